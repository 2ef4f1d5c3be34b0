//! What is lost stops the robot within the bound that docs/safety.md states, measured at the body.

use crate::support::{
    STANDSTILL, at_rest, braking_s, first_swarm, index_of, last_motion_s, moves, reaction_s, run_until_all_move,
};
use drover_config::{Drive, Kind, Swarm};
use drover_contract::BehaviourState;
use drover_swarm::VirtualSwarm;
use drover_world::Fault;
use std::time::Duration;

/// One robot of each kind that is not the leader.
const FOLLOWERS: [u32; 2] = [2, 4];

fn under_way(swarm: &Swarm) -> VirtualSwarm {
    let mut virtual_swarm = at_rest(swarm);
    run_until_all_move(&mut virtual_swarm, swarm.robots.len());
    virtual_swarm
}

/// The device's own watchdog (docs/safety.md, table of watchdogs), s.
fn watchdog_s(kind: &Kind) -> f64 {
    match kind.drive {
        Drive::Mavlink { .. } => 3.0,
        Drive::AgilexV2 { .. } => 0.5,
    }
}

fn kind_of(swarm: &Swarm, id: u32) -> Kind {
    swarm.kind_of(&swarm.robots[index_of(swarm, id)]).clone()
}

fn assert_stands_within(virtual_swarm: &mut VirtualSwarm, index: usize, bound_s: f64) {
    let took_s = last_motion_s(virtual_swarm, index, bound_s + 3.0);
    println!("stood after {took_s:.2} s, bound {bound_s:.2} s");
    assert!(took_s <= bound_s, "moved for {took_s:.2} s; the bound is {bound_s:.2} s");
    assert!(took_s > 0.0, "it did not move in the first place");
}

#[test]
fn a_killed_process_leaves_the_drives_watchdog_to_stop_the_body_and_the_others_go_on() {
    for id in FOLLOWERS {
        let swarm = first_swarm(&[]);
        let (index, kind) = (index_of(&swarm, id), kind_of(&swarm, id));
        let mut virtual_swarm = under_way(&swarm);
        virtual_swarm.kill(index);
        assert_stands_within(&mut virtual_swarm, index, watchdog_s(&kind) + 0.1 + braking_s(&kind));
        let leader = index_of(&swarm, 1);
        assert!(moves(&virtual_swarm, leader), "the leader goes on without robot {id}");
    }
}

#[test]
fn a_cut_link_stops_the_body_by_the_drives_watchdog_and_is_named() {
    for id in FOLLOWERS {
        let swarm = first_swarm(&[]);
        let (index, kind) = (index_of(&swarm, id), kind_of(&swarm, id));
        let mut virtual_swarm = under_way(&swarm);
        let now = virtual_swarm.now();
        virtual_swarm.plant_mut().inject(now, index, Fault::LinkCut);
        assert_stands_within(&mut virtual_swarm, index, watchdog_s(&kind) + 0.1 + braking_s(&kind));
        let verdict = virtual_swarm.robot(index).expect("alive").status().verdict.to_string();
        assert!(verdict.contains("silent") || verdict.contains("old"), "robot {id} says: {verdict}");
    }
}

#[test]
fn a_link_that_comes_back_lets_the_robot_drive_again() {
    for id in FOLLOWERS {
        let swarm = first_swarm(&[]);
        let index = index_of(&swarm, id);
        let mut virtual_swarm = under_way(&swarm);
        let now = virtual_swarm.now();
        virtual_swarm.plant_mut().inject(now, index, Fault::LinkCut);
        virtual_swarm.run_until(now + Duration::from_secs(6));
        assert!(!moves(&virtual_swarm, index));
        let back = virtual_swarm.now();
        virtual_swarm.plant_mut().inject(back, index, Fault::LinkBack);
        let moved_s = last_motion_s(&mut virtual_swarm, index, 10.0);
        assert!(moved_s > 0.0, "robot {id} never moved again");
    }
}

