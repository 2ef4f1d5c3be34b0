//! Cells over the place, which walls are near each, and between which neighbours one may pass.
//!
//! **In**: walls (world frame, metres), corners of the place, distance to keep. **Out**: for every cell the walls that
//! can matter to somebody in it, how far off the next cell with such walls is, and a bit for each of its eight
//! neighbours that can be reached straight from centre to centre.
//!
//! **Idea**: a wall is listed in every cell whose centre is within `keep_m` and [`NEAR_CELLS`] of it. Whoever looks
//! along a way in steps of one cell then finds all walls that the way comes too near to, and may jump over open floor.

use crate::avoid::Capsule;
use drover_contract::Vec2;

/// More cells than this are not made: the cells become larger instead.
pub(super) const CELLS_MAX: f64 = 4e6;
/// By how much the cells grow at a time.
const COARSER: f64 = 1.05;
/// Half a step along a way, and half a cell's diagonal from there to its centre: sqrt(1/2) + 1/2, rounded up.
const NEAR_CELLS: f64 = 1.208;
/// Neighbours of a cell counter-clockwise from the east; the opposite one is four places on.
pub(super) const NEIGHBOURS: [(isize, isize); 8] =
    [(1, 0), (1, 1), (0, 1), (-1, 1), (-1, 0), (-1, -1), (0, -1), (1, -1)];

/// Bits of the three neighbours on a side.
const EAST: u8 = 0b1000_0011;
const NORTH: u8 = 0b0000_1110;
const WEST: u8 = 0b0011_1000;
const SOUTH: u8 = 0b1110_0000;

/// Square cells in rows from the south-west; a cell is named by its place in the row-wise list.
#[derive(Clone, Debug)]
pub(super) struct Grid {
    low_w: Vec2,
    pub(super) cell_m: f64,
    pub(super) columns: usize,
    pub(super) rows: usize,
}

impl Grid {
    /// Cells over a box and a strip of `keep_m` and two cells around it, in which no wall is near any place: one may
    /// walk there. Larger cells than `cell_m` where there would be too many.
    pub(super) fn over(low_w: Vec2, high_w: Vec2, keep_m: f64, cell_m: f64) -> Self {
        let counts = |cell_m: f64| ((high_w - low_w) / cell_m).add_scalar(2.0 * keep_m / cell_m + 4.0).map(f64::ceil);
        let mut cell_m = cell_m;
        while counts(cell_m).product() > CELLS_MAX {
            cell_m *= COARSER;
        }
        let counts = counts(cell_m);
        let low_w = low_w.add_scalar(-keep_m - 2.0 * cell_m);
        Self { low_w, cell_m, columns: counts.x as usize, rows: counts.y as usize }
    }

    pub(super) fn cells(&self) -> usize {
        self.columns * self.rows
    }

    /// The part of it between two places, which may be outside of it.
    pub(super) fn patch(&self, low_w: Vec2, high_w: Vec2) -> Patch {
        let ((west, south), (east, north)) = (self.place_of(low_w), self.place_of(high_w));
        Patch { west, south, columns: east - west + 1, rows: north - south + 1 }
    }

    /// All of it.
    pub(super) fn whole(&self) -> Patch {
        Patch { west: 0, south: 0, columns: self.columns, rows: self.rows }
    }

    /// Column and row of the cell around a place, or of the nearest cell to a place outside.
    pub(super) fn place_of(&self, at_w: Vec2) -> (usize, usize) {
        let at = (at_w - self.low_w) / self.cell_m; // `as` saturates: what is south or west of all is in cell 0
        ((at.x as usize).min(self.columns - 1), (at.y as usize).min(self.rows - 1))
    }

    pub(super) fn cell_of(&self, at_w: Vec2) -> usize {
        let (column, row) = self.place_of(at_w);
        row * self.columns + column
    }

    /// The centre of the cell in a column and a row, world frame.
    pub(super) fn centre_w(&self, column: usize, row: usize) -> Vec2 {
        self.low_w + Vec2::new(column as f64 + 0.5, row as f64 + 0.5) * self.cell_m
    }

    /// How far a place is outside of all cells, metres; 0 within.
    pub(super) fn outside_m(&self, at_w: Vec2) -> f64 {
        let high_w = self.low_w + Vec2::new(self.columns as f64, self.rows as f64) * self.cell_m;
        let beyond = (self.low_w - at_w).sup(&(at_w - high_w));
        beyond.x.max(beyond.y).max(0.0)
    }

    /// Cells whose centre is within `reach_m` of a wall, row by row: only the part of each row is looked at that the
    /// wall can reach.
    fn cells_near(&self, wall: &Capsule, reach_m: f64, mut found: impl FnMut(usize)) {
        let reach = Vec2::repeat(reach_m + wall.radius_m);
        let (_, first) = self.place_of(wall.a_w.inf(&wall.b_w) - reach);
        let (_, last) = self.place_of(wall.a_w.sup(&wall.b_w) + reach);
        for row in first..=last {
            let north_m = self.centre_w(0, row).y;
            let Some((west_w, east_w)) = within_rows(wall, north_m - reach.y, north_m + reach.y) else { continue };
            let (west, _) = self.place_of(Vec2::new(west_w - reach.x, north_m));
            let (east, _) = self.place_of(Vec2::new(east_w + reach.x, north_m));
            let near = |column: &usize| wall.distance_m(self.centre_w(*column, row)) < reach_m;
            (west..=east).filter(near).for_each(|column| found(row * self.columns + column));
        }
    }
}

