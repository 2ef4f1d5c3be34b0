//! `drover bench deploy`: the paper's deployment as printed, what ships, its parts one by one, and modern peers.
//!
//! Every row runs on the very same seeds, so on the same places, starts and layouts; what differs is what decides. A
//! row of ours is a list of overrides on the scene's file (`rows.rs`), run as `drover sim` does; a peer gets starts,
//! walls and targets of the shipped configuration, as that one assigned them (`runs.rs`). A second table says what a
//! round costs against the number of robots (`cost.rs`).
//!
//! Runs are spread over all cores; no result depends on how many there are.

mod cost;
mod peers;
mod rows;
mod runs;
mod scenes;
mod summary;
mod table;
mod ways;

pub use cost::DeployCostRow;
pub use runs::DeployRun;
pub use scenes::DeployPlan;
pub use summary::DeploySummary;
pub use ways::deploy_ways;

use crate::contest::{Plan, Scene};
use crate::machine::Conditions;
use rows::Row;
use serde::Serialize;

/// What the bench says.
#[derive(Clone, Debug, Serialize)]
pub struct DeployResult {
    /// Machine and build.
    pub conditions: Conditions,
    /// First seed, and one past the last.
    pub seeds: [u64; 2],
    /// Scene by scene.
    pub scenes: Vec<DeployScene>,
    /// What a round costs; empty if one swarm was asked for.
    pub cost: Vec<DeployCostRow>,
}

/// Everybody on one scene.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct DeployScene {
    /// Its swarm's name.
    pub scene: String,
    /// How many robots it has.
    pub robots: usize,
    /// A run ends after this long if not all have arrived, s.
    pub duration_s: f64,
    /// Who did how well.
    pub rows: Vec<DeployRow>,
}

/// One contender on one scene.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct DeployRow {
    /// What the table calls it.
    pub row: &'static str,
    /// The overrides on the scene's file that it is made of; none for a peer.
    pub overrides: Option<Vec<&'static str>>,
    /// What its runs say together.
    pub summary: DeploySummary,
    /// Run by run, in the order of seeds.
    pub runs: Vec<DeployRun>,
}

/// Measure. `on_run` is told of every run that has ended, on whatever thread that is.
///
/// # Errors
/// If a scene cannot be loaded with a seed, or a thread pool not be made.
pub fn deploy(plan: &DeployPlan, on_run: &(dyn Fn() + Sync)) -> anyhow::Result<DeployResult> {
    let conditions = Conditions::now();
    let plan = &plan.0;
    // First, while nothing else of ours is running.
    let cost = plan.cost_file().map_or_else(|| Ok(Vec::new()), |file| cost::measure(file, plan.quick))?;
    let scenes = scene_rows(plan, &rows::of(plan.quick), on_run)?;
    Ok(DeployResult { conditions, seeds: [plan.seeds.start, plan.seeds.end], scenes, cost })
}

impl DeployPlan {
    /// How many runs that is.
    #[must_use]
    pub fn runs(&self) -> u64 {
        (self.0.scenes.len() * rows::of(self.0.quick).len()) as u64 * (self.0.seeds.end - self.0.seeds.start)
    }
}

fn scene_rows(plan: &Plan, rows: &[Row], on_run: &(dyn Fn() + Sync)) -> anyhow::Result<Vec<DeployScene>> {
    let contenders: Vec<(&Scene, &Row)> =
        plan.scenes.iter().flat_map(|scene| rows.iter().map(move |row| (scene, row))).collect();
    let runs = plan.run_all(&contenders, |(scene, row), seed| runs::run(scene, row, seed), on_run)?;
    let mut of_rows = runs.into_iter();
    let row = |row: &Row, runs: Vec<DeployRun>| DeployRow {
        row: row.name,
        overrides: row.overrides(),
        summary: DeploySummary::of(&runs),
        runs,
    };
    let scene = |scene: &Scene| {
        let swarm = scene.load(&[], plan.seeds.start)?;
        Ok(DeployScene {
            scene: swarm.name,
            robots: swarm.robots.len(),
            duration_s: swarm.duration_s,
            rows: rows.iter().zip(&mut of_rows).map(|(own, runs)| row(own, runs)).collect(),
        })
    };
    plan.scenes.iter().map(scene).collect()
}

#[cfg(test)]
mod tests;
