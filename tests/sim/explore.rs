//! Exploration by bodies in virtual time: an office and a warehouse, over the wire, with a death, with a bad radio.

use drover_config::{Override, Swarm, load_swarm};
use drover_contract::Stamp;
use drover_core::map::{Board, Known};
use drover_swarm::{Fidelity, SurveyFigures, Trial, TrialResult, VirtualSwarm, run_trial, trial_of};
use std::path::Path;

fn scene(name: &str, set: &[&str]) -> Swarm {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("config/swarms/explore_scouts_{name}.toml"));
    let set: Vec<Override> = set.iter().map(|set| Override::parse(set).expect("sound")).collect();
    load_swarm(&path, &set).unwrap_or_else(|problems| panic!("{problems}"))
}

fn run(swarm: &Swarm, fidelity: Fidelity) -> TrialResult {
    let mut trial = trial_of(swarm, fidelity, None).expect("opens");
    run_trial(swarm, trial.as_mut(), &mut |_: &dyn Trial| true).expect("not interrupted")
}

/// All have their certificates, nothing was touched, and every map is true and whole.
fn is_mapped(run: &TrialResult) -> &SurveyFigures {
    let figures = run.survey.as_ref().expect("an exploration by bodies");
    assert!(run.reached && figures.finished && run.touched == 0, "{run:?}");
    assert!(figures.map_at_walls >= 0.98 && figures.coverage >= 0.995, "{run:?}");
    assert_eq!(figures.unreached_frontiers, 0, "{run:?}");
    figures
}

#[test]
fn rovers_and_scouts_map_an_office_over_the_wire_without_a_touch() {
    let run = run(&scene("office", &["seed=1"]), Fidelity::Wire);
    assert!(is_mapped(&run).bytes > 0, "they told each other");
}

#[test]
fn robots_that_lose_a_third_of_all_messages_map_a_warehouse() {
    let run = run(&scene("warehouse", &["seed=1", "radio.loss=0.33"]), Fidelity::Direct);
    is_mapped(&run);
}

#[test]
fn robots_that_hear_each_other_from_near_alone_map_all_of_it_each() {
    let near = ["seed=12", "radio.range_m=10"];
    let run = run(&scene("office", &near), Fidelity::Direct);
    is_mapped(&run);
}

#[test]
fn a_robot_that_dies_leaves_its_task_to_the_others_who_go_around_it() {
    let swarm = scene("office", &["seed=3"]);
    let mut robots = VirtualSwarm::unrecorded(&swarm).expect("opens");
    robots.run_until(Stamp::from_millis(25_000));
    robots.kill(0);
    let living = |robots: &VirtualSwarm| (1..4).all(|robot| robots.status(robot).is_some_and(|status| status.reached));
    while !living(&robots) {
        assert!(robots.now() < Stamp::from_millis(400_000), "the rest finish");
        robots.run_until(robots.now() + std::time::Duration::from_secs(1));
    }
    let gap_m = robots.arena().min_gap_robot_m().expect("several robots");
    assert!(gap_m > 0.0 && robots.arena().min_gap_wall_m().is_some_and(|gap_m| gap_m > 0.0));
    // Those who can hear each other have one map.
    let free = |board: &Board| (0..board.count()).filter(|cell| board.at(*cell) == Known::Free).count();
    let maps: Vec<usize> = (1..4).map(|robot| free(robots.map(robot).expect("a map").board())).collect();
    assert!(maps.iter().all(|free| free.abs_diff(maps[0]) * 100 <= maps[0]), "{maps:?}");
}
