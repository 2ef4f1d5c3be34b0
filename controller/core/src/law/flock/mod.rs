//! Sequential flocking with wall following: robots keep together behind a leader, and nobody stays behind in a trap.
//!
//! **In**: own pose (world) and twist (body); peers with fresh beacons: pose (world), twist (body), acceleration along
//! the heading, whom they follow; the returns of the lidar that are not peers' (body frame). **Out**: a twist in the
//! body frame, m/s and rad/s.
//!
//! **Idea**: every robot is a point mass in the potential of all others, in a frame that moves with the leader
//! ([`potential`]). A potential has local minima: in a U or behind a T robots would stay behind. One that is stuck in
//! front of a wall leaves the flock, goes where the leader went or follows the wall, and joins again when the way is
//! free.
//!
//! - [`literal`]: the paper's follower, with each repair to be switched on by itself.
//! - [`safe`]: what ships.
//! - [`laser`], [`recent`]: what stands around, now and a moment ago; the virtual accompanying robot.
//! - [`deadlock`], [`trail`], [`pledge`]: the trap, and the two ways out of it.
//! - [`planes`], [`precedence`]: what walls and peers leave open, and who goes first.
//! - [`bonds`], [`ties`]: links that are kept, in the law and on bodies.
//! - [`leader`], [`route`]: how a leader gets along its way and round what stands there; it may wait for its worst
//!   link, and gives way to others.
//! - [`lead`]: who leads, and who takes over. - [`arrival`]: when a follower has arrived.
//! - [`lockstep`]: all of it for simulated points that decide together.
//!
//! **Source**: L. Cheng, Q. Zhu, H. Wu, Y. Wang, H. Fang, "Multi-mode sequential flocking strategy integrating
//! wall-following behavior for motion control of multiple mobile robots", Control and Decision 26(3), 2011, 477-480,
//! equations 1-10. Errata and readings: where each equation is, and docs/papers.md.
//!
//! **Cost**: one pass over the neighbours and one over the beams; along a wall, beams times directions.
//!
//! **Cannot solve**: the leader is not heard, or is stopped for good: [`Outcome::Stale`]; the supervisor holds the
//! robot until the leader is back, or, with `leader_loss = "elect"`, until another has explicitly taken the lead.

mod arrival;
mod bonds;
mod deadlock;
mod laser;
mod lead;
mod leader;
mod literal;
mod lockstep;
mod planes;
mod pledge;
mod potential;
mod precedence;
mod recent;
mod route;
mod safe;
mod ties;
mod trail;

pub use bonds::longest_link_m;
pub use lockstep::{FlockLockstep, FlockMember, FlockScene};

use super::pacts::{INNER_M, Tied};
use super::{Outcome, View, leads};
use crate::avoid::{Disc, OrcaParams};
use crate::links::{LinkPeer, Place};
use crate::peers::Neighbour;
use arrival::Arrival;
use drover_config::{Avoidance, Flock, FlockGuard, FlockMode, Kind, POSE_ERROR_M, RobotFile, SimMotion, WallFollowing};
use drover_contract::{LinkReport, Pose, RobotId, Stamp, Twist, Vec2};
use lead::Lead;
use leader::Leader;
use literal::Literal;
use safe::Safe;
use std::time::Duration;
use ties::Ties;

/// Parameters of one robot; the letters are the paper's.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Params {
    own: RobotId,
    /// Whom to follow now.
    leader: RobotId,
    /// The party's ids, both ends included.
    party: (u32, u32),
    mode: FlockMode,
    leader_speed_mps: f64,
    speed_mps: f64,
    turn_radps: f64,
    /// L.
    spacing_m: f64,
    /// A, m^2/s^2.
    gain: f64,
    /// S.
    obstacle_range_m: f64,
    /// d.
    head_offset_m: f64,
    /// k.
    damping_per_s: f64,
    /// m, I.
    mass_kg: f64,
    inertia_kgm2: f64,
    wall_speed_mps: f64,
    wall_turn_radps: f64,
    /// d_s0, or 0.
    wall_distance_m: f64,
    /// D.
    avoid_m: f64,
    deadlock_mps: f64,
    deadlock: Duration,
    reverse: bool,
    laser_rad: f64,
    walls: WallFollowing,
    side_latch: bool,
    right_of_way: bool,
    trail: bool,
    lose_nobody: bool,
    avoidance: Avoidance,
    /// Of the own body.
    radius_m: f64,
    margin_m: f64,
    /// From the centre to a wall at least.
    keep_m: f64,
    /// How long a link may be where they are kept, or 0.
    link_m: f64,
    /// It keeps that much farther inside of its discs than the last layer does.
    inner_m: f64,
    /// A gap is closed with this time constant, seconds: the drive must follow.
    settle_s: f64,
    /// So is an angle.
    turn_s: f64,
}

