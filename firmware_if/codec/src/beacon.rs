//! What robots broadcast to each other: DROVER_BEACON and DROVER_STOP of our own dialect, `dialect/drover.xml`.
//!
//! One MAVLink 2 frame a datagram. DROVER_BEACON carries 59 bytes of state (75 bytes on the wire with header and CRC
//! at most) and keeps 64 more for a signature that is not made yet: zeros at a payload's end are not sent, so it costs
//! nothing. Fields stand in the XML file's order, which is MAVLink's order too (falling size). The swarm's hash keeps
//! two swarms on one group apart; it is no protection against a hostile sender.

use crate::mavlink::raw::Raw;
use crate::mavlink::wire::{Emitter, Skipped, frames_of};
use drover_contract::{Beacon, BehaviourState, MavId, Pose, RobotId, Stamp, Twist};
use std::f64::consts::PI;
use thiserror::Error;

const BEACON: u32 = 52_000;
const BEACON_EXTRA_CRC: u8 = 165;
const STOP: u32 = 52_001;
const STOP_EXTRA_CRC: u8 = 223;
/// With the signature.
const BEACON_BYTES_MAX: usize = 123;
const STOP_BYTES_MAX: usize = 77;
const DATAGRAM_BYTES_MAX: usize = 280;
/// Header's component id: an onboard computer.
const COMPONENT: u8 = 191;
const REASON_OPERATOR: u8 = 0;

/// No robot is farther from the origin, faster, or bigger: such a beacon is nonsense.
const POSITION_M_MAX: f64 = 1.0e6;
const RATE_MAX: f64 = 100.0;
const ACCEL_MPS2_MAX: f64 = 1.0e3;
const RADIUS_M_MAX: f64 = 100.0;
/// An f32 pi is a little more than pi.
const YAW_RAD_MAX: f64 = PI + 1.0e-6;

/// What a datagram of the beacon plane says.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Message {
    /// The state of a robot.
    Beacon {
        /// [`swarm_hash`] of its swarm's name.
        swarm: u32,
        /// The state.
        beacon: Beacon,
    },
    /// Stop, latched.
    Stop {
        /// [`swarm_hash`] of the swarm's name.
        swarm: u32,
        /// One robot, or all of the swarm.
        robot: Option<RobotId>,
    },
}

