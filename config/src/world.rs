//! The simulated place.

use crate::boxes::bounds;
use serde::{Serialize, Serializer};
use std::sync::Arc;

/// A place: walls and obstacles in the world frame. One file in `config/worlds/` each.
///
/// What a generator (`world.generate`) made stands here as the shapes that it made.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct World {
    /// Its name.
    pub name: String,
    /// Outlines; robots stay outside of them, but for the one marked `enclosure`, where they stay inside.
    pub polygons: Vec<Polygon>,
    /// Round obstacles.
    pub circles: Vec<Circle>,
    /// Thin walls, seen and touched from both sides.
    pub polylines: Vec<Polyline>,
    /// A grid map whose occupied cells are obstacles.
    #[serde(skip_serializing_if = "Option::is_none", serialize_with = "named")]
    pub map: Option<Arc<GridMap>>,
    /// Round obstacles that move.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub movers: Vec<Mover>,
}

impl World {
    /// The smallest rectangle along the axes around the enclosure, or else around everything that does not move:
    /// south-west and north-east corner, metres. None for a world without anything.
    #[must_use]
    pub fn bounds_m(&self) -> Option<[[f64; 2]; 2]> {
        if let Some(enclosure) = self.polygons.iter().find(|polygon| polygon.enclosure) {
            return bounds(enclosure.points_m.iter().copied());
        }
        let outlines = self.polygons.iter().flat_map(|polygon| &polygon.points_m).copied();
        let chains = self.polylines.iter().flat_map(|chain| &chain.points_m).copied();
        let discs = self.circles.iter().flat_map(|disc| {
            let [x_m, y_m] = disc.centre_m;
            [[x_m - disc.radius_m, y_m - disc.radius_m], [x_m + disc.radius_m, y_m + disc.radius_m]]
        });
        let map = self.map.iter().flat_map(|map| map.corners_m());
        bounds(outlines.chain(chains).chain(discs).chain(map))
    }
}

impl GridMap {
    /// Its four corners, world frame, metres.
    fn corners_m(&self) -> [[f64; 2]; 4] {
        let (sin, cos) = (libm::sin(self.origin_yaw_rad), libm::cos(self.origin_yaw_rad));
        let [width_m, height_m] = [self.width, self.height].map(|cells| cells as f64 * self.resolution_m);
        let turned =
            |[x_m, y_m]: [f64; 2]| [self.origin_m[0] + x_m * cos - y_m * sin, self.origin_m[1] + x_m * sin + y_m * cos];
        [[0.0, 0.0], [width_m, 0.0], [width_m, height_m], [0.0, height_m]].map(turned)
    }
}

/// A simple polygon.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Polygon {
    /// Whether it is the outer wall: robots are inside. At most one of a world is.
    pub enclosure: bool,
    /// Corners in order, either way round, metres, at least three.
    pub points_m: Vec<[f64; 2]>,
}

/// A round obstacle.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Circle {
    /// Centre, metres.
    pub centre_m: [f64; 2],
    /// Radius, metres, > 0.
    pub radius_m: f64,
}

/// A disc that goes along a route for ever, and waits while a robot is in its way: it never runs into one.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Mover {
    /// Radius, metres, > 0.
    pub radius_m: f64,
    /// Where it starts, and where it goes from there in straight lines, metres, at least two.
    pub waypoints_m: Vec<[f64; 2]>,
    /// How fast it goes while nobody is in its way, m/s, > 0.
    pub speed_mps: f64,
    /// Whether it goes from the last waypoint straight to the first; else it goes back along them.
    #[serde(rename = "loop")]
    pub loops: bool,
}

impl Mover {
    /// Its whole way until it is where it started, and goes on as it did at first: from each of these points to the
    /// next, and from the last to the first.
    #[must_use]
    pub fn round_m(&self) -> Vec<[f64; 2]> {
        let back = self.waypoints_m.iter().rev().skip(1).take(self.waypoints_m.len().saturating_sub(2));
        let back = back.filter(|_| !self.loops);
        self.waypoints_m.iter().chain(back).copied().collect()
    }
}

/// A chain of thin walls.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Polyline {
    /// Corners in order, metres, at least two; the last is not joined to the first.
    pub points_m: Vec<[f64; 2]>,
}

/// A map in the format of ROS' map_server (YAML beside PGM or PNG), read.
///
/// It is written as the file it came from.
#[derive(Clone, Debug, PartialEq)]
pub struct GridMap {
    /// Path of its YAML file, as it can be opened from the current folder or absolutely.
    pub file: String,
    /// What cells are that are neither free nor occupied.
    pub unknown: UnknownCells,
    /// Side of a cell, metres, > 0.
    pub resolution_m: f64,
    /// South-west corner of the south-west cell, world frame, metres.
    pub origin_m: [f64; 2],
    /// How the map is turned about that corner, radians, counter-clockwise.
    pub origin_yaw_rad: f64,
    /// Cells from west to east.
    pub width: usize,
    /// Cells from south to north.
    pub height: usize,
    /// Whether a cell is an obstacle: `solid[y * width + x]`, y counted from the south.
    pub solid: Vec<bool>,
}

/// What a map's unknown cells are taken for.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum UnknownCells {
    /// Obstacles: nobody leaves the known.
    #[default]
    Solid,
    /// Free floor.
    Free,
}

/// Writes a map as the file that it came from.
fn named<S: Serializer>(map: &Option<Arc<GridMap>>, serializer: S) -> Result<S::Ok, S::Error> {
    #[derive(Serialize)]
    struct Named<'a> {
        file: &'a str,
        unknown: UnknownCells,
    }
    map.as_ref().map(|map| Named { file: &map.file, unknown: map.unknown }).serialize(serializer)
}
