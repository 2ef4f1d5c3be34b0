//! A grid of rooms with doors.

use super::chance::Chance;
use super::fault::Room;
use super::floor::Floor;
use super::tree::openings;
use super::{Misfit, Mm, Size, bays, mm};

/// Rooms of one size, every one of which can be reached through doors.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Rooms {
    /// Rooms from west to east.
    pub(crate) columns: usize,
    /// Rooms from south to north.
    pub(crate) rows: usize,
    /// Width of a door, metres; it is somewhere in its wall, a wall's thickness away from the corners.
    pub(crate) door_m: f64,
    /// Thickness of a wall, metres.
    pub(crate) wall_m: f64,
    /// Share of the walls that need no door, 0 to 1, to have one all the same.
    pub(crate) loops: f64,
}

impl Rooms {
    pub(super) fn floor(&self, size: Size, chance: &mut Chance) -> Result<Floor, Misfit> {
        let (door, wall) = (mm(self.door_m), mm(self.wall_m));
        for (key, found, count) in [("width_m", size.width, self.columns), ("height_m", size.height, self.rows)] {
            // A millimetre each: bays are cut to whole ones.
            let least = count as Mm * (door + 3 * wall + 1) - wall;
            Room { key, found, least }
                .check("the rooms, each with door_m and a wall's thickness beside it, and walls")?;
        }
        let (xs, ys) = (bays(size.width, self.columns, wall), bays(size.height, self.rows, wall));
        let mut floor = Floor::solid(size);
        for y in &ys {
            xs.iter().for_each(|x| floor.carve(*x, *y));
        }
        for opening in openings(self.columns, self.rows, self.loops, chance) {
            let [column, row] = opening.cell;
            if opening.east {
                let at = door_in(ys[row], door, wall, chance);
                floor.carve((xs[column].1, xs[column + 1].0), at);
            } else {
                let at = door_in(xs[column], door, wall, chance);
                floor.carve(at, (ys[row].1, ys[row + 1].0));
            }
        }
        Ok(floor)
    }
}

/// From where to where a door goes in a wall that goes from `from` to `to`.
pub(super) fn door_in((from, to): (Mm, Mm), door: Mm, wall: Mm, chance: &mut Chance) -> (Mm, Mm) {
    let start = chance.between(from + wall, to - wall - door);
    (start, start + door)
}
