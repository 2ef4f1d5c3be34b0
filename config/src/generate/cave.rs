//! A natural cave: a cellular automaton, and of it only what a robot can reach.
//!
//! Cells have half a passage's side. Free floor is what two by two free cells cover, moved one cell at a time: a disc
//! of a passage's diameter gets to all of it. Its outline runs through the middles of the cells' sides, without steps.

use super::chance::Chance;
use super::fault::Room;
use super::grid::Grid;
use super::{Misfit, Mm, Outline, Size, metres, mm};
use core::ops::Range;

/// Most cells.
const CELLS_MAX: usize = 250_000;
/// Caves that are tried before the rock counts as too dense.
const CAVES_MAX: usize = 20;
/// Least part of the place that is free, in percent: less is a hole, not a cave.
const FREE_PERCENT_MIN: usize = 20;
/// Solid neighbours, itself included, from which on a cell becomes rock.
const ROCK_NEIGHBOURS: usize = 5;

/// Rock in lumps with open floor between.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Cave {
    /// Least width of a passage, metres; cells have half of it.
    pub(crate) passage_m: f64,
    /// Share of cells that begin as rock, 0 to 1.
    pub(crate) density: f64,
    /// How often every cell becomes what most cells around it are.
    pub(crate) smoothing: usize,
    /// Centre of a place that is free and reached whatever the seed, metres.
    pub(crate) clear_m: [f64; 2],
    /// Its radius, metres; 0: none.
    pub(crate) clear_radius_m: f64,
}

impl Cave {
    pub(super) fn outlines(&self, size: Size, chance: &mut Chance) -> Result<Vec<Outline>, Misfit> {
        // Even, so that the middle of a side is a whole number, too.
        let cell = (mm(self.passage_m) + 3) / 4 * 2;
        let (columns, rows) = self.check(size, cell)?;
        let mut free_percent = 0;
        for _ in 0..CAVES_MAX {
            let mut cave = self.automaton(columns, rows, chance);
            let clear = self.clear(&mut cave, cell);
            let floor = reachable(&cave, clear);
            free_percent = floor.free_count() * 100 / (columns * rows);
            if free_percent >= FREE_PERCENT_MIN {
                return Ok(floor.outlines().iter().map(|outline| smooth(outline, cell)).collect());
            }
        }
        let found = format!("{}, of which the floor that robots reach is {free_percent} %", self.density);
        let expected = format!("at least {FREE_PERCENT_MIN} % of the place");
        Err(Misfit::new("density", found, expected, "lower density, or passage_m"))
    }

    /// Columns and rows.
    fn check(&self, size: Size, cell: Mm) -> Result<(usize, usize), Misfit> {
        let sum = "six cells of half of passage_m each, rock at both ends";
        Room { key: "width_m", found: size.width, least: 6 * cell }.check(sum)?;
        Room { key: "height_m", found: size.height, least: 6 * cell }.check(sum)?;
        let count = |length: Mm| usize::try_from(length / cell).unwrap_or(usize::MAX);
        let (columns, rows) = (count(size.width), count(size.height));
        if columns.saturating_mul(rows) > CELLS_MAX {
            let found = format!("{} m, which makes {columns} x {rows} cells", self.passage_m);
            let advice = "choose wider passages, or a smaller place";
            return Err(Misfit::new("passage_m", found, format!("at most {CELLS_MAX} cells"), advice));
        }
        for (key, centre_m, end) in
            [("clear_x_m", self.clear_m[0], size.width), ("clear_y_m", self.clear_m[1], size.height)]
        {
            let (low, high) = (2 * cell, end - 3 * cell);
            if self.clear_radius_m > 0.0 && !(low..=high).contains(&mm(centre_m)) {
                let expected = format!("{} to {} m, inside the rock around the cave", metres(low), metres(high));
                return Err(Misfit::new(key, format!("{centre_m} m"), expected, "move the free place inwards"));
            }
        }
        Ok((columns, rows))
    }

    /// Rock at random, then the rule of the majority; the rim is always rock.
    fn automaton(&self, columns: usize, rows: usize, chance: &mut Chance) -> Grid {
        let mut cave = Grid::new(columns, rows, false);
        for y in 1..rows - 1 {
            for x in 1..columns - 1 {
                let free = chance.share() >= self.density;
                cave.set(x..x + 1, y..y + 1, free);
            }
        }
        for _ in 0..self.smoothing {
            let before = cave.clone();
            for y in 1..rows - 1 {
                for x in 1..columns - 1 {
                    let around = (y - 1..=y + 1).flat_map(|y| (x - 1..=x + 1).map(move |x| (x, y)));
                    let rock = around.filter(|(x, y)| !before.is_free(*x, *y)).count();
                    cave.set(x..x + 1, y..y + 1, rock < ROCK_NEIGHBOURS);
                }
            }
        }
        cave
    }

