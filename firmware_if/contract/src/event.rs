//! What firmware tells its robot, once decoded: every host-side codec speaks in these.

use crate::{Pose, Scan, Stamp, Twist};
use serde::{Deserialize, Serialize};
use std::fmt;
use std::time::Duration;

/// One thing that a host-side codec learned from the wire.
#[derive(Clone, Debug, PartialEq)]
pub enum Event {
    /// The body's own motion, as its drive measures it.
    Odometry(Odometry),
    /// Where the body is, from an estimator on the other side of the link.
    Pose(PoseFix),
    /// A complete scan.
    Scan(Scan),
    /// How far the drive is on the way to obeying.
    Drive(DriveState),
    /// The drive's supply.
    Battery(Battery),
    /// Words for the operator.
    Text(Severity, String),
}

/// The body's motion as its drive measures it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Odometry {
    /// When it was received.
    pub stamp: Stamp,
    /// Velocity in the body frame.
    pub twist_b: Twist,
    /// How far each side's wheels have rolled, if the drive counts it.
    pub wheels: Option<WheelTravel>,
}

/// Distance rolled by each side since power-up, metres. It may start anew when the drive restarts.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct WheelTravel {
    /// Left side.
    pub left_m: f64,
    /// Right side.
    pub right_m: f64,
}

/// Where the body is in the world frame, from an estimator on the other side of the link.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PoseFix {
    /// When it was received.
    pub stamp: Stamp,
    /// The body in the world.
    pub pose_wb: Pose,
}

/// How far a drive is on the way from silent to driving. Only `Ready` lets a robot move.
#[derive(Clone, Debug, PartialEq, Eq, Default)]
pub enum DriveState {
    /// Nothing heard yet, or nothing for too long.
    #[default]
    Silent,
    /// On the way: what is being waited for, for example "arming".
    BringUp(&'static str),
    /// It refuses, or was taken from us: why, and whether the host tries again by itself.
    Refused(String),
    /// It obeys. The device stops by itself when commands cease: see the watchdog.
    Ready(Watchdog),
}

/// The device's own command watchdog: the third of the three independent stops (invariant 4).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Watchdog {
    /// The maker fixes it; it cannot be read or set.
    Fixed(Duration),
    /// A setting, read back from the device.
    ReadBack(Duration),
    /// There is none: said aloud at start-up.
    Absent,
}

impl fmt::Display for DriveState {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Silent => f.write_str("silent"),
            Self::BringUp(step) => write!(f, "{step}"),
            Self::Refused(why) => write!(f, "refused: {why}"),
            Self::Ready(_) => f.write_str("ready"),
        }
    }
}

/// A drive's supply.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Battery {
    /// Volts, if known.
    pub voltage_v: Option<f64>,
    /// Amperes drawn, if known.
    pub current_a: Option<f64>,
    /// What is left, 0..=1, if known.
    pub charge: Option<f64>,
}

/// How grave a text is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Severity {
    /// Good to know.
    Info,
    /// Somebody should look.
    Warning,
    /// Something failed.
    Error,
}

impl fmt::Display for Watchdog {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Fixed(span) => {
                write!(f, "its own watchdog stops it after {} ms of silence (fixed)", span.as_millis())
            }
            Self::ReadBack(span) => write!(f, "its own watchdog is set to {} ms (read back)", span.as_millis()),
            Self::Absent => f.write_str("it has NO watchdog of its own: if this computer dies, it keeps driving"),
        }
    }
}
