//! Where cells lie in the world: squares row by row from the south-west corner.

use drover_contract::Vec2;

/// A rectangle of square cells along the axes of the world frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lattice {
    low_w: Vec2,
    cell_m: f64,
    columns: usize,
    rows: usize,
}

impl Lattice {
    /// Cells with sides of `cell_m` from the corner `low_w` on, as many as `high_w` needs; at least one.
    #[must_use]
    pub fn over(low_w: Vec2, high_w: Vec2, cell_m: f64) -> Self {
        let size = high_w - low_w;
        // A hair less: what is a whole number of cells wide is not one more for rounding.
        let count = |length_m: f64| (length_m / cell_m - 1e-9).ceil().max(1.0) as usize;
        Self { low_w, cell_m, columns: count(size.x), rows: count(size.y) }
    }

    /// Side of a cell, metres.
    #[must_use]
    pub const fn cell_m(&self) -> f64 {
        self.cell_m
    }

    /// The south-west corner of all, world frame.
    #[must_use]
    pub const fn low_w(&self) -> Vec2 {
        self.low_w
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

    /// The middle of a cell, world frame.
    #[must_use]
    pub fn centre_w(&self, cell: usize) -> Vec2 {
        let (column, row) = (cell % self.columns, cell / self.columns);
        self.low_w + Vec2::new(column as f64 + 0.5, row as f64 + 0.5) * self.cell_m
    }

    /// The cell at a place, if it is in one.
    #[must_use]
    pub fn cell_at(&self, place_w: Vec2) -> Option<usize> {
        let at = (place_w - self.low_w) / self.cell_m;
        let within = |value: f64, count: usize| value >= 0.0 && value < count as f64;
        let inside = within(at.x, self.columns) && within(at.y, self.rows);
        inside.then(|| at.y as usize * self.columns + at.x as usize)
    }

    /// The cell nearest to a place.
    #[must_use]
    pub fn cell_near(&self, place_w: Vec2) -> usize {
        let at = (place_w - self.low_w) / self.cell_m;
        let within = |value: f64, count: usize| (value.floor().max(0.0) as usize).min(count - 1);
        within(at.y, self.rows) * self.columns + within(at.x, self.columns)
    }

    /// Every cell that the straight way between two places touches, from the first on, as far as it is on the lattice.
    /// J. Amanatides, A. Woo, "A fast voxel traversal algorithm for ray tracing", Eurographics 1987.
    pub fn along(&self, from_w: Vec2, to_w: Vec2, mut visit: impl FnMut(usize)) {
        let from = (from_w - self.low_w) / self.cell_m;
        let way = (to_w - from_w) / self.cell_m;
        let mut at = [from.x.floor() as i64, from.y.floor() as i64];
        let step = [way.x, way.y].map(|along| if along < 0.0 { -1 } else { 1 });
        // In shares of the way: what is left to the next side of a cell on each axis, and from side to side.
        let each = [way.x, way.y].map(|along| if along == 0.0 { f64::INFINITY } else { 1.0 / along.abs() });
        let left = |axis: usize, value: f64| {
            let to_side = if step[axis] > 0 { value.floor() + 1.0 - value } else { value - value.floor() };
            if each[axis].is_finite() { to_side * each[axis] } else { f64::INFINITY }
        };
        let mut next = [left(0, from.x), left(1, from.y)];
        // No way on a lattice touches more cells than this; numbers that are none end at once.
        for _ in 0..2 * (self.columns + self.rows) + 4 {
            if let [Ok(column), Ok(row)] = at.map(usize::try_from)
                && column < self.columns
                && row < self.rows
            {
                visit(row * self.columns + column);
            }
            let axis = usize::from(next[1] < next[0]);
            if next[axis].is_nan() || next[axis] > 1.0 {
                return;
            }
            at[axis] += step[axis];
            next[axis] += each[axis];
        }
    }
}

#[cfg(test)]
mod tests {
    use super::Lattice;
    use drover_contract::Vec2;
    use proptest::prelude::*;

    fn lattice() -> Lattice {
        Lattice::over(Vec2::new(-1.0, 2.0), Vec2::new(1.0, 3.5), 0.5)
    }

    #[test]
    fn places_have_cells_and_cells_have_middles() {
        let lattice = lattice();
        assert_eq!((lattice.columns(), lattice.rows()), (4, 3));
        assert_eq!(lattice.cell_at(Vec2::new(-0.9, 2.1)), Some(0));
        assert_eq!(lattice.cell_at(Vec2::new(0.1, 2.6)), Some(6));
        assert_eq!(lattice.centre_w(6), Vec2::new(0.25, 2.75));
        assert_eq!(lattice.cell_at(Vec2::new(1.1, 2.6)), None);
        assert_eq!(lattice.cell_near(Vec2::new(1.1, 9.0)), 11);
    }

    proptest! {
        #[test]
        fn a_way_touches_what_points_on_it_lie_in(
            (x0, y0, x1, y1) in (-1.0..1.0f64, 2.0..3.5f64, -2.0..2.0f64, 1.0..4.5f64),
        ) {
            let lattice = lattice();
            let (from_w, to_w) = (Vec2::new(x0, y0), Vec2::new(x1, y1));
            let mut touched = Vec::new();
            lattice.along(from_w, to_w, |cell| touched.push(cell));
            prop_assert_eq!(touched.first().copied(), lattice.cell_at(from_w));
            for share in 0..=200 {
                let place_w = from_w + (to_w - from_w) * (f64::from(share) / 200.0);
                let Some(cell) = lattice.cell_at(place_w) else { continue };
                // A place on a corner belongs to four.
                let corner = (place_w - lattice.centre_w(cell)).abs().max() > 0.25 - 1e-9;
                prop_assert!(corner || touched.contains(&cell), "{share}: {cell} of {touched:?}");
            }
            for pair in touched.windows(2) {
                let apart = (lattice.centre_w(pair[0]) - lattice.centre_w(pair[1])).norm();
                prop_assert!(apart < 0.5 + 1e-9 || x1.abs() > 1.0 || !(2.0..3.5).contains(&y1));
            }
        }
    }
}
