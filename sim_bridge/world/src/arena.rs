//! All bodies in one place: they move together, stop each other, and see each other.
//!
//! Within one step all bodies move at once, each along its own arc. The first contact of any two ends the step for both
//! of them; the others go on, and may meet those two where they now stand. So what happens depends on where the bodies
//! are and not on their order in the list. Two discs never overlap, and no disc overlaps a wall.

use crate::body::{Body, BodyParams, Motion};
use crate::firmware::BodyState;
use crate::geometry::{Disc, SKIN_M, TOUCH_M, Walls, first_contact};
use crate::lidar::{Lidar, LidarParams};
use drover_config::World;
use drover_contract::{Pose, Scan, Stamp, Twist, Vec2};

/// One body to put into the arena.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BodySpec {
    /// The robot's id: its chance depends on it, not on its place in the list.
    pub key: u64,
    /// Where it stands at first.
    pub start: Pose,
    /// Its chassis.
    pub body: BodyParams,
    /// Its lidar.
    pub lidar: LidarParams,
}

/// The place with everything in it.
pub struct Arena {
    walls: Walls,
    members: Vec<Member>,
    /// Where the bodies are now: the same order as `members`.
    discs: Vec<Disc>,
    radius_m_max: f64,
    /// Robots from west to east: near ones are neighbours in this list.
    by_x: Vec<usize>,
    /// Kept from step to step for their memory only.
    plans: Vec<Plan>,
    pairs: Vec<Pair>,
}

struct Member {
    body: Body,
    lidar: Lidar,
    in_contact: bool,
    gap_robot_m_min: Option<f64>,
    gap_wall_m_min: Option<f64>,
}

/// A body's motion in this step, and how much of it nothing prevents.
struct Plan {
    from_wb: Pose,
    motion: Motion,
    share: f64,
}

/// Two bodies that may meet in this step, and where along it they do.
struct Pair {
    robots: [usize; 2],
    contact: Option<f64>,
}

impl Arena {
    /// All bodies at rest. Bodies that overlap at first may only move apart.
    #[must_use]
    pub fn new(world: &World, bodies: &[BodySpec], seed: u64) -> Self {
        let member = |spec: &BodySpec| Member {
            body: Body::new(spec.body, spec.start, seed, spec.key),
            lidar: Lidar::new(spec.lidar, seed, spec.key),
            in_contact: false,
            gap_robot_m_min: None,
            gap_wall_m_min: None,
        };
        let disc = |spec: &BodySpec| Disc { centre_w: spec.start.position(), radius_m: spec.body.radius_m };
        let mut arena = Self {
            walls: Walls::new(world),
            members: bodies.iter().map(member).collect(),
            discs: bodies.iter().map(disc).collect(),
            radius_m_max: bodies.iter().map(|spec| spec.body.radius_m).fold(0.0, f64::max),
            by_x: (0..bodies.len()).collect(),
            plans: Vec::new(),
            pairs: Vec::new(),
        };
        arena.sort_by_x();
        arena.measure(Walls::gap_m);
        arena
    }

    /// How many bodies there are.
    #[must_use]
    pub fn robot_count(&self) -> usize {
        self.members.len()
    }

    /// Move all bodies by `dt_s` seconds towards `demands` (one a body; a body without one is asked to stand).
    pub fn step(&mut self, dt_s: f64, demands: &[Twist]) {
        self.plan(dt_s, demands);
        self.find_pairs();
        self.resolve_contacts();
        for ((member, plan), disc) in self.members.iter_mut().zip(&self.plans).zip(&mut self.discs) {
            member.body.carry_out(&plan.motion, plan.share);
            member.in_contact = plan.share < 1.0;
            disc.centre_w = member.body.pose_wb().position();
        }
        self.sort_by_x();
        // Who is in free space stays there, so the side of a wall need not be asked for again.
        self.measure(|walls, disc| Some(walls.distance_m(disc.centre_w)? - disc.radius_m));
    }

    /// Body `robot`, as its own sensors could know it.
    ///
    /// # Panics
    /// If there is no such robot; so do all functions here that take one.
    #[must_use]
    pub fn state(&self, robot: usize) -> BodyState {
        let member = &self.members[robot];
        BodyState {
            pose_wb: member.body.pose_wb(),
            twist_b: member.body.twist_b(),
            wheels: member.body.wheels(),
            in_contact: member.in_contact,
        }
    }

