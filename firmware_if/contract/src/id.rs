//! Identities are newtypes: no bare number crosses a crate.

use serde::{Deserialize, Serialize};
use std::fmt;

/// A robot of the swarm. 32 bits inside; MAVLink's 8-bit system id is a window onto it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(transparent)]
pub struct RobotId(pub u32);

impl fmt::Display for RobotId {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.0)
    }
}

/// A node on a DroneCAN bus, 1..=127.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct CanNode(pub u8);

/// Who speaks in MAVLink: a system and one of its components.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct MavId {
    /// MAVLink system id, 1..=255.
    pub system: u8,
    /// MAVLink component id; 1 is the autopilot.
    pub component: u8,
}