impl Params {
    fn new(flock: &Flock, kind: &Kind, own: RobotId, tick_s: f64) -> Self {
        let motion = kind.motion;
        let party = flock.party_of(own.0);
        let speed_mps = flock.speed_mps.min(motion.speed_mps_max);
        Self {
            own,
            leader: party.map_or(own, |party| RobotId(party.leader)),
            party: party.map_or((own.0, own.0), |party| (party.first_id, party.last_id)),
            mode: flock.mode,
            leader_speed_mps: flock.leader_speed_mps,
            speed_mps,
            turn_radps: flock.turn_radps.min(motion.yaw_rate_radps_max),
            spacing_m: flock.spacing_m,
            gain: flock.gain,
            obstacle_range_m: flock.obstacle_range_m,
            head_offset_m: flock.head_offset_m,
            damping_per_s: flock.damping_per_s,
            mass_kg: flock.mass_kg,
            inertia_kgm2: flock.inertia_kgm2,
            wall_speed_mps: flock.wall_speed_mps.min(speed_mps),
            wall_turn_radps: flock.wall_turn_radps.min(motion.yaw_rate_radps_max),
            wall_distance_m: flock.wall_distance_m,
            avoid_m: flock.avoid_m,
            deadlock_mps: flock.deadlock_mps,
            deadlock: Duration::from_secs_f64(flock.deadlock_s),
            reverse: flock.reverse,
            laser_rad: flock.laser_rad,
            walls: flock.walls,
            side_latch: flock.side_latch,
            right_of_way: flock.right_of_way,
            trail: flock.trail,
            lose_nobody: flock.lose_nobody,
            avoidance: flock.avoidance,
            radius_m: kind.body.radius_m,
            margin_m: motion.margin_m,
            keep_m: kind.body.radius_m + motion.margin_m,
            inner_m: 0.0,
            link_m: if flock.guard == FlockGuard::Full { flock.link_range_m } else { 0.0 },
            settle_s: 0.2 + speed_mps / motion.brake_mps2,
            turn_s: (motion.yaw_rate_radps_max.min(flock.turn_radps) / motion.yaw_accel_radps2_max).max(3.0 * tick_s),
        }
    }
}

impl Params {
    /// For reciprocal avoidance, over horizons in which a robot goes twice, and along walls half, of D.
    fn orca(&self, dt_s: f64) -> OrcaParams {
        OrcaParams {
            radius_m: self.radius_m,
            keep_m: self.margin_m,
            tracking_m: 0.0,
            horizon_s: 2.0 * self.avoid_m / self.speed_mps,
            wall_horizon_s: self.settle_s,
            dt_s,
            speed_mps_max: self.speed_mps,
        }
    }
}

/// The last layer keeps this share of the margin, and laws all of it: who obeys its law is not held up by the last
/// layer where beams 10 degrees apart show a corner a little off.
const GUARDED: f64 = 2.0 / 3.0;

/// Whether a peer is of the own party.
fn is_mate(params: &Params, peer: &Neighbour) -> bool {
    is_within(params.party, peer.id)
}

/// Whether a robot is of a party, given by its ids, both ends included.
fn is_within((first, last): (u32, u32), robot: RobotId) -> bool {
    (first..=last).contains(&robot.0)
}

/// A vector turned counter-clockwise.
fn turned(vector: Vec2, by_rad: f64) -> Vec2 {
    Pose::new(0.0, 0.0, by_rad).rotate(vector)
}

