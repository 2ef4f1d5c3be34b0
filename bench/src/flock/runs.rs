//! One run of one row.

use super::rows::Row;
use crate::contest::Scene;
use drover_config::{Problem, Problems, Swarm};
use drover_swarm::{Fidelity, FlockFigures, Trial, run_trial, trial_of};
use serde::Serialize;

/// How a run went.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct FlockRun {
    /// Its seed.
    pub seed: u64,
    /// How long it was, s.
    pub time_s: f64,
    /// What a flock is measured by.
    #[serde(flatten)]
    pub figures: FlockFigures,
    /// How often the robot that did so most began to follow a wall: twice and more, and it was trapped again.
    pub wall_entries_max: u64,
    /// Mean length of the robots' ways, metres.
    pub path_m_mean: f64,
    /// The least gap of two bodies, metres; none for a single robot.
    pub min_gap_robot_m: Option<f64>,
    /// The least gap of a body and a wall, metres; none where there is no wall.
    pub min_gap_wall_m: Option<f64>,
    /// Robots that touched something.
    pub touched: u64,
}

/// A scene's configuration cannot be with a row's overrides.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct FlockRefusal {
    /// With this seed.
    pub seed: u64,
    /// The first thing that is wrong.
    pub reason: String,
}

/// Run `row` on `scene` with `seed`, or say why it cannot be.
pub(super) fn run(scene: &Scene, row: &Row, seed: u64) -> anyhow::Result<Result<FlockRun, FlockRefusal>> {
    let set = row.overrides();
    let set: Vec<&str> = set.iter().map(String::as_str).collect();
    let error = match scene.load(&set, seed) {
        Ok(swarm) => return ours(&swarm).map(Ok),
        Err(error) => error,
    };
    // All problems in full are what `drover check` says; a table has room for the first.
    let problem = error.downcast_ref().and_then(|problems: &Problems| problems.iter().next());
    let reason =
        problem.map(|Problem { key, found, expected, .. }| format!("{key}: found {found}; allowed: {expected}"));
    reason.map(|reason| Err(FlockRefusal { seed, reason })).ok_or(error)
}

fn ours(swarm: &Swarm) -> anyhow::Result<FlockRun> {
    let mut trial = trial_of(swarm, Fidelity::Direct, None)?;
    let result = run_trial(swarm, trial.as_mut(), &mut |_: &dyn Trial| true);
    let measured = result.and_then(|result| Some((result.flock.clone()?, result)));
    let (figures, result) = measured.ok_or_else(|| anyhow::anyhow!("swarm {:?} was not measured", swarm.name))?;
    let statuses = (0..swarm.robots.len()).filter_map(|robot| trial.status(robot));
    Ok(FlockRun {
        seed: swarm.seed,
        time_s: result.time_s,
        figures,
        wall_entries_max: statuses.map(|status| status.counters.wall_entries).max().unwrap_or(0),
        path_m_mean: result.path_m_mean,
        min_gap_robot_m: result.min_gap_robot_m,
        min_gap_wall_m: result.min_gap_wall_m,
        touched: result.touched,
    })
}
