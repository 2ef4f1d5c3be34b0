//! Overlaps, ways and rays worked out from scratch, edge by edge: what the arena's own measuring is checked against.

use super::{Arena, BodySpec};
use crate::geometry::{Disc, Segment};
use crate::walls::Walls;
use drover_contract::math::sin;
use drover_contract::{Pose, Twist, Vec2, wrap};
use proptest::prelude::*;

/// Parts that a step's arc is checked in.
const PARTS: u32 = 16;

/// A body or a round obstacle, world frame.
#[derive(Clone, Debug)]
pub(super) enum Shape {
    Disc(Disc),
    /// Convex, counter-clockwise.
    Polygon(Vec<Vec2>),
}

/// The bodies where they are.
pub(super) fn shapes(arena: &Arena, specs: &[BodySpec]) -> Vec<Shape> {
    let shape = |(n, spec): (usize, &BodySpec)| {
        let pose_wb = arena.state(n).pose_wb;
        match &spec.outline {
            None => Shape::Disc(Disc { centre_w: pose_wb.position(), radius_m: spec.body.radius_m }),
            Some(outline) => {
                Shape::Polygon(outline.corners_b().iter().map(|corner| pose_wb.transform(*corner)).collect())
            }
        }
    };
    specs.iter().enumerate().map(shape).collect()
}

impl Shape {
    /// Its edges; a disc's is its centre.
    fn edges(&self) -> Vec<Segment> {
        match self {
            Self::Disc(disc) => vec![Segment { from_w: disc.centre_w, to_w: disc.centre_w }],
            Self::Polygon(corners) => {
                let next = corners.iter().cycle().skip(1);
                corners.iter().zip(next).map(|(from, to)| Segment { from_w: *from, to_w: *to }).collect()
            }
        }
    }

    fn radius_m(&self) -> f64 {
        if let Self::Disc(disc) = self { disc.radius_m } else { 0.0 }
    }

    fn middle_w(&self) -> Vec2 {
        let edges = self.edges();
        edges.iter().map(|edge| edge.from_w).sum::<Vec2>() / edges.len() as f64
    }

    fn holds(&self, point_w: Vec2) -> bool {
        match self {
            Self::Disc(disc) => (point_w - disc.centre_w).norm() < disc.radius_m,
            Self::Polygon(_) => self.edges().iter().all(|edge| side(edge, point_w) > 0.0),
        }
    }

    /// Gap to a segment, metres, 0 or less where they overlap.
    fn gap_m(&self, segment: &Segment) -> f64 {
        if self.holds(segment.from_w) {
            return 0.0;
        }
        self.edges().iter().map(|edge| apart_m(edge, segment)).fold(f64::INFINITY, f64::min) - self.radius_m()
    }

    /// The same to another shape.
    fn gap_to_m(&self, other: &Self) -> f64 {
        let inside = |a: &Self, b: &Self| b.edges().iter().any(|edge| a.holds(edge.from_w));
        if inside(self, other) || inside(other, self) {
            return 0.0;
        }
        other.edges().iter().map(|edge| self.gap_m(edge)).fold(f64::INFINITY, f64::min) - other.radius_m()
    }

    /// How far a ray of unit direction runs before it enters, metres.
    pub(super) fn ray_m(&self, from_w: Vec2, along_w: Vec2) -> Option<f64> {
        if let Self::Disc(disc) = self {
            let to = disc.centre_w - from_w;
            let (ahead, aside) = (to.dot(&along_w), to.perp(&along_w));
            let depth2 = disc.radius_m * disc.radius_m - aside * aside;
            return (depth2 >= 0.0 && ahead > 0.0).then(|| ahead - depth2.sqrt());
        }
        let met = |edge: &Segment| {
            let (start, way) = (edge.from_w - from_w, edge.to_w - edge.from_w);
            let across = along_w.perp(&way);
            let (range_m, share) = (start.perp(&way) / across, start.perp(&along_w) / across);
            (across.abs() > 1e-12 && range_m > 0.0 && (0.0..=1.0).contains(&share)).then_some(range_m)
        };
        self.edges().iter().filter_map(met).min_by(f64::total_cmp)
    }
}

