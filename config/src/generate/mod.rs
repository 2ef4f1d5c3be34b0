//! Worlds made from a few numbers and a seed (`world.generate`).
//!
//! A generator makes outlines and nothing else: the enclosure is the outline of the free floor itself, and obstacles
//! are what stands free in it. So walls that meet are one outline without a seam that a ray or a robot could find.
//!
//! All lengths are whole millimetres inside: what touches is equal, and the same seed makes the same world anywhere.

mod cave;
mod chance;
mod corridor;
mod fault;
mod field;
mod floor;
mod grid;
mod maze;
mod office;
mod pocket;
mod rooms;
mod spiral;
mod tree;
mod warehouse;

#[cfg(test)]
mod tests;

pub(crate) use cave::Cave;
pub(crate) use corridor::{Corridor, Door};
pub(crate) use fault::Misfit;
pub(crate) use field::ConvexField;
pub(crate) use maze::Maze;
pub(crate) use office::Office;
pub(crate) use pocket::{Comb, Pocket, Tee, U};
pub(crate) use rooms::Rooms;
pub(crate) use spiral::Spiral;
pub(crate) use warehouse::Warehouse;

use crate::Polygon;
use chance::Chance;

/// Most corners of all outlines together: a written world must be readable again.
pub(crate) const CORNERS_MAX: usize = 20_000;

/// Millimetres.
type Mm = i64;

/// What a world is made from.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Generate {
    /// From the west end to the east end, metres.
    pub(crate) width_m: f64,
    /// From the south end to the north end, metres.
    pub(crate) height_m: f64,
    /// The layout's own seed; none: the swarm's counts.
    pub(crate) seed: Option<u64>,
    /// What stands there.
    pub(crate) layout: Layout,
}

/// What stands in a generated world.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Layout {
    /// Scattered convex obstacles.
    ConvexField(ConvexField),
    /// A grid of rooms.
    Rooms(Rooms),
    /// Corridors with rooms on both sides.
    Office(Office),
    /// Rows of racks.
    Warehouse(Warehouse),
    /// A maze of square cells.
    Maze(Maze),
    /// A natural cave.
    Cave(Cave),
    /// One corridor, straight or bent.
    Corridor(Corridor),
    /// A pocket that opens to the west.
    U(U),
    /// One of random size, turned and moved.
    Pocket(Pocket),
    /// A bar with a stem to the west.
    T(Tee),
    /// A spiral corridor.
    Spiral(Spiral),
    /// Pockets in a row.
    Comb(Comb),
    /// Two rooms and a door.
    Door(Door),
}

/// The size of the place.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Size {
    width: Mm,
    height: Mm,
}

/// The outlines of a world; the first is the enclosure. `seed` counts if the parameters have none of their own.
///
/// # Errors
/// [`Misfit`] if the parameters do not fit together, or if the outlines have too many corners.
pub(crate) fn generate(params: &Generate, seed: u64) -> Result<Vec<Polygon>, Misfit> {
    let size = Size { width: mm(params.width_m), height: mm(params.height_m) };
    let mut chance = Chance::new(params.seed.unwrap_or(seed));
    let outlines = params.layout.outlines(size, &mut chance)?;
    let corners: usize = outlines.iter().map(Vec::len).sum();
    if corners > CORNERS_MAX {
        let found = format!("a world of {corners} corners");
        return Err(Misfit::new("kind", found, format!("at most {CORNERS_MAX}"), "make it smaller, or coarser"));
    }
    let polygon = |(index, outline): (usize, &Outline)| Polygon {
        enclosure: index == 0,
        points_m: outline.iter().map(|[x, y]| [metres(*x), metres(*y)]).collect(),
    };
    Ok(outlines.iter().enumerate().map(polygon).collect())
}

impl Layout {
    fn outlines(&self, size: Size, chance: &mut Chance) -> Result<Vec<Outline>, Misfit> {
        let floor = match self {
            Self::ConvexField(field) => return field.outlines(size, chance),
            Self::Cave(cave) => return cave.outlines(size, chance),
            Self::Pocket(pocket) => return pocket.outlines(size, chance),
            Self::Rooms(rooms) => rooms.floor(size, chance),
            Self::Office(office) => office.floor(size, chance),
            Self::Warehouse(warehouse) => warehouse.floor(size, chance),
            Self::Maze(maze) => maze.floor(size, chance),
            Self::Corridor(corridor) => corridor.floor(size),
            Self::U(u) => u.floor(size),
            Self::T(tee) => tee.floor(size),
            Self::Spiral(spiral) => spiral.floor(size),
            Self::Comb(comb) => comb.floor(size),
            Self::Door(door) => door.floor(size),
        };
        floor?.outlines()
    }
}

/// Corners in order, millimetres.
type Outline = Vec<[Mm; 2]>;

/// Whole millimetres nearest to `length_m`. The reader keeps lengths within kilometres: nothing is cut off.
fn mm(length_m: f64) -> Mm {
    libm::round(length_m * 1_000.0) as Mm
}

/// Metres, as short as they can be written.
fn metres(length: Mm) -> f64 {
    length as f64 / 1_000.0
}

/// `length` cut into `count` bays with walls between: from where to where each goes, the last up to `length`.
fn bays(length: Mm, count: usize, wall: Mm) -> Vec<(Mm, Mm)> {
    let start = |bay: usize| (bay as Mm) * (length + wall) / (count.max(1) as Mm);
    (0..count).map(|bay| (start(bay), start(bay + 1) - wall)).collect()
}

/// How many bays of at least `bay` fit into `length` with walls between; 0 if not even one does.
fn bays_that_fit(length: Mm, bay: Mm, wall: Mm) -> usize {
    usize::try_from((length + wall) / (bay + wall).max(1)).unwrap_or(0)
}
