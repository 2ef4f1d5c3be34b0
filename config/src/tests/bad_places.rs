//! Thin walls, maps, footprints, sensors and radios that cannot be; bodies where none can be.

use super::{good, shipped};
use crate::{Override, Problem, load_swarm};

/// The one problem of a good swarm with changes.
fn refused(sets: &[&str]) -> Problem {
    let sets: Vec<Override> = sets.iter().map(|set| Override::parse(set).expect("a key and a value")).collect();
    let problems = load_swarm(&good("swarms/first.toml"), &sets).expect_err("refused").0;
    let [problem] = problems.try_into().unwrap_or_else(|all: Vec<_>| panic!("one problem, not {all:#?}"));
    problem
}

/// A change, the key that is wrong, and words of found, allowed and advice.
fn check(rows: &[(&str, &str, [&str; 3])]) {
    for (set, key, [found, allowed, advice]) in rows {
        let problem = refused(&[set]);
        assert_eq!(problem.key, *key, "{problem}");
        assert!(problem.found.contains(found), "{found:?} in: {problem}");
        assert!(problem.expected.contains(allowed), "{allowed:?} in: {problem}");
        assert!(problem.advice.contains(advice), "{advice:?} in: {problem}");
    }
}

#[test]
fn thin_walls_that_cannot_be_are_refused() {
    const KEY: &str = "world.polylines[0].points_m";
    check(&[
        ("world.polylines=[{ points_m = [[1, 1]] }]", KEY, ["a list of 1", "2..=1000 points", "add points"]),
        ("world.polylines=[{ points_m = [[1, 1], [1, 1]] }]", KEY, ["corners 0 and 1", "another place", "leave one"]),
        (
            "world.polylines=[{ points_m = [[1, 1], [nan, 1]] }]",
            "world.polylines[0].points_m[1]",
            ["[nan, 1]", "-10000..=10000", "finite"],
        ),
        (
            "world.polylines=[{ points_m = [[1, 1], [inf, 1]] }]",
            "world.polylines[0].points_m[1]",
            ["[inf, 1]", "-10000..=10000", "finite"],
        ),
        (
            "world.polylines=[{ points_m = [[1, 1], [1, 2]], closed = true }]",
            "world.polylines[0].closed",
            ["unknown key", "points_m", "remove it"],
        ),
        (
            "world.polylines=[{ points_m = [[4.5, 5], [4.5, 7]] }]",
            "robot[0].start",
            ["0.100 m from polylines[0]", "0.3 m of free floor", "wall"],
        ),
        (
            "world.polylines=[{ points_m = [[13.0, 9.0], [13.5, 9.5]] }]",
            "behaviour.waypoints_m[2]",
            ["m from polylines[0]", "0.3 m of free floor", "wall"],
        ),
    ]);
    let lines: Vec<String> = (0..21)
        .map(|line| {
            let corners: Vec<String> = (0..1_000).map(|corner| format!("[{corner}, {}]", 100 + line)).collect();
            format!("{{ points_m = [{}] }}", corners.join(","))
        })
        .collect();
    let problem = refused(&[&format!("world.polylines=[{}]", lines.join(","))]);
    assert_eq!((problem.key.as_str(), problem.expected.as_str()), ("world.polylines", "at most 20000"));
}

