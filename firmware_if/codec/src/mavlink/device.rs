//! The autopilot's end of the link: what a virtual rover must understand and say.
//!
//! [`decode`] turns a datagram into what ground stations and onboard computers ask for; [`Speaker`] turns
//! [`Telemetry`] into frames. Commands are read at fixed offsets, so that one that nobody knows can still be answered
//! with its own number.

mod setpoint;
mod telemetry;

pub use setpoint::{Demand, Setpoint};
pub use telemetry::{AckResult, Sector, Speaker, Telemetry, text_pieces};

use super::raw::{Heartbeat, Raw};
use super::wire::{Frame, WireCounters, frames};
use super::{AUTOPILOT_COMPONENT, cmd, id};
use drover_contract::MavId;

/// Something that reached an autopilot, and from whom.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Received {
    /// The sender.
    pub from: MavId,
    /// What it wants.
    pub what: Inbound,
}

/// What can be wanted of an autopilot.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Inbound {
    /// Somebody is there.
    Heartbeat {
        /// Its MAV_TYPE: 6 is a ground station.
        vehicle_type: u8,
    },
    /// SET_MODE (11), the old way; it is not acknowledged.
    SetMode {
        /// The mode.
        custom_mode: u32,
    },
    /// COMMAND_LONG or COMMAND_INT: to be acknowledged once, whatever it is.
    Command(Command),
    /// Drive.
    Setpoint(Setpoint),
    /// TIMESYNC question: answer with the same number.
    TimeQuestion {
        /// The asker's time, nanoseconds.
        asked_ns: i64,
    },
    /// REQUEST_DATA_STREAM (66), the old way to ask for telemetry.
    DataStream {
        /// MAV_DATA_STREAM; 0 is all.
        stream: u8,
        /// Messages per second.
        hz: u16,
        /// Start or stop.
        on: bool,
    },
    /// A good frame of another message.
    Other {
        /// Its id.
        message: u32,
    },
}

/// A command, with the number that its acknowledgement must carry.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Command {
    /// MAV_CMD, known or not.
    pub id: u16,
    /// What it asks for.
    pub ask: Ask,
}

/// What a command asks for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Ask {
    /// DO_SET_MODE (176).
    Mode(u32),
    /// COMPONENT_ARM_DISARM (400).
    Arm {
        /// Arm or disarm.
        arm: bool,
        /// Without the checks (parameter 2 is 21196).
        force: bool,
    },
    /// SET_MESSAGE_INTERVAL (511).
    Interval {
        /// Message id.
        message: u32,
        /// Microseconds; 0: the default, -1: off.
        interval_us: i64,
    },
    /// REQUEST_MESSAGE (512).
    Message(u32),
    /// Something else.
    Unknown,
}

/// Parameter 2 of an arm command that skips the checks.
const FORCE: f32 = 21196.0;

/// What `datagram` asks of the autopilot of `system`. Total: the rest is counted.
#[must_use]
pub fn decode(system: u8, datagram: &[u8], counters: &mut WireCounters) -> Vec<Received> {
    counters.datagrams += 1;
    let mut received = Vec::new();
    for found in frames(datagram) {
        match found {
            Ok(frame) => {
                counters.frames += 1;
                received.extend(read(system, &frame).map(|what| Received { from: frame.from, what }));
            }
            Err(skipped) => counters.skip(skipped),
        }
    }
    received
}

/// `None`: it is meant for another system or component.
fn read(system: u8, frame: &Frame<'_>) -> Option<Inbound> {
    let raw = Raw(frame.payload);
    let ours = |target: u8| target == system || target == 0;
    let inbound = match frame.message {
        id::HEARTBEAT => Inbound::Heartbeat { vehicle_type: Heartbeat::read(frame.payload).vehicle_type },
        id::SET_MODE if ours(raw.u8(4)) => Inbound::SetMode { custom_mode: raw.u32(0) },
        id::COMMAND_LONG | id::COMMAND_INT => {
            let for_us = ours(raw.u8(30)) && matches!(raw.u8(31), 0 | AUTOPILOT_COMPONENT);
            for_us.then(|| Inbound::Command(command(raw)))?
        }
        // The target component of a setpoint is not looked at.
        id::SET_POSITION_TARGET_LOCAL_NED if ours(raw.u8(50)) => Inbound::Setpoint(Setpoint::read(raw)),
        id::TIMESYNC if raw.i64(0) == 0 && ours(raw.u8(16)) => Inbound::TimeQuestion { asked_ns: raw.i64(8) },
        id::REQUEST_DATA_STREAM if ours(raw.u8(2)) => {
            Inbound::DataStream { stream: raw.u8(4), hz: raw.u16(0), on: raw.u8(5) != 0 }
        }
        id::SET_MODE | id::SET_POSITION_TARGET_LOCAL_NED | id::REQUEST_DATA_STREAM => return None,
        message => Inbound::Other { message },
    };
    Some(inbound)
}

/// COMMAND_LONG and COMMAND_INT agree in everything that is looked at here: parameters 1 and 2 at 0 and 4, the
/// command at 28, the target at 30 and 31.
fn command(raw: Raw<'_>) -> Command {
    let (first, second) = (raw.f32(0), raw.f32(4));
    let id = raw.u16(28);
    let ask = match id {
        cmd::DO_SET_MODE => Ask::Mode(second as u32),
        cmd::COMPONENT_ARM_DISARM => Ask::Arm { arm: first >= 0.5, force: (second - FORCE).abs() < 0.5 },
        cmd::SET_MESSAGE_INTERVAL => Ask::Interval { message: first as u32, interval_us: second as i64 },
        cmd::REQUEST_MESSAGE => Ask::Message(first as u32),
        _ => Ask::Unknown,
    };
    Command { id, ask }
}
