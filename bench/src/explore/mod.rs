//! `drover bench explore`: the paper's exploration, without its parts, classical methods, what ships, on the same
//! places and starts; with a robot that dies, with other numbers of robots, on larger places; what the paper's figures
//! show; and what a decision costs.

mod concentration;
mod cost;
mod course;
mod killed;
mod part;
mod rows;
mod runs;
mod table;
mod teams;

pub use concentration::ExploreConcentration;
pub use cost::ExploreCostRow;
pub use course::{ExploreCourse, ExploreWindow};
pub use killed::ExploreKilled;
pub use part::ExplorePart;
pub use teams::{ExploreTeam, ExploreTeamRow};

use crate::contest::{Asked, Plan, Scene, Usual};
use crate::machine::Conditions;
use drover_config::Behaviour;
use drover_swarm::{ExploreFigures, Spread, Worst};
use rows::{ROWS, Row, SCENES};
use runs::{Case, is_done};
use serde::Serialize;
use std::ops::Range;
use std::path::Path;

/// What is run unless told otherwise; seeds are each part's own.
const USUAL: Usual = Usual {
    scenes: &[(SCENES[0], &[]), (SCENES[1], &[]), (SCENES[2], &[]), (SCENES[3], &[])],
    quick: SCENES[0],
    cost: SCENES[0],
    seeds: ExplorePart::Rows.seeds(false),
    seeds_quick: ExplorePart::Rows.seeds(true),
    fits: |swarm| match &swarm.behaviour {
        Behaviour::Explore(_) => Ok(()),
        Behaviour::Flock(_) | Behaviour::Diffuse(_) | Behaviour::Deploy(_) => {
            anyhow::bail!("swarm {:?} does not explore", swarm.name)
        }
    },
};

/// What is to be measured.
#[derive(Clone, Debug)]
pub struct ExplorePlan {
    plan: Plan,
    /// Whether seeds were asked for; else each part has its own.
    seeded: bool,
    only: Option<ExplorePart>,
}

/// What the bench says.
#[derive(Clone, Debug, Serialize)]
pub struct ExploreResult {
    /// Machine and build.
    pub conditions: Conditions,
    /// First seed of the scenes' rows, and one past the last.
    pub seeds: [u64; 2],
    /// Scene by scene.
    pub scenes: Vec<ExploreScene>,
    /// A robot dies.
    pub killed: ExploreTable<ExploreKilled>,
    /// Other numbers of robots; empty if one swarm was asked for.
    pub teams: ExploreTable<ExploreTeam>,
    /// Larger places; empty if one swarm was asked for.
    pub large: ExploreTable<ExploreTeam>,
    /// The paper's figures 4 and 5.
    pub courses: ExploreTable<ExploreCourse>,
    /// What a decision costs; empty if one swarm was asked for.
    pub cost: Vec<ExploreCostRow>,
}

/// A part with seeds of its own.
#[derive(Clone, Debug, Default, Serialize)]
pub struct ExploreTable<T> {
    /// First seed, and one past the last.
    pub seeds: [u64; 2],
    /// Line by line; none if the part was not asked for.
    pub lines: Vec<T>,
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
    /// All scenes, or `swarm` alone; `seeds` for all parts, or each part's usual ones. `quick`: few of everything.
    ///
    /// # Errors
    /// If a file is not there, cannot be read or tells a swarm to do something else.
    pub fn new(swarm: Option<&Path>, seeds: Option<Range<u64>>, quick: bool) -> anyhow::Result<Self> {
        let seeded = seeds.is_some();
        Ok(Self { plan: Plan::new(&USUAL, Asked { swarm, seeds, quick })?, seeded, only: None })
    }

    /// One part alone, or all of them.
    #[must_use]
    pub fn only(self, only: Option<ExplorePart>) -> Self {
        Self { only, ..self }
    }

    /// How many runs that is, without those that are timed.
    #[must_use]
    pub fn runs(&self) -> u64 {
        let of = |part: ExplorePart| {
            let plan = self.of(part);
            let cases = match part {
                ExplorePart::Rows => plan.scenes.len() * self.rows().len(),
                ExplorePart::Killed => killed::cases(&plan).len(),
                ExplorePart::Teams => teams::teams(&plan, false).iter().map(|team| team.cases().count()).sum(),
                ExplorePart::Large => teams::teams(&plan, true).iter().map(|team| team.cases().count()).sum(),
                ExplorePart::Figures => course::cases(&plan).len(),
                ExplorePart::Cost => 0,
            };
            cases as u64 * (plan.seeds.end - plan.seeds.start)
        };
        ExplorePart::ALL.into_iter().filter(|part| self.has(*part)).map(of).sum()
    }

    fn rows(&self) -> Vec<Row> {
        ROWS.into_iter().filter(|row| row.quick || !self.plan.quick).collect()
    }

    fn has(&self, part: ExplorePart) -> bool {
        let all_scenes = self.plan.cost_file().is_some();
        self.only.is_none_or(|only| only == part) && (all_scenes || part.is_of_any_swarm())
    }

    /// The plan of a part, with its seeds.
    fn of(&self, part: ExplorePart) -> Plan {
        let mut plan = self.plan.clone();
        if !self.seeded {
            plan.seeds = part.seeds(plan.quick);
        }
        plan
    }

    /// A part's table, if it is wanted.
    fn table<T>(
        &self,
        part: ExplorePart,
        lines: impl FnOnce(&Plan) -> anyhow::Result<Vec<T>>,
    ) -> anyhow::Result<ExploreTable<T>> {
        if !self.has(part) {
            return Ok(ExploreTable { seeds: [0, 0], lines: Vec::new() });
        }
        let plan = self.of(part);
        Ok(ExploreTable { seeds: [plan.seeds.start, plan.seeds.end], lines: lines(&plan)? })
    }
}

