//! A flock of simulated points that all decide at the same moments and know where the others are: the paper's world.
//!
//! What each may use is what it could sense: the returns of its laser, and the snapshot of its peers. The last layer
//! ([`crate::avoid`]) has the last word on every step: O keeps from walls, R from robots, C within a link's range.

use super::{Flocker, GUARDED, Params};
use crate::avoid::{Capsule, Disc, SafeSet, SafeSetParams};
use crate::deploy::{Graph, KeptGraph};
use crate::estimate::Motion;
use crate::law::{Outcome, View};
use crate::limit::limits_of;
use crate::peers::Neighbour;
use drover_config::{Flock, FlockGuard, Kind};
use drover_contract::{BehaviourState, Limits, Pose, RobotId, Stamp, Twist, Vec2};
use std::collections::BTreeSet;

/// Shares of a speed that the last layer tries.
const SHARES: [f64; 5] = [1.0, 0.75, 0.5, 0.25, 0.0];
/// Links are kept that much shorter than the range, as a share of it: rounding adds up.
const LINK_SLACK: f64 = 1e-5;

/// One robot as it is.
#[derive(Clone, Copy, Debug)]
pub struct FlockMember {
    /// World frame.
    pub pose_wb: Pose,
    /// Body frame.
    pub twist_b: Twist,
}

/// The swarm as it is.
#[derive(Clone, Copy, Debug)]
pub struct FlockScene<'a> {
    /// When.
    pub now: Stamp,
    /// Everybody; `None`: dead.
    pub members: &'a [Option<FlockMember>],
    /// Of each robot the laser's returns that are not robots', body frame, in the order of beams.
    pub returns_b: &'a [Vec<Vec2>],
    /// What the last layer keeps away from.
    pub walls: &'a [Capsule],
}

/// A swarm of them.
#[derive(Clone, Debug)]
pub struct FlockLockstep {
    robots: Vec<Robot>,
    guard: FlockGuard,
    link_range_m: f64,
    period_s: f64,
}

#[derive(Clone, Debug)]
struct Robot {
    id: RobotId,
    law: Flocker,
    limits: Limits,
    radius_m: f64,
    safe: SafeSetParams,
    accel: Accel,
}

/// What a robot tells of its acceleration: by how much its speed changed since the period before.
#[derive(Clone, Copy, Debug, Default)]
struct Accel {
    speed_mps: Option<f64>,
}

