//! The simulated place: geometry, bodies, lidar, virtual firmware, radio. Pure and deterministic.
//!
//! Walls ([`Walls`]) and bodies ([`body::Body`]) make an [`Arena`]; the arena and the virtual firmware of every robot
//! make a [`Plant`], which knows its robots by the bytes on their links only. [`Radio`] stands beside it: beacons go
//! from robot to robot, not through firmware.

pub mod arena;
pub mod body;
mod chance;
pub mod fault;
pub mod firmware;
pub mod geometry;
pub mod lidar;
pub mod plant;
pub mod radio;
mod station;

pub use arena::{Arena, BodySpec};
pub use fault::Fault;
pub use firmware::{BodyState, PeerKey};
pub use geometry::{Disc, Walls};
pub use plant::{Output, Packet, Plant, Port, Truth};
pub use radio::{Radio, RadioTally};
