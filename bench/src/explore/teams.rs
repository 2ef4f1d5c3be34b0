//! Other numbers of robots, and larger places.

use super::rows::{Row, SCENES, principal, sized};
use super::runs::{Case, is_done};
use crate::contest::{Plan, Scene};
use drover_swarm::{ExploreFigures, Spread, Worst};
use serde::Serialize;

/// Robots, on places of the files' own size.
const TEAMS: [u32; 5] = [1, 2, 4, 8, 16];
const TEAMS_QUICK: [u32; 2] = [2, 8];
/// Cells to a side of the files' own places, with the rim.
const SIDE: u32 = 100;
/// A larger place, and robots on it; the scenes that there are of it.
const SIDE_LARGE: u32 = 200;
const SIDE_LARGE_QUICK: u32 = 112;
const TEAMS_LARGE: [u32; 2] = [4, 8];
const SCENES_LARGE: [&str; 2] = [SCENES[0], SCENES[1]];

/// So many robots on a place of such a size.
#[derive(Clone, Debug, Serialize)]
pub struct ExploreTeam {
    /// The scene's file, without its ending.
    pub scene: String,
    /// Cells to a side.
    pub side_cells: u32,
    /// Robots.
    pub robots: u32,
    /// Method by method.
    pub rows: Vec<ExploreTeamRow>,
}

/// A method with so many robots.
#[derive(Clone, Debug, Serialize)]
pub struct ExploreTeamRow {
    /// The method.
    pub row: &'static str,
    /// Runs that ended with nothing left.
    pub done: usize,
    /// Steps to 96 %.
    pub steps_96: Option<Spread>,
    /// Steps to the end.
    pub steps_finish: Option<Spread>,
    /// Run by run, in the order of seeds.
    pub runs: Vec<ExploreFigures>,
}

/// A team that is to be measured.
pub(super) struct Team<'a> {
    scene: &'a Scene,
    side_cells: u32,
    robots: u32,
    rows: Vec<Row>,
}

/// Team sizes, or larger places.
pub(super) fn teams(plan: &Plan, large: bool) -> Vec<Team<'_>> {
    let rows: Vec<Row> = principal().into_iter().filter(|row| !plan.quick || row.name != "MinPos, eq. 9").collect();
    let robots: &[u32] = match (large, plan.quick) {
        (false, false) => &TEAMS,
        (false, true) => &TEAMS_QUICK,
        (true, quick) => {
            if quick {
                &TEAMS_LARGE[1..]
            } else {
                &TEAMS_LARGE
            }
        }
    };
    let side_cells = match (large, plan.quick) {
        (false, _) => SIDE,
        (true, false) => SIDE_LARGE,
        (true, true) => SIDE_LARGE_QUICK,
    };
    let there = |scene: &&Scene| !large || SCENES_LARGE.contains(&scene.name().as_str());
    let scenes = plan.scenes.iter().filter(there);
    let of = |scene| {
        robots.iter().map(|robots| Team { scene, side_cells, robots: *robots, rows: rows.clone() }).collect::<Vec<_>>()
    };
    scenes.flat_map(of).collect()
}

impl<'a> Team<'a> {
    pub(super) fn cases(&self) -> impl Iterator<Item = Case<'a>> {
        let mut base = vec![format!("fleet[0].count={}", self.robots)];
        if self.side_cells != SIDE {
            base.extend(sized(&self.scene.name(), self.side_cells));
        }
        let scene = self.scene;
        self.rows.clone().into_iter().map(move |row| Case { base: base.clone(), ..Case::of(scene, row) })
    }

    /// What came out, of each of [`Self::cases`].
    pub(super) fn line(&self, runs: Vec<Vec<ExploreFigures>>) -> ExploreTeam {
        let rows = self.rows.iter().zip(runs).map(|(row, runs)| team_row(row.name, runs)).collect();
        ExploreTeam { scene: self.scene.name(), side_cells: self.side_cells, robots: self.robots, rows }
    }
}

/// Measure them all.
pub(super) fn measure(plan: &Plan, large: bool, on_run: &(dyn Fn() + Sync)) -> anyhow::Result<Vec<ExploreTeam>> {
    let teams = teams(plan, large);
    let cases: Vec<Case<'_>> = teams.iter().flat_map(Team::cases).collect();
    let mut runs = plan.run_all(&cases, Case::run, on_run)?.into_iter();
    Ok(teams.iter().map(|team| team.line(runs.by_ref().take(team.rows.len()).collect())).collect())
}

fn team_row(row: &'static str, runs: Vec<ExploreFigures>) -> ExploreTeamRow {
    let steps = |of: fn(&ExploreFigures) -> Option<u32>| {
        Spread::of_numbers(runs.iter().filter_map(of).map(f64::from), Worst::Largest)
    };
    ExploreTeamRow {
        row,
        done: runs.iter().filter(|run| is_done(run)).count(),
        steps_96: steps(|run| run.steps_96),
        steps_finish: steps(|run| run.steps_finish),
        runs,
    }
}
