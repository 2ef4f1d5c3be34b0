//! Reads a world.

use super::generate;
use crate::map;
use crate::reader::{NAME, Table};
use crate::{Circle, GridMap, Mover, Polygon, Polyline, World};
use std::sync::Arc;

/// Most corners of one polygon: as many as a world may have. A maze is one outline.
const OUTLINE_CORNERS_MAX: usize = 20_000;
/// Most corners of one polyline.
const CORNERS_MAX: usize = 1_000;
/// Most polygons, most circles, most polylines.
const SHAPES_MAX: usize = 10_000;
/// Most movers: every lidar and every body looks at each of them.
const MOVERS_MAX: usize = 100;
/// Most waypoints of one mover.
const WAYPOINTS_MAX: usize = 1_000;

/// Where the indices of generated polygons begin: those in a file end before.
const GENERATED: usize = SHAPES_MAX;

/// Whether a polygon was generated.
pub(crate) fn is_generated(polygon: usize) -> bool {
    polygon >= GENERATED
}

/// A polygon's name in words for the user, by its index.
pub(crate) fn polygon_name(polygon: usize) -> String {
    match polygon.checked_sub(GENERATED) {
        Some(outline) => format!("outline {outline} that generate made"),
        None => format!("polygons[{polygon}]"),
    }
}

/// What could be read of a world; shapes keep their index in the file, generated ones come after them.
#[derive(Debug, Default)]
pub(crate) struct WorldParts {
    pub(crate) name: Option<String>,
    pub(crate) polygons: Vec<(usize, Polygon)>,
    pub(crate) circles: Vec<(usize, Circle)>,
    pub(crate) polylines: Vec<(usize, Polyline)>,
    pub(crate) map: Option<Arc<GridMap>>,
    pub(crate) movers: Vec<(usize, Mover)>,
}

impl WorldParts {
    /// The world; only for a report without problems.
    pub(crate) fn world(&self) -> Option<World> {
        Some(World {
            name: self.name.clone()?,
            polygons: self.polygons.iter().map(|(_, polygon)| polygon.clone()).collect(),
            circles: self.circles.iter().map(|(_, circle)| *circle).collect(),
            polylines: self.polylines.iter().map(|(_, polyline)| polyline.clone()).collect(),
            map: self.map.clone(),
            movers: self.movers.iter().map(|(_, mover)| mover.clone()).collect(),
        })
    }
}

/// Reads what there is. `seed` counts for a generator that has none of its own.
pub(crate) fn world(table: &mut Table<'_>, seed: u64) -> Option<WorldParts> {
    let name = table.text("name", &NAME, None);
    let polygons = table.tables("polygons", SHAPES_MAX, |table| {
        let enclosure = table.bool("enclosure", Some(false));
        let points_m = table.points("points_m", 3..=OUTLINE_CORNERS_MAX);
        Some(Polygon { enclosure: enclosure?, points_m: points_m? })
    });
    let circles = table.tables("circles", SHAPES_MAX, |table| {
        let centre_m = table.point("centre_m");
        let radius_m = table.number("radius_m", 0.001..=1_000.0, None);
        Some(Circle { centre_m: centre_m?, radius_m: radius_m? })
    });
    let polylines = table.tables("polylines", SHAPES_MAX, |table| {
        let points_m = table.points("points_m", 2..=CORNERS_MAX);
        Some(Polyline { points_m: points_m? })
    });
    let movers = table.tables("movers", MOVERS_MAX, mover);
    let map = table.optional_file_table("map", map::read).flatten();
    let generated = table.optional_table("generate", |table| generate::outlines(table, seed)).flatten();
    let generated = (GENERATED..).zip(generated.unwrap_or_default());
    Some(WorldParts {
        name,
        polygons: polygons.unwrap_or_default().into_iter().chain(generated).collect(),
        circles: circles.unwrap_or_default(),
        polylines: polylines.unwrap_or_default(),
        map: map.map(Arc::new),
        movers: movers.unwrap_or_default(),
    })
}

fn mover(table: &mut Table<'_>) -> Option<Mover> {
    let radius_m = table.number("radius_m", 0.005..=50.0, None);
    let waypoints_m = table.points("waypoints_m", 2..=WAYPOINTS_MAX);
    let speed_mps = table.number("speed_mps", 0.001..=20.0, None);
    let loops = table.bool("loop", Some(false));
    Some(Mover { radius_m: radius_m?, waypoints_m: waypoints_m?, speed_mps: speed_mps?, loops: loops? })
}
