//! Walls: how far a disc is from them, where a ray meets them, and how far a body may travel before it touches.
//!
//! The only file that names parry, which speaks glam; nalgebra's types are converted here, at the border.
//!
//! Every outline is kept with its free side on the left: obstacles run clockwise, the enclosure counter-clockwise. Seen
//! from free space, a segment then faces the viewer exactly when it runs counter-clockwise around him.

use drover_config::{Circle, Polygon, World};
use drover_contract::Vec2;
use parry2d_f64::math::Vector;
use parry2d_f64::query::{PointQuery, Ray, RayCast};
use parry2d_f64::shape::Polyline;

/// Gap that a body keeps when it touches, metres: numerical room, so that rounding never makes an overlap.
pub const SKIN_M: f64 = 1e-4;
/// Bodies this near touch, metres: reported as a gap of 0.
pub const TOUCH_M: f64 = 2.0 * SKIN_M;
/// Smaller steps along one motion than this many mean sliding along a surface: that is a contact.
const SWEEP_STEPS_MAX: u32 = 512;
/// A motion checked up to this share is done: the rest is rounding, far below the skin.
const SHARE_DONE: f64 = 1.0 - 1e-9;
/// Corners nearer to each other than this are one, metres.
const CORNER_M: f64 = 1e-9;

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

/// Everything in a world that does not move.
pub struct Walls {
    outlines: Vec<Outline>,
    segments: Vec<Segment>,
    discs: Vec<Disc>,
    /// All segments in parry's tree; none for a world without polygons.
    tree: Option<Polyline>,
}

/// One polygon: its corners, and on which side of it there is room.
struct Outline {
    enclosure: bool,
    corners_w: Vec<Vec2>,
}

impl Walls {
    /// The walls of `world`. A polygon of fewer than three different corners encloses nothing and is left out.
    #[must_use]
    pub fn new(world: &World) -> Self {
        let outlines: Vec<Outline> =
            world.polygons.iter().map(Outline::new).filter(|outline| outline.corners_w.len() >= 3).collect();
        let segments: Vec<Segment> = outlines.iter().flat_map(Outline::segments).collect();
        let tree = (!segments.is_empty()).then(|| tree_of(&segments));
        Self { outlines, segments, discs: world.circles.iter().map(disc_of).collect(), tree }
    }

    /// All pieces of wall.
    #[must_use]
    pub fn segments(&self) -> &[Segment] {
        &self.segments
    }

    /// All round obstacles.
    #[must_use]
    pub fn discs(&self) -> &[Disc] {
        &self.discs
    }

    /// Whether a point lies where no body may be: within an obstacle or outside of the enclosure.
    #[must_use]
    pub fn is_solid(&self, point_w: Vec2) -> bool {
        let in_disc = |disc: &Disc| (point_w - disc.centre_w).norm() < disc.radius_m;
        self.outlines.iter().any(|outline| outline.holds(point_w) != outline.enclosure)
            || self.discs.iter().any(in_disc)
    }

    /// Distance from a point of free space to the nearest surface, metres; `None` in a world without walls.
    ///
    /// It does not know inside from outside of a polygon: a body that starts in free space never gets inside.
    #[must_use]
    pub fn distance_m(&self, point_w: Vec2) -> Option<f64> {
        let straight = self.tree.as_ref().map(|tree| tree.distance_to_local_point(to_parry(point_w), true));
        let round = self.discs.iter().map(|disc| (point_w - disc.centre_w).norm() - disc.radius_m);
        straight.into_iter().chain(round).min_by(f64::total_cmp)
    }

    /// Gap between a disc and the nearest surface, metres: below 0 if they overlap or if the centre is inside a solid;
    /// `None` in a world without walls.
    #[must_use]
    pub fn gap_m(&self, disc: &Disc) -> Option<f64> {
        let distance_m = self.distance_m(disc.centre_w)?;
        let signed_m = if self.is_solid(disc.centre_w) { -distance_m.abs() } else { distance_m };
        Some(signed_m - disc.radius_m)
    }

    /// How far a ray runs before it meets a surface, metres, up to `range_m`. `direction_w` has length 1.
    ///
    /// Parry's own ray cast: slower than [`crate::lidar`], and what that is checked against.
    #[must_use]
    pub fn ray_m(&self, origin_w: Vec2, direction_w: Vec2, range_m: f64) -> Option<f64> {
        let ray = Ray::new(to_parry(origin_w), to_parry(direction_w));
        let straight = self.tree.as_ref().and_then(|tree| tree.cast_local_ray(&ray, range_m, true));
        let round = self.discs.iter().filter_map(|disc| {
            let local = Ray::new(to_parry(origin_w - disc.centre_w), to_parry(direction_w));
            parry2d_f64::shape::Ball::new(disc.radius_m).cast_local_ray(&local, range_m, false)
        });
        straight.into_iter().chain(round).min_by(f64::total_cmp)
    }
}

