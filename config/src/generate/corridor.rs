//! Narrow ways: one corridor, and two rooms with one door.

use super::fault::Room;
use super::floor::Floor;
use super::{Misfit, Mm, Size, mm};

/// One corridor from the south-west corner to the east end, up and down as often as it bends.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Corridor {
    /// Right angles on the way; 0: straight.
    pub(crate) bends: usize,
    /// Its width, metres.
    pub(crate) passage_m: f64,
    /// Least solid between two legs, metres.
    pub(crate) wall_m: f64,
}

impl Corridor {
    pub(super) fn floor(&self, size: Size) -> Result<Floor, Misfit> {
        let (passage, wall) = (mm(self.passage_m), mm(self.wall_m));
        // Legs from south to north; after an odd number of bends the last one is the end, at the east wall.
        let legs = self.bends.div_ceil(2) as Mm;
        let gaps = if self.bends % 2 == 1 { legs } else { legs + 1 };
        let least = if legs > 0 { gaps * (passage + wall) + passage } else { 2 * passage };
        Room { key: "width_m", found: size.width, least }
            .check("the legs, each passage_m wide, with wall_m between")?;
        let least = match self.bends {
            0 => passage,
            1 => passage + wall,
            _ => 2 * passage + wall,
        };
        Room { key: "height_m", found: size.height, least }.check("passage_m at both ends of a leg, wall_m between")?;
        let mut floor = Floor::solid(size);
        let mut start = 0;
        for leg in 0..=legs {
            let (low, high) = ((0, passage), (size.height - passage, size.height));
            let end = (size.width - passage) * (leg + 1) / gaps.max(1);
            let at = if leg % 2 == 0 { low } else { high };
            floor.carve((start, (end + passage).min(size.width)), at);
            if leg < legs {
                floor.carve((end, end + passage), (0, size.height));
            }
            start = end.min(size.width - passage);
        }
        Ok(floor)
    }
}

/// Two rooms, one in the west and one in the east, and a door in the middle of the wall between.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Door {
    /// Width of the door, metres.
    pub(crate) door_m: f64,
    /// Thickness of the wall, metres.
    pub(crate) wall_m: f64,
}

impl Door {
    pub(super) fn floor(&self, size: Size) -> Result<Floor, Misfit> {
        let (door, wall) = (mm(self.door_m), mm(self.wall_m));
        Room { key: "width_m", found: size.width, least: 2 * door + wall }.check("a room of door_m on both sides")?;
        Room { key: "height_m", found: size.height, least: door + 2 * wall }.check("door_m and wall_m beside it")?;
        let (west, south) = ((size.width - wall) / 2, (size.height - door) / 2);
        let mut floor = Floor::open(size);
        floor.fill((west, west + wall), (0, size.height));
        floor.carve((west, west + wall), (south, south + door));
        Ok(floor)
    }
}
