//! Everything in a world that does not move, and the questions that are asked of it.
//!
//! Every outline is kept with its free side on the left: obstacles run clockwise, the enclosure counter-clockwise. Seen
//! from free space, a segment then faces the viewer exactly when it runs counter-clockwise around him. A thin wall
//! (polyline) is kept twice, once each way, so that each viewer sees one of the two.

use crate::geometry::{Disc, Outline, Segment, Tree};
use crate::grid::Grid;
use crate::map;
use crate::sight::Sight;
use drover_config::{GridMap, Polygon, World};
use drover_contract::{Pose, Vec2};
use std::sync::Arc;

/// Corners nearer to each other than this are one, metres.
const CORNER_M: f64 = 1e-9;
/// Round obstacles are looked for this far away at first, metres; then ever farther.
const DISC_SEARCH_M: f64 = 2.0;

/// Everything in a world that does not move.
pub struct Walls {
    loops: Vec<Loop>,
    map: Option<Arc<GridMap>>,
    segments: Vec<Segment>,
    discs: Vec<Disc>,
    disc_grid: Grid,
    disc_radius_m_max: f64,
    /// All segments in parry's tree; none for a world without any.
    tree: Option<Tree>,
    sight: Sight,
}

/// One polygon: its corners, and on which side of it there is room.
struct Loop {
    enclosure: bool,
    corners_w: Vec<Vec2>,
    low_w: Vec2,
    high_w: Vec2,
}

impl Walls {
    /// The walls of `world`. A polygon of fewer than three different corners encloses nothing and is left out.
    #[must_use]
    pub fn new(world: &World) -> Self {
        let loops: Vec<Loop> =
            world.polygons.iter().map(Loop::new).filter(|loop_| loop_.corners_w.len() >= 3).collect();
        let mut segments: Vec<Segment> = loops.iter().flat_map(Loop::segments).collect();
        segments.extend(world.polylines.iter().flat_map(|line| thin(&line.points_m)));
        segments.extend(world.map.iter().flat_map(|map| map::outline(map)));
        let disc = |circle: &drover_config::Circle| Disc {
            centre_w: Vec2::new(circle.centre_m[0], circle.centre_m[1]),
            radius_m: circle.radius_m,
        };
        let discs: Vec<Disc> = world.circles.iter().map(disc).collect();
        let disc_radius_m_max = discs.iter().map(|disc| disc.radius_m).fold(0.0, f64::max);
        let mut disc_grid = Grid::default();
        disc_grid.rebuild(discs.iter().map(|disc| disc.centre_w), DISC_SEARCH_M);
        Self {
            tree: Tree::new(&segments),
            sight: Sight::new(&segments, &discs),
            loops,
            map: world.map.clone(),
            segments,
            discs,
            disc_grid,
            disc_radius_m_max,
        }
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

    /// What a lidar sees of the walls.
    #[must_use]
    pub fn sight(&self) -> &Sight {
        &self.sight
    }

    /// Whether there is nothing at all.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.segments.is_empty() && self.discs.is_empty()
    }

    /// Whether a point lies where no body may be: within an obstacle or outside of the enclosure.
    #[must_use]
    pub fn is_solid(&self, point_w: Vec2) -> bool {
        let in_disc = |disc: &Disc| (point_w - disc.centre_w).norm() < disc.radius_m;
        self.loops.iter().any(|loop_| loop_.holds(point_w) != loop_.enclosure)
            || self.discs.iter().any(in_disc)
            || self.map.as_ref().is_some_and(|map| map::is_solid(map, point_w))
    }

    /// Distance from a point of free space to the nearest surface, metres; `None` in a world without walls.
    ///
    /// It does not know inside from outside of a polygon: a body that starts in free space never gets inside.
    #[must_use]
    pub fn distance_m(&self, point_w: Vec2) -> Option<f64> {
        let straight = self.tree.as_ref().map(|tree| tree.distance_m(point_w));
        smaller(straight, self.disc_distance_m(point_w))
    }

