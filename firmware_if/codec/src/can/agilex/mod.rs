//! AgileX chassis (Scout, Scout Mini, Tracer, Bunker, Hunter), protocol v2.
//!
//! Classic CAN, 11-bit identifiers, 500 kbit/s, numbers big-endian ("Motorola"), no node id: one chassis a bus. Byte
//! layouts are in [`wire`], what differs by chassis in [`Model`], the host's state machine in [`AgilexHost`].
//! Sources: Scout user manual v1.3.0, Tracer v1.2, Hunter CAN protocol v2.1, Bunker Mini; ugv_sdk.

#[cfg(test)]
mod golden_tests;
mod host;
#[cfg(test)]
mod host_tests;
mod model;
mod odometer;
mod verdict;
pub mod wire;

pub use host::{AgilexCounters, AgilexHost, AgilexParams};
pub use model::{Mode, Model};
