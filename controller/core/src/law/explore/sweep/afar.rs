//! Where to go when little is near: to where most is left for the way, and for those who are there before.
//!
//! **In**: the map, everybody's cell and target. **Out**: the frontier cell to go to, and what going there brings.
//!
//! **Idea**: each unknown cell belongs to the frontier cell from which the fewest steps lead to it, and frontier
//! cells to square tiles of the map. A tile with `m` cells that is `d` steps away brings `m / (d + m / r)` cells a
//! step if `r` are seen in a step once one is there: a large one is worth a journey, a small one only a few steps. So
//! nobody follows another for the crumbs beside it while half of the place lies elsewhere.
//!
//! - *Others are there before*: what the nearest other sees until one arrives is not left; of the rest half.
//! - *Others go there*: a tile with the target of another counts half.
//!
//! **Cost**: two waves over the known cells, one as deep as `DEPTH` into the unknown ones; only when little is near.
//!
//! **Cannot solve**: that several robots go far together, if all that is left is far from all of them.

use super::super::view::View;
use crate::map::{Board, Field, Known, Unknowns};

/// Cells to a side of a tile: two robots have something to do in one that borders open ground.
const TILE: usize = 8;
/// How deep into the unknown a tile's cells are counted, steps.
const DEPTH: u32 = 16;
/// Cells that a robot sees in a step, once it is where something is left: between straight (5) and diagonal lanes (9).
pub(super) const RATE: f64 = 6.0;
/// More than this many cells are never the reason to go farther: they last for a journey back.
const CELLS_MAX: f64 = 300.0;
/// A tile with nothing left for one counts this much, so that somebody goes there in the end.
const CELLS_MIN: f64 = 0.01;
/// What is left for one who comes later.
const LATE_SHARE: f64 = 0.5;
/// What is left where another goes.
const CLAIMED_SHARE: f64 = 0.5;
const NOWHERE: u32 = u32::MAX;

/// A tile as one sees it.
#[derive(Clone, Copy, Debug)]
struct Tile {
    cells: u32,
    /// The nearest frontier cell of it, and the steps to it.
    nearest: usize,
    steps: u32,
    /// Steps of the nearest other robot.
    others_steps: u32,
    claimed: bool,
}

impl Tile {
    const EMPTY: Self = Self { cells: 0, nearest: 0, steps: NOWHERE, others_steps: NOWHERE, claimed: false };

    /// Cells a step, on the way and there.
    fn rate(&self) -> f64 {
        let mut cells = f64::from(self.cells);
        if self.others_steps < self.steps {
            cells = (cells - RATE * f64::from(self.steps - self.others_steps)) * LATE_SHARE;
        }
        if self.claimed {
            cells *= CLAIMED_SHARE;
        }
        let cells = cells.clamp(CELLS_MIN, CELLS_MAX);
        cells / (f64::from(self.steps) + cells / RATE)
    }
}

/// Finds it; keeps nothing but memory.
#[derive(Clone, Debug, Default)]
pub(super) struct Afar {
    others: Field,
    tiles: Vec<Tile>,
    /// The tile of a frontier or unknown cell.
    tile_of: Vec<u32>,
    queue: Vec<usize>,
}

impl Afar {
    /// The frontier cell to go to and the cells a step that this brings; none if no frontier cell can be reached.
    /// `field` then has the ways to all of them, over what is known to be free.
    pub(super) fn best(&mut self, view: &View<'_>, field: &mut Field) -> Option<(usize, f64)> {
        let board = view.board;
        field.spread(board, view.at(), Unknowns::Solid);
        self.others.spread_from(board, view.others().map(|(_, mate)| mate.at), Unknowns::Solid);
        self.collect(board, field);
        self.count(board);
        for target in view.others().filter_map(|(_, mate)| mate.target) {
            self.tiles[tile(board, target)].claimed = true;
        }
        let mut best: Option<(usize, f64)> = None;
        for tile in self.tiles.iter().filter(|tile| tile.steps != NOWHERE) {
            let rate = tile.rate();
            if best.is_none_or(|(_, least)| rate > least) {
                best = Some((tile.nearest, rate));
            }
        }
        best
    }

    /// Frontier cells, tile by tile.
    fn collect(&mut self, board: &Board, field: &Field) {
        self.tiles.clear();
        self.tiles.resize(board.columns().div_ceil(TILE) * board.rows().div_ceil(TILE), Tile::EMPTY);
        self.tile_of.clear();
        self.tile_of.resize(board.count(), NOWHERE);
        self.queue.clear();
        for cell in board.frontier() {
            let Some(steps) = field.steps(cell).filter(|steps| *steps > 0) else { continue };
            let at = tile(board, cell);
            self.tile_of[cell] = at as u32;
            self.queue.push(cell);
            let tile = &mut self.tiles[at];
            if steps < tile.steps {
                (tile.nearest, tile.steps) = (cell, steps);
            }
            tile.others_steps = tile.others_steps.min(self.others.steps(cell).unwrap_or(NOWHERE));
        }
    }

    /// Unknown cells are counted for the tile of the nearest frontier cell.
    fn count(&mut self, board: &Board) {
        let mut first = 0;
        for _ in 0..DEPTH {
            let end = self.queue.len();
            for next in first..end {
                let cell = self.queue[next];
                let tile = self.tile_of[cell];
                for other in board.neighbours(cell) {
                    if board.at(other) == Known::Unknown && self.tile_of[other] == NOWHERE {
                        self.tile_of[other] = tile;
                        self.tiles[tile as usize].cells += 1;
                        self.queue.push(other);
                    }
                }
            }
            first = end;
        }
    }
}

fn tile(board: &Board, cell: usize) -> usize {
    let (column, row) = (cell % board.columns(), cell / board.columns());
    row / TILE * board.columns().div_ceil(TILE) + column / TILE
}