    /// What body `robot`'s lidar sees now: walls, round obstacles, other bodies.
    #[must_use]
    pub fn cast(&mut self, now: Stamp, robot: usize) -> Scan {
        let Self { walls, members, discs, .. } = self;
        let member = &mut members[robot];
        let others = discs.iter().enumerate().filter(|(other, _)| *other != robot).map(|(_, disc)| disc);
        let round = walls.discs().iter().chain(others);
        member.lidar.scan(now, member.body.pose_wb(), walls.segments(), round)
    }

    /// How far body `robot` has travelled, metres.
    #[must_use]
    pub fn path_m(&self, robot: usize) -> f64 {
        self.members[robot].body.path_m()
    }

    /// Smallest gap so far between body `robot` and any other, metres, 0 from the first touch on; `None` if it is
    /// alone.
    #[must_use]
    pub fn gap_robot_m_min(&self, robot: usize) -> Option<f64> {
        self.members[robot].gap_robot_m_min
    }

    /// Smallest gap so far between body `robot` and any wall, metres, 0 from the first touch on; `None` without walls.
    #[must_use]
    pub fn gap_wall_m_min(&self, robot: usize) -> Option<f64> {
        self.members[robot].gap_wall_m_min
    }

    /// Smallest gap so far between any two bodies, metres.
    #[must_use]
    pub fn min_gap_robot_m(&self) -> Option<f64> {
        self.members.iter().filter_map(|member| member.gap_robot_m_min).min_by(f64::total_cmp)
    }

    /// Smallest gap so far between any body and any wall, metres.
    #[must_use]
    pub fn min_gap_wall_m(&self) -> Option<f64> {
        self.members.iter().filter_map(|member| member.gap_wall_m_min).min_by(f64::total_cmp)
    }

    /// Everything in the place that does not move.
    #[must_use]
    pub fn walls(&self) -> &Walls {
        &self.walls
    }

    /// Each body's motion, clipped at the walls.
    fn plan(&mut self, dt_s: f64, demands: &[Twist]) {
        self.plans.clear();
        for (index, member) in self.members.iter_mut().enumerate() {
            let motion = member.body.plan(demands.get(index).copied().unwrap_or(Twist::ZERO), dt_s);
            let mut plan = Plan { from_wb: member.body.pose_wb(), motion, share: 1.0 };
            let radius_m = member.body.radius_m();
            let gap_at = |share| self.walls.distance_m(plan.position_w(share)).map_or(f64::MAX, |m| m - radius_m);
            if let Some(share) = first_contact(motion.length_m, gap_at) {
                plan.share = share;
            }
            self.plans.push(plan);
        }
    }

    /// All pairs of bodies that could meet in this step.
    fn find_pairs(&mut self) {
        self.pairs.clear();
        let reach = |robot: usize| self.discs[robot].radius_m + self.plans[robot].motion.length_m;
        let reach_m_max = (0..self.members.len()).map(reach).fold(0.0, f64::max);
        for (rank, &a) in self.by_x.iter().enumerate() {
            let west_x_m = self.discs[a].centre_w.x;
            let window_m = reach(a) + reach_m_max + SKIN_M;
            let near = self.by_x[rank + 1..].iter().take_while(|b| self.discs[**b].centre_w.x - west_x_m <= window_m);
            for &b in near {
                let distance_m = (self.discs[a].centre_w - self.discs[b].centre_w).norm();
                if distance_m <= reach(a) + reach(b) + SKIN_M {
                    self.pairs.push(Pair { robots: [a, b], contact: None });
                }
            }
        }
    }

    /// Clip motions at contacts between bodies, the earliest contact first.
    ///
    /// A clipped body stands where it is from then on, so only contacts at or after that moment can be new: every round
    /// ends the step for at least one body more.
    fn resolve_contacts(&mut self) {
        for index in 0..self.pairs.len() {
            self.pairs[index].contact = self.contact_of(self.pairs[index].robots);
        }
        while let Some((share, [a, b])) = self.earliest_contact() {
            for robot in [a, b] {
                self.plans[robot].share = self.plans[robot].share.min(share);
            }
            for index in 0..self.pairs.len() {
                let robots = self.pairs[index].robots;
                if robots.contains(&a) || robots.contains(&b) {
                    self.pairs[index].contact = self.contact_of(robots);
                }
            }
        }
    }

