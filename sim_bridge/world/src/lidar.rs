//! The lidar: a one-dimensional depth buffer.
//!
//! All beams of a scan share one origin, so the work is done per thing in range and not per ray: a wall or a disc
//! becomes an interval of beams (two angles), and each beam u of the interval keeps the nearest range that it was
//! offered, in closed form: r = c / (n . u) for a wall at distance c with unit normal n, and
//! r = u . p - sqrt(radius^2 - (u x p)^2) for a disc at p. The same idea as a z-buffer, with one row.
//!
//! Conditions: the origin lies in free space, and outlines are closed, since walls that face away are skipped (what
//! lies behind a face is hidden by that face). Both hold for a body that started in free space.
//!
//! Beam 0 looks straight ahead (angle 0 in the body frame), and beams go counter-clockwise.

use crate::chance::{Use, generator, normal};
use crate::geometry::{Disc, Segment};
use drover_config::Kind;
use drover_contract::{Beam, Pose, Scan, Stamp, Vec2};
use rand::Rng;
use rand_pcg::Pcg32;
use std::f64::consts::TAU;

/// An interval of beams is widened by this share of a beam, so that two walls that share a corner leave no hole.
const EDGE_BEAMS: f64 = 1e-9;
/// A wall seen this edge-on has no face, metres (distance of its line from the origin).
const EDGE_ON_M: f64 = 1e-12;

/// What a lidar can do.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LidarParams {
    /// Beams of a full turn, at least one.
    pub beams: u32,
    /// Nearer than this there is no reading, metres.
    pub range_m_min: f64,
    /// Farther than this everything is clear, metres.
    pub range_m_max: f64,
    /// Standard deviation of a range, metres.
    pub range_noise_m: f64,
    /// Share of beams without a reading, 0..=1.
    pub beam_dropout: f64,
}

impl LidarParams {
    /// The lidar of a robot kind.
    #[must_use]
    pub fn of(kind: &Kind) -> Self {
        Self {
            beams: kind.lidar.beams,
            range_m_min: kind.lidar.range_m_min,
            range_m_max: kind.lidar.range_m_max,
            range_noise_m: kind.sim.range_noise_m,
            beam_dropout: kind.sim.beam_dropout,
        }
    }
}

/// One robot's lidar. Its buffers are kept from scan to scan.
#[derive(Clone, Debug)]
pub struct Lidar {
    params: LidarParams,
    step_rad: f64,
    directions_b: Vec<Vec2>,
    depth: DepthBuffer,
    rng: Pcg32,
}

/// The nearest range that each beam was offered, metres.
#[derive(Clone, Debug, Default)]
struct DepthBuffer {
    range_m: Vec<f64>,
}

impl Lidar {
    /// A lidar; `seed` and `key` (the robot's id) make its noise.
    #[must_use]
    pub fn new(params: LidarParams, seed: u64, key: u64) -> Self {
        let beams = params.beams.max(1);
        let step_rad = TAU / f64::from(beams);
        let direction = |index: u32| {
            let (sin, cos) = (step_rad * f64::from(index)).sin_cos();
            Vec2::new(cos, sin)
        };
        Self {
            params,
            step_rad,
            directions_b: (0..beams).map(direction).collect(),
            depth: DepthBuffer { range_m: vec![f64::INFINITY; beams as usize] },
            rng: generator(seed, key, Use::Lidar),
        }
    }

    /// What it can do.
    #[must_use]
    pub fn params(&self) -> &LidarParams {
        &self.params
    }

