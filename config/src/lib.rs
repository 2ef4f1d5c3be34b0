//! Strict, typed TOML: robot kinds, worlds, swarms, and the file of one robot in the field.
//!
//! Raw text -> tree with positions -> checked values. Everything that is wrong is said at once, each with file, line,
//! column, key, the value found, the allowed range and what to do. What comes out cannot be wrong.

mod behaviour;
mod kind;
mod plane;
mod robot;
mod swarm;
mod world;

pub use behaviour::{Behaviour, Flock};
pub use kind::{AgilexModel, Body, Drive, Kind, Lidar, LidarLink, Motion, Sim, Timeouts};
pub use plane::{BeaconPlane, Radio};
pub use robot::{Links, Peer, Robot, RobotFile, Start};
pub use swarm::Swarm;
pub use world::{Circle, Polygon, World};
