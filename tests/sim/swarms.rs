//! Swarms for the tests: shipped files with some keys set, and small ones of the tests' own.

use drover_config::{Override, Swarm, load_swarm};
use std::path::Path;

/// A shipped file under `config/`, with some keys set.
pub(crate) fn shipped(file: &str, set: &[&str]) -> Swarm {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("config").join(file);
    load(&path, set)
}

/// A swarm of a text whose `../` leads to `config/`.
pub(crate) fn written(text: &str, set: &[&str]) -> Swarm {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("swarm.toml");
    let text = text.replace("../", concat!(env!("CARGO_MANIFEST_DIR"), "/config/"));
    std::fs::write(&path, text).expect("a writable folder");
    load(&path, set)
}

fn load(path: &Path, set: &[&str]) -> Swarm {
    let set: Vec<Override> = set.iter().map(|text| Override::parse(text).expect("a good override")).collect();
    load_swarm(path, &set).unwrap_or_else(|problems| panic!("{problems}"))
}

/// Four hundred robots in a hall: more than any one job of a step takes.
pub(crate) const CROWD: &str = r#"
name = "crowd"
seed = 1
duration_s = 3.0
world = "../worlds/pillars.toml"
[kinds]
scout_mini = "../robots/scout_mini.toml"
[[fleet]]
kind = "scout_mini"
count = 400
layout = "random"
spacing_m = 1.2
region_m = [[-20.0, -20.0], [20.0, 20.0]]
[behaviour]
kind = "diffuse"
speed_mps = 0.8
clearance_m = 1.0
ahead_rad = 1.5 # under a right angle: beams in opposite directions, both ahead, would be exact ties
[radio]
range_m = 10.0
loss = 0.1
"#;

/// Twenty robots in the passages of a generated maze.
pub(crate) const MAZE: &str = r#"
name = "maze"
seed = 5
duration_s = 20.0
world = "../worlds/generated/maze.toml"
[kinds]
scout_mini = "../robots/scout_mini.toml"
[[fleet]]
kind = "scout_mini"
count = 20
layout = "random"
spacing_m = 1.2
[behaviour]
kind = "diffuse"
speed_mps = 0.5
clearance_m = 0.9
"#;

/// Everything at once that a world may have: outlines, sweeping lidars mounted elsewhere with ranges in steps, and a
/// radio with bursts, jitter, duplicates, walls and a busy channel.
pub(crate) const EVERYTHING: &str = r#"
name = "everything"
seed = 3
duration_s = 15.0
world = "../worlds/generated/cave.toml"
[kinds.box]
file = "../robots/scout_mini.toml"
body = { footprint_m = [[0.3, -0.28], [0.3, 0.28], [-0.3, 0.28], [-0.3, -0.28]] }
lidar = { mount = { x_m = 0.15, y_m = -0.05, yaw_rad = 0.3 } }
sim = { scan_sweep = true, range_step_m = 0.02 }
[kinds.point]
file = "../robots/rover_mavlink.toml"
sim = { motion = "point", prearm_s = 0.2 }
[[fleet]]
kind = "box"
count = 8
region_m = [[2.5, 2.5], [9.5, 9.5]]
spacing_m = 1.5
yaw_rad = 0.7
[[fleet]]
kind = "point"
count = 4
first_id = 101
region_m = [[2.5, 2.5], [9.5, 9.5]]
layout = "random"
spacing_m = 0.9
[behaviour]
kind = "diffuse"
speed_mps = 0.6
clearance_m = 1.0
[radio]
range_m = 15.0
loss = 0.05
delay_ms = 5.0
jitter_ms = 150.0
duplicate = 0.2
asymmetry = 0.3
burst = { enter_per_s = 1.0, leave_per_s = 2.0, loss = 0.9 }
propagation = { half_range_m = 8.0, wall_db = 6.0, shadow_db = 4.0 }
airtime = { message_ms = 2.0, wait_ms_max = 20.0 }
[[radio.partitions]]
from_s = 3.0
until_s = 5.0
ids = [1, 2, 101]
"#;