    fn earliest_contact(&self) -> Option<(f64, [usize; 2])> {
        let contacts = self.pairs.iter().filter_map(|pair| pair.contact.map(|share| (share, pair.robots)));
        contacts.min_by(|a, b| a.0.total_cmp(&b.0))
    }

    /// Where along the step these two meet, if that ends the motion of one of them earlier than known so far.
    fn contact_of(&self, [a, b]: [usize; 2]) -> Option<f64> {
        let (plan_a, plan_b) = (&self.plans[a], &self.plans[b]);
        let radii_m = self.discs[a].radius_m + self.discs[b].radius_m;
        let gap_at = |share: f64| (plan_a.position_w(share) - plan_b.position_w(share)).norm() - radii_m;
        let share = first_contact(plan_a.motion.length_m + plan_b.motion.length_m, gap_at)?;
        (share < plan_a.share.max(plan_b.share)).then_some(share)
    }

    /// Nearly sorted from the step before, so this is nearly free. Equal places are told apart by the robots' order.
    fn sort_by_x(&mut self) {
        let Self { by_x, discs, .. } = self;
        by_x.sort_by(|a, b| discs[*a].centre_w.x.total_cmp(&discs[*b].centre_w.x).then(a.cmp(b)));
    }

    /// Bring running minima and contacts up to date.
    fn measure(&mut self, gap_to_wall_m: impl Fn(&Walls, &Disc) -> Option<f64>) {
        for rank in 0..self.by_x.len() {
            let robot = self.by_x[rank];
            let disc = self.discs[robot];
            let wall_m = gap_to_wall_m(&self.walls, &disc);
            let robot_m = self.gap_to_nearest_m(rank);
            let member = &mut self.members[robot];
            member.gap_wall_m_min = smaller(member.gap_wall_m_min, wall_m.map(reported_gap_m));
            member.gap_robot_m_min = smaller(member.gap_robot_m_min, robot_m.map(reported_gap_m));
            member.in_contact |= [wall_m, robot_m].into_iter().flatten().any(|gap_m| gap_m <= TOUCH_M);
        }
    }

    /// Gap to the nearest other body, metres. Bodies that are farther than the smallest gap so far need not be found.
    fn gap_to_nearest_m(&self, rank: usize) -> Option<f64> {
        let disc = self.discs[self.by_x[rank]];
        let known_m = self.members[self.by_x[rank]].gap_robot_m_min.unwrap_or(f64::INFINITY).max(TOUCH_M);
        let mut nearest_m: Option<f64> = None;
        let mut look = |robot: usize| {
            let other = self.discs[robot];
            let radii_m = disc.radius_m + other.radius_m;
            let within_m = nearest_m.map_or(known_m, |gap_m| gap_m.min(known_m));
            if (other.centre_w.x - disc.centre_w.x).abs() - disc.radius_m - self.radius_m_max > within_m {
                return false;
            }
            nearest_m = smaller(nearest_m, Some((other.centre_w - disc.centre_w).norm() - radii_m));
            true
        };
        // East, then west, each until the bodies are too far away to matter.
        let _ = self.by_x[rank + 1..].iter().all(|robot| look(*robot));
        let _ = self.by_x[..rank].iter().rev().all(|robot| look(*robot));
        nearest_m
    }
}

impl Plan {
    /// Where the body is after a share of the step.
    fn position_w(&self, share: f64) -> Vec2 {
        self.from_wb.advance(self.motion.twist_b, self.motion.dt_s * share.min(self.share)).position()
    }
}

/// A gap as it is told: touching is 0, and nothing is below 0.
fn reported_gap_m(gap_m: f64) -> f64 {
    if gap_m <= TOUCH_M { 0.0 } else { gap_m }
}

fn smaller(a: Option<f64>, b: Option<f64>) -> Option<f64> {
    a.into_iter().chain(b).min_by(f64::total_cmp)
}

#[cfg(test)]
#[path = "arena_tests.rs"]
mod tests;
