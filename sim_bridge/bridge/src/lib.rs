//! World <-> UDP MAVLink and CAN buses, paced to the wall clock.
//!
//! The simulator reaches a robot through the codec's bytes and nothing else (invariant 10): what crosses this crate are
//! datagrams and CAN frames, and the robot on the other side opens the same kinds of link as in the field.

mod bridge;
mod far_side;

pub use bridge::{Bridge, PlantHandle, pace};
pub use far_side::{BridgeError, CanBacking, CanChoice, CanEnd, NearSide};
