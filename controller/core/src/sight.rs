//! What the scan shows: carried to now, with the unknown made into something to decide on, and peers told from walls.
//!
//! Laws get the scan without peers' bodies (invariant 6); the supervisor gets everything.

use crate::estimate::Motion;
use crate::peers::Body;
use drover_contract::math::{quick_angle, sin_cos};
use drover_contract::{Beam, Pose, Scan, Stamp, Vec2, wrap};
use nalgebra::{Isometry2, Point2};
use std::f64::consts::{FRAC_PI_2, TAU};
use std::ops::Range;

/// A hit is a peer's if it lies this close to where its disc should be, metres, beside what the bounds allow.
const MATCH_SLACK_M: f64 = 0.15;
/// Bounds beyond this are not believed when hits are matched, metres: a lost robot must not swallow every wall.
const MATCH_BOUND_M_MAX: f64 = 0.4;
/// That many unknown beams side by side are a blind spot; fewer take the nearer of their two neighbours.
const BLIND_RUN: usize = 3;
/// So many beams have to pass where a body would be before it is not there.
const THROUGH_BEAMS: f64 = 3.0;
/// No beam, and all of them.
const NONE: Range<f64> = -1.0..-1.0;
const ALL: [Range<f64>; 2] = [0.0..f64::INFINITY, NONE];
/// Beams that are looked at to either side of where a body can be: rounding must not cost a match.
const MATCH_BEAMS: f64 = 0.01;

/// What is around the body now, in the body frame of now. Its lists are kept from tick to tick.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Surroundings {
    /// Every hit, walls and peers alike, and what stands for dropped-out beams.
    pub(crate) points_b: Vec<Vec2>,
    /// Directions of blind spots, unit vectors.
    pub(crate) blind_b: Vec<Vec2>,
    /// Of each beam the index of its first point, and of the first beyond the last: a beam has one point or none.
    starts: Vec<u32>,
    /// The sensor of the scan, in the body frame of now.
    sensor_b: Isometry2<f64>,
    rays: Rays,
    /// Farther than this the scan shows nothing, metres.
    range_m_max: f64,
    /// The nearest hit, metres from the sensor.
    pub(crate) nearest_m: Option<f64>,
    /// Share of the scan's beams without a reading, 0..=1.
    pub(crate) unknown_share: f64,
}

/// Directions of a scan's beams, sensor frame: scans of one sensor are alike, and sines are dear.
#[derive(Clone, Debug, Default, PartialEq)]
struct Rays {
    first_rad: f64,
    step_rad: f64,
    /// Beams a radian, and beams of a full turn.
    per_rad: f64,
    turn_beams: f64,
    units: Vec<Vec2>,
}

impl Rays {
    fn fit(&mut self, scan: &Scan, count: usize) {
        let (first_rad, step_rad) = (scan.angle_first_rad, scan.angle_step_rad);
        let same = self.units.len() == count
            && self.first_rad.to_bits() == first_rad.to_bits()
            && self.step_rad.to_bits() == step_rad.to_bits();
        if !same {
            let unit = |index: usize| {
                let (sin, cos) = sin_cos(scan.angle_rad(index));
                Vec2::new(cos, sin)
            };
            let units = (0..count).map(unit).collect();
            *self = Self { first_rad, step_rad, per_rad: 1.0 / step_rad, turn_beams: TAU / step_rad.abs(), units };
        }
    }

    /// The beams that may point into the angles `middle_rad +- half_rad`, in up to two runs.
    fn within(&self, middle_rad: f64, half_rad: f64) -> [Range<f64>; 2] {
        let turn = self.turn_beams;
        let half = half_rad * self.per_rad.abs() + MATCH_BEAMS;
        if 2.0 * half >= turn || self.units.len() as f64 > turn + 1.0 {
            return ALL;
        }
        let middle = wrap(middle_rad - self.first_rad) * self.per_rad;
        let middle = if middle < 0.0 { middle + turn } else { middle };
        // What reaches beyond an end of the turn goes on at its other end.
        let (from, to) = (middle - half, middle + half);
        let beyond = if from < 0.0 {
            from + turn..turn
        } else if to >= turn {
            0.0..to - turn
        } else {
            NONE
        };
        [from..to, beyond]
    }
}

