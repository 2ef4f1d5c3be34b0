use super::cells::CellTeam;
use super::ground::Ground;
use super::swarm::CellSwarm;
use crate::{Fidelity, Trial, run_trial, trial_of};
use drover_config::{Behaviour, Explore, ExploreMethod, Override, load_swarm};
use std::path::Path;

const ALL: [ExploreMethod; 9] = [
    ExploreMethod::Sweep,
    ExploreMethod::Inea,
    ExploreMethod::Basic,
    ExploreMethod::Greedy,
    ExploreMethod::Nearest,
    ExploreMethod::Burgard,
    ExploreMethod::Hungarian,
    ExploreMethod::MinPos,
    ExploreMethod::Market,
];

/// Two rooms of 20 x 20 cells with a door one cell wide between, and a hollow block that nobody can enter.
fn two_rooms() -> Ground {
    let solid = |column: usize, row: usize| {
        let wall = column == 20 && row != 7;
        let block = (25..30).contains(&column) && (10..15).contains(&row);
        let hollow = (26..29).contains(&column) && (11..14).contains(&row);
        wall || (block && !hollow)
    };
    Ground::new((41, 20), solid, |_| Some(41 + 1))
}

fn run(team: &mut CellTeam, steps_max: u32) {
    while team.finished().is_none() && team.steps() < steps_max {
        team.step();
    }
}

#[test]
fn everybody_finishes_and_knows_all_that_can_be_reached() {
    let starts = [42, 43, 42 + 41 * 3, 44 + 41 * 5];
    for method in ALL {
        let mut team = CellTeam::new(&Explore::usual(method), two_rooms(), &starts);
        run(&mut team, 5_000);
        assert!(team.finished().is_some(), "{method:?} never ended");
        assert!((team.coverage() - 1.0).abs() < 1e-12, "{method:?}: {}", team.coverage());
        assert_eq!(team.frontiers_in_reach(), 0, "{method:?}");
    }
}

#[test]
fn what_a_dead_robot_was_about_to_see_others_see() {
    for method in ALL {
        let mut team = CellTeam::new(&Explore::usual(method), two_rooms(), &[42, 60 + 41 * 12]);
        run(&mut team, 30);
        assert!(team.finished().is_none(), "{method:?} was done too early for this to say anything");
        team.kill(1);
        run(&mut team, 5_000);
        assert!(team.finished().is_some() && team.frontiers_in_reach() == 0, "{method:?}");
    }
}

#[test]
fn what_is_behind_a_dead_robot_that_nobody_gets_around_is_no_reason_to_go_on() {
    let (west, door, east) = (42, 20 + 41 * 7, 38 + 41 * 18);
    for method in ALL {
        let mut team = CellTeam::new(&Explore::usual(method), two_rooms(), &[west, door]);
        team.kill(1);
        run(&mut team, 5_000);
        assert!(team.finished().is_some() && team.frontiers_in_reach() == 0, "{method:?} never ended");
        // The door is known all the same; of the east room only what was seen through it.
        assert!((0.4..0.7).contains(&team.coverage()), "{method:?}: {}", team.coverage());
        assert_eq!(team.robot(1), (door, None), "{method:?}");
        let mut team = CellTeam::new(&Explore::usual(method), two_rooms(), &[west, door, east]);
        team.kill(1);
        run(&mut team, 5_000);
        assert!(team.finished().is_some() && team.frontiers_in_reach() == 0, "{method:?} never ended");
        assert!((team.coverage() - 1.0).abs() < 1e-12, "each has a room: {method:?} {}", team.coverage());
    }
}

