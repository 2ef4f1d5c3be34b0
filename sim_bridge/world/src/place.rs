//! Where everything is: walls, movers, bodies, and who is near whom. It is read by all and changed by the arena alone.

use crate::arena::BodySpec;
use crate::body::Motion;
use crate::geometry::{Disc, Outline};
use crate::grid::Grid;
use crate::lidar::{Scenery, Silhouette};
use crate::movers::{GAP_M, Mover};
use crate::radio::Scene;
use crate::sight::Sight;
use crate::walls::{Walls, smaller};
use drover_config::World;
use drover_contract::{Pose, Vec2};
use std::sync::Arc;

/// Another body is looked for this far from surface to surface at first, metres; then ever farther.
const SEARCH_M: f64 = 1.0;
/// Doublings of that until all bodies are looked at, one after the other.
const SEARCHES_MAX: u32 = 8;

/// Walls, movers and bodies.
pub struct Place {
    walls: Walls,
    movers: Vec<Mover>,
    poses_wb: Vec<Pose>,
    /// The disc that holds each body.
    discs: Vec<Disc>,
    outlines: Vec<Option<Arc<Outline>>>,
    grid: Grid,
    radius_m_max: f64,
}

impl Place {
    /// A place with bodies at their starts.
    #[must_use]
    pub(crate) fn new(world: &World, bodies: &[BodySpec]) -> Self {
        let disc = |spec: &BodySpec| Disc { centre_w: spec.start.position(), radius_m: spec.body.radius_m };
        let mut place = Self {
            walls: Walls::new(world),
            movers: world.movers.iter().map(Mover::new).collect(),
            poses_wb: bodies.iter().map(|spec| spec.start).collect(),
            discs: bodies.iter().map(disc).collect(),
            outlines: bodies.iter().map(|spec| spec.outline.clone()).collect(),
            grid: Grid::default(),
            radius_m_max: bodies.iter().map(|spec| spec.body.radius_m).fold(0.0, f64::max),
        };
        place.sort();
        place
    }

    /// Everything that does not move.
    #[must_use]
    pub fn walls(&self) -> &Walls {
        &self.walls
    }

    /// The obstacles that move, in the order of the world's list.
    #[must_use]
    pub fn movers(&self) -> &[Mover] {
        &self.movers
    }

    /// Where body `robot` is.
    ///
    /// # Panics
    /// If there is no such robot; so do all functions here that take one.
    #[must_use]
    pub fn pose_wb(&self, robot: usize) -> Pose {
        self.poses_wb[robot]
    }

    /// The discs that hold the bodies, in the order of the swarm's list.
    #[must_use]
    pub fn discs(&self) -> &[Disc] {
        &self.discs
    }

