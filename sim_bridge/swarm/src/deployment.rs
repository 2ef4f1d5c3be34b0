//! What a deployment is measured by, from outside: where the bodies truly are, step by step.
//!
//! Within a step of the world every body moves straight (points) or nearly so. The distance of two such bodies is a
//! convex function of time: links of which both ends of a step are within range are so all the time, and the smallest
//! distance within the step is known in closed form.

use drover_config::{Deploy, Drive, Kind, SimMotion, Swarm};
use drover_contract::Vec2;
use drover_core::avoid::Capsule;
use drover_core::deploy::Graph;
use drover_record::connectivity;
use drover_world::Arena;
use serde::Serialize;

use crate::points::{capsules, targets_w};

/// How often the algebraic connectivity is computed, s; its eigenvalues cost the cube of the number of robots.
const LAMBDA_S: f64 = 1.0;
/// In larger swarms it is left out.
const LAMBDA_ROBOTS_MAX: usize = 200;
/// What odometry may be off by, as a share of the way: the shipped robots' is 2 % or so after 20 m.
const DRIFT_SHARE: f64 = 0.05;
/// Rounding must not part a network that stands on its bound, metres.
const ROUNDING_M: f64 = 1e-9;

/// One run of a deployment.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct DeployFigures {
    /// Whether the living robots were one network, by their true positions and the range, at every step.
    pub connected_always: bool,
    /// Smallest algebraic connectivity of that network, links of weight 1, looked at every second; none for a swarm of
    /// more than 200 robots.
    pub lambda2_min: Option<f64>,
    /// For how long it was parted, s.
    pub time_disconnected_s: f64,
    /// Share of the robots whose bodies ended within `arrive_m` of their own target; of those that know their place by
    /// odometry alone, within 5 % of the way that they drove beyond it: odometry drifts.
    pub arrived_fraction: f64,
    /// Robots whose centre crossed an obstacle.
    pub tunnelled: u64,
    /// Share of the decisions that the last layer changed.
    pub guard_changed_fraction: f64,
    /// What was said on the air, bytes.
    pub messages_bytes: u64,
}

/// Watches one run.
#[derive(Clone, Debug)]
pub(crate) struct Deployment {
    targets_w: Vec<Vec2>,
    range_m: f64,
    arrive_m: f64,
    points: bool,
    /// Of each robot whether it knows its place by odometry alone.
    drifts: Vec<bool>,
    walls: Vec<Capsule>,
    before_w: Vec<Option<Vec2>>,
    lambda_due_s: f64,
    lambda2_min: Option<f64>,
    disconnected_s: f64,
    crossed: Vec<bool>,
    robot_m_min: f64,
    wall_m_min: f64,
}

impl Deployment {
    /// Before the first step of `swarm`.
    pub(crate) fn new(swarm: &Swarm, deploy: &Deploy, arena: &Arena) -> Self {
        let count = swarm.robots.len();
        let mut watch = Self {
            targets_w: targets_w(swarm, deploy),
            range_m: deploy.range_m,
            arrive_m: deploy.arrive_m,
            points: is_of_points(swarm),
            drifts: swarm.robots.iter().map(|robot| drifts(swarm.kind_of(robot))).collect(),
            walls: capsules(arena.walls()),
            before_w: vec![None; count],
            lambda_due_s: 0.0,
            lambda2_min: None,
            disconnected_s: 0.0,
            crossed: vec![false; count],
            robot_m_min: f64::INFINITY,
            wall_m_min: f64::INFINITY,
        };
        watch.see(arena, |_| true, (0.0, 0.0));
        watch
    }

    /// The bodies after a step of `dt_s` that ends at `now_s`; `lives` says which robots still count.
    pub(crate) fn see(&mut self, arena: &Arena, lives: impl Fn(usize) -> bool, (now_s, dt_s): (f64, f64)) {
        let at_w: Vec<Vec2> = (0..self.before_w.len()).map(|robot| arena.state(robot).pose_wb.position()).collect();
        let living: Vec<Option<Vec2>> =
            at_w.iter().enumerate().map(|(robot, at_w)| lives(robot).then_some(*at_w)).collect();
        let graph = Graph::new(&living, self.range_m + ROUNDING_M);
        if graph.all().parts(|robot| living[robot].is_some()) > 1 {
            self.disconnected_s += dt_s.max(f64::MIN_POSITIVE);
        }
        if now_s >= self.lambda_due_s && at_w.len() <= LAMBDA_ROBOTS_MAX {
            self.lambda_due_s = now_s + LAMBDA_S;
            let lambda2 = lambda2(&graph, &living);
            self.lambda2_min = self.lambda2_min.map_or(lambda2, |least| lambda2.map(|lambda2| lambda2.min(least)));
        }
        self.measure_gaps(&at_w);
        self.before_w = at_w.into_iter().map(Some).collect();
    }