#[test]
fn on_every_shipped_place_the_rest_finish_when_one_dies_halfway() {
    for (place, seed) in ["random", "rooms", "maze", "cave"].into_iter().flat_map(|place| [(place, 500), (place, 501)])
    {
        let file = format!("../../config/swarms/explore_{place}.toml");
        let file = Path::new(env!("CARGO_MANIFEST_DIR")).join(file);
        let swarm = load_swarm(&file, &[Override::parse(&format!("seed={seed}")).unwrap()]).unwrap();
        let Behaviour::Explore(explore) = &swarm.behaviour else { panic!("{place} does not explore") };
        let mut trial = CellSwarm::new(&swarm, explore);
        while trial.coverage() < 0.5 {
            assert!(trial.round(), "{place}, seed {seed}: done too early");
        }
        trial.kill(seed as usize % swarm.robots.len());
        while trial.rounds() < 5_000 && trial.round() {}
        let figures = trial.explored().unwrap();
        assert!(figures.finished && figures.unreached_frontiers == 0, "{place}, seed {seed}: {figures:?}");
        assert!(figures.coverage > 0.5, "{place}, seed {seed}: {figures:?}");
    }
}

#[test]
fn the_same_run_twice_is_the_same() {
    let run_of = || {
        let mut team = CellTeam::new(&Explore::usual(ExploreMethod::Sweep), two_rooms(), &[42, 60 + 41 * 12]);
        run(&mut team, 5_000);
        (team.finished(), team.path_cells().to_bits(), team.robot(0), team.robot(1))
    };
    assert_eq!(run_of(), run_of());
}

#[test]
fn a_shipped_place_is_mapped_to_the_end_and_nobody_is_touched() {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../config/swarms/explore_cave.toml");
    let swarm = load_swarm(&file, &[]).unwrap();
    let mut trial = trial_of(&swarm, Fidelity::Direct, None).unwrap();
    let result = run_trial(&swarm, trial.as_mut(), &mut |_: &dyn Trial| true).unwrap();
    let figures = result.explore.clone().unwrap();
    assert!(result.reached && figures.finished && figures.unreached_frontiers == 0, "{result:?}");
    assert!(figures.coverage > 0.9999 && result.touched == 0, "{result:?}");
    let steps = figures.steps_finish.unwrap();
    assert!((result.time_s - f64::from(steps)).abs() < 2.0, "a step takes a second: {result:?}");
    assert!(figures.steps_90 <= figures.steps_96 && figures.steps_96 <= figures.steps_finish, "{result:?}");
}

/// A shipped scene whose robots have maps of their own and hear each other from ten cells, seven of ten times.
fn apart(scene: &str, exchange: &str) -> CellSwarm {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("../../config/swarms/explore_{scene}.toml"));
    let exchange = format!("behaviour.exchange={exchange}");
    let set = [exchange.as_str(), "radio.range_m=10", "radio.loss=0.3", "seed=3"];
    let set = set.map(|set| Override::parse(set).expect("sound"));
    let swarm = load_swarm(&path, &set).unwrap_or_else(|problems| panic!("{problems}"));
    let Behaviour::Explore(explore) = &swarm.behaviour else { panic!("an exploration") };
    let mut robots = CellSwarm::new(&swarm, explore);
    while robots.rounds() < 8_000 && robots.round() {}
    robots
}

#[test]
fn over_a_bad_radio_gossip_ends_with_everything_in_every_robot() {
    for scene in ["random", "cave"] {
        let figures = apart(scene, "gossip").explored().expect("measured");
        assert!(figures.finished && figures.unreached_frontiers == 0, "{scene}: {figures:?}");
        assert!((figures.coverage - 1.0).abs() < 1e-12, "{scene}: {figures:?}");
        assert!(figures.bytes.is_some_and(|bytes| bytes > 10_000), "{scene}: {figures:?}");
    }
}

#[test]
fn by_observation_points_robots_believe_in_more_than_anybody_saw() {
    let figures = apart("rooms", "points").explored().expect("measured");
    assert!(figures.finished, "{figures:?}");
    assert!(figures.coverage > 0.95 && figures.coverage < 1.0, "walls hid some of what counts as seen: {figures:?}");
}
