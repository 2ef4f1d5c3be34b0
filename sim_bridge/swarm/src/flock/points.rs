//! A flock of simulated points: the paper's robots, which decide together every `period_s`, have at once the speed and
//! the turn that they ask for, and are stopped by what they touch.

use crate::points::capsules;
use crate::trial::Trial;
use drover_config::{Flock, Swarm};
use drover_contract::{BehaviourState, Pose, RobotId, Stamp, Twist, Vec2};
use drover_core::avoid::Capsule;
use drover_core::flock::{FlockLockstep, FlockMember, FlockScene};
use drover_core::{Status, Verdict};
use drover_robot::{HeardView, View};
use drover_world::{Arena, BodySpec, RadioTally};
use std::time::Duration;

/// A return this near to a robot's rim is that robot's, metres, beside a hundredth of its radius.
const ON_RIM_M: f64 = 1e-3;

/// A swarm of them.
pub struct FlockSwarm {
    now: Stamp,
    step: Duration,
    period: Duration,
    round_due: Stamp,
    arena: Arena,
    mind: FlockLockstep,
    /// What does not move, `standing_walls` of them; then what does, as of this period, and the dead.
    walls: Vec<Capsule>,
    standing_walls: usize,
    solid: bool,
    ids: Vec<u32>,
    radii_m: Vec<f64>,
    mounts_bs: Vec<Pose>,
    alive: Vec<bool>,
    demands: Vec<Twist>,
    returns_b: Vec<Vec<Vec2>>,
    statuses: Vec<Status>,
}

impl FlockSwarm {
    /// Robots at rest at time zero. `flock` is what they do.
    #[must_use]
    pub fn new(swarm: &Swarm, flock: &Flock) -> Self {
        let bodies = BodySpec::all_of(swarm);
        let arena = Arena::new(&swarm.world, &bodies, swarm.seed);
        let kinds = || swarm.robots.iter().map(|robot| swarm.kind_of(robot));
        let status = |body: &BodySpec| Status {
            verdict: Verdict::Driving,
            state: BehaviourState::Active,
            ..Status::first(Stamp::ZERO, body.start)
        };
        let mount = |body: &BodySpec| Pose::new(body.lidar.mount.x_m, body.lidar.mount.y_m, body.lidar.mount.yaw_rad);
        let walls = capsules(arena.walls());
        Self {
            now: Stamp::ZERO,
            step: Duration::from_millis(u64::from(swarm.step_ms.max(1))),
            period: Duration::from_secs_f64(flock.period_s),
            round_due: Stamp::ZERO,
            mind: FlockLockstep::new(flock, swarm.robots.iter().map(|robot| RobotId(robot.id)).zip(kinds())),
            standing_walls: walls.len(),
            walls,
            arena,
            solid: flock.solid,
            ids: swarm.robots.iter().map(|robot| robot.id).collect(),
            radii_m: kinds().map(|kind| kind.body.radius_m).collect(),
            mounts_bs: bodies.iter().map(mount).collect(),
            alive: vec![true; bodies.len()],
            demands: vec![Twist::ZERO; bodies.len()],
            returns_b: vec![Vec::new(); bodies.len()],
            statuses: bodies.iter().map(status).collect(),
        }
    }

    /// Robot `robot` dies: it stands where it is, as an obstacle that says nothing.
    pub fn kill(&mut self, robot: usize) {
        if let Some(alive) = self.alive.get_mut(robot) {
            *alive = false;
            self.demands[robot] = Twist::ZERO;
        }
    }

    fn decide(&mut self) {
        self.look();
        let member = |robot: usize| {
            let state = self.arena.state(robot);
            self.alive[robot].then_some(FlockMember { pose_wb: state.pose_wb, twist_b: self.demands[robot] })
        };
        let members: Vec<Option<FlockMember>> = (0..self.alive.len()).map(member).collect();
        self.walls.truncate(self.standing_walls);
        self.walls.extend(self.arena.movers().map(|(centre_w, radius_m)| Capsule::disc(centre_w, radius_m)));
        let dead = (0..self.alive.len()).filter(|robot| !self.alive[*robot]);
        let body = |robot| Capsule::disc(self.arena.state(robot).pose_wb.position(), self.radii_m[robot]);
        self.walls.extend(dead.map(body));
        let scene = FlockScene { now: self.now, members: &members, returns_b: &self.returns_b, walls: &self.walls };
        for (robot, (twist, changed)) in self.mind.round(&scene).into_iter().enumerate() {
            self.demands[robot] = twist;
            self.note(robot, twist, changed);
        }
    }