impl Outline {
    fn new(polygon: &Polygon) -> Self {
        let mut corners_w: Vec<Vec2> = polygon.points_m.iter().map(|[x, y]| Vec2::new(*x, *y)).collect();
        corners_w.dedup_by(|a, b| (*a - *b).norm() < CORNER_M);
        while corners_w.len() > 1 && (corners_w[0] - corners_w[corners_w.len() - 1]).norm() < CORNER_M {
            corners_w.pop();
        }
        let counter_clockwise = twice_area(&corners_w) > 0.0;
        if counter_clockwise != polygon.enclosure {
            corners_w.reverse();
        }
        Self { enclosure: polygon.enclosure, corners_w }
    }

    fn segments(&self) -> impl Iterator<Item = Segment> + '_ {
        let next = self.corners_w.iter().cycle().skip(1);
        self.corners_w.iter().zip(next).map(|(from, to)| Segment { from_w: *from, to_w: *to })
    }

    /// Whether the point lies within the outline: a ray to the east crosses it an odd number of times.
    fn holds(&self, point_w: Vec2) -> bool {
        let crossings = self.segments().filter(|segment| {
            let (a, b) = (segment.from_w, segment.to_w);
            let spans = (a.y > point_w.y) != (b.y > point_w.y);
            spans && point_w.x < a.x + (point_w.y - a.y) / (b.y - a.y) * (b.x - a.x)
        });
        crossings.count() % 2 == 1
    }
}

/// Where along a motion, as a share 0..=1 of it, the first contact is; `None` if there is none.
///
/// `gap_at(share)` is the gap there, metres, and `length_m` bounds how much the gap can shrink over the whole motion
/// (the path lengths of all that move). Conservative advancement (Mirtich 1996): at a gap of g nothing can touch before
/// g of the way is used up, whatever the path's shape, so no speed tunnels. A motion that starts at a contact may go on
/// as long as every little step widens the gap.
pub(crate) fn first_contact(length_m: f64, gap_at: impl Fn(f64) -> f64) -> Option<f64> {
    let mut share = 0.0;
    let mut gap_m = gap_at(share);
    if length_m <= 0.0 || gap_m - length_m > SKIN_M {
        return None;
    }
    for _ in 0..SWEEP_STEPS_MAX {
        let room_m = gap_m - SKIN_M;
        let touching = room_m < SKIN_M / 2.0;
        let next = (share + room_m.max(SKIN_M / 2.0) / length_m).min(1.0);
        let next_gap_m = gap_at(next);
        if touching && next_gap_m <= gap_m {
            return Some(share);
        }
        if next >= SHARE_DONE {
            return None;
        }
        (share, gap_m) = (next, next_gap_m);
    }
    Some(share)
}

fn twice_area(corners: &[Vec2]) -> f64 {
    let next = corners.iter().cycle().skip(1);
    corners.iter().zip(next).map(|(a, b)| a.x * b.y - b.x * a.y).sum()
}

fn tree_of(segments: &[Segment]) -> Polyline {
    let vertices = segments.iter().flat_map(|segment| [to_parry(segment.from_w), to_parry(segment.to_w)]).collect();
    let pairs = (0..segments.len() as u32).map(|index| [2 * index, 2 * index + 1]).collect();
    Polyline::new(vertices, Some(pairs))
}

fn disc_of(circle: &Circle) -> Disc {
    let [x, y] = circle.centre_m;
    Disc { centre_w: Vec2::new(x, y), radius_m: circle.radius_m }
}

