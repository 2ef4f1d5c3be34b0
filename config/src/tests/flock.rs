//! Flocking: what a mode stands for, parties, and what cannot be.

use super::good;
use crate::{
    Avoidance, Behaviour, Flock, FlockGuard, FlockMode, LeaderLoss, LeaderWay, Override, Party, Problem, Problems,
    Swarm, WallFollowing, load_robot, load_swarm,
};

/// Both kinds of the good swarm become points.
const POINTS: [&str; 2] = ["kinds.rover_mavlink.sim.motion=point", "kinds.scout_mini.sim.motion=point"];
const LITERAL: &str = "behaviour.mode=literal";

fn load(changes: &[&str]) -> Result<Swarm, Problems> {
    let sets: Vec<Override> = changes.iter().map(|set| Override::parse(set).expect("a key and a value")).collect();
    load_swarm(&good("swarms/first.toml"), &sets)
}

fn flock_of(behaviour: &Behaviour) -> &Flock {
    let Behaviour::Flock(flock) = behaviour else { panic!("a flock") };
    flock
}

fn flock(changes: &[&str]) -> Flock {
    let swarm = load(changes).unwrap_or_else(|problems| panic!("{changes:?}: {problems}"));
    flock_of(&swarm.behaviour).clone()
}

/// The same of points.
fn of_points(changes: &[&str]) -> Flock {
    flock(&[&POINTS, changes].concat())
}

/// `behaviour={...}` with these parties: leader, first and last id, and a point.
fn parties(parties: &[(u32, u32, u32, [f64; 2])]) -> String {
    let party = |(leader, first_id, last_id, [x_m, y_m]): &(u32, u32, u32, [f64; 2])| {
        format!("{{ leader = {leader}, first_id = {first_id}, last_id = {last_id}, waypoints_m = [[{x_m}, {y_m}]] }}")
    };
    let parties: Vec<String> = parties.iter().map(party).collect();
    format!("behaviour={{ kind = \"flock\", party = [{}] }}", parties.join(", "))
}

/// Robots 1 and 2, and 3 to 5.
const TWO: [(u32, u32, u32, [f64; 2]); 2] = [(1, 1, 2, [20.5, 9.5]), (4, 3, 5, [1.5, 4.0])];

#[test]
fn the_mode_says_whose_defaults_count_and_every_key_can_be_set() {
    let bare = "behaviour={ kind = \"flock\", leader = 1, waypoints_m = [[20.5, 9.5]] }";
    let safe = flock(&[bare]);
    let parties = vec![Party::of_all(1, vec![[20.5, 9.5]])];
    let expected = Flock {
        mode: FlockMode::Safe,
        parties,
        leader_speed_mps: 0.8,
        waypoint_radius_m: 0.5,
        arrive_radius_m: 4.0,
        speed_mps: 10.0,
        turn_radps: std::f64::consts::PI,
        spacing_m: 1.8,
        gain: 0.3,
        obstacle_range_m: 1.2,
        head_offset_m: 0.3,
        damping_per_s: 1.0,
        mass_kg: 0.5,
        inertia_kgm2: 0.0225,
        wall_speed_mps: 0.6,
        wall_turn_radps: std::f64::consts::PI,
        wall_distance_m: 0.0,
        avoid_m: 1.4,
        deadlock_mps: 0.05,
        deadlock_s: 1.0,
        period_s: 0.01,
        reverse: false,
        laser_rad: std::f64::consts::TAU,
        walls: WallFollowing::Pledge,
        side_latch: true,
        right_of_way: true,
        trail: true,
        lose_nobody: false,
        leader_way: LeaderWay::Pursuit,
        guard: FlockGuard::Collision,
        avoidance: Avoidance::Voronoi,
        link_range_m: 0.0,
        solid: true,
        leader_loss: LeaderLoss::Stop,
    };
    assert_eq!(safe, expected);
    let literal = Flock {
        mode: FlockMode::Literal,
        turn_radps: std::f64::consts::PI / 10.0,
        wall_turn_radps: 26.2,
        deadlock_s: 0.1,
        reverse: true,
        laser_rad: std::f64::consts::PI,
        walls: WallFollowing::Literal,
        side_latch: false,
        right_of_way: false,
        trail: false,
        guard: FlockGuard::None,
        ..expected
    };
    assert_eq!(of_points(&[bare, LITERAL]), literal);
}

