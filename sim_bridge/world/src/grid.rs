//! Who is near whom: places in a uniform grid, made anew whenever the places have changed.
//!
//! A counting sort puts all places into cells, row by row, so that a query reads one run of memory a row. The grid
//! covers where most places are (three standard deviations about the mean); who is farther away counts into the cells
//! at the rim, where a query looks for him too: one robot that has gone astray makes nobody slow and is not lost.

use drover_contract::Vec2;

/// Cells a place, at most: a sparse swarm must not pay for empty floor.
const CELLS_PER_PLACE: f64 = 2.0;
/// Cells at least.
const CELLS_MIN: f64 = 16.0;
/// The grid covers that many standard deviations to each side of the mean.
const DEVIATIONS: f64 = 3.0;

/// One place in the grid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Entry {
    /// Index of the place in the list it came from.
    pub(crate) index: u32,
    /// Where it is, world frame, metres.
    pub(crate) pos_w: Vec2,
}

/// Places by cell.
#[derive(Clone, Debug, Default)]
pub(crate) struct Grid {
    low_w: Vec2,
    cell_m: f64,
    columns: usize,
    rows: usize,
    /// `starts[cell]..starts[cell + 1]` are the entries of a cell.
    starts: Vec<u32>,
    entries: Vec<Entry>,
}

impl Grid {
    /// Sort `places_w` into cells of at least `cell_m_min` metres. What was allocated before is used again.
    pub(crate) fn rebuild(&mut self, places_w: impl Iterator<Item = Vec2> + Clone, cell_m_min: f64) {
        let count = self.cover(places_w.clone(), cell_m_min);
        let cells = self.columns * self.rows;
        self.starts.clear();
        self.starts.resize(cells + 1, 0);
        for pos_w in places_w.clone() {
            let cell = self.cell_of(pos_w);
            self.starts[cell + 1] += 1;
        }
        for cell in 0..cells {
            self.starts[cell + 1] += self.starts[cell];
        }
        self.entries.resize(count, Entry { index: 0, pos_w: Vec2::zeros() });
        // `starts` moves up while cells are filled and is put back afterwards: no second list is needed.
        for (index, pos_w) in places_w.enumerate() {
            let cell = self.cell_of(pos_w);
            let slot = &mut self.starts[cell];
            self.entries[*slot as usize] = Entry { index: index as u32, pos_w };
            *slot += 1;
        }
        for cell in (1..=cells).rev() {
            self.starts[cell] = self.starts[cell - 1];
        }
        self.starts[0] = 0;
    }

    /// Everybody whose cell is within `range_m` of `centre_w`: all that are within that distance, and some more.
    pub(crate) fn near(&self, centre_w: Vec2, range_m: f64) -> impl Iterator<Item = &Entry> + '_ {
        let half = Vec2::new(range_m, range_m);
        let (left, low) = self.column_row(centre_w - half);
        let (right, high) = self.column_row(centre_w + half);
        (low..=high).flat_map(move |row| {
            let first = self.starts[row * self.columns + left] as usize;
            let end = self.starts[row * self.columns + right + 1] as usize;
            &self.entries[first..end]
        })
    }

    /// Heap bytes held.
    #[must_use]
    pub(crate) fn bytes(&self) -> usize {
        self.starts.capacity() * size_of::<u32>() + self.entries.capacity() * size_of::<Entry>()
    }

    /// Lay the grid over the places; how many there are.
    fn cover(&mut self, places_w: impl Iterator<Item = Vec2>, cell_m_min: f64) -> usize {
        let (mut count, mut sum_w, mut squares) = (0_usize, Vec2::zeros(), Vec2::zeros());
        let mut low_w = Vec2::repeat(f64::INFINITY);
        let mut high_w = Vec2::repeat(f64::NEG_INFINITY);
        for pos_w in places_w {
            count += 1;
            sum_w += pos_w;
            squares += pos_w.component_mul(&pos_w);
            low_w = low_w.inf(&pos_w);
            high_w = high_w.sup(&pos_w);
        }
        let n = (count.max(1)) as f64;
        let mean_w = sum_w / n;
        let spread = (squares / n - mean_w.component_mul(&mean_w)).map(|v| v.max(0.0).sqrt() * DEVIATIONS);
        self.low_w = low_w.sup(&(mean_w - spread));
        let extent =
            (high_w.inf(&(mean_w + spread)) - self.low_w).map(|v| if v.is_finite() { v.max(0.0) } else { 0.0 });
        if count == 0 {
            self.low_w = Vec2::zeros();
        }
        let cells_max = (n * CELLS_PER_PLACE).max(CELLS_MIN);
        // A long thin crowd has its area from its length alone.
        let per_cell_m = (extent.x.max(cell_m_min) * extent.y.max(cell_m_min) / cells_max).sqrt();
        self.cell_m = cell_m_min.max(per_cell_m).max(1e-6);
        let cells = |along_m: f64| ((along_m / self.cell_m) as usize + 1).min(cells_max as usize * 2);
        (self.columns, self.rows) = (cells(extent.x), cells(extent.y));
        count
    }

    fn column_row(&self, pos_w: Vec2) -> (usize, usize) {
        let from = pos_w - self.low_w;
        // A cast saturates: below the grid is 0; above it is cut.
        let cell = |along_m: f64, count: usize| ((along_m / self.cell_m) as usize).min(count - 1);
        (cell(from.x, self.columns), cell(from.y, self.rows))
    }

    fn cell_of(&self, pos_w: Vec2) -> usize {
        let (column, row) = self.column_row(pos_w);
        row * self.columns + column
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn near(places: &[Vec2], cell_m: f64, centre_w: Vec2, range_m: f64) -> Vec<u32> {
        let mut grid = Grid::default();
        grid.rebuild(places.iter().copied(), cell_m);
        let within = |entry: &&Entry| (entry.pos_w - centre_w).norm() <= range_m;
        let mut found: Vec<u32> = grid.near(centre_w, range_m).filter(within).map(|entry| entry.index).collect();
        found.sort_unstable();
        found
    }

    #[test]
    fn an_empty_grid_answers_with_nobody() {
        assert!(near(&[], 1.0, Vec2::zeros(), 5.0).is_empty());
    }

    #[test]
    fn one_astray_neither_gets_lost_nor_makes_the_cells_large() {
        let mut places: Vec<Vec2> = (0..2_500).map(|i| Vec2::new(f64::from(i % 50), f64::from(i / 50))).collect();
        places.push(Vec2::new(1e4, -1e4));
        assert_eq!(near(&places, 1.0, Vec2::new(1e4, -1e4), 1.0), [2_500]);
        let mut grid = Grid::default();
        grid.rebuild(places.iter().copied(), 1.0);
        assert!(grid.near(Vec2::new(25.0, 25.0), 1.0).count() < 400);
    }

    proptest! {
        #[test]
        fn everybody_within_range_is_found(
            places in prop::collection::vec((-30.0..30.0f64, -5.0..90.0f64), 0..60),
            centre in (-40.0..40.0f64, -40.0..100.0f64), range_m in 0.0..20.0f64, cell_m in 0.1..10.0f64,
        ) {
            let places: Vec<Vec2> = places.into_iter().map(|(x, y)| Vec2::new(x, y)).collect();
            let centre_w = Vec2::new(centre.0, centre.1);
            let expected: Vec<u32> = (0..places.len() as u32)
                .filter(|index| (places[*index as usize] - centre_w).norm() <= range_m)
                .collect();
            prop_assert_eq!(near(&places, cell_m, centre_w, range_m), expected);
        }
    }
}
