//! Flocking in virtual time: the paper as printed, what ships, parties that meet, links that are kept, a leader that
//! dies, real bodies.

use crate::support::{at_rest, at_s, braking_s, moves, reaction_s};
use drover_config::{Behaviour, Override, Swarm, load_swarm};
use drover_contract::RobotId;
use drover_swarm::{Fidelity, FlockFigures, FlockSwarm, Trial, TrialResult, VirtualSwarm, run_trial, trial_of};
use rayon::prelude::*;
use std::path::Path;

fn scene(name: &str, seed: u64, set: &[&str]) -> Swarm {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("config/swarms/flock_{name}.toml"));
    let seed = format!("seed={seed}");
    let set = set.iter().copied().chain([seed.as_str()]).map(|set| Override::parse(set).expect("sound"));
    load_swarm(&path, &set.collect::<Vec<_>>()).unwrap_or_else(|problems| panic!("{problems}"))
}

fn run(name: &str, (seed, fidelity): (u64, Fidelity), set: &[&str]) -> TrialResult {
    let swarm = scene(name, seed, set);
    let mut trial = trial_of(&swarm, fidelity, None).expect("opens");
    run_trial(&swarm, trial.as_mut(), &mut |_: &dyn Trial| true).expect("not interrupted")
}

fn all(name: &str, seeds: std::ops::Range<u64>, set: &[&str]) -> Vec<TrialResult> {
    seeds.into_par_iter().map(|seed| run(name, (seed, Fidelity::Direct), set)).collect()
}

fn figures(run: &TrialResult) -> &FlockFigures {
    run.flock.as_ref().expect("a flock")
}

#[test]
fn what_ships_gets_out_of_every_trap_without_a_touch_and_in_order() {
    for name in ["u", "t", "spiral", "comb", "forest", "mover"] {
        for run in all(name, 100..110, &[]) {
            let figures = figures(&run);
            assert!(figures.success && run.touched == 0, "{name}: {run:?}");
            assert!(figures.order >= 0.98, "{name}: {run:?}");
        }
    }
}

#[test]
fn a_single_robot_follows_the_wall_out_of_a_trap_to_a_goal_that_stands() {
    // No leader has gone before it: there is no trail.
    for run in all("single", 100..110, &[]) {
        let figures = figures(&run);
        assert!(run.reached && figures.success && run.touched == 0 && figures.wall_entries > 0, "{run:?}");
    }
    let without = all("single", 100..110, &["behaviour.walls=none"]);
    assert!(without.iter().all(|run| !run.reached), "{without:?}");
}

#[test]
fn as_printed_robots_stay_behind_touch_walls_and_are_trapped_again() {
    for name in ["u", "t"] {
        let runs = all(name, 0..20, &["behaviour.mode=literal"]);
        let succeed = runs.iter().filter(|run| figures(run).success).count();
        assert!(succeed <= 10, "{name}: {succeed} of 20");
        assert!(runs.iter().any(|run| run.touched > 0), "{name}: reversing blindly");
        assert!(runs.iter().any(|run| figures(run).wall_entries > 10), "{name}: trapped again and again");
        let without = all(name, 0..20, &["behaviour.walls=none", "behaviour.trail=false"]);
        assert!(without.iter().any(|run| !figures(run).success), "{name}: a trap that catches nobody");
    }
}

#[test]
fn with_the_papers_own_limits_of_turning_most_get_out() {
    let limits = ["behaviour.turn_radps=0.31416", "behaviour.wall_turn_radps=26.2"];
    let runs: Vec<TrialResult> =
        ["u", "t", "spiral", "comb"].iter().flat_map(|name| all(name, 0..10, &limits)).collect();
    let succeed = runs.iter().filter(|run| figures(run).success).count();
    assert!(succeed >= 37 && runs.iter().all(|run| run.touched == 0), "{succeed} of 40");
}

#[test]
fn two_flocks_that_meet_at_a_door_both_come_through() {
    for run in all("headon", 100..108, &[]) {
        let figures = figures(&run);
        assert!(figures.success && run.touched == 0, "{run:?}");
        assert!(figures.stuck_s <= 20.0 && figures.gave_way_s > 0.0, "{run:?}");
    }
}

