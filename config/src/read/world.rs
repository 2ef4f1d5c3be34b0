//! Reads a world.

use crate::reader::{NAME, Table};
use crate::{Circle, Polygon, World};

/// Most corners of one polygon: every pair of its edges is checked.
const CORNERS_MAX: usize = 1_000;
/// Most polygons, and most circles.
const SHAPES_MAX: usize = 10_000;

/// What could be read of a world; shapes keep their index in the file.
#[derive(Debug, Default)]
pub(crate) struct WorldParts {
    pub(crate) name: Option<String>,
    pub(crate) polygons: Vec<(usize, Polygon)>,
    pub(crate) circles: Vec<(usize, Circle)>,
}

impl WorldParts {
    /// The world; only for a report without problems.
    pub(crate) fn world(&self) -> Option<World> {
        Some(World {
            name: self.name.clone()?,
            polygons: self.polygons.iter().map(|(_, polygon)| polygon.clone()).collect(),
            circles: self.circles.iter().map(|(_, circle)| *circle).collect(),
            polylines: Vec::new(),
            map: None,
        })
    }
}

/// Reads what there is.
pub(crate) fn world(table: &mut Table<'_>) -> Option<WorldParts> {
    let name = table.text("name", &NAME, None);
    let polygons = table.tables("polygons", SHAPES_MAX, |table| {
        let enclosure = table.bool("enclosure", Some(false));
        let points_m = table.points("points_m", 3..=CORNERS_MAX);
        Some(Polygon { enclosure: enclosure?, points_m: points_m? })
    });
    let circles = table.tables("circles", SHAPES_MAX, |table| {
        let centre_m = table.point("centre_m");
        let radius_m = table.number("radius_m", 0.001..=1_000.0, None);
        Some(Circle { centre_m: centre_m?, radius_m: radius_m? })
    });
    Some(WorldParts { name, polygons: polygons.unwrap_or_default(), circles: circles.unwrap_or_default() })
}
