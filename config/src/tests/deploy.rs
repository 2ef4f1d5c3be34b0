//! Deployment: the paper's scenes, what a mode stands for, who goes where, and what cannot be.

use super::{good, shipped};
use crate::crowd::parted;
use crate::{
    Assignment, Behaviour, Deploy, DeployGuard, DeployMode, Exchange, KeptLinks, Override, Problem, Robot, Swarm,
    load_robot, load_swarm,
};
use std::path::PathBuf;

/// The shipped swarms that deploy.
const SWARMS: [&str; 8] = [
    "deploy_exp1",
    "deploy_exp2",
    "deploy_exp3_row",
    "deploy_exp3_random",
    "deploy_lossy",
    "deploy_pocket",
    "deploy_field",
    "deploy_pockets",
];

fn path(name: &str) -> PathBuf {
    shipped(&format!("swarms/{name}.toml"))
}

fn sets(sets: &[&str]) -> Vec<Override> {
    sets.iter().map(|set| Override::parse(set).expect("a key and a value")).collect()
}

fn swarm(name: &str, changes: &[&str]) -> Swarm {
    load_swarm(&path(name), &sets(changes)).unwrap_or_else(|problems| panic!("{name} {changes:?}: {problems}"))
}

fn deploy(swarm: &Swarm) -> &Deploy {
    let Behaviour::Deploy(deploy) = &swarm.behaviour else { panic!("{} deploys", swarm.name) };
    deploy
}

/// `robot=[...]`: points with these ids at these places.
fn points(robots: &[(u32, [f64; 2])]) -> String {
    let robot = |(id, [x_m, y_m]): &(u32, [f64; 2])| {
        format!("{{ id = {id}, kind = \"point\", start = {{ x_m = {x_m}, y_m = {y_m} }} }}")
    };
    format!("robot=[{}]", robots.iter().map(robot).collect::<Vec<_>>().join(", "))
}

/// `behaviour={...}` for five robots of the good swarm.
fn in_the_room(more: &str) -> String {
    let layout = "{ origin_m = [16, 8], columns = 5, rows = 1, spacing_m = 1.2 }";
    format!("behaviour={{ kind = \"deploy\", layout = {layout}, {more} }}")
}

fn place(robot: &Robot) -> [f64; 2] {
    [robot.start.x_m, robot.start.y_m]
}

fn gap_m(a: [f64; 2], b: [f64; 2]) -> f64 {
    libm::hypot(a[0] - b[0], a[1] - b[1])
}

/// Whether the places of `robots` less `offset` are those of a lattice, rows of `columns` first.
fn is_lattice(robots: &[Robot], origin: [f64; 2], columns: usize, spacing_m: f64) -> bool {
    robots.iter().enumerate().all(|(index, robot)| {
        let (x, y) = ((index % columns) as f64, (index / columns) as f64);
        gap_m(place(robot), [origin[0] + x * spacing_m, origin[1] + y * spacing_m]) < 1e-9
    })
}

#[test]
fn the_paper_s_scenes_start_and_end_where_it_says() {
    let rows = [
        ("deploy_exp1", [4.0, 5.0], (10, 10, 2.5), ([70.0, 32.5], [70.0, 55.0])),
        ("deploy_exp3_row", [4.0, 4.0], (40, 10, 2.2), ([60.0, 35.0], [72.0, 56.0])),
    ];
    for (name, origin, (count, columns, spacing_m), (first, last)) in rows {
        let mut offsets = Vec::new();
        for seed in 0..50 {
            let swarm = swarm(name, &[&format!("seed={seed}"), "behaviour.assignment=given"]);
            let start = place(&swarm.robots[0]);
            let offset = [start[0] - origin[0], start[1] - origin[1]];
            assert!(offset.iter().all(|offset| (-1.0..=3.0).contains(offset)), "{name} {seed}: {offset:?}");
            assert!(swarm.robots.len() == count && is_lattice(&swarm.robots, start, columns, spacing_m), "{name}");
            let targets = &deploy(&swarm).targets_m;
            assert_eq!((targets.len(), targets[0], targets[count - 1]), (count, first, last));
            offsets.push(offset);
        }
        let spread = |axis: usize| {
            let values = || offsets.iter().map(|offset| offset[axis]);
            values().fold(f64::NEG_INFINITY, f64::max) - values().fold(f64::INFINITY, f64::min)
        };
        assert!(spread(0) > 3.0 && spread(1) > 3.0, "{name}: offsets of 4 m are drawn");
    }
    // Without an offset it is the paper's own row.
    let unmoved = "fleet=[{ kind = \"point\", count = 10, region_m = [[3.5, 4.5], [27.0, 5.5]], spacing_m = 2.5 }]";
    assert!(is_lattice(&swarm("deploy_exp1", &[unmoved]).robots, [4.0, 5.0], 10, 2.5));
}

