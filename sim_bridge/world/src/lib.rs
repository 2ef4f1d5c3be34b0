//! The simulated place: geometry, bodies, lidar, virtual firmware, radio. Pure and deterministic.
//!
//! Walls ([`Walls`]) and bodies ([`body::Body`]) make an [`Arena`]; the arena and the virtual firmware of every robot
//! make a plant, which knows its robots by the bytes on their links only. [`Radio`] stands beside it: beacons go from
//! robot to robot, not through firmware.

pub mod arena;
pub mod body;
mod chance;
pub mod firmware;
pub mod geometry;
pub mod lidar;
pub mod radio;

pub use arena::{Arena, BodySpec};
pub use firmware::{BodyState, PeerKey};
pub use geometry::{Disc, Walls};
pub use radio::{Radio, RadioTally};
