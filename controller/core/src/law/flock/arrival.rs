//! When a follower has arrived: near the leader's last point while the leader itself is there, for long enough.
//!
//! A follower that stopped at once would stand at the rim in the way of those behind it. It flocks on behind a leader
//! that stands until the flock has come to rest, and then stops for good; where rest does not come, because something
//! dithers around an equilibrium, after `SETTLE_S_MAX` seconds.

use crate::estimate::Motion;
use crate::peers::Neighbour;
use drover_config::Flock;
use drover_contract::{BehaviourState, Stamp, Vec2};
use std::time::Duration;

/// At rest for this long, a follower that is near has arrived, seconds.
const REST_S: u64 = 3;
/// Near for this long, it has arrived whether at rest or not, seconds.
const SETTLE_S_MAX: u64 = 15;
/// Slower than this share of the leader's speed is at rest.
const REST: f64 = 1.0 / 27.0;
/// Slower than this share of it, a leader stands.
const STANDS: f64 = 1.0 / 16.0;

/// Watches one follower's arrival.
#[derive(Clone, Debug)]
pub(crate) struct Arrival {
    radius_m: f64,
    leader_radius_m: f64,
    leader_speed_mps: f64,
    near_since: Option<Stamp>,
    rest_since: Option<Stamp>,
    done: bool,
}

impl Arrival {
    pub(crate) fn new(flock: &Flock) -> Self {
        let (radius_m, leader_radius_m) = (flock.arrive_radius_m, flock.waypoint_radius_m);
        let leader_speed_mps = flock.leader_speed_mps;
        Self { radius_m, leader_radius_m, leader_speed_mps, near_since: None, rest_since: None, done: false }
    }

    /// One tick: the follower is where `motion` says; `leader` is `None` if it is not heard.
    pub(crate) fn update(&mut self, now: Stamp, motion: &Motion, leader: Option<&Neighbour>, goal_w: Vec2) {
        let ended = leader.is_some_and(|leader| self.at_end(leader, goal_w));
        if leader.is_some_and(|leader| !ended && leader.state == BehaviourState::Active) {
            // The leader set off again (a new life, a new task): so does the follower.
            self.done = false;
        }
        let near = ended && (motion.pose_wb.position() - goal_w).norm() <= self.radius_m;
        let rests = near && motion.twist_b.speed_mps.abs() <= REST * self.leader_speed_mps;
        self.near_since = near.then(|| self.near_since.unwrap_or(now));
        self.rest_since = rests.then(|| self.rest_since.unwrap_or(now));
        let lasts = |since: Option<Stamp>, span_s: u64| {
            since.is_some_and(|since| now.since(since) >= Duration::from_secs(span_s))
        };
        self.done |= lasts(self.rest_since, REST_S) || lasts(self.near_since, SETTLE_S_MAX);
    }

    fn at_end(&self, leader: &Neighbour, goal_w: Vec2) -> bool {
        match leader.state {
            BehaviourState::Done => true,
            BehaviourState::Waiting | BehaviourState::Active | BehaviourState::Held | BehaviourState::Stopped => {
                // It may pass the last point on its way there: only a leader that stands has come to its end.
                let stands = leader.twist_b.speed_mps.abs() < STANDS * self.leader_speed_mps;
                stands && (leader.pose_wb.position() - goal_w).norm() <= self.leader_radius_m
            }
        }
    }

    pub(crate) fn done(&self) -> bool {
        self.done
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::flock_config;
    use drover_contract::{Pose, RobotId, Twist};

    fn motion(x_m: f64, speed_mps: f64) -> Motion {
        let pose_wb = Pose::new(x_m, 0.0, 0.0);
        Motion { pose_wb, twist_b: Twist::new(speed_mps, 0.0), accel_mps2: 0.0, pos_bound_m: 0.0 }
    }

    fn leader(x_m: f64, state: BehaviourState, speed_mps: f64) -> Neighbour {
        let Motion { pose_wb, twist_b, .. } = motion(x_m, speed_mps);
        let (id, radius_m) = (RobotId(1), 0.4);
        Neighbour { id, pose_wb, twist_b, accel_mps2: 0.0, state, leader: Some(id), radius_m }
    }

    /// Whether a follower has arrived that sees the same for `seconds`.
    fn after(seconds: u64, motion: &Motion, leader: Option<&Neighbour>) -> bool {
        let mut arrival = Arrival::new(&flock_config(vec![[20.0, 0.0]]));
        for tick in 0..=seconds * 20 {
            arrival.update(Stamp::from_millis(tick * 50), motion, leader, Vec2::new(20.0, 0.0));
        }
        arrival.done()
    }

    #[test]
    fn it_takes_being_near_at_rest_and_a_leader_that_is_done() {
        let done = leader(20.0, BehaviourState::Done, 0.0);
        assert!(after(3, &motion(18.0, 0.0), Some(&done)));
        assert!(!after(2, &motion(18.0, 0.0), Some(&done)));
        assert!(!after(60, &motion(15.0, 0.0), Some(&done)), "not near");
        assert!(!after(60, &motion(18.0, 0.0), None), "no leader");
        assert!(!after(60, &motion(18.0, 0.0), Some(&leader(20.0, BehaviourState::Active, 0.8))), "it passes by");
        assert!(after(3, &motion(18.0, 0.0), Some(&leader(19.8, BehaviourState::Held, 0.0))), "it stands there");
    }

    #[test]
    fn one_that_dithers_arrives_in_the_end() {
        let done = leader(20.0, BehaviourState::Done, 0.0);
        assert!(!after(14, &motion(18.0, 0.2), Some(&done)));
        assert!(after(15, &motion(18.0, 0.2), Some(&done)));
    }

    #[test]
    fn a_follower_that_has_arrived_sets_off_again_with_its_leader_and_not_without() {
        let goal_w = Vec2::new(20.0, 0.0);
        let mut arrival = Arrival::new(&flock_config(vec![[20.0, 0.0]]));
        for tick in 0..=60 {
            let done = leader(20.0, BehaviourState::Done, 0.0);
            arrival.update(Stamp::from_millis(tick * 50), &motion(18.0, 0.0), Some(&done), goal_w);
        }
        arrival.update(Stamp::from_millis(4_000), &motion(18.0, 0.0), None, goal_w);
        assert!(arrival.done());
        let away = leader(10.0, BehaviourState::Active, 0.5);
        arrival.update(Stamp::from_millis(5_000), &motion(18.0, 0.0), Some(&away), goal_w);
        assert!(!arrival.done());
    }
}