    /// What body `robot`'s lidar has around it.
    #[must_use]
    pub fn seen_by(&self, robot: usize) -> SeenBy<'_> {
        SeenBy { place: self, robot }
    }

    /// Every body whose disc may be within `range_m` of a point, by index, and some more.
    pub fn bodies_near(&self, centre_w: Vec2, range_m: f64) -> impl Iterator<Item = usize> + '_ {
        self.grid.near(centre_w, range_m + self.radius_m_max).map(|entry| entry.index as usize)
    }

    /// Every mover goes on for `dt_s`, or waits for who is in its way. How far the fastest one got, metres.
    pub(crate) fn move_movers(&mut self, dt_s: f64) -> f64 {
        let mut way_m_max: f64 = 0.0;
        for index in 0..self.movers.len() {
            let way_m = self.movers[index].way_m(dt_s);
            if self.is_free(&self.movers[index], way_m) {
                self.movers[index].go(dt_s);
                way_m_max = way_m_max.max(way_m);
            } else {
                self.movers[index].wait();
            }
        }
        way_m_max
    }

    fn is_free(&self, mover: &Mover, way_m: f64) -> bool {
        let Disc { centre_w, radius_m } = mover.disc();
        let mut near = self.bodies_near(centre_w, radius_m + way_m + GAP_M);
        near.all(|robot| mover.is_free(way_m, |disc| self.disc_gap_m(robot, self.poses_wb[robot], disc)))
    }

    /// Gap from a body's surface to a disc if it were at `pose_wb`, metres.
    fn disc_gap_m(&self, robot: usize, pose_wb: Pose, disc: &Disc) -> f64 {
        match &self.outlines[robot] {
            Some(outline) => outline.gap_to_disc_m(pose_wb, disc),
            None => (pose_wb.position() - disc.centre_w).norm() - disc.radius_m - self.discs[robot].radius_m,
        }
    }

    pub(crate) fn move_to(&mut self, robot: usize, pose_wb: Pose) {
        self.poses_wb[robot] = pose_wb;
        self.discs[robot].centre_w = pose_wb.position();
    }

    /// Bodies have moved: find out anew who is near whom.
    pub(crate) fn sort(&mut self) {
        let Self { grid, discs, radius_m_max, .. } = self;
        grid.rebuild(discs.iter().map(|disc| disc.centre_w), 2.5 * *radius_m_max);
    }

    /// How far turning alone moves the farthest part of a body, metres: a disc does not move by turning.
    pub(crate) fn turn_m(&self, robot: usize, motion: &Motion) -> f64 {
        let outline = self.outlines[robot].as_ref();
        outline.map_or(0.0, |outline| (motion.twist_b.yaw_rate_radps * motion.dt_s).abs() * outline.radius_m())
    }

    /// Gap from a body's surface to the nearest wall or mover if it were at `pose_wb` in free space, metres; `None`
    /// without any.
    pub(crate) fn wall_gap_m(&self, robot: usize, pose_wb: Pose) -> Option<f64> {
        let still_m = match &self.outlines[robot] {
            Some(outline) => self.walls.outline_gap_m(outline, pose_wb),
            None => self.walls.distance_m(pose_wb.position()).map(|away_m| away_m - self.discs[robot].radius_m),
        };
        let gaps_m = self.movers.iter().map(|mover| self.disc_gap_m(robot, pose_wb, &mover.disc()));
        smaller(still_m, gaps_m.min_by(f64::total_cmp))
    }

    /// The same where it is, below 0 if it is inside of a solid.
    pub(crate) fn signed_wall_gap_m(&self, robot: usize) -> Option<f64> {
        let gap_m = self.wall_gap_m(robot, self.poses_wb[robot])?;
        Some(if self.walls.is_solid(self.discs[robot].centre_w) { -gap_m.abs() } else { gap_m })
    }

    /// Gap between two bodies if they were at these poses, metres. What is farther apart than `enough_m` is not
    /// measured any better than by their discs.
    pub(crate) fn body_gap_m(&self, [a, b]: [usize; 2], [a_wb, b_wb]: [Pose; 2], enough_m: f64) -> f64 {
        let (disc_a, disc_b) = (self.discs[a], self.discs[b]);
        let apart_m = (a_wb.position() - b_wb.position()).norm() - disc_a.radius_m - disc_b.radius_m;
        let at = |disc: Disc, pose_wb: Pose| Disc { centre_w: pose_wb.position(), ..disc };
        match (&self.outlines[a], &self.outlines[b]) {
            (None, None) => apart_m,
            _ if apart_m > enough_m => apart_m,
            (Some(outline), None) => outline.gap_to_disc_m(a_wb, &at(disc_b, b_wb)),
            (None, Some(outline)) => outline.gap_to_disc_m(b_wb, &at(disc_a, a_wb)),
            // Which of two outlines is measured from decides the last bits: it must not be the list's order that does.
            (Some(one), Some(other)) if goes_first(&a_wb, &b_wb) => one.gap_to_outline_m(a_wb, other, b_wb),
            (Some(one), Some(other)) => other.gap_to_outline_m(b_wb, one, a_wb),
        }
    }

    /// Gap to the nearest other body, metres; `None` if there is no other.
    pub(crate) fn nearest_body_m(&self, robot: usize) -> Option<f64> {
        if self.discs.len() < 2 {
            return None;
        }
        let disc = self.discs[robot];
        let mut search_m = SEARCH_M;
        for _ in 0..SEARCHES_MAX {
            let near = self.bodies_near(disc.centre_w, search_m + disc.radius_m);
            let nearest_m = self.nearest_of(robot, near);
            if nearest_m <= search_m {
                return Some(nearest_m);
            }
            search_m *= 2.0;
        }
        Some(self.nearest_of(robot, 0..self.discs.len()))
    }

    fn nearest_of(&self, robot: usize, others: impl Iterator<Item = usize>) -> f64 {
        let mut nearest_m = f64::INFINITY;
        for other in others.filter(|other| *other != robot) {
            let poses_wb = [self.poses_wb[robot], self.poses_wb[other]];
            nearest_m = nearest_m.min(self.body_gap_m([robot, other], poses_wb, nearest_m));
        }
        nearest_m
    }

    /// Heap bytes held, the walls' apart.
    pub(crate) fn bytes(&self) -> usize {
        self.poses_wb.capacity() * size_of::<Pose>()
            + self.discs.capacity() * size_of::<Disc>()
            + self.movers.iter().map(|mover| size_of::<Mover>() + mover.bytes()).sum::<usize>()
            + self.outlines.capacity() * size_of::<Option<Arc<Outline>>>()
            + self.grid.bytes()
    }
}

fn goes_first(a_wb: &Pose, b_wb: &Pose) -> bool {
    a_wb.x_m.total_cmp(&b_wb.x_m).then(a_wb.y_m.total_cmp(&b_wb.y_m)).is_le()
}

/// A place as one body's lidar has it around itself.
pub struct SeenBy<'a> {
    place: &'a Place,
    robot: usize,
}

impl Scenery for SeenBy<'_> {
    fn sight(&self) -> &Sight {
        self.place.walls.sight()
    }

    fn bodies_near(&self, from_w: Vec2, range_m: f64, see: &mut dyn FnMut(Silhouette<'_>)) {
        let is_near = |disc: &Disc| {
            let reach_m = range_m + disc.radius_m;
            (disc.centre_w - from_w).norm_squared() <= reach_m * reach_m
        };
        let movers = self.place.movers.iter().map(Mover::disc);
        movers.filter(is_near).for_each(|disc| see(Silhouette::Disc(disc)));
        for other in self.place.bodies_near(from_w, range_m).filter(|other| *other != self.robot) {
            let disc = self.place.discs[other];
            if !is_near(&disc) {
                continue;
            }
            see(match &self.place.outlines[other] {
                Some(outline) => Silhouette::Outline(outline.corners_b(), self.place.poses_wb[other]),
                None => Silhouette::Disc(disc),
            });
        }
    }
}

impl Scene for Place {
    fn position_w(&self, robot: usize) -> Option<Vec2> {
        self.discs.get(robot).map(|disc| disc.centre_w)
    }

    fn for_each_near(&self, centre_w: Vec2, range_m: f64, visit: &mut dyn FnMut(usize)) {
        self.grid.near(centre_w, range_m).for_each(|entry| visit(entry.index as usize));
    }

    fn walls_between(&self, a_w: Vec2, b_w: Vec2) -> u32 {
        self.walls.walls_between(a_w, b_w)
    }
}
