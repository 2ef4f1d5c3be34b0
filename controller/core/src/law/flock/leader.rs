//! The leader: its way, whom it waits for, and to whom it gives way.
//!
//! **Way**: pure pursuit ([`super::route`]), or an improved potential field with a target that moves along the legs
//! (`leader_way = "potential"`). The paper's own leader, "an improved potential field with a dynamic target point", is
//! another paper's (Gao, Huang, Robot 26(2), 2004) that we do not have; ours is this: the target keeps a spacing ahead
//! of the leader's foot on the leg and attracts with a constant force, so that it neither overshoots nor is lost; walls
//! within S repel as in S. Ge, Y. Cui, "New potential functions for mobile robot path planning", IEEE Trans. Robotics
//! and Automation 16(5), 2000: the repulsion is scaled by the distance to the end, or an end near a wall is not
//! reached.
//!
//! **Round what stands there**: the legs are free in the swarm's file, and a robot that died or a mover may stand on
//! one all the same. If the way ahead is not free as far as is seen, the leader goes in the direction nearest to it
//! that is, on the side that it chose first, until the way is free again.
//!
//! **Waiting**: it never waits (invariant 5), unless it is asked to lose nobody: then a follower that is heard from
//! some spacings beyond the flock's own reach slows the leader down, and at last stops it for as long as it takes.
//!
//! **Giving way**: of two parties that come head-on, the one whose leader has the higher id goes aside, to the
//! side of the other's way that it is on, until that one has passed; and so its followers do, who flock around it. It
//! gives way to each leader once.

use super::laser::{companion_w, returns_w};
use super::recent::Recent;
use super::route::Route;
use super::safe::{track, wall_planes};
use super::trail::is_clear;
use super::{Params, bonds, is_mate, spread_m, turned};
use crate::law::View;
use crate::peers::Neighbour;
use drover_config::{Flock, FlockMode, LeaderWay};
use drover_contract::{RobotId, Stamp, Twist, Vec2};
use std::f64::consts::PI;
use std::time::Duration;

/// With `lose_nobody`, a follower farther away than the flock's own reach and the first so many spacings slows the
/// leader down; at the second it stands.
const NEAR_SPACINGS: f64 = 2.0;
const LOST_SPACINGS: f64 = 5.0;
/// Another party's leader nearer than this many spacings, that comes our way, is made way for; going aside by so many.
const MEET_SPACINGS: f64 = 10.0;
const ASIDE_SPACINGS: f64 = 4.0;
/// Who comes within this many spacings of our place, across its way, meets us.
const LANE_SPACINGS: f64 = 3.0;
/// The others have passed when the last of them is no more than so many spacings before us: until we are back in its
/// lane it is through.
const CLEAR_SPACINGS: f64 = 2.0;
/// Nobody is given way to for longer: the other may be stuck itself.
const ASIDE_MAX: Duration = Duration::from_secs(60);

/// A leader, or who may become one.
#[derive(Clone, Debug)]
pub(super) struct Leader {
    route: Route,
    way: LeaderWay,
    aside: Option<Aside>,
    /// Whom it has given way to already.
    passed: Option<RobotId>,
    recent: Recent,
    /// Which way round what stands on the leg: +1 to the left.
    round: Option<f64>,
}

/// Giving way to a party.
#[derive(Clone, Copy, Debug)]
struct Aside {
    to: RobotId,
    since: Stamp,
    place_w: Vec2,
    /// Where the others go, a unit vector.
    their_way_w: Vec2,
}

impl Leader {
    pub(super) fn new(flock: &Flock, params: &Params) -> Self {
        let points_w = flock.party_of(params.own.0).map(|party| &party.waypoints_m);
        let points_w = points_w.into_iter().flatten().map(|[x, y]| Vec2::new(*x, *y)).collect();
        let route = Route::new(flock.waypoint_radius_m, flock.spacing_m * AIM, points_w);
        Self { route, way: flock.leader_way, aside: None, passed: None, recent: Recent::default(), round: None }
    }