#[test]
fn every_key_can_be_set_by_itself() {
    let flock = of_points(&[
        LITERAL,
        "behaviour.guard=full",
        "behaviour.link_range_m=4",
        "behaviour.walls=none",
        "behaviour.reverse=false",
        "behaviour.avoidance=orca",
        "behaviour.leader_way=potential",
        "behaviour.leader_loss=elect",
        "behaviour.lose_nobody=true",
        "behaviour.solid=false",
    ]);
    let words = (flock.guard, flock.walls, flock.avoidance, flock.leader_way, flock.leader_loss);
    let (guard, walls) = (FlockGuard::Full, WallFollowing::None);
    assert_eq!(words, (guard, walls, Avoidance::Orca, LeaderWay::Potential, LeaderLoss::Elect));
    assert!(!flock.reverse && flock.lose_nobody && !flock.solid && !flock.side_latch);
    assert!((flock.link_range_m - 4.0).abs() < 1e-12 && (flock.deadlock_s - 0.1).abs() < 1e-12);
}

#[test]
fn turning_along_a_wall_follows_from_turning_unless_the_paper_s_counts() {
    let turn = |flock: Flock| (flock.wall_turn_radps * 10.0).round() / 10.0;
    assert!((turn(flock(&["behaviour.turn_radps=3"])) - 3.0).abs() < 1e-12);
    assert!((turn(of_points(&["behaviour.turn_radps=3", LITERAL])) - 26.2).abs() < 1e-12);
    assert!((turn(of_points(&["behaviour.wall_turn_radps=5", LITERAL])) - 5.0).abs() < 1e-12);
}

#[test]
fn the_paper_s_own_robots_of_a_centimetre_are_possible() {
    let kind = |key: &str| format!("kinds.rover_mavlink.{key}");
    let sets = [
        "body={ radius_m = 0.01, track_m = 0.015 }",
        "motion.margin_m=0.001",
        "motion.yaw_rate_radps_max=200",
        "motion.yaw_accel_radps2_max=10000",
        "lidar.range_m_min=0.001",
        "sim.motion=point",
    ];
    let sets = sets.map(kind);
    let behaviour = "behaviour={ kind = \"flock\", mode = \"literal\", leader = 1, waypoints_m = [[10, 7]], \
                     spacing_m = 0.1, obstacle_range_m = 0.05, head_offset_m = 0.002, gain = 0.001, mass_kg = 0.1, \
                     leader_speed_mps = 0.05, inertia_kgm2 = 2e-7, waypoint_radius_m = 0.02, arrive_radius_m = 0.2 }";
    let fleet = "fleet=[{ kind = \"rover_mavlink\", count = 30, region_m = [[1, 6], [2, 7]], spacing_m = 0.03 }]";
    let changes: Vec<&str> = sets.iter().map(String::as_str).chain(["robot=[]", fleet, behaviour]).collect();
    let swarm = load(&changes).unwrap_or_else(|problems| panic!("{problems}"));
    assert!(swarm.robots.len() == 30 && (flock_of(&swarm.behaviour).inertia_kgm2 - 2e-7).abs() < 1e-15);
}

#[test]
fn each_robot_has_one_party_and_one_end() {
    let all = flock(&[]);
    assert!((1..=5).all(|id| all.party_of(id).is_some_and(|party| party.leader == 1)));
    let two = flock(&[&parties(&TWO)]);
    let leaders: Vec<u32> = (1..=5).filter_map(|id| Some(two.party_of(id)?.leader)).collect();
    assert_eq!(leaders, [1, 1, 4, 4, 4]);
    assert_eq!(two.party_of(6), None);
    assert_eq!(two.parties.iter().map(Party::end_m).collect::<Vec<_>>(), [[20.5, 9.5], [1.5, 4.0]]);
}

