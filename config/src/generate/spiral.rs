//! A corridor that winds inwards.

use super::fault::Room;
use super::floor::Floor;
use super::{Misfit, Mm, Size, mm};

/// A square spiral: from the south-west corner counter-clockwise to a room in the middle.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Spiral {
    /// How often it goes around.
    pub(crate) turns: usize,
    /// Width of the corridor, metres.
    pub(crate) passage_m: f64,
    /// Thickness of the walls, metres.
    pub(crate) wall_m: f64,
}

impl Spiral {
    pub(super) fn floor(&self, size: Size) -> Result<Floor, Misfit> {
        let (passage, wall) = (mm(self.passage_m), mm(self.wall_m));
        let pitch = passage + wall;
        let least = 2 * self.turns as Mm * pitch + passage;
        for (key, found) in [("width_m", size.width), ("height_m", size.height)] {
            Room { key, found, least }
                .check("twice passage_m and wall_m for every turn, and passage_m in the middle")?;
        }
        let mut floor = Floor::open(size);
        for turn in 0..self.turns as Mm {
            // From the outer wall to this turn's wall. The wall begins at the one of the turn before, the first one at
            // the outer wall, and ends one corridor short of its own beginning.
            let near = passage + turn * pitch;
            let (east, north) = (size.width - near, size.height - near);
            let begin = if turn == 0 { 0 } else { near - pitch };
            floor.fill((begin, east), (near, near + wall));
            floor.fill((east - wall, east), (near, north));
            floor.fill((near, east), (north - wall, north));
            floor.fill((near, near + wall), (near + pitch, north));
        }
        Ok(floor)
    }
}