impl Surroundings {
    /// The raw scan as the supervisor sees it: taken by a sensor at `mount` (body frame).
    pub(crate) fn look(&mut self, scan: &Scan, mount: &Isometry2<f64>, motion: &Motion, now: Stamp) {
        let then = then_in_now(motion, scan.stamp, now).isometry();
        let count = full_turn(scan);
        self.rays.fit(scan, count);
        self.sensor_b = then * mount;
        self.range_m_max = scan.range_m_max;
        self.clear();
        let (mut nearest_m, mut unknown) = (f64::INFINITY, 0);
        for index in 0..count {
            self.starts.push(self.points_b.len() as u32);
            match beam(scan, index) {
                Beam::Hit(range_m) => {
                    nearest_m = nearest_m.min(range_m);
                    self.put(index, range_m);
                }
                Beam::Clear => {}
                Beam::Unknown => {
                    unknown += usize::from(index < scan.beams.len());
                    self.put_unknown(scan, index, count);
                }
            }
        }
        self.nearest_m = nearest_m.is_finite().then_some(nearest_m);
        self.unknown_share = if scan.beams.is_empty() { 1.0 } else { unknown as f64 / scan.beams.len() as f64 };
        self.starts.push(self.points_b.len() as u32);
    }

    /// Where the sensor of the scan is in the body frame of now.
    pub(crate) const fn sensor_b(&self) -> &Isometry2<f64> {
        &self.sensor_b
    }

    /// Nothing is seen.
    pub(crate) fn clear(&mut self) {
        self.points_b.clear();
        self.blind_b.clear();
        self.starts.clear();
        self.nearest_m = None;
        self.unknown_share = 1.0;
    }

    /// A blind spot, or a dropped-out beam that its neighbours stand in for.
    fn put_unknown(&mut self, scan: &Scan, beam: usize, count: usize) {
        if unknown_run(scan, beam, count) >= BLIND_RUN {
            self.blind_b.push(self.sensor_b.rotation * self.rays.units[beam]);
        } else if let Some(range_m) = stand_in(scan, beam, count) {
            self.put(beam, range_m);
        }
    }

    fn put(&mut self, beam: usize, range_m: f64) {
        let point_b = self.sensor_b * Point2::from(self.rays.units[beam] * range_m);
        self.points_b.push(point_b.coords);
    }

    /// Whether beams enough pass where a disc would be: known ones, that show something behind it or nothing.
    fn looks_through(&self, centre_b: Vec2, radius_m: f64) -> bool {
        let centre_s = self.sensor_b.inverse_transform_point(&Point2::from(centre_b)).coords;
        let apart_m = centre_s.norm();
        if apart_m <= radius_m {
            return self.blind_b.is_empty(); // we are there ourselves
        }
        if apart_m + radius_m > self.range_m_max {
            return false;
        }
        let half_rad = half_angle_rad(radius_m / apart_m);
        let beams = 2.0 * half_rad * self.rays.per_rad.abs();
        let to_centre_b = (centre_b - self.sensor_b.translation.vector) / apart_m;
        let blind = self.blind_b.iter().any(|ray_b| ray_b.dot(&to_centre_b) > 1.0 - half_rad * half_rad / 2.0);
        let runs = self.rays.within(f64::from(quick_angle(centre_s.y as f32, centre_s.x as f32)), half_rad);
        let is_behind =
            |index: usize| (self.points_b[index] - self.sensor_b.translation.vector).norm() > apart_m + radius_m;
        beams >= THROUGH_BEAMS && !blind && runs.iter().flat_map(|run| self.points_on(run)).all(is_behind)
    }

    /// The points (by index) on the beams of a run.
    fn points_on(&self, beams: &Range<f64>) -> Range<usize> {
        let Some(last) = self.starts.len().checked_sub(1) else { return 0..0 };
        if beams.end < 0.0 || beams.start >= last as f64 {
            return 0..0;
        }
        // A cast saturates and cuts: it may look at the beam before the first, and that costs nothing.
        let (from, to) = (beams.start as usize, (beams.end as usize).saturating_add(1));
        self.starts[from] as usize..self.starts[to.min(last)] as usize
    }
}

