//! A swarm of points: the theory books' robots, which decide every period `T` and go straight in between.
//!
//! Nothing stops a point: what the law (and its safe set, if it has one) lets it do, it does, through walls if need be.
//! So it is here that the literal paper is judged and that a guard's promise is put to the test, in steps of the world
//! that are much finer than a period.

mod death;
mod hearers;

pub use death::{Aftermath, kill_one};

use crate::trial::Trial;
use drover_config::{Deploy, Exchange, Swarm};
use drover_contract::math::atan2;
use drover_contract::{BehaviourState, Pose, RobotId, Stamp, Vec2};
use drover_core::avoid::Capsule;
use drover_core::deploy::{Lockstep, Places};
use drover_core::{Status, Verdict};
use drover_robot::{HeardView, View};
use drover_world::{Arena, BodySpec, RadioTally, Walls};
use hearers::{Hearers, Scene};
use std::time::Duration;

/// Bytes that a snapshot takes on the air: each robot's own beacon (nobody leads a deployment), and for every robot
/// that it passes on for trees of more than one hop, id and place (u32, two f32).
const BEACON_BYTES: u64 = 71;
const RELAYED_BYTES: u64 = 12;

/// A swarm of points.
pub struct PointSwarm {
    now: Stamp,
    step: Duration,
    period: Duration,
    round_due: Stamp,
    arena: Arena,
    mind: Mind,
    ids: Vec<u32>,
    alive: Vec<bool>,
    from_w: Vec<Vec2>,
    ends_w: Vec<Vec2>,
    heard: Vec<Vec<HeardView>>,
    statuses: Vec<Status>,
    messages_bytes: u64,
}

/// How robots come to know each other.
enum Mind {
    Lockstep(Box<Lockstep>),
    Hearers(Box<Hearers>),
}

impl Mind {
    fn new(swarm: &Swarm, deploy: &Deploy, starts_w: &[Vec2], walls: Vec<Capsule>) -> Self {
        match deploy.exchange {
            Exchange::Snapshot => {
                // Lockstep knows robots by their place in the file, targets go by the ranks of their ids.
                let targets = targets_w(swarm, deploy).into_iter().map(|target_w| [target_w.x, target_w.y]);
                let deploy = Deploy { targets_m: targets.collect(), ..deploy.clone() };
                Self::Lockstep(Box::new(Lockstep::new(&deploy, starts_w, walls)))
            }
            Exchange::Beacons => Self::Hearers(Box::new(Hearers::new(swarm, deploy, starts_w, walls))),
        }
    }
}

impl PointSwarm {
    /// Points at rest at time zero. `deploy` is what they do.
    #[must_use]
    pub fn new(swarm: &Swarm, deploy: &Deploy) -> Self {
        let bodies = BodySpec::all_of(swarm);
        let arena = Arena::new(&swarm.world, &bodies, swarm.seed);
        let start_w: Vec<Vec2> = bodies.iter().map(|body| body.start.position()).collect();
        let status = |body: &BodySpec| Status {
            verdict: Verdict::Driving,
            state: BehaviourState::Active,
            ..Status::first(Stamp::ZERO, body.start)
        };
        Self {
            now: Stamp::ZERO,
            step: Duration::from_millis(u64::from(swarm.step_ms.max(1))),
            period: Duration::from_secs_f64(deploy.period_s),
            round_due: Stamp::ZERO,
            mind: Mind::new(swarm, deploy, &start_w, capsules(arena.walls())),
            arena,
            ids: swarm.robots.iter().map(|robot| robot.id).collect(),
            alive: vec![true; bodies.len()],
            ends_w: start_w.clone(),
            from_w: start_w,
            heard: vec![Vec::new(); bodies.len()],
            statuses: bodies.iter().map(status).collect(),
            messages_bytes: 0,
        }
    }

    /// Robot `robot` dies: it stands where it is and says nothing any more. Over beacons the others sense its body and
    /// go on avoiding it; in a snapshot it is not there.
    pub fn kill(&mut self, robot: usize) {
        if let Some(alive) = self.alive.get_mut(robot) {
            *alive = false;
            self.from_w[robot] = self.arena.state(robot).pose_wb.position();
            self.ends_w[robot] = self.from_w[robot];
        }
    }

