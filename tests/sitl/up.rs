//! `drover up` from start to end.

use crate::common::{assert_reached_safely, exported, json, private, signal, up, up_command};
use serde_json::Value;
use std::process::{Command, Stdio};
use std::time::Duration;

/// What a flock is measured by, of a run in which nobody is in anybody's way; a flat part of the summary, as in `sim`.
fn assert_flocked(summary: &Value) {
    let number = |name: &str| summary[name].as_f64().unwrap_or_else(|| panic!("{name} is no number: {summary:#}"));
    assert_eq!((&summary["success"], &summary["lost"]), (&Value::from(true), &Value::from(0)), "{summary:#}");
    // The leader goes on straight for the last five seconds of its way, and its flock behind it.
    assert!((0.9..=1.0).contains(&number("order")), "{summary:#}");
    assert!(number("cohesion_m") > 0.5 && number("cohesion_m") < 4.0, "{summary:#}");
    assert!(number("gathered_s") < number("time_s"), "{summary:#}");
    assert!((0.8..1.2).contains(&number("path_ratio")), "{summary:#}");
    // Nobody moves before its drive is ready; then all do.
    assert!(number("stuck_s") > 0.0 && number("stuck_s") < 15.0, "{summary:#}");
    assert!(number("gave_way_s") <= 0.0 && summary["wall_entries"].is_u64(), "{summary:#}");
}

#[test]
fn the_first_swarm_reaches_its_end_with_robots_as_tasks() {
    let folder = tempfile::tempdir().expect("a folder");
    let output = up(folder.path(), &["--duration", "60", "--seed", "1", "--json"]);
    let summary = json(&output);
    assert_reached_safely(&summary);
    assert_flocked(&summary);
    assert_eq!(summary["processes"], false);
    assert_eq!(output.status.code(), Some(0));
    let recording = std::path::Path::new(summary["recording"].as_str().expect("a file")).to_owned();
    let export = exported(&recording);
    let beside = ["swarm.toml", "summary.json", "run.mcap"].map(|name| recording.with_file_name(name));
    let links = ["robot-1.tlog", "robot-3-drive.log", "robot-3-lidar.log", "states.csv"].map(|name| export.join(name));
    for file in beside.iter().chain(&links) {
        let size = file.metadata().map(|file| file.len()).unwrap_or_default();
        assert!(size > 500, "{} holds {size} bytes", file.display());
    }
}

#[test]
fn the_first_swarm_reaches_its_end_with_every_robot_a_process() {
    let folder = tempfile::tempdir().expect("a folder");
    let output = up(folder.path(), &["--duration", "60", "--seed", "1", "--json", "--processes"]);
    let summary = json(&output);
    assert_reached_safely(&summary);
    assert_flocked(&summary);
    assert_eq!(summary["processes"], true);
    assert_eq!(output.status.code(), Some(0));
}

#[test]
fn an_interrupt_stops_every_robot_and_is_said() {
    let folder = tempfile::tempdir().expect("a folder");
    let mut command = up_command(folder.path(), &["--duration", "60", "--json"]);
    let child = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().expect("drover runs");
    std::thread::sleep(Duration::from_secs(9));
    signal("INT", child.id());
    let output = child.wait_with_output().expect("it ends");
    let summary = json(&output);
    assert_eq!(summary["ended"], "interrupted", "{summary:#}");
    assert_eq!(summary["stopped"], true, "{summary:#}");
    assert!(summary["robots"][0]["path_m"].as_f64().is_some_and(|path_m| path_m > 0.5), "{summary:#}");
    let reports = summary["robots"].as_array().expect("robots").iter().map(|robot| &robot["report"]["seen_stopped"]);
    assert!(reports.into_iter().all(|seen| *seen == true), "{summary:#}");
    assert_eq!(output.status.code(), Some(130));
}

#[test]
fn a_stop_over_the_beacon_plane_stops_every_process() {
    let folder = tempfile::tempdir().expect("a folder");
    let mut command = crate::common::drover();
    let set: Vec<String> = private(folder.path()).into_iter().flat_map(|set| ["--set".to_owned(), set]).collect();
    let first = crate::common::first_toml();
    command.arg("up").arg(&first).args(["--processes", "--duration", "18", "--json"]).args(&set);
    let child = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().expect("drover runs");
    std::thread::sleep(Duration::from_secs(9));
    let stop: &mut Command = &mut crate::common::drover();
    let stopped = stop.arg("stop").arg(&first).args(&set).output().expect("drover runs");
    assert!(stopped.status.success(), "{}", String::from_utf8_lossy(&stopped.stderr));
    let summary = json(&child.wait_with_output().expect("it ends"));
    for robot in summary["robots"].as_array().expect("robots") {
        assert_eq!(robot["state"], "stopped", "{robot:#}");
        assert!(robot["reason"].as_str().is_some_and(|reason| reason.contains("operator")), "{robot:#}");
        assert!(robot["path_m"].as_f64().is_some_and(|path_m| path_m > 0.3), "it had not moved before: {robot:#}");
    }
}
