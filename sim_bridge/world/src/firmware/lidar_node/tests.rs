//! The virtual lidar node against pydronecan's bytes, and read by the robot's own host, in virtual time.

use super::{DronecanSimParams, NodeHealth, VirtualDronecanLidar};
use drover_codec::can::dronecan::{DronecanLidarHost, DronecanLidarParams, Reassembler};
use drover_contract::{Beam, CanFrame, CanId, CanNode, Event, Scan, Stamp};
use std::f64::consts::TAU;

const RANGE_M_MAX: f64 = 12.1; // not a half float: it becomes 12.1015625 on the wire

fn ms(ms: u64) -> Stamp {
    Stamp::from_millis(ms)
}

fn lidar(sectors: u32, silent_is_clear: bool) -> VirtualDronecanLidar {
    let node = CanNode(42);
    VirtualDronecanLidar::new(DronecanSimParams { node, sensor_id: 7, sectors, rate_hz: 10.0, silent_is_clear }, 1)
}

fn scan_of(beams: Vec<Beam>) -> Scan {
    Scan {
        stamp: ms(0),
        angle_first_rad: 0.0,
        angle_step_rad: TAU / beams.len() as f64,
        range_m_min: 0.1,
        range_m_max: RANGE_M_MAX,
        beams,
    }
}

fn frames(lidar: &mut VirtualDronecanLidar) -> Vec<CanFrame> {
    std::iter::from_fn(|| lidar.poll_output()).collect()
}

#[test]
fn it_sends_the_bytes_that_pydronecan_sends() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../tests/golden/can/dronecan.json");
    let document: serde_json::Value = serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap();
    let distances = document["lidar"]["distances_m"].as_array().unwrap();
    let beam = |distance: &serde_json::Value| distance.as_f64().map_or(Beam::Unknown, Beam::Hit);
    let mut lidar = lidar(36, false);
    lidar.step(ms(0), Some(&scan_of(distances.iter().map(beam).collect())));
    (1..=50).for_each(|at_ms| lidar.step(ms(at_ms), None));
    let sent: Vec<String> = frames(&mut lidar).iter().map(CanFrame::to_string).collect();
    let golden = document["lidar"]["frames"].as_array().unwrap();
    assert_eq!(sent, golden.iter().map(|frame| frame.as_str().unwrap()).collect::<Vec<_>>());
}

#[test]
fn a_scan_is_spread_over_half_its_period() {
    let mut lidar = lidar(36, false);
    lidar.step(ms(0), Some(&scan_of(vec![Beam::Clear; 360])));
    _ = frames(&mut lidar);
    let counts: Vec<usize> = (1..=50).map(|at_ms| (lidar.step(ms(at_ms), None), frames(&mut lidar).len()).1).collect();
    assert_eq!(counts.iter().sum::<usize>(), 35 * 2);
    assert!(counts.iter().all(|count| *count <= 2), "{counts:?}");
}

#[test]
fn a_new_scan_finds_nothing_left_of_the_last() {
    let mut lidar = lidar(36, false);
    for at_ms in [0, 10] {
        lidar.step(ms(at_ms), Some(&scan_of(vec![Beam::Clear; 36])));
    }
    lidar.step(ms(100), None);
    assert_eq!(frames(&mut lidar).len(), 1 + 2 * 36 * 2);
}

#[test]
fn node_status_comes_once_a_second_whether_or_not_it_sees() {
    let mut lidar = lidar(36, true);
    (0..5_000).step_by(10).for_each(|at_ms| lidar.step(ms(at_ms), Some(&scan_of(vec![Beam::Clear; 36]))));
    let sent = frames(&mut lidar);
    assert_eq!(sent.len(), 5);
    assert!(sent.iter().all(|frame| frame.id() == CanId::Extended(0x1401_552A)));
}

