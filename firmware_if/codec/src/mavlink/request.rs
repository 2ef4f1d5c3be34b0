//! What is asked of an autopilot, and how it answers.

use super::{cmd, mode};

/// Something to ask the autopilot for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Request {
    /// DO_SET_MODE.
    Mode(u32),
    /// COMPONENT_ARM_DISARM.
    Arm(bool),
    /// SET_MESSAGE_INTERVAL.
    Interval { message: u32, hz: u32 },
}

impl Request {
    pub(crate) const fn command(self) -> u16 {
        match self {
            Self::Mode(_) => cmd::DO_SET_MODE,
            Self::Arm(_) => cmd::COMPONENT_ARM_DISARM,
            Self::Interval { .. } => cmd::SET_MESSAGE_INTERVAL,
        }
    }

    pub(crate) fn words(self) -> String {
        match self {
            Self::Mode(custom_mode) => format!("mode {}", mode::name(custom_mode)),
            Self::Arm(true) => "arming".into(),
            Self::Arm(false) => "disarming".into(),
            Self::Interval { message, hz } => format!("message {message} at {hz} Hz"),
        }
    }
}

/// MAV_RESULT.
pub(crate) mod ack {
    pub(crate) const ACCEPTED: u8 = 0;
    pub(crate) const IN_PROGRESS: u8 = 5;

    pub(crate) const fn words(result: u8) -> &'static str {
        match result {
            1 => "temporarily rejected",
            2 => "denied",
            3 => "not supported",
            4 => "failed",
            6 => "cancelled",
            _ => "refused",
        }
    }
}