#[test]
fn parties_and_both_modes_are_written_and_read_again() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("resolved.toml");
    let literal = [POINTS[0], POINTS[1], LITERAL];
    for changes in [&[&*parties(&TWO)][..], &[], &literal] {
        let swarm = load(changes).unwrap_or_else(|problems| panic!("{problems}"));
        std::fs::write(&path, swarm.to_toml()).expect("written");
        assert_eq!(load_swarm(&path, &[]).map_err(|problems| problems.to_string()), Ok(swarm.clone()));
        let file = swarm.robot_file(4).expect("its robot");
        std::fs::write(&path, file.to_toml()).expect("written");
        assert_eq!(load_robot(&path, &[]).map_err(|problems| problems.to_string()), Ok(file));
    }
}

/// All problems of the good swarm with changes.
fn refused(changes: &[&str]) -> Vec<Problem> {
    load(changes).expect_err("refused").0
}

/// A problem's key in `[behaviour]`, and words of found, allowed and advice.
type Row = (&'static str, [&'static str; 3]);

fn check(changes: &[&str], rows: &[Row]) {
    let problems = refused(changes);
    assert_eq!(problems.len(), rows.len(), "{changes:?}: {problems:#?}");
    for (problem, (key, [found, allowed, advice])) in problems.iter().zip(rows) {
        assert_eq!(problem.key, format!("behaviour.{key}").trim_end_matches('.'), "{problem}");
        assert!(problem.found.contains(found), "{found:?} in: {problem}");
        assert!(problem.expected.contains(allowed), "{allowed:?} in: {problem}");
        assert!(problem.advice.contains(advice), "{advice:?} in: {problem}");
    }
}

#[test]
fn single_keys_are_refused() {
    let rows = [
        ("behaviour.mode=save", ("mode", ["save", "\"safe\", \"literal\"", "did you mean \"safe\"?"])),
        ("behaviour.walls=pledg", ("walls", ["pledg", "\"pledge\", \"literal\", \"none\"", "\"pledge\"?"])),
        ("behaviour.guard=all", ("guard", ["all", "\"collision\", \"full\", \"none\"", "choose"])),
        ("behaviour.avoidance=orka", ("avoidance", ["orka", "\"voronoi\", \"orca\"", "\"orca\"?"])),
        ("behaviour.leader_way=", ("leader_way", ["\"\"", "\"pursuit\", \"potential\"", "choose"])),
        ("behaviour.leader_loss=1", ("leader_loss", ["1", "\"stop\", \"elect\"", "choose"])),
        ("behaviour.reverse=yes", ("reverse", ["yes", "true or false", "without quotes"])),
        ("behaviour.speed_mps=0", ("speed_mps", ["0", "0.001..=10", "range"])),
        ("behaviour.turn_radps=201", ("turn_radps", ["201", "0.01..=200", "range"])),
        ("behaviour.wall_turn_radps=nan", ("wall_turn_radps", ["nan", "0.01..=200", "finite"])),
        ("behaviour.laser_rad=7", ("laser_rad", ["7", "0.1..=6.28", "range"])),
        ("behaviour.period_s=0", ("period_s", ["0", "0.005..=1", "range"])),
        ("behaviour.deadlock_s=0", ("deadlock_s", ["0", "0.01..=60", "range"])),
        ("behaviour.wall_distance_m=-1", ("wall_distance_m", ["-1", "0..=100", "range"])),
        ("behaviour.spacing_m=0.001", ("spacing_m", ["0.001", "0.01..=100", "range"])),
        ("behaviour.leder=1", ("leder", ["unknown key", "leader", "did you mean 'leader'?"])),
        ("behaviour.targets_m=[]", ("targets_m", ["unknown key", "waypoints_m", "remove it"])),
    ];
    for (change, row) in rows {
        check(&[change], &[row]);
    }
}

