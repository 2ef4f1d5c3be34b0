//! What is left undone when a robot dies halfway.

use super::rows::principal;
use super::runs::{Case, is_done};
use crate::contest::Plan;
use drover_swarm::{ExploreFigures, Spread, Worst};
use serde::Serialize;

/// A method on a scene, one robot of which is killed when half of the place is known.
#[derive(Clone, Debug, Serialize)]
pub struct ExploreKilled {
    /// The scene's file, without its ending.
    pub scene: String,
    /// The method.
    pub row: &'static str,
    /// Runs in which the others came to an end with nothing left that they could reach.
    pub done: usize,
    /// Steps to 96 %.
    pub steps_96: Option<Spread>,
    /// Steps to the end.
    pub steps_finish: Option<Spread>,
    /// What was known in the end, of what could have been reached were nobody dead.
    pub coverage: Option<Spread>,
    /// Run by run, in the order of seeds.
    pub runs: Vec<ExploreFigures>,
}

/// Everybody on every scene; in a quick run the method that ships alone.
pub(super) fn cases(plan: &Plan) -> Vec<Case<'_>> {
    let rows = principal().into_iter().filter(|row| !plan.quick || row.name == "sweep");
    let rows: Vec<_> = rows.collect();
    let of = |scene| rows.iter().map(move |row| Case { kills: true, ..Case::of(scene, *row) });
    plan.scenes.iter().flat_map(of).collect()
}

pub(super) fn line(case: &Case<'_>, runs: Vec<ExploreFigures>) -> ExploreKilled {
    let steps = |of: fn(&ExploreFigures) -> Option<u32>| {
        Spread::of_numbers(runs.iter().filter_map(of).map(f64::from), Worst::Largest)
    };
    ExploreKilled {
        scene: case.scene.name(),
        row: case.row.name,
        done: runs.iter().filter(|run| is_done(run)).count(),
        steps_96: steps(|run| run.steps_96),
        steps_finish: steps(|run| run.steps_finish),
        coverage: Spread::of_numbers(runs.iter().map(|run| run.coverage), Worst::Smallest),
        runs,
    }
}