    /// Frees the place that is to be free; a block of two by two cells in it, if there is one.
    fn clear(&self, cave: &mut Grid, cell: Mm) -> Option<[usize; 2]> {
        let radius = mm(self.clear_radius_m);
        if radius == 0 {
            return None;
        }
        let centre = self.clear_m.map(mm);
        let index = |at: Mm, count: usize| usize::try_from(at / cell).unwrap_or(0).clamp(1, count - 3);
        let block = [index(centre[0] - cell / 2, cave.columns), index(centre[1] - cell / 2, cave.rows)];
        for y in 1..cave.rows - 1 {
            for x in 1..cave.columns - 1 {
                // Every cell that the disc touches; as a block, for single cells are passed by nobody.
                let beyond = |at: Mm, cell_index: usize| {
                    let low = cell_index as Mm * cell;
                    at - at.clamp(low, low + cell)
                };
                let [dx, dy] = [beyond(centre[0], x), beyond(centre[1], y)];
                if dx * dx + dy * dy <= radius * radius {
                    free_block(cave, [x.min(cave.columns - 3), y.min(cave.rows - 3)]);
                }
            }
        }
        free_block(cave, block);
        Some(block)
    }
}

/// What a block of two by two cells covers when it moves through the largest free part. `start` is a block that must
/// be a part of that: if it is not, a tunnel is dug.
fn reachable(cave: &Grid, start: Option<[usize; 2]>) -> Grid {
    let mut cave = cave.clone();
    let mut blocks = blocks_of(&cave);
    if let Some(start) = start
        && let Some(end) = nearest_of_largest(&blocks, start)
    {
        let (xs, ys) = (range(start[0], end[0]), range(start[1], end[1]));
        xs.for_each(|x| free_block(&mut cave, [x, start[1]]));
        ys.for_each(|y| free_block(&mut cave, [end[0], y]));
        blocks = blocks_of(&cave);
    }
    blocks.keep_largest();
    let mut floor = Grid::new(cave.columns, cave.rows, false);
    for y in 0..blocks.rows {
        for x in 0..blocks.columns {
            if blocks.is_free(x, y) {
                free_block(&mut floor, [x, y]);
            }
        }
    }
    floor.open_diagonals();
    floor
}

fn free_block(grid: &mut Grid, [x, y]: [usize; 2]) {
    grid.set(x..x + 2, y..y + 2, true);
}

fn range(a: usize, b: usize) -> Range<usize> {
    a.min(b)..a.max(b) + 1
}

/// Where a block of two by two free cells is, by its south-west cell.
fn blocks_of(cave: &Grid) -> Grid {
    let mut blocks = Grid::new(cave.columns - 1, cave.rows - 1, false);
    for y in 0..blocks.rows {
        for x in 0..blocks.columns {
            let cells = [(x, y), (x + 1, y), (x, y + 1), (x + 1, y + 1)];
            blocks.set(x..x + 1, y..y + 1, cells.iter().all(|(x, y)| cave.is_free(*x, *y)));
        }
    }
    blocks
}

/// The block of the largest part that is the fewest moves away; none if `start` is in that part itself.
fn nearest_of_largest(blocks: &Grid, start: [usize; 2]) -> Option<[usize; 2]> {
    let mut largest = blocks.clone();
    largest.keep_largest();
    let cells = (0..largest.rows).flat_map(|y| (0..largest.columns).map(move |x| [x, y]));
    let free = cells.filter(|[x, y]| largest.is_free(*x, *y));
    free.min_by_key(|[x, y]| x.abs_diff(start[0]) + y.abs_diff(start[1])).filter(|end| *end != start)
}

/// The outline through the middles of the cells' sides, without corners on a straight line.
fn smooth(outline: &[[usize; 2]], cell: Mm) -> Outline {
    let place = |corner: &[usize; 2]| [corner[0] as Mm * cell, corner[1] as Mm * cell];
    let mut middles: Outline = Vec::new();
    for (from, to) in outline.iter().zip(outline.iter().cycle().skip(1)) {
        let (from, to) = (place(from), place(to));
        let step = [(to[0] - from[0]).signum() * cell / 2, (to[1] - from[1]).signum() * cell / 2];
        middles.push([from[0] + step[0], from[1] + step[1]]);
        middles.push([to[0] - step[0], to[1] - step[1]]);
    }
    middles.dedup();
    let before = middles.iter().cycle().skip(middles.len().saturating_sub(1));
    let after = middles.iter().cycle().skip(1);
    let bends = |a: &[Mm; 2], b: &[Mm; 2], c: &[Mm; 2]| (b[0] - a[0]) * (c[1] - b[1]) != (b[1] - a[1]) * (c[0] - b[0]);
    let corners = middles.iter().zip(before).zip(after).filter(|((at, before), after)| bends(before, at, after));
    corners.map(|((at, _), _)| *at).collect()
}
