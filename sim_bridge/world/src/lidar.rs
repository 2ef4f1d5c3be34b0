//! The lidar: where it sits, what it sees of walls and of other bodies, and what its sensor makes of that.
//!
//! Casting is a depth buffer's work ([`crate::depth`]). Ranges are then those of a real sensor: noise, steps, beams
//! without a reading. Noise is a function of the robot, the scan and the beam, so no scan depends on another.
//!
//! Beam 0 of a full turn looks straight ahead of the sensor (angle 0 in the sensor's frame), and beams go
//! counter-clockwise. A field of view of less than a turn is centred on straight ahead, its first and last beam on its
//! edges. A scan's angles and points are in the sensor's frame; `lidar.mount` says where that is.

use crate::chance::{Draws, Use};
use crate::depth::DepthBuffer;
use crate::geometry::Disc;
use crate::lanes::{LANES, Lanes};
use crate::sight::Sight;
use drover_config::{Kind, Mount};
use drover_contract::{Beam, Pose, Scan, Stamp, Vec2};
use std::f64::consts::TAU;

/// A field of view this close to a turn is one, radians.
const TURN_SLACK_RAD: f64 = 1e-6;
/// A sweep is cast from that many places along the way at most.
const SWEEP_PARTS: usize = 16;

/// What a lidar can do.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LidarParams {
    /// Beams of its field of view, at least one.
    pub beams: u32,
    /// Field of view, radians, up to a full turn, about straight ahead.
    pub fov_rad: f64,
    /// Where the sensor sits on the body.
    pub mount: Mount,
    /// Nearer than this there is no reading, metres.
    pub range_m_min: f64,
    /// Farther than this everything is clear, metres.
    pub range_m_max: f64,
    /// Standard deviation of a range, metres.
    pub range_noise_m: f64,
    /// Ranges come in steps of this, metres; 0: none.
    pub range_step_m: f64,
    /// Share of beams without a reading, 0..=1.
    pub beam_dropout: f64,
    /// Whether a scan is taken while the body moves, beam after beam from one scan to the next.
    pub sweep: bool,
}

impl LidarParams {
    /// The lidar of a robot kind.
    #[must_use]
    pub fn of(kind: &Kind) -> Self {
        Self {
            beams: kind.lidar.beams,
            fov_rad: kind.lidar.fov_rad,
            mount: kind.lidar.mount,
            range_m_min: kind.lidar.range_m_min,
            range_m_max: kind.lidar.range_m_max,
            range_noise_m: kind.sim.range_noise_m,
            range_step_m: kind.sim.range_step_m,
            beam_dropout: kind.sim.beam_dropout,
            sweep: kind.sim.scan_sweep,
        }
    }

    /// Direction of the first beam and the angle from one to the next, radians, sensor frame.
    #[must_use]
    pub fn angles_rad(&self) -> (f64, f64) {
        let beams = f64::from(self.beams.max(1));
        if self.fov_rad > TAU - TURN_SLACK_RAD {
            (0.0, TAU / beams)
        } else if self.beams > 1 {
            (-self.fov_rad / 2.0, self.fov_rad / (beams - 1.0))
        } else {
            (0.0, self.fov_rad)
        }
    }

    /// What the sensor makes of the true range of beam `nth`.
    fn reading(&self, draws: Draws, nth: u64, range_m: f64) -> Beam {
        let LidarParams { range_m_min, range_m_max, range_noise_m, beam_dropout, range_step_m, .. } = *self;
        if beam_dropout > 0.0 && draws.uniform(!nth) < beam_dropout {
            return Beam::Unknown;
        }
        if range_m > range_m_max {
            return Beam::Clear;
        }
        if range_m < range_m_min {
            return Beam::Unknown;
        }
        let noise_m = if range_noise_m > 0.0 { range_noise_m * draws.roughly_normal(nth) } else { 0.0 };
        let measured_m = range_m + noise_m;
        let to_step_m = |range_m: f64| (range_m / range_step_m).round() * range_step_m;
        let stepped_m = if range_step_m > 0.0 { to_step_m(measured_m) } else { measured_m };
        Beam::Hit(stepped_m.clamp(range_m_min, range_m_max))
    }
}

