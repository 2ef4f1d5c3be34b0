//! `--set`: any key, checked like the file.

use super::good;
use crate::{Behaviour, LidarLink, Override, Problem, Swarm, load_robot, load_swarm};

fn sets(texts: &[&str]) -> Vec<Override> {
    texts.iter().map(|text| Override::parse(text).expect("a key and a value")).collect()
}

fn with(texts: &[&str]) -> Swarm {
    load_swarm(&good("swarms/first.toml"), &sets(texts)).unwrap_or_else(|problems| panic!("{problems}"))
}

/// The one problem that `text` makes.
fn refused(text: &str) -> Problem {
    let problems = load_swarm(&good("swarms/first.toml"), &sets(&[text])).expect_err("refused").0;
    let [problem] = problems.try_into().unwrap_or_else(|all: Vec<_>| panic!("one problem, not {all:#?}"));
    problem
}

#[test]
fn any_key_of_any_file_can_be_set() {
    let swarm = with(&[
        "seed=18446744073709551615",
        "record_dir=/tmp/runs of today",
        "robot[2].start.x_m=3.1",
        "robots.4.start = { x_m = 1.0, y_m = 6.0 }",
        "kinds.scout_mini.motion.speed_mps_max=1",
        "kinds.scout_mini.lidar.link.silent_is_clear=true",
        "world.circles[0].radius_m=0.5",
        "behaviour.waypoints_m[4]=[20.0, 9.0]",
        "beacon.port=20000",
    ]);
    assert_eq!((swarm.seed, swarm.record_dir.as_str(), swarm.beacon.port), (u64::MAX, "/tmp/runs of today", 20_000));
    let x_m: Vec<f64> = swarm.robots.iter().map(|robot| robot.start.x_m).collect();
    assert_eq!(x_m, [4.6, 3.0, 3.1, 1.0, 1.5]);
    let scout = &swarm.kinds["scout_mini"];
    assert!((scout.motion.speed_mps_max - 1.0).abs() < 1e-12);
    assert_eq!(scout.lidar.link, LidarLink::Dronecan { node: 42, silent_is_clear: true });
    assert!((swarm.world.circles[0].radius_m - 0.5).abs() < 1e-12);
    let Behaviour::Flock(flock) = &swarm.behaviour else { panic!("a flock") };
    assert_eq!(flock.parties[0].waypoints_m.last(), Some(&[20.0, 9.0]));
}

#[test]
fn the_last_of_two_overrides_counts() {
    assert_eq!(with(&["step_ms=1", "step_ms=2"]).step_ms, 2);
}

#[test]
fn a_kind_and_a_world_can_be_exchanged_for_other_files() {
    let rover = good("robots/rover_mavlink.toml");
    let world = good("worlds/room.toml");
    let swarm = with(&[
        &format!("kinds.scout_mini={}", rover.display()),
        &format!("world={}", world.display()),
        "world.name=hall",
    ]);
    assert_eq!(swarm.kinds["scout_mini"].lidar.beams, 72);
    assert_eq!((swarm.kinds["scout_mini"].name.as_str(), swarm.world.name.as_str()), ("scout_mini", "hall"));
}

#[test]
fn swarm_wide_tables_tighten_every_kind_and_never_loosen_one() {
    let swarm = with(&[
        "kinds.scout_mini.motion.speed_mps_max=0.7",
        "motion={ speed_mps_max = 1.0, margin_m = 0.4 }",
        "timeouts.scan_ms=200",
    ]);
    let speeds: Vec<f64> = swarm.kinds.values().map(|kind| kind.motion.speed_mps_max).collect();
    assert_eq!(speeds, [1.0, 0.7]);
    assert!(swarm.kinds.values().all(|kind| kind.timeouts.scan_ms == 200));
    assert!(swarm.kinds.values().all(|kind| (kind.motion.margin_m - 0.4).abs() < 1e-12));
    assert_eq!(refused("timeouts.peer_ms=5000").key, "timeouts.peer_ms");
}

#[test]
fn problems_name_the_override_and_no_line() {
    let problem = refused("robot[2].start.x_m=abc");
    assert_eq!(
        problem.to_string(),
        "--set robot[2].start.x_m=abc: key 'robot[2].start.x_m': found \"abc\"; \
         allowed: a number in -10000..=10000; do: write the number without quotes"
    );
    assert_eq!((problem.line, problem.column), (None, None));
}

#[test]
fn an_unknown_key_names_the_nearest_one() {
    assert_eq!(refused("behaviour.leader_sped_mps=1").advice, "did you mean 'leader_speed_mps'?");
    assert_eq!(refused("leader_speed_mps=1").advice, "did you mean 'behaviour.leader_speed_mps'?");
    assert_eq!(refused("behavior.leader=2").advice, "did you mean 'behaviour'?");
}

#[test]
fn a_path_that_leads_nowhere_says_where_it_ends() {
    assert_eq!(refused("robot[9].id=3").expected, "an index below 5");
    assert_eq!(refused("robots.9.start.x_m=3").found, "robot id 9");
    assert_eq!(refused("robot.id=3").advice, "write an index before 'id', as in robot[0].id");
    assert_eq!(refused("seed.x=3").expected, "no key below a plain value");
    assert_eq!(refused("seed[0]=3").expected, "no index: it is not a list");
}

#[test]
fn what_is_no_override_is_refused_before_any_file_is_read() {
    for text in ["", "seed", "=3", "a..b=3", "a[x]=3", "a[1=3", "a b=3", "ü=3", "robot[-1].id=3", &"a.".repeat(99)] {
        let problem = Override::parse(text).expect_err(text);
        assert_eq!(problem.file, format!("--set {text}"));
    }
}

#[test]
fn a_robot_file_takes_overrides_too() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("robot.toml");
    let file = with(&[]).robot_file(3).expect("good");
    std::fs::write(&path, file.to_toml()).expect("written");
    let set = sets(&["robot.links.drive=can0", "kind.motion.speed_mps_max=0.8", "record_dir=/tmp/x"]);
    let read = load_robot(&path, &set).unwrap_or_else(|problems| panic!("{problems}"));
    assert_eq!(read.record_dir.as_deref(), Some("/tmp/x"));
    assert!((read.kind.motion.speed_mps_max - 0.8).abs() < 1e-12);
}
