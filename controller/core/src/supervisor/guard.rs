//! Reduces a request until the body can stop before anything. Never increases a speed or a turn.
//!
//! Candidates are shares of the request, the largest first: speed is given up before turn. The first whose course
//! ([`super::rollout`]) keeps clear is taken (the admissible velocities of D. Fox, W. Burgard, S. Thrun, "The dynamic
//! window approach to collision avoidance", IEEE Robotics & Automation Magazine 4(1), 1997, eq. 14).
//!
//! *Clear* of points: the disc keeps its margin from all. Already inside the margin, nothing in the outer half of it
//! may come nearer than what is nearest, and nothing in the inner half may come nearer at all: the robot can slide
//! along a wall and leave it, and noise cannot walk it in. *Clear* of peers: the centre stays in its half of the gap.
//!
//! *Clear* of links: the centre leaves no disc that was agreed on with a peer.
//!
//! A disc that turns in place touches nothing new: that is always allowed to a robot that stands.

use super::Reason;
use super::obstacles::{Obstacles, Plane};
use super::rollout::{Pace, Start, course, latency_course, still};
use drover_contract::{Limits, Twist, Vec2};

/// Shares of the requested turn and speed that are tried.
const TURN_SHARES: [f64; 3] = [1.0, 0.5, 0.0];
const SPEED_STEPS: u32 = 8;
/// A request for less than this is not blocked when it is not met, m/s.
const ASKED_MPS: f64 = 0.02;
/// A robot slower than this may turn in place whatever its course says, m/s.
const CREEP_MPS: f64 = 0.1;
/// Nearer than this to its bound is on it: rounding must not lock a robot, metres.
const ROUNDING_M: f64 = 1e-9;

/// What the guard knows of its body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct GuardParams {
    pub(crate) limits: Limits,
    /// Radius of the disc, metres.
    pub(crate) radius_m: f64,
    /// Gap to keep, metres.
    pub(crate) margin_m: f64,
    /// From a measurement to wheels that obey it, seconds, without the tick.
    pub(crate) latency_s: f64,
    pub(crate) tick_s: f64,
}

impl GuardParams {
    /// Distance that the body's centre keeps from points, metres.
    pub(crate) fn keep_m(&self) -> f64 {
        self.radius_m + self.margin_m
    }
}

/// What is left of a request.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Guarded {
    pub(super) twist_b: Twist,
    /// What made it less, if it is less.
    pub(super) reduced: Option<Reason>,
    /// What is in the way, if nothing is left of the requested speed.
    pub(super) blocked: Option<Reason>,
}

/// What the guard works on; the lists are kept for their memory only.
#[derive(Clone, Debug, Default)]
pub(crate) struct Scratch {
    bounds: Bounds,
    path: Vec<Vec2>,
}

/// `request` (finite), reduced.
pub(super) fn guard(
    request: Twist,
    start: Start,
    obstacles: &Obstacles,
    params: &GuardParams,
    scratch: &mut Scratch,
) -> Guarded {
    let pace = Pace { latency_s: params.latency_s, tick_s: params.tick_s, limits: &params.limits };
    let Scratch { bounds, path } = scratch;
    bounds.fill(obstacles, params, reach_m(request, start, params));
    let stays = [still(start.is_b), start.before_b, request].iter().all(|twist_b| twist_b.speed_mps == 0.0);
    if bounds.is_empty() || stays {
        // With nothing within reach, or for a body that stays where it is, no course needs to be known.
        return guarded(request, request, None);
    }
    let committed = latency_course(start, &pace, path);
    // What crosses before any command can act cannot be helped by a choice among them.
    let helpless = bounds.crossed_by(path);
    let mut why = helpless;
    for candidate in candidates(request).filter(|_| helpless.is_none()) {
        course(committed, candidate, &pace, path);
        match bounds.crossed_by(path) {
            None => return guarded(request, candidate, why),
            Some(reason) => why = why.or(Some(reason)),
        }
    }
    let stands = start.is_b.speed_mps.abs() < CREEP_MPS;
    let rest = if stands { Twist::new(0.0, request.yaw_rate_radps) } else { Twist::ZERO };
    guarded(request, rest, why)
}

fn guarded(request: Twist, twist_b: Twist, why: Option<Reason>) -> Guarded {
    let blocked = twist_b.speed_mps == 0.0 && request.speed_mps.abs() > ASKED_MPS;
    Guarded { twist_b, reduced: why, blocked: why.filter(|_| blocked) }
}

