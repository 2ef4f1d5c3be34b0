//! A swarm of points: the theory books' robots, which decide every period `T` and go straight in between.
//!
//! Nothing stops a point: what the law (and its safe set, if it has one) lets it do, it does, through walls if need be.
//! So it is here that the literal paper is judged and that a guard's promise is put to the test, in steps of the world
//! that are much finer than a period.

use crate::trial::Trial;
use drover_config::{Deploy, Swarm};
use drover_contract::math::atan2;
use drover_contract::{BehaviourState, Pose, Stamp, Vec2};
use drover_core::avoid::Capsule;
use drover_core::deploy::{KeptGraph, Lockstep};
use drover_core::{Status, Verdict};
use drover_robot::{HeardView, View};
use drover_world::{Arena, BodySpec, RadioTally, Walls};
use std::time::Duration;

/// Bytes that a snapshot takes on the air: each robot's own beacon, and for every robot that it passes on for trees of
/// more than one hop, id and place (u32, two f32).
const BEACON_BYTES: u64 = 71;
const RELAYED_BYTES: u64 = 12;

/// A swarm of points.
pub struct PointSwarm {
    now: Stamp,
    step: Duration,
    period: Duration,
    round_due: Stamp,
    arena: Arena,
    mind: Lockstep,
    ids: Vec<u32>,
    alive: Vec<bool>,
    from_w: Vec<Vec2>,
    ends_w: Vec<Vec2>,
    kept: KeptGraph,
    heard: Vec<Vec<usize>>,
    statuses: Vec<Status>,
    messages_bytes: u64,
}

impl PointSwarm {
    /// Points at rest at time zero. `deploy` is what they do.
    #[must_use]
    pub fn new(swarm: &Swarm, deploy: &Deploy) -> Self {
        let bodies = BodySpec::all_of(swarm);
        let arena = Arena::new(&swarm.world, &bodies, swarm.seed);
        let mut order: Vec<usize> = (0..swarm.robots.len()).collect();
        order.sort_by_key(|robot| swarm.robots[*robot].id);
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
            mind: Lockstep::new(deploy, &start_w, capsules(arena.walls())),
            arena,
            ids: swarm.robots.iter().map(|robot| robot.id).collect(),
            alive: vec![true; bodies.len()],
            ends_w: start_w.clone(),
            from_w: start_w,
            kept: KeptGraph::default(),
            heard: vec![Vec::new(); bodies.len()],
            statuses: bodies.iter().map(status).collect(),
            messages_bytes: 0,
        }
    }

    /// Robot `robot` dies: it stands where it is and says nothing any more. The others go on avoiding its body.
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

    /// A new period begins: everybody decides.
    fn decide(&mut self) {
        let at_w: Vec<Vec2> = self.at_w().collect();
        let there: Vec<Option<Vec2>> = at_w.iter().zip(&self.alive).map(|(at_w, alive)| alive.then_some(*at_w)).collect();
        let moves = self.mind.round(&there);
        self.messages_bytes += moves.beacons * BEACON_BYTES + moves.relayed * RELAYED_BYTES;
        for (robot, status) in self.statuses.iter_mut().enumerate().filter(|(robot, _)| self.alive[*robot]) {
            status.stamp = self.now;
            status.counters.ticks += 1;
            status.changed = moves.changed[robot].then_some("safe set");
            if let Some(why) = status.changed {
                *status.counters.changed.entry(why).or_default() += 1;
            }
            status.reached = self.mind.has_arrived(robot, at_w[robot]);
            status.state = if status.reached { BehaviourState::Done } else { BehaviourState::Active };
            status.target_w = Some(self.mind.pilot(robot).target_w());
            status.peers_heard = moves.graph.neighbours(robot).len();
            self.heard[robot] = moves.graph.neighbours(robot).to_vec();
            self.ends_w[robot] = moves.ends_w[robot];
        }
        self.kept = moves.kept;
        self.from_w = at_w;
    }

    fn pose_at(&self, robot: usize, share: f64) -> Pose {
        let (from_w, end_w) = (self.from_w[robot], self.ends_w[robot]);
        let way = end_w - from_w;
        let yaw_rad =
            if way.norm() > 0.0 { atan2(way.y, way.x) } else { self.arena.state(robot).pose_wb.yaw_rad };
        let at_w = from_w + way * share;
        Pose::new(at_w.x, at_w.y, yaw_rad)
    }
}

/// The walls of a place, piece by piece; a thin wall's two sides are one.
pub(crate) fn capsules(walls: &Walls) -> Vec<Capsule> {
    let discs = walls.discs().iter().map(|disc| Capsule::disc(disc.centre_w, disc.radius_m));
    walls.segments().iter().map(|edge| Capsule::edge(edge.from_w, edge.to_w)).chain(discs).collect()
}

impl Trial for PointSwarm {
    fn now(&self) -> Stamp {
        self.now
    }

    fn step(&mut self) {
        if self.now >= self.round_due {
            self.decide();
            self.round_due = self.now + self.period;
        }
        self.now = self.now + self.step;
        let left = self.round_due.since(self.now).as_secs_f64() / self.period.as_secs_f64();
        let share = (1.0 - left).clamp(0.0, 1.0);
        let poses: Vec<Pose> = (0..self.alive.len()).map(|robot| self.pose_at(robot, share)).collect();
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
        let kept = self.kept.of(robot);
        let heard = |other: &usize| HeardView { id: self.ids[*other], age_ms: 0, kept: kept.contains(other) };
        let heard = self.heard[robot].iter().map(heard).collect();
        Some(View { heard, ..View::of_status(self.ids[robot], status, self.now) })
    }

    fn radio(&self) -> RadioTally {
        RadioTally::default()
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
