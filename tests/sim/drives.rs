//! Drives that are taken away and given back: power cycles, remote controls, emergency stops.

use crate::support::{at_rest, braking_s, first_swarm, index_of, last_motion_s, moves, run_until_all_move};
use drover_codec::mavlink::mode;
use drover_swarm::VirtualSwarm;
use drover_world::Fault;
use std::time::Duration;

fn injected(id: u32, fault: Fault) -> (VirtualSwarm, usize, f64) {
    let swarm = first_swarm(&[]);
    let index = index_of(&swarm, id);
    let brake_s = braking_s(swarm.kind_of(&swarm.robots[index]));
    let mut virtual_swarm = at_rest(&swarm);
    run_until_all_move(&mut virtual_swarm, swarm.robots.len());
    let now = virtual_swarm.now();
    virtual_swarm.plant_mut().inject(now, index, fault);
    (virtual_swarm, index, brake_s)
}

#[test]
fn a_power_cycled_drive_stands_and_is_brought_up_again() {
    for id in [2, 4] {
        let (mut virtual_swarm, index, _) = injected(id, Fault::PowerCycle);
        let now = virtual_swarm.now();
        virtual_swarm.run_until(now + Duration::from_millis(200));
        assert!(last_motion_s(&mut virtual_swarm, index, 20.0) > 0.0, "robot {id} never drove again");
    }
}

#[test]
fn a_remote_control_takes_the_robot_and_giving_it_back_lets_it_drive_on() {
    for id in [2, 4] {
        let (mut virtual_swarm, index, brake_s) = injected(id, Fault::RemoteControl(true));
        let stood_s = last_motion_s(&mut virtual_swarm, index, 6.0);
        assert!(
            stood_s <= 0.2 + brake_s,
            "robot {id} moved for {stood_s:.2} s under a remote control that asks nothing"
        );
        let verdict = virtual_swarm.robot(index).expect("alive").status().verdict.to_string();
        assert!(verdict.contains("drive"), "robot {id} says: {verdict}");
        let now = virtual_swarm.now();
        virtual_swarm.plant_mut().inject(now, index, Fault::RemoteControl(false));
        assert!(last_motion_s(&mut virtual_swarm, index, 10.0) > 0.0, "robot {id} never drove again");
    }
}

#[test]
fn an_emergency_stop_stands_even_when_it_is_released_until_the_process_is_started_anew() {
    let (mut virtual_swarm, index, brake_s) = injected(4, Fault::EStop(true));
    let stood_s = last_motion_s(&mut virtual_swarm, index, 6.0);
    assert!(stood_s <= 0.2 + brake_s, "moved for {stood_s:.2} s");
    assert!(!moves(&virtual_swarm, index));
    let now = virtual_swarm.now();
    virtual_swarm.plant_mut().inject(now, index, Fault::EStop(false));
    assert!(last_motion_s(&mut virtual_swarm, index, 15.0) <= 0.0, "a released button moved it");
    let drive = drive_of(&virtual_swarm, index);
    assert!(drive.contains("emergency stop") && drive.contains("start this program anew"), "{drive}");
    virtual_swarm.restart(index).expect("it restarts");
    assert!(last_motion_s(&mut virtual_swarm, index, 15.0) > 0.0, "it never drove again");
}

#[test]
fn a_ground_stations_hold_stays_in_force_until_guided_is_given_back() {
    let (mut virtual_swarm, index, brake_s) = injected(2, Fault::StationMode(mode::HOLD));
    let stood_s = last_motion_s(&mut virtual_swarm, index, 20.0);
    assert!(stood_s <= 0.2 + brake_s, "moved for {stood_s:.2} s after HOLD");
    let drive = drive_of(&virtual_swarm, index);
    assert!(drive.contains("HOLD was set by somebody else"), "{drive}");
    let now = virtual_swarm.now();
    virtual_swarm.plant_mut().inject(now, index, Fault::StationMode(mode::GUIDED));
    assert!(last_motion_s(&mut virtual_swarm, index, 10.0) > 0.0, "it never drove again");
}

#[test]
fn a_ground_stations_hold_outlasts_a_link_that_is_cut_and_ends_with_a_new_process() {
    let (mut virtual_swarm, index, _) = injected(2, Fault::LinkCut);
    let cut = virtual_swarm.now();
    virtual_swarm.run_until(cut + Duration::from_secs(6));
    for fault in [Fault::StationMode(mode::HOLD), Fault::LinkBack] {
        let now = virtual_swarm.now();
        virtual_swarm.plant_mut().inject(now, index, fault);
    }
    assert!(last_motion_s(&mut virtual_swarm, index, 15.0) <= 0.0, "a link that is back moved it");
    let drive = drive_of(&virtual_swarm, index);
    assert!(drive.contains("HOLD was set by somebody else"), "{drive}");
    virtual_swarm.restart(index).expect("it restarts");
    assert!(last_motion_s(&mut virtual_swarm, index, 15.0) > 0.0, "it never drove again");
}

fn drive_of(virtual_swarm: &VirtualSwarm, index: usize) -> String {
    virtual_swarm.robot(index).expect("alive").status().drive.to_string()
}