#[test]
fn movers_that_cannot_be_are_refused() {
    const KEY: &str = "world.movers[0].waypoints_m";
    const ADVICE: &str = "move the waypoints";
    let free = "more than 0.4 m of free floor";
    let rows: [(&str, String, [&str; 3]); 11] = [
        ("[[10, 5]], speed_mps = 1", KEY.into(), ["a list of 1", "2..=1000 points", "add points"]),
        ("[[10, 5], [10, 5]], speed_mps = 1", KEY.into(), ["waypoints 0 and 1", "another place", "leave one"]),
        (
            "[[10, 5], [10, 7], [10, 5]], speed_mps = 1, loop = true",
            KEY.into(),
            ["waypoints 2 and 0", "another place", "leave one"],
        ),
        ("[[10, 5], [10, 7]]", "world.movers[0].speed_mps".into(), ["nothing", "0.001..=20", "add"]),
        ("[[10, 5], [10, 7]], speed_mps = 0", "world.movers[0].speed_mps".into(), ["0", "0.001..=20", "range"]),
        ("[[10, 5], [10, 7]], speed_mps = 1, lop = true", "world.movers[0].lop".into(), ["unknown key", "", "'loop'"]),
        ("[[10, 5], [10, 13.7]], speed_mps = 1", format!("{KEY}[0]"), ["0 to 1, 0.3", free, ADVICE]),
        ("[[10, 5], [16, 6.4], [21, 6.4]], speed_mps = 1", format!("{KEY}[1]"), ["polygons[3]", free, ADVICE]),
        (
            "[[16, 6.4], [18.5, 8.5], [21, 6.4]], loop = true, speed_mps = 1",
            format!("{KEY}[2]"),
            ["waypoint 2 to 0", free, ADVICE],
        ),
        ("[[-5, 1], [-5, 2]], speed_mps = 1", format!("{KEY}[0]"), ["outside of the enclosure", free, ADVICE]),
        (
            "[[4.6, 6.5], [4.6, 8]], speed_mps = 1",
            "robot[0].start".into(),
            ["0.500 m from world.movers[0]", "at least 0.700 m", "move one"],
        ),
    ];
    for (mover, key, words) in rows {
        check(&[(&format!("world.movers=[{{ radius_m = 0.4, waypoints_m = {mover} }}]"), &key, words)]);
    }
}

#[test]
fn a_mover_along_a_wall_for_kilometres_is_refused_before_long() {
    let hall = "world.polygons=[{ enclosure = true, points_m = [[0, 0], [9000, 0], [9000, 14], [0, 14]] }]";
    let mover = "world.movers=[{ radius_m = 0.4, waypoints_m = [[1, 0.4015], [8000, 0.4015]], speed_mps = 1 }]";
    let problem = refused(&["world.circles=[]", hall, mover]);
    assert!(problem.found.contains("too long to be looked at"), "{problem}");
}

#[test]
fn movers_that_can_be_are_read_and_written_and_fleets_start_beside_them() {
    let mover = "{ radius_m = 0.4, waypoints_m = [[9.7, 1.6], [9.7, 13], [11, 13]], speed_mps = 0.5 }";
    let looped = "{ radius_m = 1, waypoints_m = [[20, 2], [20, 4], [21.5, 4]], speed_mps = 1, loop = true }";
    // Of the four places that the region has, the mover starts in the first.
    let fleet = "fleet=[{ kind = \"scout_mini\", count = 3, first_id = 10, region_m = [[9, 1], [12, 4]] }]";
    let sets = [&format!("world.movers=[{mover}, {looped}]"), fleet];
    let sets = sets.map(|set| Override::parse(set).expect("a key and a value"));
    let swarm = load_swarm(&good("swarms/first.toml"), &sets).unwrap_or_else(|problems| panic!("{problems}"));
    let [first, second] = swarm.world.movers.as_slice() else { panic!("two movers") };
    assert_eq!(first.round_m(), [[9.7, 1.6], [9.7, 13.0], [11.0, 13.0], [9.7, 13.0]]);
    assert_eq!((second.round_m(), second.loops), (second.waypoints_m.clone(), true));
    let away_m = |robot: &crate::Robot| libm::hypot(robot.start.x_m - 9.7, robot.start.y_m - 1.6);
    assert!(swarm.robots.len() == 8 && swarm.robots.iter().all(|robot| away_m(robot) >= 0.4 + 0.42));
    assert_eq!(load_swarm_text(&swarm.to_toml()), swarm);
}

#[test]
fn starts_in_solid_cells_and_off_the_map_are_refused() {
    let set = |text: &str| Override::parse(text).expect("a key and a value");
    let kind = "fleet=[]";
    let robot = |x_m: f64, y_m: f64| {
        format!("robot=[{{ id = 1, kind = \"scout_mini\", start = {{ x_m = {x_m}, y_m = {y_m} }} }}]")
    };
    let cases = [
        (robot(-3.5, -3.5), "inside a solid cell of the map"),
        (robot(-9.0, 5.0), "inside a solid cell of the map"),
        (robot(-9.5, 0.0), "0.300 m from a solid cell of the map"),
        (robot(-9.8, 0.0), "0.200 m from the edge of the map"),
        (robot(30.0, 0.0), "outside of the map"),
    ];
    for (robot, found) in cases {
        let sets = [set(kind), set(&robot), set("radio={}")];
        let problems = load_swarm(&shipped("swarms/cafe.toml"), &sets).expect_err("refused").0;
        let [problem] = problems.as_slice() else { panic!("{problems:#?}") };
        assert!(problem.found.contains(found), "{problem}");
        assert_eq!(problem.key, "robot[0].start");
    }
    // What nobody has seen may be taken for free floor.
    let sets = [kind, &robot(-9.0, 5.0), "radio={}", "world.map.unknown=free"].map(set);
    assert!(load_swarm(&shipped("swarms/cafe.toml"), &sets).is_ok());
    let sets = [kind, &robot(30.0, 0.0), "radio={}", "world.map.unknown=free"].map(set);
    assert!(load_swarm(&shipped("swarms/cafe.toml"), &sets).is_ok());
}

