//! What carries beacons: a multicast group between computers, a modelled radio within one process.

use serde::Serialize;

/// The beacon plane.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct BeaconPlane {
    /// Multicast group, 224.0.0.0/4.
    pub group: String,
    /// UDP port, 1024..=65535.
    pub port: u16,
    /// Address of the interface to use; 127.0.0.1 keeps it on this computer.
    pub interface: String,
    /// Beacons per second, 1..=50.
    pub rate_hz: f64,
}

/// The modelled radio between robots of one process.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Radio {
    /// Farther apart than this, robots do not hear each other, metres, > 0.
    pub range_m: f64,
    /// Share of beacons lost, each on its own, 0..=1.
    pub loss: f64,
    /// Shortest delay, ms, 0..=10000.
    pub delay_ms: f64,
    /// Added to it, uniformly, up to this, ms, 0..=10000.
    pub jitter_ms: f64,
}