    /// One tick.
    pub(super) fn step(&mut self, params: &Params, view: &View<'_>) -> Twist {
        let cruise_mps = params.leader_speed_mps * pace(params, view) * bonds::pace(params, view);
        self.route.see(view.motion.pose_wb.position());
        if params.mode == FlockMode::Safe {
            self.look_out(params, view);
        }
        if let Some(aside) = self.aside {
            let way = aside.place_w - view.motion.pose_wb.position();
            let wish_w = way * (params.leader_speed_mps / way.norm().max(params.spacing_m / 2.0));
            let places_w = self.recent.look(params, view);
            return go_round(params, (wish_w, &places_w), view);
        }
        match self.way {
            LeaderWay::Pursuit if params.mode == FlockMode::Safe => {
                let places_w = self.recent.look(params, view);
                match self.round_w(params, view.motion.pose_wb.position(), &places_w) {
                    Some(way_w) => go_round(params, (way_w * cruise_mps, &places_w), view),
                    None => self.route.pursue(cruise_mps, view),
                }
            }
            LeaderWay::Pursuit => self.route.pursue(cruise_mps, view),
            LeaderWay::Potential => match self.potential_w(params, cruise_mps, view) {
                Some(vel_w) => track(params, vel_w, params.turn_radps, view),
                None => Twist::ZERO,
            },
        }
    }

    /// Somebody else leads: if this robot ever does, the way goes on where that one is.
    pub(super) fn watch(&mut self, leader_w: Vec2) {
        self.route.see(leader_w);
        self.aside = None;
    }

    pub(super) fn gives_way_to(&self) -> Option<RobotId> {
        self.aside.map(|aside| aside.to)
    }

    pub(super) fn reached(&self) -> bool {
        self.route.reached()
    }

    pub(super) fn next_w(&self) -> Option<Vec2> {
        self.route.next_w()
    }

    pub(super) fn progress(&self) -> f64 {
        self.route.progress()
    }

    /// The direction past what stands in the way, a unit vector, or zero if there is none; `None` if the way is free.
    fn round_w(&mut self, params: &Params, at_w: Vec2, places_w: &[Vec2]) -> Option<Vec2> {
        let ahead = (self.route.aim_w()? - at_w).cap_magnitude(params.obstacle_range_m);
        let is_free = |way: Vec2| is_clear(params, (at_w, places_w), at_w + way);
        if is_free(ahead) {
            self.round = None;
            return None;
        }
        let on_side = |side: f64| {
            let mut ways = (1..=ROUND_STEPS).map(|step| (step, turned(ahead, side * ROUND_RAD * f64::from(step))));
            ways.find(|(_, way)| is_free(*way))
        };
        let (left, right) = (on_side(1.0), on_side(-1.0));
        let steps = |way: Option<(u32, Vec2)>| way.map_or(u32::MAX, |(step, _)| step);
        let nearer = if steps(left) <= steps(right) { 1.0 } else { -1.0 };
        let chosen = self.round.filter(|side| if *side > 0.0 { left.is_some() } else { right.is_some() });
        let side = *self.round.insert(chosen.unwrap_or(nearer));
        let way = if side > 0.0 { left } else { right };
        Some(way.and_then(|(_, way)| way.try_normalize(1e-9)).unwrap_or_else(Vec2::zeros))
    }

    fn potential_w(&self, params: &Params, cruise_mps: f64, view: &View<'_>) -> Option<Vec2> {
        let at_w = view.motion.pose_wb.position();
        let end_w = self.route.end_w()?;
        let to_target = self.route.aim_w()? - at_w;
        let mut vel_w = to_target * (cruise_mps / to_target.norm().max(params.spacing_m * 0.1));
        if let Some(wall_w) = companion_w(returns_w(params, view), at_w) {
            let away = at_w - wall_w;
            let (r_m, s_m) = (away.norm().max(1e-6), params.obstacle_range_m);
            // Of strength one at half of S, and by Ge and Cui's factor nothing at the end itself.
            let near_end = ((end_w - at_w).norm() / params.spacing_m).min(1.0);
            vel_w += away * (cruise_mps / r_m * (s_m / r_m - 1.0) * near_end);
        }
        Some(vel_w.cap_magnitude(cruise_mps))
    }

