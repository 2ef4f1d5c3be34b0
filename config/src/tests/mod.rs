//! Whole files: what is shipped, what is written and read again.

mod bad;
mod bad_places;
mod deploy;
mod documented;
mod explore;
mod fleets;
mod flock;
mod generated;
mod hostile;
mod maps;
mod overrides;

use crate::{Checked, Links, check_file, load_kind, load_robot, load_swarm, load_world};
use std::path::{Path, PathBuf};

/// A file that is right and stays as it is: the shipped ones are tuned.
fn good(name: &str) -> PathBuf {
    shipped("src/tests/good").join(name)
}

/// A shipped file.
fn shipped(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(name)
}

#[test]
fn every_shipped_file_loads_without_a_problem() {
    for folder in ["robots", "worlds", "swarms"] {
        let entries = std::fs::read_dir(shipped(folder)).expect("the folder is shipped");
        for entry in entries {
            let path = entry.expect("a readable folder").path();
            if path.extension().is_none_or(|ending| ending != "toml") {
                continue; // a map's files, and the generated worlds, which have tests of their own
            }
            if let Err(problems) = check_file(&path) {
                panic!("{problems}");
            }
        }
    }
}

#[test]
fn the_first_swarm_is_the_one_that_was_asked_for() {
    let swarm = load_swarm(&shipped("swarms/first.toml"), &[]).expect("shipped");
    let ids: Vec<u32> = swarm.robots.iter().map(|robot| robot.id).collect();
    assert_eq!(ids, [1, 2, 3, 4, 5]);
    assert_eq!(swarm.robots[0].links, Links::Mavlink { autopilot: "udpout:127.0.0.1:14601".to_owned() });
    let can = Links::Can { drive: "vcan5d".to_owned(), lidar: "vcan5l".to_owned() };
    assert_eq!(swarm.robots[4].links, can);
}

#[test]
fn a_resolved_swarm_written_out_reads_back_equal() {
    let mut swarm = load_swarm(&shipped("swarms/first.toml"), &[]).expect("shipped");
    swarm.seed = u64::MAX;
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("resolved.toml");
    std::fs::write(&path, swarm.to_toml()).expect("written");
    assert_eq!(load_swarm(&path, &[]).map_err(|problems| problems.to_string()), Ok(swarm.clone()));
    for robot in &swarm.robots {
        let file = swarm.robot_file(robot.id).expect("its robot");
        std::fs::write(&path, file.to_toml()).expect("written");
        assert_eq!(load_robot(&path, &[]).map_err(|problems| problems.to_string()), Ok(file));
        assert!(matches!(check_file(&path), Ok(Checked::Robot(_))));
    }
}

#[test]
fn each_sort_of_file_is_recognised_by_its_tables() {
    assert!(matches!(check_file(&shipped("swarms/first.toml")), Ok(Checked::Swarm(_))));
    assert!(matches!(check_file(&shipped("robots/scout_mini.toml")), Ok(Checked::Kind(_))));
    assert!(matches!(check_file(&shipped("worlds/room.toml")), Ok(Checked::World(_))));
    assert_eq!(load_kind(&shipped("robots/scout_mini.toml")).expect("shipped").name, "scout_mini");
    assert_eq!(load_world(&shipped("worlds/room.toml")).expect("shipped").name, "room");
}
