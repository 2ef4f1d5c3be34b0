//! Deployment in virtual time: the paper's claims, what ships, losses, deaths, pockets.

use drover_config::{Behaviour, Deploy, Override, Swarm, load_swarm};
use drover_contract::Stamp;
use drover_swarm::{Fidelity, PointSwarm, TrialResult, kill_one, run_trial, trial_of};
use rayon::prelude::*;
use std::path::Path;
use std::time::Duration;

fn scene(name: &str, seed: u64, set: &[&str]) -> Swarm {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("config/swarms/deploy_{name}.toml"));
    let seed = format!("seed={seed}");
    let set: Vec<Override> =
        set.iter().copied().chain([seed.as_str()]).map(|set| Override::parse(set).expect("sound")).collect();
    load_swarm(&path, &set).unwrap_or_else(|problems| panic!("{problems}"))
}

fn deploys(swarm: &Swarm) -> &Deploy {
    match &swarm.behaviour {
        Behaviour::Deploy(deploy) => deploy,
        other => panic!("{other:?}"),
    }
}

fn run(name: &str, seed: u64, set: &[&str]) -> TrialResult {
    let swarm = scene(name, seed, set);
    let mut trial = trial_of(&swarm, Fidelity::Direct, None).expect("opens");
    run_trial(&swarm, trial.as_mut(), &mut |_: &dyn drover_swarm::Trial| true).expect("not interrupted")
}

fn all(name: &str, seeds: std::ops::Range<u64>, set: &[&str]) -> Vec<TrialResult> {
    seeds.into_par_iter().map(|seed| run(name, seed, set)).collect()
}

/// Connected at every step, no gap below d_s or d_o, nobody in a wall, all arrive.
fn assert_sound(name: &str, runs: &[TrialResult]) {
    for run in runs {
        let figures = run.deploy.as_ref().expect("a deployment");
        let gaps_m = run.min_gap_robot_m.into_iter().chain(run.min_gap_wall_m);
        assert!(figures.connected_always && figures.tunnelled == 0 && run.reached, "{name}: {run:?}");
        assert!(gaps_m.fold(f64::INFINITY, f64::min) >= 0.3 - 1e-6, "{name}: {run:?}");
    }
}

fn median_s(runs: &[TrialResult]) -> f64 {
    let mut times: Vec<f64> = runs.iter().map(|run| run.time_s).collect();
    times.sort_by(f64::total_cmp);
    times[times.len() / 2]
}

#[test]
fn experiment_1_literal_never_arrives_with_all_links_arrives_with_fewer_and_walks_through_walls() {
    let plain = all("exp1", 0..4, &["behaviour.mode=literal", "behaviour.links=all", "behaviour.repel_gain=2"]);
    assert!(plain.iter().all(|run| !run.reached), "without the optimisation");
    let literal = all("exp1", 0..10, &["behaviour.mode=literal"]);
    assert!(literal.iter().all(|run| run.reached), "with it");
    assert!(
        literal.iter().all(|run| run.deploy.as_ref().is_some_and(|figures| figures.tunnelled > 0)),
        "through walls"
    );
}

#[test]
fn the_paper_s_scenes_are_sound_and_no_slower_than_the_prototype() {
    let medians_s = [("exp1", 249.0), ("exp2", 116.0), ("exp3_row", 238.0), ("exp3_random", 194.0)];
    for (name, prototype_s) in medians_s {
        let runs = all(name, 0..12, &[]);
        assert_sound(name, &runs);
        assert!(median_s(&runs) <= prototype_s, "{name}: {} s", median_s(&runs));
    }
}

#[test]
fn whatever_stands_for_a_forbidden_move_the_network_is_one() {
    // The nearest allowed point lies on the very rim of the discs, step after step.
    for steer in ["behaviour.steer=project", "behaviour.steer=heading"] {
        let runs = all("exp1", 0..10, &[steer]);
        assert!(runs.iter().all(|run| run.deploy.as_ref().is_some_and(|figures| figures.connected_always)), "{steer}");
    }
}

#[test]
fn targets_go_by_ids_and_not_by_the_order_of_the_file() {
    for exchange in ["behaviour.exchange=snapshot", "behaviour.exchange=beacons"] {
        let mut swarm = scene("exp1", 3, &[exchange]);
        swarm.robots.reverse();
        let mut trial = trial_of(&swarm, Fidelity::Direct, None).expect("opens");
        let run = run_trial(&swarm, trial.as_mut(), &mut |_: &dyn drover_swarm::Trial| true).expect("a result");
        assert_sound(exchange, &[run]);
    }
}

#[test]
fn generated_fields_and_pockets_are_crossed() {
    assert_sound("field", &all("field", 0..6, &[]));
    assert_sound("pockets", &all("pockets", 0..10, &[]));
    let stuck = all("pockets", 0..2, &["behaviour.escape=none"]);
    assert!(stuck.iter().all(|run| !run.reached), "a pocket is one: without the map nobody comes out");
}

#[test]
fn late_and_lost_beacons_cost_time_and_never_a_link() {
    let ideal = all("lossy", 0..12, &["behaviour.exchange=snapshot"]);
    for loss in ["radio.loss=0", "radio.loss=0.1", "radio.loss=0.3"] {
        let runs = all("lossy", 0..12, &[loss]);
        assert_sound(loss, &runs);
        let ratio = median_s(&runs) / median_s(&ideal);
        assert!(ratio <= 1.3, "{loss}: {ratio} times the ideal");
    }
}

#[test]
fn the_network_freezes_rather_than_break_when_nothing_is_heard() {
    let runs = all("lossy", 0..4, &["radio.loss=0.97", "duration_s=120", "behaviour.peer_lost_s=1000"]);
    assert!(runs.iter().all(|run| run.deploy.as_ref().is_some_and(|figures| figures.connected_always)));
}

#[test]
fn the_living_are_one_network_again_after_a_death() {
    let mut late = Vec::new();
    let runs: Vec<_> = (0..24_u64)
        .into_par_iter()
        .map(|seed| {
            let swarm = scene("lossy", seed, &["radio.loss=0.1"]);
            let deploy = deploys(&swarm);
            let robot = (seed * 7 % 10) as usize;
            let at = Stamp::from_millis(8_000 + seed * 7_919 % 220_000);
            let watch = (Duration::from_secs(60), deploy.range_m);
            (seed, kill_one(&mut PointSwarm::new(&swarm, deploy), robot, at, watch))
        })
        .collect();
    for (seed, aftermath) in runs {
        println!("{seed} {aftermath:?}");
        assert!(aftermath.whole_before, "{seed}");
        if aftermath.whole_after_s.is_none_or(|s| s > 30.0) {
            late.push((seed, aftermath));
        }
    }
    assert!(late.is_empty(), "{late:?}");
}

#[test]
fn twelve_robots_on_can_and_mavlink_deploy_over_the_wire() {
    let runs: Vec<TrialResult> = [1, 2, 3]
        .into_par_iter()
        .map(|seed| {
            let swarm = scene("scouts", seed, &[]);
            let mut trial = trial_of(&swarm, Fidelity::Wire, None).expect("opens");
            run_trial(&swarm, trial.as_mut(), &mut |_: &dyn drover_swarm::Trial| true).expect("not interrupted")
        })
        .collect();
    for run in &runs {
        let figures = run.deploy.as_ref().expect("a deployment");
        assert!(figures.connected_always && figures.tunnelled == 0, "{run:?}");
        assert!(run.reached && run.touched == 0 && run.aged_commands == 0, "{run:?}");
    }
}
