//! The small state message that robots broadcast to each other.

use crate::{Pose, RobotId, Stamp, Twist};
use serde::Serialize;

/// What one robot tells all others, ten times a second. The newest replaces all older ones.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Beacon {
    /// Who speaks.
    pub robot: RobotId,
    /// Which life of that robot: greater after every restart.
    pub epoch: u32,
    /// Greater with every beacon of one life.
    pub seq: u32,
    /// When it was sent, on the sender's own clock: good for differences only.
    pub sent: Stamp,
    /// The sender in the world.
    pub pose_wb: Pose,
    /// The sender's velocity in its own body frame.
    pub twist_b: Twist,
    /// The sender's acceleration along its heading, m/s^2: the flocking law feeds the leader's forward.
    pub accel_mps2: f64,
    /// The sender is within this distance of `pose_wb`, metres.
    pub pos_bound_m: f64,
    /// Radius of the sender's body, metres.
    pub radius_m: f64,
    /// What the sender is doing.
    pub state: BehaviourState,
    /// How much of its task the sender has done, 0..=1.
    pub progress: f64,
    /// The robot whose lead it follows, itself if it leads; none for a behaviour without leaders.
    pub leader: Option<RobotId>,
}

/// What a robot is doing, in one word.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum BehaviourState {
    /// Not ready: its drive is being brought up or its sensors are missing.
    #[default]
    Waiting,
    /// At work.
    Active,
    /// Held by its supervisor; it will go on by itself when the reason ends.
    Held,
    /// Its task is done.
    Done,
    /// Stopped for good: an operator or a fault; it needs a restart.
    Stopped,
}

impl BehaviourState {
    /// The state as tables, JSON and logs spell it.
    #[must_use]
    pub const fn word(self) -> &'static str {
        match self {
            Self::Waiting => "waiting",
            Self::Active => "active",
            Self::Held => "held",
            Self::Done => "done",
            Self::Stopped => "stopped",
        }
    }
}
