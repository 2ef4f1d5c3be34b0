//! Rows of racks with aisles between.

use super::chance::Chance;
use super::fault::Room;
use super::floor::Floor;
use super::{Misfit, Mm, Size, bays_that_fit, mm};

/// Most racks: each has four corners.
const RACKS_MAX: usize = 5_000;

/// As many racks as fit, from west to east lengthwise, in the middle of the place. Aisles run between their rows, cross
/// aisles between their ends.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Warehouse {
    /// A rack's length, metres.
    pub(crate) rack_m: f64,
    /// A rack's depth, metres.
    pub(crate) rack_depth_m: f64,
    /// Width of aisles and cross aisles, metres.
    pub(crate) passage_m: f64,
    /// Least free floor along the walls, metres.
    pub(crate) margin_m: f64,
    /// Share of places that are left empty, 0 to 1.
    pub(crate) gaps: f64,
}

impl Warehouse {
    pub(super) fn floor(&self, size: Size, chance: &mut Chance) -> Result<Floor, Misfit> {
        let (passage, margin) = (mm(self.passage_m), mm(self.margin_m));
        let (rack, depth) = (mm(self.rack_m), mm(self.rack_depth_m));
        Room { key: "margin_m", found: margin, least: passage }.check("passage_m; robots go around the racks")?;
        Room { key: "width_m", found: size.width, least: rack + 2 * margin }.check("rack_m and twice margin_m")?;
        Room { key: "height_m", found: size.height, least: depth + 2 * margin }
            .check("rack_depth_m and twice margin_m")?;
        let columns = places(size.width, margin, rack, passage);
        let rows = places(size.height, margin, depth, passage);
        if columns.len() * rows.len() > RACKS_MAX {
            let found = format!("room for {} x {} racks", columns.len(), rows.len());
            let expected = format!("at most {RACKS_MAX}");
            return Err(Misfit::new("rack_m", found, expected, "choose longer racks or a smaller place"));
        }
        let mut floor = Floor::open(size);
        for y in &rows {
            for x in &columns {
                if chance.share() >= self.gaps {
                    floor.fill(*x, *y);
                }
            }
        }
        Ok(floor)
    }
}

/// As many places of `item` as fit with `passage` between and `margin` at the ends, in the middle of `length`.
fn places(length: Mm, margin: Mm, item: Mm, passage: Mm) -> Vec<(Mm, Mm)> {
    let count = bays_that_fit(length - 2 * margin, item, passage) as Mm;
    let first = (length - count * (item + passage) + passage) / 2;
    let start = |place: Mm| first + place * (item + passage);
    (0..count).map(|place| (start(place), start(place) + item)).collect()
}
