//! The places of `drover bench rays`: made from a seed, the same on every machine.

use drover_config::{GridMap, Polygon, UnknownCells, World};
use drover_contract::math::sin_cos;
use drover_contract::{Pose, Vec2};
use drover_world::geometry::{CellBlocks, DiscTree};
use drover_world::lidar::{Scenery, Silhouette};
use drover_world::sight::Sight;
use drover_world::{Disc, Walls};
use rand::{Rng, SeedableRng};
use rand_pcg::Pcg32;
use std::f64::consts::{PI, TAU};
use std::sync::Arc;

/// Floor an obstacle, square metres: the place grows with the number of obstacles.
const FLOOR_M2_PER_OBSTACLE: f64 = 8.0;
/// Radii of the circles that obstacles' corners lie on, metres.
const OBSTACLE_M: std::ops::Range<f64> = 0.25..0.6;
/// Free floor between two obstacles, and between an obstacle and the outer wall, at least, metres.
const GAP_M: f64 = 0.1;
/// Corners of one obstacle after the other: four on average.
const CORNERS: [usize; 4] = [4, 3, 5, 4];
/// A sensor, or a robot's surface, is at least this far from a wall, metres.
const CLEAR_M: f64 = 0.1;
/// Radius of a robot, metres.
const ROBOT_M: f64 = 0.2;
/// Side of a map's cell, metres.
const CELL_M: f64 = 0.1;

/// Parry's structures beside the tree that [`Walls`] has anyway.
enum Parry {
    /// The tree of wall pieces does it all.
    Walls,
    /// The discs of the others in a tree of their own.
    Discs(DiscTree),
    /// Cells of a map, as they are.
    Cells(CellBlocks),
}

/// A place, what parry makes of it, and where scans are taken.
pub(crate) struct Scene {
    /// What it is called in the table.
    pub(crate) name: String,
    /// Its walls.
    pub(crate) walls: Walls,
    /// Robots; scan i is taken by robot i modulo their number, and does not see it.
    pub(crate) robots: Vec<Disc>,
    /// Where scans are taken.
    pub(crate) poses_ws: Vec<Pose>,
    parry: Parry,
}

/// One scan's surroundings.
pub(crate) struct Seen<'a> {
    scene: &'a Scene,
    viewer: usize,
}

impl Scene {
    /// A walled square with `count` obstacles of four corners on average, and `poses` places to scan from.
    pub(crate) fn obstacles(count: usize, poses: usize) -> Self {
        let mut rng = Pcg32::seed_from_u64(count as u64);
        let walls = Walls::new(&square(count, &mut rng));
        let poses_ws = free_poses(&walls, poses, CLEAR_M, side_m(count), &mut rng);
        let name = format!("{} segments", walls.segments().len());
        Self { name, walls, robots: Vec::new(), poses_ws, parry: Parry::Walls }
    }

    /// The same with `count_robots` robots that see each other.
    pub(crate) fn swarm(count: usize, count_robots: usize) -> Self {
        let mut scene = Self::obstacles(count, 0);
        let mut rng = Pcg32::seed_from_u64(1);
        while scene.poses_ws.len() < count_robots {
            let pose_ws = free_poses(&scene.walls, 1, ROBOT_M + CLEAR_M, side_m(count), &mut rng)[0];
            let apart = |disc: &Disc| (disc.centre_w - pose_ws.position()).norm() > 2.0 * ROBOT_M + CLEAR_M;
            if scene.robots.iter().all(apart) {
                scene.robots.push(Disc { centre_w: pose_ws.position(), radius_m: ROBOT_M });
                scene.poses_ws.push(pose_ws);
            }
        }
        scene.name = format!("{} and {count_robots} robots", scene.name);
        scene.parry = Parry::Discs(DiscTree::new(&scene.robots));
        scene
    }

    /// A map of `side` x `side` cells with blocks of 2 to 20 cells a side, until a fifth is solid, and a closed rim.
    /// `as_cells`: parry casts on the cells, and not on their outlines.
    pub(crate) fn map(side: usize, poses: usize, as_cells: bool) -> Self {
        let mut rng = Pcg32::seed_from_u64(side as u64);
        let map = Arc::new(blocks(side, &mut rng));
        let parry = if as_cells { Parry::Cells(CellBlocks::new(&map)) } else { Parry::Walls };
        let walls = Walls::new(&World { name: "map".into(), map: Some(map), ..World::default() });
        let poses_ws = free_poses(&walls, poses, CLEAR_M, side as f64 * CELL_M, &mut rng);
        let what = if as_cells { "cells (Voxels)" } else { "outlines" };
        let name = format!("{side} x {side} map, {what}");
        Self { name, walls, robots: Vec::new(), poses_ws, parry }
    }

