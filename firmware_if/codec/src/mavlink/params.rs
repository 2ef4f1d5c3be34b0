//! What a host is told at first, and what it counts.

use super::wire::WireCounters;
use std::time::Duration;

/// What a host must know of its robot.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MavHostParams {
    /// The robot's MAVLink system id, 1..=255: the autopilot's, and ours on this link.
    pub robot: u8,
    /// Our component id on this link (191: onboard computer).
    pub component: u8,
    /// How often pose and odometry are asked for, Hz, 1..=40 (ArduPilot refuses more at its default loop rate).
    pub telemetry_hz: u32,
    /// The component whose OBSTACLE_DISTANCE is the scan (196: obstacle avoidance).
    pub lidar_component: u8,
    /// The least range, metres, if the lidar does not say.
    pub range_m_min: f64,
    /// The greatest range, metres, if the lidar does not say.
    pub range_m_max: f64,
    /// An autopilot that drives and is silent for longer than this is lost.
    pub link_timeout: Duration,
}

/// What a host has seen and not used.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct MavCounters {
    /// Framing.
    pub wire: WireCounters,
    /// Good frames of other systems and components.
    pub foreign: u64,
    /// Good frames whose content made no sense.
    pub nonsense: u64,
    /// Acknowledgements that answered nothing we had asked.
    pub stray_acks: u64,
    /// DISTANCE_SENSOR messages of the autopilot's own sectors.
    pub sectors: u64,
    /// Commands that were not sent because the drive was not ready.
    pub withheld: u64,
    /// Events that nobody fetched in time.
    pub events_dropped: u64,
    /// Messages that nobody sent in time.
    pub outputs_dropped: u64,
}
