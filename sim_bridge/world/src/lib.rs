//! The simulated place: geometry, bodies, lidar, virtual firmware, radio. Pure and deterministic.
//!
//! Walls ([`Walls`]), what moves among them ([`Mover`]) and bodies ([`body::Body`]) make a [`Place`], and an [`Arena`]
//! moves all that moves; the arena and the virtual firmware of every robot make a [`Plant`], which knows its robots by
//! the bytes on their links only. [`Radio`] stands beside it: beacons go from robot to robot, not through firmware.

pub mod arena;
pub mod body;
mod chance;
mod clearance;
mod contacts;
mod depth;
pub mod fault;
pub mod firmware;
pub mod geometry;
mod grid;
mod ideal;
mod lanes;
pub mod lidar;
mod map;
mod movers;
mod periodic;
mod place;
pub mod plant;
pub mod radio;
pub mod sight;
mod station;
mod sweep;
mod walls;

pub use arena::{Arena, BodySpec, Eyes};
pub use chance::phases;
pub use clearance::Clearance;
pub use fault::Fault;
pub use firmware::{BodyState, PeerKey};
pub use geometry::{Disc, Outline, Segment};
pub use ideal::IdealDevice;
pub use lidar::{Lidar, LidarParams};
pub use movers::Mover;
pub use place::Place;
pub use plant::{Output, Packet, Plant, Port, Truth};
pub use radio::{Delivery, Radio, RadioTally, Scene};
pub use walls::Walls;
