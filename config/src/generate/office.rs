//! Corridors with rooms on both sides.

use super::chance::Chance;
use super::fault::Room;
use super::floor::Floor;
use super::rooms::door_in;
use super::{Misfit, Mm, Size, bays, bays_that_fit, mm};

/// A desk along the wall and from the wall, millimetres: the usual 1.6 m x 0.8 m.
const DESK: [Mm; 2] = [1_600, 800];
/// Most rooms: their outlines would have too many corners anyway.
const ROOMS_MAX: usize = 5_000;

/// Corridors from west to east. Every room has one door, to its corridor; a corridor along the west end joins them if
/// there are several.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Office {
    /// How many there are.
    pub(crate) corridors: usize,
    /// Width of the corridors, metres.
    pub(crate) passage_m: f64,
    /// Least width of a room on the average, metres; a wall is up to an eighth of it aside.
    pub(crate) room_m: f64,
    /// Width of a door, metres.
    pub(crate) door_m: f64,
    /// Thickness of a wall, metres.
    pub(crate) wall_m: f64,
    /// Most desks of a room, in a row along the wall that faces the door; fewer where they have no room.
    pub(crate) desks: usize,
}

/// A row of rooms on one side of a corridor.
struct Row {
    /// From its south end to its north end.
    y: (Mm, Mm),
    /// Whether its corridor is to the north.
    door_north: bool,
}

impl Office {
    pub(super) fn floor(&self, size: Size, chance: &mut Chance) -> Result<Floor, Misfit> {
        let (passage, wall) = (mm(self.passage_m), mm(self.wall_m));
        self.check(size)?;
        let west = if self.corridors > 1 { passage + wall } else { 0 };
        let mut floor = Floor::solid(size);
        if self.corridors > 1 {
            floor.carve((0, passage), (0, size.height));
        }
        for (south, north) in bays(size.height, self.corridors, wall) {
            let low = (south + north - passage) / 2;
            floor.carve((0, size.width), (low, low + passage));
            let rows = [
                Row { y: (south, low - wall), door_north: true },
                Row { y: (low + passage + wall, north), door_north: false },
            ];
            for row in rows {
                self.rooms(&mut floor, (west, size.width), &row, chance);
            }
        }
        Ok(floor)
    }

    /// Refuses what does not fit.
    fn check(&self, size: Size) -> Result<(), Misfit> {
        let (passage, room, door, wall) = (mm(self.passage_m), mm(self.room_m), mm(self.door_m), mm(self.wall_m));
        // Two walls may each be an eighth aside; some millimetres for what rounding takes.
        let least = (door + 2 * wall) * 4 / 3 + 4;
        Room { key: "room_m", found: room, least }
            .check("three quarters of it hold door_m and wall_m on both sides")?;
        let west = if self.corridors > 1 { passage + wall } else { 0 };
        Room { key: "width_m", found: size.width - west, least: room }
            .check("a room of room_m beside the corridors")?;
        let depth = door + if self.desks > 0 { DESK[1] } else { 0 };
        let count = self.corridors as Mm;
        let least = count * (2 * depth + 2 * wall + passage + 4) + (count - 1) * wall;
        Room { key: "height_m", found: size.height, least }
            .check("the corridors, and rooms on both sides as deep as door_m and a desk")?;
        let rooms = 2 * self.corridors * bays_that_fit(size.width - west, room, wall);
        if rooms > ROOMS_MAX {
            let found = format!("{} m, which makes {rooms} rooms", self.room_m);
            return Err(Misfit::new("room_m", found, format!("at most {ROOMS_MAX} rooms"), "choose wider rooms"));
        }
        Ok(())
    }

    /// Draws a row of rooms from west to east, each with its door and its desks.
    fn rooms(&self, floor: &mut Floor, (west, east): (Mm, Mm), row: &Row, chance: &mut Chance) {
        let (room, door, wall) = (mm(self.room_m), mm(self.door_m), mm(self.wall_m));
        let count = bays_that_fit(east - west, room, wall);
        let even = bays(east - west, count, wall);
        let mut start = west;
        for (index, (_, end)) in even.iter().enumerate() {
            let aside = if index + 1 < count { chance.between(-room / 8, room / 8) } else { 0 };
            let x = (start, west + end + aside);
            floor.carve(x, row.y);
            let at = door_in(x, door, wall, chance);
            let (gap, desks) = if row.door_north {
                ((row.y.1, row.y.1 + wall), (row.y.0, row.y.0 + DESK[1]))
            } else {
                ((row.y.0 - wall, row.y.0), (row.y.1 - DESK[1], row.y.1))
            };
            floor.carve(at, gap);
            let count = (self.desks as Mm).min((x.1 - x.0) / DESK[0]);
            if count > 0 {
                let first = chance.between(x.0, x.1 - count * DESK[0]);
                floor.fill((first, first + count * DESK[0]), desks);
            }
            start = x.1 + wall;
        }
    }
}