    fn measure_gaps(&mut self, at_w: &[Vec2]) {
        let from_w = |robot: usize| self.before_w[robot].unwrap_or(at_w[robot]);
        let everybody: Vec<Option<Vec2>> = at_w.iter().copied().map(Some).collect();
        let near = Graph::new(&everybody, self.range_m);
        for robot in 0..at_w.len() {
            let others = near.neighbours(robot).iter().filter(|other| **other > robot);
            let apart_m = others.map(|other| nearest_m(from_w(robot) - from_w(*other), at_w[robot] - at_w[*other]));
            self.robot_m_min = apart_m.fold(self.robot_m_min, f64::min);
            let (from_w, to_w) = (from_w(robot), at_w[robot]);
            for wall in &self.walls {
                if wall.at_least_m(to_w) - (to_w - from_w).norm() < self.wall_m_min.max(0.0) {
                    let clear_m = wall.clearance_m(from_w, to_w);
                    self.wall_m_min = self.wall_m_min.min(clear_m);
                    self.crossed[robot] |= clear_m <= 0.0;
                }
            }
        }
    }

    /// Smallest distance so far of two points, metres, and of a point and a wall; none for bodies, which the arena
    /// measures from surface to surface.
    pub(crate) fn point_gaps_m(&self) -> Option<(Option<f64>, Option<f64>)> {
        let finite = |gap_m: f64| gap_m.is_finite().then_some(gap_m.max(0.0));
        self.points.then_some((finite(self.robot_m_min), finite(self.wall_m_min)))
    }

    /// Whether robot `robot` is within `arrive_m` of its target, as well as it can know.
    pub(crate) fn has_arrived(&self, arena: &Arena, robot: usize) -> bool {
        let drift_m = if self.drifts[robot] { DRIFT_SHARE * arena.path_m(robot) } else { 0.0 };
        (arena.state(robot).pose_wb.position() - self.targets_w[robot]).norm() <= self.arrive_m + drift_m
    }

    /// What came out. `changed` of `decisions` were changed by the last layer.
    pub(crate) fn figures(
        &self,
        arena: &Arena,
        (changed, decisions): (u64, u64),
        messages_bytes: u64,
    ) -> DeployFigures {
        let count = self.before_w.len();
        let arrived = (0..count).filter(|robot| self.has_arrived(arena, *robot)).count();
        DeployFigures {
            connected_always: self.disconnected_s <= 0.0,
            lambda2_min: self.lambda2_min,
            time_disconnected_s: self.disconnected_s,
            arrived_fraction: arrived as f64 / count.max(1) as f64,
            tunnelled: self.crossed.iter().filter(|crossed| **crossed).count() as u64,
            guard_changed_fraction: changed as f64 / decisions.max(1) as f64,
            messages_bytes,
        }
    }
}

/// Whether a robot of this kind knows its place by odometry alone: an autopilot has fixes.
fn drifts(kind: &Kind) -> bool {
    match kind.drive {
        Drive::AgilexV2 { .. } => true,
        Drive::Mavlink { .. } => false,
    }
}

/// Whether all robots are points of the theory books.
pub(crate) fn is_of_points(swarm: &Swarm) -> bool {
    swarm.robots.iter().all(|robot| swarm.kind_of(robot).sim.motion == SimMotion::Point)
}

/// Smallest length of a difference that goes straight from one to the other.
fn nearest_m(from: Vec2, to: Vec2) -> f64 {
    Capsule::edge(from, to).distance_m(Vec2::zeros())
}

fn lambda2(graph: &Graph, living: &[Option<Vec2>]) -> Option<f64> {
    let mut place = vec![0; living.len()];
    let mut count = 0;
    for (robot, _) in living.iter().enumerate().filter(|(_, at_w)| at_w.is_some()) {
        place[robot] = count;
        count += 1;
    }
    let of = |robot: usize| graph.neighbours(robot).iter().map(move |other| (robot, *other));
    let links: Vec<(usize, usize)> =
        (0..living.len()).flat_map(of).map(|(one, other)| (place[one], place[other])).collect();
    connectivity(count, &links).lambda2
}