/// About how far a flock of this size reaches from its leader at rest, metres.
fn spread_m(params: &Params, view: &View<'_>) -> f64 {
    let mates = view.neighbours.iter().filter(|peer| is_mate(params, peer)).count();
    SPREAD * params.spacing_m * (mates as f64 + 1.0).sqrt()
}

/// A flock of N robots reaches this times L sqrt(N) far.
const SPREAD: f64 = 0.6;

/// One robot of a flock.
#[derive(Clone, Debug)]
pub(crate) struct Flocker {
    params: Params,
    lead: Lead,
    leader: Leader,
    arrival: Arrival,
    mind: Mind,
    goal_w: Vec2,
    /// On a body that keeps links.
    ties: Option<Ties>,
    /// Where it wishes to move, m/s, world frame.
    wish_w: Vec2,
}

#[derive(Clone, Debug)]
enum Mind {
    Literal(Literal),
    Safe(Safe),
}

impl Flocker {
    /// Robot `own` of `flock`, which decides every `tick_s`.
    pub(crate) fn new(flock: &Flock, kind: &Kind, own: RobotId, tick_s: f64) -> Self {
        let params = Params::new(flock, kind, own, tick_s);
        let end_m = flock.party_of(own.0).map_or([0.0, 0.0], drover_config::Party::end_m);
        Self {
            params,
            lead: Lead::new(flock, own),
            leader: Leader::new(flock, &params),
            arrival: Arrival::new(flock),
            mind: match flock.mode {
                FlockMode::Safe => Mind::Safe(Safe::default()),
                FlockMode::Literal => Mind::Literal(Literal::default()),
            },
            goal_w: Vec2::new(end_m[0], end_m[1]),
            ties: None,
            wish_w: Vec2::zeros(),
        }
    }

    /// The robot of `file` in its life `epoch`: one that hears its peers and, with `guard = "full"`, keeps its links by
    /// agreement with them. Simulated points know where they are.
    pub(crate) fn on_body(flock: &Flock, file: &RobotFile, epoch: u32, now: Stamp) -> Self {
        let kind = &file.kind;
        let mut law = Self::new(flock, kind, RobotId(file.robot.id), f64::from(kind.timeouts.tick_ms) / 1e3);
        if flock.guard == FlockGuard::Full {
            let (margin_m, inner_m) = match kind.sim.motion {
                SimMotion::Point => (0.0, 0.0),
                SimMotion::DiffDrive => (POSE_ERROR_M, INNER_M),
            };
            law.params.link_m = flock.link_range_m - 2.0 * (margin_m + inner_m);
            law.params.inner_m = inner_m;
            law.ties = Some(Ties::new(&law.params, (flock.link_range_m, margin_m), epoch, now));
        }
        law
    }

    /// One tick.
    pub(crate) fn step(&mut self, view: &View<'_>) -> Outcome {
        let outcome = self.decide(view);
        self.wish_w = match outcome {
            Outcome::Solved(twist_b) => view.motion.pose_wb.heading() * twist_b.speed_mps,
            Outcome::Stale(_) => Vec2::zeros(),
        };
        outcome
    }

    fn decide(&mut self, view: &View<'_>) -> Outcome {
        if self.ties.as_ref().is_some_and(|ties| !ties.is_ready()) {
            return Outcome::Solved(Twist::ZERO);
        }
        self.params.leader = self.lead.decide(&self.params, view);
        if self.params.leader == self.params.own {
            return Outcome::Solved(self.leader.step(&self.params, view));
        }
        let Some(leader) = view.neighbours.iter().find(|peer| peer.id == self.params.leader) else {
            self.arrival.update(view.now, &view.motion, None, self.goal_w);
            return self.without_leader("leader lost");
        };
        if !leads(leader.state) {
            return self.without_leader("leader stopped");
        }
        self.arrival.update(view.now, &view.motion, Some(leader), self.goal_w);
        if self.arrival.done() {
            return Outcome::Solved(Twist::ZERO);
        }
        self.leader.watch(leader.pose_wb.position());
        Outcome::Solved(match &mut self.mind {
            Mind::Literal(mind) => mind.step(&self.params, leader, view),
            Mind::Safe(mind) => mind.step(&self.params, leader, view),
        })
    }

