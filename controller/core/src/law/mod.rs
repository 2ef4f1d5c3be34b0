//! The behaviours' laws, and which of them this robot runs.
//!
//! A law is parameters, state and a pure function; what it sees is in [`View`], what it answers in [`Outcome`]. This
//! file chooses between leading and following and knows when the task is done.

pub mod deploy;
mod diffuse;
mod drive;
pub mod explore;
pub mod flock;
pub(crate) mod pacts;

use crate::avoid::Disc;
use crate::estimate::Motion;
use crate::peers::{Body, Neighbour, Roster};
use deploy::Deployer;
pub use diffuse::Diffusion;
use drover_config::{Behaviour, RobotFile};
use drover_contract::{BehaviourState, Limits, RobotId, Scan, Stamp, Twist, Vec2, Writer};
use explore::Surveyor;
use flock::Flocker;
use nalgebra::Isometry2;
use pacts::Tied;

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
    /// What the scan shows beside peers, body frame; only for a law that asks for it.
    pub(crate) walls_b: &'a [Vec2],
    /// Everything that the scan shows, peers too, body frame.
    pub(crate) points_b: &'a [Vec2],
    /// The near sides of peers that are heard and not seen, as far towards us as they may be, body frame.
    pub(crate) unseen_b: &'a [Vec2],
    /// The scan as it came, and its sensor in the body frame of now; none without one.
    pub(crate) scan: Option<(&'a Scan, Isometry2<f64>)>,
    /// Bodies of peers that may be in it.
    pub(crate) bodies: &'a [Body],
    /// C: discs in which it has to stay, world frame; none where no links are kept.
    pub(crate) discs: &'a [Disc],
    pub(crate) limits: &'a Limits,
}

/// What this robot does in the swarm.
#[derive(Clone, Debug)]
pub(crate) struct Law {
    role: Role,
    goal_w: Vec2,
    start_gap_m: Option<f64>,
    progress: f64,
    range_m: f64,
}

#[derive(Clone, Debug)]
enum Role {
    Flocker(Box<Flocker>),
    Diffuser(Diffusion),
    Deployer(Box<Deployer>),
    Surveyor(Box<Surveyor>),
}

impl Law {
    /// The law of the robot of `file`.
    /// `roster` are all robots, `epoch` is its life.
    pub(crate) fn new(file: &RobotFile, roster: &Roster, epoch: u32, now: Stamp) -> Self {
        let own = RobotId(file.robot.id);
        let start = |role, goal_w, range_m| Self { role, goal_w, start_gap_m: None, progress: 0.0, range_m };
        match &file.behaviour {
            Behaviour::Flock(flock) => {
                let law = Flocker::on_body(flock, file, epoch, now);
                let goal_w = law.goal_w();
                start(Role::Flocker(Box::new(law)), goal_w, Flocker::range_m(flock))
            }
            Behaviour::Deploy(deploy) => {
                let ids = roster.ids().filter(|id| *id != own).chain([own]);
                let law = Deployer::new(file, deploy, ids, (own, epoch), now);
                start(Role::Deployer(Box::new(law)), Vec2::zeros(), deploy.range_m)
            }
            Behaviour::Diffuse(params) => {
                start(Role::Diffuser(Diffusion::new(*params)), Vec2::zeros(), params.clearance_m)
            }
            Behaviour::Explore(explore) => {
                let writer = Writer { robot: own, epoch };
                let law = Surveyor::new(explore, &file.kind, writer, roster.ids());
                start(Role::Surveyor(Box::new(law)), Vec2::zeros(), Surveyor::range_m(&file.kind))
            }
        }
    }

    /// Whether peers matter to it.
    pub(crate) fn asks_for_peers(&self) -> bool {
        match self.role {
            Role::Flocker(_) | Role::Deployer(_) | Role::Surveyor(_) => true,
            Role::Diffuser(_) => false,
        }
    }

    /// What is farther than this from the body's origin is no matter to it, peers to follow apart, metres.
    pub(crate) fn range_m(&self) -> f64 {
        self.range_m
    }

    /// Whether every return that is not a peer's matters to it.
    pub(crate) fn asks_for_walls(&self) -> bool {
        match self.role {
            Role::Flocker(_) | Role::Deployer(_) => true,
            Role::Diffuser(_) | Role::Surveyor(_) => false,
        }
    }

    /// The law that keeps links, if it is one.
    pub(crate) fn tied(&self) -> Option<&dyn Tied> {
        match &self.role {
            Role::Deployer(law) => Some(law.as_ref()),
            Role::Flocker(law) => law.tied(),
            Role::Diffuser(_) | Role::Surveyor(_) => None,
        }
    }

    /// The same to be told something.
    pub(crate) fn tied_mut(&mut self) -> Option<&mut dyn Tied> {
        match &mut self.role {
            Role::Deployer(law) => Some(law.as_mut()),
            Role::Flocker(law) => law.tied_mut(),
            Role::Diffuser(_) | Role::Surveyor(_) => None,
        }
    }

