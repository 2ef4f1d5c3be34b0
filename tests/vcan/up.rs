//! The whole swarm, its three CAN robots on six interfaces of this kernel.

use crate::common::{assert_reached_safely, exported, json, up, up_swarm};
use crate::support::{Peer, number};
use serde_json::Value;
use std::path::Path;

fn reaches_its_end_on_vcan(more: &[&str]) -> (tempfile::TempDir, Value) {
    let folder = tempfile::tempdir().expect("a folder");
    let arguments = [&["--duration", "60", "--seed", "1", "--json"], more].concat();
    let output = up(folder.path(), &arguments);
    let summary = json(&output);
    println!(
        "time {} s, gaps {} m and {} m, world rate {}",
        summary["time_s"], summary["min_gap_robot_m"], summary["min_gap_wall_m"], summary["world_rate"]
    );
    assert_reached_safely(&summary);
    assert_eq!(summary["can"], "vcan", "{summary:#}");
    assert_eq!(output.status.code(), Some(0), "{summary:#}");
    for interface in ["vcan3d", "vcan3l", "vcan4d", "vcan4l", "vcan5d", "vcan5l"] {
        assert!(!Path::new("/sys/class/net").join(interface).exists(), "{interface} was left behind");
    }
    (folder, summary)
}

#[test]
fn the_first_swarm_reaches_its_end_on_real_vcan_and_others_read_its_recordings() {
    let (_folder, summary) = reaches_its_end_on_vcan(&[]);
    assert_eq!(summary["processes"], false);
    let recording = exported(Path::new(summary["recording"].as_str().expect("a file")));
    let names = ["robot-1.tlog", "robot-3-drive.log", "robot-3-lidar.log"];
    let paths = names.map(|name| recording.join(name).display().to_string());
    let found = Peer::start("read_recordings.py", &paths.each_ref().map(String::as_str)).finish();
    for name in names {
        assert_eq!(found[name]["backwards"], 0, "{found:#}");
        let lasted_s = number(&found[name], "last_s") - number(&found[name], "first_s");
        assert!(lasted_s >= number(&summary, "time_s") - 2.0, "{name} lasts {lasted_s} s: {found:#}");
        assert!(number(&found[name], "first_s") > 1.7e9, "wall-clock time: {found:#}");
    }
}

#[test]
fn the_first_swarm_reaches_its_end_on_real_vcan_with_every_robot_a_process() {
    // Recording is shown above; here it would only cost what one slow processor has little of.
    let (_folder, summary) = reaches_its_end_on_vcan(&["--processes", "--no-record"]);
    assert_eq!(summary["processes"], true);
}

#[test]
fn twelve_robots_deploy_on_real_vcan_and_stay_connected() {
    let folder = tempfile::tempdir().expect("a folder");
    let arguments = ["--duration", "150", "--seed", "1", "--json", "--no-record"];
    let output = up_swarm("deploy_scouts", folder.path(), &arguments);
    let summary = json(&output);
    println!("time {} s, gaps {} m, lambda2 {}", summary["time_s"], summary["min_gap_robot_m"], summary["lambda2_min"]);
    for truth in ["reached", "connected_always", "stopped"] {
        assert_eq!(summary[truth], true, "{truth}: {summary:#}");
    }
    assert_eq!((summary["can"].as_str(), summary["tunnelled"].as_u64()), (Some("vcan"), Some(0)), "{summary:#}");
    let gaps_m = ["min_gap_robot_m", "min_gap_wall_m"].map(|gap| number(&summary, gap));
    assert!(gaps_m.iter().all(|gap_m| *gap_m > 0.0), "{summary:#}");
}

#[test]
fn rovers_and_scouts_begin_to_map_an_office_on_real_vcan() {
    let folder = tempfile::tempdir().expect("a folder");
    let output = up_swarm("explore_scouts_office", folder.path(), &["--duration", "40", "--seed", "1", "--json"]);
    let summary = json(&output);
    println!(
        "time {} s, gap {} m, world rate {}",
        summary["time_s"], summary["min_gap_robot_m"], summary["world_rate"]
    );
    assert_eq!(summary["can"], "vcan", "{summary:#}");
    assert_eq!(summary["stopped"], true, "{summary:#}");
    let gaps_m = ["min_gap_robot_m", "min_gap_wall_m"].map(|gap| number(&summary, gap));
    assert!(gaps_m.iter().all(|gap_m| *gap_m > 0.0), "{summary:#}");
    // What a Scout knows by then, in the files that Nav2 reads: some of the 384 m2, of its own and of the others'.
    let run = Path::new(summary["recording"].as_str().expect("a file")).parent().expect("its folder").to_owned();
    let image = std::fs::read(run.join("robot-3-map.pgm")).expect("a map");
    let free = image.iter().filter(|pixel| **pixel == 254).count();
    assert!(run.join("robot-3-map.yaml").exists() && free > 1_500, "{free} free cells: {summary:#}");
}
