//! One run of one row, measured the same way whoever decides.
//!
//! Ours are measured every step of the world (50 ms, exact in between), peers over whole periods (exact in between as
//! well). Both end as soon as everybody is within the arrival radius at a moment of decision.

use super::peers;
use super::rows::{Contender, Row};
use super::scenes::deploys;
use crate::contest::Scene;
use drover_config::{Deploy, Swarm};
use drover_contract::Vec2;
use drover_swarm::{Fidelity, Trial, capsules, run_trial, trial_of};
use drover_world::{Arena, BodySpec};
use serde::Serialize;

/// How a run went.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct DeployRun {
    /// Its seed.
    pub seed: u64,
    /// Whether the swarm was one network at every moment.
    pub connected_always: bool,
    /// Whether everybody ended at its own target.
    pub all_arrived: bool,
    /// Share of the robots that did.
    pub arrived_fraction: f64,
    /// Until all had arrived, or how long it was given, s.
    pub time_s: f64,
    /// The longest straight line from a start to its target at full speed, s: nobody can be faster.
    pub bound_s: f64,
    /// Mean length of the robots' ways, metres.
    pub path_m_mean: f64,
    /// The least distance of two centres, metres; none for a single robot.
    pub min_gap_robot_m: Option<f64>,
    /// The least distance of a centre and a wall, metres; none where there is no wall.
    pub min_gap_wall_m: Option<f64>,
    /// Whether anybody's centre crossed a wall.
    pub tunnelled: bool,
    /// The smallest algebraic connectivity, links of weight 1, looked at about every second.
    pub lambda2_min: Option<f64>,
    /// Share of decisions that the last layer changed; none for a peer.
    pub guard_changed_fraction: Option<f64>,
    /// How often a peer's robot stayed because its problem had no solution; none for ours.
    pub cannot_solve: Option<u64>,
}

/// Run `row` on `scene` with `seed`.
pub(super) fn run(scene: &Scene, row: &Row, seed: u64) -> anyhow::Result<DeployRun> {
    match row.contender {
        Contender::Ours(set) => ours(&scene.load(set, seed)?),
        Contender::Peer(at) => of_peer(&scene.load(&[], seed)?, at),
    }
}

fn ours(swarm: &Swarm) -> anyhow::Result<DeployRun> {
    let mut trial = trial_of(swarm, Fidelity::Direct, None)?;
    let result = run_trial(swarm, trial.as_mut(), &mut |_: &dyn Trial| true);
    let measured = result.and_then(|result| Some((result.deploy.clone()?, result)));
    let (figures, result) = measured.ok_or_else(|| anyhow::anyhow!("swarm {:?} was not measured", swarm.name))?;
    Ok(DeployRun {
        seed: swarm.seed,
        connected_always: figures.connected_always,
        all_arrived: result.reached,
        arrived_fraction: figures.arrived_fraction,
        time_s: result.time_s,
        bound_s: Task::of(swarm)?.bound_s(),
        path_m_mean: result.path_m_mean,
        min_gap_robot_m: result.min_gap_robot_m,
        min_gap_wall_m: result.min_gap_wall_m,
        tunnelled: figures.tunnelled > 0,
        lambda2_min: figures.lambda2_min,
        guard_changed_fraction: Some(figures.guard_changed_fraction),
        cannot_solve: None,
    })
}

fn of_peer(swarm: &Swarm, at: usize) -> anyhow::Result<DeployRun> {
    let task = Task::of(swarm)?;
    let deploy = task.deploy;
    let walls = capsules(Arena::new(&swarm.world, &BodySpec::all_of(swarm), swarm.seed).walls());
    let scene = peers::Scene {
        walls: &walls,
        targets_w: &task.targets_w,
        range_m: deploy.range_m,
        step_m: deploy.speed_mps * deploy.period_s,
        period_s: deploy.period_s,
        robot_gap_m: deploy.robot_gap_m,
        wall_gap_m: deploy.wall_gap_m,
    };
    let mut peer = peers::all().swap_remove(at);
    let run = peers::run(peer.as_mut(), &scene, &task.starts_w, swarm.duration_s);
    let finite = |gap_m: f64| gap_m.is_finite().then_some(gap_m.max(0.0));
    Ok(DeployRun {
        seed: swarm.seed,
        connected_always: run.connected_always,
        all_arrived: run.arrived_fraction >= 1.0,
        arrived_fraction: run.arrived_fraction,
        time_s: run.time_s,
        bound_s: task.bound_s(),
        path_m_mean: run.path_m_mean,
        min_gap_robot_m: finite(run.min_gap_robot_m),
        min_gap_wall_m: finite(run.min_gap_wall_m),
        tunnelled: run.tunnelled,
        lambda2_min: Some(run.lambda2_min),
        guard_changed_fraction: None,
        cannot_solve: Some(run.cannot_solve),
    })
}

/// Who has to go from where to where.
pub(super) struct Task<'a> {
    pub(super) deploy: &'a Deploy,
    pub(super) starts_w: Vec<Vec2>,
    pub(super) targets_w: Vec<Vec2>,
}

impl<'a> Task<'a> {
    /// Of `swarm`: the robot with the k-th smallest id goes to the k-th target.
    pub(super) fn of(swarm: &'a Swarm) -> anyhow::Result<Self> {
        let deploy = deploys(swarm)?;
        let mut robots: Vec<_> = swarm.robots.iter().collect();
        robots.sort_by_key(|robot| robot.id);
        let starts_w = robots.iter().map(|robot| Vec2::new(robot.start.x_m, robot.start.y_m)).collect();
        let targets = deploy.targets_m.iter().take(robots.len());
        Ok(Self { deploy, starts_w, targets_w: targets.map(|[x, y]| Vec2::new(*x, *y)).collect() })
    }

    fn bound_s(&self) -> f64 {
        let ways_m = self.starts_w.iter().zip(&self.targets_w).map(|(start_w, target_w)| (target_w - start_w).norm());
        ways_m.fold(0.0, f64::max) / self.deploy.speed_mps
    }
}