#[test]
fn it_says_who_it_is_when_asked_and_only_then() {
    let mut lidar = lidar(36, false);
    lidar.step(ms(0), None);
    _ = frames(&mut lidar);
    let request = |raw, tail| CanFrame::new(CanId::Extended(raw), &[tail]).unwrap();
    lidar.handle_frame(ms(1), &request(0x1E01_AB8A, 0xC2)); // to node 43
    lidar.handle_frame(ms(1), &request(0x1E01_2A8A, 0xC2)); // an answer, not a request
    assert_eq!(frames(&mut lidar), []);
    lidar.handle_frame(ms(1), &request(0x1E01_AA8A, 0xC2)); // pydronecan's request from 10 to 42, transfer 2
    let mut reassembler = Reassembler::new(1);
    let mut answers = frames(&mut lidar).into_iter().filter_map(|frame| {
        assert_eq!(frame.id(), CanId::Extended(0x1E01_0AAA));
        reassembler.accept(ms(1), &frame, |_| Some(0xEE46_8A81_21C4_6A9E))
    });
    let answer = answers.next().unwrap();
    assert_eq!(answer.transfer_id, 2);
    assert!(answer.payload.ends_with(b"drover.sim.lidar"));
}

/// A host and a lidar on one wire, for a second and a half at ten scans a second.
fn seen(scan: &Scan, sectors: u32, silent_is_clear: bool) -> Vec<Scan> {
    let mut host = DronecanLidarHost::new(host_params(sectors, silent_is_clear), ms(0));
    let mut lidar = lidar(sectors, silent_is_clear);
    let mut scans = vec![];
    for at_ms in (0..1_500).step_by(5) {
        lidar.step(ms(at_ms), Some(scan).filter(|_| at_ms % 100 == 0));
        scans.extend(exchange(&mut host, &mut lidar, at_ms));
    }
    scans
}

fn host_params(sectors: u32, silent_is_clear: bool) -> DronecanLidarParams {
    DronecanLidarParams {
        node: CanNode(42),
        own_node: CanNode(10),
        beams: sectors,
        range_m_min: 0.1,
        range_m_max: RANGE_M_MAX,
        rate_hz: 10.0,
        silent_is_clear,
    }
}

fn exchange(host: &mut DronecanLidarHost, lidar: &mut VirtualDronecanLidar, at_ms: u64) -> Vec<Scan> {
    for frame in frames(lidar) {
        host.handle_frame(ms(at_ms), &frame);
    }
    host.handle_timeout(ms(at_ms));
    while let Some(frame) = host.poll_output() {
        lidar.handle_frame(ms(at_ms), &frame);
    }
    let scan = |event| if let Event::Scan(scan) = event { Some(scan) } else { None };
    std::iter::from_fn(|| host.poll_event()).filter_map(scan).collect()
}

/// Every kind of beam in its place, three beams a sector.
fn mixed() -> Scan {
    let mut beams = vec![Beam::Clear; 108];
    beams[0] = Beam::Hit(2.5); // ahead
    beams[26..29].copy_from_slice(&[Beam::Hit(4.0), Beam::Hit(3.0), Beam::Unknown]); // to the left
    beams[53..56].fill(Beam::Unknown); // behind
    scan_of(beams)
}

#[test]
fn a_host_sees_what_the_world_cast_whether_or_not_silence_is_clear() {
    for silent_is_clear in [false, true] {
        let scans = seen(&mixed(), 36, silent_is_clear);
        assert!((14..=16).contains(&scans.len()), "{} scans in 1.5 s", scans.len());
        let last = &scans[scans.len() - 2];
        assert_eq!((last.beams.len(), last.angle_rad(9)), (36, TAU / 4.0));
        assert_eq!([last.beams[0], last.beams[9], last.beams[18]], [Beam::Hit(2.5), Beam::Hit(3.0), Beam::Unknown]);
        let clear = last.beams.iter().filter(|beam| **beam == Beam::Clear).count();
        assert_eq!(clear, 33, "silent_is_clear = {silent_is_clear}");
    }
}

#[test]
fn an_empty_place_is_seen_as_clear_although_nothing_is_said() {
    let scans = seen(&scan_of(vec![Beam::Clear; 36]), 36, true);
    assert!(scans.len() >= 14);
    assert!(scans.iter().all(|scan| scan.beams.iter().all(|beam| *beam == Beam::Clear)));
}

#[test]
fn a_critical_node_gives_no_more_scans() {
    let mut host = DronecanLidarHost::new(host_params(36, true), ms(0));
    let mut lidar = lidar(36, true);
    lidar.set_health(NodeHealth::Critical);
    for at_ms in (0..2_000).step_by(10) {
        lidar.step(ms(at_ms), Some(&mixed()).filter(|_| at_ms % 100 == 0));
        assert_eq!(exchange(&mut host, &mut lidar, at_ms), []);
    }
}