#[test]
fn a_leader_and_its_way_or_parties_but_not_both_and_not_neither() {
    let beside = ["parties beside a leader or waypoints_m", "one of the two", "remove leader and waypoints_m"];
    check(&["behaviour.party=[]"], &[("party", beside)]);
    let party = "party = [{ leader = 1, first_id = 1, last_id = 5, waypoints_m = [[20.5, 9.5]] }]";
    check(&[&format!("behaviour={{ kind = \"flock\", leader = 1, {party} }}")], &[("party", beside)]);
    check(&[&format!("behaviour={{ kind = \"flock\", waypoints_m = [[20.5, 9.5]], {party} }}")], &[("party", beside)]);
    let leader = ("leader", ["nothing", "[[behaviour.party]]", "add leader"]);
    let way = ("waypoints_m", ["nothing", "[[behaviour.party]]", "add waypoints_m"]);
    check(&["behaviour={ kind = \"flock\" }"], &[leader, way]);
    check(&["behaviour={ kind = \"flock\", leader = 1 }"], &[way]);
    check(&["behaviour={ kind = \"flock\", waypoints_m = [[20.5, 9.5]] }"], &[leader]);
    let none = ("party", ["no party", "at least one", "leader and waypoints_m"]);
    check(&["behaviour={ kind = \"flock\", party = [] }"], &[none]);
    check(
        &["behaviour={ kind = \"flock\", party = [{}] }"],
        &[
            ("party[0].first_id", ["nothing", "1..=4294967295", "add first_id"]),
            ("party[0].last_id", ["nothing", "1..=4294967295", "add last_id"]),
            ("party[0].leader", ["nothing", "1..=4294967295", "add leader"]),
            ("party[0].waypoints_m", ["nothing", "1..=10000 points", "add waypoints_m"]),
        ],
    );
}

#[test]
fn parties_that_do_not_fit_the_robots_are_refused() {
    let end = [20.5, 9.5];
    let rows: [(&[_], Row); 6] = [
        (&[(1, 1, 5, end), (6, 6, 9, end)], ("party[1].leader", ["6", "a party with a robot in it", "choose"])),
        (&[(1, 1, 2, end), (6, 3, 9, end)], ("party[1].leader", ["6", "of a robot: 3, 4, 5", "choose"])),
        (&[(1, 1, 2, end), (2, 3, 5, end)], ("party[1].leader", ["2", "an id in 3..=5", "widen the party"])),
        (
            &[(1, 1, 3, end), (3, 3, 5, end)],
            ("party[1].first_id", ["3 up to 5, some of which party[0] has", "other than its 1..=3", "one leader"]),
        ),
        (&[(1, 1, 3, end), (5, 5, 5, end)], ("party", ["no party for 4", "a party for each robot", "widen"])),
        (&[(1, 5, 1, end)], ("party[0].last_id", ["1", "at least first_id, 5", "swap"])),
    ];
    for (listed, row) in rows {
        check(&[&parties(listed)], &[row]);
    }
    let wall = ("party[1].waypoints_m[0]", ["[7, 12], inside polygons[1]", "0.42 m of free floor", "wall"]);
    check(&[&parties(&[TWO[0], (4, 3, 5, [7.0, 12.0])])], &[wall]);
    let slow = "kinds.scout_mini.motion.speed_mps_max=0.7";
    let speed = ("leader_speed_mps", ["0.8", "at most 0.7, the leader's motion.speed_mps_max", "lower"]);
    check(&[slow, &parties(&TWO)], &[speed]);
    let quick = "behaviour.leader_speed_mps=1.6";
    let speed = ("leader_speed_mps", ["1.6", "at most 1.5, the leader's", "lower"]);
    check(&[&parties(&TWO), quick], &[speed]);
}