#[test]
fn maps_are_named_by_table_or_by_path() {
    check(
        &[
            ("world.map=none.yaml", "world.map.file", ["none.yaml", "a readable file", "none.yaml"]),
            ("world.map=3", "world.map", ["3", "a table", "table"]),
            ("world.map={}", "world.map.file", ["nothing", "the path of a file", "add file"]),
            ("world.map={ file = \"\" }", "world.map.file", ["\"\"", "the path of a file", "name a file"]),
            (
                "world.map={ file = \"x\", unkown = \"free\" }",
                "world.map.unkown",
                ["unknown key", "unknown", "'unknown'"],
            ),
        ]
        .map(|(set, key, words)| (set, key, words))[..3],
    );
    let problem = refused(&["world.map={ file = \"\" }"]);
    assert_eq!((problem.key.as_str(), problem.expected.as_str()), ("world.map.file", "the path of a file"));
}

#[test]
fn footprints_that_cannot_be_are_refused() {
    const KEY: &str = "kinds.scout_mini.body.footprint_m";
    check(&[
        (
            "kinds.scout_mini.body.footprint_m=[[0.3, 0.2], [-0.3, 0.2]]",
            KEY,
            ["a list of 2", "3..=64 points", "add points"],
        ),
        (
            "kinds.scout_mini.body.footprint_m=[[0.3, 0.2], [-0.3, 0.2], [-0.1, 0], [-0.3, -0.2], [0.3, -0.2]]",
            KEY,
            ["a corner [-0.1, 0] that points inwards", "convex", "leave that corner out"],
        ),
        (
            "kinds.scout_mini.body.footprint_m=[[0.3, 0.2], [-0.3, -0.2], [-0.3, 0.2], [0.3, -0.2]]",
            KEY,
            ["edges 0 and 2", "convex", "order"],
        ),
        (
            "kinds.scout_mini.body.footprint_m=[[0.4, 0.2], [-0.3, 0.2], [-0.3, -0.2], [0.4, -0.2]]",
            KEY,
            ["0.447 m away", "within radius_m = 0.42", "raise body.radius_m"],
        ),
        (
            "kinds.scout_mini.body.footprint_m=[[0.3, 0.2], [0.1, 0.2], [0.1, -0.2], [0.3, -0.2]]",
            KEY,
            ["beside it", "around the point between the wheels", "body frame"],
        ),
        (
            "kinds.scout_mini.body.footprint_m=[[0.3, 0.2], [nan, 0.2], [0.1, -0.2]]",
            "kinds.scout_mini.body.footprint_m[1]",
            ["[nan, 0.2]", "a point", "finite"],
        ),
    ]);
    let clockwise =
        Override::parse("kinds.scout_mini.body.footprint_m=[[0.3, -0.2], [-0.3, -0.2], [-0.3, 0.2], [0.3, 0.2]]");
    let swarm = load_swarm(&good("swarms/first.toml"), &[clockwise.expect("a key")]).expect("either way round");
    let footprint = &swarm.kinds["scout_mini"].body.footprint_m;
    assert_eq!(*footprint, [[0.3, 0.2], [-0.3, 0.2], [-0.3, -0.2], [0.3, -0.2]]);
    assert_eq!(load_swarm_text(&swarm.to_toml()), swarm);
}

fn load_swarm_text(text: &str) -> crate::Swarm {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("swarm.toml");
    std::fs::write(&path, text).expect("written");
    load_swarm(&path, &[]).unwrap_or_else(|problems| panic!("{problems}"))
}

