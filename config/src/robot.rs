//! One robot: in a swarm file, and as the file that `drover run` reads in the field.

use crate::{BeaconPlane, Behaviour, Kind};
use serde::Serialize;

/// One robot of a swarm.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Robot {
    /// 1..=4294967295, unique in the swarm; 1..=250 for a MAVLink robot (its system id).
    pub id: u32,
    /// Name of its kind.
    pub kind: String,
    /// Where it stands at first.
    pub start: Start,
    /// How its firmware is reached.
    pub links: Links,
}

/// A start pose in the world frame.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Start {
    /// East, metres.
    pub x_m: f64,
    /// North, metres.
    pub y_m: f64,
    /// Heading, radians, counter-clockwise from east.
    pub yaw_rad: f64,
}

/// How a robot's firmware is reached. Derived from the robot's id unless given.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
#[serde(untagged)]
pub enum Links {
    /// One MAVLink link: `udpout:HOST:PORT` (we speak first) or `udpin:HOST:PORT` (the autopilot does).
    Mavlink {
        /// The address.
        autopilot: String,
    },
    /// Two CAN buses: the drive's and the lidar's. Interface names (`can0`, `vcan4d`), or
    /// `udp:LOCAL_PORT:REMOTE_PORT`, a bus tunnelled over loopback for machines without CAN.
    Can {
        /// The chassis.
        drive: String,
        /// The lidar.
        lidar: String,
    },
}

/// What a robot knows of another beforehand.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Peer {
    /// Its id.
    pub id: u32,
    /// Radius of its body, metres.
    pub radius_m: f64,
}

/// Everything that `drover run` needs, in one file.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RobotFile {
    /// Name of the swarm.
    pub swarm: String,
    /// This robot.
    pub robot: Robot,
    /// Its kind.
    pub kind: Kind,
    /// What the swarm does.
    pub behaviour: Behaviour,
    /// How it hears and tells the others.
    pub beacon: BeaconPlane,
    /// The others.
    pub peers: Vec<Peer>,
    /// Folder for recordings; none: nothing is recorded.
    pub record_dir: Option<String>,
}
