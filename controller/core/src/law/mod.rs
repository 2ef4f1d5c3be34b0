//! The behaviours' laws, and which of them this robot runs.
//!
//! A law is parameters, state and a pure function; what it sees is in [`View`], what it answers in [`Outcome`]. This
//! file chooses between leading and following and knows when the task is done.

mod arrival;
pub mod deploy;
mod diffuse;
mod flock;
mod waypoints;

use crate::estimate::Motion;
use crate::peers::{Neighbour, Roster};
use arrival::Arrival;
use deploy::Deployer;
pub use diffuse::Diffusion;
use drover_config::{Behaviour, Flock, RobotFile};
use drover_contract::{BehaviourState, Limits, RobotId, Stamp, Twist, Vec2};
use waypoints::Route;

/// What a law answers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Outcome {
    /// Do this, body frame.
    Solved(Twist),
    /// Something the law needs is too old or gone: the supervisor holds the robot until it is back.
    Stale(&'static str),
}

/// What a law sees in one tick. Everything is already aged, and neighbours are sorted by id.
#[derive(Clone, Debug)]
pub(crate) struct View<'a> {
    pub(crate) now: Stamp,
    pub(crate) dt_s: f64,
    pub(crate) motion: Motion,
    pub(crate) neighbours: &'a [Neighbour],
    /// The return nearest to the law's reference point that is not a peer's, body frame.
    pub(crate) wall_b: Option<Vec2>,
    /// What the scan shows beside peers, body frame; only for a law that asks for it.
    pub(crate) walls_b: &'a [Vec2],
    /// Everything that the scan shows, peers too, body frame.
    pub(crate) points_b: &'a [Vec2],
    /// The near sides of peers that are heard and not seen, as far towards us as they may be, body frame.
    pub(crate) unseen_b: &'a [Vec2],
    pub(crate) limits: &'a Limits,
}

/// What this robot does in the swarm.
#[derive(Clone, Debug)]
pub(crate) struct Law {
    role: Role,
    goal_w: Vec2,
    start_gap_m: Option<f64>,
    progress: f64,
    head_offset_m: f64,
    range_m: f64,
}

#[derive(Clone, Debug)]
enum Role {
    Leader(Route),
    Follower { params: flock::Params, before: Twist, arrival: Arrival },
    Diffuser(Diffusion),
    Deployer(Box<Deployer>),
}

impl Law {
    /// The law of the robot of `file`.
    /// `roster` are all robots, `epoch` is its life.
    pub(crate) fn new(file: &RobotFile, roster: &Roster, epoch: u32, now: Stamp) -> Self {
        let own = RobotId(file.robot.id);
        let start = |role, goal_w, (head_offset_m, range_m)| Self {
            role,
            goal_w,
            start_gap_m: None,
            progress: 0.0,
            head_offset_m,
            range_m,
        };
        match &file.behaviour {
            Behaviour::Flock(flock) => {
                let role = if RobotId(flock.leader) == own { lead(flock) } else { follow(flock) };
                let goal_w = flock.waypoints_m.last().map_or_else(Vec2::zeros, |[x, y]| Vec2::new(*x, *y));
                start(role, goal_w, (flock.head_offset_m, flock.head_offset_m + flock.obstacle_range_m))
            }
            Behaviour::Deploy(deploy) => {
                let ids = roster.ids().filter(|id| *id != own).chain([own]);
                let law = Deployer::new(file, deploy, ids, (own, epoch), now);
                start(Role::Deployer(Box::new(law)), Vec2::zeros(), (0.0, deploy.range_m))
            }
            Behaviour::Diffuse(params) => {
                start(Role::Diffuser(Diffusion::new(*params)), Vec2::zeros(), (0.0, params.clearance_m))
            }
        }
    }

    /// Where the nearest wall is measured from, body frame.
    pub(crate) fn reference_b(&self) -> Vec2 {
        match self.role {
            Role::Leader(_) | Role::Diffuser(_) | Role::Deployer(_) => Vec2::zeros(),
            Role::Follower { .. } => Vec2::new(self.head_offset_m, 0.0),
        }
    }

    /// Whether peers matter to it.
    pub(crate) fn asks_for_peers(&self) -> bool {
        match self.role {
            Role::Leader(_) | Role::Follower { .. } | Role::Deployer(_) => true,
            Role::Diffuser(_) => false,
        }
    }

    /// What is farther than this from the body's origin is no matter to it, peers to follow apart, metres.
    pub(crate) fn range_m(&self) -> f64 {
        self.range_m
    }

    /// Whether every return that is not a peer's matters to it.
    pub(crate) fn asks_for_walls(&self) -> bool {
        self.deployer().is_some()
    }

    /// The law that keeps links, if it is one.
    pub(crate) fn deployer(&self) -> Option<&Deployer> {
        match &self.role {
            Role::Deployer(law) => Some(law),
            Role::Leader(_) | Role::Follower { .. } | Role::Diffuser(_) => None,
        }
    }