    /// What scan `index` is taken of.
    pub(crate) fn seen_by(&self, index: usize) -> Seen<'_> {
        Seen { scene: self, viewer: if self.robots.is_empty() { 0 } else { index % self.robots.len() } }
    }
}

impl Seen<'_> {
    /// How far one ray runs by parry, metres; infinite where it meets nothing within `range_m`.
    pub(crate) fn parry_m(&self, from_w: Vec2, direction_w: Vec2, range_m: f64) -> f64 {
        let hit = match &self.scene.parry {
            Parry::Walls => self.scene.walls.ray_m(from_w, direction_w, range_m),
            Parry::Cells(cells) => cells.ray_m(from_w, direction_w, range_m),
            Parry::Discs(discs) => {
                // What is behind the wall need not be looked for.
                let wall_m = self.scene.walls.ray_m(from_w, direction_w, range_m);
                discs.ray_m(from_w, direction_w, wall_m.unwrap_or(range_m), self.viewer).or(wall_m)
            }
        };
        hit.unwrap_or(f64::INFINITY)
    }
}

impl Scenery for Seen<'_> {
    fn sight(&self) -> &Sight {
        self.scene.walls.sight()
    }

    fn bodies_near(&self, from_w: Vec2, range_m: f64, see: &mut dyn FnMut(Silhouette<'_>)) {
        let near = |disc: &Disc| (disc.centre_w - from_w).norm_squared() < (range_m + disc.radius_m).powi(2);
        let others = self.scene.robots.iter().enumerate().filter(|(index, _)| *index != self.viewer);
        others.filter(|(_, disc)| near(disc)).for_each(|(_, disc)| see(Silhouette::Disc(*disc)));
    }
}

/// Side of the square that holds so many obstacles, metres.
fn side_m(count: usize) -> f64 {
    (count as f64 * FLOOR_M2_PER_OBSTACLE).sqrt()
}

fn square(count: usize, rng: &mut Pcg32) -> World {
    let side_m = side_m(count);
    let mut circles: Vec<(Vec2, f64)> = Vec::new();
    while circles.len() < count {
        let radius_m = rng.random_range(OBSTACLE_M);
        let inside = radius_m + GAP_M..side_m - radius_m - GAP_M;
        let centre = Vec2::new(rng.random_range(inside.clone()), rng.random_range(inside));
        if circles.iter().all(|(other, other_m)| (other - centre).norm() > radius_m + other_m + GAP_M) {
            circles.push((centre, radius_m));
        }
    }
    let rim = vec![[0.0, 0.0], [side_m, 0.0], [side_m, side_m], [0.0, side_m]];
    let mut polygons = vec![Polygon { enclosure: true, points_m: rim }];
    for ((centre, radius_m), corners) in circles.into_iter().zip(CORNERS.into_iter().cycle()) {
        // Corners on a circle make a convex outline, wherever they are.
        let corner = |index: usize| {
            let angle_rad = (index as f64 + rng.random_range(0.1..0.9)) * TAU / corners as f64;
            let (sin, cos) = sin_cos(angle_rad);
            [centre.x + radius_m * cos, centre.y + radius_m * sin]
        };
        polygons.push(Polygon { enclosure: false, points_m: (0..corners).map(corner).collect() });
    }
    World { name: "square".into(), polygons, ..World::default() }
}

fn blocks(side: usize, rng: &mut Pcg32) -> GridMap {
    let rim = |index: usize| index == 0 || index == side - 1;
    let mut solid: Vec<bool> = (0..side * side).map(|index| rim(index % side) || rim(index / side)).collect();
    while solid.iter().filter(|cell| **cell).count() * 5 < side * side {
        let [width, height] = [rng.random_range(2..20), rng.random_range(2..20)];
        let [x, y] = [rng.random_range(0..side - width), rng.random_range(0..side - height)];
        (y..y + height).for_each(|row| solid[row * side + x..row * side + x + width].fill(true));
    }
    GridMap {
        file: String::new(),
        unknown: UnknownCells::Solid,
        resolution_m: CELL_M,
        origin_m: [0.0, 0.0],
        origin_yaw_rad: 0.0,
        width: side,
        height: side,
        solid,
    }
}

fn free_poses(walls: &Walls, count: usize, clear_m: f64, side_m: f64, rng: &mut Pcg32) -> Vec<Pose> {
    let anywhere = std::iter::repeat_with(|| {
        Pose::new(rng.random_range(0.0..side_m), rng.random_range(0.0..side_m), rng.random_range(-PI..PI))
    });
    let clear = |pose: &Pose| {
        let place = Disc { centre_w: pose.position(), radius_m: clear_m };
        walls.gap_m(&place).is_none_or(|gap_m| gap_m > 0.0)
    };
    anywhere.filter(clear).take(count).collect()
}
