//! Cells, each unknown, free or occupied, and from which of the free ones a step leads into the unknown.
//!
//! A cell is its index, row by row from the south-west corner. Frontier flags and the counts of known neighbours are
//! kept as cells are learnt: learning one costs its neighbourhood, asking costs nothing. An unknown cell behind the
//! corner of two occupied ones (the inside of a wall, seen from a room's corner) makes no frontier: no step leads
//! there, and nobody needs to know it.

/// What is known of a cell.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Known {
    /// Nothing.
    #[default]
    Unknown,
    /// Nothing stands there.
    Free,
    /// Something stands there.
    Occupied,
}

/// A rectangle of cells.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Board {
    columns: usize,
    rows: usize,
    cells: Vec<Known>,
    known_around: Vec<u8>,
    frontier: Vec<bool>,
    known: usize,
    free: usize,
}

impl Board {
    /// Nothing is known of `columns` x `rows` cells; at least one each.
    #[must_use]
    pub fn new(columns: usize, rows: usize) -> Self {
        let (columns, rows) = (columns.max(1), rows.max(1));
        let count = columns * rows;
        let mut board = Self {
            columns,
            rows,
            cells: vec![Known::Unknown; count],
            known_around: vec![0; count],
            frontier: vec![false; count],
            known: 0,
            free: 0,
        };
        // Beyond the rim there is nothing to learn.
        for cell in 0..count {
            board.known_around[cell] = (8 - board.neighbours(cell).count()) as u8;
        }
        board
    }

    /// Cells from west to east.
    #[must_use]
    pub const fn columns(&self) -> usize {
        self.columns
    }

    /// Cells from south to north.
    #[must_use]
    pub const fn rows(&self) -> usize {
        self.rows
    }

    /// How many cells there are.
    #[must_use]
    pub fn count(&self) -> usize {
        self.cells.len()
    }

    /// How many are known.
    #[must_use]
    pub const fn known_count(&self) -> usize {
        self.known
    }

    /// How many are known to be free.
    #[must_use]
    pub const fn free_count(&self) -> usize {
        self.free
    }

    /// Column and row of a cell.
    #[must_use]
    pub const fn place(&self, cell: usize) -> [i32; 2] {
        [(cell % self.columns) as i32, (cell / self.columns) as i32]
    }

    /// The cell at a column and row, if there is one.
    #[must_use]
    pub fn cell(&self, [column, row]: [i32; 2]) -> Option<usize> {
        let (column, row) = (usize::try_from(column).ok()?, usize::try_from(row).ok()?);
        (column < self.columns && row < self.rows).then_some(row * self.columns + column)
    }

    /// What is known of a cell.
    #[must_use]
    pub fn at(&self, cell: usize) -> Known {
        self.cells[cell]
    }

    /// Whether a cell is free and a step leads from it to an unknown one: to a side, or to a corner that is not cut.
    #[must_use]
    pub fn is_frontier(&self, cell: usize) -> bool {
        self.frontier[cell]
    }

    /// Known cells of the eight around a cell; those beyond the rim count as known.
    #[must_use]
    pub fn known_around(&self, cell: usize) -> u8 {
        self.known_around[cell]
    }

