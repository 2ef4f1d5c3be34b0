//! Where the robots went: the paper's figure 4 as it comes out here, and a robot that is trapped again.

use super::rows::{self, LITERAL, OF_PAPER, SAFE};
use super::{FlockContender, FlockPlan, FlockResult};
use crate::contest::{Figure, Scene, Ways, record_ways};
use drover_config::Swarm;
use rayon::prelude::*;

/// The figure's number in the paper.
const NUMBER: u32 = 4;
/// Between two moments, s: a wall is followed for a few seconds.
const EVERY_S: f64 = 0.2;
/// A flock goes on for metres after a trap of a few hundred millimetres: a picture shows starts and walls, and so much
/// around them, metres.
const AROUND_M: f64 = 0.3;
/// A robot that has begun to follow a wall so often was trapped again.
const TRAPPED_AGAIN: u64 = 3;

/// The ways on the paper's own scenes, those that are in the plan: the paper and what ships by the first seed, and the
/// paper once more where `result` has a run of it that fails with a robot that was trapped again.
///
/// # Errors
/// If a scene cannot be loaded.
pub fn flock_ways(plan: &FlockPlan, result: &FlockResult) -> anyhow::Result<Vec<Ways>> {
    let first = plan.0.seeds.start;
    let mut shown: Vec<(&Scene, &str, String, u64)> = Vec::new();
    for scene in OF_PAPER.iter().filter_map(|name| plan.0.named(name)) {
        shown.extend([LITERAL, SAFE].map(|row| (scene, row, row.to_owned(), first)));
        let again = trapped_again(result, &scene.name());
        shown.extend(again.map(|seed| (scene, LITERAL, format!("{LITERAL}, trapped again, seed {seed}"), seed)));
    }
    let ways = |(scene, row, called, seed): (&Scene, &str, String, u64)| {
        let own = rows::of(&scene.name(), false).into_iter().find(|own| own.name == row);
        let set = own.map(|own| own.overrides()).unwrap_or_default();
        let set: Vec<&str> = set.iter().map(String::as_str).collect();
        let ways = record_ways(scene, &Figure { number: NUMBER, row: &called, set: &set, seed, every_s: EVERY_S })?;
        Ok(Ways { view_m: Some(around(&ways.swarm)), ..ways })
    };
    shown.into_par_iter().map(ways).collect()
}

/// The box of starts and walls, and a little more.
fn around(swarm: &Swarm) -> [[f64; 2]; 2] {
    let starts_m = swarm.robots.iter().map(|robot| [robot.start.x_m, robot.start.y_m]);
    let corners_m = swarm.world.polygons.iter().flat_map(|polygon| polygon.points_m.iter().copied());
    let points_m: Vec<[f64; 2]> = starts_m.chain(corners_m).collect();
    let low = |axis: usize| points_m.iter().map(|point_m| point_m[axis]).fold(f64::INFINITY, f64::min);
    let high = |axis: usize| points_m.iter().map(|point_m| point_m[axis]).fold(f64::NEG_INFINITY, f64::max);
    [[0, 1].map(|axis| low(axis) - AROUND_M), [0, 1].map(|axis| high(axis) + AROUND_M)]
}

/// The first seed by which the paper fails so.
fn trapped_again(result: &FlockResult, scene: &str) -> Option<u64> {
    let on_scene = result.scenes.iter().find(|own| own.scene == scene)?;
    let literal: &FlockContender = on_scene.rows.iter().find(|row| row.row == LITERAL)?;
    let fails = literal.runs.iter().find(|run| !run.figures.success && run.wall_entries_max >= TRAPPED_AGAIN);
    fails.map(|run| run.seed)
}
