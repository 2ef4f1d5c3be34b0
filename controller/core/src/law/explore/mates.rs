//! The other robots of a team that explores, as one of them knows them: where they are, for how long they have stood
//! there, and whether they are still with us.

use crate::peers::Neighbour;
use drover_contract::{BehaviourState, RobotId, Stamp, Vec2};
use std::collections::BTreeMap;
use std::time::Duration;

/// Slower than this is standing, m/s.
const STANDING_MPS: f64 = 0.05;
/// Who has stood for this long is gone around.
const STANDING: Duration = Duration::from_millis(1_500);
/// ... and for so long after it moved again: two that stand in each other's way would else both go on at once.
const STOOD: Duration = Duration::from_secs(4);
/// Who was not heard for this long is out of reach or dead: nothing is left to it, and its body is in the way.
const SILENT: Duration = Duration::from_secs(5);

/// A robot this near is in the way even if it moves, metres.
const NEAR_M: f64 = 2.2;
/// From this near one sees whether a robot is there, metres.
const LOOK_M: f64 = 4.0;

/// Another robot.
#[derive(Clone, Copy, Debug)]
pub(super) struct Fellow {
    pub(super) pos_w: Vec2,
    pub(super) radius_m: f64,
    heard: Stamp,
    still_since: Option<Stamp>,
    stood_until: Option<Stamp>,
    stopped: bool,
}

impl Fellow {
    /// Whether it takes part: one that is stopped for good, or silent, does not.
    pub(super) fn takes_part(&self, now: Stamp) -> bool {
        !self.stopped && now.since(self.heard) < SILENT
    }

    /// Whether it is surely where it was heard last, though it takes no part: one that is stopped for good is; one
    /// that is silent may have gone on, and counts as there for who is near enough to see whether it is.
    pub(super) fn lies(&self, now: Stamp, at_w: Vec2) -> bool {
        self.stopped || (!self.takes_part(now) && (self.pos_w - at_w).norm() < LOOK_M)
    }

    /// Whether it is in the way of whoever is at a place and has to pass: it stands, or is so near that a way through
    /// it would end in front of it.
    pub(super) fn stands(&self, now: Stamp, at_w: Vec2) -> bool {
        let still = self.still_since.is_some_and(|since| now.since(since) >= STANDING);
        let near = (self.pos_w - at_w).norm() < NEAR_M;
        let stood = still || near || self.stood_until.is_some_and(|until| now < until);
        self.lies(now, at_w) || (stood && self.takes_part(now))
    }
}

/// All of them that were ever heard, by id.
#[derive(Clone, Debug, Default)]
pub(super) struct Fellows {
    all: BTreeMap<RobotId, Fellow>,
}

impl Fellows {
    /// Those that are heard now.
    pub(super) fn see(&mut self, now: Stamp, heard: &[Neighbour]) {
        for peer in heard {
            let before = self.all.get(&peer.id);
            let still = peer.twist_b.speed_mps.abs() < STANDING_MPS;
            let still_since = before.and_then(|fellow| fellow.still_since).or(Some(now)).filter(|_| still);
            let stood = before.filter(|fellow| fellow.still_since.is_some_and(|since| now.since(since) >= STANDING));
            let stood_until = stood.map(|_| now + STOOD).or_else(|| before.and_then(|fellow| fellow.stood_until));
            let fellow = Fellow {
                pos_w: peer.pose_wb.position(),
                radius_m: peer.radius_m,
                heard: now,
                still_since,
                stood_until,
                stopped: peer.state == BehaviourState::Stopped,
            };
            self.all.insert(peer.id, fellow);
        }
    }

    /// What can be seen through is not there: forget those that take no part and that a scan shows to be gone.
    /// `seen_m` is how far one sees towards a place, metres; none where one does not.
    pub(super) fn look_for(&mut self, now: Stamp, at_w: Vec2, seen_m: impl Fn(Vec2) -> Option<f64>) {
        self.all.retain(|_, fellow| {
            let behind_m = (fellow.pos_w - at_w).norm() + fellow.radius_m;
            fellow.takes_part(now) || seen_m(fellow.pos_w).is_none_or(|seen_m| seen_m < behind_m)
        });
    }

    pub(super) fn of(&self, robot: RobotId) -> Option<&Fellow> {
        self.all.get(&robot)
    }

    pub(super) fn all(&self) -> impl Iterator<Item = (RobotId, &Fellow)> + '_ {
        self.all.iter().map(|(id, fellow)| (*id, fellow))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use drover_contract::{Pose, Twist};

    fn heard(x_m: f64, speed_mps: f64) -> Neighbour {
        Neighbour {
            id: RobotId(2),
            pose_wb: Pose::new(x_m, 0.0, 0.0),
            twist_b: Twist::new(speed_mps, 0.0),
            accel_mps2: 0.0,
            state: BehaviourState::Active,
            leader: None,
            radius_m: 0.3,
        }
    }

    #[test]
    fn who_stands_for_long_is_gone_around_and_who_is_near_at_once() {
        let mut fellows = Fellows::default();
        fellows.see(Stamp::ZERO, &[heard(5.0, 0.0)]);
        let stands = |fellows: &Fellows, ms: u64, x_m: f64| {
            fellows.of(RobotId(2)).is_some_and(|fellow| fellow.stands(Stamp::from_millis(ms), Vec2::new(x_m, 0.0)))
        };
        assert!(!stands(&fellows, 1_000, 0.0) && stands(&fellows, 1_000, 3.5));
        fellows.see(Stamp::from_millis(1_600), &[heard(5.0, 0.0)]);
        assert!(stands(&fellows, 1_600, 0.0));
        fellows.see(Stamp::from_millis(1_700), &[heard(5.0, 0.5)]);
        assert!(stands(&fellows, 3_000, 0.0), "it has only just begun to move");
        fellows.see(Stamp::from_millis(6_000), &[heard(5.0, 0.5)]);
        assert!(!stands(&fellows, 6_000, 0.0));
    }

    #[test]
    fn a_silent_one_counts_for_who_is_near_until_it_is_seen_to_be_gone() {
        let mut fellows = Fellows::default();
        fellows.see(Stamp::ZERO, &[heard(5.0, 0.5)]);
        let late = Stamp::from_millis(9_000);
        let lies = |fellows: &Fellows, x_m: f64| {
            fellows.of(RobotId(2)).is_some_and(|fellow| fellow.lies(late, Vec2::new(x_m, 0.0)))
        };
        assert!(!lies(&fellows, 0.0) && lies(&fellows, 2.0));
        fellows.look_for(late, Vec2::new(2.0, 0.0), |_| Some(2.8));
        assert!(lies(&fellows, 2.0), "the beam ends on it");
        fellows.look_for(late, Vec2::new(2.0, 0.0), |_| Some(4.0));
        assert!(fellows.of(RobotId(2)).is_none(), "the beam goes through it");
    }
}