/// What is around: walls, and what moves.
pub trait Scenery {
    /// The walls.
    fn sight(&self) -> &Sight;
    /// Call with every mover, and every body other than the one that looks, that may be within `range_m` of a place.
    fn bodies_near(&self, from_w: Vec2, range_m: f64, see: &mut dyn FnMut(Silhouette<'_>));
}

/// What a lidar sees of a body.
#[derive(Clone, Copy, Debug)]
pub enum Silhouette<'a> {
    /// A disc.
    Disc(Disc),
    /// A convex outline: its corners, counter-clockwise, body frame, and where the body is.
    Outline(&'a [Vec2], Pose),
}

/// One robot's lidar. Its buffers are kept from scan to scan.
#[derive(Clone, Debug)]
pub struct Lidar {
    params: LidarParams,
    mount: Pose,
    depth: DepthBuffer,
    draws: Draws,
    scans: u64,
    /// Where the body was since the last scan, for a sweep.
    way_wb: Vec<Pose>,
}

impl Lidar {
    /// A lidar; `seed` and `key` (the robot's id) make its noise.
    #[must_use]
    pub fn new(params: LidarParams, seed: u64, key: u64) -> Self {
        let (first_rad, step_rad) = params.angles_rad();
        Self {
            mount: Pose::new(params.mount.x_m, params.mount.y_m, params.mount.yaw_rad),
            depth: DepthBuffer::new(params.beams.max(1) as usize, first_rad, step_rad, params.range_m_max),
            draws: Draws::new(seed, Use::Lidar).of(key),
            scans: 0,
            way_wb: Vec::new(),
            params,
        }
    }

    /// What it can do.
    #[must_use]
    pub fn params(&self) -> &LidarParams {
        &self.params
    }

    /// The body has moved to `pose_wb`; only a sweeping lidar wants to know.
    pub fn note(&mut self, pose_wb: Pose) {
        if self.params.sweep {
            self.way_wb.push(pose_wb);
        }
    }

    /// A scan of a body at `pose_wb`, with noise and dropout.
    ///
    /// A sweep takes its first beam where the body was at the scan before and its last where it is now; other bodies
    /// are taken where they are now.
    pub fn scan(&mut self, now: Stamp, pose_wb: Pose, scenery: &impl Scenery) -> Scan {
        self.cast_all(pose_wb, scenery);
        let draws = self.draws.of(self.scans);
        self.scans += 1;
        let params = self.params;
        let ranges_m = self.depth.ranges().iter().enumerate();
        let beams = ranges_m.map(|(beam, range_m)| params.reading(draws, beam as u64, *range_m)).collect();
        let (angle_first_rad, angle_step_rad) = self.params.angles_rad();
        let LidarParams { range_m_min, range_m_max, .. } = self.params;
        Scan { stamp: now, angle_first_rad, angle_step_rad, range_m_min, range_m_max, beams }
    }

    /// True ranges of all beams from a body at `pose_wb`, metres, infinite where nothing is: no noise, no limits but
    /// that what is wholly farther than the sensor's range is not looked at.
    pub fn ranges(&mut self, pose_wb: Pose, scenery: &impl Scenery) -> impl Iterator<Item = f64> + '_ {
        self.depth.clear();
        self.cast(pose_wb, scenery);
        self.depth.ranges().iter().copied()
    }

    /// Heap bytes held.
    #[must_use]
    pub fn bytes(&self) -> usize {
        self.depth.bytes() + self.way_wb.capacity() * size_of::<Pose>()
    }

    fn cast_all(&mut self, pose_wb: Pose, scenery: &impl Scenery) {
        self.depth.clear();
        if self.way_wb.len() < 2 {
            return self.cast(pose_wb, scenery);
        }
        let way_wb = std::mem::take(&mut self.way_wb);
        let beams = self.depth.beams();
        let parts = SWEEP_PARTS.min(way_wb.len()).min(beams);
        for part in 0..parts {
            self.depth.draw_only(part * beams / parts, (part + 1) * beams / parts);
            self.cast(way_wb[(2 * part + 1) * way_wb.len() / (2 * parts)], scenery);
        }
        self.depth.draw_only(0, beams);
        self.way_wb = way_wb;
        self.way_wb.clear();
    }

    fn cast(&mut self, pose_wb: Pose, scenery: &impl Scenery) {
        let at_w = pose_wb.transform(self.mount.position());
        let pose_ws = Pose::new(at_w.x, at_w.y, pose_wb.yaw_rad + self.mount.yaw_rad);
        scenery.sight().draw(pose_ws, &mut self.depth);
        let mut bodies = Bodies::new(pose_ws);
        let depth = &mut self.depth;
        scenery.bodies_near(at_w, self.params.range_m_max, &mut |body| bodies.see(body, depth));
        bodies.finish(depth);
    }
}

/// Other bodies on their way into the buffer, in lanes.
struct Bodies {
    origin_w: Vec2,
    heading: Vec2,
    count: usize,
    px: Lanes,
    py: Lanes,
    radius: Lanes,
}

impl Bodies {
    fn new(pose_ws: Pose) -> Self {
        let empty = Lanes::default();
        let (origin_w, heading) = (pose_ws.position(), pose_ws.heading());
        Self { origin_w, heading, count: 0, px: empty, py: empty, radius: empty }
    }

