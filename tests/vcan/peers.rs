//! CAN peers that others wrote: python-can and pydronecan on this kernel's interfaces.

use crate::scout::Scout;
use crate::support::{Peer, number};
use drover_codec::can::dronecan::{DronecanLidarHost, DronecanLidarParams};
use drover_contract::{Beam, CanBus, CanNode, Clock, Event, Scan};
use drover_io::{OsClock, SocketCanBus, VcanInterface};
use std::time::{Duration, Instant};

const LIDAR_NODE: u8 = 42;
const RANGE_M_MAX: f64 = 12.0;

#[test]
fn python_can_enables_and_drives_the_virtual_chassis_and_sees_it_stop_500_ms_after_silence() {
    let scout = Scout::open();
    let brake = scout.kind().motion.brake_mps2.to_string();
    let host = Peer::start("can_agilex_host.py", &[&scout.drive, "--brake", &brake]);
    scout.place.wait("the body moves as it is told", 20.0, |place| place.speed_mps(0) > 0.2);
    let moving = Instant::now();
    scout.place.wait("the body stands", 5.0, |place| !place.moves(0));
    let report = host.finish();
    println!("fell {} s, stood {} s after the last command", report["fell_after_s"], report["stood_after_s"]);
    assert_eq!(report["problems"].as_array().map(Vec::len), Some(0), "{report:#}");
    // The body moved for the 1.5 s of driving and for the watchdog's 0.5 s, less the start and the last bit.
    let moved_s = moving.elapsed().as_secs_f64();
    assert!(moved_s > 1.5, "{moved_s:.2} s: {report:#}");
    assert!(number(&report, "fell_after_s") >= 0.45 && number(&report, "stood_after_s") <= 1.0, "{report:#}");
    assert!(!scout.place.moves(0));
    let path_m = scout.place.plant.with(|plant| plant.truth(0).path_m);
    assert!((0.3..0.7).contains(&path_m), "0.25 m/s for 2 s: {path_m} m");
}

/// The first scan with at least `known` readings that our own decoder makes of what it hears there within 20 s. On a
/// slow machine a sender's round now and then takes longer than its period, and is then told as two halves.
fn our_scan(interface: &str, known: usize) -> Scan {
    let clock = OsClock::new();
    let params = DronecanLidarParams {
        node: CanNode(LIDAR_NODE),
        own_node: CanNode(11),
        beams: 36,
        range_m_min: 0.2,
        range_m_max: RANGE_M_MAX,
        rate_hz: 10.0,
        silent_is_clear: false,
    };
    let mut host = DronecanLidarHost::new(params, clock.now());
    let mut bus = SocketCanBus::open(interface).unwrap_or_else(|error| panic!("{error}"));
    let limit = Instant::now() + Duration::from_secs(20);
    let mut most = 0;
    while Instant::now() < limit {
        host.handle_timeout(clock.now());
        while let Ok(Some(frame)) = bus.try_recv() {
            host.handle_frame(clock.now(), &frame);
        }
        while let Some(frame) = host.poll_output() {
            bus.send(&frame).unwrap_or_else(|error| panic!("{error}"));
        }
        while let Some(event) = host.poll_event() {
            if let Event::Scan(scan) = event {
                let count = scan.beams.iter().filter(|beam| **beam != Beam::Unknown).count();
                if count >= known {
                    return scan;
                }
                most = most.max(count);
            }
        }
        std::thread::sleep(Duration::from_millis(2));
    }
    panic!("at most {most} readings in a scan on {interface} within 20 s; counters {:?}", host.counters());
}

/// The direction in which beam `index` looks, whole degrees clockwise from ahead, -179..=180.
fn clockwise_deg(scan: &Scan, index: usize) -> i64 {
    let degrees = (-scan.angle_rad(index).to_degrees().round() as i64).rem_euclid(360);
    if degrees > 180 { degrees - 360 } else { degrees }
}

#[test]
fn pydronecan_reads_the_virtual_lidar_as_our_decoder_does() {
    let scout = Scout::open();
    let listener = Peer::start("can_dronecan_listener.py", &[&scout.lidar, "--node", "42", "--seconds", "3"]);
    let scan = our_scan(&scout.lidar, 33);
    let report = listener.finish();
    println!("{} readings, {} NodeStatus", report["proximity_count"], report["node_status"]);
    assert_eq!(report["problems"].as_array().map(Vec::len), Some(0), "{report:#}");
    let readings = report["proximity"].as_array().expect("readings");
    let mut alike = 0;
    for (index, beam) in scan.beams.iter().enumerate() {
        let degrees = clockwise_deg(&scan, index);
        let same = |reading: &&serde_json::Value| {
            let yaw = reading[0].as_f64().unwrap_or(f64::NAN).round() as i64;
            (yaw - degrees).rem_euclid(360) == 0
        };
        let theirs = readings.iter().find(same).unwrap_or_else(|| panic!("nothing at {degrees} degrees: {report:#}"));
        let theirs_m = theirs[1].as_f64().unwrap_or(f64::NAN);
        alike += usize::from(match beam {
            // Another round of the same place: noise of 1 cm, half floats, now and then a reading that dropped out.
            Beam::Hit(range_m) => (range_m - theirs_m).abs() < 0.1,
            Beam::Clear => (theirs_m - RANGE_M_MAX).abs() < 0.01,
            Beam::Unknown => false,
        });
    }
    assert!(alike >= 32, "{alike} of 36 directions alike: {scan:?} {report:#}");
    assert!(scan.nearest_m().is_some(), "there are walls: {scan:?}");
}

#[test]
fn our_decoder_reads_pydronecans_lidar() {
    let interface = VcanInterface::create("pylidar").unwrap_or_else(|error| panic!("{error}"));
    let lidar = Peer::start("can_dronecan_lidar.py", &[interface.name(), "--node", "42", "--seconds", "8"]);
    let scan = our_scan(interface.name(), 35);
    assert_eq!(scan.beams.len(), 36);
    for (index, beam) in scan.beams.iter().enumerate() {
        let counter_clockwise_deg = (-clockwise_deg(&scan, index)).rem_euclid(360);
        assert_eq!(counter_clockwise_deg % 10, 0, "{scan:?}");
        match (counter_clockwise_deg / 10, beam) {
            (9, Beam::Unknown) | (18, Beam::Clear) => {}
            (9 | 18, wrong) => panic!("{counter_clockwise_deg} degrees: {wrong:?}"),
            (sector, Beam::Hit(range_m)) => {
                assert!((range_m - (1.0 + sector as f64 / 10.0)).abs() < 0.003, "sector {sector}: {range_m} m");
            }
            (sector, Beam::Clear | Beam::Unknown) => panic!("sector {sector}: {beam:?}"),
        }
    }
    let report = lidar.finish();
    assert_eq!(report["other_nodes"], serde_json::json!([11]), "it saw us: {report:#}");
}