/// Why a datagram is no message of the beacon plane.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
pub enum DecodeError {
    /// More bytes than any message has.
    #[error("{0} bytes are more than any message has")]
    Oversized(usize),
    /// Not one whole frame with a right checksum.
    #[error("not one whole MAVLink 2 frame with a right checksum")]
    Frame,
    /// A good frame of something else.
    #[error("message {0} is neither a beacon nor a stop")]
    Foreign(u32),
    /// The header speaks for another robot than the payload.
    #[error("header and payload name different robots")]
    Sender,
    /// A field is not finite or out of its range.
    #[error("field {0} is out of its range")]
    Range(&'static str),
}

/// FNV-1a, 32 bits: which swarm a message belongs to.
#[must_use]
pub fn swarm_hash(name: &str) -> u32 {
    name.bytes().fold(0x811C_9DC5, |hash, byte| (hash ^ u32::from(byte)).wrapping_mul(0x0100_0193))
}

/// The 8-bit window onto a robot's id that MAVLink headers carry: never 0, which means everybody.
#[must_use]
pub const fn system_window(robot: RobotId) -> u8 {
    match (robot.0 & 0xFF) as u8 {
        0 => u8::MAX,
        low => low,
    }
}

/// `beacon` as a datagram; `seq` counts the frames of this sender. Numbers travel as f32.
#[must_use]
pub fn encode_beacon(swarm: u32, beacon: &Beacon, seq: u8) -> Vec<u8> {
    let Beacon { pose_wb, twist_b, .. } = beacon;
    let mut payload = Vec::with_capacity(BEACON_BYTES_MAX);
    payload.extend_from_slice(&beacon.sent.as_micros().to_le_bytes());
    for word in [swarm, beacon.robot.0, beacon.epoch, beacon.seq] {
        payload.extend_from_slice(&word.to_le_bytes());
    }
    let numbers = [
        pose_wb.x_m,
        pose_wb.y_m,
        pose_wb.yaw_rad,
        twist_b.speed_mps,
        twist_b.yaw_rate_radps,
        beacon.accel_mps2,
        beacon.pos_bound_m,
        beacon.radius_m,
    ];
    for number in numbers {
        payload.extend_from_slice(&(number as f32).to_le_bytes());
    }
    let progress = (beacon.progress.clamp(0.0, 1.0) * f64::from(u16::MAX)).round() as u16;
    payload.extend_from_slice(&progress.to_le_bytes());
    payload.push(state_to_wire(beacon.state));
    emitter(beacon.robot, seq).encode_raw(BEACON, BEACON_EXTRA_CRC, &payload)
}

/// A stop for one robot of the swarm, or for all, as a datagram.
#[must_use]
pub fn encode_stop(swarm: u32, robot: Option<RobotId>, seq: u8) -> Vec<u8> {
    let target = robot.map_or(0, |id| id.0);
    let mut payload = Vec::with_capacity(STOP_BYTES_MAX);
    for word in [swarm, target, u32::from(seq)] {
        payload.extend_from_slice(&word.to_le_bytes());
    }
    payload.push(REASON_OPERATOR);
    emitter(RobotId(0), seq).encode_raw(STOP, STOP_EXTRA_CRC, &payload)
}

fn emitter(robot: RobotId, seq: u8) -> Emitter {
    Emitter::starting_at(MavId { system: system_window(robot), component: COMPONENT }, seq)
}

/// The message in `datagram`. Total: nothing that arrives does more than be refused.
///
/// # Errors
/// [`DecodeError`] says what is wrong with it.
pub fn decode(datagram: &[u8]) -> Result<Message, DecodeError> {
    if datagram.len() > DATAGRAM_BYTES_MAX {
        return Err(DecodeError::Oversized(datagram.len()));
    }
    let mut found = frames_of(datagram, extra_crc);
    let frame = match (found.next(), found.next()) {
        (Some(Ok(frame)), None) => frame,
        (Some(Err(Skipped::Unknown)), None) => return Err(DecodeError::Foreign(foreign_id(datagram))),
        _ => return Err(DecodeError::Frame),
    };
    let raw = Raw(frame.payload);
    match frame.message {
        BEACON if frame.payload.len() <= BEACON_BYTES_MAX => read_beacon(raw, frame.from.system),
        STOP if frame.payload.len() <= STOP_BYTES_MAX => Ok(read_stop(raw)),
        _ => Err(DecodeError::Oversized(datagram.len())),
    }
}

fn extra_crc(message: u32) -> Option<u8> {
    match message {
        BEACON => Some(BEACON_EXTRA_CRC),
        STOP => Some(STOP_EXTRA_CRC),
        _ => None,
    }
}

/// The id in a header that is known to be whole, MAVLink 2 or 1.
fn foreign_id(datagram: &[u8]) -> u32 {
    match datagram {
        [0xFD, _, _, _, _, _, _, low, middle, high, ..] => u32::from_le_bytes([*low, *middle, *high, 0]),
        [_, _, _, _, _, id, ..] => u32::from(*id),
        _ => 0,
    }
}

fn read_stop(raw: Raw<'_>) -> Message {
    let target = raw.u32(4);
    Message::Stop { swarm: raw.u32(0), robot: (target != 0).then_some(RobotId(target)) }
}

fn read_beacon(raw: Raw<'_>, system: u8) -> Result<Message, DecodeError> {
    let robot = RobotId(raw.u32(12));
    if robot.0 == 0 {
        return Err(DecodeError::Range("robot"));
    }
    if system != system_window(robot) {
        return Err(DecodeError::Sender);
    }
    let within = |offset: usize, range: std::ops::RangeInclusive<f64>, name: &'static str| {
        let number = f64::from(raw.f32(offset));
        if range.contains(&number) { Ok(number) } else { Err(DecodeError::Range(name)) }
    };
    let x_m = within(24, -POSITION_M_MAX..=POSITION_M_MAX, "x")?;
    let y_m = within(28, -POSITION_M_MAX..=POSITION_M_MAX, "y")?;
    let yaw_rad = within(32, -YAW_RAD_MAX..=YAW_RAD_MAX, "yaw")?;
    let speed_mps = within(36, -RATE_MAX..=RATE_MAX, "speed")?;
    let yaw_rate_radps = within(40, -RATE_MAX..=RATE_MAX, "yaw_rate")?;
    let beacon = Beacon {
        robot,
        epoch: raw.u32(16),
        seq: raw.u32(20),
        sent: Stamp::from_micros(raw.u64(0)),
        pose_wb: Pose::new(x_m, y_m, yaw_rad),
        twist_b: Twist::new(speed_mps, yaw_rate_radps),
        accel_mps2: within(44, -ACCEL_MPS2_MAX..=ACCEL_MPS2_MAX, "accel")?,
        pos_bound_m: within(48, 0.0..=POSITION_M_MAX, "pos_bound")?,
        radius_m: within(52, 0.0..=RADIUS_M_MAX, "radius")?,
        progress: f64::from(raw.u16(56)) / f64::from(u16::MAX),
        state: state_from_wire(raw.u8(58)).ok_or(DecodeError::Range("state"))?,
    };
    Ok(Message::Beacon { swarm: raw.u32(8), beacon })
}

const fn state_to_wire(state: BehaviourState) -> u8 {
    match state {
        BehaviourState::Waiting => 0,
        BehaviourState::Active => 1,
        BehaviourState::Held => 2,
        BehaviourState::Done => 3,
        BehaviourState::Stopped => 4,
    }
}

const fn state_from_wire(wire: u8) -> Option<BehaviourState> {
    match wire {
        0 => Some(BehaviourState::Waiting),
        1 => Some(BehaviourState::Active),
        2 => Some(BehaviourState::Held),
        3 => Some(BehaviourState::Done),
        4 => Some(BehaviourState::Stopped),
        _ => None,
    }
}
