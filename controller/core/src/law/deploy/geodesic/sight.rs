//! Whether one may go straight from here to there: exact, by the walls that are near the way.

use super::grid::{Grid, NEIGHBOURS, Near};
use crate::avoid::Capsule;
use drover_contract::Vec2;

/// Rounding of a clearance must not lock in who stands exactly at the distance to keep, metres.
const ROUNDING_M: f64 = 1e-12;
/// Walls that the last cells of a way had in common are asked once.
const ASKED: usize = 4;

/// The walls with an index to find them by.
#[derive(Clone, Debug)]
pub(super) struct Sight {
    pub(super) grid: Grid,
    near: Near,
    walls: Vec<Capsule>,
    keep_m: f64,
}

impl Sight {
    pub(super) fn new(grid: Grid, walls: Vec<Capsule>, keep_m: f64) -> Self {
        Self { near: Near::new(&grid, &walls, keep_m), grid, walls, keep_m }
    }

    /// Whether the way keeps `keep_m`, at most what the index was made for.
    pub(super) fn clear(&self, from_w: Vec2, to_w: Vec2, keep_m: f64) -> bool {
        self.all_near(from_w, to_w, |wall| wall.clearance_m(from_w, to_w) >= keep_m)
    }

    /// Whether a robot may go this way: it keeps the distance, except that a wall which an end is nearer to already is
    /// only not approached.
    pub(super) fn passes(&self, from_w: Vec2, to_w: Vec2, keep_m: f64) -> bool {
        self.all_near(from_w, to_w, |wall| {
            let clearance_m = wall.clearance_m(from_w, to_w);
            clearance_m >= keep_m || clearance_m >= wall.distance_m(from_w).min(wall.distance_m(to_w)) - ROUNDING_M
        })
    }

    /// Distance from a place to the nearest wall, metres; `keep_m` if it is not less.
    pub(super) fn room_m(&self, at_w: Vec2) -> f64 {
        let near = self.near.of(self.grid.cell_of(at_w)).iter();
        near.map(|wall| self.walls[*wall as usize].distance_m(at_w)).fold(self.keep_m, f64::min)
    }

    /// Whether `allows` holds for every wall that is nearer than `keep_m` to the way (and for some that are not). In
    /// steps of one cell the lists of [`Near`] miss none; over open floor steps are as long as that is wide.
    fn all_near(&self, from_w: Vec2, to_w: Vec2, allows: impl Fn(&Capsule) -> bool) -> bool {
        let length_m = (to_w - from_w).norm();
        let unit = (to_w - from_w).try_normalize(0.0).unwrap_or_else(Vec2::zeros);
        let mut asked = [u32::MAX; ASKED];
        let mut next = 0;
        let mut along_m = 0.0;
        loop {
            let at_w = from_w + unit * f64::min(along_m, length_m);
            let cell = self.grid.cell_of(at_w);
            for wall in self.near.of(cell) {
                if !asked.contains(wall) {
                    if !allows(&self.walls[*wall as usize]) {
                        return false;
                    }
                    asked[next] = *wall;
                    next = (next + 1) % ASKED;
                }
            }
            if along_m >= length_m || !length_m.is_finite() {
                return length_m.is_finite();
            }
            let open = f64::from(self.near.open_rings[cell].max(1));
            along_m += (open * self.grid.cell_m).max(self.grid.outside_m(at_w));
        }
    }

    /// For each cell a bit for each neighbour that one may pass to from centre to centre, numbered as in
    /// [`NEIGHBOURS`].
    pub(super) fn moves(&self) -> Vec<u8> {
        let mut moves = vec![0_u8; self.grid.cells()];
        for row in 0..self.grid.rows {
            for column in 0..self.grid.columns {
                let cell = row * self.grid.columns + column;
                // East, north-east, north, north-west: the other four are the same moves from the other end.
                for (direction, (right, up)) in NEIGHBOURS.iter().enumerate().take(4) {
                    let (Some(east), north) = (column.checked_add_signed(*right), row + *up as usize) else { continue };
                    let inside = east < self.grid.columns && north < self.grid.rows;
                    if inside && self.may_move(cell, (column, row), (east, north)) {
                        moves[cell] |= 1 << direction;
                        moves[north * self.grid.columns + east] |= 1 << (direction + 4);
                    }
                }
            }
        }
        moves
    }

    fn may_move(&self, cell: usize, from: (usize, usize), to: (usize, usize)) -> bool {
        self.near.open_rings[cell] > 1
            || self.clear(self.grid.centre_w(from.0, from.1), self.grid.centre_w(to.0, to.1), self.keep_m)
    }
}