/// How the body moved since `stamp`: the body of then in the body frame of now, by the measured velocity.
fn then_in_now(motion: &Motion, stamp: Stamp, now: Stamp) -> Pose {
    let back_s = now.since(stamp).as_secs_f64().min(0.5);
    Pose::default().advance(motion.twist_b, -back_s)
}

/// Beams of a full turn; those that the scan does not have are unknown.
fn full_turn(scan: &Scan) -> usize {
    let turn = (TAU / scan.angle_step_rad.abs()).round();
    // A codec never makes a scan of more than some thousands of beams; the bound keeps a strange one from costing time.
    scan.beams.len().max(turn.min(10_000.0) as usize)
}

fn beam(scan: &Scan, index: usize) -> Beam {
    scan.beams.get(index).copied().unwrap_or(Beam::Unknown)
}

/// How many unknown beams stand side by side around `index`, counted no further than `BLIND_RUN` each way.
fn unknown_run(scan: &Scan, index: usize, count: usize) -> usize {
    let run =
        |step: usize| (1..=BLIND_RUN).take_while(|k| beam(scan, (index + k * step) % count) == Beam::Unknown).count();
    1 + run(1) + run(count - 1)
}

/// What a dropped-out beam is taken for: the nearer of the readings beside it.
fn stand_in(scan: &Scan, index: usize, count: usize) -> Option<f64> {
    let neighbour = |step: usize| {
        let known = |k: &usize| beam(scan, (index + k * step) % count) != Beam::Unknown;
        let k = (1..=BLIND_RUN).find(known)?;
        match beam(scan, (index + k * step) % count) {
            Beam::Hit(range_m) => Some(range_m),
            Beam::Clear | Beam::Unknown => None,
        }
    };
    match (neighbour(1), neighbour(count - 1)) {
        (Some(left), Some(right)) => Some(left.min(right)),
        (one, other) => one.or(other),
    }
}

/// Which hits are peers' bodies. Its lists are kept from tick to tick.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Matches {
    /// Of each point whether it may be on a body that is heard.
    on_body: Vec<bool>,
    /// Of each body where it is.
    pub(crate) bodies: Vec<Sighting>,
}

/// Where a peer's body is, body frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Sighting {
    /// Its middle, as it told.
    pub(crate) centre_b: Vec2,
    /// The nearest hit that may be on it.
    pub(crate) hit_b: Option<Vec2>,
    /// It stands, but not there: the scan looks through that place.
    pub(crate) gone: bool,
}

impl Matches {
    /// Match every hit with every body that it may be on, given how well both robots know where they are.
    pub(crate) fn find(&mut self, seen: &Surroundings, motion: &Motion, bodies: &[Body]) {
        self.on_body.clear();
        self.on_body.resize(seen.points_b.len(), false);
        self.bodies.clear();
        let world_b = motion.pose_wb.isometry().inverse();
        for body in bodies {
            let centre_b = (world_b * Point2::from(body.pos_w)).coords;
            let hit_b = self.take(seen, (centre_b, match_radius_m(body, motion.pos_bound_m)), body.heard);
            let gone = body.stands && hit_b.is_none() && seen.looks_through(centre_b, body.radius_m);
            self.bodies.push(Sighting { centre_b, hit_b, gone });
        }
    }

    /// All points within `within_m` of a centre: the one nearest to us; marked if that body is heard. Only beams that
    /// point there are looked at.
    fn take(&mut self, seen: &Surroundings, (centre_b, within_m): (Vec2, f64), heard: bool) -> Option<Vec2> {
        let centre_s = seen.sensor_b.inverse_transform_point(&Point2::from(centre_b)).coords;
        let apart_m = centre_s.norm();
        if apart_m - within_m > seen.range_m_max {
            return None;
        }
        let runs = if apart_m > within_m {
            let middle_rad = f64::from(quick_angle(centre_s.y as f32, centre_s.x as f32));
            seen.rays.within(middle_rad, half_angle_rad(within_m / apart_m))
        } else {
            ALL
        };
        let mut nearest_b: Option<Vec2> = None;
        for index in runs.iter().flat_map(|run| seen.points_on(run)) {
            let point_b = seen.points_b[index];
            if (point_b - centre_b).norm_squared() <= within_m * within_m {
                self.on_body[index] |= heard;
                let nearer = nearest_b.is_none_or(|nearest_b| point_b.norm_squared() < nearest_b.norm_squared());
                nearest_b = if nearer { Some(point_b) } else { nearest_b };
            }
        }
        nearest_b
    }

