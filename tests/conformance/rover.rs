//! `drover run` drives a rover that pymavlink makes.

use crate::support::{Driven, Peer, alone, faster_than, file_with_links, number};
use drover_config::{Links, Swarm};
use serde_json::{Value, json};
use std::time::Duration;
use tempfile::TempDir;

const HOLD: [f64; 3] = [176.0, 1.0, 4.0];
const GUIDED: [f64; 3] = [176.0, 1.0, 15.0];
const ARM: [f64; 3] = [400.0, 1.0, 0.0];
const DISARM: [f64; 3] = [400.0, 0.0, 0.0];

/// The leader's process under way on a rover made by pymavlink.
fn under_way(more: &[&str]) -> (Swarm, TempDir, Peer, Driven) {
    let folder = tempfile::tempdir().expect("a folder");
    let swarm = alone(folder.path(), 1);
    let start = swarm.robots[0].start;
    let (x, y, yaw) = (start.x_m.to_string(), start.y_m.to_string(), start.yaw_rad.to_string());
    let mut arguments = vec!["--port", "0", "--system", "1", "--x", &x, "--y", &y, "--yaw", &yaw];
    arguments.extend(more);
    let mut rover = Peer::start("mavlink_rover.py", &arguments);
    let port = rover.line()["listening"].as_u64().expect("a port");
    let links = Links::Mavlink { autopilot: format!("udpout:127.0.0.1:{port}") };
    let robot = Driven::start(&file_with_links(&swarm, links, folder.path()));
    robot.wait_view("it drives", 30.0, faster_than(0.4));
    (swarm, folder, rover, robot)
}

/// Commands of the report, in order: number and first two parameters.
fn commands(report: &Value) -> Vec<[f64; 3]> {
    serde_json::from_value(report["commands"].clone()).expect("commands")
}

/// Places in `commands` where `wanted` is.
fn places(commands: &[[f64; 3]], wanted: [f64; 3]) -> Vec<usize> {
    let same = |one: &[f64; 3]| one.iter().zip(wanted).all(|(one, wanted)| (one - wanted).abs() < 1e-6);
    commands.iter().enumerate().filter(|(_, command)| same(command)).map(|(place, _)| place).collect()
}

/// What must hold of everything that was sent, however the run ended.
fn assert_well_spoken(report: &Value) {
    assert_eq!(report["sources"], json!([[1, 191]]), "one speaker, an onboard computer: {report:#}");
    assert_eq!(report["setpoint_kinds"], json!([[8, 1479]]), "speed and turn rate in the body's frame: {report:#}");
    assert_eq!(report["bad_setpoints"], 0, "{report:#}");
    assert_eq!(report["bad_frames"], 0, "{report:#}");
    assert_eq!(report["sequence_gaps"], 0, "{report:#}");
    assert!(number(report, "heartbeats") >= 0.6 * number(report, "ended_s") - 2.0, "{report:#}");
    assert!(number(report, "asked_mps_max") > 0.4 && number(report, "speed_mps_max") > 0.4, "{report:#}");
    let commands = commands(report);
    let first = |wanted| places(&commands, wanted).first().copied();
    let (hold, arm, guided) = (first(HOLD), first(ARM), first(GUIDED));
    assert!(hold.is_some() && hold < arm && arm < guided, "HOLD, then arm, then GUIDED: {commands:?}");
}

/// The drive was let go of: after the last GUIDED came HOLD and a disarming, and it stood by then.
fn assert_let_go(report: &Value) {
    let commands = commands(report);
    let last = |wanted| places(&commands, wanted).last().copied();
    assert!(last(HOLD) > last(GUIDED) && last(DISARM) > last(GUIDED), "{commands:?}");
    assert_eq!(report["armed"], false, "{report:#}");
    assert_eq!(report["mode"], 4, "HOLD: {report:#}");
    assert!(number(report, "standing_setpoints") >= 5.0, "{report:#}");
    assert!(number(report, "speed_mps_at_disarm").abs() < 0.05, "{report:#}");
    assert!(number(report, "disarmed_s") > number(report, "last_moving_setpoint_s"), "{report:#}");
}

#[test]
fn drover_brings_a_pymavlink_rover_up_drives_it_and_lets_go_of_it_standing() {
    let (_swarm, _folder, rover, robot) = under_way(&[]);
    std::thread::sleep(Duration::from_secs(2));
    assert_eq!(robot.terminate(), Some(130));
    let report = rover.end();
    println!(
        "armed after {} s, last moving setpoint {} s, disarmed {} s",
        report["first_armed_s"], report["last_moving_setpoint_s"], report["disarmed_s"]
    );
    assert_well_spoken(&report);
    assert_let_go(&report);
    assert!(number(&report, "path_m") > 1.0, "{report:#}");
    // It was never left without a setpoint for long while it was driven: far from the autopilot's 3 s.
    assert!(number(&report, "setpoint_gap_s_max") < 1.0, "{report:#}");
}

#[test]
fn a_pymavlink_rover_whose_lidar_falls_silent_is_asked_to_stand_within_the_scans_age_and_braking() {
    let (swarm, _folder, rover, robot) = under_way(&["--stop-scan-after", "8"]);
    robot.wait_view("the scan is old", 15.0, |view| view["scan_age_ms"].as_u64().is_none_or(|age_ms| age_ms > 1_500));
    let view = robot.wait_view("it stands", 5.0, |view| view["speed_mps"].as_f64().is_some_and(|mps| mps.abs() < 0.02));
    assert!(view["reason"].as_str().is_some_and(|reason| reason.contains("scan")), "{view:#}");
    std::thread::sleep(Duration::from_secs(1));
    assert_eq!(robot.terminate(), Some(130));
    let report = rover.end();
    let kind = swarm.kind_of(&swarm.robots[0]);
    // The scan's greatest age, a tick and the way to the wire, the braking that the robot plans, and a noisy machine.
    let reaction_s = f64::from(kind.timeouts.tick_ms) * 1e-3 + 0.1;
    let braking_s = number(&report, "asked_mps_max") / kind.motion.brake_mps2;
    let bound_s = f64::from(kind.timeouts.scan_ms) * 1e-3 + reaction_s + braking_s + 0.2;
    let took_s = number(&report, "last_moving_setpoint_s") - number(&report, "last_scan_s");
    println!("asked to stand {took_s:.2} s after the last scan, bound {bound_s:.2} s");
    assert!(took_s <= bound_s, "{took_s:.2} s, bound {bound_s:.2} s: {report:#}");
    assert_well_spoken(&report);
    assert_let_go(&report);
    assert!(number(&report, "standing_setpoints") >= 20.0, "it went on saying so: {report:#}");
}