impl FlockLockstep {
    /// The robots of `flock`, in the file's order.
    #[must_use]
    pub fn new<'k>(flock: &Flock, robots: impl Iterator<Item = (RobotId, &'k Kind)>) -> Self {
        let period_s = flock.period_s;
        let robot = |(id, kind): (RobotId, &Kind)| {
            let params = Params::new(flock, kind, id, period_s);
            let margin_m = GUARDED * params.margin_m;
            let safe = SafeSetParams {
                robot_gap_m: 2.0 * params.radius_m + margin_m,
                wall_gap_m: params.radius_m + margin_m,
                step_m_max: params.speed_mps.max(flock.leader_speed_mps) * period_s,
            };
            let law = Flocker::new(flock, kind, id, period_s);
            let radius_m = kind.body.radius_m;
            Robot { id, law, limits: limits_of(&kind.motion), radius_m, safe, accel: Accel::default() }
        };
        Self { robots: robots.map(robot).collect(), guard: flock.guard, link_range_m: flock.link_range_m, period_s }
    }

    /// One period: what each robot does until the next, and whether the last layer changed it.
    pub fn round(&mut self, scene: &FlockScene<'_>) -> Vec<(Twist, bool)> {
        let everybody: Vec<Option<Neighbour>> = self
            .robots
            .iter_mut()
            .zip(scene.members)
            .map(|(robot, member)| robot.tells(*member, self.period_s))
            .collect();
        let kept = self.kept(scene);
        let range_m = self.link_range_m * (1.0 - LINK_SLACK);
        let mut others = Vec::with_capacity(everybody.len());
        let mut moves = Vec::with_capacity(everybody.len());
        for (at, robot) in self.robots.iter_mut().enumerate() {
            let Some(member) = scene.members[at] else {
                moves.push((Twist::ZERO, false));
                continue;
            };
            others.clear();
            others.extend(everybody.iter().enumerate().filter(|(other, _)| *other != at).filter_map(|(_, peer)| *peer));
            let at_w = member.pose_wb.position();
            let linked = kept.iter().flat_map(|kept| kept.of(at)).filter_map(|other| scene.members[*other]);
            let discs = linked.map(|other| Disc::between(at_w, other.pose_wb.position(), range_m));
            let discs: Vec<Disc> = discs.collect();
            let wish = robot.wish(scene.now, member, (&others, &scene.returns_b[at], &discs), self.period_s);
            if self.guard == FlockGuard::None {
                moves.push((wish, false));
                continue;
            }
            let bodies = scene.members.iter().enumerate().filter(|(other, _)| *other != at);
            let bodies_w = bodies.filter_map(|(_, body)| body.map(|body| body.pose_wb.position()));
            let set = SafeSet::around(robot.safe, at_w, discs.into_iter(), bodies_w, scene.walls);
            let twist = held(wish, member.pose_wb, &set, self.period_s);
            moves.push((twist, twist != wish));
        }
        moves
    }

    /// The links that are kept, of each party by itself: two flocks that meet are not tied together.
    fn kept(&self, scene: &FlockScene<'_>) -> Vec<KeptGraph> {
        if self.guard != FlockGuard::Full {
            return Vec::new();
        }
        let graph = |party: &(u32, u32)| {
            let robots = self.robots.iter().zip(scene.members);
            let place = |(robot, member): (&Robot, &Option<FlockMember>)| {
                member.filter(|_| robot.law.party() == *party).map(|member| member.pose_wb.position())
            };
            Graph::new(&robots.map(place).collect::<Vec<Option<Vec2>>>(), self.link_range_m).lmst(1)
        };
        let parties: BTreeSet<(u32, u32)> = self.robots.iter().map(|robot| robot.law.party()).collect();
        parties.iter().map(graph).collect()
    }

    /// Whether robot `robot` is at its end.
    #[must_use]
    pub fn reached(&self, robot: usize) -> bool {
        self.robots[robot].law.reached()
    }

    /// Whom robot `robot` follows; itself if it leads, nobody while it follows a wall.
    #[must_use]
    pub fn follows(&self, robot: usize) -> Option<RobotId> {
        self.robots[robot].law.follows()
    }

    /// How often robot `robot` has begun to follow a wall.
    #[must_use]
    pub fn wall_entries(&self, robot: usize) -> u32 {
        self.robots[robot].law.wall_entries()
    }

    /// Where robot `robot` is heading for.
    #[must_use]
    pub fn target_w(&self, robot: usize) -> Option<Vec2> {
        self.robots[robot].law.target_w()
    }

    /// To whom robot `robot` gives way on purpose, standing aside.
    #[must_use]
    pub fn gives_way_to(&self, robot: usize) -> Option<RobotId> {
        self.robots[robot].law.gives_way_to()
    }
}

impl Robot {
    /// What the others know of it.
    fn tells(&mut self, member: Option<FlockMember>, period_s: f64) -> Option<Neighbour> {
        let FlockMember { pose_wb, twist_b } = member?;
        let before_mps = self.accel.speed_mps.replace(twist_b.speed_mps).unwrap_or(twist_b.speed_mps);
        let accel_mps2 = (twist_b.speed_mps - before_mps) / period_s;
        let leader = self.law.follows();
        let state = if self.law.reached() { BehaviourState::Done } else { BehaviourState::Active };
        Some(Neighbour { id: self.id, pose_wb, twist_b, accel_mps2, state, leader, radius_m: self.radius_m })
    }

    fn wish(
        &mut self,
        now: Stamp,
        FlockMember { pose_wb, twist_b }: FlockMember,
        (neighbours, walls_b, discs): (&[Neighbour], &[Vec2], &[Disc]),
        dt_s: f64,
    ) -> Twist {
        let motion = Motion { pose_wb, twist_b, accel_mps2: 0.0, pos_bound_m: 0.0 };
        let view = View {
            now,
            dt_s,
            motion,
            neighbours,
            walls_b,
            points_b: walls_b,
            unseen_b: &[],
            scan: None,
            bodies: &[],
            discs,
            limits: &self.limits,
        };
        match self.law.step(&view) {
            Outcome::Solved(twist) => twist,
            Outcome::Stale(_) => {
                self.law.halt();
                Twist::ZERO
            }
        }
    }
}

/// As much of a speed as the set allows; a disc may always turn.
fn held(wish: Twist, pose_wb: Pose, set: &SafeSet, dt_s: f64) -> Twist {
    let slower = SHARES.map(|share| Twist::new(wish.speed_mps * share, wish.yaw_rate_radps));
    let allowed = |twist: &Twist| set.allows(pose_wb.advance(*twist, dt_s).position());
    slower.into_iter().find(allowed).unwrap_or(Twist::new(0.0, wish.yaw_rate_radps))
}
