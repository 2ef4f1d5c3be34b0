//! DroneCAN (UAVCAN v0) on classic CAN: framing, the few messages of a range sensor, and the host of a lidar node.
//!
//! 29-bit identifiers ([`FrameId`]), a tail byte in every frame, a CRC over multi-frame transfers ([`transfer`]),
//! values little-endian with bits packed from the top of each byte ([`message`]).
//! Sources: the DroneCAN specification and DSDL; golden vectors by pydronecan.

mod float16;
#[cfg(test)]
mod golden_tests;
mod host;
#[cfg(test)]
mod host_tests;
mod id;
pub mod message;
mod reassembly;
#[cfg(test)]
mod reassembly_tests;
mod sectors;
pub mod transfer;

pub use float16::{float16_decode, float16_encode};
pub use host::{DronecanCounters, DronecanLidarHost, DronecanLidarParams};
pub use id::FrameId;
pub use reassembly::{Reassembler, ReassemblyCounters, Transfer};
