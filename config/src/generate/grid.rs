//! Cells that are free or solid, and the outlines between the two.

use core::ops::Range;

/// A corner of cells: column and row of the cell to its north-east.
pub(super) type Corner = [usize; 2];

/// Ways along an outline, with the free side on the left.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Way {
    East,
    North,
    West,
    South,
}

impl Way {
    const ALL: [Self; 4] = [Self::East, Self::North, Self::West, Self::South];

    fn bit(self) -> u8 {
        1 << (self as u8)
    }

    fn from(self, [x, y]: Corner) -> Corner {
        match self {
            Self::East => [x + 1, y],
            Self::North => [x, y + 1],
            Self::West => [x.saturating_sub(1), y],
            Self::South => [x, y.saturating_sub(1)],
        }
    }
}

/// Cells; everything around them is solid.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Grid {
    pub(super) columns: usize,
    pub(super) rows: usize,
    free: Vec<bool>,
}

impl Grid {
    /// All cells are free, or none.
    pub(super) fn new(columns: usize, rows: usize, free: bool) -> Self {
        Self { columns, rows, free: vec![free; columns * rows] }
    }

    /// Whether a cell is free.
    pub(super) fn is_free(&self, x: usize, y: usize) -> bool {
        x < self.columns && y < self.rows && self.free[y * self.columns + x]
    }

    /// How many cells are free.
    pub(super) fn free_count(&self) -> usize {
        self.free.iter().filter(|free| **free).count()
    }

    /// Makes a block of cells free or solid; what lies outside is left alone.
    pub(super) fn set(&mut self, columns: Range<usize>, rows: Range<usize>, free: bool) {
        for y in rows.start..rows.end.min(self.rows) {
            for x in columns.start..columns.end.min(self.columns) {
                self.free[y * self.columns + x] = free;
            }
        }
    }

    /// Makes everything solid that cannot be reached from the largest free part by going east, north, west and south.
    pub(super) fn keep_largest(&mut self) {
        let (parts, sizes) = self.parts();
        // Of parts of one size the first counts.
        let largest = (0..sizes.len()).rev().max_by_key(|part| sizes[*part]);
        for (free, part) in self.free.iter_mut().zip(parts) {
            *free = part.is_some() && part == largest;
        }
    }

    /// Which free part each cell belongs to (solid ones to none), and how many cells each part has.
    pub(super) fn parts(&self) -> (Vec<Option<usize>>, Vec<usize>) {
        let mut parts = vec![None; self.free.len()];
        let mut sizes = Vec::new();
        for start in 0..self.free.len() {
            if self.free[start] && parts[start].is_none() {
                sizes.push(self.flood(start, sizes.len(), &mut parts));
            }
        }
        (parts, sizes)
    }

    fn flood(&self, start: usize, part: usize, parts: &mut [Option<usize>]) -> usize {
        parts[start] = Some(part);
        let mut open = vec![start];
        let mut count = 0;
        while let Some(cell) = open.pop() {
            count += 1;
            let (x, y) = (cell % self.columns, cell / self.columns);
            // A wrapped number is no column and no row.
            for (x, y) in [(x + 1, y), (x.wrapping_sub(1), y), (x, y + 1), (x, y.wrapping_sub(1))] {
                if self.is_free(x, y) && parts[y * self.columns + x].is_none() {
                    parts[y * self.columns + x] = Some(part);
                    open.push(y * self.columns + x);
                }
            }
        }
        count
    }

    /// Frees a cell wherever free ones touch by a corner alone, for an outline must not touch itself. Solid cells along
    /// the rim are safe as long as a whole rim is solid or the place ends there.
    pub(super) fn open_diagonals(&mut self) {
        let mut open: Vec<Corner> = (1..self.rows).flat_map(|y| (1..self.columns).map(move |x| [x, y])).collect();
        while let Some([x, y]) = open.pop() {
            if x == 0 || y == 0 || x >= self.columns || y >= self.rows {
                continue;
            }
            let [south_west, south_east] = [self.is_free(x - 1, y - 1), self.is_free(x, y - 1)];
            let [north_west, north_east] = [self.is_free(x - 1, y), self.is_free(x, y)];
            if south_west != north_east || north_west != south_east || south_west == south_east {
                continue;
            }
            let column = if south_west { x } else { x - 1 };
            self.set(column..column + 1, y - 1..y, true);
            open.extend([[column, y - 1], [column + 1, y - 1], [column, y], [column + 1, y]]);
        }
    }