    fn note(&mut self, robot: usize, twist: Twist, changed: bool) {
        let status = &mut self.statuses[robot];
        status.stamp = self.now;
        status.counters.ticks += 1;
        status.changed = changed.then_some("safe set");
        if let Some(why) = status.changed {
            *status.counters.changed.entry(why).or_default() += 1;
        }
        status.counters.wall_entries = u64::from(self.mind.wall_entries(robot));
        status.request = Some(twist);
        status.reached = self.mind.reached(robot);
        status.state = if status.reached { BehaviourState::Done } else { BehaviourState::Active };
        status.target_w = self.mind.target_w(robot);
        status.leader = self.mind.follows(robot);
        status.gives_way_to = self.mind.gives_way_to(robot);
        status.peers_heard = self.alive.iter().filter(|alive| **alive).count().saturating_sub(1);
    }

    /// What each laser shows that is no living robot's body.
    fn look(&mut self) {
        let at_w: Vec<Vec2> = self.at_w().collect();
        for robot in 0..self.alive.len() {
            if !self.alive[robot] {
                continue;
            }
            let scan = self.arena.cast(self.now, robot);
            let pose_wb = self.arena.state(robot).pose_wb;
            let mount_bs = self.mounts_bs[robot];
            let hits = scan.beams.iter().enumerate().filter_map(|(beam, reading)| {
                let drover_contract::Beam::Hit(range_m) = reading else { return None };
                let (sin, cos) = drover_contract::math::sin_cos(scan.angle_rad(beam));
                Some(mount_bs.transform(Vec2::new(cos, sin) * *range_m))
            });
            let is_wall = |point_b: &Vec2| {
                let point_w = pose_wb.transform(*point_b);
                let on = |other: usize| (point_w - at_w[other]).norm() <= self.radii_m[other] * 1.01 + ON_RIM_M;
                !(0..at_w.len()).any(|other| other != robot && self.alive[other] && on(other))
            };
            self.returns_b[robot].clear();
            self.returns_b[robot].extend(hits.filter(is_wall));
        }
    }

    fn at_w(&self) -> impl Iterator<Item = Vec2> + '_ {
        (0..self.alive.len()).map(|robot| self.arena.state(robot).pose_wb.position())
    }
}

impl Trial for FlockSwarm {
    fn now(&self) -> Stamp {
        self.now
    }

    fn step(&mut self) {
        if self.now >= self.round_due {
            self.round_due = self.round_due + self.period;
            self.decide();
        }
        self.now = self.now + self.step;
        let dt_s = self.step.as_secs_f64();
        if self.solid {
            self.arena.step(dt_s, &self.demands);
        } else {
            let ahead = |(robot, twist_b): (usize, &Twist)| self.arena.state(robot).pose_wb.advance(*twist_b, dt_s);
            let poses: Vec<Pose> = self.demands.iter().enumerate().map(ahead).collect();
            self.arena.glide(dt_s, &poses);
        }
        for (robot, status) in self.statuses.iter_mut().enumerate() {
            let state = self.arena.state(robot);
            (status.pose_wb, status.twist_b) = (state.pose_wb, state.twist_b);
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
        let others =
            self.ids.iter().zip(&self.alive).enumerate().filter(|(other, (_, alive))| *other != robot && **alive);
        let kept = |id: u32| status.leader == Some(RobotId(id));
        let heard = others.map(|(_, (id, _))| HeardView { id: *id, age_ms: 0, kept: kept(*id) }).collect();
        Some(View { heard, ..View::of_status(self.ids[robot], status, self.now) })
    }

    fn radio(&self) -> RadioTally {
        RadioTally::default()
    }

    fn aged_commands(&self) -> u64 {
        0 // a point has no wheels to command
    }

    fn bytes(&self) -> usize {
        self.arena.bytes().0 + self.statuses.capacity() * size_of::<Status>()
    }
}
