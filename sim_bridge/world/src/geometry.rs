//! The only file that names parry, which speaks glam; nalgebra's types are converted here, at the border.
//!
//! Parry measures where exactness counts more than speed: how far a body is from walls, how far two outlines are from
//! each other. Lidar casting is ours (`sight`); parry's own ray cast is here as what that is checked against.

use drover_config::GridMap;
use drover_contract::{Pose, Vec2};
use parry2d_f64::bounding_volume::Aabb;
use parry2d_f64::math::{IVector, Pose as Placement, Rotation, Vector};
use parry2d_f64::partitioning::{Bvh, BvhBuildStrategy};
use parry2d_f64::query::{self, PointQuery, Ray, RayCast};
use parry2d_f64::shape::{Ball, ConvexPolygon, Polyline, Voxels};

/// A piece of wall; its free side is on the left of the way from `from_w` to `to_w`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Segment {
    /// First end, world frame, metres.
    pub from_w: Vec2,
    /// Second end, world frame, metres.
    pub to_w: Vec2,
}

/// A disc: a round obstacle or a robot's body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Disc {
    /// Centre, world frame, metres.
    pub centre_w: Vec2,
    /// Radius, metres.
    pub radius_m: f64,
}

impl Disc {
    /// How far a ray of unit direction runs before it meets the disc from outside, metres, up to `range_m` (parry's).
    #[must_use]
    pub fn ray_m(&self, origin_w: Vec2, direction_w: Vec2, range_m: f64) -> Option<f64> {
        let local = Ray::new(to_parry(origin_w - self.centre_w), to_parry(direction_w));
        Ball::new(self.radius_m).cast_local_ray(&local, range_m, false)
    }
}

/// Pieces of wall in parry's tree.
pub struct Tree {
    polyline: Polyline,
}

impl Tree {
    /// A tree of `segments`; `None` for none.
    #[must_use]
    pub fn new(segments: &[Segment]) -> Option<Self> {
        let vertices: Vec<Vector> =
            segments.iter().flat_map(|segment| [to_parry(segment.from_w), to_parry(segment.to_w)]).collect();
        let pairs = (0..segments.len() as u32).map(|index| [2 * index, 2 * index + 1]).collect();
        (!segments.is_empty()).then(|| Self { polyline: Polyline::new(vertices, Some(pairs)) })
    }

    /// Distance from a point to the nearest piece, metres.
    #[must_use]
    pub fn distance_m(&self, point_w: Vec2) -> f64 {
        self.polyline.distance_to_local_point(to_parry(point_w), true)
    }

    /// Gap between an outline at `pose_wb` and the nearest piece, metres; 0 where they cross.
    #[must_use]
    pub fn gap_m(&self, outline: &Outline, pose_wb: Pose) -> f64 {
        // Both are shapes that parry has this query for.
        query::distance(&Placement::IDENTITY, &self.polyline, &pose_of(pose_wb), &outline.polygon)
            .map_or(0.0, |apart| apart.distance)
    }

    /// How far a ray of unit direction runs before it meets a piece, metres, up to `range_m`.
    #[must_use]
    pub fn ray_m(&self, origin_w: Vec2, direction_w: Vec2, range_m: f64) -> Option<f64> {
        let ray = Ray::new(to_parry(origin_w), to_parry(direction_w));
        self.polyline.cast_local_ray(&ray, range_m, true)
    }
}

/// Discs in parry's tree.
pub struct DiscTree {
    discs: Vec<Disc>,
    tree: Bvh,
}

impl DiscTree {
    /// A tree of `discs`.
    #[must_use]
    pub fn new(discs: &[Disc]) -> Self {
        let leaf = |disc: &Disc| Ball::new(disc.radius_m).aabb(&Placement::from_translation(to_parry(disc.centre_w)));
        let leaves: Vec<Aabb> = discs.iter().map(leaf).collect();
        Self { discs: discs.to_vec(), tree: Bvh::from_leaves(BvhBuildStrategy::Binned, &leaves) }
    }