    /// Begin to give way, or end it.
    fn look_out(&mut self, params: &Params, view: &View<'_>) {
        let at_w = view.motion.pose_wb.position();
        if let Some(aside) = &self.aside {
            let theirs = |peer: &&Neighbour| !is_mate(params, peer) && peer.leader.unwrap_or(aside.to) == aside.to;
            let behind = |peer: &Neighbour| {
                let apart = peer.pose_wb.position() - at_w;
                apart.dot(&aside.their_way_w) > -CLEAR_SPACINGS * params.spacing_m
                    || apart.norm() > 2.0 * MEET_SPACINGS * params.spacing_m
            };
            let passed = view.neighbours.iter().filter(theirs).all(behind);
            if passed || view.now.since(aside.since) > ASIDE_MAX {
                self.passed = Some(aside.to);
                self.aside = None;
            }
            return;
        }
        let meets = |peer: &&Neighbour| {
            !is_mate(params, peer)
                && peer.leader == Some(peer.id)
                && peer.id < params.own
                && Some(peer.id) != self.passed
        };
        self.aside = view.neighbours.iter().filter(meets).find_map(|peer| aside_of(params, at_w, peer, view.now));
    }
}

/// As far as walls and links leave a wish.
fn go_round(params: &Params, (wish_w, places_w): (Vec2, &[Vec2]), view: &View<'_>) -> Twist {
    let walls = wall_planes(params, places_w, view.motion.pose_wb.position());
    track(params, bonds::held(walls, params, view).nearest(wish_w), params.turn_radps, view)
}

/// Directions round what stands in the way are tried in steps of this, radians, and so many to each side.
const ROUND_RAD: f64 = PI / 36.0;
const ROUND_STEPS: u32 = 24;

/// How far ahead on a leg the leader aims, in spacings.
const AIM: f64 = 2.0 / 3.0;

/// Where to go if `peer` comes our way.
fn aside_of(params: &Params, at_w: Vec2, peer: &Neighbour, now: Stamp) -> Option<Aside> {
    let their_way_w = peer.vel_w().try_normalize(0.1 * params.leader_speed_mps)?;
    let apart = at_w - peer.pose_wb.position();
    let (ahead_m, across_m) = (apart.dot(&their_way_w), their_way_w.perp(&apart));
    let lane_m = LANE_SPACINGS * params.spacing_m;
    if ahead_m <= 0.0 || ahead_m > MEET_SPACINGS * params.spacing_m || across_m.abs() > lane_m {
        return None;
    }
    let left_w = Vec2::new(-their_way_w.y, their_way_w.x);
    let side_w = if across_m >= 0.0 { left_w } else { -left_w };
    let place_w = at_w + side_w * (ASIDE_SPACINGS * params.spacing_m - across_m.abs()).max(0.0);
    Some(Aside { to: peer.id, since: now, place_w, their_way_w })
}

/// Share of the speed at which it drives on: less while somebody is far behind, if nobody is to be lost.
fn pace(params: &Params, view: &View<'_>) -> f64 {
    if !params.lose_nobody {
        return 1.0;
    }
    let at_w = view.motion.pose_wb.position();
    let mates = view.neighbours.iter().filter(|peer| is_mate(params, peer));
    let worst_m = mates.map(|peer| (peer.pose_wb.position() - at_w).norm()).fold(0.0, f64::max);
    let spread_m = spread_m(params, view);
    let (near_m, most_m) = (NEAR_SPACINGS * params.spacing_m + spread_m, LOST_SPACINGS * params.spacing_m + spread_m);
    ((most_m - worst_m) / (most_m - near_m)).clamp(0.0, 1.0)
}
