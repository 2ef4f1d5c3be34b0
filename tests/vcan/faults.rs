//! A CAN robot's process dies, its interfaces go and come: measured at the body (docs/safety.md).

use crate::common::{Place, drover};
use crate::scout::{Scout, lives, set_link};
use crate::support::{Driven, alone, faster_than, file_with_links};
use drover_config::Links;

/// The chassis' own command watchdog, s.
const WATCHDOG_S: f64 = 0.5;
/// A step of the world, a look of ours, a machine with one processor.
const SLACK_S: f64 = 0.2;

#[test]
fn a_killed_process_leaves_the_body_to_the_chassis_watchdog() {
    let (scout, mut robot) = Scout::driving();
    let bound_s = WATCHDOG_S + scout.braking_s() + SLACK_S;
    robot.running.kill();
    let took_s = scout.place.last_motion_s(0, 3.0);
    println!("stood {took_s:.2} s after SIGKILL, bound {bound_s:.2} s");
    assert!(took_s > 0.3 && took_s <= bound_s, "moved for {took_s:.2} s, bound {bound_s:.2} s");
    // A process anew drives it on: nothing of the old one is left over.
    let again = Driven::start(&scout.place.robot_file(0));
    again.wait_view("it drives again", 15.0, faster_than(0.3));
}

/// Take `interface` down while the robot drives: its body must stand within the bound, and drive on after it is up.
fn survives_loss_of(scout: &Scout, robot: &Driven, interface: &str, bound_s: f64) {
    set_link(interface, "down");
    let took_s = scout.place.last_motion_s(0, bound_s + 1.5);
    println!("{interface} down: stood after {took_s:.2} s, bound {bound_s:.2} s");
    assert!(took_s <= bound_s, "{interface} down: moved for {took_s:.2} s, bound {bound_s:.2} s");
    assert!(lives(robot), "{}", robot.errors());
    let view = robot.view().expect("a view");
    let said = view["links"]["last_error"].as_str().unwrap_or_default().to_owned();
    assert!(said.contains(&format!("ip link set {interface} up")), "{view:#}");
    set_link(interface, "up");
    scout.place.wait("it drives again", 15.0, |place| place.speed_mps(0) > 0.3);
    assert!(lives(robot), "{}", robot.errors());
}

#[test]
fn an_interface_that_goes_down_stops_the_robot_and_it_drives_on_when_it_is_up_again() {
    let (scout, robot) = Scout::driving();
    let timeouts = scout.kind().timeouts;
    survives_loss_of(&scout, &robot, &scout.drive, WATCHDOG_S + scout.braking_s() + SLACK_S);
    robot.wait_view("it drives as before", 10.0, faster_than(0.4));
    let reaction_s = f64::from(timeouts.scan_ms + timeouts.tick_ms) * 1e-3 + 0.1;
    survives_loss_of(&scout, &robot, &scout.lidar, reaction_s + scout.braking_s() + SLACK_S);
    assert!(!scout.touched());
    assert_eq!(robot.terminate(), Some(130));
    assert!(!scout.place.moves(0));
}

#[test]
fn an_interface_that_is_not_there_is_named_with_what_to_do_and_nothing_starts() {
    let folder = tempfile::tempdir().expect("a folder");
    let swarm = alone(folder.path(), 3);
    let links = Links::Can { drive: "can77".into(), lidar: "can78".into() };
    let file = file_with_links(&swarm, links, folder.path());
    let output = drover().arg("run").arg(&file).output().expect("drover runs");
    let said = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(3), "{said}");
    assert!(said.contains("can77") && said.contains("ip "), "{said}");
    assert!(!said.contains("panicked"), "{said}");
}

#[test]
fn an_interface_that_is_down_at_the_start_is_said_and_the_robot_waits_for_it() {
    let scout = Scout::open();
    let still = |place: &Place| !place.moves(0);
    set_link(&scout.drive, "down");
    let robot = Driven::start(&scout.place.robot_file(0));
    let wanted = format!("ip link set {} up", scout.drive);
    let says = |view: &serde_json::Value| view["links"]["last_error"].as_str().is_some_and(|it| it.contains(&wanted));
    let view = robot.wait_view("it says what to do", 10.0, says);
    assert_ne!(view["state"], "driving", "{view:#}");
    assert!(still(&scout.place) && lives(&robot), "{}", robot.errors());
    set_link(&scout.drive, "up");
    robot.wait_view("it drives", 20.0, faster_than(0.3));
}
