//! The simulated place.

use serde::Serialize;

/// A place: walls and obstacles in the world frame. One file in `config/worlds/` each.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct World {
    /// Its name.
    pub name: String,
    /// Outlines; robots stay outside of them, but for the one marked `enclosure`, where they stay inside.
    pub polygons: Vec<Polygon>,
    /// Round obstacles.
    pub circles: Vec<Circle>,
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
