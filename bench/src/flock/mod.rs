//! `drover bench flock`: the paper's flocking as printed, what can be done for it, what ships, and its parts one by
//! one.
//!
//! Every row runs on the very same seeds, so on the same places and starts; what differs is what decides. A row is a
//! list of overrides on the scene's file (`rows.rs`), run as `drover sim` does (`runs.rs`). The paper's own two scenes
//! have more rows, beside figures that were measured elsewhere. A second table says what a decision costs against the
//! number of robots (`cost.rs`).

mod cost;
mod rows;
mod runs;
mod scenes;
mod summary;
mod table;
mod ways;

pub use cost::FlockCostRow;
pub use runs::{FlockRefusal, FlockRun};
pub use scenes::FlockPlan;
pub use summary::FlockSummary;
pub use ways::flock_ways;

use crate::contest::{Plan, Scene};
use crate::machine::Conditions;
use rows::Row;
use serde::Serialize;

/// What the bench says.
#[derive(Clone, Debug, Serialize)]
pub struct FlockResult {
    /// Machine and build.
    pub conditions: Conditions,
    /// First seed, and one past the last.
    pub seeds: [u64; 2],
    /// Scene by scene.
    pub scenes: Vec<FlockScene>,
    /// What a decision costs; empty if one swarm was asked for.
    pub cost: Vec<FlockCostRow>,
}

/// Everybody on one scene.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct FlockScene {
    /// Its file's name, without its ending.
    pub scene: String,
    /// How many robots it has.
    pub robots: usize,
    /// A run takes this long, unless all have arrived before, s.
    pub duration_s: f64,
    /// Who did how well.
    pub rows: Vec<FlockContender>,
}

/// One contender on one scene.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct FlockContender {
    /// What the table calls it.
    pub row: &'static str,
    /// The overrides on the scene's file that it is made of.
    pub overrides: Vec<String>,
    /// The share of successes that a Python prototype measured: other scenes and starts.
    pub prototype: Option<f64>,
    /// What its runs say together.
    pub summary: FlockSummary,
    /// Run by run, in the order of seeds.
    pub runs: Vec<FlockRun>,
    /// Seeds with which the scene refuses these overrides, and why.
    pub refused: Vec<FlockRefusal>,
}

/// Measure. `on_run` is told of every run that has ended, on whatever thread that is.
///
/// # Errors
/// If a scene cannot be loaded as it is, or a thread pool not be made.
pub fn flock(plan: &FlockPlan, on_run: &(dyn Fn() + Sync)) -> anyhow::Result<FlockResult> {
    let plan = &plan.0;
    let conditions = Conditions::now();
    // First, while nothing else of ours is running.
    let cost = plan.cost_file().map_or_else(|| Ok(Vec::new()), |file| cost::measure(file, plan.quick))?;
    let scenes = scene_rows(plan, on_run)?;
    Ok(FlockResult { conditions, seeds: [plan.seeds.start, plan.seeds.end], scenes, cost })
}

impl FlockPlan {
    /// How many runs that is.
    #[must_use]
    pub fn runs(&self) -> u64 {
        contenders(&self.0).len() as u64 * (self.0.seeds.end - self.0.seeds.start)
    }
}

fn contenders(plan: &Plan) -> Vec<(&Scene, Row)> {
    let of_scene = |scene| rows::of(&Scene::name(scene), plan.quick).into_iter().map(move |row| (scene, row));
    plan.scenes.iter().flat_map(of_scene).collect()
}

fn scene_rows(plan: &Plan, on_run: &(dyn Fn() + Sync)) -> anyhow::Result<Vec<FlockScene>> {
    let contenders = contenders(plan);
    let runs = plan.run_all(&contenders, |(scene, row), seed| runs::run(scene, row, seed), on_run)?;
    let mut rows = contenders.iter().zip(runs).map(|((scene, row), runs)| contender(scene, row, runs));
    let scene = |scene: &Scene| {
        let swarm = scene.load(&[], plan.seeds.start)?;
        let count = rows::of(&scene.name(), plan.quick).len();
        Ok(FlockScene {
            scene: scene.name(),
            robots: swarm.robots.len(),
            duration_s: swarm.duration_s,
            rows: rows.by_ref().take(count).collect(),
        })
    };
    plan.scenes.iter().map(scene).collect()
}

fn contender(scene: &Scene, row: &Row, outcomes: Vec<Result<FlockRun, FlockRefusal>>) -> FlockContender {
    let mut runs = Vec::with_capacity(outcomes.len());
    let mut refused = Vec::new();
    for outcome in outcomes {
        match outcome {
            Ok(run) => runs.push(run),
            Err(refusal) => refused.push(refusal),
        }
    }
    FlockContender {
        row: row.name,
        overrides: row.overrides(),
        prototype: row.prototype_on(&scene.name()),
        summary: FlockSummary::of(&runs),
        runs,
        refused,
    }
}

#[cfg(test)]
mod tests;
