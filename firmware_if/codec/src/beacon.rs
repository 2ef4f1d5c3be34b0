//! What robots broadcast to each other: DROVER_BEACON, DROVER_LINKS (in `links.rs`), DROVER_MAP (in `map.rs`) and
//! DROVER_STOP of our own dialect, `dialect/drover.xml`.
//!
//! One MAVLink 2 frame a datagram. DROVER_BEACON carries 63 bytes of state (75 bytes on the wire with header and CRC
//! at most) and keeps 64 more for a signature that is not made yet: zeros at a payload's end are not sent, so it costs
//! nothing, and neither does a leader where nobody leads. Fields stand in the XML file's order, which is MAVLink's too
//! (falling size, then extensions as they come). The swarm's hash keeps two swarms on one group apart; it is no
//! protection against a hostile sender.

use crate::links::{LINKS, LINKS_BYTES_MAX, LINKS_EXTRA_CRC, read_links};
use crate::map::{MAP, MAP_BYTES_MAX, MAP_EXTRA_CRC, read_map};
use crate::mavlink::raw::Raw;
use crate::mavlink::wire::{Emitter, Skipped, frames_of};
use drover_contract::{Beacon, BehaviourState, LinkReport, MapReport, MavId, Pose, RobotId, Stamp, Twist};
use std::f64::consts::PI;
use thiserror::Error;

const BEACON: u32 = 52_000;
const BEACON_EXTRA_CRC: u8 = 165;
const STOP: u32 = 52_001;
const STOP_EXTRA_CRC: u8 = 223;
/// With the signature.
const BEACON_BYTES_MAX: usize = 127;
const STOP_BYTES_MAX: usize = 77;
const DATAGRAM_BYTES_MAX: usize = 280;
/// Header's component id: an onboard computer.
const COMPONENT: u8 = 191;
const REASON_OPERATOR: u8 = 0;

/// No robot is farther from the origin, faster, or bigger: such a beacon is nonsense.
pub(crate) const POSITION_M_MAX: f64 = 1.0e6;
const RATE_MAX: f64 = 100.0;
const ACCEL_MPS2_MAX: f64 = 1.0e3;
const RADIUS_M_MAX: f64 = 100.0;
/// An f32 pi is a little more than pi.
const YAW_RAD_MAX: f64 = PI + 1.0e-6;

