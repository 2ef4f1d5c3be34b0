//! Processes that die or hang, mid-run, measured at the body (docs/safety.md).

use crate::common::{Place, Running, first_swarm, signal};
use drover_config::{Drive, Kind};
use std::process::Stdio;
use std::time::Duration;

/// A rover, the leader, drives alone: it needs nobody.
const LEADER: usize = 0;

fn drive_s(kind: &Kind) -> f64 {
    let watchdog_s = match kind.drive {
        Drive::Mavlink { .. } => 3.0,
        Drive::AgilexV2 { .. } => 0.5,
    };
    // One world step and one look of ours on top: 10 ms each, and a noisy machine.
    watchdog_s + 0.2 + kind.motion.speed_mps_max / kind.motion.brake_mps2
}

/// The shipped swarm's robots started as processes, all under way.
fn under_way(ids: &[usize]) -> (Place, Vec<Running>) {
    let folder = tempfile::tempdir().expect("a folder");
    let place = Place::open(first_swarm(folder.path(), &[]), folder);
    let running = ids.iter().map(|index| place.start(*index)).collect();
    for index in ids {
        place.wait("a robot drives", 30.0, |place| place.speed_mps(*index) > 0.3);
    }
    (place, running)
}

#[test]
fn a_killed_process_leaves_the_body_to_the_drives_watchdog() {
    let (place, mut running) = under_way(&[0, 1, 2]);
    // A follower on MAVLink, one on CAN, and at last the leader.
    for index in [1, 2, 0] {
        let kind = place.swarm().kind_of(&place.swarm().robots[index]).clone();
        place.wait("it drives", 10.0, |place| place.moves(index));
        running[index].kill();
        let (took_s, bound_s) = (place.last_motion_s(index, drive_s(&kind) + 2.0), drive_s(&kind));
        println!("robot {}: stood {took_s:.2} s after SIGKILL, bound {bound_s:.2} s", index + 1);
        assert!(took_s <= bound_s, "robot {} moved for {took_s:.2} s, bound {bound_s:.2} s", index + 1);
    }
}

#[test]
fn a_process_that_hangs_is_no_worse_than_a_killed_one() {
    let (place, running) = under_way(&[LEADER]);
    let kind = place.swarm().kind_of(&place.swarm().robots[LEADER]).clone();
    signal("STOP", running[0].id());
    let (took_s, bound_s) = (place.last_motion_s(LEADER, drive_s(&kind) + 2.0), drive_s(&kind));
    assert!(took_s <= bound_s, "moved for {took_s:.2} s, bound {bound_s:.2} s");
    // Awake again, it must not send what it had in mind: its first tick is late, and late ticks stop.
    signal("CONT", running[0].id());
    place.wait("it drives on by itself", 15.0, |place| place.speed_mps(LEADER) > 0.3);
}

#[test]
fn a_terminated_process_stops_its_robot_and_lets_go_of_the_drive() {
    let (place, mut running) = under_way(&[LEADER]);
    signal("TERM", running[0].id());
    let ended = running.remove(0).wait();
    assert!(!place.moves(LEADER), "the process ended while its robot was moving");
    assert_eq!(ended.code(), Some(130));
}

#[test]
fn a_reader_that_sleeps_does_not_hold_the_robot_up() {
    let folder = tempfile::tempdir().expect("a folder");
    let place = Place::open(first_swarm(folder.path(), &[]), folder);
    let file = place.robot_file(LEADER);
    // Nobody ever reads this pipe: views fill it within some 12 s.
    let mut command = crate::common::drover();
    command.arg("run").arg(file).arg("--json").stdin(Stdio::null()).stdout(Stdio::piped());
    let _running = Running::start(&mut command);
    place.wait("it drives", 30.0, |place| place.speed_mps(LEADER) > 0.3);
    std::thread::sleep(Duration::from_secs(18));
    assert!(place.speed_mps(LEADER) > 0.3, "the robot stands: its loop waits for a reader");
}
