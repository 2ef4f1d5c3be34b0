//! All bodies in one place: they move together, stop each other, and see each other.
//!
//! Within one step all bodies move at once, each along its own arc. The first contact of any two ends the step for both
//! of them; the others go on, and may meet those two where they now stand. So what happens depends on where the bodies
//! are and not on their order in the list. Two bodies never overlap, and no body overlaps a wall. Before that the
//! movers move ([`crate::movers`]), which are like walls to bodies that move then.
//!
//! Sensing changes nothing but the sensor: [`Arena::eyes`] lends the place to as many threads as there are.

use crate::body::{Body, BodyParams, Motion};
use crate::clearance::Clearance;
use crate::contacts::{Contacts, Plan};
use crate::firmware::BodyState;
use crate::geometry::Outline;
use crate::lidar::{Lidar, LidarParams};
use crate::place::Place;
use crate::sweep::{SKIN_M, TOUCH_M, first_contact};
use crate::walls::{Walls, smaller};
use drover_config::{Kind, Robot, Swarm, World};
use drover_contract::{Pose, Scan, Stamp, Twist, Vec2};
use rayon::prelude::*;
use std::collections::BTreeMap;
use std::sync::Arc;

/// Bodies that one thread takes at once: fewer are not worth another thread's waking. What is done to a body side by
/// side reads the place and writes that body alone.
const BODIES_PER_JOB: usize = 512;

/// One body to put into the arena.
#[derive(Clone)]
pub struct BodySpec {
    /// The robot's id: its chance depends on it, not on its place in the list.
    pub key: u64,
    /// Where it stands at first.
    pub start: Pose,
    /// Its chassis.
    pub body: BodyParams,
    /// The convex outline that it really has; none: its disc.
    pub outline: Option<Arc<Outline>>,
    /// Its lidar.
    pub lidar: LidarParams,
}

impl BodySpec {
    /// The bodies of a swarm, in the file's order. Robots of one kind share their outline.
    #[must_use]
    pub fn all_of(swarm: &Swarm) -> Vec<Self> {
        let outline = |kind: &Kind| Outline::new(&kind.body.footprint_m).map(Arc::new);
        let outlines: BTreeMap<&str, Option<Arc<Outline>>> =
            swarm.kinds.iter().map(|(name, kind)| (name.as_str(), outline(kind))).collect();
        let spec = |robot: &Robot| {
            let kind = swarm.kind_of(robot);
            Self {
                key: u64::from(robot.id),
                start: Pose::new(robot.start.x_m, robot.start.y_m, robot.start.yaw_rad),
                body: BodyParams::of(kind),
                outline: outlines.get(robot.kind.as_str()).cloned().flatten(),
                lidar: LidarParams::of(kind),
            }
        };
        swarm.robots.iter().map(spec).collect()
    }
}

/// The place with everything in it.
pub struct Arena {
    place: Place,
    members: Vec<Member>,
    lidars: Vec<Lidar>,
    contacts: Contacts,
    /// Kept from step to step for their memory only.
    plans: Vec<Plan>,
}

/// The place and its bodies, to be looked at by many at once.
#[derive(Clone, Copy)]
pub struct Eyes<'a> {
    place: &'a Place,
    members: &'a [Member],
}

impl<'a> Eyes<'a> {
    /// The place as it is.
    #[must_use]
    pub fn place(&self) -> &'a Place {
        self.place
    }

    /// Body `robot`, as its own sensors could know it.
    ///
    /// # Panics
    /// If there is no such robot.
    #[must_use]
    pub fn state(&self, robot: usize) -> BodyState {
        self.members[robot].state()
    }
}

struct Member {
    body: Body,
    in_contact: bool,
    wall: Clearance,
    robot: Clearance,
}

impl Arena {
    /// All bodies at rest. Bodies that overlap at first may only move apart.
    #[must_use]
    pub fn new(world: &World, bodies: &[BodySpec], seed: u64) -> Self {
        let member = |spec: &BodySpec| Member {
            body: Body::new(spec.body, spec.start, seed, spec.key),
            in_contact: false,
            wall: Clearance::default(),
            robot: Clearance::default(),
        };
        let mut arena = Self {
            place: Place::new(world, bodies),
            members: bodies.iter().map(member).collect(),
            lidars: bodies.iter().map(|spec| Lidar::new(spec.lidar, seed, spec.key)).collect(),
            contacts: Contacts::default(),
            plans: Vec::new(),
        };
        for (robot, member) in arena.members.iter_mut().enumerate() {
            member.measure(&arena.place, robot, true);
        }
        arena
    }