/// What a datagram of the beacon plane says.
#[derive(Clone, Debug, PartialEq)]
pub enum Message {
    /// The state of a robot.
    Beacon {
        /// [`swarm_hash`] of its swarm's name.
        swarm: u32,
        /// The state.
        beacon: Beacon,
    },
    /// The links of a robot.
    Links {
        /// [`swarm_hash`] of its swarm's name.
        swarm: u32,
        /// The links: boxed, for it is ten times as big as the others.
        report: Box<LinkReport>,
    },
    /// A robot's part in making a map.
    Map {
        /// [`swarm_hash`] of its swarm's name.
        swarm: u32,
        /// Its report: boxed as links are.
        report: Box<MapReport>,
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
    #[error("message {0} is none of the beacon plane")]
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
    payload.extend_from_slice(&beacon.leader.map_or(0, |id| id.0).to_le_bytes());
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

pub(crate) fn emitter(robot: RobotId, seq: u8) -> Emitter {
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
        LINKS if frame.payload.len() <= LINKS_BYTES_MAX => read_links(raw, frame.from.system),
        MAP if frame.payload.len() <= MAP_BYTES_MAX => read_map(raw, frame.from.system),
        STOP if frame.payload.len() <= STOP_BYTES_MAX => Ok(read_stop(raw)),
        _ => Err(DecodeError::Oversized(datagram.len())),
    }
}

fn extra_crc(message: u32) -> Option<u8> {
    match message {
        BEACON => Some(BEACON_EXTRA_CRC),
        LINKS => Some(LINKS_EXTRA_CRC),
        MAP => Some(MAP_EXTRA_CRC),
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
    let leader = raw.u32(59);
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
        leader: (leader != 0).then_some(RobotId(leader)),
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mavlink::golden::vectors;

    fn golden(label: &str) -> Vec<u8> {
        let file = include_str!(concat!(env!("CARGO_MANIFEST_DIR"), "/../../tests/golden/mavlink/beacon.txt"));
        vectors(file).remove(label).expect("known label").bytes
    }

    fn sample() -> Beacon {
        Beacon {
            robot: RobotId(70_003),
            epoch: 5,
            seq: 1234,
            sent: Stamp::from_micros(9_000_000_123),
            pose_wb: Pose::new(12.5, -3.25, 1.5),
            twist_b: Twist::new(0.75, -0.5),
            accel_mps2: 0.25,
            pos_bound_m: 0.125,
            radius_m: 0.3,
            state: BehaviourState::Active,
            progress: 0.5,
            leader: Some(RobotId(4_000_000_007)),
        }
    }

    #[test]
    fn our_beacon_is_the_bytes_that_pymavlink_makes_from_our_dialect() {
        assert_eq!(encode_beacon(swarm_hash("first"), &sample(), 17), golden("beacon"));
        assert_eq!(golden("beacon").len(), 75, "63 bytes of state, 12 around them");
    }

    #[test]
    fn a_beacon_whose_sender_follows_nobody_is_the_one_from_before_there_were_leaders() {
        let beacon = Beacon { leader: None, ..sample() };
        let bytes = encode_beacon(swarm_hash("first"), &beacon, 17);
        assert_eq!(bytes, golden("beacon_without_leader"));
        assert_eq!(bytes.len(), 71, "not a byte more than what it had then");
        let Ok(Message::Beacon { beacon, .. }) = decode(&bytes) else { panic!("no beacon") };
        assert_eq!(beacon.leader, None);
    }

    #[test]
    fn every_leader_but_0_goes_over_the_wire_whatever_zeros_are_before_it() {
        for (leader, bytes) in [(1, 72), (255, 72), (256, 73), (70_001, 74), (u32::MAX, 75)] {
            let beacon = Beacon { leader: Some(RobotId(leader)), ..sample() };
            let idle = Beacon { state: BehaviourState::Waiting, progress: 0.0, ..beacon };
            for beacon in [beacon, idle] {
                let datagram = encode_beacon(1, &beacon, 0);
                assert_eq!(datagram.len(), bytes, "{leader}");
                let Ok(Message::Beacon { beacon: got, .. }) = decode(&datagram) else { panic!("no beacon") };
                assert_eq!(got.leader, beacon.leader);
            }
        }
        let nobody = encode_beacon(1, &Beacon { leader: Some(RobotId(0)), ..sample() }, 0);
        let Ok(Message::Beacon { beacon, .. }) = decode(&nobody) else { panic!("no beacon") };
        assert_eq!(beacon.leader, None, "no robot has the id 0");
    }

    #[test]
    fn a_beacon_that_pymavlink_made_reads_as_what_it_says() {
        let Ok(Message::Beacon { swarm, beacon }) = decode(&golden("beacon")) else { panic!("no beacon") };
        assert_eq!(swarm, swarm_hash("first"));
        let close = |a: f64, b: f64| assert!((a - b).abs() < 1e-4, "{a} is not {b}");
        close(beacon.radius_m, 0.3);
        close(beacon.progress, 0.5);
        let exact = Beacon { radius_m: 0.3, progress: 0.5, ..beacon };
        assert_eq!(exact, sample());
    }

    #[test]
    fn zeros_at_the_end_are_not_sent_and_a_signature_changes_nothing_yet() {
        let Ok(Message::Beacon { beacon, .. }) = decode(&golden("beacon_mostly_zero")) else { panic!("no beacon") };
        assert_eq!((beacon.robot, beacon.state, beacon.radius_m), (RobotId(256), BehaviourState::Waiting, 0.5));
        assert_eq!(beacon.leader, None);
        let Ok(Message::Beacon { beacon, .. }) = decode(&golden("beacon_with_signature")) else { panic!("no beacon") };
        assert_eq!((beacon.robot, beacon.progress, beacon.leader), (RobotId(3), 1.0, Some(RobotId(2))));
    }

    #[test]
    fn numbers_out_of_range_are_refused_by_name() {
        let refused = |label| decode(&golden(label)).expect_err("refused");
        assert_eq!(refused("bad_beacon_nan"), DecodeError::Range("x"));
        assert_eq!(refused("bad_beacon_infinite"), DecodeError::Range("speed"));
        assert_eq!(refused("bad_beacon_turned_too_far"), DecodeError::Range("yaw"));
        assert_eq!(refused("bad_beacon_state"), DecodeError::Range("state"));
        let anonymous = encode_beacon(1, &Beacon { robot: RobotId(0), ..sample() }, 0);
        assert_eq!(decode(&anonymous), Err(DecodeError::Range("robot")));
    }

    #[test]
    fn a_stop_names_one_robot_or_all() {
        let swarm = swarm_hash("first");
        assert_eq!(encode_stop(swarm, None, 4), golden("stop_all"));
        assert_eq!(encode_stop(swarm, Some(RobotId(70_003)), 4), golden("stop_one"));
        assert_eq!(decode(&golden("stop_all")), Ok(Message::Stop { swarm, robot: None }));
        assert_eq!(decode(&golden("stop_one")), Ok(Message::Stop { swarm, robot: Some(RobotId(70_003)) }));
    }

    #[test]
    fn one_wrong_bit_anywhere_is_never_taken_for_a_beacon() {
        let good = golden("beacon");
        for bit in 0..good.len() * 8 {
            let mut bad = good.clone();
            bad[bit / 8] ^= 1 << (bit % 8);
            assert!(decode(&bad).is_err(), "bit {bit}");
        }
        for length in 0..good.len() {
            assert!(decode(&good[..length]).is_err(), "cut to {length}");
        }
        assert_eq!(decode(&[0xFD; 281]), Err(DecodeError::Oversized(281)));
        let twice = [good.clone(), good].concat();
        assert_eq!(decode(&twice), Err(DecodeError::Frame));
    }

    #[test]
    fn a_frame_of_the_common_dialect_is_foreign() {
        let heartbeat = [0xFD, 1, 0, 0, 0, 1, 1, 0, 0, 0, 0, 0, 0];
        assert_eq!(decode(&heartbeat), Err(DecodeError::Foreign(0)));
    }

    #[test]
    fn a_header_cannot_speak_for_another_robot() {
        let mut forged = Emitter::new(MavId { system: 9, component: COMPONENT });
        let payload = &golden("beacon")[10..73];
        assert_eq!(decode(&forged.encode_raw(BEACON, BEACON_EXTRA_CRC, payload)), Err(DecodeError::Sender));
    }

    #[test]
    fn garbage_never_panics() {
        let mut state = 1_u32;
        for _ in 0..20_000 {
            let mut bytes = Vec::new();
            for _ in 0..(state >> 8) % 140 {
                state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                bytes.push((state >> 24) as u8);
            }
            state = state.wrapping_add(97);
            if let Some(first) = bytes.first_mut() {
                *first = 0xFD;
            }
            assert!(decode(&bytes).is_err());
        }
    }

    #[test]
    fn swarm_hashes_are_fnv_1a() {
        assert_eq!(swarm_hash(""), 0x811C_9DC5);
        assert_eq!(swarm_hash("foobar"), 0xBF9C_F968, "published test vector");
        assert_eq!([system_window(RobotId(256)), system_window(RobotId(70_003))], [255, 115]);
    }
}
