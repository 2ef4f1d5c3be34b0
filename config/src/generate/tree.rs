//! Which neighbours among cells are joined: a spanning tree, and perhaps some more.

use super::chance::Chance;

/// A wall between two neighbours that is to be opened.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Opening {
    /// The cell to the west or to the south: column and row.
    pub(super) cell: [usize; 2],
    /// Whether the other one is to the east of it, not to the north.
    pub(super) east: bool,
}

/// Openings that join all cells: in any order, each wall is opened that parts two groups (Kruskal 1956); of the others
/// then the share `loops`.
pub(super) fn openings(columns: usize, rows: usize, loops: f64, chance: &mut Chance) -> Vec<Opening> {
    let cells = (0..rows).flat_map(|y| (0..columns).map(move |x| [x, y]));
    let mut walls: Vec<Opening> = cells
        .flat_map(|cell| [true, false].map(|east| Opening { cell, east }))
        .filter(|wall| if wall.east { wall.cell[0] + 1 < columns } else { wall.cell[1] + 1 < rows })
        .collect();
    chance.shuffle(&mut walls);
    let mut groups = Groups((0..columns * rows).collect());
    let (tree, rest): (Vec<Opening>, Vec<Opening>) = walls.into_iter().partition(|wall| {
        let first = wall.cell[1] * columns + wall.cell[0];
        groups.join(first, if wall.east { first + 1 } else { first + columns })
    });
    let extra = libm::floor(rest.len() as f64 * loops) as usize;
    tree.into_iter().chain(rest.into_iter().take(extra)).collect()
}

/// Groups of cells: each cell points to another one of its group, the group's first cell to itself.
struct Groups(Vec<usize>);

impl Groups {
    fn first(&mut self, mut cell: usize) -> usize {
        while self.0[cell] != cell {
            self.0[cell] = self.0[self.0[cell]]; // the way is halved for whoever comes next
            cell = self.0[cell];
        }
        cell
    }

    /// Makes two groups one; whether they were two.
    fn join(&mut self, a: usize, b: usize) -> bool {
        let (a, b) = (self.first(a), self.first(b));
        self.0[a.max(b)] = a.min(b);
        a != b
    }
}

#[cfg(test)]
mod tests {
    use super::{Chance, openings};

    #[test]
    fn a_tree_has_one_opening_less_than_cells_and_loops_add_their_share() {
        assert_eq!(openings(6, 4, 0.0, &mut Chance::new(1)).len(), 23);
        assert_eq!(openings(6, 4, 1.0, &mut Chance::new(1)).len(), 5 * 4 + 6 * 3);
    }
}