    /// The law that makes a map, if it is one.
    pub(crate) fn surveyor(&self) -> Option<&Surveyor> {
        match &self.role {
            Role::Surveyor(law) => Some(law),
            Role::Flocker(_) | Role::Diffuser(_) | Role::Deployer(_) => None,
        }
    }

    /// The same to be told something.
    pub(crate) fn surveyor_mut(&mut self) -> Option<&mut Surveyor> {
        match &mut self.role {
            Role::Surveyor(law) => Some(law),
            Role::Flocker(_) | Role::Diffuser(_) | Role::Deployer(_) => None,
        }
    }

    /// Whether it steers away from peers that it hears and does not see.
    pub(crate) fn minds_unseen(&self) -> bool {
        match self.role {
            Role::Flocker(_) | Role::Deployer(_) | Role::Surveyor(_) => false,
            Role::Diffuser(_) => true,
        }
    }

    /// One tick.
    pub(crate) fn step(&mut self, view: &View<'_>) -> Outcome {
        let gap_m = (view.motion.pose_wb.position() - self.goal_w).norm();
        let outcome = match &mut self.role {
            Role::Flocker(law) => law.step(view),
            Role::Deployer(law) => law.step(view),
            Role::Surveyor(law) => law.step(view),
            Role::Diffuser(law) => Outcome::Solved(law.step(view.points_b.iter().chain(view.unseen_b).copied())),
        };
        self.measure(gap_m);
        outcome
    }

    fn measure(&mut self, gap_m: f64) {
        let start_m = *self.start_gap_m.get_or_insert(gap_m.max(1e-3));
        let now = match &self.role {
            Role::Flocker(law) => law.progress(gap_m, start_m),
            Role::Deployer(law) => law.progress(),
            Role::Surveyor(law) => law.progress(),
            Role::Diffuser(_) => 0.0,
        };
        self.progress = if self.reached() { 1.0 } else { self.progress.max(now) };
    }

    /// The robot stands: what the law remembers of its own motion is void, its place in the task is not.
    pub(crate) fn halt(&mut self) {
        if let Role::Flocker(law) = &mut self.role {
            law.halt();
        }
    }

    /// Whether the task is done: the robot then stays where it is.
    pub(crate) fn reached(&self) -> bool {
        match &self.role {
            Role::Flocker(law) => law.reached(),
            Role::Deployer(law) => law.reached(),
            Role::Surveyor(law) => law.reached(),
            Role::Diffuser(_) => false,
        }
    }

    /// Where the robot is heading for, world frame: the leader's next point, a follower's end.
    pub(crate) fn target_w(&self) -> Option<Vec2> {
        match &self.role {
            Role::Flocker(law) => law.target_w(),
            Role::Deployer(law) => Some(law.target_w()),
            Role::Surveyor(law) => law.target_w(),
            Role::Diffuser(_) => None,
        }
    }

    /// Whether the robot would hold without this peer: a follower without its leader, the end of a link that is kept.
    pub(crate) fn relies_on(&self, peer: RobotId) -> bool {
        match &self.role {
            Role::Flocker(law) => law.relies_on(peer),
            Role::Deployer(law) => law.relies_on(peer),
            Role::Diffuser(_) | Role::Surveyor(_) => false,
        }
    }

    /// Whose lead it follows, itself if it leads; nobody's for a law without leaders, or while it follows a wall.
    pub(crate) fn leader(&self) -> Option<RobotId> {
        match &self.role {
            Role::Flocker(law) => law.follows(),
            Role::Deployer(_) | Role::Diffuser(_) | Role::Surveyor(_) => None,
        }
    }

    /// How often it has begun to follow a wall.
    pub(crate) fn wall_entries(&self) -> u32 {
        match &self.role {
            Role::Flocker(law) => law.wall_entries(),
            Role::Deployer(_) | Role::Diffuser(_) | Role::Surveyor(_) => 0,
        }
    }

    /// To whom it gives way, standing aside on purpose.
    pub(crate) fn gives_way_to(&self) -> Option<RobotId> {
        match &self.role {
            Role::Flocker(law) => law.gives_way_to(),
            Role::Deployer(_) | Role::Diffuser(_) | Role::Surveyor(_) => None,
        }
    }

    /// Share of the task that is done, 0..=1, never falling.
    pub(crate) fn progress(&self) -> f64 {
        self.progress
    }
}

/// Whether a leader in this state may be followed. One that is stopped for good is as lost as a silent one.
pub(crate) fn leads(state: BehaviourState) -> bool {
    match state {
        BehaviourState::Waiting | BehaviourState::Active | BehaviourState::Held | BehaviourState::Done => true,
        BehaviourState::Stopped => false,
    }
}
