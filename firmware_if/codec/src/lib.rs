//! Bytes <-> contract: MAVLink, AgileX, DroneCAN, beacon. No sockets, no clock.

pub mod beacon;
pub mod can;
pub mod links;
pub mod map;
pub mod mavlink;
