//! What becomes of a swarm of points when one of them dies.

use super::PointSwarm;
use crate::trial::Trial;
use drover_contract::{Stamp, Vec2};
use drover_core::deploy::Graph;
use std::time::Duration;

/// A network that has been whole for this long is whole again.
const WHOLE_S: f64 = 5.0;

/// How a swarm took a death.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Aftermath {
    /// Whether the living were one network right after it, by positions.
    pub parted: bool,
    /// From the death until they were one network for good (for 5 s at least), s; 0 if they never were anything else;
    /// none if they were not within the time.
    pub whole_after_s: Option<f64>,
    /// Whether they were one network at every step before.
    pub whole_before: bool,
}

/// Run `swarm` until `at`, let robot `robot` die, and look on for `watch` or until the living have been one network for
/// long enough. `range_m` is the radio's.
pub fn kill_one(swarm: &mut PointSwarm, robot: usize, at: Stamp, (watch, range_m): (Duration, f64)) -> Aftermath {
    let mut whole_before = true;
    while swarm.now() < at {
        swarm.step();
        whole_before &= is_whole(swarm, range_m);
    }
    swarm.kill(robot);
    let parted = !is_whole(swarm, range_m);
    let mut parted_last = None;
    while swarm.now() < at + watch {
        if !is_whole(swarm, range_m) {
            parted_last = Some(swarm.now());
        }
        let since = parted_last.unwrap_or(at);
        if swarm.now().since(since).as_secs_f64() > WHOLE_S && swarm.now().since(at).as_secs_f64() > 2.0 * WHOLE_S {
            break;
        }
        swarm.step();
    }
    let whole = is_whole(swarm, range_m);
    let whole_after_s = whole.then(|| parted_last.map_or(0.0, |last| last.since(at).as_secs_f64()));
    Aftermath { parted, whole_after_s, whole_before }
}

fn is_whole(swarm: &PointSwarm, range_m: f64) -> bool {
    let there = |robot| swarm.status(robot).map(|_| swarm.arena().state(robot).pose_wb.position());
    let living: Vec<Option<Vec2>> = (0..swarm.arena().robot_count()).map(there).collect();
    Graph::new(&living, range_m + 1e-9).all().parts(|robot| living[robot].is_some()) <= 1
}
