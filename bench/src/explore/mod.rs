//! `drover bench explore`: the paper's exploration, without its parts, classical methods, what ships, on the same
//! places and starts; and what a decision costs.

mod cost;
mod rows;
mod table;

pub use cost::ExploreCostRow;

use crate::contest::{Asked, Plan, Scene, Usual};
use crate::machine::Conditions;
use drover_config::{Behaviour, Swarm};
use drover_swarm::{CellSwarm, ExploreFigures, Spread, Trial, Worst};
use rows::{ROWS, Row, SCENES};
use serde::Serialize;
use std::ops::Range;
use std::path::Path;

/// As many seeds as the prototype had.
const USUAL: Usual = Usual {
    scenes: &[(SCENES[0], &[]), (SCENES[1], &[]), (SCENES[2], &[]), (SCENES[3], &[])],
    quick: SCENES[0],
    cost: SCENES[0],
    seeds: 0..20,
    seeds_quick: 0..2,
    fits: |swarm| match &swarm.behaviour {
        Behaviour::Explore(_) => Ok(()),
        Behaviour::Flock(_) | Behaviour::Diffuse(_) | Behaviour::Deploy(_) => {
            anyhow::bail!("swarm {:?} does not explore", swarm.name)
        }
    },
};
/// A run that is not done after so many steps is not going to be.
const STEPS_MAX: u32 = 15_000;

/// What is to be measured.
#[derive(Clone, Debug)]
pub struct ExplorePlan(Plan);

/// What the bench says.
#[derive(Clone, Debug, Serialize)]
pub struct ExploreResult {
    /// Machine and build.
    pub conditions: Conditions,
    /// First seed, and one past the last.
    pub seeds: [u64; 2],
    /// Scene by scene.
    pub scenes: Vec<ExploreScene>,
    /// What a decision costs; empty if one swarm was asked for.
    pub cost: Vec<ExploreCostRow>,
}

/// Everybody on one scene.
#[derive(Clone, Debug, Serialize)]
pub struct ExploreScene {
    /// Its file's name, without its ending.
    pub scene: String,
    /// How many robots it has.
    pub robots: usize,
    /// Who did how well.
    pub rows: Vec<ExploreContender>,
}

/// One contender on one scene.
#[derive(Clone, Debug, Serialize)]
pub struct ExploreContender {
    /// What the table calls it.
    pub row: &'static str,
    /// The overrides on the scene's file that it is made of.
    pub overrides: Vec<String>,
    /// Mean steps to 96 % that a prototype measured, on worlds of its own.
    pub prototype: Option<u32>,
    /// Steps to 90 % of the free cells that can be reached.
    pub steps_90: Option<Spread>,
    /// Steps to 96 %.
    pub steps_96: Option<Spread>,
    /// Steps to 99 %.
    pub steps_99: Option<Spread>,
    /// Steps to the end.
    pub steps_finish: Option<Spread>,
    /// Steps to 96 % over those of the first row with the same seed, less one.
    pub against_first: Option<Spread>,
    /// Share of the runs that ended with nothing left.
    pub finished: Option<Spread>,
    /// Repeated views.
    pub overlap: Option<Spread>,
    /// Targets of others.
    pub obex: Option<Spread>,
    /// Run by run, in the order of seeds.
    pub runs: Vec<ExploreFigures>,
}

impl ExplorePlan {
    /// All scenes, or `swarm` alone; `seeds` unless the usual ones are meant. `quick`: few of everything.
    ///
    /// # Errors
    /// If a file is not there, cannot be read or tells a swarm to do something else.
    pub fn new(swarm: Option<&Path>, seeds: Option<Range<u64>>, quick: bool) -> anyhow::Result<Self> {
        Plan::new(&USUAL, Asked { swarm, seeds, quick }).map(Self)
    }

    /// How many runs that is.
    #[must_use]
    pub fn runs(&self) -> u64 {
        (self.rows().len() * self.0.scenes.len()) as u64 * (self.0.seeds.end - self.0.seeds.start)
    }

    fn rows(&self) -> Vec<Row> {
        ROWS.into_iter().filter(|row| row.quick || !self.0.quick).collect()
    }
}

