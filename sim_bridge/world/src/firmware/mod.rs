//! Virtual firmware: what stands on the far side of a robot's links, each with its device's own habits.
//!
//! Every firmware speaks bytes or CAN frames only, through the same codec as the robot; it sees its body as
//! [`BodyState`] and asks it to move by the twist that its `demand()` returns.

mod rover;

pub use rover::{RoverParams, VirtualRover};

mod agilex;
mod lidar_node;

pub use agilex::{AgilexSimParams, VirtualAgilex};
pub use lidar_node::{DronecanSimParams, NodeHealth, VirtualDronecanLidar};

use drover_contract::{Pose, Twist, WheelTravel};

/// A body, as its own sensors could know it: what firmware may look at.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct BodyState {
    /// The body in the world.
    pub pose_wb: Pose,
    /// Its true velocity in its own frame, slip included.
    pub twist_b: Twist,
    /// How far the wheels have rolled since the start, as encoders count it: slip shows in `pose_wb`, not here.
    pub wheels: WheelTravel,
    /// Whether it touches a wall or another body.
    pub in_contact: bool,
}

/// Who sent a datagram and where the answer goes. The bridge decides what the number stands for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct PeerKey(pub u64);
