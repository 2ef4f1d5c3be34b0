//! Beacons are MAVLink of our own dialect: pymavlink reads them out of the air.

use crate::common::{Place, drover};
use crate::support::{Peer, alone, number};
use std::time::Duration;

#[test]
fn pymavlink_makes_the_same_beacons_out_of_the_dialect_file() {
    let report = Peer::start("mavlink_beacon.py", &[]).finish();
    assert_eq!(report["golden_is_what_pymavlink_makes"], true, "{report:#}");
}

#[test]
fn pymavlink_hears_a_running_robots_beacons_and_an_operators_stop() {
    let folder = tempfile::tempdir().expect("a folder");
    let place = Place::open(alone(folder.path(), 1), folder);
    let file = place.robot_file(0);
    let plane = &place.swarm().beacon;
    let address = format!("{}:{}", plane.group, plane.port);
    let _robot = place.start(0);
    place.wait("it drives", 30.0, |place| place.speed_mps(0) > 0.3);
    let listener =
        Peer::start("mavlink_beacon.py", &["--listen", &address, "--interface", &plane.interface, "--seconds", "4"]);
    // Python takes a moment until it listens; the stop comes in the middle, and beacons go on after it.
    std::thread::sleep(Duration::from_millis(3500));
    let stopped = drover().arg("stop").arg(&file).output().expect("drover runs");
    assert!(stopped.status.success(), "{}", String::from_utf8_lossy(&stopped.stderr));
    let report = listener.finish();
    assert_eq!(report["bad"], 0, "{report:#}");
    assert!(number(&report, "stops") >= 1.0, "{report:#}");
    let heard = &report["robots"]["1"];
    assert!((25.0..=50.0).contains(&number(heard, "beacons")), "10 a second for 4 s: {report:#}");
    assert!(number(heard, "bytes") <= 160.0, "a beacon with a signature at most: {report:#}");
    assert_eq!(heard["leader"], 1, "it leads: {report:#}");
    place.wait("it stands", 5.0, |place| !place.moves(0));
    let true_w = place.plant.with(|plant| plant.truth(0).pose_wb.position());
    let off_m = (number(heard, "x") - true_w.x).hypot(number(heard, "y") - true_w.y);
    assert!(off_m < 1.0, "the beacon says another place, {off_m:.2} m off: {report:#} {true_w:?}");
}