    /// The hits that are no heard peers', in the body frame of now: what laws take for walls. Who is not heard any more
    /// tells nobody that it makes way, and stands there like a wall.
    pub(crate) fn walls<'a>(&'a self, seen: &'a Surroundings) -> impl Iterator<Item = Vec2> + 'a {
        let hits = seen.points_b.iter().zip(&self.on_body);
        hits.filter(|(_, on_body)| !**on_body).map(|(point_b, _)| *point_b)
    }
}

/// A hit this near to where a body's middle should be may be on it, metres, given how well we know our own place.
pub(crate) fn match_radius_m(body: &Body, own_bound_m: f64) -> f64 {
    body.radius_m + (MATCH_SLACK_M + (body.bound_m + own_bound_m).min(MATCH_BOUND_M_MAX))
}

/// Never below the arc sine of `ratio` (0..=1), and above it by little: a few beams more to look at cost less than it.
fn half_angle_rad(ratio: f64) -> f64 {
    ratio + (FRAC_PI_2 - 1.0) * ratio * ratio * ratio
}

#[cfg(test)]
mod tests {
    use super::*;
    use drover_contract::{Pose, Twist};
    use proptest::prelude::*;

    /// A scan of 72 beams, clear but for hits: (beam, range).
    fn scan(hits: &[(usize, f64)]) -> Scan {
        let mut beams = vec![Beam::Clear; 72];
        hits.iter().for_each(|(beam, range_m)| beams[*beam] = Beam::Hit(*range_m));
        let step = TAU / 72.0;
        Scan {
            stamp: Stamp::ZERO,
            angle_first_rad: 0.0,
            angle_step_rad: step,
            range_m_min: 0.1,
            range_m_max: 8.0,
            beams,
        }
    }

    fn standing(pose_wb: Pose) -> Motion {
        Motion { pose_wb, twist_b: Twist::ZERO, accel_mps2: 0.0, pos_bound_m: 0.05 }
    }

    fn nearest_wall(hits: &[(usize, f64)], motion: &Motion, bodies: &[Body]) -> Option<Vec2> {
        let mut seen = Surroundings::default();
        seen.look(&scan(hits), &Isometry2::identity(), motion, Stamp::ZERO);
        let mut matches = Matches::default();
        matches.find(&seen, motion, bodies);
        matches.walls(&seen).min_by(|a, b| a.norm().total_cmp(&b.norm()))
    }

    #[test]
    fn a_peers_body_is_no_wall_and_what_stands_behind_it_is() {
        let motion = standing(Pose::new(10.0, 5.0, std::f64::consts::FRAC_PI_2));
        // Ahead of the body is north: a peer 2 m ahead, whose near side is seen, and a wall 4 m to the left.
        let hits = [(0, 1.6), (18, 4.0)];
        let at =
            |place: Option<Vec2>, x: f64, y: f64| place.is_some_and(|place| (place - Vec2::new(x, y)).norm() < 1e-9);
        let peer = Body { pos_w: Vec2::new(10.0, 7.0), radius_m: 0.4, bound_m: 0.05, heard: true, stands: false };
        assert!(at(nearest_wall(&hits, &motion, &[peer]), 0.0, 4.0));
        assert!(at(nearest_wall(&hits, &motion, &[]), 1.6, 0.0));
        let elsewhere = Body { pos_w: Vec2::new(10.0, 9.0), ..peer };
        assert!(at(nearest_wall(&hits, &motion, &[elsewhere]), 1.6, 0.0));
    }

    #[test]
    fn a_sensor_that_is_mounted_elsewhere_sees_from_there() {
        let mut seen = Surroundings::default();
        let mount = Pose::new(0.2, -0.1, std::f64::consts::PI);
        seen.look(&scan(&[(0, 2.0)]), &mount.isometry(), &standing(Pose::default()), Stamp::ZERO);
        assert!((seen.points_b[0] - Vec2::new(-1.8, -0.1)).norm() < 1e-9);
    }