/// West and east end of the part of a wall's segment that lies between two lines of equal y.
fn within_rows(wall: &Capsule, south_m: f64, north_m: f64) -> Option<(f64, f64)> {
    let along = wall.b_w - wall.a_w;
    let (mut first, mut last) = (0.0_f64, 1.0_f64);
    if along.y.abs() > 1e-12 {
        let (one, other) = ((south_m - wall.a_w.y) / along.y, (north_m - wall.a_w.y) / along.y);
        first = first.max(one.min(other));
        last = last.min(one.max(other));
    }
    let (from, to) = (wall.a_w.x + along.x * first, wall.a_w.x + along.x * last);
    (first <= last).then_some((from.min(to), from.max(to)))
}

/// A rectangle of cells of a grid.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Patch {
    pub(super) west: usize,
    pub(super) south: usize,
    pub(super) columns: usize,
    pub(super) rows: usize,
}

impl Patch {
    pub(super) fn cells(&self) -> usize {
        self.columns * self.rows
    }

    /// Column and row in the grid of a cell of the patch.
    pub(super) fn place_of(&self, cell: usize) -> (usize, usize) {
        (self.west + cell % self.columns, self.south + cell / self.columns)
    }

    /// Of the moves of a whole grid those that stay in the patch.
    pub(super) fn moves(&self, of_grid: &[u8], columns: usize) -> Vec<u8> {
        let mut moves = Vec::with_capacity(self.cells());
        for row in self.south..self.south + self.rows {
            let first = row * columns + self.west;
            moves.extend_from_slice(&of_grid[first..first + self.columns]);
        }
        (0..self.columns).for_each(|column| moves[column] &= !SOUTH);
        (0..self.columns).for_each(|column| moves[self.cells() - 1 - column] &= !NORTH);
        (0..self.rows).for_each(|row| moves[row * self.columns] &= !WEST);
        (0..self.rows).for_each(|row| moves[(row + 1) * self.columns - 1] &= !EAST);
        moves
    }

    /// Cells of the patch at `ring` steps around the cell of the grid in a column and a row.
    pub(super) fn ring(&self, around: (usize, usize), ring: usize) -> impl Iterator<Item = usize> + use<> {
        let (patch, ring) = (*self, ring as isize);
        let centre = (around.0 as isize - self.west as isize, around.1 as isize - self.south as isize);
        (-ring..=ring).flat_map(move |up| {
            let stride = if up.abs() == ring { 1 } else { (2 * ring).max(1) };
            (-ring..=ring)
                .step_by(stride as usize)
                .filter_map(move |right| patch.cell_at(centre.0 + right, centre.1 + up))
        })
    }

    fn cell_at(&self, column: isize, row: isize) -> Option<usize> {
        let (column, row) = (usize::try_from(column).ok()?, usize::try_from(row).ok()?);
        (column < self.columns && row < self.rows).then_some(row * self.columns + column)
    }
}

/// Which walls are near each cell: `walls[starts[cell]..starts[cell + 1]]`.
#[derive(Clone, Debug)]
pub(super) struct Near {
    starts: Vec<u32>,
    walls: Vec<u32>,
    /// Rings around a cell that have no walls in their lists, itself included; 255 for more.
    pub(super) open_rings: Vec<u8>,
}

impl Near {
    pub(super) fn new(grid: &Grid, walls: &[Capsule], keep_m: f64) -> Self {
        let mut pairs: Vec<(u32, u32)> = Vec::new();
        for (wall, index) in walls.iter().zip(0_u32..) {
            grid.cells_near(wall, keep_m + NEAR_CELLS * grid.cell_m, |cell| pairs.push((cell as u32, index)));
        }
        pairs.sort_unstable();
        let mut starts = vec![0_u32; grid.cells() + 1];
        pairs.iter().for_each(|(cell, _)| starts[*cell as usize + 1] += 1);
        (1..starts.len()).for_each(|cell| starts[cell] += starts[cell - 1]);
        let open_rings = open_rings(grid, &starts);
        Self { starts, walls: pairs.into_iter().map(|(_, wall)| wall).collect(), open_rings }
    }

    pub(super) fn of(&self, cell: usize) -> &[u32] {
        &self.walls[self.starts[cell] as usize..self.starts[cell + 1] as usize]
    }
}

/// Steps of a king from each cell to the next with walls in its list, by one sweep there and one back.
fn open_rings(grid: &Grid, starts: &[u32]) -> Vec<u8> {
    let listed = |cell: usize| starts[cell] < starts[cell + 1];
    let mut rings: Vec<u8> = (0..grid.cells()).map(|cell| if listed(cell) { 0 } else { u8::MAX }).collect();
    let mut sweep = |cell: usize, steps: &[(isize, isize)]| {
        let (column, row) = (cell % grid.columns, cell / grid.columns);
        for (right, up) in steps {
            let (Some(column), Some(row)) = (column.checked_add_signed(*right), row.checked_add_signed(*up)) else {
                continue;
            };
            if column < grid.columns && row < grid.rows {
                rings[cell] = rings[cell].min(rings[row * grid.columns + column].saturating_add(1));
            }
        }
    };
    (0..grid.cells()).for_each(|cell| sweep(cell, &[(-1, 0), (-1, -1), (0, -1), (1, -1)]));
    (0..grid.cells()).rev().for_each(|cell| sweep(cell, &[(1, 0), (1, 1), (0, 1), (-1, 1)]));
    rings
}
