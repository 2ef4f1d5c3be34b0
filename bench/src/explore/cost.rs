//! What a decision costs: choosing and the way there, while a team maps a hall with obstacles, on one thread.

use super::rows::{SCENES, sized, timed};
use crate::contest::{load, one_thread};
use drover_config::{Behaviour, Swarm};
use drover_swarm::CellSwarm;
use serde::Serialize;
use std::path::Path;

/// Sides of the board, cells, and robots on it.
const BOARDS: [(u32, u32); 6] = [(100, 4), (100, 8), (200, 4), (200, 8), (500, 4), (500, 8)];
/// Decisions that are timed, about and at most: of larger places that is the beginning.
const DECISIONS_MAX: usize = 4000;

/// Decisions of one method on one board.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ExploreCostRow {
    /// The method.
    pub row: &'static str,
    /// Cells to a side.
    pub side_cells: u32,
    /// Robots.
    pub robots: u32,
    /// Decisions that were timed.
    pub decisions: usize,
    /// The median, microseconds.
    pub plan_us_p50: f64,
    /// One in a hundred takes longer than this, microseconds.
    pub plan_us_p99: f64,
}

/// Measure, with the world of `file` at other sizes.
pub(super) fn measure(file: &Path, quick: bool) -> anyhow::Result<Vec<ExploreCostRow>> {
    let boards = if quick { &BOARDS[..1] } else { &BOARDS[..] };
    let mut rows = Vec::new();
    for (side, robots) in boards {
        let swarm = scene(file, *side, *robots)?;
        for (row, explore) in timed() {
            let swarm = Swarm { behaviour: Behaviour::Explore(explore), ..swarm.clone() };
            rows.push(one_thread()?.install(|| cost(row, &swarm, *side)));
        }
    }
    Ok(rows)
}

fn scene(file: &Path, side: u32, robots: u32) -> anyhow::Result<Swarm> {
    let mut set = sized(SCENES[0], side);
    set.push(format!("fleet[0].count={robots}"));
    load(file, set.iter().map(String::as_str))
}

fn cost(row: &'static str, swarm: &Swarm, side_cells: u32) -> ExploreCostRow {
    let Behaviour::Explore(explore) = &swarm.behaviour else { unreachable!("made so above") };
    let mut trial = CellSwarm::new(swarm, explore).timed();
    // Bodies need not glide: what is timed is what the team decides.
    while trial.decisions_us().len() < DECISIONS_MAX && trial.round() {}
    let mut taken_us = trial.decisions_us().to_vec();
    taken_us.sort_by(f64::total_cmp);
    let at = |share: f64| taken_us[((taken_us.len() - 1) as f64 * share) as usize];
    ExploreCostRow {
        row,
        side_cells,
        robots: swarm.robots.len() as u32,
        decisions: taken_us.len(),
        plan_us_p50: at(0.5),
        plan_us_p99: at(0.99),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_board_is_a_place_with_its_robots() {
        let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../config/swarms/explore_random.toml");
        for (side, robots) in BOARDS {
            let swarm = scene(&file, side, robots).unwrap_or_else(|error| panic!("{side} cells: {error:#}"));
            assert_eq!(swarm.robots.len(), robots as usize);
        }
    }
}
