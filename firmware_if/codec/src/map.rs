//! DROVER_MAP of our own dialect: what [`drover_contract::MapReport`] says, framed as a beacon is.
//!
//! 190 bytes of state (202 on the wire at most) and 64 more for a signature that is not made yet. Zeros at the end
//! are not sent, so a report without a piece of a log is no longer than what it tells. A cell goes as its number plus
//! one, so that 0 is none; a writer whose robot is 0 is an empty place.

use crate::beacon::{DecodeError, Message, emitter, system_window};
use crate::mavlink::raw::Raw;
use drover_contract::{CHANGES_BYTES_MAX, MapChunk, MapHead, MapReport, RobotId, Writer};

pub(crate) const MAP: u32 = 52_003;
pub(crate) const MAP_EXTRA_CRC: u8 = 6;
const STATE_BYTES: usize = at::CHANGES + CHANGES_BYTES_MAX;
/// With the signature.
pub(crate) const MAP_BYTES_MAX: usize = STATE_BYTES + 64;

const DONE: u8 = 1;

/// Where each field starts.
mod at {
    pub(super) const SWARM: usize = 0;
    pub(super) const ROBOT: usize = 4;
    pub(super) const EPOCH: usize = 8;
    pub(super) const SEQ: usize = 12;
    pub(super) const LATTICE: usize = 16;
    pub(super) const GOAL: usize = 20;
    pub(super) const HEAD_ROBOT: usize = 24;
    pub(super) const HEAD_EPOCH: usize = 44;
    pub(super) const HEAD: usize = 64;
    pub(super) const WRITER: usize = 84;
    pub(super) const WRITER_EPOCH: usize = 88;
    pub(super) const AFTER: usize = 92;
    pub(super) const UPTO: usize = 96;
    pub(super) const FLAGS: usize = 100;
    pub(super) const LENGTH: usize = 101;
    pub(super) const CHANGES: usize = 102;
}

/// `report` as a datagram; `seq` counts the frames of this sender.
#[must_use]
pub fn encode_map(swarm: u32, report: &MapReport, seq: u8) -> Vec<u8> {
    let mut payload = [0; STATE_BYTES];
    let mut word = |offset: usize, value: u32| payload[offset..offset + 4].copy_from_slice(&value.to_le_bytes());
    word(at::SWARM, swarm);
    word(at::ROBOT, report.from.robot.0);
    word(at::EPOCH, report.from.epoch);
    word(at::SEQ, report.seq);
    word(at::LATTICE, report.lattice);
    word(at::GOAL, report.goal.map_or(0, |cell| cell.saturating_add(1)));
    for (place, MapHead { writer, head }) in report.heads.iter().flatten().enumerate() {
        word(at::HEAD_ROBOT + 4 * place, writer.robot.0);
        word(at::HEAD_EPOCH + 4 * place, writer.epoch);
        word(at::HEAD + 4 * place, *head);
    }
    if let Some(chunk) = &report.chunk {
        word(at::WRITER, chunk.writer.robot.0);
        word(at::WRITER_EPOCH, chunk.writer.epoch);
        word(at::AFTER, chunk.after);
        word(at::UPTO, chunk.upto);
        let changes = &chunk.changes[..chunk.changes.len().min(CHANGES_BYTES_MAX)];
        payload[at::LENGTH] = changes.len() as u8;
        payload[at::CHANGES..at::CHANGES + changes.len()].copy_from_slice(changes);
    }
    payload[at::FLAGS] = if report.done { DONE } else { 0 };
    emitter(report.from.robot, seq).encode_raw(MAP, MAP_EXTRA_CRC, &payload)
}

pub(crate) fn read_map(raw: Raw<'_>, system: u8) -> Result<Message, DecodeError> {
    let from = Writer { robot: RobotId(raw.u32(at::ROBOT)), epoch: raw.u32(at::EPOCH) };
    if from.robot.0 == 0 {
        return Err(DecodeError::Range("robot"));
    }
    if system != system_window(from.robot) {
        return Err(DecodeError::Sender);
    }
    let report = MapReport {
        from,
        seq: raw.u32(at::SEQ),
        lattice: raw.u32(at::LATTICE),
        goal: raw.u32(at::GOAL).checked_sub(1),
        done: raw.u8(at::FLAGS) & DONE != 0,
        heads: std::array::from_fn(|place| read_head(raw, place)),
        chunk: read_chunk(raw)?,
    };
    Ok(Message::Map { swarm: raw.u32(at::SWARM), report: Box::new(report) })
}

