//! What a robot says of itself: for the terminal, the recording and the summary.

use crate::supervisor::{Reason, Verdict};
use drover_contract::{Battery, BehaviourState, DriveState, Pose, RobotId, SafeCommand, Severity, Stamp, Twist, Vec2};
use std::collections::BTreeMap;
use std::time::Duration;

/// One robot, as of its last tick.
#[derive(Clone, Debug, PartialEq)]
pub struct Status {
    /// When this held.
    pub stamp: Stamp,
    /// How far the drive is on the way to obeying.
    pub drive: DriveState,
    /// What the supervisor allows, and why not more.
    pub verdict: Verdict,
    /// What the robot is doing, in one word.
    pub state: BehaviourState,
    /// The body in the world, as estimated.
    pub pose_wb: Pose,
    /// The body is within this distance of it, metres.
    pub pos_bound_m: f64,
    /// The measured velocity, body frame.
    pub twist_b: Twist,
    /// What the law asked for in the last tick, limited, body frame; `None` if it asked for nothing.
    pub request: Option<Twist>,
    /// The command of the last tick.
    pub command: SafeCommand,
    /// Why that command is not what was asked for, as the counters name it; `None` if it is.
    pub changed: Option<&'static str>,
    /// Where the law is heading for, world frame, metres; `None` for a law without a place to go.
    pub target_w: Option<Vec2>,
    /// The nearest hit of the newest scan, metres from the body's origin, peers included.
    pub nearest_m: Option<f64>,
    /// Age of the newest scan.
    pub scan_age: Option<Duration>,
    /// Age of the newest odometry.
    pub odometry_age: Option<Duration>,
    /// Whose lead it follows, itself if it leads; nobody's for a law without leaders, or while it follows a wall.
    pub leader: Option<RobotId>,
    /// To whom it gives way, standing aside on purpose.
    pub gives_way_to: Option<RobotId>,
    /// Share of the task that is done, 0..=1.
    pub progress: f64,
    /// Whether the task is done.
    pub reached: bool,
    /// Metres travelled, as measured.
    pub path_m: f64,
    /// Peers heard within their timeout.
    pub peers_heard: usize,
    /// The supply, as last heard.
    pub battery: Option<Battery>,
    /// The newest words of the firmware.
    pub text: Option<(Severity, String)>,
    /// What has been counted since the start.
    pub counters: Counters,
}

impl Status {
    /// A robot that has not ticked yet.
    #[must_use]
    pub fn first(now: Stamp, start_wb: Pose) -> Self {
        Self {
            stamp: now,
            drive: DriveState::Silent,
            verdict: Verdict::Waiting(Reason::DriveSilent),
            state: BehaviourState::Waiting,
            pose_wb: start_wb,
            pos_bound_m: 0.0,
            twist_b: Twist::ZERO,
            request: None,
            command: SafeCommand::STOP,
            changed: None,
            target_w: None,
            nearest_m: None,
            scan_age: None,
            odometry_age: None,
            leader: None,
            gives_way_to: None,
            progress: 0.0,
            reached: false,
            path_m: 0.0,
            peers_heard: 0,
            battery: None,
            text: None,
            counters: Counters::default(),
        }
    }
}

/// A peer that is heard.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct HeardPeer {
    /// Whom.
    pub id: RobotId,
    /// How old its newest beacon is.
    pub age: Duration,
    /// Whether the law relies on it: without that peer this robot would hold.
    pub kept: bool,
}

/// What has been counted since the start.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Counters {
    /// Ticks.
    pub ticks: u64,
    /// Ticks that came more than two ticks after the one before.
    pub late_ticks: u64,
    /// Times that a moving command was followed by STOP against the law's wish.
    pub stops: u64,
    /// Commands that the supervisor changed, by the reason's label.
    pub changed: BTreeMap<&'static str, u64>,
    /// How often it has begun to follow a wall.
    pub wall_entries: u64,
    /// Beacons taken.
    pub beacons_taken: u64,
    /// Beacons dropped: older than what is held.
    pub beacons_old: u64,
    /// Beacons dropped: heard before.
    pub beacons_duplicate: u64,
    /// Beacons dropped: our own id, an id that the file does not name, or impossible numbers.
    pub beacons_refused: u64,
}

impl Counters {
    /// Commands that the supervisor changed, for whatever reason.
    #[must_use]
    pub fn changed_total(&self) -> u64 {
        self.changed.values().sum()
    }
}
