//! Where the robots went: the paper's figures 5, 6 and 7 as they come out here.

use super::rows::{self, ALL_LINKS, LITERAL, SAFE};
use super::scenes::DeployPlan;
use crate::contest::{Figure, Scene, Ways, record_ways};
use rayon::prelude::*;

/// The paper's figures: number, scene, and which rows show it. Figure 5 is that of the optimisation of links.
const FIGURES: [(u32, &str, &[&str]); 4] = [
    (5, "deploy_exp1", &[ALL_LINKS, LITERAL, SAFE]),
    (6, "deploy_exp2", &[LITERAL, SAFE]),
    (7, "deploy_exp3_row", &[LITERAL, SAFE]),
    (7, "deploy_exp3_random", &[LITERAL, SAFE]),
];
/// Between two moments, s.
const EVERY_S: f64 = 1.0;

/// The ways of those scenes of a plan that the paper has figures of, by its first seed.
///
/// # Errors
/// If a scene cannot be loaded.
pub fn deploy_ways(plan: &DeployPlan) -> anyhow::Result<Vec<Ways>> {
    let shown = FIGURES.iter().filter_map(|(number, name, rows)| Some((number, plan.0.named(name)?, rows)));
    let all: Vec<(u32, &Scene, &str)> =
        shown.flat_map(|(number, scene, rows)| rows.iter().map(move |row| (*number, scene, *row))).collect();
    let ways = |(number, scene, row): (u32, &Scene, &str)| {
        let own = rows::of(false).into_iter().find(|own| own.name == row);
        let set = own.and_then(|own| own.overrides()).unwrap_or_default();
        record_ways(scene, &Figure { number, row, set: &set, seed: plan.0.seeds.start, every_s: EVERY_S })
    };
    all.into_par_iter().map(ways).collect()
}