    /// How many bodies there are.
    #[must_use]
    pub fn robot_count(&self) -> usize {
        self.members.len()
    }

    /// Move all bodies by `dt_s` seconds towards `demands` (one a body; a body without one is asked to stand).
    pub fn step(&mut self, dt_s: f64, demands: &[Twist]) {
        self.move_movers(dt_s);
        self.plan(dt_s, demands);
        self.contacts.resolve(&self.place, &mut self.plans);
        let way_m_max = self.plans.iter().map(|plan| plan.sweep_m * plan.share).fold(0.0, f64::max);
        let moves = self.members.par_iter_mut().zip(self.plans.par_iter()).zip(self.lidars.par_iter_mut());
        moves.with_min_len(BODIES_PER_JOB).for_each(|((member, plan), lidar)| {
            member.body.carry_out(&plan.motion, plan.share);
            member.in_contact = plan.share < 1.0;
            lidar.note(member.body.pose_wb());
        });
        for (robot, member) in self.members.iter().enumerate() {
            self.place.move_to(robot, member.body.pose_wb());
        }
        self.place.sort();
        let Self { place, members, plans, .. } = self;
        let moved = members.par_iter_mut().zip(plans.par_iter()).enumerate();
        moved.with_min_len(BODIES_PER_JOB).for_each(|(robot, (member, plan))| {
            let way_m = plan.sweep_m * plan.share;
            member.wall.moved(way_m);
            member.robot.moved(way_m + way_m_max);
            member.measure(place, robot, false);
        });
    }

    /// Put each body where `poses_wb` says, straight and in `dt_s`: points of the theory books, which nothing stops.
    /// Gaps are measured as for any motion; bodies beyond the list stay. Movers move first, as in a step.
    pub fn glide(&mut self, dt_s: f64, poses_wb: &[Pose]) {
        self.move_movers(dt_s);
        let Self { place, members, lidars, .. } = self;
        let mut ways_m = Vec::with_capacity(members.len());
        for (robot, (member, pose_wb)) in members.iter_mut().zip(poses_wb).enumerate() {
            let before_w = member.body.pose_wb().position();
            member.body.glide(*pose_wb, dt_s);
            ways_m.push((pose_wb.position() - before_w).norm());
            lidars[robot].note(*pose_wb);
            place.move_to(robot, *pose_wb);
        }
        place.sort();
        let way_m_max = ways_m.iter().copied().fold(0.0, f64::max);
        for (robot, (member, way_m)) in members.iter_mut().zip(ways_m).enumerate() {
            member.wall.moved(way_m);
            member.robot.moved(way_m + way_m_max);
            member.measure(place, robot, false);
        }
    }

    /// Body `robot`, as its own sensors could know it.
    ///
    /// # Panics
    /// If there is no such robot; so do all functions here that take one.
    #[must_use]
    pub fn state(&self, robot: usize) -> BodyState {
        self.members[robot].state()
    }

    /// What body `robot`'s lidar sees now: walls, movers, other bodies.
    #[must_use]
    pub fn cast(&mut self, now: Stamp, robot: usize) -> Scan {
        let pose_wb = self.members[robot].body.pose_wb();
        self.lidars[robot].scan(now, pose_wb, &self.place.seen_by(robot))
    }

    /// All there is to see, and every lidar: what is needed to take all scans side by side.
    pub fn eyes(&mut self) -> (Eyes<'_>, &mut [Lidar]) {
        (Eyes { place: &self.place, members: &self.members }, &mut self.lidars)
    }

    /// The place as it is.
    #[must_use]
    pub fn place(&self) -> &Place {
        &self.place
    }

    /// How far body `robot` has travelled, metres.
    #[must_use]
    pub fn path_m(&self, robot: usize) -> f64 {
        self.members[robot].body.path_m()
    }

    /// Smallest gap so far between body `robot` and any other, metres, 0 from the first touch on; `None` if it is
    /// alone. As exact as [`Clearance`] says.
    #[must_use]
    pub fn gap_robot_m_min(&self, robot: usize) -> Option<f64> {
        self.members[robot].robot.smallest_m()
    }