    #[test]
    fn the_half_angle_is_never_too_small() {
        for step in 0..=1_000 {
            let ratio = f64::from(step) / 1_000.0;
            let over = half_angle_rad(ratio) - libm::asin(ratio);
            assert!((0.0..0.2).contains(&(over + 1e-15)), "{ratio}: {over}");
        }
    }

    proptest! {
        #[test]
        fn looking_only_where_a_body_is_finds_every_hit_on_it(
            ranges in prop::collection::vec(0.2..8.0f64, 72), turned in any::<bool>(), first_rad in -9.0..9.0f64,
            (x, y, radius_m) in (-6.0..6.0f64, -6.0..6.0f64, 0.05..2.0f64), mount_yaw in -3.0..3.0f64,
        ) {
            let hits: Vec<(usize, f64)> = ranges.into_iter().enumerate().collect();
            let mut scan = scan(&hits);
            scan.angle_first_rad = first_rad;
            scan.angle_step_rad *= if turned { -1.0 } else { 1.0 };
            let motion = standing(Pose::new(0.3, 0.4, 0.5));
            let mut seen = Surroundings::default();
            seen.look(&scan, &Pose::new(0.1, 0.2, mount_yaw).isometry(), &motion, Stamp::ZERO);
            let body = Body { pos_w: Vec2::new(x, y), radius_m, bound_m: 0.05, heard: true, stands: false };
            let mut matches = Matches::default();
            matches.find(&seen, &motion, &[body]);
            let near = |point_b: &Vec2| {
                (motion.pose_wb.transform(*point_b) - body.pos_w).norm() <= radius_m + MATCH_SLACK_M + 0.1
            };
            let expected: Vec<bool> = seen.points_b.iter().map(near).collect();
            prop_assert_eq!(matches.on_body, expected);
        }
    }

    #[test]
    fn a_silent_peer_is_gone_where_beams_pass_its_place_and_only_there() {
        let mut seen = Surroundings::default();
        let mount = Isometry2::identity();
        let motion = standing(Pose::default());
        let mut gone = |hits: &[(usize, f64)], unknown: &[usize], at_w: Vec2, stands: bool| {
            let mut scan = scan(hits);
            unknown.iter().for_each(|beam| scan.beams[*beam] = Beam::Unknown);
            seen.look(&scan, &mount, &motion, Stamp::ZERO);
            let mut matches = Matches::default();
            let body = Body { pos_w: at_w, radius_m: 0.4, bound_m: 0.05, heard: false, stands };
            matches.find(&seen, &motion, &[body]);
            matches.bodies[0].gone
        };
        let there = Vec2::new(2.0, 0.0);
        assert!(gone(&[], &[], there, true), "nothing is in its direction");
        assert!(gone(&[(0, 5.0), (1, 5.0)], &[], there, true), "a wall behind it");
        assert!(!gone(&[(0, 1.6)], &[], there, true), "it is seen");
        assert!(!gone(&[(0, 0.8)], &[], there, true), "something stands in front of it");
        assert!(!gone(&[], &[71, 0, 1], there, true), "a blind spot");
        assert!(!gone(&[], &[], Vec2::new(7.8, 0.0), true), "out of range");
        assert!(!gone(&[], &[], Vec2::new(6.0, 0.0), true), "too few beams pass there");
        assert!(!gone(&[], &[], there, false), "it may be on its way");
        assert!(gone(&[], &[], Vec2::new(0.2, 0.1), true), "we are there ourselves");
    }

    #[test]
    fn who_is_not_heard_is_a_wall_to_laws() {
        let mut seen = Surroundings::default();
        let motion = standing(Pose::default());
        seen.look(&scan(&[(0, 1.6)]), &Isometry2::identity(), &motion, Stamp::ZERO);
        let walls = |heard: bool| {
            let mut matches = Matches::default();
            let body = Body { pos_w: Vec2::new(2.0, 0.0), radius_m: 0.4, bound_m: 0.05, heard, stands: false };
            matches.find(&seen, &motion, &[body]);
            assert!(matches.bodies[0].hit_b.is_some(), "the supervisor knows whose hit it is");
            matches.walls(&seen).count()
        };
        assert_eq!((walls(true), walls(false)), (0, 1));
    }
}
