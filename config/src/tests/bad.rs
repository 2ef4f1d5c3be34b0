//! What is wrong is said with its place, its key and what to do; and all of it at once.

use super::good;
use crate::{Problem, check_file, load_robot, load_swarm};
use std::path::{Path, PathBuf};

/// A folder with copies of the good files, one of which is changed.
struct Bench {
    folder: tempfile::TempDir,
}

impl Bench {
    fn new() -> Self {
        let folder = tempfile::tempdir().expect("a folder");
        let files = ["swarms/first.toml", "robots/rover_mavlink.toml", "robots/scout_mini.toml", "worlds/room.toml"];
        for file in files {
            let to = folder.path().join(file);
            std::fs::create_dir_all(to.parent().expect("a parent")).expect("made");
            std::fs::copy(good(file), to).expect("copied");
        }
        Self { folder }
    }

    fn path(&self, file: &str) -> PathBuf {
        self.folder.path().join(file)
    }

    /// Replaces the first `old` in `file`; where it stood: line and column, from 1.
    fn replace(&self, file: &str, old: &str, new: &str) -> (u32, u32) {
        let text = std::fs::read_to_string(self.path(file)).expect("copied");
        let at = text.find(old).unwrap_or_else(|| panic!("no {old:?} in {file}"));
        std::fs::write(self.path(file), text.replacen(old, new, 1)).expect("written");
        let line = text[..at].matches('\n').count() + 1;
        let column = at - text[..at].rfind('\n').map_or(0, |newline| newline + 1) + 1;
        (line as u32, column as u32)
    }

    fn problems(&self) -> Vec<Problem> {
        load_swarm(&self.path("swarms/first.toml"), &[]).expect_err("refused").0
    }
}

