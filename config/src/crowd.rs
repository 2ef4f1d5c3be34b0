//! Discs that have a place already, found quickly by where they are.

use crate::geometry::{Point, distance};
use std::collections::BTreeMap;

/// Touching is not overlapping: places that were computed differ in their last digits, metres.
pub(crate) const TOUCH_M: f64 = 1e-9;
/// The smallest body, metres: discs are kept apart by how many times it doubles into their radius.
const RADIUS_M_MIN: f64 = 0.005;

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

/// Points, and which of them are within a distance of a place.
#[derive(Debug)]
pub(crate) struct Near {
    distance_m: f64,
    cells: BTreeMap<(i64, i64), Vec<Point>>,
}

impl Near {
    /// No point yet.
    pub(crate) fn new(distance_m: f64) -> Self {
        Self { distance_m, cells: BTreeMap::new() }
    }

    /// Adds a point.
    pub(crate) fn add(&mut self, point: Point) {
        self.cells.entry(cell_of(point, self.distance_m)).or_default().push(point);
    }

    /// Whether none of them is nearer to `point` than the distance.
    pub(crate) fn has_room(&self, point: Point) -> bool {
        self.around(point).all(|other| distance(point, *other) >= self.distance_m)
    }

    /// Whether one of them is no farther from `point` than the distance.
    pub(crate) fn reaches(&self, point: Point) -> bool {
        self.around(point).any(|other| distance(point, *other) <= self.distance_m)
    }

    /// All that are within the distance of `point`, and some others.
    fn around(&self, point: Point) -> impl Iterator<Item = &Point> {
        let (x, y) = cell_of(point, self.distance_m);
        let columns = (x - 1..=x + 1).flat_map(move |x| self.cells.range((x, y - 1)..=(x, y + 1)));
        columns.flat_map(|(_, points)| points)
    }
}

/// A point that no chain of links joins to the first one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Parted {
    /// Which one it is; the first of them.
    pub(crate) index: usize,
    /// The nearest of those that are joined to the first one.
    pub(crate) nearest: usize,
    /// How far away that one is, metres.
    pub(crate) gap_m: f64,
}

/// Where a network is parted whose links join `points` no farther than `range_m` from each other, if it is.
pub(crate) fn parted(points: &[Point], range_m: f64) -> Option<Parted> {
    let mut left: BTreeMap<(i64, i64), Vec<usize>> = BTreeMap::new();
    for (index, point) in points.iter().enumerate().skip(1) {
        left.entry(cell_of(*point, range_m)).or_default().push(index);
    }
    let mut joined = vec![false; points.len()];
    let mut open: Vec<usize> = points.iter().take(1).map(|_| 0).collect();
    while let Some(at) = open.pop() {
        joined[at] = true;
        let (x, y) = cell_of(points[at], range_m);
        for key in (x - 1..=x + 1).flat_map(|x| (y - 1..=y + 1).map(move |y| (x, y))) {
            let Some(cell) = left.get_mut(&key) else { continue };
            cell.retain(|index| {
                let linked = distance(points[at], points[*index]) <= range_m + TOUCH_M;
                if linked {
                    open.push(*index);
                }
                !linked
            });
        }
    }
    let index = joined.iter().position(|joined| !joined)?;
    let gap_m = |other: usize| distance(points[index], points[other]);
    let nearest = (0..points.len()).filter(|other| joined[*other]).min_by(|a, b| gap_m(*a).total_cmp(&gap_m(*b)))?;
    Some(Parted { index, nearest, gap_m: gap_m(nearest) })
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
