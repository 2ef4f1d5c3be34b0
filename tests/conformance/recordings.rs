//! What crossed robots' links is read by others' readers: the tlog by pymavlink, the candump log by python-can.

use crate::common::{drover, first_swarm, first_toml, private};
use crate::support::{Peer, number};
use drover_contract::Stamp;
use drover_swarm::VirtualSwarm;
use serde_json::Value;
use std::collections::BTreeMap;
use std::path::Path;
use std::time::Duration;

const RUN_S: f64 = 8.0;

/// Lay these files in `folder`, and let others read them. pymavlink does not know our beacons: those are left out.
fn read(folder: &Path, recordings: &BTreeMap<String, Vec<u8>>) -> Value {
    let mut paths = Vec::new();
    for (name, bytes) in recordings.iter().filter(|(name, _)| !name.ends_with("-beacons.tlog")) {
        let path = folder.join(name);
        std::fs::write(&path, bytes).expect("a writable folder");
        paths.push(path.display().to_string());
    }
    let arguments: Vec<&str> = paths.iter().map(String::as_str).collect();
    Peer::start("read_recordings.py", &arguments).finish()
}

fn assert_all_read(recordings: &BTreeMap<String, Vec<u8>>, found: &Value) {
    let names: Vec<&str> = recordings.keys().map(String::as_str).collect();
    let count = |end: &str| names.iter().filter(|name| name.ends_with(end)).count();
    assert_eq!((count("-beacons.tlog"), count(".tlog")), (5, 7), "{names:?}");
    assert_eq!((count("-drive.log"), count("-lidar.log"), count(".log")), (3, 3, 6), "{names:?}");
    for (name, bytes) in recordings.iter().filter(|(name, _)| !name.ends_with("-beacons.tlog")) {
        let found = &found[name];
        assert_times(name, found);
        if name.ends_with(".tlog") {
            assert_tlog(name, found);
        } else {
            assert_candump(name, found, bytes);
        }
    }
}

fn assert_times(name: &str, found: &Value) {
    assert_eq!(found["backwards"], 0, "{name}: {found:#}");
    let (first_s, last_s) = (number(found, "first_s"), number(found, "last_s"));
    assert!(last_s - first_s > RUN_S - 1.5 && last_s - first_s <= RUN_S, "{name}: {first_s} to {last_s}");
}

fn assert_tlog(name: &str, found: &Value) {
    assert_eq!(found["bad"], 0, "{name}: {found:#}");
    let kinds = [
        "HEARTBEAT",
        "COMMAND_LONG",
        "COMMAND_ACK",
        "SET_POSITION_TARGET_LOCAL_NED",
        "LOCAL_POSITION_NED",
        "ATTITUDE",
        "SYS_STATUS",
        "OBSTACLE_DISTANCE",
        "DISTANCE_SENSOR",
    ];
    for kind in kinds {
        assert!(found["kinds"][kind].as_u64().is_some_and(|count| count > 0), "{name} without {kind}: {found:#}");
    }
    // Both directions: the autopilot, the lidar bridge, and our onboard computer.
    let id = name.trim_start_matches("robot-").trim_end_matches(".tlog");
    for component in ["1", "191", "196"] {
        assert!(found["sources"][format!("{id}/{component}")].is_u64(), "{name}, component {component}: {found:#}");
    }
}

fn assert_candump(name: &str, found: &Value, recorded: &[u8]) {
    let lines = recorded.iter().filter(|byte| **byte == b'\n').count();
    assert_eq!(number(found, "messages") as usize, lines, "{name}: {found:#}");
    assert_eq!(found["errors"], 0, "{name}: {found:#}");
    assert_eq!(found["channels"].as_array().map(Vec::len), Some(1), "{name}: {found:#}");
    assert!(number(found, "received") > 0.0 && number(found, "sent") > 0.0, "{name}: {found:#}");
    if name.contains("-drive") {
        assert_eq!(found["extended"].as_object().map(serde_json::Map::len), Some(0), "{name}: {found:#}");
        for id in ["111", "421", "211", "221", "311"] {
            assert!(found["standard"][id].is_u64(), "{name} without 0x{id}: {found:#}");
        }
    } else {
        assert_eq!(found["standard"].as_object().map(serde_json::Map::len), Some(0), "{name}: {found:#}");
        let most = found["extended"].as_object().expect("a table").values().filter_map(Value::as_u64).max();
        assert!(most.is_some_and(|count| count > 36 * 10 * 6), "36 sectors, 10 times a second: {name}: {found:#}");
    }
}

#[test]
fn every_recording_of_a_swarm_is_read_to_its_end_by_pymavlink_and_python_can() {
    let folder = tempfile::tempdir().expect("a folder");
    let swarm = first_swarm(folder.path(), &[]);
    let mut virtual_swarm = VirtualSwarm::new(&swarm).unwrap_or_else(|error| panic!("{error}"));
    virtual_swarm.run_until(Stamp::ZERO + Duration::from_secs_f64(RUN_S));
    let recordings = virtual_swarm.recordings();
    let found = read(folder.path(), &recordings);
    assert_all_read(&recordings, &found);
}

/// `drover sim --record`, then `drover export`: the same, by way of an MCAP file.
#[test]
fn what_is_exported_from_an_mcap_file_is_read_by_pymavlink_and_python_can() {
    let folder = tempfile::tempdir().expect("a folder");
    let set = private(folder.path());
    let mut sim = drover();
    sim.arg("sim").arg(first_toml()).args(["--fidelity", "wire", "--record", "--seeds", "1"]);
    sim.args(["--duration", &RUN_S.to_string()]).args(set.iter().flat_map(|set| ["--set", set]));
    let output = sim.output().expect("drover runs");
    assert_eq!(output.status.code(), Some(1), "{}", String::from_utf8_lossy(&output.stderr));
    let recording = crate::mcap::one_recording(folder.path());
    let exported = folder.path().join("exported");
    let output = drover().arg("export").arg(&recording).arg("--to").arg(&exported).output().expect("drover runs");
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    let mut recordings = BTreeMap::new();
    for entry in std::fs::read_dir(&exported).expect("the folder") {
        let path = entry.expect("a file").path();
        let name = path.file_name().expect("a name").to_string_lossy().into_owned();
        recordings.insert(name, std::fs::read(&path).expect("a file"));
    }
    let table = String::from_utf8(recordings.remove("states.csv").expect("a table")).expect("text");
    let rows = table.lines().count();
    assert!((300..=500).contains(&rows), "five robots, ten times a second: {rows}");
    let found = read(folder.path(), &recordings);
    assert_all_read(&recordings, &found);
}