/// A change to a good file and what must be said about it.
struct Case {
    file: &'static str,
    old: &'static str,
    new: &'static str,
    key: &'static str,
    /// Where, in columns right of the change; `None`: not where the change is.
    right: Option<u32>,
    words: [&'static str; 3],
}

const SWARM: &str = "swarms/first.toml";
const ROVER: &str = "robots/rover_mavlink.toml";
const SCOUT: &str = "robots/scout_mini.toml";
const ROOM: &str = "worlds/room.toml";

/// A case: file, old text, new text, key, columns to the right, and words of found, allowed and advice.
type Row = (&'static str, &'static str, &'static str, &'static str, Option<u32>, [&'static str; 3]);

fn check(rows: &[Row]) {
    for (file, old, new, key, right, words) in rows {
        let case = Case { file, old, new, key, right: *right, words: *words };
        check_case(&case);
    }
}

fn check_case(case: &Case) {
    let bench = Bench::new();
    let (line, column) = bench.replace(case.file, case.old, case.new);
    let problems = bench.problems();
    let [problem] = problems.as_slice() else { panic!("{:?}: one problem, not {problems:#?}", case.new) };
    assert_eq!(problem.key, case.key, "{problem}");
    if let Some(right) = case.right {
        assert_eq!((problem.line, problem.column), (Some(line), Some(column + right)), "{problem}");
        assert!(problem.file.ends_with(case.file.rsplit('/').next().unwrap_or_default()), "{problem}");
    } else {
        assert!(problem.line.is_some() && problem.column.is_some(), "{problem}");
    }
    let [found, expected, advice] = case.words;
    assert!(problem.found.contains(found), "{found:?} in: {problem}");
    assert!(problem.expected.contains(expected), "{expected:?} in: {problem}");
    assert!(problem.advice.contains(advice), "{advice:?} in: {problem}");
}

#[test]
fn single_keys_are_refused_with_their_place() {
    check(&[
        (SWARM, "seed = 1", "seed = -1", "seed", Some(7), ["-1", "0..=18446744073709551615", "in that range"]),
        (SWARM, "seed = 1", "seed = 1.5", "seed", Some(7), ["1.5", "a whole number", "without a decimal point"]),
        (SWARM, "seed = 1", "sead = 1", "sead", Some(0), ["an unknown key", "seed", "did you mean 'seed'?"]),
        (SWARM, "seed = 1", "gain = 1", "gain", Some(0), ["unknown key", "one of", "'behaviour.gain'"]),
        (SWARM, "duration_s = 60.0", "", "duration_s", None, ["nothing", "0.1..=86400", "add duration_s"]),
        (SWARM, "duration_s = 60.0", "duration_s = nan", "duration_s", Some(13), ["nan", "a number", "finite"]),
        (SWARM, "duration_s = 60.0", "duration_s = inf", "duration_s", Some(13), ["inf", "a number", "finite"]),
        (SWARM, "duration_s = 60.0", "duration_s = 1e999", "duration_s", Some(13), ["1e999", "a number", "finite"]),
        (SWARM, "x_m = 3.0", "x_m = \"abc\"", "robot[1].start.x_m", Some(6), ["\"abc\"", "-10000..=10000", "quotes"]),
        (SWARM, "x_m = 3.0", "x_m = 1979-05-27", "robot[1].start.x_m", Some(6), ["the date", "a number", "number"]),
        (SWARM, "name = \"first\"", "name = \"a b\"", "name", Some(7), ["\"a b\"", "letters, digits", "name"]),
        (SWARM, "start = { x_m = 4.6", "start = 3 #", "robot[0].start", Some(8), ["3", "a table", "table"]),
        (SWARM, "rate_hz = 10.0", "group = \"10.0.0.1\"", "beacon.group", Some(8), ["10.0.0.1", "multicast", "239."]),
        (SWARM, "rate_hz = 10.0", "interface = \"lo\"", "beacon.interface", Some(12), ["lo", "IPv4", "127.0.0.1"]),
        (SWARM, "rate_hz = 10.0", "port = 80", "beacon.port", Some(7), ["80", "1024..=65535", "range"]),
        (SWARM, "loss = 0.02", "loss = true", "radio.loss", Some(7), ["true", "0..=1", "write a number"]),
        (
            SWARM,
            "kind = \"flock\"",
            "kind = \"flok\"",
            "behaviour.kind",
            Some(7),
            ["flok", "\"flock\"", "did you mean"],
        ),
        (
            ROOM,
            "enclosure = true",
            "enclosure = 1",
            "world.polygons[0].enclosure",
            Some(12),
            ["1", "true or false", ""],
        ),
        (ROOM, "radius_m = 1.2", "radius_m = 0", "world.circles[0].radius_m", Some(11), ["0", "0.001..=1000", ""]),
    ]);
}

#[test]
fn kinds_are_refused_where_their_own_file_is_wrong() {
    check(&[
        (
            ROVER,
            "scan_ms = 300",
            "scan_ms = 0",
            "kinds.rover_mavlink.timeouts.scan_ms",
            Some(10),
            ["0", "20..=2000", "0 would mean never"],
        ),
        (
            ROVER,
            "speed_mps_max = 1.5",
            "sped_mps_max = 1.5\nspeed_mps_max = 1.5",
            "kinds.rover_mavlink.motion.sped_mps_max",
            Some(0),
            ["unknown", "one of", "'speed_mps_max'"],
        ),
        (
            ROVER,
            "brake_mps2 = 1.5",
            "brake_mps2 = 0.05",
            "kinds.rover_mavlink.motion.speed_mps_max",
            None,
            ["stops within 23.7", "12 m", "lower speed_mps_max"],
        ),
        (
            ROVER,
            "rate_hz = 10.0",
            "rate_hz = 2.0",
            "kinds.rover_mavlink.timeouts.scan_ms",
            None,
            ["300", "at least one period of lidar.rate_hz, 500 ms", "raise it"],
        ),
        (
            ROVER,
            "telemetry_hz = 20",
            "telemetry_hz = 2",
            "kinds.rover_mavlink.timeouts.odometry_ms",
            None,
            ["300", "drive.telemetry_hz, 500 ms", "raise it"],
        ),
        (ROVER, "beams = 72", "beams = 73", "kinds.rover_mavlink.lidar.beams", Some(8), ["73", "8..=72", "bins"]),
        (
            ROVER,
            "component = 191",
            "component = 196",
            "kinds.rover_mavlink.lidar.link.component",
            None,
            ["196", "other than drive.component", "its own"],
        ),
        (
            ROVER,
            "track_m = 0.40",
            "track_m = 0.70",
            "kinds.rover_mavlink.body.track_m",
            Some(10),
            ["0.7", "2 * radius_m = 0.6", "wheels"],
        ),
    ]);
}

#[test]
fn parts_of_a_kind_that_do_not_go_together_are_refused() {
    check(&[
        (
            ROVER,
            "{ protocol = \"obstacle_distance\", component = 196 }",
            "{ protocol = \"dronecan\", node = 1 }",
            "kinds.rover_mavlink.lidar.link.protocol",
            Some(13),
            ["\"dronecan\"", "\"obstacle_distance\" with a mavlink drive", "autopilot's link"],
        ),
        (
            SCOUT,
            "{ protocol = \"dronecan\", node = 42, silent_is_clear = false }",
            "{ protocol = \"obstacle_distance\" }",
            "kinds.scout_mini.lidar.link.protocol",
            Some(13),
            ["\"obstacle_distance\"", "\"dronecan\" with an agilex_v2 drive", "CAN lidar"],
        ),
        (
            SCOUT,
            "\"scout_mini\"\n\n[motion]",
            "\"hunter\"\n\n[motion]",
            "kinds.scout_mini.drive.model",
            Some(0),
            ["hunter", "on the spot", "car"],
        ),
        (
            SCOUT,
            "speed_mps_max = 1.5",
            "speed_mps_max = 3.5",
            "kinds.scout_mini.motion.speed_mps_max",
            Some(16),
            ["3.5", "at most 3", "lower it"],
        ),
        (
            SCOUT,
            "yaw_rate_radps_max = 1.5",
            "yaw_rate_radps_max = 33",
            "kinds.scout_mini.motion.yaw_rate_radps_max",
            Some(21),
            ["33", "at most 32, which can be said", "lower it"],
        ),
        (
            SCOUT,
            "range_m_min = 0.2",
            "range_m_min = 0.7",
            "kinds.scout_mini.lidar.range_m_min",
            Some(14),
            ["0.7", "radius_m + margin_m = 0.670", "margin_m"],
        ),
        (SCOUT, "node = 42, ", "", "kinds.scout_mini.lidar.link.node", None, ["nothing", "1..=127", "add node"]),
        (SCOUT, "[sim]", "[simulation]", "kinds.scout_mini.simulation", Some(1), ["unknown", "one of", "remove it"]),
    ]);
}

#[test]
fn ids_and_links_that_collide_are_refused() {
    check(&[
        (SWARM, "id = 2", "id = 1", "robot[1].id", Some(5), ["1, which robot[0] has already", "its own", "change one"]),
        (SWARM, "id = 2", "id = 251", "robot[1].id", Some(5), ["251", "1..=250 for a MAVLink robot", "system id"]),
        (
            SWARM,
            "kind = \"scout_mini\"",
            "kind = \"scout_min\"",
            "robot[2].kind",
            Some(7),
            ["\"scout_min\"", "rover_mavlink, scout_mini", "did you mean \"scout_mini\"?"],
        ),
        (
            SWARM,
            "kind = \"scout_mini\"",
            "links.lidar = \"vcan4d\"\nkind = \"scout_mini\"",
            "robot[3].links.drive",
            None,
            ["CAN interface vcan4d robot[2].links.lidar has already", "its own", "another"],
        ),
        (
            SWARM,
            "rate_hz = 10.0",
            "port = 14602",
            "robot[1].links.autopilot",
            None,
            ["UDP port 14602 beacon.port has", "its own", "another"],
        ),
    ]);
}

#[test]
fn starts_that_are_not_on_free_floor_are_refused() {
    check(&[
        (
            SWARM,
            "{ x_m = 1.4, y_m = 6.0",
            "{ x_m = 3.0, y_m = 5.5",
            "robot[3].start",
            Some(0),
            ["0.500 m from robot[2]", "0.840", "move"],
        ),
        (
            SWARM,
            "{ x_m = 1.4, y_m = 6.0",
            "{ x_m = 0.3, y_m = 6.0",
            "robot[3].start",
            Some(0),
            ["0.300 m from polygons[0]", "0.42", "wall"],
        ),
        (
            SWARM,
            "{ x_m = 1.4, y_m = 6.0",
            "{ x_m = -4.0, y_m = 6.0",
            "robot[3].start",
            Some(0),
            ["outside of the enclosure", "free floor", "wall"],
        ),
        (
            SWARM,
            "{ x_m = 1.4, y_m = 6.0",
            "{ x_m = 7.0, y_m = 12.0",
            "robot[3].start",
            Some(0),
            ["inside polygons[1]", "free floor", "wall"],
        ),
        (
            SWARM,
            "{ x_m = 1.4, y_m = 6.0",
            "{ x_m = 23.0, y_m = 1.0",
            "robot[3].start",
            Some(0),
            ["inside circles[1]", "free floor", "wall"],
        ),
    ]);
}

#[test]
fn behaviours_that_do_not_fit_the_swarm_are_refused() {
    check(&[
        (SWARM, "leader = 1", "leader = 6", "behaviour.leader", Some(9), ["6", "1, 2, 3, 4, 5", "choose"]),
        (
            SWARM,
            "leader_speed_mps = 0.6",
            "leader_speed_mps = 2",
            "behaviour.leader_speed_mps",
            Some(19),
            ["2", "1.5", "lower"],
        ),
        (SWARM, "spacing_m = 1.8", "spacing_m = 0.8", "behaviour.spacing_m", Some(12), ["0.8", "0.84", "touch"]),
        (
            SWARM,
            "obstacle_range_m = 1.2",
            "obstacle_range_m = 13",
            "behaviour.obstacle_range_m",
            Some(19),
            ["13", "12", "seen"],
        ),
        (
            SWARM,
            "[10.5, 7.2]",
            "[13.0, 4.0]",
            "behaviour.waypoints_m[1]",
            Some(0),
            ["inside polygons[2]", "0.3 m of free floor", "wall"],
        ),
    ]);
}

#[test]
fn ways_that_are_no_ways_and_periods_that_clash_are_refused() {
    check(&[
        (
            SWARM,
            "[10.5, 7.2]",
            "[10.5]",
            "behaviour.waypoints_m[1]",
            Some(0),
            ["[10.5]", "a point [x, y]", "two finite"],
        ),
        (
            SWARM,
            "[10.5, 7.2]",
            "[10.5, nan]",
            "behaviour.waypoints_m[1]",
            Some(0),
            ["[10.5, nan]", "a point [x, y]", "finite"],
        ),
        (
            SWARM,
            "[[7.5, 5.2], [10.5, 7.2], [13.25, 9.2], [17.0, 9.8], [20.5, 9.5]]",
            "[]",
            "behaviour.waypoints_m",
            Some(0),
            ["a list of 0", "1..=10000 points", "add points"],
        ),
        (
            SWARM,
            "leader = 1",
            "gain = 1\ngain = 2\nleader = 1 #",
            "",
            None,
            ["gain = 2", "each key once", "remove one"],
        ),
        (
            SWARM,
            "seed = 1",
            "step_ms = 50\ntimeouts.tick_ms = 20",
            "step_ms",
            Some(10),
            ["50", "timeouts.tick_ms, 20", "lower"],
        ),
    ]);
}

#[test]
fn unsound_shapes_are_refused() {
    const BUTTRESS: &str = "[[6.5, 9.0], [8.0, 9.0], [8.0, 14.0], [6.5, 14.0]]";
    const KEY: &str = "world.polygons[1].points_m";
    check(&[
        (ROOM, BUTTRESS, "[[6.5, 9.0], [8.0, 9.0]]", KEY, Some(0), ["a list of 2", "3..=20000 points", "add points"]),
        (
            ROOM,
            BUTTRESS,
            "[[6.0, 9.0], [8.0, 14.0], [8.0, 9.0], [6.0, 14.0]]",
            KEY,
            Some(0),
            ["edges 0 and 2", "simple", "order"],
        ),
        (ROOM, BUTTRESS, "[[6.0, 9.0], [7.0, 9.0], [8.0, 9.0]]", KEY, Some(0), ["edges", "simple", "order"]),
        (
            ROOM,
            BUTTRESS,
            "[[6.0, 9.0], [6.0001, 9.0], [6.0, 9.0001]]",
            KEY,
            Some(0),
            ["an area of", "around an area", "check"],
        ),
        (
            ROOM,
            "[[polygons]] # a wedge",
            "[[polygons]]\nenclosure = true # a wedge",
            "world.polygons[4].enclosure",
            None,
            ["another enclosure", "at most one", "enclosure = false"],
        ),
    ]);
}

#[test]
fn everything_that_is_wrong_is_said_at_once_in_the_order_of_the_files() {
    let bench = Bench::new();
    bench.replace(SWARM, "seed = 1", "sead = 1");
    bench.replace(SWARM, "x_m = 3.0", "x_m = nan");
    bench.replace(SWARM, "id = 5", "id = 4");
    bench.replace(SWARM, "leader = 1", "leader = 9");
    bench.replace(SWARM, "jitter_ms = 3.0", "jitter_ms = ");
    bench.replace(ROVER, "scan_ms = 300", "scan_ms = 0");
    bench.replace(SCOUT, "node = 42", "node = 128");
    bench.replace(ROOM, "radius_m = 1.2", "radius_m = -1.2");
    bench.replace(ROOM, "[6.5, 9.0], [8.0, 9.0]", "[8.0, 9.0], [6.5, 9.0]");
    let problems = bench.problems();
    let keys: Vec<&str> = problems.iter().map(|problem| problem.key.as_str()).collect();
    let in_swarm = ["sead", "robot[1].start.x_m", "robot[4].id", "behaviour.leader", ""];
    let in_room = ["world.polygons[1].points_m", "world.circles[0].radius_m"];
    let in_kinds = ["kinds.rover_mavlink.timeouts.scan_ms", "kinds.scout_mini.lidar.link.node"];
    let all: Vec<&str> = in_swarm.into_iter().chain(in_room).chain(in_kinds).collect();
    assert_eq!(keys, all, "{problems:#?}");
    assert!(problems[4].expected.starts_with("TOML"));
}

#[test]
fn a_swarm_without_robots_says_so() {
    let bench = Bench::new();
    let text = std::fs::read_to_string(bench.path(SWARM)).expect("copied");
    let (head, rest) = text.split_once("[[robot]]").expect("robots");
    let (_, tail) = rest.split_once("[behaviour]").expect("a behaviour");
    std::fs::write(bench.path(SWARM), format!("{head}[behaviour]{tail}")).expect("written");
    let problems = bench.problems();
    let keys: Vec<&str> = problems.iter().map(|problem| problem.key.as_str()).collect();
    assert_eq!(keys, ["robot", "behaviour.leader"], "{problems:#?}");
    assert_eq!(problems[0].found, "no robot");
}

#[test]
fn a_wrong_protocol_does_not_make_its_neighbours_unknown() {
    let bench = Bench::new();
    bench.replace(ROVER, "protocol = \"mavlink\"", "protocol = \"mavlnk\"");
    let problems = bench.problems();
    let keys: Vec<&str> = problems.iter().map(|problem| problem.key.as_str()).collect();
    assert_eq!(keys, ["kinds.rover_mavlink.drive.protocol"], "{problems:#?}");
}

#[test]
fn a_file_that_is_named_and_cannot_be_read_is_said_where_it_is_named() {
    let bench = Bench::new();
    let (line, column) = bench.replace(SWARM, "\"../robots/scout_mini.toml\"", "\"../robots/none.toml\"");
    let problems = bench.problems();
    let [problem] = problems.as_slice() else { panic!("{problems:#?}") };
    assert_eq!((problem.line, problem.column), (Some(line), Some(column)));
    assert!(problem.found.contains("no readable file"), "{problem}");
    assert!(problem.advice.contains("none.toml"), "{problem}");
}

#[test]
fn a_robot_file_is_checked_like_a_swarm() {
    let bench = Bench::new();
    let swarm = load_swarm(&bench.path(SWARM), &[]).expect("good");
    let path = bench.path("robot.toml");
    let mut file = swarm.robot_file(3).expect("good");
    file.peers[1].id = 3;
    file.peers[2].id = 1;
    file.robot.kind = "rover".to_owned();
    file.kind.timeouts.link_ms = 0;
    file.beacon.rate_hz = f64::NAN;
    std::fs::write(&path, file.to_toml()).expect("written");
    let problems = load_robot(&path, &[]).expect_err("refused").0;
    let mut keys: Vec<&str> = problems.iter().map(|problem| problem.key.as_str()).collect();
    keys.sort_unstable();
    assert_eq!(keys, ["beacon.rate_hz", "kind.timeouts.link_ms", "peers[1].id", "peers[2].id", "robot.kind"]);
}

#[test]
fn what_is_no_configuration_says_so() {
    let bench = Bench::new();
    let problems = |name: &str, bytes: &[u8]| {
        std::fs::write(bench.path(name), bytes).expect("written");
        check_file(&bench.path(name)).expect_err("refused").to_string()
    };
    assert!(problems("empty.toml", b"").contains("none of Drover's tables"));
    assert!(problems("other.toml", b"[package]\nname = \"x\"\n").contains("none of Drover's tables"));
    let binary = problems("binary.toml", b"name = \"a\"\n\xFF\xFE");
    assert!(binary.contains("not UTF-8 (first at byte 11, in line 2)"), "{binary}");
    assert!(check_file(bench.folder.path()).expect_err("a folder").to_string().contains("found a folder"));
    assert!(check_file(Path::new("/dev/zero")).expect_err("a device").to_string().contains("a device or pipe"));
    let huge = problems("huge.toml", &b"# filler\n".repeat(4_000_000));
    assert!(huge.contains("a file of 36000000 bytes; allowed: at most 33554432 bytes"), "{huge}");
    let full = problems("full.toml", &b"a = [1,1,1,1]\n".repeat(700_000));
    assert!(full.contains("too many values; allowed: at most 4000000"), "{full}");
}