fn read_head(raw: Raw<'_>, place: usize) -> Option<MapHead> {
    let robot = RobotId(raw.u32(at::HEAD_ROBOT + 4 * place));
    let writer = Writer { robot, epoch: raw.u32(at::HEAD_EPOCH + 4 * place) };
    (robot.0 != 0).then(|| MapHead { writer, head: raw.u32(at::HEAD + 4 * place) })
}

fn read_chunk(raw: Raw<'_>) -> Result<Option<MapChunk>, DecodeError> {
    let writer = Writer { robot: RobotId(raw.u32(at::WRITER)), epoch: raw.u32(at::WRITER_EPOCH) };
    if writer.robot.0 == 0 {
        return Ok(None);
    }
    let (after, upto) = (raw.u32(at::AFTER), raw.u32(at::UPTO));
    if upto <= after {
        return Err(DecodeError::Range("upto"));
    }
    let length = usize::from(raw.u8(at::LENGTH));
    if length > CHANGES_BYTES_MAX {
        return Err(DecodeError::Range("length"));
    }
    let changes = (at::CHANGES..at::CHANGES + length).map(|offset| raw.u8(offset)).collect();
    Ok(Some(MapChunk { writer, after, upto, changes }))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::beacon::{decode, swarm_hash};
    use crate::mavlink::golden::vectors;
    use drover_contract::HEADS_TOLD_MAX;
    use proptest::prelude::*;

    fn golden(label: &str) -> Vec<u8> {
        let file = include_str!(concat!(env!("CARGO_MANIFEST_DIR"), "/../../tests/golden/mavlink/map.txt"));
        vectors(file).remove(label).expect("known label").bytes
    }

    fn writer(robot: u32, epoch: u32) -> Writer {
        Writer { robot: RobotId(robot), epoch }
    }

    /// What `map` of the golden vectors says, as tests/golden/mavlink/make.py spells it.
    fn sample() -> MapReport {
        let mut heads = [None; HEADS_TOLD_MAX];
        heads[0] = Some(MapHead { writer: writer(70_003, 5), head: 77 });
        heads[1] = Some(MapHead { writer: writer(9, 2), head: 4_000_000_000 });
        MapReport {
            from: writer(70_003, 5),
            seq: 1234,
            lattice: 0xDEAD_BEEF,
            goal: Some(4_711),
            done: true,
            heads,
            chunk: Some(MapChunk { writer: writer(9, 2), after: 300, upto: 309, changes: vec![172, 2, 8, 79, 1] }),
        }
    }

    fn read(datagram: &[u8]) -> MapReport {
        match decode(datagram) {
            Ok(Message::Map { swarm, report }) if swarm == swarm_hash("first") => *report,
            other => panic!("no map report of the swarm: {other:?}"),
        }
    }

    #[test]
    fn our_report_is_the_bytes_that_pymavlink_makes_from_our_dialect() {
        let encoded = |report: &MapReport| encode_map(swarm_hash("first"), report, 17);
        assert_eq!(encoded(&sample()), golden("map"));
        let bare = MapReport { goal: None, done: false, chunk: None, ..sample() };
        assert_eq!(encoded(&bare), golden("map_without_a_piece"));
        assert_eq!(golden("map_full").len(), 202, "190 bytes of state, 12 around them");
        assert_eq!(encoded(&read(&golden("map_full"))), golden("map_full"));
    }

    #[test]
    fn a_report_that_pymavlink_made_reads_as_what_it_says_signed_or_not() {
        assert_eq!(read(&golden("map")), sample());
        assert_eq!(read(&golden("map_with_signature")), sample());
        assert_eq!(read(&golden("map_without_a_piece")).chunk, None);
    }

    #[test]
    fn what_makes_no_sense_is_refused_by_name() {
        let refused = |label| decode(&golden(label)).expect_err("refused");
        assert_eq!(refused("bad_map_robot"), DecodeError::Range("robot"));
        assert_eq!(refused("bad_map_sender"), DecodeError::Sender);
        assert_eq!(refused("bad_map_upto"), DecodeError::Range("upto"));
        assert_eq!(refused("bad_map_length"), DecodeError::Range("length"));
    }

    proptest! {
        #[test]
        fn any_payload_is_read_or_refused(bytes in prop::collection::vec(any::<u8>(), 1..=MAP_BYTES_MAX)) {
            let from = RobotId(u32::from_le_bytes([bytes[0], 0, 0, 0]));
            let datagram = emitter(from, 0).encode_raw(MAP, MAP_EXTRA_CRC, &bytes);
            if let Ok(Message::Map { swarm, report }) = decode(&datagram) {
                prop_assert!(decode(&encode_map(swarm, &report, 0)).is_ok());
            }
        }
    }
}