#[test]
fn what_only_points_can_do_is_not_asked_of_bodies() {
    let mode = ("mode", ["\"literal\" with \"rover_mavlink\"", "sim.motion = \"point\"", "set it to \"safe\""]);
    let guard = ("guard", ["\"none\" with \"rover_mavlink\"", "sim.motion = \"point\"", "leave it out"]);
    let solid = ("solid", ["false with \"rover_mavlink\"", "sim.motion = \"point\"", "leave it out"]);
    check(&[LITERAL], &[mode]);
    check(&["behaviour.guard=none"], &[guard]);
    check(&["behaviour.solid=false"], &[solid]);
    check(&[LITERAL, "behaviour.guard=none", "behaviour.solid=false"], &[mode, guard, solid]);
    // One kind with a body is enough.
    let scout = ("mode", ["\"literal\" with \"scout_mini\"", "sim.motion = \"point\"", "run into each other"]);
    check(&[POINTS[0], LITERAL], &[scout]);
    of_points(&[LITERAL, "behaviour.guard=none", "behaviour.solid=false"]);
}

#[test]
fn a_full_guard_must_know_how_long_links_may_be() {
    let words = ("link_range_m", ["0", "more than 0 with guard = \"full\"", "how long links may be"]);
    check(&["behaviour.guard=full"], &[words]);
    assert_eq!(flock(&["behaviour.guard=full", "behaviour.link_range_m=4"]).guard, FlockGuard::Full);
}

#[test]
fn links_need_room_for_errors_a_radio_that_reaches_and_a_start_as_one_network() {
    let full = |range: &'static str| ["behaviour.guard=full", range];
    let short = ("link_range_m", ["2", "at least 2.495: spacing_m, and 0.3 m of error", "no link would be begun"]);
    let parted = ["parted at the start: robot", "0.95 (link_range_m - 0.6) = 1.33 m", "nearer"];
    let problems = load(&full("behaviour.link_range_m=2")).expect_err("refused").0;
    let of = |key: &str| problems.iter().find(|problem| problem.key.ends_with(key)).expect("a problem");
    assert!(short.1.iter().all(|word| of(short.0).to_string().contains(word)), "{}", of(short.0));
    assert!(parted.iter().all(|word| of("start").to_string().contains(word)), "{}", of("start"));
    let deaf = ("link_range_m", ["200", "at most radio.range_m, 100", "nothing is heard"]);
    check(&[&full("behaviour.link_range_m=200")[..], &["radio.range_m=100"]].concat(), &[deaf]);
    // Each party by itself: two that start far apart are two networks.
    let [first, second] = TWO;
    let apart = parties(&[first, second]);
    let swarm = load(&[&apart, "behaviour.guard=full", "behaviour.link_range_m=12"]);
    assert!(swarm.is_ok(), "{:?}", swarm.err());
}

#[test]
fn a_robot_s_own_file_is_checked_the_same_way() {
    let swarm = load(&[&parties(&TWO)]).unwrap_or_else(|problems| panic!("{problems}"));
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("robot.toml");
    let problem = |change: fn(&mut Flock)| {
        let mut file = swarm.robot_file(4).expect("its robot");
        let Behaviour::Flock(flock) = &mut file.behaviour else { panic!("a flock") };
        change(flock);
        std::fs::write(&path, file.to_toml()).expect("written");
        let problems = load_robot(&path, &[]).expect_err("refused").0;
        problems.iter().map(|problem| problem.key.clone()).collect::<Vec<_>>()
    };
    assert_eq!(problem(|flock| flock.leader_speed_mps = 1.6), ["behaviour.leader_speed_mps"]);
    assert_eq!(problem(|flock| flock.parties.truncate(1)), ["behaviour.party"]);
    assert_eq!(problem(|flock| flock.parties[1].leader = 1), ["behaviour.party[1].leader"]);
    assert_eq!(problem(|flock| flock.solid = false), ["behaviour.solid"]);
    assert_eq!(problem(|flock| flock.guard = FlockGuard::Full), ["behaviour.link_range_m"]);
}