#[test]
fn a_door_that_is_hardly_wider_than_a_robot_lets_nearly_all_through_and_hurts_nobody() {
    let runs = all("door", 0..10, &[]);
    let through: u64 = runs.iter().map(|run| 4 - figures(run).lost.min(4)).sum();
    assert!(runs.iter().all(|run| run.touched == 0), "{runs:?}");
    assert!(through >= 38, "{through} of 40 followers");
}

#[test]
fn a_leader_that_is_to_lose_nobody_waits_even_for_slow_turners() {
    let set = ["behaviour.turn_radps=0.31416", "behaviour.lose_nobody=true", "duration_s=240"];
    let runs = all("spiral", 0..4, &set);
    assert!(runs.iter().all(|run| figures(run).success), "{runs:?}");
}

/// The longest link that a party needed at any step of any run, metres.
fn longest_m(runs: &[TrialResult]) -> f64 {
    runs.iter().map(|run| figures(run).link_m.expect("links are asked for")).fold(0.0, f64::max)
}

#[test]
fn with_links_kept_each_party_is_one_network_at_every_step_and_everybody_arrives() {
    let links = |guard| [guard, "behaviour.link_range_m=0.4"];
    for name in ["u", "t", "spiral", "comb", "forest", "headon"] {
        let runs = all(name, 100..106, &links("behaviour.guard=full"));
        assert!(longest_m(&runs) <= 0.4, "{name}: {} m", longest_m(&runs));
        assert!(runs.iter().all(|run| figures(run).success && run.touched == 0), "{name}: {runs:?}");
    }
    let without = longest_m(&all("comb", 100..106, &links("behaviour.guard=collision")));
    assert!(without > 0.4, "{without} m: a trap that parts nobody");
}

#[test]
fn a_link_that_holds_somebody_for_good_costs_the_way_and_never_the_network() {
    // Without wall following, those in the trap stay there.
    let set = ["behaviour.guard=full", "behaviour.link_range_m=0.4", "behaviour.walls=none"];
    for name in ["u", "comb", "door"] {
        let runs = all(name, 100..104, &set);
        assert!(longest_m(&runs) <= 0.4 && runs.iter().all(|run| run.touched == 0), "{name}: {runs:?}");
    }
}

#[test]
fn bodies_keep_their_links_over_a_bad_radio_where_they_would_part_without() {
    let run_with = |guard: &'static str, seed: u64| {
        // Nobody goes along walls or a trail, and the T catches some.
        let radio = ["radio.loss=0.3", "radio.delay_ms=100.0", "duration_s=60"];
        let trap = ["behaviour.walls=none", "behaviour.trail=false"];
        let set = [&[guard, "behaviour.link_range_m=5.5"][..], &radio, &trap].concat();
        run("scouts_t", (seed, Fidelity::Wire), &set)
    };
    let kept: Vec<TrialResult> =
        (1..4_u64).into_par_iter().map(|seed| run_with("behaviour.guard=full", seed)).collect();
    assert!(longest_m(&kept) <= 5.5 && kept.iter().all(|run| run.touched == 0), "{kept:?}");
    let parted: Vec<TrialResult> =
        (1..4_u64).into_par_iter().map(|seed| run_with("behaviour.guard=collision", seed)).collect();
    assert!(longest_m(&parted) > 8.0, "{} m: a trap that parts nobody", longest_m(&parted));
}

#[test]
fn bodies_that_keep_their_links_arrive_over_the_wire() {
    for name in ["scouts_u", "scouts_t"] {
        let run = run(name, (1, Fidelity::Wire), &["behaviour.guard=full", "behaviour.link_range_m=6"]);
        assert!(run.reached && run.touched == 0 && run.aged_commands == 0, "{name}: {run:?}");
        assert!(figures(&run).link_m.is_some_and(|link_m| link_m <= 6.0), "{name}: {run:?}");
    }
}

/// Followers' mean way after their leader died at 5 s, from 10 s on to 40 s, metres.
fn way_after_death_m(loss: &str) -> f64 {
    let swarm = scene("forest", 1, &[&format!("behaviour.leader_loss={loss}")]);
    let Behaviour::Flock(flock) = &swarm.behaviour else { panic!("a flock") };
    let mut points = FlockSwarm::new(&swarm, flock);
    let mean_m = |points: &FlockSwarm| (1..5).map(|robot| points.arena().path_m(robot)).sum::<f64>() / 4.0;
    let until = |points: &mut FlockSwarm, time_s: f64| {
        while points.now().as_secs_f64() < time_s {
            points.step();
        }
    };
    until(&mut points, 5.0);
    points.kill(0);
    until(&mut points, 10.0);
    let before_m = mean_m(&points);
    until(&mut points, 40.0);
    mean_m(&points) - before_m
}

