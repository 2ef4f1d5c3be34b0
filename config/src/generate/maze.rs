//! A maze of cells with walls between.

use super::chance::Chance;
use super::floor::Floor;
use super::tree::openings;
use super::{Misfit, Size, bays, bays_that_fit, mm};

/// Most cells: their outlines would have too many corners anyway.
const CELLS_MAX: usize = 20_000;

/// As many cells as fit, joined to a tree: between any two there is one way, but for the loops.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Maze {
    /// Least width of a cell, metres; what is left over widens all cells.
    pub(crate) passage_m: f64,
    /// Thickness of a wall, metres.
    pub(crate) wall_m: f64,
    /// Share of the walls that the tree leaves, 0 to 1, to be opened too.
    pub(crate) loops: f64,
}

impl Maze {
    pub(super) fn floor(&self, size: Size, chance: &mut Chance) -> Result<Floor, Misfit> {
        let (passage, wall) = (mm(self.passage_m), mm(self.wall_m));
        let columns = bays_that_fit(size.width, passage, wall);
        let rows = bays_that_fit(size.height, passage, wall);
        let cells = columns.saturating_mul(rows);
        if !(2..=CELLS_MAX).contains(&cells) {
            let found = format!("{} m, which makes {columns} x {rows} cells", self.passage_m);
            let expected = format!("2 to {CELLS_MAX} cells in width_m x height_m, with walls of wall_m between");
            return Err(Misfit::new("passage_m", found, expected, "choose another width of the passages"));
        }
        let (xs, ys) = (bays(size.width, columns, wall), bays(size.height, rows, wall));
        let mut floor = Floor::solid(size);
        for y in &ys {
            xs.iter().for_each(|x| floor.carve(*x, *y));
        }
        for opening in openings(columns, rows, self.loops, chance) {
            let [column, row] = opening.cell;
            if opening.east {
                floor.carve((xs[column].1, xs[column + 1].0), ys[row]);
            } else {
                floor.carve(xs[column], (ys[row].1, ys[row + 1].0));
            }
        }
        Ok(floor)
    }
}
