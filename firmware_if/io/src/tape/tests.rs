use super::*;
use crate::{MemoryBus, memory_link};
use socketcan::dump::Reader;

fn frame(id: CanId, data: &[u8]) -> CanFrame {
    CanFrame::new(id, data).unwrap()
}

fn tape() -> (Tape, Arc<MemoryTapes>) {
    let tapes = Arc::new(MemoryTapes::default());
    let tape = Tape::new(3, tapes.clone());
    tape.turn(Stamp::from_micros(1_234_567));
    (tape, tapes)
}

/// A MAVLink 2 HEARTBEAT as pymavlink 2.4.49 writes it: `mav.heartbeat_encode(10, 3, 0, 0, 3).pack(mav)`, sequence 0,
/// system 1, component 1.
const HEARTBEAT: [u8; 21] = [
    0xFD, 0x09, 0x00, 0x00, 0x00, 0x01, 0x01, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x0A, 0x03, 0x00, 0x03, 0x03,
    0x17, 0x7A,
];

#[test]
fn a_bus_is_taped_both_ways_and_written_as_candump_writes_it() {
    let (tape, tapes) = tape();
    let bus = MemoryBus::new(8);
    let mut node = tape.bus(TapePort::DriveBus, bus.node());
    let mut other = bus.node();
    node.send(&frame(CanId::Standard(0x111), &[0, 0x96, 0, 0, 0, 0, 0, 0])).unwrap();
    tape.turn(Stamp::from_millis(2_000));
    other.send(&frame(CanId::Extended(0x1055_962A), &[0x49])).unwrap();
    other.send(&frame(CanId::Standard(0x421), &[])).unwrap();
    while node.try_recv().unwrap().is_some() {}
    tape.flush();
    let log = String::from_utf8(tapes.files()["robot-3-drive.log"].clone()).unwrap();
    assert_eq!(
        log,
        "(0000000001.234567) robot-3-drive 111#0096000000000000 T\n\
         (0000000002.000000) robot-3-drive 1055962A#49 R\n\
         (0000000002.000000) robot-3-drive 421# R\n"
    );
}

#[test]
fn a_taped_bus_is_read_back_by_another_implementation_of_candumps_format() {
    let (tape, tapes) = tape();
    let mut node = tape.bus(TapePort::LidarBus, MemoryBus::new(8).node());
    node.send(&frame(CanId::Standard(0x111), &[1, 2])).unwrap();
    node.send(&frame(CanId::Extended(0x111), &[3])).unwrap();
    tape.flush();
    let log = tapes.files()["robot-3-lidar.log"].clone();
    let mut reader = Reader::from_reader(&log[..]);
    let records: Vec<_> =
        std::iter::from_fn(|| reader.next_record().unwrap().map(|record| record.to_string())).collect();
    assert_eq!(records.len(), 2);
    assert!(records[0].contains("robot-3-lidar 111#0102"), "{}", records[0]);
    assert!(records[1].contains("robot-3-lidar 00000111#03"), "{}", records[1]);
}

#[test]
fn each_mavlink_frame_of_a_datagram_has_its_own_time_in_the_tlog() {
    let (tape, tapes) = tape();
    let (near, mut far) = memory_link(8);
    let mut near = tape.link(TapePort::Autopilot, near);
    let version_1 = [0xFE, 1, 0, 1, 1, 0, 42, 0xAA, 0xBB];
    let mut signed = vec![0xFD, 1, 1, 0, 0, 1, 1, 0, 0, 0, 42, 0xAA, 0xBB];
    signed.extend([7; 13]);
    far.send(&[&HEARTBEAT[..], &version_1, &signed].concat()).unwrap();
    near.try_recv(&mut [0; 512]).unwrap();
    tape.flush();
    let time = 1_234_567_u64.to_be_bytes();
    let expected = [&time[..], &HEARTBEAT, &time, &version_1, &time, &signed].concat();
    assert_eq!(tapes.files()["robot-3.tlog"], expected);
}

#[test]
fn bytes_that_a_tlog_cannot_carry_are_left_out_and_counted() {
    let mut files = WireFiles::new(0);
    for bytes in [&b"hello"[..], &HEARTBEAT[..20], &[&HEARTBEAT[..], b"rest"].concat(), &[]] {
        let event = TapeEvent::Sent(TapePort::Autopilot, bytes.to_vec());
        files.add(3, &TapeEntry { stamp: Stamp::ZERO, event });
    }
    assert_eq!(files.left_out(), 3);
    assert_eq!(files.into_files()["robot-3.tlog"].len(), 8 + HEARTBEAT.len());
}

#[test]
fn what_did_not_leave_is_not_taped() {
    let (tape, tapes) = tape();
    let (near, far) = memory_link(8);
    let mut near = tape.link(TapePort::Autopilot, near);
    drop(far);
    assert!(near.send(&HEARTBEAT).is_err());
    tape.flush();
    assert!(tapes.files().is_empty());
}

#[test]
fn entries_are_handed_on_in_order_and_none_is_held_for_long() {
    let (tape, tapes) = tape();
    let mut node = tape.bus(TapePort::DriveBus, MemoryBus::new(8).node());
    for n in 0..50_u16 {
        tape.turn(Stamp::from_millis(2_000 + u64::from(n) * 10));
        node.send(&frame(CanId::Standard(0x111), &n.to_be_bytes())).unwrap();
    }
    let written = |tapes: &MemoryTapes| String::from_utf8(tapes.files()["robot-3-drive.log"].clone()).unwrap();
    assert!(written(&tapes).lines().count() >= 50 - 21, "more than 200 ms are held back");
    drop((node, tape));
    let all = written(&tapes);
    assert_eq!(all.lines().count(), 50);
    assert!(all.ends_with("111#0031 T\n"), "{all}");
}

#[test]
fn frames_survive_their_bytes() {
    for frame in [
        frame(CanId::Standard(0x7FF), &[1, 2, 3]),
        frame(CanId::Extended(0x1FFF_FFFF), &[]),
        frame(CanId::Extended(5), &[9; 8]),
    ] {
        assert_eq!(frame_of(&frame_bytes(&frame)), Some(frame));
    }
    for garbage in [&[][..], &[1, 2, 3], &[0, 0x10, 0, 0], &[1, 0, 0, 0, 1, 2, 3, 4, 5, 6, 7, 8, 9]] {
        assert_eq!(frame_of(garbage), None, "{garbage:?}");
    }
}