/// No body overlaps a wall, a round obstacle or another body.
pub(super) fn assert_nothing_overlaps(walls: &Walls, shapes: &[Shape]) -> Result<(), TestCaseError> {
    for (n, shape) in shapes.iter().enumerate() {
        for segment in near(walls, shape.middle_w(), 1.0) {
            let gap_m = shape.gap_m(segment);
            prop_assert!(gap_m > 0.0, "robot {n} overlaps {segment:?} by {gap_m}: {shape:?}");
        }
        let obstacles = walls.discs().iter().map(|disc| Shape::Disc(*disc));
        for (m, other) in obstacles.chain(shapes[n + 1..].iter().cloned()).enumerate() {
            let gap_m = shape.gap_to_m(&other);
            prop_assert!(gap_m > 0.0, "robot {n} overlaps the {m}th thing by {gap_m}: {shape:?} {other:?}");
        }
    }
    Ok(())
}

/// The way of a body's centre in one step, an arc, crosses no wall and no round obstacle.
pub(super) fn assert_no_way_crosses(walls: &Walls, from_wb: Pose, to_wb: Pose) -> Result<(), TestCaseError> {
    let turn_rad = wrap(to_wb.yaw_rad - from_wb.yaw_rad);
    // The step's twist: the one that leads from the one pose to the other in one second.
    let chord_wb = Pose::new(0.0, 0.0, from_wb.yaw_rad + turn_rad / 2.0);
    let chord_m = (to_wb.position() - from_wb.position()).dot(&chord_wb.heading());
    let bow = if turn_rad.abs() < 1e-9 { 1.0 } else { turn_rad / 2.0 / sin(turn_rad / 2.0) };
    let twist_b = Twist::new(chord_m * bow, turn_rad);
    prop_assert!((from_wb.advance(twist_b, 1.0).position() - to_wb.position()).norm() < 1e-6, "a step is no arc");
    let at = |part: u32| from_wb.advance(twist_b, f64::from(part) / f64::from(PARTS)).position();
    for part in 0..PARTS {
        let piece = Segment { from_w: at(part), to_w: at(part + 1) };
        for segment in near(walls, piece.from_w, 1.0) {
            prop_assert!(!cross(&piece, segment), "{from_wb:?} -> {to_wb:?} crosses {segment:?}");
        }
        let obstacle = walls.discs().iter().find(|disc| Shape::Disc(**disc).gap_m(&piece) <= 0.0);
        prop_assert!(obstacle.is_none(), "{from_wb:?} -> {to_wb:?} crosses {obstacle:?}");
    }
    Ok(())
}

/// Walls that come within a distance of a place, and some more.
fn near(walls: &Walls, place_w: Vec2, within_m: f64) -> impl Iterator<Item = &Segment> {
    let place = Segment { from_w: place_w, to_w: place_w };
    walls.segments().iter().filter(move |segment| apart_m(&place, segment) < within_m)
}

/// Above 0 if a point is on the left of an edge.
fn side(edge: &Segment, point_w: Vec2) -> f64 {
    (edge.to_w - edge.from_w).perp(&(point_w - edge.from_w))
}

fn cross(a: &Segment, b: &Segment) -> bool {
    let between = |edge: &Segment, other: &Segment| side(edge, other.from_w) * side(edge, other.to_w) < 0.0;
    between(a, b) && between(b, a)
}

fn apart_m(a: &Segment, b: &Segment) -> f64 {
    if cross(a, b) {
        return 0.0;
    }
    let ends = [point_m(a, b.from_w), point_m(a, b.to_w), point_m(b, a.from_w), point_m(b, a.to_w)];
    ends.into_iter().fold(f64::INFINITY, f64::min)
}

fn point_m(edge: &Segment, point_w: Vec2) -> f64 {
    let way = edge.to_w - edge.from_w;
    let share = if way.norm_squared() > 0.0 { (point_w - edge.from_w).dot(&way) / way.norm_squared() } else { 0.0 };
    (edge.from_w + way * share.clamp(0.0, 1.0) - point_w).norm()
}