    /// Where the movers are and their radii, metres, in the order of the world's list; [`Place::movers`] knows more.
    pub fn movers(&self) -> impl Iterator<Item = (Vec2, f64)> + '_ {
        self.place.movers().iter().map(|mover| (mover.disc().centre_w, mover.disc().radius_m))
    }

    /// Smallest gap so far between body `robot` and any wall or mover, metres, 0 from the first touch on; `None`
    /// without any.
    #[must_use]
    pub fn gap_wall_m_min(&self, robot: usize) -> Option<f64> {
        self.members[robot].wall.smallest_m()
    }

    /// Smallest gap so far between any two bodies, metres.
    #[must_use]
    pub fn min_gap_robot_m(&self) -> Option<f64> {
        self.members.iter().map(|member| member.robot.smallest_m()).fold(None, smaller)
    }

    /// Smallest gap so far between any body and any wall or mover, metres.
    #[must_use]
    pub fn min_gap_wall_m(&self) -> Option<f64> {
        self.members.iter().map(|member| member.wall.smallest_m()).fold(None, smaller)
    }

    /// Everything in the place that does not move.
    #[must_use]
    pub fn walls(&self) -> &Walls {
        self.place.walls()
    }

    /// Heap bytes held by bodies, lidars and what finds them; the walls' apart (second).
    #[must_use]
    pub fn bytes(&self) -> (usize, usize) {
        let lidars: usize = self.lidars.iter().map(|lidar| size_of::<Lidar>() + lidar.bytes()).sum();
        let bodies = self.members.capacity() * size_of::<Member>() + self.plans.capacity() * size_of::<Plan>();
        (lidars + bodies + self.contacts.bytes() + self.place.bytes(), self.place.walls().bytes())
    }

    /// Movers go on; what bodies know of their gaps is then that much less.
    fn move_movers(&mut self, dt_s: f64) {
        let way_m = self.place.move_movers(dt_s);
        if way_m > 0.0 {
            self.members.iter_mut().for_each(|member| member.wall.moved(way_m));
        }
    }

    /// Each body's motion, clipped at the walls and movers.
    fn plan(&mut self, dt_s: f64, demands: &[Twist]) {
        let Self { place, members, plans, .. } = self;
        let planned = members.par_iter_mut().enumerate().with_min_len(BODIES_PER_JOB).map(|(robot, member)| {
            let motion = member.body.plan(demands.get(robot).copied().unwrap_or(Twist::ZERO), dt_s);
            let sweep_m = motion.length_m + place.turn_m(robot, &motion);
            let mut plan = Plan { from_wb: member.body.pose_wb(), motion, share: 1.0, sweep_m };
            // What was measured before often says already that no wall can be reached.
            if member.wall.bound_m().is_some_and(|gap_m| gap_m - sweep_m <= SKIN_M) {
                let gap_at = |share| place.wall_gap_m(robot, plan.pose_at(share)).unwrap_or(f64::MAX);
                if let Some(share) = first_contact(sweep_m, gap_at) {
                    plan.share = share;
                }
            }
            plan
        });
        planned.collect_into_vec(plans);
    }
}

impl Member {
    /// Bring running minima and contacts up to date. Only at first it is asked whether a body is inside of a solid: who
    /// is in free space stays there.
    fn measure(&mut self, place: &Place, robot: usize, first: bool) {
        if self.wall.is_due() {
            let here_wb = place.pose_wb(robot);
            let gap_m = if first { place.signed_wall_gap_m(robot) } else { place.wall_gap_m(robot, here_wb) };
            self.wall.measured(gap_m);
        } else {
            self.wall.kept();
        }
        if self.robot.is_due() {
            self.robot.measured(place.nearest_body_m(robot));
        } else {
            self.robot.kept();
        }
        let touches = |clearance: &Clearance| clearance.bound_m().is_some_and(|gap_m| gap_m <= TOUCH_M);
        self.in_contact |= touches(&self.wall) || touches(&self.robot);
    }

    fn state(&self) -> BodyState {
        BodyState {
            pose_wb: self.body.pose_wb(),
            twist_b: self.body.twist_b(),
            wheels: self.body.wheels(),
            in_contact: self.in_contact,
        }
    }
}

impl Plan {
    /// The motion's twist and time, for who wants to know where it leads.
    #[must_use]
    pub(crate) fn pose_at(&self, share: f64) -> Pose {
        let Motion { twist_b, dt_s, .. } = self.motion;
        self.from_wb.advance(twist_b, dt_s * share.min(self.share))
    }
}

#[cfg(test)]
#[path = "arena_tests.rs"]
mod tests;
