//! A floor plan of rectangles, and the outlines of what is free in it.

use super::grid::Grid;
use super::{Misfit, Mm, Outline, Size};

/// Most cells that the lines of a plan may make: about as many bytes while it is drawn.
const CELLS_MAX: usize = 10_000_000;

/// A rectangle along the axes, millimetres.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Rect {
    /// From west to east.
    pub(super) x: (Mm, Mm),
    /// From south to north.
    pub(super) y: (Mm, Mm),
}

/// Rectangles drawn one over the other.
pub(super) struct Floor {
    size: Size,
    /// Whether what nothing is drawn on is free.
    free: bool,
    drawn: Vec<(Rect, bool)>,
}

impl Floor {
    /// A place that is free all over.
    pub(super) fn open(size: Size) -> Self {
        Self { size, free: true, drawn: Vec::new() }
    }

    /// A place that is solid all over.
    pub(super) fn solid(size: Size) -> Self {
        Self { size, free: false, drawn: Vec::new() }
    }

    /// Makes a rectangle solid.
    pub(super) fn fill(&mut self, x: (Mm, Mm), y: (Mm, Mm)) {
        self.drawn.push((Rect { x, y }, false));
    }

    /// Makes a rectangle free.
    pub(super) fn carve(&mut self, x: (Mm, Mm), y: (Mm, Mm)) {
        self.drawn.push((Rect { x, y }, true));
    }

    /// The outlines of the free floor: the outer one, then what stands free in it.
    pub(super) fn outlines(&self) -> Result<Vec<Outline>, Misfit> {
        let xs = lines(self.size.width, self.drawn.iter().map(|(rect, _)| rect.x));
        let ys = lines(self.size.height, self.drawn.iter().map(|(rect, _)| rect.y));
        if (xs.len() - 1).saturating_mul(ys.len() - 1) > CELLS_MAX {
            let found = format!("a plan of {} lines by {} lines", xs.len(), ys.len());
            return Err(Misfit::new("kind", found, format!("at most {CELLS_MAX} crossings"), "make it coarser"));
        }
        let mut grid = Grid::new(xs.len() - 1, ys.len() - 1, self.free);
        for (rect, free) in &self.drawn {
            grid.set(between(&xs, rect.x), between(&ys, rect.y), *free);
        }
        grid.keep_largest();
        grid.open_diagonals();
        let place = |outline: &Vec<[usize; 2]>| outline.iter().map(|[x, y]| [xs[*x], ys[*y]]).collect();
        Ok(grid.outlines().iter().map(place).collect())
    }
}

/// Every coordinate at which something begins or ends, in order, within `0..=end`.
fn lines(end: Mm, spans: impl Iterator<Item = (Mm, Mm)>) -> Vec<Mm> {
    let mut lines: Vec<Mm> = spans.flat_map(|(from, to)| [from, to]).map(|line| line.clamp(0, end)).collect();
    lines.extend([0, end]);
    lines.sort_unstable();
    lines.dedup();
    lines
}

/// The cells from one coordinate to another.
fn between(lines: &[Mm], (from, to): (Mm, Mm)) -> core::ops::Range<usize> {
    let cell = |line: Mm| lines.partition_point(|other| *other < line).min(lines.len() - 1);
    cell(from)..cell(to)
}