    /// Gap between an outline at `pose_wb` and the nearest surface, metres, 0 where they cross; `None` without walls.
    #[must_use]
    pub fn outline_gap_m(&self, outline: &Outline, pose_wb: Pose) -> Option<f64> {
        let straight = self.tree.as_ref().map(|tree| tree.gap_m(outline, pose_wb));
        let round = self.discs.iter().map(|disc| outline.gap_to_disc_m(pose_wb, disc)).min_by(f64::total_cmp);
        smaller(straight, round)
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
    /// Parry's own ray cast: slower than [`Sight`], and what that is checked against.
    #[must_use]
    pub fn ray_m(&self, origin_w: Vec2, direction_w: Vec2, range_m: f64) -> Option<f64> {
        let straight = self.tree.as_ref().and_then(|tree| tree.ray_m(origin_w, direction_w, range_m));
        let round = self.discs.iter().filter_map(|disc| disc.ray_m(origin_w, direction_w, range_m));
        straight.into_iter().chain(round).min_by(f64::total_cmp)
    }

    /// How many surfaces the straight line between two points of free space crosses, counted up to 16; a solid obstacle
    /// counts for one (its two surfaces), a thin wall for one.
    #[must_use]
    pub fn walls_between(&self, a_w: Vec2, b_w: Vec2) -> u32 {
        const COUNT_MAX: u32 = 16;
        /// From one surface on to the next, metres.
        const ON_M: f64 = 1e-6;
        let Some(direction_w) = (b_w - a_w).try_normalize(1e-9) else { return 0 };
        let (mut from_m, length_m, mut surfaces) = (0.0, (b_w - a_w).norm(), 0);
        while surfaces < COUNT_MAX {
            let Some(next_m) = self.ray_m(a_w + direction_w * from_m, direction_w, length_m - from_m) else { break };
            surfaces += 1;
            from_m += next_m + ON_M;
            if from_m >= length_m {
                break;
            }
        }
        surfaces.div_ceil(2)
    }

    /// Heap bytes held, parry's tree estimated by its segments.
    #[must_use]
    pub fn bytes(&self) -> usize {
        const TREE_BYTES_PER_SEGMENT: usize = 160;
        self.segments.capacity() * (size_of::<Segment>() + TREE_BYTES_PER_SEGMENT)
            + self.discs.capacity() * size_of::<Disc>()
            + self.disc_grid.bytes()
            + self.sight.bytes()
            + self.map.as_ref().map_or(0, |map| map.solid.len())
    }

    /// The nearest round obstacle: near ones first, so that a forest of thousands costs no more than a few.
    fn disc_distance_m(&self, point_w: Vec2) -> Option<f64> {
        let distance_m = |disc: &Disc| (point_w - disc.centre_w).norm() - disc.radius_m;
        let mut search_m = DISC_SEARCH_M;
        for _ in 0..3 {
            let near = self.disc_grid.near(point_w, search_m + self.disc_radius_m_max);
            let nearest_m = near.map(|entry| distance_m(&self.discs[entry.index as usize])).min_by(f64::total_cmp);
            if nearest_m.is_some_and(|nearest_m| nearest_m <= search_m) {
                return nearest_m;
            }
            search_m *= 4.0;
        }
        self.discs.iter().map(distance_m).min_by(f64::total_cmp)
    }
}

impl Loop {
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
        let low_w = corners_w.iter().fold(Vec2::repeat(f64::INFINITY), |low, corner| low.inf(corner));
        let high_w = corners_w.iter().fold(Vec2::repeat(f64::NEG_INFINITY), |high, corner| high.sup(corner));
        Self { enclosure: polygon.enclosure, corners_w, low_w, high_w }
    }

    fn segments(&self) -> impl Iterator<Item = Segment> + '_ {
        let next = self.corners_w.iter().cycle().skip(1);
        self.corners_w.iter().zip(next).map(|(from, to)| Segment { from_w: *from, to_w: *to })
    }

    /// Whether the point lies within the outline: a ray to the east crosses it an odd number of times.
    fn holds(&self, point_w: Vec2) -> bool {
        let (low, high) = (self.low_w, self.high_w);
        if point_w.x < low.x || point_w.y < low.y || point_w.x > high.x || point_w.y > high.y {
            return false;
        }
        let crossings = self.segments().filter(|segment| {
            let (a, b) = (segment.from_w, segment.to_w);
            let spans = (a.y > point_w.y) != (b.y > point_w.y);
            spans && point_w.x < a.x + (point_w.y - a.y) / (b.y - a.y) * (b.x - a.x)
        });
        crossings.count() % 2 == 1
    }
}

/// A thin wall, there and back.
fn thin(points_m: &[[f64; 2]]) -> impl Iterator<Item = Segment> + '_ {
    let point = |[x, y]: [f64; 2]| Vec2::new(x, y);
    let there = points_m.windows(2).map(move |ends| Segment { from_w: point(ends[0]), to_w: point(ends[1]) });
    there.filter(|piece| (piece.to_w - piece.from_w).norm() >= CORNER_M).flat_map(|piece| {
        let back = Segment { from_w: piece.to_w, to_w: piece.from_w };
        [piece, back]
    })
}

fn twice_area(corners: &[Vec2]) -> f64 {
    let next = corners.iter().cycle().skip(1);
    corners.iter().zip(next).map(|(a, b)| a.x * b.y - b.x * a.y).sum()
}

/// The smaller of two that may be absent.
pub(crate) fn smaller(a: Option<f64>, b: Option<f64>) -> Option<f64> {
    match (a, b) {
        (Some(a), Some(b)) => Some(a.min(b)),
        (one, other) => one.or(other),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use drover_config::Circle;

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
        let walls =
            Walls::new(&World { name: "flat".into(), polygons: vec![flat], circles: vec![], ..World::default() });
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
}