fn to_parry(vector: Vec2) -> Vector {
    Vector::new(vector.x, vector.y)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn room() -> World {
        World {
            name: "room".into(),
            polygons: vec![
                Polygon { enclosure: true, points_m: vec![[0.0, 0.0], [10.0, 0.0], [10.0, 6.0], [0.0, 6.0]] },
                Polygon { enclosure: false, points_m: vec![[4.0, 2.0], [5.0, 2.0], [5.0, 3.0], [4.0, 3.0]] },
            ],
            circles: vec![Circle { centre_m: [8.0, 3.0], radius_m: 0.5 }],
            ..World::default()
        }
    }

    fn gap(x: f64, y: f64, radius_m: f64) -> f64 {
        Walls::new(&room()).gap_m(&Disc { centre_w: Vec2::new(x, y), radius_m }).unwrap()
    }

    #[test]
    fn a_gap_is_measured_from_surface_to_surface() {
        assert!((gap(1.0, 1.5, 0.25) - 0.75).abs() < 1e-12, "left wall");
        assert!((gap(3.0, 2.5, 0.25) - 0.75).abs() < 1e-12, "box");
        assert!((gap(8.0, 4.5, 0.25) - 0.75).abs() < 1e-12, "circle");
        assert!((gap(3.0, 1.0, 0.0) - 1.0).abs() < 1e-12, "floor before the box's corner, which is sqrt 2 away");
    }

    #[test]
    fn a_gap_inside_a_solid_is_below_zero() {
        assert!((gap(4.5, 2.4, 0.25) + 0.65).abs() < 1e-12, "inside the box");
        assert!((gap(-1.0, 3.0, 0.25) + 1.25).abs() < 1e-12, "outside of the enclosure");
        assert!(gap(8.0, 3.1, 0.25) < 0.0, "inside the circle");
    }

    #[test]
    fn the_way_round_of_corners_does_not_matter() {
        let mut world = room();
        world.polygons.iter_mut().for_each(|polygon| polygon.points_m.reverse());
        let (a, b) = (Walls::new(&room()), Walls::new(&world));
        for (x, y) in [(1.0, 1.0), (4.5, 2.5), (11.0, 3.0), (7.6, 3.0), (3.9, 3.1)] {
            let disc = Disc { centre_w: Vec2::new(x, y), radius_m: 0.2 };
            assert_eq!(a.gap_m(&disc), b.gap_m(&disc));
        }
        let facing = |walls: &Walls| walls.segments().iter().filter(|s| faces(s, Vec2::new(1.0, 1.0))).count();
        assert_eq!((facing(&a), facing(&b)), (6, 6), "four walls and the near two sides of the box");
    }

    fn faces(segment: &Segment, viewer_w: Vec2) -> bool {
        (segment.from_w - viewer_w).perp(&(segment.to_w - viewer_w)) > 0.0
    }

    #[test]
    fn a_world_without_walls_has_no_gap_and_no_echo() {
        let walls = Walls::new(&World { name: "void".into(), polygons: vec![], circles: vec![], ..World::default() });
        assert_eq!(walls.gap_m(&Disc { centre_w: Vec2::zeros(), radius_m: 1.0 }), None);
        assert_eq!(walls.ray_m(Vec2::zeros(), Vec2::new(1.0, 0.0), 100.0), None);
        assert!(!walls.is_solid(Vec2::zeros()));
    }

    #[test]
    fn a_polygon_of_repeated_corners_is_left_out() {
        let flat = Polygon { enclosure: false, points_m: vec![[0.0, 0.0], [1.0, 0.0], [1.0, 0.0], [0.0, 0.0]] };
        let walls = Walls::new(&World { name: "flat".into(), polygons: vec![flat], circles: vec![], ..World::default() });
        assert!(walls.segments().is_empty());
    }

    #[test]
    fn a_ray_meets_the_nearest_surface() {
        let walls = Walls::new(&room());
        let east = Vec2::new(1.0, 0.0);
        assert!((walls.ray_m(Vec2::new(1.0, 2.5), east, 20.0).unwrap() - 3.0).abs() < 1e-12);
        assert!((walls.ray_m(Vec2::new(6.0, 3.0), east, 20.0).unwrap() - 1.5).abs() < 1e-12);
        assert_eq!(walls.ray_m(Vec2::new(1.0, 2.5), east, 2.9), None);
    }

    #[test]
    fn a_head_on_motion_stops_at_the_skin() {
        let share = first_contact(2.0, |share| 1.0 - 2.0 * share).unwrap();
        assert!((1.0 - 2.0 * share - SKIN_M).abs() < SKIN_M, "gap left: {}", 1.0 - 2.0 * share);
    }

    #[test]
    fn a_motion_away_from_a_contact_is_free_and_one_into_it_is_not() {
        assert_eq!(first_contact(0.02, |share| SKIN_M + 0.02 * share), None);
        assert_eq!(first_contact(0.02, |share| SKIN_M - 0.02 * share), Some(0.0));
        assert_eq!(first_contact(0.02, |share| -0.1 + 0.02 * share), None, "an overlap may only be left");
    }

    #[test]
    fn a_fast_motion_does_not_jump_through_what_is_thin() {
        // A post of 1 mm across the middle of a motion of 1 km.
        let gap_at = |share: f64| (share * 1000.0 - 500.0).abs() - 0.0005;
        let share = first_contact(1000.0, gap_at).unwrap();
        assert!(gap_at(share) > 0.0 && gap_at(share) < 1e-3);
    }
}