#[test]
fn without_their_leader_followers_stop_or_elect_another() {
    assert!(way_after_death_m("stop") < 1e-9);
    assert!(way_after_death_m("elect") > 0.5, "half of what a leader drives in that time");
}

#[test]
fn bodies_with_noisy_lidars_arrive_without_a_touch_over_the_wire() {
    for name in ["scouts_u", "scouts_t", "scouts_door", "scouts_headon", "scouts_mover"] {
        let run = run(name, (1, Fidelity::Wire), &[]);
        assert!(run.reached && figures(&run).success && run.touched == 0, "{name}: {run:?}");
        assert_eq!(figures(&run).gave_way_s > 0.0, name == "scouts_headon", "{name}: {run:?}");
    }
}

/// Rovers over the wire whose leader's process, the first of the file, dies at `dies_s`.
fn without_leader((name, dies_s): (&str, f64), seed: u64, set: &[&str]) -> (Swarm, VirtualSwarm) {
    let swarm = scene(name, seed, set);
    let mut rovers = at_rest(&swarm);
    rovers.run_until(at_s(dies_s));
    assert!((0..swarm.robots.len()).all(|robot| moves(&rovers, robot)), "all are under way");
    rovers.kill(0);
    (swarm, rovers)
}

#[test]
fn bodies_without_their_leader_stop_in_time_and_stay_if_nobody_is_to_be_elected() {
    let (swarm, mut rovers) = without_leader(("scouts_u", 20.0), 1, &["behaviour.leader_loss=stop"]);
    let kind = swarm.kind_of(&swarm.robots[1]);
    let bound_s = f64::from(kind.timeouts.peer_ms) * 1e-3 + reaction_s(kind) + braking_s(kind);
    let killed = rovers.now();
    let mut moved_s: f64 = 0.0;
    while rovers.now() < at_s(60.0) {
        rovers.step();
        if (1..swarm.robots.len()).any(|robot| moves(&rovers, robot)) {
            moved_s = rovers.now().since(killed).as_secs_f64();
        }
    }
    assert!(moved_s > 0.0 && moved_s <= bound_s, "moved until {moved_s:.2} s after, the bound is {bound_s:.2} s");
    for robot in 1..swarm.robots.len() {
        let status = rovers.robot(robot).expect("alive").status();
        assert!(status.verdict.to_string().contains("leader") && !status.reached, "{status:?}");
    }
}

#[test]
fn bodies_without_their_leader_elect_another_and_go_round_its_body_to_the_end() {
    // It dies on its way, and so on everybody's; its drive rolls on from where it was last heard.
    let deaths = ["scouts_u", "scouts_t"].into_iter().flat_map(|name| [6.0, 20.0, 30.0].map(|dies_s| (name, dies_s)));
    let runs: Vec<((&str, f64), u64)> = deaths.flat_map(|death| (1..4).map(move |seed| (death, seed))).collect();
    runs.into_par_iter().for_each(|(death, seed)| {
        let (swarm, mut rovers) = without_leader(death, seed, &["behaviour.leader_loss=elect"]);
        rovers.run_until(at_s(death.1 + 6.0));
        let leader = |robot: usize| rovers.robot(robot).expect("alive").status().leader;
        let agree = (1..swarm.robots.len()).all(|robot| leader(robot).is_none_or(|leader| leader == RobotId(2)));
        assert!(agree && leader(1) == Some(RobotId(2)), "the lowest id of the living: {death:?} {seed}");
        let summary = rovers.run();
        assert_eq!(summary.ended, "every robot reached the end", "{death:?} {seed}: {summary:#?}");
        let gaps_m = [summary.min_gap_robot_m, summary.min_gap_wall_m];
        assert!(gaps_m.into_iter().flatten().all(|gap_m| gap_m > 0.0), "{death:?} {seed}: {summary:#?}");
    });
}
