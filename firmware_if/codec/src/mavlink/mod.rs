//! MAVLink 2 as rover autopilots speak it: both sides of the link, bytes to contract and back.
//!
//! [`MavHost`] is the onboard computer's side: it brings an autopilot from silent to driving and turns its telemetry
//! into [`drover_contract::Event`]s. [`device`] is the autopilot's side, for the virtual rover. The `mavlink` crate
//! parses and serialises typed messages; the framing is ours (its connections answer the last sender only and share
//! one sequence counter), and whatever holds an enumeration is read at fixed offsets, because an unknown value makes
//! the typed parse fail.
//!
//! Wire frames (NED, FRD, centimetres, degrees) end in this folder; `ned.rs` converts.

mod bringup;
mod clock;
pub mod device;
mod host;
mod motion;
mod ned;
mod obstacle;
mod outbox;
mod params;
pub(crate) mod raw;
mod request;
mod text;
pub(crate) mod wire;

#[cfg(test)]
pub(crate) mod golden;
#[cfg(test)]
mod tests;

pub use host::MavHost;
pub use params::{MavCounters, MavHostParams};
pub use wire::WireCounters;

/// The component id of every autopilot (MAV_COMP_ID_AUTOPILOT1).
pub const AUTOPILOT_COMPONENT: u8 = 1;

/// ArduPilot Rover's modes, as HEARTBEAT.custom_mode says them.
pub mod mode {
    /// A human steers.
    pub const MANUAL: u32 = 0;
    /// A human steers, rate controlled.
    pub const ACRO: u32 = 1;
    /// A human steers, with limits.
    pub const STEERING: u32 = 3;
    /// Stand still.
    pub const HOLD: u32 = 4;
    /// Stay around a point.
    pub const LOITER: u32 = 5;
    /// Follow a mission.
    pub const AUTO: u32 = 10;
    /// Return to launch.
    pub const RTL: u32 = 11;
    /// Return along the way it came.
    pub const SMART_RTL: u32 = 12;
    /// Obey a computer.
    pub const GUIDED: u32 = 15;
    /// Starting up.
    pub const INITIALISING: u32 = 16;

    /// The mode's name.
    #[must_use]
    pub const fn name(custom_mode: u32) -> &'static str {
        match custom_mode {
            MANUAL => "MANUAL",
            ACRO => "ACRO",
            STEERING => "STEERING",
            HOLD => "HOLD",
            LOITER => "LOITER",
            AUTO => "AUTO",
            RTL => "RTL",
            SMART_RTL => "SMART_RTL",
            GUIDED => "GUIDED",
            INITIALISING => "INITIALISING",
            _ => "another mode",
        }
    }
}

/// Message ids that are asked for or answered by number.
mod id {
    pub(crate) const HEARTBEAT: u32 = 0;
    pub(crate) const SYS_STATUS: u32 = 1;
    pub(crate) const SET_MODE: u32 = 11;
    pub(crate) const ATTITUDE: u32 = 30;
    pub(crate) const LOCAL_POSITION_NED: u32 = 32;
    pub(crate) const REQUEST_DATA_STREAM: u32 = 66;
    pub(crate) const COMMAND_INT: u32 = 75;
    pub(crate) const COMMAND_LONG: u32 = 76;
    pub(crate) const COMMAND_ACK: u32 = 77;
    pub(crate) const SET_POSITION_TARGET_LOCAL_NED: u32 = 84;
    pub(crate) const TIMESYNC: u32 = 111;
    pub(crate) const DISTANCE_SENSOR: u32 = 132;
    pub(crate) const BATTERY_STATUS: u32 = 147;
    pub(crate) const STATUSTEXT: u32 = 253;
    pub(crate) const OBSTACLE_DISTANCE: u32 = 330;
}

/// Commands (MAV_CMD) that are sent or answered by number.
mod cmd {
    pub(crate) const DO_SET_MODE: u16 = 176;
    pub(crate) const COMPONENT_ARM_DISARM: u16 = 400;
    pub(crate) const SET_MESSAGE_INTERVAL: u16 = 511;
    pub(crate) const REQUEST_MESSAGE: u16 = 512;
}
