//! Shared by the tests in virtual time.

use drover_config::{Kind, Override, Swarm, load_swarm};
use drover_contract::Stamp;
use drover_swarm::VirtualSwarm;
use std::path::Path;
use std::time::Duration;

/// Slower than this a body stands, m/s and rad/s.
pub(crate) const STANDSTILL: f64 = 0.01;

/// The shipped swarm, with some keys set.
pub(crate) fn first_swarm(set: &[&str]) -> Swarm {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("config/swarms/first.toml");
    let set: Vec<Override> = set.iter().map(|text| Override::parse(text).expect("a good override")).collect();
    load_swarm(&path, &set).unwrap_or_else(|problems| panic!("{problems}"))
}

/// The swarm, at rest.
pub(crate) fn at_rest(swarm: &Swarm) -> VirtualSwarm {
    VirtualSwarm::new(swarm).unwrap_or_else(|error| panic!("{error}"))
}

/// Place of robot `id` in the file.
pub(crate) fn index_of(swarm: &Swarm, id: u32) -> usize {
    swarm.robots.iter().position(|robot| robot.id == id).expect("a robot of the swarm")
}

/// The moment `s` seconds after the start.
pub(crate) fn at_s(s: f64) -> Stamp {
    Stamp::ZERO + Duration::from_secs_f64(s)
}

/// Whether body `index` moves.
pub(crate) fn moves(virtual_swarm: &VirtualSwarm, index: usize) -> bool {
    let twist_b = virtual_swarm.plant().truth(index).twist_b;
    twist_b.speed_mps.abs() > STANDSTILL || twist_b.yaw_rate_radps.abs() > STANDSTILL
}

/// Run until every robot moves; panics if that does not happen.
pub(crate) fn run_until_all_move(virtual_swarm: &mut VirtualSwarm, count: usize) {
    let limit = at_s(20.0);
    while virtual_swarm.now() < limit {
        virtual_swarm.step();
        // Speed of its own, not just a twitch: the brake has something to do.
        let fast = |index| virtual_swarm.plant().truth(index).twist_b.speed_mps > 0.3;
        if (0..count).all(fast) {
            return;
        }
    }
    panic!("not every robot was moving at more than 0.3 m/s after 20 s");
}

/// Run for `watch_s` seconds and say how long after now body `index` last moved, s.
pub(crate) fn last_motion_s(virtual_swarm: &mut VirtualSwarm, index: usize, watch_s: f64) -> f64 {
    let began = virtual_swarm.now();
    let limit = began + Duration::from_secs_f64(watch_s);
    let mut last = began;
    while virtual_swarm.now() < limit {
        virtual_swarm.step();
        if moves(virtual_swarm, index) {
            last = virtual_swarm.now();
        }
    }
    last.since(began).as_secs_f64()
}

/// The longest that `kind` brakes from its greatest speed, s.
pub(crate) fn braking_s(kind: &Kind) -> f64 {
    kind.motion.speed_mps_max / kind.motion.brake_mps2
}

/// From the decision to stop to wheels that obey it: a tick and the way to the wheels (docs/safety.md), s.
pub(crate) fn reaction_s(kind: &Kind) -> f64 {
    f64::from(kind.timeouts.tick_ms) * 1e-3 + 0.1
}
