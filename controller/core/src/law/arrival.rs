//! When a follower has arrived: near the leader's last point while the leader itself is there, for long enough.
//!
//! A follower that stopped at once would stand at the rim in the way of those behind it; it flocks on for `SETTLE_S`
//! seconds, with a leader that stands, and then stops for good, so that nothing dithers around an equilibrium.

use crate::peers::Neighbour;
use drover_config::Flock;
use drover_contract::{BehaviourState, Stamp, Vec2};
use std::time::Duration;

/// How long a follower flocks on after it came near, seconds.
const SETTLE_S: u64 = 3;

/// Watches one follower's arrival.
#[derive(Clone, Debug)]
pub(crate) struct Arrival {
    radius_m: f64,
    leader_radius_m: f64,
    near_since: Option<Stamp>,
    done: bool,
}

impl Arrival {
    pub(crate) fn new(flock: &Flock) -> Self {
        let (radius_m, leader_radius_m) = (flock.arrive_radius_m, flock.waypoint_radius_m);
        Self { radius_m, leader_radius_m, near_since: None, done: false }
    }

    /// One tick: the follower is `gap_m` from the end at `goal_w`; `leader` is `None` if it is not heard.
    pub(crate) fn update(&mut self, now: Stamp, gap_m: f64, leader: Option<&Neighbour>, goal_w: Vec2) {
        let ended = leader.is_some_and(|leader| self.at_end(leader, goal_w));
        if leader.is_some_and(|leader| !ended && leader.state == BehaviourState::Active) {
            // The leader set off again (a new life, a new task): so does the follower.
            self.done = false;
        }
        let near = ended && gap_m <= self.radius_m;
        self.near_since = if near { Some(self.near_since.unwrap_or(now)) } else { None };
        self.done |= self.near_since.is_some_and(|since| now.since(since) >= Duration::from_secs(SETTLE_S));
    }

    fn at_end(&self, leader: &Neighbour, goal_w: Vec2) -> bool {
        match leader.state {
            BehaviourState::Done => true,
            BehaviourState::Waiting | BehaviourState::Active | BehaviourState::Held | BehaviourState::Stopped => {
                // It may pass the last point on its way there: only a leader that stands has come to its end.
                let stands = leader.twist_b.speed_mps.abs() < 0.05;
                stands && (leader.pose_wb.position() - goal_w).norm() <= self.leader_radius_m
            }
        }
    }

    pub(crate) fn done(&self) -> bool {
        self.done
    }
}