    /// A scan from `pose_wb` of walls and discs (round obstacles and other bodies), with noise and dropout.
    pub fn scan<'a>(
        &mut self,
        now: Stamp,
        pose_wb: Pose,
        segments: &[Segment],
        discs: impl Iterator<Item = &'a Disc>,
    ) -> Scan {
        self.fill(pose_wb, segments, discs);
        let beams = (0..self.directions_b.len()).map(|index| self.reading(index)).collect();
        Scan {
            stamp: now,
            angle_first_rad: 0.0,
            angle_step_rad: self.step_rad,
            range_m_min: self.params.range_m_min,
            range_m_max: self.params.range_m_max,
            beams,
        }
    }

    /// True ranges of all beams, metres; infinite where there is nothing.
    fn fill<'a>(&mut self, pose_wb: Pose, segments: &[Segment], discs: impl Iterator<Item = &'a Disc>) {
        self.depth.range_m.fill(f64::INFINITY);
        let heading = pose_wb.heading();
        let origin_w = pose_wb.position();
        let to_body = |point_w: Vec2| {
            let d = point_w - origin_w;
            Vec2::new(heading.x * d.x + heading.y * d.y, heading.x * d.y - heading.y * d.x)
        };
        for segment in segments {
            self.draw_segment(to_body(segment.from_w), to_body(segment.to_w));
        }
        for disc in discs {
            self.draw_disc(to_body(disc.centre_w), disc.radius_m);
        }
    }

    fn draw_segment(&mut self, from_b: Vec2, to_b: Vec2) {
        let along = to_b - from_b;
        // The signed distance of the wall's line; a face looks at us when it runs counter-clockwise around us.
        let facing = from_b.perp(&to_b);
        let length_m = along.norm();
        if facing <= EDGE_ON_M * length_m || facing > self.params.range_m_max * length_m {
            return;
        }
        let distance_m = facing / length_m;
        let normal_b = Vec2::new(along.y, -along.x) / length_m;
        // A beam that grazes the very end of a wall must not be thrown beyond that end by rounding.
        let farthest_m = from_b.norm().max(to_b.norm());
        let first_rad = from_b.y.atan2(from_b.x);
        let span_rad = facing.atan2(from_b.dot(&to_b));
        self.offer(first_rad, span_rad, |direction_b| {
            let approach = normal_b.dot(direction_b);
            if approach > 0.0 { (distance_m / approach).min(farthest_m) } else { f64::INFINITY }
        });
    }

    fn draw_disc(&mut self, centre_b: Vec2, radius_m: f64) {
        let distance_m = centre_b.norm();
        if distance_m <= radius_m || distance_m - radius_m > self.params.range_m_max {
            return;
        }
        let half_rad = (radius_m / distance_m).asin();
        let first_rad = centre_b.y.atan2(centre_b.x) - half_rad;
        self.offer(first_rad, 2.0 * half_rad, |direction_b| {
            let aside_m = direction_b.perp(&centre_b);
            let depth_m = (radius_m * radius_m - aside_m * aside_m).max(0.0).sqrt();
            direction_b.dot(&centre_b) - depth_m
        });
    }

    /// Offer a range to every beam from `first_rad` on, `span_rad` wide (less than a full turn).
    fn offer(&mut self, first_rad: f64, span_rad: f64, range_m: impl Fn(&Vec2) -> f64) {
        let beams = self.directions_b.len();
        let first = (first_rad / self.step_rad - EDGE_BEAMS).ceil();
        let last = ((first_rad + span_rad) / self.step_rad + EDGE_BEAMS).floor();
        let count = (last - first + 1.0).clamp(0.0, beams as f64) as usize;
        let start = (first as i64).rem_euclid(beams as i64) as usize;
        let until_wrap = count.min(beams - start);
        self.offer_run(start, until_wrap, &range_m);
        self.offer_run(0, count - until_wrap, &range_m);
    }

    fn offer_run(&mut self, start: usize, count: usize, range_m: impl Fn(&Vec2) -> f64) {
        let nearest = &mut self.depth.range_m[start..start + count];
        for (nearest_m, direction_b) in nearest.iter_mut().zip(&self.directions_b[start..start + count]) {
            *nearest_m = nearest_m.min(range_m(direction_b));
        }
    }

    /// What the sensor makes of a beam's true range.
    fn reading(&mut self, index: usize) -> Beam {
        let LidarParams { range_m_min, range_m_max, range_noise_m, beam_dropout, .. } = self.params;
        if beam_dropout > 0.0 && self.rng.random::<f64>() < beam_dropout {
            return Beam::Unknown;
        }
        let range_m = self.depth.range_m[index];
        if range_m > range_m_max {
            return Beam::Clear;
        }
        if range_m < range_m_min {
            return Beam::Unknown;
        }
        let noise_m = if range_noise_m > 0.0 { range_noise_m * normal(&mut self.rng) } else { 0.0 };
        Beam::Hit((range_m + noise_m).clamp(range_m_min, range_m_max))
    }
}

#[cfg(test)]
#[path = "lidar_tests.rs"]
mod tests;