    /// The same to be told something.
    pub(crate) fn deployer_mut(&mut self) -> Option<&mut Deployer> {
        match &mut self.role {
            Role::Deployer(law) => Some(law),
            Role::Leader(_) | Role::Follower { .. } | Role::Diffuser(_) => None,
        }
    }

    /// Whether it steers away from peers that it hears and does not see.
    pub(crate) fn minds_unseen(&self) -> bool {
        match self.role {
            Role::Leader(_) | Role::Follower { .. } | Role::Deployer(_) => false,
            Role::Diffuser(_) => true,
        }
    }

    /// One tick.
    pub(crate) fn step(&mut self, view: &View<'_>) -> Outcome {
        let gap_m = (view.motion.pose_wb.position() - self.goal_w).norm();
        let outcome = match &mut self.role {
            Role::Leader(route) => Outcome::Solved(route.step(view)),
            Role::Deployer(law) => law.step(view),
            Role::Diffuser(law) => Outcome::Solved(law.step(view.points_b.iter().chain(view.unseen_b).copied())),
            Role::Follower { params, before, arrival } => {
                let leader = view.neighbours.iter().find(|peer| peer.id == params.leader);
                arrival.update(view.now, &view.motion, leader, self.goal_w);
                if arrival.done() { Outcome::Solved(Twist::ZERO) } else { flock::flock(params, *before, view) }
            }
        };
        self.remember(outcome);
        self.measure(gap_m);
        outcome
    }

    fn remember(&mut self, outcome: Outcome) {
        if let Role::Follower { before, .. } = &mut self.role {
            *before = match outcome {
                Outcome::Solved(twist_b) => twist_b,
                Outcome::Stale(_) => Twist::ZERO,
            };
        }
    }

    fn measure(&mut self, gap_m: f64) {
        let start_m = *self.start_gap_m.get_or_insert(gap_m.max(1e-3));
        let now = match &self.role {
            Role::Leader(route) => route.progress(),
            Role::Deployer(law) => law.progress(),
            Role::Diffuser(_) => 0.0,
            // A follower knows no way, only how far the end is; it never reports all before it has arrived.
            Role::Follower { .. } => (1.0 - gap_m / start_m).clamp(0.0, 0.99),
        };
        self.progress = if self.reached() { 1.0 } else { self.progress.max(now) };
    }

    /// The robot stands: what the law remembers of its own motion is void, its place in the task is not.
    pub(crate) fn halt(&mut self) {
        if let Role::Follower { before, .. } = &mut self.role {
            *before = Twist::ZERO;
        }
    }

    /// Whether the task is done: the robot then stays where it is.
    pub(crate) fn reached(&self) -> bool {
        match &self.role {
            Role::Leader(route) => route.reached(),
            Role::Follower { arrival, .. } => arrival.done(),
            Role::Deployer(law) => law.reached(),
            Role::Diffuser(_) => false,
        }
    }

    /// Where the robot is heading for, world frame: the leader's next point, a follower's end.
    pub(crate) fn target_w(&self) -> Option<Vec2> {
        match &self.role {
            Role::Leader(route) => route.next_w(),
            Role::Follower { arrival, .. } => (!arrival.done()).then_some(self.goal_w),
            Role::Deployer(law) => Some(law.target_w()),
            Role::Diffuser(_) => None,
        }
    }

    /// Whether the robot would hold without this peer: a follower without its leader.
    pub(crate) fn relies_on(&self, peer: RobotId) -> bool {
        match &self.role {
            Role::Follower { params, .. } => params.leader == peer,
            Role::Deployer(law) => law.relies_on(peer),
            Role::Leader(_) | Role::Diffuser(_) => false,
        }
    }

    /// Share of the task that is done, 0..=1, never falling.
    pub(crate) fn progress(&self) -> f64 {
        self.progress
    }
}

fn lead(flock: &Flock) -> Role {
    let points_w = flock.waypoints_m.iter().map(|[x, y]| Vec2::new(*x, *y)).collect();
    let params = waypoints::Params {
        speed_mps: flock.leader_speed_mps,
        radius_m: flock.waypoint_radius_m,
        spacing_m: flock.spacing_m,
    };
    Role::Leader(Route::new(params, points_w))
}

fn follow(flock: &Flock) -> Role {
    let params = flock::Params {
        leader: RobotId(flock.leader),
        spacing_m: flock.spacing_m,
        gain: flock.gain,
        obstacle_range_m: flock.obstacle_range_m,
        head_offset_m: flock.head_offset_m,
        damping_per_s: flock.damping_per_s,
        mass_kg: flock.mass_kg,
        inertia_kgm2: flock.inertia_kgm2,
    };
    Role::Follower { params, before: Twist::ZERO, arrival: Arrival::new(flock) }
}

/// Whether a leader in this state may be followed. One that is stopped for good is as lost as a silent one.
pub(crate) fn leads(state: BehaviourState) -> bool {
    match state {
        BehaviourState::Waiting | BehaviourState::Active | BehaviourState::Held | BehaviourState::Done => true,
        BehaviourState::Stopped => false,
    }
}
