//! Where the robots went: the paper's figures 5, 6 and 7 as they come out here.

use super::rows::{self, ALL_LINKS, Contender, LITERAL, SAFE};
use super::scenes::{DeployPlan, Scene};
use drover_config::Swarm;
use drover_contract::Pose;
use drover_swarm::{Fidelity, Trial, run_trial, trial_of};
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

/// The ways of one run.
#[derive(Clone, Debug)]
pub struct DeployWays {
    /// Stem of a file's name for it.
    pub name: String,
    /// The swarm as it ran; its name says the row as well.
    pub swarm: Swarm,
    /// About every second: when, s, and where everybody was, world frame, in the swarm's order.
    pub moments: Vec<(f64, Vec<Pose>)>,
}

/// The ways of those scenes of a plan that the paper has figures of, by its first seed.
///
/// # Errors
/// If a scene cannot be loaded.
pub fn deploy_ways(plan: &DeployPlan) -> anyhow::Result<Vec<DeployWays>> {
    let named = |name: &str| plan.scenes.iter().find(|scene| scene.name() == name);
    let shown = FIGURES.iter().filter_map(|(number, name, rows)| Some((number, named(name)?, rows)));
    let all: Vec<(u32, &Scene, &str)> =
        shown.flat_map(|(number, scene, rows)| rows.iter().map(move |row| (*number, scene, *row))).collect();
    all.into_par_iter().map(|(number, scene, row)| ways(scene, row, (number, plan.seeds.start))).collect()
}

fn ways(scene: &Scene, row: &str, (number, seed): (u32, u64)) -> anyhow::Result<DeployWays> {
    let set = rows::of(false).into_iter().find(|own| own.name == row).map(|own| own.contender);
    let set = if let Some(Contender::Ours(set)) = set { set } else { &[] };
    let mut swarm = scene.load(set, seed)?;
    let mut trial = trial_of(&swarm, Fidelity::Direct, None)?;
    let robots = swarm.robots.len();
    let seen = |trial: &dyn Trial| {
        let poses = (0..robots).map(|robot| trial.arena().state(robot).pose_wb);
        (trial.now().as_secs_f64(), poses.collect::<Vec<Pose>>())
    };
    let mut moments = vec![seen(trial.as_ref())];
    run_trial(&swarm, trial.as_mut(), &mut |trial: &dyn Trial| {
        let last_s = moments.last().map_or(0.0, |(time_s, _)| *time_s);
        if trial.now().as_secs_f64() - last_s >= EVERY_S - 1e-9 {
            moments.push(seen(trial));
        }
        true
    });
    moments.push(seen(trial.as_ref()));
    swarm.name = format!("{}, {row}", swarm.name);
    let words: Vec<&str> = row.split([' ', ',']).filter(|word| !word.is_empty()).collect();
    Ok(DeployWays { name: format!("figure{number}_{}_{}", scene.name(), words.join("_")), swarm, moments })
}
