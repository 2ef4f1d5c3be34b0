//! Virtual firmware: what stands on the far side of a robot's links, each with its device's own habits.
//!
//! Every firmware speaks bytes or CAN frames only (the rover through the robot's codec, the CAN devices by writing
//! their own, so that each proves the other); it sees its body as [`BodyState`] and asks it to move by the twist that
//! its `demand()` returns.

mod agilex;
mod lidar_node;
mod rover;

pub use agilex::{AgilexSimParams, VirtualAgilex};
pub use lidar_node::{DronecanSimParams, NodeHealth, VirtualDronecanLidar};
pub use rover::{RoverParams, VirtualRover};

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