    fn without_leader(&self, why: &'static str) -> Outcome {
        if self.arrival.done() { Outcome::Solved(Twist::ZERO) } else { Outcome::Stale(why) }
    }

    pub(crate) fn halt(&mut self) {
        match &mut self.mind {
            Mind::Literal(mind) => mind.halt(),
            Mind::Safe(mind) => mind.halt(),
        }
    }

    pub(crate) fn leads(&self) -> bool {
        self.params.leader == self.params.own
    }

    /// Whom it follows, itself if it leads; nobody while it follows a wall.
    pub(crate) fn follows(&self) -> Option<RobotId> {
        (!self.on_wall()).then_some(self.params.leader)
    }

    /// Its party's ids, both ends included.
    fn party(&self) -> (u32, u32) {
        self.params.party
    }

    pub(crate) fn leader(&self) -> RobotId {
        self.params.leader
    }

    /// To whom it gives way as a leader, standing aside.
    pub(crate) fn gives_way_to(&self) -> Option<RobotId> {
        self.leader.gives_way_to().filter(|_| self.leads())
    }

    pub(crate) fn relies_on(&self, peer: RobotId) -> bool {
        let follows = !self.leads() && self.leader() == peer;
        follows || self.ties.as_ref().is_some_and(|ties| ties.relies_on(peer))
    }

    /// Itself, if it keeps links by agreement.
    pub(crate) fn tied(&self) -> Option<&dyn Tied> {
        self.ties.is_some().then_some(self as &dyn Tied)
    }

    /// The same to be told something.
    pub(crate) fn tied_mut(&mut self) -> Option<&mut dyn Tied> {
        self.ties.is_some().then_some(self as &mut dyn Tied)
    }

    fn on_wall(&self) -> bool {
        !self.leads()
            && match &self.mind {
                Mind::Literal(mind) => mind.on_wall(),
                Mind::Safe(mind) => mind.on_wall(),
            }
    }

    /// How often it has begun to follow a wall.
    pub(crate) fn wall_entries(&self) -> u32 {
        match &self.mind {
            Mind::Literal(mind) => mind.entries(),
            Mind::Safe(mind) => mind.entries(),
        }
    }

    pub(crate) fn reached(&self) -> bool {
        if self.leads() { self.leader.reached() } else { self.arrival.done() }
    }

    /// The leader's next point, a follower's end.
    pub(crate) fn target_w(&self) -> Option<Vec2> {
        if self.leads() { self.leader.next_w() } else { (!self.arrival.done()).then_some(self.goal_w) }
    }

    /// Share of the way, by its length for a leader and by the distance left for a follower, which knows no way.
    pub(crate) fn progress(&self, gap_m: f64, start_m: f64) -> f64 {
        if self.leads() { self.leader.progress() } else { (1.0 - gap_m / start_m).clamp(0.0, 0.99) }
    }

    pub(crate) fn goal_w(&self) -> Vec2 {
        self.goal_w
    }

    /// What is farther than this from the body's centre does not matter, metres.
    pub(crate) fn range_m(flock: &Flock) -> f64 {
        flock.head_offset_m + flock.obstacle_range_m
    }
}

impl Tied for Flocker {
    fn wish_w(&self) -> Vec2 {
        self.wish_w
    }

    fn handle_report(&mut self, now: Stamp, report: &LinkReport, place: &Place) {
        if let Some(ties) = &mut self.ties {
            ties.handle_report(now, report, place);
        }
    }

    fn attend(&mut self, now: Stamp, place: &Place, peers: &[LinkPeer]) -> Option<LinkReport> {
        let leads = self.leads();
        self.ties.as_mut().map(|ties| ties.attend(now, place, peers, leads))
    }

    fn discs(&self, put: &mut dyn FnMut(Disc)) {
        self.ties.iter().flat_map(Ties::discs).for_each(put);
    }
}

#[cfg(test)]
mod tests;
