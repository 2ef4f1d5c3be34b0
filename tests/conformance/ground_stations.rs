//! pymavlink as ground station of the virtual rover.

use crate::common::Place;
use crate::support::{Peer, alone, number};
use drover_bridge::NearSide;
use serde_json::Value;
use std::time::{Duration, Instant};

/// A rover in the shipped world, not driven yet, and its autopilot's HOST:PORT.
fn rover() -> (Place, String) {
    let folder = tempfile::tempdir().expect("a folder");
    let place = Place::open(alone(folder.path(), 1), folder);
    let NearSide::Mavlink(address) = &place.near_sides[0] else { panic!("robot 1 is a MAVLink robot") };
    let address = address.strip_prefix("udpout:").expect("the autopilot listens").to_owned();
    (place, address)
}

#[test]
fn pymavlink_arms_and_drives_the_virtual_rover_reads_its_scan_and_sees_it_stop_after_3_s_of_silence() {
    let (place, address) = rover();
    let station = Peer::start("mavlink_gcs.py", &[&address]);
    // The body itself, while the station drives it: at its asked speed of 0.5 m/s, then still.
    place.wait("the body moves", 40.0, |place| place.speed_mps(0) > 0.45);
    let fast = Instant::now();
    place.wait("the body stands again", 8.0, |place| !place.moves(0));
    let drove_s = fast.elapsed().as_secs_f64();
    let report = station.finish();
    println!("bring-up {} s, stood {} s after silence", report["bring_up_s"], report["stopped_after_silence_s"]);
    assert_eq!(report["ok"], true, "{report:#}");
    let truth = place.plant.with(|plant| plant.truth(0));
    let moved_m = number(&report, "moved_m");
    // It drives on for 3 s after what the station reports as moved.
    assert!(truth.path_m >= moved_m + 1.0 && truth.path_m <= moved_m + 2.5, "{truth:?} {report:#}");
    assert!(drove_s > 3.0, "the body stood {drove_s:.2} s after it was fast: no 3 s of silence in it");
    assert!(!place.moves(0));
    // The scan shows the true place: nothing is nearer than the nearest wall on the whole way was.
    let nearest_ever_m =
        truth.gap_wall_m_min.expect("walls") + place.swarm().kind_of(&place.swarm().robots[0]).body.radius_m;
    let nearest_m = number(&report, "scan_nearest_m");
    assert!(
        nearest_m >= nearest_ever_m - 0.1 && nearest_m <= nearest_ever_m + truth.path_m + 0.5,
        "{nearest_m} {truth:?}"
    );
    assert!(report["sectors"].as_object().is_some_and(|sectors| sectors.len() >= 4), "{report:#}");
    assert_eq!(report["unknown_command"], 3, "UNSUPPORTED");
    assert_eq!(report["50_hz_denied"], 2, "DENIED");
}

/// Messages of `kind` that a watching station counted from `component`.
fn count(report: &Value, component: u8, kind: &str) -> u64 {
    report["counts"][format!("{component}/{kind}")].as_u64().unwrap_or_default()
}

#[test]
fn two_ground_stations_watch_a_rover_that_drover_drives_and_their_end_changes_nothing() {
    const WATCH_S: &str = "5";
    let (place, address) = rover();
    let _robot = place.start(0);
    place.wait("it drives", 30.0, |place| place.speed_mps(0) > 0.3);
    let before_m = place.plant.with(|plant| plant.truth(0).path_m);
    let stations = [(); 2].map(|()| Peer::start("mavlink_gcs.py", &[&address, "--watch", WATCH_S]));
    for station in stations {
        let report = station.finish();
        assert_eq!(report["ok"], true, "{report:#}");
        // The rates of a link that nobody asked anything of: 1 Hz, whatever the robot's own link gets.
        for (component, kind) in [(1, "HEARTBEAT"), (1, "LOCAL_POSITION_NED"), (1, "SYS_STATUS"), (196, "HEARTBEAT")] {
            let seen = count(&report, component, kind);
            assert!((4..=7).contains(&seen), "{seen} of {component}/{kind}: {report:#}");
        }
        let scans = count(&report, 196, "OBSTACLE_DISTANCE");
        assert!((30..=60).contains(&scans), "{scans} scans: {report:#}");
        let path_m = number(&report, "path_m");
        assert!((1.0..4.0).contains(&path_m), "{report:#}");
    }
    let after_m = place.plant.with(|plant| plant.truth(0).path_m);
    assert!(after_m - before_m > 2.0, "it drove only {:.2} m under their eyes", after_m - before_m);
    // The stations are gone, their ports closed: what is sent to them is refused, and nobody else notices.
    std::thread::sleep(Duration::from_secs(1));
    assert!(place.speed_mps(0) > 0.3, "{} m/s", place.speed_mps(0));
}