    /// The outlines between free and solid, the free side on the left: first the outer one, counter-clockwise, then
    /// those of what stands in it, clockwise. For one free part that touches itself nowhere by a corner alone.
    pub(super) fn outlines(&self) -> Vec<Vec<Corner>> {
        let mut seen = vec![0_u8; (self.columns + 1) * (self.rows + 1)];
        let mut outlines = Vec::new();
        for y in 0..=self.rows {
            for x in 0..=self.columns {
                // Every outline goes to the east somewhere; the outer one does so in the southmost row.
                if self.goes([x, y], Way::East) && seen[y * (self.columns + 1) + x] & Way::East.bit() == 0 {
                    outlines.push(self.follow([x, y], &mut seen));
                }
            }
        }
        outlines
    }

    /// Whether an outline leaves a corner that way: free on the left, solid on the right.
    fn goes(&self, [x, y]: Corner, way: Way) -> bool {
        let (west, south) = (x.wrapping_sub(1), y.wrapping_sub(1));
        let [south_west, south_east] = [self.is_free(west, south), self.is_free(x, south)];
        let [north_west, north_east] = [self.is_free(west, y), self.is_free(x, y)];
        match way {
            Way::East => north_east && !south_east,
            Way::North => north_west && !north_east,
            Way::West => south_west && !north_west,
            Way::South => south_east && !south_west,
        }
    }

    /// The corners of the outline that leaves `start` to the east, each cell's side on its own.
    fn follow(&self, start: Corner, seen: &mut [u8]) -> Vec<Corner> {
        let mut outline = Vec::new();
        let (mut corner, mut way) = (start, Way::East);
        loop {
            let mark = &mut seen[corner[1] * (self.columns + 1) + corner[0]];
            if *mark & way.bit() != 0 {
                return without_straights(&outline);
            }
            *mark |= way.bit();
            outline.push((corner, way));
            corner = way.from(corner);
            // There is always one: what comes in on an outline goes out.
            way = Way::ALL.into_iter().find(|way| self.goes(corner, *way)).unwrap_or(way);
        }
    }
}

/// The corners at which the way changes.
fn without_straights(outline: &[(Corner, Way)]) -> Vec<Corner> {
    let before = outline.iter().cycle().skip(outline.len().saturating_sub(1));
    outline.iter().zip(before).filter(|((_, way), (_, before))| way != before).map(|((corner, _), _)| *corner).collect()
}

#[cfg(test)]
mod tests {
    use super::Grid;

    fn grid(rows: &[&str]) -> Grid {
        let mut grid = Grid::new(rows[0].len(), rows.len(), false);
        for (y, row) in rows.iter().rev().enumerate() {
            for (x, sign) in row.chars().enumerate() {
                grid.set(x..x + 1, y..y + 1, sign == '.');
            }
        }
        grid
    }

    #[test]
    fn outlines_are_the_free_floor_s_own_the_outer_one_first() {
        let grid = grid(&["....", ".#..", "...#"]);
        let outer = vec![[0, 0], [3, 0], [3, 1], [4, 1], [4, 3], [0, 3]];
        assert_eq!(grid.outlines(), [outer, vec![[1, 2], [2, 2], [2, 1], [1, 1]]]);
    }

    #[test]
    fn what_touches_by_a_corner_alone_is_opened() {
        let mut opened = grid(&["#..", "..#", "#.."]);
        opened.set(1..2, 1..2, false);
        let before = opened.free_count();
        opened.open_diagonals();
        assert!(opened.free_count() > before);
        let again = opened.clone();
        opened.open_diagonals();
        assert_eq!(opened, again);
    }

    #[test]
    fn the_largest_part_is_kept() {
        let mut kept = grid(&[".#..", ".#..", "##.#"]);
        kept.keep_largest();
        assert_eq!(kept, grid(&["##..", "##..", "##.#"]));
    }
}