#[test]
fn a_lost_scan_stops_the_robot_by_its_supervisor() {
    for id in [1, 2, 4] {
        let swarm = first_swarm(&[]);
        let (index, kind) = (index_of(&swarm, id), kind_of(&swarm, id));
        let mut virtual_swarm = under_way(&swarm);
        let now = virtual_swarm.now();
        virtual_swarm.plant_mut().inject(now, index, Fault::ScanCut);
        let scan_s = f64::from(kind.timeouts.scan_ms) * 1e-3;
        assert_stands_within(&mut virtual_swarm, index, scan_s + reaction_s(&kind) + braking_s(&kind));
        let verdict = virtual_swarm.robot(index).expect("alive").status().verdict.to_string();
        assert!(verdict.contains("scan"), "robot {id} says: {verdict}");
    }
}

#[test]
fn followers_of_a_dead_leader_stop_and_say_so() {
    let swarm = first_swarm(&[]);
    let leader = index_of(&swarm, 1);
    let mut virtual_swarm = under_way(&swarm);
    virtual_swarm.kill(leader);
    let killed = virtual_swarm.now();
    let bound_s = |id: u32| {
        let kind = kind_of(&swarm, id);
        f64::from(kind.timeouts.peer_ms) * 1e-3 + reaction_s(&kind) + braking_s(&kind)
    };
    let mut last_motion = vec![killed; swarm.robots.len()];
    while virtual_swarm.now() < killed + Duration::from_secs(8) {
        virtual_swarm.step();
        for (index, last) in last_motion.iter_mut().enumerate() {
            if moves(&virtual_swarm, index) {
                *last = virtual_swarm.now();
            }
        }
    }
    for (index, robot) in swarm.robots.iter().enumerate().filter(|(index, _)| *index != leader) {
        let took_s = last_motion[index].since(killed).as_secs_f64();
        let bound_s = bound_s(robot.id);
        assert!(took_s <= bound_s, "robot {} moved for {took_s:.2} s; the bound is {bound_s:.2} s", robot.id);
        let verdict = virtual_swarm.robot(index).expect("alive").status().verdict.to_string();
        assert!(verdict.contains("leader"), "robot {} says: {verdict}", robot.id);
    }
}

#[test]
fn a_dead_robot_is_driven_around_and_not_into() {
    let swarm = first_swarm(&[]);
    let index = index_of(&swarm, 3);
    let mut virtual_swarm = under_way(&swarm);
    virtual_swarm.kill(index);
    let summary = virtual_swarm.run();
    assert!(summary.min_gap_robot_m.is_some_and(|gap_m| gap_m > 0.0), "{summary:#?}");
    assert!(summary.min_gap_wall_m.is_some_and(|gap_m| gap_m > 0.0), "{summary:#?}");
}

#[test]
fn a_restarted_robot_never_moves_before_a_fresh_command() {
    for id in FOLLOWERS {
        let swarm = first_swarm(&[]);
        let index = index_of(&swarm, id);
        let mut virtual_swarm = under_way(&swarm);
        virtual_swarm.kill(index);
        virtual_swarm.run_until(virtual_swarm.now() + Duration::from_secs(6));
        assert!(!moves(&virtual_swarm, index), "robot {id} still moves");
        virtual_swarm.restart(index).expect("it restarts");
        let limit = virtual_swarm.now() + Duration::from_secs(15);
        let mut commanded = false;
        let mut moved = false;
        while virtual_swarm.now() < limit {
            virtual_swarm.step();
            let status = virtual_swarm.robot(index).expect("alive").status();
            commanded |= status.state == BehaviourState::Active && !status.command.is_stop();
            let twist_b = virtual_swarm.plant().truth(index).twist_b;
            let moving = twist_b.speed_mps.abs() > STANDSTILL || twist_b.yaw_rate_radps.abs() > STANDSTILL;
            assert!(commanded || !moving, "robot {id} moved before its new process had commanded anything");
            moved |= moving;
        }
        assert!(moved, "robot {id} never drove again");
    }
}