    /// How far a ray of unit direction runs before it meets a disc other than number `except`, metres, up to `range_m`.
    #[must_use]
    pub fn ray_m(&self, origin_w: Vec2, direction_w: Vec2, range_m: f64, except: usize) -> Option<f64> {
        let ray = Ray::new(to_parry(origin_w), to_parry(direction_w));
        let hit = |index: u32, nearest_m: f64| {
            let index = index as usize;
            if index == except { None } else { self.discs[index].ray_m(origin_w, direction_w, nearest_m) }
        };
        self.tree.cast_ray(&ray, range_m, hit).map(|(_, range_m)| range_m)
    }
}

/// The solid cells of a map as parry's voxels.
pub struct CellBlocks {
    voxels: Voxels,
    origin_w: Vec2,
}

impl CellBlocks {
    /// Those of a map that is not turned (`origin_yaw_rad` does not count).
    #[must_use]
    pub fn new(map: &GridMap) -> Self {
        let solid = map.solid.iter().enumerate().filter(|(_, solid)| **solid);
        let cells: Vec<IVector> =
            solid.map(|(index, _)| IVector::new((index % map.width) as i64, (index / map.width) as i64)).collect();
        let voxels = Voxels::new(Vector::splat(map.resolution_m), &cells);
        Self { voxels, origin_w: Vec2::new(map.origin_m[0], map.origin_m[1]) }
    }

    /// How far a ray of unit direction runs before it meets a solid cell, metres, up to `range_m`.
    #[must_use]
    pub fn ray_m(&self, origin_w: Vec2, direction_w: Vec2, range_m: f64) -> Option<f64> {
        let ray = Ray::new(to_parry(origin_w - self.origin_w), to_parry(direction_w));
        self.voxels.cast_local_ray(&ray, range_m, true)
    }
}

/// A convex outline around its body's origin.
#[derive(Clone)]
pub struct Outline {
    polygon: ConvexPolygon,
    corners_b: Vec<Vec2>,
    radius_m: f64,
}

impl Outline {
    /// An outline of at least three corners, convex, counter-clockwise, body frame, metres; `None` if it is not that.
    #[must_use]
    pub fn new(corners_b: &[[f64; 2]]) -> Option<Self> {
        let corners_b: Vec<Vec2> = corners_b.iter().map(|[x, y]| Vec2::new(*x, *y)).collect();
        let polygon = ConvexPolygon::from_convex_polyline_unmodified(corners_b.iter().map(|c| to_parry(*c)).collect())?;
        let radius_m = corners_b.iter().map(Vec2::norm).fold(0.0, f64::max);
        Some(Self { polygon, corners_b, radius_m })
    }

    /// The corners, body frame, metres.
    #[must_use]
    pub fn corners_b(&self) -> &[Vec2] {
        &self.corners_b
    }

    /// Distance of the farthest corner from the body's origin, metres.
    #[must_use]
    pub fn radius_m(&self) -> f64 {
        self.radius_m
    }

    /// Gap to another outline, metres; 0 where they overlap.
    #[must_use]
    pub fn gap_to_outline_m(&self, pose_wb: Pose, other: &Self, other_wb: Pose) -> f64 {
        query::distance(&pose_of(pose_wb), &self.polygon, &pose_of(other_wb), &other.polygon)
            .map_or(0.0, |apart| apart.distance)
    }

    /// Gap to a disc, metres; 0 where they overlap.
    #[must_use]
    pub fn gap_to_disc_m(&self, pose_wb: Pose, disc: &Disc) -> f64 {
        let centre = Placement::from_translation(to_parry(disc.centre_w));
        query::distance(&pose_of(pose_wb), &self.polygon, &centre, &Ball::new(disc.radius_m))
            .map_or(0.0, |apart| apart.distance)
    }
}

fn to_parry(vector: Vec2) -> Vector {
    Vector::new(vector.x, vector.y)
}

fn pose_of(pose_wb: Pose) -> Placement {
    let heading = pose_wb.heading();
    Placement::from_parts(Vector::new(pose_wb.x_m, pose_wb.y_m), Rotation::from_cos_sin_unchecked(heading.x, heading.y))
}
