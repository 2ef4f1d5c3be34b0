//! Peers that send garbage: no panic, nothing moves that would not have moved.

use drover_codec::beacon::{decode, encode_beacon, encode_stop, swarm_hash};
use drover_codec::can::agilex::{AgilexHost, AgilexParams, Model};
use drover_codec::mavlink::{MavHost, MavHostParams};
use drover_contract::{Beacon, BehaviourState, CanFrame, CanId, Pose, RobotId, Stamp, Twist};
use rand::{Rng, SeedableRng};
use rand_pcg::Pcg32;
use std::time::Duration;

fn mav_host() -> MavHost {
    let params = MavHostParams {
        robot: 1,
        component: 191,
        telemetry_hz: 20,
        lidar_component: 196,
        range_m_min: 0.2,
        range_m_max: 12.0,
        link_timeout: Duration::from_millis(500),
    };
    MavHost::new(params, Stamp::ZERO)
}

#[test]
fn garbage_on_a_mavlink_link_brings_nothing_up() {
    let mut host = mav_host();
    let mut chance = Pcg32::seed_from_u64(1);
    for step in 0..20_000_u64 {
        let now = Stamp::from_millis(step);
        let len = chance.random_range(0..1500);
        let mut bytes: Vec<u8> = (0..len).map(|_| chance.random()).collect();
        if let (Some(first), true) = (bytes.first_mut(), chance.random()) {
            // Half of it begins like a frame.
            *first = 0xFD;
        }
        host.handle_datagram(now, &bytes);
        host.handle_timeout(now);
        while host.poll_output().is_some() {}
        while let Some(event) = host.poll_event() {
            let text = format!("{event:?}");
            assert!(!text.contains("Ready"), "garbage made the drive ready: {text}");
        }
    }
}

#[test]
fn garbage_on_a_can_bus_brings_no_chassis_up() {
    let params = AgilexParams { model: Model::ScoutMini, track_m: 0.49, link_timeout: Duration::from_millis(500) };
    let mut host = AgilexHost::new(params, Stamp::ZERO);
    let mut chance = Pcg32::seed_from_u64(2);
    for step in 0..50_000_u64 {
        let now = Stamp::from_millis(step);
        let len = chance.random_range(0..=8);
        let bytes: Vec<u8> = (0..len).map(|_| chance.random()).collect();
        let id = if chance.random() {
            CanId::Extended(chance.random_range(0..0x2000_0000))
        } else {
            // Never the two frames that say who is in charge: any byte there may truthfully say "CAN mode".
            CanId::Standard([0x111, 0x241, 0x251, 0x311, 0x361, 0x7FF][chance.random_range(0..6)])
        };
        host.handle_frame(now, &CanFrame::new(id, &bytes).expect("it fits"));
        host.handle_timeout(now);
        while host.poll_output().is_some() {}
        while let Some(event) = host.poll_event() {
            let text = format!("{event:?}");
            assert!(!text.contains("Ready("), "garbage made the drive ready: {text}");
        }
    }
}

fn beacon() -> Beacon {
    Beacon {
        robot: RobotId(7),
        epoch: 3,
        seq: 9,
        sent: Stamp::from_millis(1234),
        pose_wb: Pose::new(1.5, -2.5, 0.5),
        twist_b: Twist::new(0.5, 0.25),
        accel_mps2: 0.125,
        pos_bound_m: 0.25,
        radius_m: 0.375,
        state: BehaviourState::Active,
        progress: 0.5,
        leader: None,
    }
}

#[test]
fn a_beacon_with_one_bit_wrong_is_refused() {
    let swarm = swarm_hash("first");
    for good in [encode_beacon(swarm, &beacon(), 1), encode_stop(swarm, None, 1)] {
        assert!(decode(&good).is_ok());
        for bit in 0..good.len() * 8 {
            let mut bad = good.clone();
            bad[bit / 8] ^= 1 << (bit % 8);
            assert!(decode(&bad).is_err(), "bit {bit} was flipped and nobody noticed");
        }
        for len in 0..good.len() {
            assert!(decode(&good[..len]).is_err(), "cut to {len} bytes and nobody noticed");
        }
    }
}
