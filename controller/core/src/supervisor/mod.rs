//! The last word before the wheels: conditions -> transition -> action.
//!
//! - [`conditions`]: what is the case this tick, as facts, and the first reason among them not to move.
//! - [`guard`]: the request, reduced until the body can stop before anything (never increased).
//! - [`transition`]: the state that follows, a pure exhaustive match.
//! - [`action`]: the command of that state; the only place in the project that makes a moving `SafeCommand`.
//!
//! Absent means stop: no scan, old odometry, a silent drive, a late tick, a request that is not finite.

mod action;
pub(crate) mod conditions;
mod guard;
mod obstacles;
mod rollout;
mod transition;

pub(crate) use conditions::Conditions;
pub(crate) use guard::GuardParams;
pub(crate) use obstacles::{Obstacles, Peers, near_side};

use drover_contract::{SafeCommand, Twist};
pub(crate) use guard::Scratch;
use guard::guard;
use rollout::Start;
use std::fmt;

/// What the supervisor lets the robot do, and why not more.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// Not ready yet, or not any more: the drive does not obey or a sensor was never heard. Ends by itself.
    Waiting(Reason),
    /// The request reaches the wheels, reduced where something is near.
    Driving,
    /// Ready, but held this tick. Ends by itself.
    Held(Reason),
    /// Stopped for good: latched until the program starts anew.
    Stopped(StopReason),
}

/// Why a robot is stopped for good.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StopReason {
    /// An operator asked for it: Ctrl-C, `drover stop`, a ground station.
    Operator,
    /// The program ends.
    Shutdown,
    /// The robot's own shell failed: a panic, a hang, an overrun; what exactly.
    Fault(&'static str),
}

/// Why a robot does not move as asked.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reason {
    /// The drive says nothing.
    DriveSilent,
    /// The drive is on the way to obeying: what is waited for.
    DriveBringUp(&'static str),
    /// The drive refuses.
    DriveRefused,
    /// No scan was ever received.
    NoScan,
    /// The newest scan is too old.
    ScanOld,
    /// More than half of the beams have no reading.
    ScanBlind,
    /// No odometry was ever received.
    NoOdometry,
    /// The newest odometry is too old.
    OdometryOld,
    /// The autopilot has not yet said where the robot is.
    NoPose,
    /// The newest pose is too old.
    PoseOld,
    /// This tick came late.
    LateTick,
    /// The law asked for something that is not a number.
    RequestNotFinite,
    /// The law has no answer: its own words.
    Law(&'static str),
    /// Something that the lidar sees is in the way.
    Obstacle,
    /// Another robot is in the way.
    Peer,
    /// A link to a peer would be stretched farther than was agreed.
    Link,
}

impl Reason {
    /// A short name for counters and tables.
    #[must_use]
    pub const fn label(&self) -> &'static str {
        match self {
            Self::DriveSilent => "drive silent",
            Self::DriveBringUp(_) => "drive bring-up",
            Self::DriveRefused => "drive refused",
            Self::NoScan => "no scan",
            Self::ScanOld => "scan old",
            Self::ScanBlind => "scan blind",
            Self::NoOdometry => "no odometry",
            Self::OdometryOld => "odometry old",
            Self::NoPose => "no pose",
            Self::PoseOld => "pose old",
            Self::LateTick => "late tick",
            Self::RequestNotFinite => "request not finite",
            Self::Law(why) => why,
            Self::Obstacle => "obstacle",
            Self::Peer => "peer",
            Self::Link => "link",
        }
    }
}

impl fmt::Display for Reason {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::DriveBringUp(step) => write!(f, "drive: {step}"),
            other => f.write_str(other.label()),
        }
    }
}

impl fmt::Display for StopReason {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Operator => f.write_str("operator"),
            Self::Shutdown => f.write_str("shutdown"),
            Self::Fault(what) => write!(f, "fault: {what}"),
        }
    }
}

impl fmt::Display for Verdict {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Waiting(reason) => write!(f, "waiting: {reason}"),
            Self::Driving => f.write_str("driving"),
            Self::Held(reason) => write!(f, "held: {reason}"),
            Self::Stopped(reason) => write!(f, "stopped: {reason}"),
        }
    }
}

/// What the supervisor decided in one tick.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Decision {
    pub(crate) command: SafeCommand,
    /// Why the command is not the request; `None` if it is.
    pub(crate) changed: Option<Reason>,
}

/// The supervisor: its state, its latch, and the command before.
#[derive(Clone, Debug)]
pub(crate) struct Supervisor {
    params: GuardParams,
    verdict: Verdict,
    latched: Option<StopReason>,
    before: SafeCommand,
}

impl Supervisor {
    pub(crate) fn new(params: GuardParams) -> Self {
        let verdict = Verdict::Waiting(Reason::DriveSilent);
        Self { params, verdict, latched: None, before: SafeCommand::STOP }
    }

    /// Stop for good. The first reason is kept.
    pub(crate) fn handle_stop(&mut self, reason: StopReason) {
        let reason = *self.latched.get_or_insert(reason);
        self.verdict = Verdict::Stopped(reason);
        self.before = SafeCommand::STOP;
    }

    /// One tick. `request` is what the law asks for, limited; `is_b` is the measured velocity; `scratch` is lent for
    /// its memory only.
    pub(crate) fn tick(
        &mut self,
        facts: &Conditions,
        request: Option<Twist>,
        is_b: Twist,
        obstacles: &Obstacles,
        scratch: &mut Scratch,
    ) -> Decision {
        let asked = request.filter(Twist::is_finite);
        let start = Start { is_b, before_b: self.before.twist_b() };
        let guarded = asked.map(|asked| guard(asked, start, obstacles, &self.params, scratch));
        let blocked = guarded.and_then(|guarded| guarded.blocked);
        self.verdict = transition::transition(self.verdict, self.latched, facts, blocked);
        let command = action::act(self.verdict, guarded.map(|guarded| guarded.twist_b), &self.params.limits);
        self.before = command;
        let limited_by = guarded.and_then(|guarded| guarded.reduced);
        Decision { command, changed: changed(self.verdict, asked, command, limited_by) }
    }

    pub(crate) fn verdict(&self) -> Verdict {
        self.verdict
    }

    /// The command before: what the next one may differ from only as far as the limits allow.
    pub(crate) fn before(&self) -> Twist {
        self.before.twist_b()
    }
}

/// Why `command` is not what was asked for. A robot that waits or is stopped for good is asked for nothing.
fn changed(verdict: Verdict, asked: Option<Twist>, command: SafeCommand, near: Option<Reason>) -> Option<Reason> {
    let differs = asked.is_none_or(|asked| asked != command.twist_b());
    match verdict {
        Verdict::Held(reason) if differs => Some(reason),
        Verdict::Driving if differs => near,
        Verdict::Waiting(_) | Verdict::Stopped(_) | Verdict::Held(_) | Verdict::Driving => None,
    }
}

#[cfg(test)]
mod tests;