#[test]
fn random_starts_are_apart_in_their_region_and_one_network_for_every_seed() {
    let rows = [
        ("deploy_exp2", 100, [[3.0, 15.0], [27.0, 45.0]]),
        ("deploy_exp3_random", 40, [[2.0, 2.0], [24.0, 20.0]]),
        ("deploy_field", 40, [[3.0, 20.0], [20.0, 40.0]]),
        ("deploy_pocket", 12, [[4.0, 14.0], [14.0, 26.0]]),
        ("deploy_pockets", 12, [[4.0, 16.0], [14.0, 28.0]]),
    ];
    for (name, count, [low, high]) in rows {
        for seed in 0..100 {
            let swarm = swarm(name, &[&format!("seed={seed}"), "behaviour.assignment=given"]);
            let places: Vec<[f64; 2]> = swarm.robots.iter().map(place).collect();
            assert_eq!(places.len(), count);
            for (index, place) in places.iter().enumerate() {
                assert!((0..2).all(|axis| (low[axis]..=high[axis]).contains(&place[axis])), "{name} {seed}: {place:?}");
                let nearest_m = places[..index].iter().map(|other| gap_m(*place, *other)).fold(f64::INFINITY, f64::min);
                assert!(nearest_m >= 1.3 && (index == 0 || nearest_m <= 6.5), "{name} {seed}: {nearest_m}");
            }
            assert_eq!(parted(&places, 6.5), None, "{name} {seed}");
        }
    }
}

#[test]
fn every_seed_makes_a_field_and_a_pocket_that_go_with_start_and_layout() {
    let mut counts = [0_usize; 11];
    for seed in 0..1_000 {
        let given = [&*format!("seed={seed}"), "behaviour.assignment=given"];
        let field = swarm("deploy_field", &given);
        let obstacles: Vec<_> = field.world.polygons.iter().filter(|polygon| !polygon.enclosure).collect();
        counts[obstacles.len()] += 1;
        let corners = obstacles.iter().flat_map(|polygon| &polygon.points_m);
        assert!(corners.into_iter().all(|[x, y]| (22.0..=62.0).contains(x) && (3.0..=57.0).contains(y)), "{seed}");
        let pockets = swarm("deploy_pockets", &given);
        let [_, pocket] = pockets.world.polygons.as_slice() else { panic!("an enclosure and a pocket") };
        // The inner corners at the bottom lie to the east of the arms' ends: it opens to where robots start.
        let [south_m, north_m] =
            [(6, 7), (5, 4)].map(|(inner, end)| pocket.points_m[inner][0] - pocket.points_m[end][0]);
        assert!(south_m >= 4.0 && north_m >= 4.0, "{seed}: {pocket:?}");
        assert!(pocket.points_m.iter().all(|[x, y]| (17.0..=47.0).contains(x) && (3.0..=41.0).contains(y)), "{seed}");
    }
    assert!(counts[6..=10].iter().all(|count| *count > 100) && counts.iter().sum::<usize>() == 1_000, "{counts:?}");
}

#[test]
fn the_mode_says_whose_defaults_count_and_every_key_can_be_set() {
    let safe = swarm("deploy_exp1", &[]);
    let safe = deploy(&safe);
    assert_eq!((safe.mode, safe.links, safe.hops), (DeployMode::Safe, KeptLinks::Lmst, 0));
    assert_eq!((safe.assignment, safe.guard, safe.follow), (Assignment::Hungarian, DeployGuard::Full, true));
    let literal = swarm("deploy_exp1", &["behaviour.mode=literal"]);
    let literal = deploy(&literal);
    assert_eq!((literal.mode, literal.links, literal.hops), (DeployMode::Literal, KeptLinks::Rng, 1));
    assert_eq!((literal.assignment, literal.guard, literal.follow), (Assignment::Given, DeployGuard::None, false));
    let same = |deploy: &Deploy| {
        (deploy.exchange, deploy.rotation, deploy.forces, deploy.steer, deploy.escape, deploy.view_rad.to_bits())
    };
    assert_eq!(same(safe), same(literal));
    let mixed = swarm("deploy_exp1", &["behaviour.mode=literal", "behaviour.guard=collision", "behaviour.hops=3"]);
    let mixed = deploy(&mixed);
    assert_eq!((mixed.guard, mixed.hops, mixed.links), (DeployGuard::Collision, 3, KeptLinks::Rng));
    let lossy = swarm("deploy_lossy", &[]);
    assert_eq!(deploy(&lossy).exchange, Exchange::Beacons);
    assert!((lossy.radio.loss - 0.3).abs() < 1e-12 && lossy.radio.delay_ms + lossy.radio.jitter_ms <= 300.0);
}

