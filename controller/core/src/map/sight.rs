//! What a robot on a cell sees: a square of cells around it, as far as nothing stands in between.
//!
//! The paper replaces the circle of radius r_c by the square inside it (Wu 2008, section 2): r_c = 4 gives half a side
//! of 2.83, in cells |dx|, |dy| <= 2. On the straight line to a cell, a step along the longer axis passes one cell, or
//! between two; it is blocked if all that it passes are occupied. So sight is mutual. The first occupied cell is seen.

use super::Board;
use core::ops::Range;

/// A square with the cells that each line of sight passes.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Sight {
    reach: i32,
    rays: Vec<Ray>,
    /// What rays pass, one cell (twice) or two at each step, ray by ray.
    passes: Vec<[[i32; 2]; 2]>,
}

#[derive(Clone, Debug, PartialEq, Eq)]
struct Ray {
    to: [i32; 2],
    passes: Range<usize>,
}

impl Sight {
    /// Everything within `reach` cells to each side.
    #[must_use]
    pub fn new(reach: u8) -> Self {
        let reach = i32::from(reach);
        let mut sight = Self { reach, rays: Vec::new(), passes: Vec::new() };
        for to in (-reach..=reach).flat_map(|dy| (-reach..=reach).map(move |dx| [dx, dy])) {
            let first = sight.passes.len();
            sight.passes.extend(passed(to));
            sight.rays.push(Ray { to, passes: first..sight.passes.len() });
        }
        sight
    }

    /// How far it goes to each side, cells.
    #[must_use]
    pub const fn reach(&self) -> i32 {
        self.reach
    }

    /// Every cell that is seen from `from`, itself too, where `blocks` says which cells cannot be looked through.
    pub fn look(&self, board: &Board, from: usize, blocks: impl Fn(usize) -> bool, seen: impl FnMut(usize)) {
        let [column, row] = board.place(from);
        let (columns, rows) = (board.columns() as i32, board.rows() as i32);
        let within = |at: i32, count: i32| at >= self.reach && at + self.reach < count;
        if within(column, columns) && within(row, rows) {
            // Far from the rim every cell is there, which is most of the work of all methods.
            self.cast(|[dx, dy]| Some((from as i32 + dy * columns + dx) as usize), blocks, seen);
        } else {
            self.cast(|[dx, dy]| board.cell([column + dx, row + dy]), blocks, seen);
        }
    }

    fn cast(
        &self,
        at: impl Fn([i32; 2]) -> Option<usize>,
        blocks: impl Fn(usize) -> bool,
        mut seen: impl FnMut(usize),
    ) {
        for ray in &self.rays {
            let Some(cell) = at(ray.to) else { continue };
            let blocked = |pair: &[[i32; 2]; 2]| pair.iter().all(|step| at(*step).is_none_or(&blocks));
            if !self.passes[ray.passes.clone()].iter().any(blocked) {
                seen(cell);
            }
        }
    }
}

/// The cells between the origin and `to`, step by step along the longer axis: the nearest to the line, and if two are
/// equally near, both.
fn passed(to: [i32; 2]) -> Vec<[[i32; 2]; 2]> {
    let length = to[0].abs().max(to[1].abs());
    let pair = |step: i32| {
        // Twice the distance to half a cell below and above, so that all are whole numbers.
        let low = |axis: usize| -(length - 2 * to[axis] * step).div_euclid(2 * length);
        let high = |axis: usize| (2 * to[axis] * step + length).div_euclid(2 * length);
        [[low(0), low(1)], [high(0), high(1)]]
    };
    (1..length).map(pair).collect()
}

#[cfg(test)]
mod tests {
    use super::{Sight, passed};
    use crate::map::Board;

    #[test]
    fn a_line_passes_one_cell_or_between_two() {
        assert_eq!(passed([2, 0]), [[[1, 0], [1, 0]]]);
        assert_eq!(passed([2, 2]), [[[1, 1], [1, 1]]]);
        assert_eq!(passed([2, 1]), [[[1, 0], [1, 1]]]);
        assert_eq!(passed([-2, 1]), [[[-1, 0], [-1, 1]]]);
        assert_eq!(passed([3, 1]), [[[1, 0], [1, 0]], [[2, 1], [2, 1]]]);
        assert!(passed([1, 1]).is_empty());
    }

    #[test]
    fn a_wall_hides_what_is_behind_it_and_is_seen_itself() {
        let board = Board::new(5, 5);
        let wall = |cell: usize| cell / 5 == 3; // a row north of the middle
        let mut seen = Vec::new();
        Sight::new(2).look(&board, 12, wall, |cell| seen.push(cell));
        assert_eq!(seen, (0..20).collect::<Vec<_>>());
    }

    #[test]
    fn sight_is_mutual() {
        let board = Board::new(9, 9);
        let sight = Sight::new(4);
        let blocks = |cell: usize| (cell * 7).is_multiple_of(5);
        let sees = |from: usize, to: usize| {
            let mut found = false;
            sight.look(&board, from, blocks, |cell| found |= cell == to);
            found
        };
        for (from, to) in (0..81).flat_map(|from| (0..81).map(move |to| (from, to))) {
            assert_eq!(sees(from, to), sees(to, from), "{from} {to}");
        }
    }
}