/// Measure. `on_run` is told of every run that has ended, on whatever thread that is.
///
/// # Errors
/// If a scene cannot be loaded, or a thread pool not be made.
pub fn explore(plan: &ExplorePlan, on_run: &(dyn Fn() + Sync)) -> anyhow::Result<ExploreResult> {
    let rows = plan.rows();
    let plan = &plan.0;
    let conditions = Conditions::now();
    // First, while nothing else of ours is running.
    let cost = plan.cost_file().map_or_else(|| Ok(Vec::new()), |file| cost::measure(file, plan.quick))?;
    let contenders: Vec<(&Scene, Row)> =
        plan.scenes.iter().flat_map(|scene| rows.iter().map(move |row| (scene, *row))).collect();
    let mut runs = plan.run_all(&contenders, |(scene, row), seed| run(scene, row, seed), on_run)?.into_iter();
    let scene = |scene: &Scene| {
        let of_rows: Vec<Vec<ExploreFigures>> = runs.by_ref().take(rows.len()).collect();
        let first = of_rows.first().cloned().unwrap_or_default();
        let all = rows.iter().zip(of_rows).map(|(row, runs)| contender(&scene.name(), row, runs, &first));
        let robots = scene.load(&[], plan.seeds.start)?.robots.len();
        Ok(ExploreScene { scene: scene.name(), robots, rows: all.collect() })
    };
    let scenes = plan.scenes.iter().map(scene).collect::<anyhow::Result<_>>()?;
    Ok(ExploreResult { conditions, seeds: [plan.seeds.start, plan.seeds.end], scenes, cost })
}

fn run(scene: &Scene, row: &Row, seed: u64) -> anyhow::Result<ExploreFigures> {
    let set = row.overrides();
    let set: Vec<&str> = set.iter().map(String::as_str).collect();
    let swarm: Swarm = scene.load(&set, seed)?;
    let Behaviour::Explore(explore) = &swarm.behaviour else {
        anyhow::bail!("swarm {:?} does not explore", swarm.name)
    };
    let mut trial = CellSwarm::new(&swarm, explore);
    while trial.rounds() < STEPS_MAX && trial.round() {}
    trial.explored().ok_or_else(|| anyhow::anyhow!("swarm {:?} was not measured", swarm.name))
}

fn contender(scene: &str, row: &Row, runs: Vec<ExploreFigures>, first: &[ExploreFigures]) -> ExploreContender {
    use Worst::{Largest, Smallest};
    let steps =
        |of: fn(&ExploreFigures) -> Option<u32>| Spread::of_numbers(runs.iter().filter_map(of).map(f64::from), Largest);
    let numbers = |of: fn(&ExploreFigures) -> f64| Spread::of_numbers(runs.iter().map(of), Largest);
    let pairs = runs.iter().zip(first).filter_map(|(own, first)| own.steps_96.zip(first.steps_96));
    let against = pairs.map(|(own, first)| f64::from(own) / f64::from(first) - 1.0);
    ExploreContender {
        row: row.name,
        overrides: row.overrides(),
        prototype: row.prototype_on(scene),
        steps_90: steps(|run| run.steps_90),
        steps_96: steps(|run| run.steps_96),
        steps_99: steps(|run| run.steps_99),
        steps_finish: steps(|run| run.steps_finish),
        against_first: Spread::of_numbers(against, Largest),
        finished: Spread::of_truths(runs.iter().map(|run| run.finished && run.unreached_frontiers == 0), Smallest),
        overlap: numbers(|run| run.overlap),
        obex: numbers(|run| run.obex),
        runs,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::PathBuf;

    fn folder() -> PathBuf {
        Path::new(env!("CARGO_MANIFEST_DIR")).join("../config/swarms")
    }

    #[test]
    fn a_quick_run_has_the_paper_and_ours_and_all_of_them_finish() {
        let plan = ExplorePlan(Plan::within(&folder(), &USUAL, Asked { quick: true, ..Asked::default() }).unwrap());
        assert_eq!(plan.runs(), 8);
        let result = explore(&plan, &|| {}).unwrap();
        assert_eq!(result.cost.len(), 3);
        let [scene] = &result.scenes[..] else { panic!("one scene") };
        for row in &scene.rows {
            assert!(row.runs.len() == 2 && row.runs.iter().all(|run| run.finished), "{}", row.row);
        }
        assert!(scene.rows[0].against_first.as_ref().is_some_and(|spread| spread.mean.abs() < 1e-12));
        let words = result.to_string();
        assert!(words.contains("explore_random: 4 robots") && words.contains("sweep, whole"), "{words}");
    }

    #[test]
    fn every_row_is_a_configuration() {
        let all = Plan::within(&folder(), &USUAL, Asked::default()).unwrap();
        for row in ROWS {
            let set = row.overrides();
            let set: Vec<&str> = set.iter().map(String::as_str).collect();
            all.scenes[0].load(&set, 1).unwrap_or_else(|error| panic!("{}: {error:#}", row.name));
        }
    }
}