    fn to_sensor(&self, place_w: Vec2) -> [f32; 2] {
        let (d, h) = (place_w - self.origin_w, self.heading);
        [(h.x * d.x + h.y * d.y) as f32, (h.x * d.y - h.y * d.x) as f32]
    }

    fn see(&mut self, body: Silhouette<'_>, depth: &mut DepthBuffer) {
        match body {
            Silhouette::Disc(disc) => {
                [self.px.each_mut()[self.count], self.py.each_mut()[self.count]] = self.to_sensor(disc.centre_w);
                self.radius.each_mut()[self.count] = disc.radius_m as f32;
                self.count += 1;
                if self.count == LANES {
                    depth.draw_discs([self.px, self.py], self.radius);
                    self.count = 0;
                }
            }
            Silhouette::Outline(corners_b, pose_wb) => self.draw_outline(corners_b, pose_wb, depth),
        }
    }

    /// An outline's free side is outside: its corners are taken clockwise.
    fn draw_outline(&self, corners_b: &[Vec2], pose_wb: Pose, depth: &mut DepthBuffer) {
        let frame = pose_wb.isometry();
        let corner = |index: usize| {
            let corner_b = corners_b[corners_b.len() - 1 - index % corners_b.len()];
            self.to_sensor((frame * nalgebra::Point2::from(corner_b)).coords)
        };
        let (mut from, count) = (corner(0), corners_b.len());
        for first in (0..count).step_by(LANES) {
            let [mut ax, mut ay, mut bx, mut by] = [Lanes::default(); 4];
            for i in 0..LANES.min(count - first) {
                let to = corner(first + i + 1);
                ([ax.each_mut()[i], ay.each_mut()[i]], [bx.each_mut()[i], by.each_mut()[i]]) = (from, to);
                from = to;
            }
            depth.draw_walls([ax, ay], [bx, by]);
        }
    }

    fn finish(mut self, depth: &mut DepthBuffer) {
        if self.count == 0 {
            return;
        }
        self.radius.each_mut()[self.count..].fill(0.0);
        depth.draw_discs([self.px, self.py], self.radius);
    }
}

#[cfg(test)]
#[path = "lidar_tests.rs"]
mod tests;