#[test]
fn targets_are_in_the_order_of_ids_and_ways_are_short() {
    // Robot 9 stands in the south and robot 2 in the north; the targets are listed from south to north.
    let robots = points(&[(9, [0.0, 0.0]), (2, [0.0, 5.0])]);
    let targets = |change: &str| {
        let listed = "behaviour={ kind = \"deploy\", targets_m = [[70, 40], [70, 45], [70, 50]] }";
        deploy(&swarm("deploy_exp1", &["fleet=[]", &robots, listed, change])).targets_m.clone()
    };
    assert_eq!(targets("behaviour.assignment=given"), [[70.0, 40.0], [70.0, 45.0], [70.0, 50.0]]);
    assert_eq!(targets("behaviour.assignment=hungarian"), [[70.0, 45.0], [70.0, 40.0], [70.0, 50.0]]);
    for name in SWARMS {
        let cost = |change: &str| {
            let swarm = swarm(name, &[change]);
            let pairs = swarm.robots.iter().zip(&deploy(&swarm).targets_m);
            pairs.map(|(robot, target)| gap_m(place(robot), *target) * gap_m(place(robot), *target)).sum::<f64>()
        };
        assert!(cost("behaviour.assignment=hungarian") <= cost("behaviour.assignment=given") + 1e-3, "{name}");
    }
}

#[test]
fn what_was_assigned_is_written_and_read_again_and_robots_do_not_assign_it_anew() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("resolved.toml");
    for name in SWARMS {
        let swarm = swarm(name, &[]);
        std::fs::write(&path, swarm.to_toml()).expect("written");
        assert!(load_swarm(&path, &[]).is_ok_and(|again| again == swarm), "{name}");
        let file = swarm.robot_file(2).expect("its robot");
        let Behaviour::Deploy(own) = &file.behaviour else { panic!("{name} deploys") };
        assert_eq!((own.assignment, &own.targets_m), (Assignment::Given, &deploy(&swarm).targets_m));
        std::fs::write(&path, file.to_toml()).expect("written");
        assert_eq!(load_robot(&path, &[]).map_err(|problems| problems.to_string()), Ok(file));
    }
}

#[test]
fn robots_with_bodies_deploy_over_beacons() {
    let changes = sets(&[&in_the_room("exchange = \"beacons\"")]);
    let swarm = load_swarm(&good("swarms/first.toml"), &changes).unwrap_or_else(|problems| panic!("{problems}"));
    assert!(deploy(&swarm).exchange == Exchange::Beacons && swarm.robots.len() == 5);
}

/// The one problem of a swarm with changes.
fn refused(path: PathBuf, changes: &[&str]) -> Problem {
    let problems = load_swarm(&path, &sets(changes)).expect_err("refused").0;
    let [problem] = problems.try_into().unwrap_or_else(|all: Vec<_>| panic!("{changes:?}: one problem, not {all:#?}"));
    problem
}

fn check(problem: &Problem, key: &str, [found, allowed, advice]: [&str; 3]) {
    assert_eq!(problem.key, key, "{problem}");
    assert!(problem.found.contains(found), "{found:?} in: {problem}");
    assert!(problem.expected.contains(allowed), "{allowed:?} in: {problem}");
    assert!(problem.advice.contains(advice), "{advice:?} in: {problem}");
}