    /// All frontier cells, the lowest first.
    pub fn frontier(&self) -> impl Iterator<Item = usize> + '_ {
        (0..self.count()).filter(|cell| self.frontier[*cell])
    }

    /// The cells within so many of a cell to each side, itself among them, from the south-west on.
    pub fn square(&self, cell: usize, reach: i32) -> impl Iterator<Item = usize> + '_ {
        let [column, row] = self.place(cell);
        let places = (-reach..=reach).flat_map(move |dy| (-reach..=reach).map(move |dx| [column + dx, row + dy]));
        places.filter_map(|place| self.cell(place))
    }

    /// The cells around a cell, at sides and corners.
    pub fn neighbours(&self, cell: usize) -> impl Iterator<Item = usize> + use<> {
        let (columns, rows) = (self.columns, self.rows);
        let (column, row) = (cell % columns, cell / columns);
        let (west, east) = (column.saturating_sub(1), (column + 1).min(columns - 1));
        let (south, north) = (row.saturating_sub(1), (row + 1).min(rows - 1));
        let around = (south..=north).flat_map(move |row| (west..=east).map(move |column| row * columns + column));
        around.filter(move |other| *other != cell)
    }

    /// Take in what a cell is; whether that is news. Who says `Unknown` says nothing.
    pub fn learn(&mut self, cell: usize, known: Known) -> bool {
        known != Known::Unknown && self.set(cell, known)
    }

    /// What counts of a cell from now on, whatever was known of it; whether that is news.
    pub fn set(&mut self, cell: usize, known: Known) -> bool {
        let before = std::mem::replace(&mut self.cells[cell], known);
        if known == before {
            return false;
        }
        self.free += usize::from(known == Known::Free);
        self.free -= usize::from(before == Known::Free);
        if before == Known::Unknown || known == Known::Unknown {
            let now_known = known != Known::Unknown;
            self.known = if now_known { self.known + 1 } else { self.known - 1 };
            for other in self.neighbours(cell) {
                let around = &mut self.known_around[other];
                *around = if now_known { *around + 1 } else { *around - 1 };
            }
        }
        for other in self.neighbours(cell) {
            self.frontier[other] = self.leads_on(other);
        }
        self.frontier[cell] = self.leads_on(cell);
        true
    }

    /// Whether a step leads from a free cell into the unknown.
    fn leads_on(&self, cell: usize) -> bool {
        if self.cells[cell] != Known::Free || self.known_around[cell] >= 8 {
            return false;
        }
        let [column, row] = self.place(cell);
        let at = |place: [i32; 2]| self.cell(place).map_or(Known::Occupied, |cell| self.cells[cell]);
        let open = |place: [i32; 2]| at(place) != Known::Occupied;
        let steps = [[1, 0], [-1, 0], [0, 1], [0, -1], [1, 1], [1, -1], [-1, 1], [-1, -1]];
        steps.into_iter().any(|[dx, dy]| {
            let whole = dx == 0 || dy == 0 || (open([column + dx, row]) && open([column, row + dy]));
            whole && at([column + dx, row + dy]) == Known::Unknown
        })
    }

    /// Heap bytes held.
    #[must_use]
    pub fn bytes(&self) -> usize {
        self.cells.capacity() * size_of::<Known>() + self.known_around.capacity() + self.frontier.capacity()
    }
}

#[cfg(test)]
mod tests {
    use super::{Board, Known};
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn what_is_kept_is_what_is_counted(
            learnt in proptest::collection::vec((0_usize..35, 0_usize..3), 0..80),
        ) {
            let mut board = Board::new(7, 5);
            for (cell, known) in learnt {
                board.set(cell, [Known::Free, Known::Occupied, Known::Unknown][known]);
            }
            let known = |cell: &usize| board.at(*cell) != Known::Unknown;
            let all = || 0..board.count();
            prop_assert_eq!(board.known_count(), all().filter(known).count());
            prop_assert_eq!(board.free_count(), all().filter(|cell| board.at(*cell) == Known::Free).count());
            for cell in all() {
                let unknown = board.neighbours(cell).filter(|other| !known(other)).count();
                prop_assert_eq!(usize::from(8 - board.known_around(cell)), unknown);
                prop_assert_eq!(board.is_frontier(cell), board.leads_on(cell));
            }
        }
    }

    #[test]
    fn what_is_behind_the_corner_of_two_walls_is_no_matter() {
        let mut board = Board::new(3, 3);
        (0..8).for_each(|cell| {
            board.learn(cell, if [5, 7].contains(&cell) { Known::Occupied } else { Known::Free });
        });
        assert_eq!(board.frontier().next(), None);
        board.learn(7, Known::Free);
        assert_eq!(board.frontier().collect::<Vec<_>>(), [7]);
    }

    #[test]
    fn a_square_ends_at_the_rim() {
        let board = Board::new(4, 3);
        assert_eq!(board.square(0, 1).collect::<Vec<_>>(), [0, 1, 4, 5]);
        assert_eq!(board.square(6, 1).count(), 9);
    }

    #[test]
    fn cells_have_places_and_the_rim_has_fewer_neighbours() {
        let board = Board::new(4, 3);
        assert_eq!(board.place(6), [2, 1]);
        assert_eq!(board.cell([2, 1]), Some(6));
        assert_eq!([[-1, 0], [4, 0], [0, 3]].map(|place| board.cell(place)), [None; 3]);
        assert_eq!(board.neighbours(0).collect::<Vec<_>>(), [1, 4, 5]);
        assert_eq!(board.neighbours(5).count(), 8);
    }
}
