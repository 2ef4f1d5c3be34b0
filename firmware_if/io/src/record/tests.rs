use super::*;
use crate::{ManualClock, MemoryBus, memory_link};
use drover_contract::{CanId, Stamp};
use socketcan::dump::Reader;
use std::time::Duration;

fn frame(id: CanId, data: &[u8]) -> CanFrame {
    CanFrame::new(id, data).unwrap()
}

fn clock() -> ManualClock {
    ManualClock::new(Stamp::from_micros(1_234_567))
}

/// A MAVLink 2 HEARTBEAT as pymavlink 2.4.49 writes it: `mav.heartbeat_encode(10, 3, 0, 0, 3).pack(mav)`, sequence 0,
/// system 1, component 1.
const HEARTBEAT: [u8; 21] = [
    0xFD, 0x09, 0x00, 0x00, 0x00, 0x01, 0x01, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x0A, 0x03, 0x00, 0x03, 0x03,
    0x17, 0x7A,
];

#[test]
fn a_bus_is_recorded_both_ways_as_candump_writes_it() {
    let recorder = Recorder::in_memory();
    let bus = MemoryBus::new(8);
    let time = clock();
    let mut node = recorder.can("can0", bus.node(), time.clone()).unwrap();
    let mut other = bus.node();
    node.send(&frame(CanId::Standard(0x111), &[0, 0x96, 0, 0, 0, 0, 0, 0])).unwrap();
    time.set(Stamp::from_millis(2_000));
    other.send(&frame(CanId::Extended(0x1055_962A), &[0x49])).unwrap();
    other.send(&frame(CanId::Standard(0x421), &[])).unwrap();
    while node.try_recv().unwrap().is_some() {}
    let log = String::from_utf8(recorder.contents()["can0.log"].clone()).unwrap();
    assert_eq!(
        log,
        "(0000000001.234567) can0 111#0096000000000000 T\n\
         (0000000002.000000) can0 1055962A#49 R\n\
         (0000000002.000000) can0 421# R\n"
    );
}

#[test]
fn a_recorded_bus_is_read_back_by_another_implementation_of_candumps_format() {
    let recorder = Recorder::in_memory();
    let bus = MemoryBus::new(8);
    let mut node = recorder.can("vcan1", bus.node(), clock()).unwrap();
    node.send(&frame(CanId::Standard(0x111), &[1, 2])).unwrap();
    node.send(&frame(CanId::Extended(0x111), &[3])).unwrap();
    let log = recorder.contents()["vcan1.log"].clone();
    let mut reader = Reader::from_reader(&log[..]);
    let records: Vec<_> =
        std::iter::from_fn(|| reader.next_record().unwrap().map(|record| record.to_string())).collect();
    assert_eq!(records.len(), 2);
    assert!(records[0].contains("vcan1 111#0102"), "{}", records[0]);
    assert!(records[1].contains("vcan1 00000111#03"), "{}", records[1]);
}

#[test]
fn each_mavlink_frame_of_a_datagram_has_its_own_time_in_the_tlog() {
    let recorder = Recorder::in_memory();
    let (near, mut far) = memory_link(8);
    let mut near = recorder.link("robot3", near, clock()).unwrap();
    let version_1 = [0xFE, 1, 0, 1, 1, 0, 42, 0xAA, 0xBB];
    let mut signed = vec![0xFD, 1, 1, 0, 0, 1, 1, 0, 0, 0, 42, 0xAA, 0xBB];
    signed.extend([7; 13]);
    far.send(&[&HEARTBEAT[..], &version_1, &signed].concat()).unwrap();
    near.try_recv(&mut [0; 512]).unwrap();
    let time = 1_234_567_u64.to_be_bytes();
    let expected = [&time[..], &HEARTBEAT, &time, &version_1, &time, &signed].concat();
    assert_eq!(recorder.contents()["robot3.tlog"], expected);
    assert_eq!(recorder.dropped(), 0);
}

#[test]
fn bytes_that_a_tlog_cannot_carry_are_left_out_and_counted() {
    let recorder = Recorder::in_memory();
    let (near, _far) = memory_link(8);
    let mut near = recorder.link("robot3", near, clock()).unwrap();
    near.send(b"hello").unwrap();
    near.send(&HEARTBEAT[..20]).unwrap();
    near.send(&[&HEARTBEAT[..], b"rest"].concat()).unwrap();
    near.send(&[]).unwrap();
    assert_eq!(recorder.contents()["robot3.tlog"].len(), 8 + HEARTBEAT.len());
    assert_eq!(recorder.dropped(), 3);
}

#[test]
fn what_did_not_leave_is_not_recorded() {
    let recorder = Recorder::in_memory();
    let (near, far) = memory_link(8);
    let mut near = recorder.link("robot3", near, clock()).unwrap();
    drop(far);
    assert!(near.send(&HEARTBEAT).is_err());
    assert!(recorder.contents()["robot3.tlog"].is_empty());
}

#[test]
fn files_hold_everything_once_the_last_user_of_the_recorder_is_gone() {
    let folder = tempfile::tempdir().unwrap();
    let recorder = Recorder::in_folder(folder.path(), 1_700_000_000_000_000).unwrap();
    let bus = MemoryBus::new(8);
    let mut node = recorder.can("can0", bus.node(), clock()).unwrap();
    drop(recorder);
    for n in 0..5_000_u16 {
        node.send(&frame(CanId::Standard(0x111), &n.to_be_bytes())).unwrap();
    }
    let dropped = node.recorder.dropped();
    drop(node);
    let log = std::fs::read_to_string(folder.path().join("can0.log")).unwrap();
    assert_eq!(dropped, 0);
    assert_eq!(log.lines().count(), 5_000);
    assert!(log.starts_with("(1700000001.234567) can0 111#0000 T\n"), "{}", &log[..60]);
    assert!(log.ends_with("can0 111#1387 T\n"));
}

#[test]
fn what_is_recorded_reaches_the_disk_within_seconds_even_if_nobody_ends_the_recording() {
    let folder = tempfile::tempdir().unwrap();
    let recorder = Recorder::in_folder(folder.path(), 0).unwrap();
    let mut node = recorder.can("can0", MemoryBus::new(8).node(), clock()).unwrap();
    node.send(&frame(CanId::Standard(0x111), &[1])).unwrap();
    let path = folder.path().join("can0.log");
    let written = (0..100).any(|_| {
        std::thread::sleep(Duration::from_millis(50));
        std::fs::metadata(&path).unwrap().len() > 0
    });
    assert!(written);
}

#[test]
fn a_folder_that_is_not_there_is_an_error_with_what_to_do() {
    let error = Recorder::in_folder(Path::new("/nonexistent/drover"), 0).err().unwrap();
    assert!(error.to_string().contains("record_dir"), "{error}");
}

#[test]
fn the_same_messages_at_the_same_virtual_times_give_the_same_bytes() {
    let record = || {
        let recorder = Recorder::in_memory();
        let time = clock();
        let bus = MemoryBus::new(8);
        let mut node = recorder.can("can0", bus.node(), time.clone()).unwrap();
        let (near, _far) = memory_link(8);
        let mut link = recorder.link("robot1", near, time.clone()).unwrap();
        for step in 0..50_u8 {
            time.set(Stamp::from_millis(2_000 + u64::from(step)));
            node.send(&frame(CanId::Standard(0x111), &[step])).unwrap();
            link.send(&HEARTBEAT).unwrap();
        }
        recorder.contents()
    };
    assert_eq!(record(), record());
}