/// Measure. `on_run` is told of every run that has ended, on whatever thread that is.
///
/// # Errors
/// If a scene cannot be loaded, or a thread pool not be made.
pub fn explore(plan: &ExplorePlan, on_run: &(dyn Fn() + Sync)) -> anyhow::Result<ExploreResult> {
    let conditions = Conditions::now();
    // First, while nothing else of ours is running.
    let file = plan.plan.cost_file().filter(|_| plan.has(ExplorePart::Cost));
    let cost = file.map_or_else(|| Ok(Vec::new()), |file| cost::measure(file, plan.plan.quick))?;
    let rows = plan.rows();
    let scenes = plan.table(ExplorePart::Rows, |plan| scene_rows(plan, &rows, on_run))?;
    let killed = |plan: &Plan| {
        let cases = killed::cases(plan);
        let runs = plan.run_all(&cases, Case::run, on_run)?;
        Ok(cases.iter().zip(runs).map(|(case, runs)| killed::line(case, runs)).collect())
    };
    let courses = |plan: &Plan| {
        let cases = course::cases(plan);
        let runs = plan.run_all(&cases, course::run, on_run)?;
        Ok(cases.iter().zip(runs).map(|(case, runs)| course::line(case, runs)).collect())
    };
    Ok(ExploreResult {
        conditions,
        seeds: scenes.seeds,
        scenes: scenes.lines,
        killed: plan.table(ExplorePart::Killed, killed)?,
        teams: plan.table(ExplorePart::Teams, |plan| teams::measure(plan, false, on_run))?,
        large: plan.table(ExplorePart::Large, |plan| teams::measure(plan, true, on_run))?,
        courses: plan.table(ExplorePart::Figures, courses)?,
        cost,
    })
}

fn scene_rows(plan: &Plan, rows: &[Row], on_run: &(dyn Fn() + Sync)) -> anyhow::Result<Vec<ExploreScene>> {
    let cases: Vec<Case<'_>> =
        plan.scenes.iter().flat_map(|scene| rows.iter().map(move |row| Case::of(scene, *row))).collect();
    let mut runs = plan.run_all(&cases, Case::run, on_run)?.into_iter();
    let scene = |scene: &Scene| {
        let of_rows: Vec<Vec<ExploreFigures>> = runs.by_ref().take(rows.len()).collect();
        let first = of_rows.first().cloned().unwrap_or_default();
        let all = rows.iter().zip(of_rows).map(|(row, runs)| contender(&scene.name(), row, runs, &first));
        let robots = scene.load(&[], plan.seeds.start)?.robots.len();
        Ok(ExploreScene { scene: scene.name(), robots, rows: all.collect() })
    };
    plan.scenes.iter().map(scene).collect()
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
        finished: Spread::of_truths(runs.iter().map(is_done), Smallest),
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
    fn a_quick_run_has_a_little_of_each_part_and_all_of_it_finishes() {
        let plan = Plan::within(&folder(), &USUAL, Asked { quick: true, ..Asked::default() }).unwrap();
        let plan = ExplorePlan { plan, seeded: false, only: None };
        assert_eq!(plan.runs(), 5 * 2 + 2 + 2 * 3 + 3 + 1);
        let result = explore(&plan, &|| {}).unwrap();
        assert_eq!(result.cost.len(), 3);
        let [scene] = &result.scenes[..] else { panic!("one scene") };
        for row in &scene.rows {
            assert!(row.runs.len() == 2 && row.runs.iter().all(is_done), "{}", row.row);
        }
        assert!(scene.rows[0].against_first.as_ref().is_some_and(|spread| spread.mean.abs() < 1e-12));
        let killed = &result.killed.lines[0];
        assert!(killed.done == 2 && killed.coverage.as_ref().is_some_and(|spread| spread.worst > 0.5), "{killed:?}");
        let teams: Vec<&ExploreTeam> = result.teams.lines.iter().chain(&result.large.lines).collect();
        assert_eq!(
            teams.iter().map(|team| (team.side_cells, team.robots)).collect::<Vec<_>>(),
            [(100, 2), (100, 8), (112, 8)]
        );
        assert!(teams.iter().flat_map(|team| &team.rows).all(|row| row.done == 1), "{teams:?}");
        let steps = |team: &ExploreTeam| team.rows[0].steps_96.as_ref().map_or(0.0, |spread| spread.mean);
        assert!(steps(teams[0]) > 2.0 * steps(teams[1]), "eight are faster than two");
        let course = &result.courses.lines[0];
        assert!(course.windows.last().is_some_and(|window| window.coverage >= 0.96), "{course:?}");
        let [with, without, ..] = &course.concentrations[..] else { panic!("four networks") };
        assert!(with.mean.len() == 41 && with.mean[10] > 0.5 && without.mean[10] > with.mean[10], "{course:?}");
        let words = result.to_string();
        assert!(words.contains("explore_random: 4 robots") && words.contains("sweep, whole"), "{words}");
        assert!(words.contains("2 of 2") && words.contains("112 cells"), "{words}");
        assert!(words.lines().all(|line| line.chars().count() <= 160), "{words}");
    }

    #[test]
    fn one_part_of_one_swarm_is_that_part_alone() {
        let file = folder().join("explore_cave.toml");
        let plan = ExplorePlan::new(Some(&file), Some(3..5), false).unwrap();
        assert_eq!(plan.clone().only(Some(ExplorePart::Teams)).runs(), 0, "team sizes are those of shipped scenes");
        assert_eq!(plan.clone().only(Some(ExplorePart::Killed)).runs(), 4 * 2);
        assert_eq!(plan.of(ExplorePart::Large).seeds, 3..5);
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