/// Shares of nothing are all alike: each is tried once.
fn candidates(request: Twist) -> impl Iterator<Item = Twist> {
    let turns = if request.yaw_rate_radps == 0.0 { 1 } else { TURN_SHARES.len() };
    let slowest = if request.speed_mps == 0.0 { SPEED_STEPS } else { 0 };
    TURN_SHARES.into_iter().take(turns).flat_map(move |turn| {
        (slowest..=SPEED_STEPS).rev().map(move |step| {
            let share = f64::from(step) / f64::from(SPEED_STEPS);
            Twist::new(request.speed_mps * share, request.yaw_rate_radps * turn)
        })
    })
}

impl GuardParams {
    /// No course at all of a body that moves as fast as `is_b` leads farther than this, metres.
    pub(crate) fn reach_m_max(&self, is_b: Twist) -> f64 {
        let most_mps = self.limits.speed_mps_max.max(self.limits.reverse_mps_max).max(is_b.speed_mps.abs());
        reach_at_m(most_mps, self)
    }
}

/// No course of a share of `request` leads farther than this from here, metres.
fn reach_m(request: Twist, start: Start, params: &GuardParams) -> f64 {
    let speeds = [request.speed_mps, start.is_b.speed_mps, start.before_b.speed_mps];
    let most_mps = speeds.iter().fold(0.0_f64, |most, speed| most.max(speed.abs()));
    reach_at_m(most_mps, params)
}

fn reach_at_m(most_mps: f64, params: &GuardParams) -> f64 {
    let ahead_s = params.latency_s + params.tick_s + 0.1;
    most_mps * ahead_s + most_mps * most_mps / (2.0 * params.limits.brake_mps2)
}

/// The bounds that matter within reach.
#[derive(Clone, Debug, Default)]
struct Bounds {
    /// Each with the distance that the centre must keep from it.
    points: Vec<(Vec2, f64)>,
    planes: Vec<Plane>,
    discs: Vec<(Vec2, f64)>,
}

impl Bounds {
    fn fill(&mut self, obstacles: &Obstacles, params: &GuardParams, reach_m: f64) {
        let keep_m = params.keep_m();
        let within_m2 = (keep_m + reach_m) * (keep_m + reach_m);
        self.points.clear();
        let near = obstacles.points_b.iter().filter(|point| point.norm_squared() <= within_m2);
        self.points.extend(near.map(|point| (*point, point.norm())));
        // What is nearest is within reach, if anything is.
        let nearest_m = self.points.iter().map(|(_, distance_m)| *distance_m).fold(f64::INFINITY, f64::min);
        let floor_m = nearest_m.clamp(params.radius_m + params.margin_m / 2.0, keep_m);
        self.points.iter_mut().for_each(|(_, distance_m)| *distance_m = floor_m.min(*distance_m));
        self.discs.clear();
        self.discs.extend(obstacles.discs.iter().filter(|(centre, radius_m)| centre.norm() + reach_m > *radius_m));
        self.planes.clear();
        self.planes.extend(obstacles.planes.iter().filter(|plane| plane.advance_m <= reach_m));
    }

    fn is_empty(&self) -> bool {
        self.points.is_empty() && self.planes.is_empty() && self.discs.is_empty()
    }

    fn crossed_by(&self, path: &[Vec2]) -> Option<Reason> {
        let plane_hit = |place: &Vec2| {
            let hit = self.planes.iter().find(|p| place.dot(&p.normal_b) > p.advance_m + ROUNDING_M);
            hit.map(|plane| plane.reason)
        };
        let point_hit = |place: &Vec2| {
            let near = |(point, keep_m): &(Vec2, f64)| (point - place).norm_squared() < (keep_m - ROUNDING_M).powi(2);
            self.points.iter().any(near).then_some(Reason::Obstacle)
        };
        let disc_left = |place: &Vec2| {
            let left = |(centre, radius_m): &(Vec2, f64)| (place - centre).norm() > radius_m + ROUNDING_M;
            self.discs.iter().any(left).then_some(Reason::Link)
        };
        path.iter().find_map(|place| plane_hit(place).or_else(|| point_hit(place)).or_else(|| disc_left(place)))
    }
}