/// A change to the paper's first scene, the key of `[behaviour]` that is wrong, and words of found, allowed and advice.
type Row = (&'static str, &'static str, [&'static str; 3]);

fn check_rows(rows: &[Row]) {
    for (change, key, words) in rows {
        check(&refused(path("deploy_exp1"), &[change]), &format!("behaviour.{key}"), *words);
    }
}

#[test]
fn single_keys_are_refused() {
    check_rows(&[
        ("behaviour.mode=save", "mode", ["save", "\"safe\", \"literal\"", "did you mean \"safe\"?"]),
        ("behaviour.links=mst", "links", ["mst", "\"lmst\", \"rng\", \"all\"", "did you mean \"lmst\"?"]),
        ("behaviour.hops=17", "hops", ["17", "0..=16", "range"]),
        ("behaviour.guard=all", "guard", ["all", "\"full\", \"collision\", \"none\"", "choose"]),
        ("behaviour.follow=yes", "follow", ["yes", "true or false", "without quotes"]),
        ("behaviour.period_s=0", "period_s", ["0", "0.05..=60", "range"]),
        ("behaviour.view_rad=0", "view_rad", ["0", "0.01..=3.14", "range"]),
        ("behaviour.robot_gap_m=-1", "robot_gap_m", ["-1", "0..=100", "range"]),
        ("behaviour.arrive_m=nan", "arrive_m", ["nan", "0.01..=100", "finite"]),
        ("behaviour.peer_lost_s=0", "peer_lost_s", ["0", "0.1..=3600", "range"]),
        ("behaviour.leader=1", "leader", ["unknown key", "targets_m", "remove it"]),
        ("behaviour.hop=1", "hop", ["unknown key", "hops", "did you mean 'hops'?"]),
    ]);
}

#[test]
fn numbers_that_do_not_go_together_are_refused() {
    check_rows(&[
        ("behaviour.goal_gain=2", "goal_gain", ["2", "less than 2 / period_s = 2", "overleap"]),
        ("behaviour.period_s=4", "range_m", ["7", "more than 4 speed_mps period_s = 8", "raise it"]),
        ("behaviour.avoid_m_min=1.2", "avoid_m_min", ["1.2", "less than d_a", "raise epsilon_m"]),
        ("behaviour.speed_mps=0.6", "speed_mps", ["0.6", "0.5 of \"point\"", "lower it"]),
    ]);
    let gap = refused(path("deploy_exp1"), &["behaviour.range_m=3", "behaviour.robot_gap_m=2.4"]);
    check(&gap, "behaviour.robot_gap_m", ["2.4", "range_m - 2 speed_mps period_s = 2", "lower"]);
    let radio = refused(path("deploy_lossy"), &["radio.range_m=6"]);
    check(&radio, "behaviour.range_m", ["7", "at most radio.range_m, 6", "raise radio.range_m"]);
    let beacon = refused(path("deploy_lossy"), &["beacon.rate_hz=5", "behaviour.peer_lost_s=0.1"]);
    assert_eq!(beacon.key, "behaviour.peer_lost_s");
    let map = refused(path("deploy_lossy"), &["behaviour.escape=geodesic"]);
    check(&map, "behaviour.escape", ["a known map", "exchange = \"beacons\"", "leave it out"]);
    let guard = refused(path("deploy_lossy"), &["behaviour.guard=collision"]);
    check(&guard, "behaviour.guard", ["another guard", "exchange = \"beacons\"", "leave it out"]);
}

#[test]
fn layouts_that_cannot_be_are_refused() {
    let lattice = |origin: &str, more: &str| format!("behaviour.layout={{ origin_m = {origin}, {more} }}");
    let cases = [
        (lattice("[70, 30]", "columns = 1, rows = 9, spacing_m = 2.5"), ["9 targets", "each of 10 robots", "add"]),
        (
            lattice("[70, 30]", "columns = 1, rows = 10, spacing_m = 0.2"),
            ["[70, 30.2], 0.200 m to another target", "at least 0.3 m", "move them apart"],
        ),
        (
            lattice("[70, 30]", "columns = 1, rows = 10, spacing_m = 8"),
            ["[70, 38], 8.000 m to the nearest", "links up to range_m = 7 m", "nearer"],
        ),
        (
            lattice("[43.75, 20]", "columns = 1, rows = 10, spacing_m = 2"),
            ["[43.75, 24], 0.250 m from polygons[0]", "0.3 m of free floor", "lower wall_gap_m"],
        ),
        (lattice("[45, 25]", "columns = 2, rows = 5, spacing_m = 1"), ["[45, 25], inside polygons[0]", "0.3 m", ""]),
    ];
    for (change, words) in cases {
        check(&refused(path("deploy_exp1"), &[&change]), "behaviour.layout", words);
    }
    let most = refused(path("deploy_exp1"), &[&lattice("[0, 0]", "columns = 1000, rows = 11, spacing_m = 1")]);
    check(&most, "behaviour.layout.rows", ["11, which makes 11000", "at most 10000 targets", "lower"]);
    let far = refused(path("deploy_exp1"), &[&lattice("[9990, 0]", "columns = 10, rows = 1, spacing_m = 2")]);
    check(&far, "behaviour.layout.spacing_m", ["[10008, 0]", "up to 10000", "origin_m"]);
    let many = refused(path("deploy_exp1"), &[&lattice("[70, 100]", "columns = 101, rows = 10, spacing_m = 1")]);
    check(&many, "behaviour.assignment", ["1010 targets", "at most 1000", "\"given\""]);
    let both = refused(path("deploy_exp1"), &["behaviour.targets_m=[[1, 1]]"]);
    check(&both, "behaviour.layout", ["beside targets_m", "one of the two", "remove"]);
    let none = refused(path("deploy_exp1"), &["behaviour={ kind = \"deploy\" }"]);
    check(&none, "behaviour.targets_m", ["nothing", "or layout", "add targets_m"]);
    let column: String = (40..49).map(|y_m| format!("[60, {y_m}], ")).collect();
    let listed = format!("behaviour={{ kind = \"deploy\", targets_m = [{column}[51.9, 40]] }}");
    let listed = refused(path("deploy_exp1"), &[&listed]);
    check(&listed, "behaviour.targets_m[9]", ["[51.9, 40], 8.100 m to the nearest", "range_m = 7", "nearer"]);
}

#[test]
fn a_network_that_is_parted_at_its_start_is_refused() {
    let fleet = "fleet=[{ kind = \"point\", count = 10, region_m = [[0, 0], [80, 1]], spacing_m = 7.5 }]";
    let problem = refused(path("deploy_exp1"), &[fleet]);
    let words = ["robot 2 is 7.500 m from robot 1, the nearest", "range_m = 7", "linked_m"];
    check(&problem, "fleet[0].region_m", words);
    let alone = points(&[(11, [1.0, 20.0])]);
    let problem = refused(path("deploy_exp1"), &[&alone, "behaviour.layout.rows=11"]);
    assert!(problem.found.contains("parted at the start: robot 1 is"), "{problem}");
    let problem = refused(path("deploy_exp1"), &["fleet=[]", &points(&[(1, [1.0, 0.0]), (2, [9.0, 0.0])])]);
    check(&problem, "robot[1].start", ["robot 2 is 8.000 m from robot 1", "range_m = 7", "nearer"]);
}

#[test]
fn of_more_targets_than_robots_those_that_are_gone_to_must_be_one_network() {
    // Each robot is nearest to one end of a row whose middle nobody goes to.
    let robots = points(&[(1, [0.0, 80.0]), (2, [6.0, 80.0])]);
    let row = |spacing_m: &str| {
        format!("behaviour.layout={{ origin_m = [-2, 80], columns = 3, rows = 1, spacing_m = {spacing_m} }}")
    };
    let near = sets(&["fleet=[]", &robots, &row("3")]);
    assert!(load_swarm(&path("deploy_exp1"), &near).is_ok());
    let problem = refused(path("deploy_exp1"), &["fleet=[]", &robots, &row("5")]);
    let words = ["gone to are parted: [8, 80] is 10.000 m", "2 robots", "leave targets out"];
    check(&problem, "behaviour.layout", words);
}

#[test]
fn the_paper_as_printed_and_snapshots_are_for_points() {
    let problems = |more: &str| load_swarm(&good("swarms/first.toml"), &sets(&[&in_the_room(more)])).expect_err("no").0;
    let literal = problems("mode = \"literal\", exchange = \"beacons\"");
    assert_eq!(literal.len(), 3, "one for each kind, and one for the beacons");
    let mode = literal.iter().find(|problem| problem.key == "behaviour.mode").expect("said of each kind");
    check(mode, "behaviour.mode", ["\"rover_mavlink\", a kind that is no point", "simulated points", "walls"]);
    let snapshot = problems("exchange = \"snapshot\"");
    check(&snapshot[1], "behaviour.exchange", ["\"scout_mini\"", "\"beacons\"", "hears"]);
}

#[test]
fn a_robot_s_own_file_is_held_against_the_same_rules() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("robot.toml");
    let file = swarm("deploy_exp1", &[]).robot_file(3).expect("its robot");
    std::fs::write(&path, file.to_toml()).expect("written");
    let problem = |change: &str| {
        let problems = load_robot(&path, &sets(&[change])).expect_err("refused").0;
        let [problem] = problems.try_into().unwrap_or_else(|all: Vec<_>| panic!("one problem, not {all:#?}"));
        problem
    };
    let words = ["\"hungarian\"", "does not know where its peers start", "write assignment = \"given\""];
    check(&problem("behaviour.assignment=hungarian"), "behaviour.assignment", words);
    check(&problem("behaviour.speed_mps=0.6"), "behaviour.speed_mps", ["0.6", "0.5 of \"point\"", "lower it"]);
    let words = ["1 targets", "each of 10 robots", "add targets"];
    check(&problem("behaviour.targets_m=[[70, 40]]"), "behaviour.targets_m", words);
    check(&problem("kind.sim.motion=diff_drive"), "behaviour.exchange", ["\"snapshot\"", "\"beacons\"", "hears"]);
}
