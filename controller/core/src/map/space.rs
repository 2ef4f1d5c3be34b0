//! Where a round body may be: the map with everything occupied grown by the body's radius and what it keeps.
//!
//! A cell too near to something occupied counts as occupied, whatever is known of it: a body cannot go there, so it
//! need not be looked at either. What is left unknown is what a body could enter, and a frontier cell is one that a
//! body can stand on and go on from. Kept cell by cell as the map changes.

use super::{Board, Known, Lattice};

/// The places of a body's centre.
#[derive(Clone, Debug)]
pub struct Space {
    board: Board,
    /// Which cells count as occupied around them.
    solid: Vec<bool>,
    /// How many occupied cells are too near to each cell, and how many are near.
    tight: Counts,
    near: Counts,
}

#[derive(Clone, Debug)]
struct Counts {
    counts: Vec<u16>,
    offsets: Vec<[i32; 2]>,
}

impl Counts {
    fn new(lattice: &Lattice, radius_m: f64) -> Self {
        let reach = (radius_m / lattice.cell_m()).ceil() as i32;
        let within = |offset: &[i32; 2]| {
            let [x, y] = offset.map(|cells| f64::from(cells) * lattice.cell_m());
            x * x + y * y <= radius_m * radius_m
        };
        let square = (-reach..=reach).flat_map(|dy| (-reach..=reach).map(move |dx| [dx, dy]));
        Self { counts: vec![0; lattice.columns() * lattice.rows()], offsets: square.filter(within).collect() }
    }

    /// One more, or one less, occupied cell; who is told are the cells whose count is now, or was, none.
    fn change(&mut self, board: &Board, cell: usize, more: bool, mut visit: impl FnMut(usize)) {
        let [column, row] = board.place(cell);
        for [dx, dy] in &self.offsets {
            let Some(other) = board.cell([column + dx, row + dy]) else { continue };
            let count = &mut self.counts[other];
            let before = *count;
            *count = if more { before.saturating_add(1) } else { before.saturating_sub(1) };
            if (before == 0) != (*count == 0) {
                visit(other);
            }
        }
    }
}

impl Space {
    /// Nothing is known. The body's centre is to keep `keep_m` from the middle of every occupied cell, and likes to
    /// keep `calm_m`.
    #[must_use]
    pub fn new(lattice: &Lattice, keep_m: f64, calm_m: f64) -> Self {
        Self {
            board: Board::new(lattice.columns(), lattice.rows()),
            solid: vec![false; lattice.columns() * lattice.rows()],
            tight: Counts::new(lattice, keep_m),
            near: Counts::new(lattice, calm_m),
        }
    }

    /// Unknown, free, or occupied for a body's centre.
    #[must_use]
    pub const fn board(&self) -> &Board {
        &self.board
    }

    /// Whether a body would rather not be there.
    #[must_use]
    pub fn is_near(&self, cell: usize) -> bool {
        self.near.counts[cell] > 0
    }

    /// Take in that something else is known of a cell than before.
    pub fn learn(&mut self, map: &Board, cell: usize) {
        let solid = map.at(cell) == Known::Occupied;
        if std::mem::replace(&mut self.solid[cell], solid) != solid {
            let mut turned = Vec::new();
            self.tight.change(map, cell, solid, |other| turned.push(other));
            self.near.change(map, cell, solid, |_| {});
            turned.into_iter().for_each(|other| self.settle(map, other));
        }
        self.settle(map, cell);
    }

    fn settle(&mut self, map: &Board, cell: usize) {
        let known = if self.tight.counts[cell] > 0 { Known::Occupied } else { map.at(cell) };
        self.board.set(cell, known);
    }
}

#[cfg(test)]
mod tests {
    use super::Space;
    use crate::map::{Board, Known, Lattice};
    use drover_contract::Vec2;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn what_is_kept_is_what_distances_say(
            said in prop::collection::vec((0_usize..120, any::<bool>()), 0..150),
        ) {
            let lattice = Lattice::over(Vec2::zeros(), Vec2::new(3.0, 2.5), 0.25);
            let (mut map, mut space) = (Board::new(12, 10), Space::new(&lattice, 0.45, 0.8));
            for (cell, occupied) in said {
                let known = if occupied { Known::Occupied } else { Known::Free };
                if map.learn(cell, known) {
                    space.learn(&map, cell);
                }
            }
            let gap_m = |cell: usize| {
                let occupied = (0..120).filter(|other| map.at(*other) == Known::Occupied);
                let gap_m = |other| (lattice.centre_w(cell) - lattice.centre_w(other)).norm();
                occupied.map(gap_m).fold(f64::INFINITY, f64::min)
            };
            for cell in 0..120 {
                let expected = if gap_m(cell) <= 0.45 { Known::Occupied } else { map.at(cell) };
                prop_assert_eq!(space.board().at(cell), expected);
                prop_assert_eq!(space.is_near(cell), gap_m(cell) <= 0.8);
            }
        }
    }
}
