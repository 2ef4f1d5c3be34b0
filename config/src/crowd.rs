//! Discs that have a place already, found quickly by where they are.

use crate::geometry::{Point, distance};
use std::collections::BTreeMap;

/// Touching is not overlapping: places that were computed differ in their last digits, metres.
const TOUCH_M: f64 = 1e-9;
/// The smallest body, metres: discs are kept apart by how many times it doubles into their radius.
const RADIUS_M_MIN: f64 = 0.02;

/// Discs by size and place. Of discs that do not overlap, a cell holds a few at most, whatever else is in the crowd.
#[derive(Debug, Default)]
pub(crate) struct Crowd {
    sizes: BTreeMap<u8, BTreeMap<(i64, i64), Vec<Disc>>>,
    count: usize,
}

/// One of them; `index` counts them in the order in which they came.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Disc {
    pub(crate) index: usize,
    pub(crate) centre_m: Point,
    pub(crate) radius_m: f64,
}

impl Crowd {
    /// Adds a disc.
    pub(crate) fn add(&mut self, centre_m: Point, radius_m: f64) {
        let size = size_of(radius_m);
        let disc = Disc { index: self.count, centre_m, radius_m };
        let cell = cell_of(centre_m, side_m(size));
        self.sizes.entry(size).or_default().entry(cell).or_default().push(disc);
        self.count += 1;
    }

    /// A disc that is nearer to one at `centre_m` with `radius_m` than both radii together.
    pub(crate) fn overlapping(&self, centre_m: Point, radius_m: f64) -> Option<Disc> {
        self.sizes.iter().find_map(|(size, cells)| {
            let side_m = side_m(*size);
            let reach_m = radius_m + side_m / 2.0;
            let (west, south) = cell_of([centre_m[0] - reach_m, centre_m[1] - reach_m], side_m);
            let (east, north) = cell_of([centre_m[0] + reach_m, centre_m[1] + reach_m], side_m);
            let overlaps = |disc: &&Disc| distance(centre_m, disc.centre_m) < radius_m + disc.radius_m - TOUCH_M;
            let columns = (west..=east).flat_map(|x| cells.range((x, south)..=(x, north)));
            columns.flat_map(|(_, discs)| discs).find(overlaps).copied()
        })
    }
}

/// Points that keep a distance.
#[derive(Debug)]
pub(crate) struct Apart {
    apart_m: f64,
    cells: BTreeMap<(i64, i64), Vec<Point>>,
}

impl Apart {
    /// No point yet; they will be at least `apart_m` apart.
    pub(crate) fn new(apart_m: f64) -> Self {
        Self { apart_m, cells: BTreeMap::new() }
    }

    /// Adds a point.
    pub(crate) fn add(&mut self, point: Point) {
        self.cells.entry(cell_of(point, self.apart_m)).or_default().push(point);
    }

    /// Whether `point` is far enough from all of them.
    pub(crate) fn has_room(&self, point: Point) -> bool {
        let (x, y) = cell_of(point, self.apart_m);
        let columns = (x - 1..=x + 1).flat_map(|x| self.cells.range((x, y - 1)..=(x, y + 1)));
        columns.flat_map(|(_, points)| points).all(|other| distance(point, *other) >= self.apart_m)
    }
}

/// How often the smallest body doubles into this one.
fn size_of(radius_m: f64) -> u8 {
    (0_u8..12).find(|size| radius_m <= side_m(*size) / 2.0).unwrap_or(12)
}

/// Cells of a size are as wide as its greatest disc.
fn side_m(size: u8) -> f64 {
    2.0 * RADIUS_M_MIN * f64::from(1_u32 << size)
}

fn cell_of(point: Point, side_m: f64) -> (i64, i64) {
    // `as` saturates; coordinates are at most 10 km.
    ((point[0] / side_m).floor() as i64, (point[1] / side_m).floor() as i64)
}
