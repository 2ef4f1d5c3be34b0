//! Recordings are MCAP files: the MCAP project's own reader reads them, every message by nothing but its schema.

use crate::common::{drover, json, private, top, up};
use crate::support::{Peer, number};
use serde_json::Value;
use std::path::{Path, PathBuf};

/// The only recording somewhere under `folder`.
pub(crate) fn one_recording(folder: &Path) -> PathBuf {
    let mut folders = vec![folder.to_owned()];
    let mut found = Vec::new();
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(&folder).expect("a folder") {
            let path = entry.expect("an entry").path();
            if path.is_dir() {
                folders.push(path);
            } else if path.file_name().is_some_and(|name| name == "run.mcap") {
                found.push(path);
            }
        }
    }
    assert_eq!(found.len(), 1, "{found:?}");
    found.remove(0)
}

fn read(path: &Path) -> Value {
    let path = path.display().to_string();
    let found = Peer::start("read_mcap.py", &[&path]).finish();
    let found = found[&path].clone();
    assert_eq!(found["streamed"], found["messages"], "with the index and without: {found:#}");
    found
}

/// A topic is there, with this schema, its messages this many.
fn assert_topic(found: &Value, topic: &str, schema: &str, counts: std::ops::RangeInclusive<f64>) {
    let entry = &found["topics"][topic];
    assert_eq!(entry["schema"], schema, "{topic}: {entry:#}");
    let messages = number(entry, "messages");
    assert!(counts.contains(&messages), "{topic}: {messages} messages, expected {counts:?}");
    let encoding = entry["encoding"].as_str().expect("an encoding");
    assert!(["protobuf", "json"].contains(&encoding), "{topic}: {encoding}");
}

fn assert_finished(found: &Value) {
    assert_eq!(found["summary"], true, "{found:#}");
    assert_eq!(found["stated"], found["messages"], "{found:#}");
    assert!(number(found, "chunks") >= 2.0, "{found:#}");
    assert!(found["library"].as_str().is_some_and(|name| name.starts_with("drover ")), "{found:#}");
    let topics = found["topics"].as_object().expect("topics");
    for (topic, entry) in topics {
        let schema = entry["schema"].as_str().expect("a schema");
        assert!(["foxglove.", "drover."].iter().any(|from| schema.starts_with(from)), "{topic}: {schema}");
    }
}

fn assert_robot_topics(found: &Value, id: u32, run_s: f64) {
    let topic = |name: &str| format!("/robot-{id}/{name}");
    let rate = |low_hz: f64, high_hz: f64| low_hz * run_s..=high_hz * (run_s + 3.0);
    assert_topic(found, &topic("begin"), "drover.Begin", 1.0..=1.0);
    assert_topic(found, &topic("state"), "drover.State", rate(8.0, 10.5));
    assert_topic(found, &topic("decision"), "drover.Decision", rate(15.0, 50.0));
    assert_topic(found, &topic("wire"), "drover.Wire", rate(3.0, 6.0));
    assert_topic(found, &topic("beacon"), "drover.Beacon", rate(1.0, 2.5));
    // Rovers need some seconds until their lidar's messages flow.
    assert_topic(found, &topic("scan"), "foxglove.LaserScan", rate(3.0, 10.5));
    let scan = &found["topics"][topic("scan")];
    assert_eq!(scan["shape"][0], format!("robot-{id}"), "{scan:#}");
    assert!(scan["shape"][1].as_u64().is_some_and(|beams| beams >= 36), "{scan:#}");
    assert!(scan["metadata"]["range_m_max"].as_str().is_some_and(|text| text.parse::<f64>().is_ok()), "{scan:#}");
}

#[test]
fn every_message_of_a_run_in_real_time_is_decoded_by_the_python_reader() {
    const RUN_S: f64 = 6.0;
    let folder = tempfile::tempdir().expect("a folder");
    let before_s = unix_s();
    let output = up(folder.path(), &["--duration", &RUN_S.to_string(), "--no-view", "--json"]);
    let after_s = unix_s();
    let summary = json(&output);
    assert_eq!(summary["recording_dropped"], 0, "{summary:#}");
    assert!(summary["recording_failed"].is_null(), "{summary:#}");
    let path = one_recording(folder.path());
    assert_eq!(summary["recording"], path.display().to_string());
    let found = read(&path);
    assert_finished(&found);
    let (first_s, last_s) = (number(&found, "first_s"), number(&found, "last_s"));
    assert!(before_s <= first_s && last_s <= after_s + 0.1, "{before_s} {first_s} {last_s} {after_s}");
    assert!((RUN_S - 0.5..RUN_S + 3.0).contains(&(last_s - first_s)), "{first_s} to {last_s}");
    for (topic, schema) in [("/drover/setting", "drover.Setting"), ("/drover/summary", "drover.Summary")] {
        assert_topic(&found, topic, schema, 1.0..=1.0);
    }
    assert_topic(&found, "/scene", "foxglove.SceneUpdate", 1.0..=1.0);
    assert_topic(&found, "/tf", "foxglove.FrameTransforms", 8.0 * RUN_S..=10.5 * (RUN_S + 3.0));
    assert_topic(&found, "/run", "drover.Run", 8.0 * RUN_S..=10.5 * (RUN_S + 3.0));
    assert_topic(&found, "/links", "foxglove.SceneUpdate", 1.5 * RUN_S..=2.1 * (RUN_S + 3.0));
    assert_topic(&found, "/heard", "drover.Heard", 1.5 * RUN_S..=2.1 * (RUN_S + 3.0));
    assert_topic(&found, "/log", "foxglove.Log", 5.0..=500.0);
    for id in 1..=5 {
        assert_robot_topics(&found, id, RUN_S);
    }
    let kib = number(&found, "bytes") / 1024.0;
    println!("{kib:.0} KiB for five robots and {RUN_S} s, {} messages", found["messages"]);
    assert!(kib < 1024.0, "{kib} KiB");
}

fn unix_s() -> f64 {
    let unix = std::time::SystemTime::now().duration_since(std::time::UNIX_EPOCH);
    unix.expect("a clock after 1970").as_secs_f64()
}

#[test]
fn a_mapped_world_is_a_grid_in_the_recording() {
    let folder = tempfile::tempdir().expect("a folder");
    let mut sim = drover();
    sim.arg("sim").arg(top().join("config/swarms/cafe.toml")).args(["--record", "--duration", "2"]);
    sim.args(private(folder.path()).iter().flat_map(|set| ["--set", set]));
    let output = sim.output().expect("drover runs");
    // Who wanders has nowhere to arrive at.
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    let found = read(&one_recording(folder.path()));
    assert_finished(&found);
    assert_topic(&found, "/map", "foxglove.Grid", 1.0..=1.0);
    let shape = &found["topics"]["/map"]["shape"];
    assert_eq!(shape[0], "world", "{shape:#}");
    // Whole rows of whole cells, and nothing else: the cafe's map is 200 by 150 cells.
    assert_eq!((shape[1].as_u64(), shape[2].as_f64()), (Some(200), Some(150.0)), "{shape:#}");
    assert!(shape[3].as_u64().is_some_and(|stride| stride >= 1) && shape[4] == 1, "{shape:#}");
    assert_topic(&found, "/tf", "foxglove.FrameTransforms", 15.0..=21.0);
    for id in 1..=12 {
        assert_topic(&found, &format!("/robot-{id}/scan"), "foxglove.LaserScan", 10.0..=21.0);
        assert_topic(&found, &format!("/robot-{id}/state"), "drover.State", 15.0..=21.0);
    }
}