    fn at_w(&self) -> impl Iterator<Item = Vec2> + '_ {
        (0..self.alive.len()).map(|robot| self.arena.state(robot).pose_wb.position())
    }

    /// A new period begins: everybody decides. The poses after a step of the world.
    fn in_lockstep(&mut self, at_w: &[Vec2]) -> Vec<Vec2> {
        if self.now >= self.round_due {
            self.round_due = self.now + self.period;
            self.decide(at_w);
        }
        let left = self.round_due.since(self.now + self.step).as_secs_f64() / self.period.as_secs_f64();
        let share = (1.0 - left).clamp(0.0, 1.0);
        self.from_w.iter().zip(&self.ends_w).map(|(from_w, end_w)| from_w + (end_w - from_w) * share).collect()
    }

    fn decide(&mut self, at_w: &[Vec2]) {
        let Mind::Lockstep(mind) = &mut self.mind else { return };
        let there: Vec<Option<Vec2>> =
            at_w.iter().zip(&self.alive).map(|(at_w, alive)| alive.then_some(*at_w)).collect();
        let moves = mind.round(&there);
        self.messages_bytes += moves.beacons * BEACON_BYTES + moves.relayed * RELAYED_BYTES;
        for (robot, status) in self.statuses.iter_mut().enumerate().filter(|(robot, _)| self.alive[*robot]) {
            let arrived = mind.has_arrived(robot, at_w[robot]);
            note(status, self.now, moves.changed[robot], (mind.pilot(robot).target_w(), arrived));
            let kept = moves.kept.of(robot);
            let heard = |other: &usize| HeardView { id: self.ids[*other], age_ms: 0, kept: kept.contains(other) };
            self.heard[robot] = moves.graph.neighbours(robot).iter().map(heard).collect();
            status.peers_heard = self.heard[robot].len();
            self.ends_w[robot] = moves.ends_w[robot];
        }
        self.from_w = at_w.to_vec();
    }

    /// Everybody hears, speaks, decides when it is time for it, and moves as far as the last layer lets it.
    fn by_beacons(&mut self, at_w: &[Vec2]) -> Vec<Vec2> {
        let Self { now, arena, alive, statuses, heard, .. } = self;
        let Mind::Hearers(mind) = &mut self.mind else { return at_w.to_vec() };
        let scene = Scene { now: *now, arena, at_w, alive };
        for decided in mind.turn(&scene) {
            let (robot, mate) = (decided.robot, mind.mate(decided.robot));
            note(&mut statuses[robot], *now, decided.changed, (mate.target_w(), mate.has_arrived(at_w[robot])));
            let view = |(id, age): (RobotId, Duration)| {
                let age_ms = u64::try_from(age.as_millis()).unwrap_or(u64::MAX);
                HeardView { id: id.0, age_ms, kept: mate.relies_on(id) }
            };
            heard[robot] = mind.heard(robot, *now).map(view).collect();
            statuses[robot].peers_heard = heard[robot].len();
        }
        self.messages_bytes = mind.messages_bytes();
        mind.advance(&scene, self.step.as_secs_f64())
    }
}

/// The pose of a body that goes straight from one to a place: it looks where it goes.
pub(crate) fn pose_towards(before_wb: Pose, to_w: Vec2) -> Pose {
    let way = to_w - before_wb.position();
    let yaw_rad = if way.norm() > 0.0 { atan2(way.y, way.x) } else { before_wb.yaw_rad };
    Pose::new(to_w.x, to_w.y, yaw_rad)
}

/// What a robot decided, as its status says it: whether the last layer changed it, and its target and whether it is
/// there.
fn note(status: &mut Status, now: Stamp, changed: bool, (target_w, reached): (Vec2, bool)) {
    status.stamp = now;
    status.counters.ticks += 1;
    status.changed = changed.then_some("safe set");
    if let Some(why) = status.changed {
        *status.counters.changed.entry(why).or_default() += 1;
    }
    status.reached = reached;
    status.state = if reached { BehaviourState::Done } else { BehaviourState::Active };
    status.target_w = Some(target_w);
}

/// Everybody's target, in the file's order.
pub(crate) fn targets_w(swarm: &Swarm, deploy: &Deploy) -> Vec<Vec2> {
    let ids = || swarm.robots.iter().map(|robot| RobotId(robot.id));
    let places = Places::new(ids(), &deploy.targets_m, deploy.range_m);
    ids().map(|id| places.target_w(id, &[]).unwrap_or_else(Vec2::zeros)).collect()
}

/// The walls of a place, piece by piece; a thin wall's two sides are one.
#[must_use]
pub fn capsules(walls: &Walls) -> Vec<Capsule> {
    let discs = walls.discs().iter().map(|disc| Capsule::disc(disc.centre_w, disc.radius_m));
    walls.segments().iter().map(|edge| Capsule::edge(edge.from_w, edge.to_w)).chain(discs).collect()
}

impl Trial for PointSwarm {
    fn now(&self) -> Stamp {
        self.now
    }

    fn step(&mut self) {
        let at_w: Vec<Vec2> = self.at_w().collect();
        let ends_w = match self.mind {
            Mind::Lockstep(_) => self.in_lockstep(&at_w),
            Mind::Hearers(_) => self.by_beacons(&at_w),
        };
        self.now = self.now + self.step;
        let pose = |(robot, end_w): (usize, &Vec2)| pose_towards(self.arena.state(robot).pose_wb, *end_w);
        let poses: Vec<Pose> = ends_w.iter().enumerate().map(pose).collect();
        self.arena.glide(self.step.as_secs_f64(), &poses);
        for (robot, status) in self.statuses.iter_mut().enumerate() {
            status.pose_wb = poses[robot];
            status.twist_b = self.arena.state(robot).twist_b;
            status.path_m = self.arena.path_m(robot);
        }
    }

    fn arena(&self) -> &Arena {
        &self.arena
    }

    fn status(&self, robot: usize) -> Option<&Status> {
        self.statuses.get(robot).filter(|_| self.alive[robot])
    }

    fn view(&self, robot: usize) -> Option<View> {
        let status = self.status(robot)?;
        let heard = self.heard[robot].clone();
        Some(View { heard, ..View::of_status(self.ids[robot], status, self.now) })
    }

    fn radio(&self) -> RadioTally {
        match &self.mind {
            Mind::Lockstep(_) => RadioTally::default(),
            Mind::Hearers(mind) => mind.radio(),
        }
    }

    fn aged_commands(&self) -> u64 {
        0 // a point has no wheels to command
    }

    fn messages_bytes(&self) -> u64 {
        self.messages_bytes
    }

    fn bytes(&self) -> usize {
        self.arena.bytes().0 + self.statuses.capacity() * size_of::<Status>()
    }
}
