//! Peers that others wrote, over real UDP: pymavlink as ground station, rover and listener; readers of recordings.
//!
//! They are the Python scripts in `peers`, run by the Python that `DROVER_PEERS_PYTHON` names (`tests/run` makes it). A
//! missing one is a failure. Peers that need a CAN bus stand in `tests/vcan`.

#[path = "../common/mod.rs"]
mod common;

mod beacons;
mod golden;
mod ground_stations;
mod mcap;
mod recordings;
mod rover;
mod support;
