//! What the scan shows: carried to now, with the unknown made into something to decide on, and peers told from walls.
//!
//! Laws get the scan without peers' bodies (invariant 6); the supervisor gets everything.

use crate::estimate::Motion;
use crate::peers::Body;
use drover_contract::{Beam, Pose, Scan, Stamp, Vec2};
use std::f64::consts::TAU;

/// A hit is a peer's if it lies this close to where its disc should be, metres, beside what the bounds allow.
const MATCH_SLACK_M: f64 = 0.15;
/// Bounds beyond this are not believed when hits are matched, metres: a lost robot must not swallow every wall.
const MATCH_BOUND_M_MAX: f64 = 0.4;
/// That many unknown beams side by side are a blind spot; fewer take the nearer of their two neighbours.
const BLIND_RUN: usize = 3;

/// What is around the body now, in the body frame of now.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Surroundings {
    /// Every hit, walls and peers alike, and what stands for dropped-out beams.
    pub(crate) points_b: Vec<Vec2>,
    /// Directions of blind spots, unit vectors.
    pub(crate) blind_b: Vec<Vec2>,
}

/// How the body moved since `stamp`: the body of then in the body frame of now, by the measured velocity.
fn then_in_now(motion: &Motion, stamp: Stamp, now: Stamp) -> Pose {
    let back_s = now.since(stamp).as_secs_f64().min(0.5);
    Pose::default().advance(motion.twist_b, -back_s)
}

/// The raw scan as the supervisor sees it.
pub(crate) fn surroundings(scan: &Scan, motion: &Motion, now: Stamp) -> Surroundings {
    let then = then_in_now(motion, scan.stamp, now);
    let mut seen = Surroundings::default();
    let count = full_turn(scan);
    for index in 0..count {
        let (sin, cos) = scan.angle_rad(index).sin_cos();
        let ray = Vec2::new(cos, sin);
        match beam(scan, index) {
            Beam::Hit(range_m) => seen.points_b.push(then.transform(ray * range_m)),
            Beam::Clear => {}
            Beam::Unknown if unknown_run(scan, index, count) >= BLIND_RUN => seen.blind_b.push(then.rotate(ray)),
            Beam::Unknown => seen.points_b.extend(stand_in(scan, index, count).map(|r| then.transform(ray * r))),
        }
    }
    seen
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

/// Whether a point of the world may be on `body`, given how well both robots know where they are.
pub(crate) fn on_body(pos_w: Vec2, body: &Body, own_bound_m: f64) -> bool {
    let slack_m = MATCH_SLACK_M + (body.bound_m + own_bound_m).min(MATCH_BOUND_M_MAX);
    (pos_w - body.pos_w).norm() <= body.radius_m + slack_m
}

/// The nearest hit that is not a peer's, in the body frame of now: what laws take for walls.
pub(crate) fn nearest_wall(seen: &Surroundings, motion: &Motion, bodies: &[Body], from_b: Vec2) -> Option<Vec2> {
    let is_wall = |point: &&Vec2| {
        let pos_w = motion.pose_wb.transform(**point);
        !bodies.iter().any(|body| on_body(pos_w, body, motion.pos_bound_m))
    };
    let walls = seen.points_b.iter().filter(is_wall);
    walls.min_by(|a, b| (**a - from_b).norm_squared().total_cmp(&(**b - from_b).norm_squared())).copied()
}

#[cfg(test)]
mod tests {
    use super::*;
    use drover_contract::{Pose, Twist};

    #[test]
    fn a_peers_body_is_no_wall_and_what_stands_behind_it_is() {
        let pose_wb = Pose::new(10.0, 5.0, std::f64::consts::FRAC_PI_2);
        let motion = Motion { pose_wb, twist_b: Twist::ZERO, accel_mps2: 0.0, pos_bound_m: 0.05 };
        // Ahead of the body is north: a peer 2 m ahead, whose near side is seen, and a wall 4 m to the left.
        let (peer_side_b, wall_b) = (Vec2::new(1.6, 0.0), Vec2::new(0.0, 4.0));
        let seen = Surroundings { points_b: vec![peer_side_b, wall_b], ..Surroundings::default() };
        let peer = Body { pos_w: Vec2::new(10.0, 7.0), radius_m: 0.4, bound_m: 0.05 };
        assert_eq!(nearest_wall(&seen, &motion, &[peer], Vec2::zeros()), Some(wall_b));
        assert_eq!(nearest_wall(&seen, &motion, &[], Vec2::zeros()), Some(peer_side_b));
        let elsewhere = Body { pos_w: Vec2::new(10.0, 9.0), ..peer };
        assert_eq!(nearest_wall(&seen, &motion, &[elsewhere], Vec2::zeros()), Some(peer_side_b));
    }
}