#[test]
fn sensors_that_cannot_be_are_refused() {
    check(&[
        (
            "kinds.scout_mini.lidar.fov_rad=3",
            "kinds.scout_mini.lidar.fov_rad",
            ["3", "a full turn, over dronecan", "leave it out"],
        ),
        ("kinds.rover_mavlink.lidar.fov_rad=0", "kinds.rover_mavlink.lidar.fov_rad", ["0", "0.01..=6.28", "range"]),
        (
            "kinds.rover_mavlink.lidar.mount={ x_m = 0.3, y_m = 0.1 }",
            "kinds.rover_mavlink.lidar.mount",
            ["0.316 m away", "within body.radius_m = 0.3", "measure"],
        ),
        (
            "kinds.rover_mavlink.lidar.mount={ x_mm = 0.3 }",
            "kinds.rover_mavlink.lidar.mount.x_mm",
            ["unknown key", "x_m, y_m, yaw_rad", "'x_m'"],
        ),
        ("kinds.rover_mavlink.sim.motion=\"car\"", "kinds.rover_mavlink.sim.motion", ["car", "\"point\"", "choose"]),
        ("kinds.rover_mavlink.sim.range_step_m=-1", "kinds.rover_mavlink.sim.range_step_m", ["-1", "0..=1", "range"]),
        ("kinds.rover_mavlink.sim.scan_sweep=1", "kinds.rover_mavlink.sim.scan_sweep", ["1", "true or false", "true"]),
    ]);
}

#[test]
fn radios_that_cannot_be_are_refused() {
    check(&[
        ("radio.duplicate=2", "radio.duplicate", ["2", "0..=1", "range"]),
        ("radio.asymmetry=nan", "radio.asymmetry", ["nan", "0..=1", "finite"]),
        ("radio.burst={ enter_per_s = 1 }", "radio.burst.leave_per_s", ["nothing", "0.001..=1000", "add"]),
        ("radio.burst={ enter_per_s = 1, leave_per_s = 0 }", "radio.burst.leave_per_s", ["0", "0.001..=1000", "range"]),
        ("radio.propagation={}", "radio.propagation.half_range_m", ["nothing", "0.1..=100000", "add"]),
        ("radio.propagation={ half_range_m = 9, wal_db = 3 }", "radio.propagation.wal_db", ["unknown", "", "wall_db"]),
        ("radio.airtime={ message_ms = 0 }", "radio.airtime.message_ms", ["0", "0.001..=1000", "range"]),
        (
            "radio.partitions=[{ from_s = 2, until_s = 1, ids = [1] }]",
            "radio.partitions[0].until_s",
            ["1", "more than from_s, 2", "swap"],
        ),
        (
            "radio.partitions=[{ from_s = 1, until_s = 2, ids = [1, 9] }]",
            "radio.partitions[0].ids[1]",
            ["9", "a robot of this swarm", "choose another"],
        ),
        (
            "radio.partitions=[{ from_s = 1, until_s = 2, ids = [] }]",
            "radio.partitions[0].ids",
            ["a list of 0", "1..=100000 ids", "add ids"],
        ),
        (
            "radio.partitions=[{ from_s = 1, until_s = 2, ids = [-1] }]",
            "radio.partitions[0].ids[0]",
            ["-1", "1..=4294967295", "a robot's id"],
        ),
    ]);
}

#[test]
fn diffusion_that_these_bodies_cannot_do_is_refused() {
    check(&[
        (
            "behaviour={ kind = \"diffuse\", speed_mps = 2 }",
            "behaviour.speed_mps",
            ["2", "motion.speed_mps_max of its kinds, 1.5", "lower"],
        ),
        (
            "behaviour={ kind = \"diffuse\", turn_radps = 2 }",
            "behaviour.turn_radps",
            ["2", "motion.yaw_rate_radps_max of its kinds, 1.5", "lower"],
        ),
        (
            "behaviour={ kind = \"diffuse\", clearance_m = 13 }",
            "behaviour.clearance_m",
            ["13", "lidar.range_m_max of its kinds, 12", "lower"],
        ),
        (
            "behaviour={ kind = \"diffuse\", clearance_m = 0.4 }",
            "behaviour.clearance_m",
            ["0.4", "body.radius_m of its kinds, 0.42", "raise"],
        ),
        (
            "behaviour={ kind = \"diffuse\", leader = 1 }",
            "behaviour.leader",
            ["unknown key", "clearance_m", "remove it"],
        ),
    ]);
}
