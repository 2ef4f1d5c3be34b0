//! The other robots, as their beacons tell: a table that ages, bounded by the peers that the robot's file names.
//!
//! Two questions are asked of it, and their answers differ on purpose:
//! - *Whom may a law follow?* Only who was heard within `peer_ms` ([`Peers::followable`]).
//! - *Whom may I not touch?* Everybody ever heard, whatever state they are in ([`Peers::bodies`], invariant 5).
//!
//! A peer's pose is carried forward by its last velocity for as long as it may be followed, no longer. What it may
//! have done meanwhile is a disc that grows with age, `A_UNSEEN t^2 / 2`, the reachable set of a body that changes its
//! mind, up to `REACH_M_MAX`. A peer silent for `SILENT_S` keeps its last pose as an obstacle without that disc: it has
//! stopped (absent means stop) or its radio is broken, and then the scan sees it. It stays until it is heard again; but
//! where the scan looks through its last place, it is not there (a drive rolls on for a while), and what the scan shows
//! elsewhere may be it.
//!
//! Clocks of two robots are not comparable, but differences are: of all beacons of one life the one that took least
//! time sets an offset, and what a later one takes beyond that counts as age. So a beacon that lay in a queue is as
//! old as it is, not as fresh as it looks.

use crate::links::LinkPeer;
use drover_contract::{Beacon, BehaviourState, Pose, RobotId, Stamp, Twist, Vec2};
use std::cmp::Ordering;
use std::collections::BTreeMap;
use std::sync::Arc;
use std::time::Duration;

/// How hard a peer may change its velocity without our knowing, m/s^2.
const A_UNSEEN_MPS2: f64 = 2.0;
/// The disc of what a peer may have done grows no larger, metres.
const REACH_M_MAX: f64 = 0.5;
/// A peer silent for longer keeps its last pose without a disc around it, seconds.
const SILENT_S: f64 = 5.0;
/// How fast two clocks may drift apart: the offset follows that much, microseconds per second.
const DRIFT_US_PER_S: f64 = 100.0;
/// Numbers beyond these are no robot's: metres, m/s or rad/s.
const PLACE_M_MAX: f64 = 1e6;
const RATE_MAX: f64 = 50.0;
const RADIUS_M_MAX: f64 = 5.0;

/// A peer whose beacon is fresh enough to follow.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Neighbour {
    pub(crate) id: RobotId,
    /// Carried forward to now.
    pub(crate) pose_wb: Pose,
    /// In its own body frame.
    pub(crate) twist_b: Twist,
    /// Along its heading, m/s^2.
    pub(crate) accel_mps2: f64,
    pub(crate) state: BehaviourState,
    /// Whose lead it follows: itself if it leads.
    pub(crate) leader: Option<RobotId>,
    /// Of its body, metres.
    pub(crate) radius_m: f64,
}

impl Neighbour {
    /// Its velocity, world frame.
    pub(crate) fn vel_w(&self) -> Vec2 {
        self.pose_wb.heading() * self.twist_b.speed_mps
    }
}

/// A peer's body, for collision.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Body {
    pub(crate) pos_w: Vec2,
    /// Of the disc that holds it, metres.
    pub(crate) radius_m: f64,
    /// Its centre is within this distance of `pos_w`, metres.
    pub(crate) bound_m: f64,
    /// Whether it was heard within the timeout.
    pub(crate) heard: bool,
    /// Whether it has been silent for so long that it stands, wherever that is.
    pub(crate) stands: bool,
}

/// Why beacons were not taken, and how many were.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct BeaconCounts {
    pub(crate) taken: u64,
    pub(crate) old: u64,
    pub(crate) duplicate: u64,
    pub(crate) own: u64,
    pub(crate) unknown: u64,
    pub(crate) malformed: u64,
}

#[derive(Clone, Copy, Debug)]
struct Record {
    beacon: Beacon,
    received: Stamp,
    /// `received - sent` of the quickest beacon of this life, microseconds.
    offset_us: i64,
    /// What this beacon took beyond the quickest, microseconds.
    delay_us: u64,
    /// Of the peer's body, as the file says, metres.
    radius_m: f64,
}

/// All robots of a swarm with their bodies' radii, metres: one list for all robots of a process.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Roster {
    radius_m: BTreeMap<RobotId, f64>,
}

impl Roster {
    /// The robots with these ids and radii, metres.
    #[must_use]
    pub fn new(robots: impl IntoIterator<Item = (RobotId, f64)>) -> Self {
        Self { radius_m: robots.into_iter().collect() }
    }

    /// Everybody's id, sorted.
    pub(crate) fn ids(&self) -> impl Iterator<Item = RobotId> + '_ {
        self.radius_m.keys().copied()
    }
}

/// The ageing table.
#[derive(Clone, Debug)]
pub(crate) struct Peers {
    own: RobotId,
    roster: Arc<Roster>,
    /// Sorted by id.
    table: Vec<Record>,
    /// A peer silent for longer is not followed, microseconds.
    timeout_us: u64,
    counts: BeaconCounts,
}

impl Peers {
    /// A table for robot `own`, which knows the others of `roster` and follows none silent for `timeout`.
    pub(crate) fn new(own: RobotId, roster: Arc<Roster>, timeout: Duration) -> Self {
        let timeout_us = timeout.as_micros() as u64;
        Self { own, roster, table: Vec::new(), timeout_us, counts: BeaconCounts::default() }
    }

    /// Takes `beacon` if it is a known peer's and newer than what is held; else counts why not.
    pub(crate) fn handle_beacon(&mut self, now: Stamp, beacon: &Beacon) {
        let place = self.table.binary_search_by_key(&beacon.robot, |record| record.beacon.robot);
        let held = place.ok().map(|at| &self.table[at]);
        match self.judge(beacon, held) {
            Intake::Take => {
                self.counts.taken += 1;
                let life = held.filter(|held| held.beacon.epoch == beacon.epoch);
                let mut record = Record::new(now, beacon, life);
                record.radius_m = held.map_or_else(|| self.radius_m(beacon.robot), |held| held.radius_m);
                match place {
                    Ok(at) => self.table[at] = record,
                    Err(at) => self.table.insert(at, record),
                }
            }
            Intake::Old => self.counts.old += 1,
            Intake::Duplicate => self.counts.duplicate += 1,
            Intake::Own => self.counts.own += 1,
            Intake::Unknown => self.counts.unknown += 1,
            Intake::Malformed => self.counts.malformed += 1,
        }
    }

    fn judge(&self, beacon: &Beacon, held: Option<&Record>) -> Intake {
        let order = held.map(|held| (beacon.epoch, beacon.seq).cmp(&(held.beacon.epoch, held.beacon.seq)));
        if beacon.robot == self.own {
            Intake::Own
        } else if held.is_none() && !self.roster.radius_m.contains_key(&beacon.robot) {
            Intake::Unknown
        } else if !plausible(beacon) {
            Intake::Malformed
        } else {
            match order {
                None | Some(Ordering::Greater) => Intake::Take,
                Some(Ordering::Equal) => Intake::Duplicate,
                Some(Ordering::Less) => Intake::Old,
            }
        }
    }

    /// The peers that a law may follow now, sorted by id, carried forward to now.
    pub(crate) fn followable(&self, now: Stamp) -> impl Iterator<Item = Neighbour> + '_ {
        let fresh = self.table.iter().filter(move |record| record.age_us(now) <= self.timeout_us);
        fresh.map(move |record| record.neighbour(self.pose_wb(record, now)))
    }

    /// The peers that were heard within the timeout, sorted by id, as they told it: not carried forward.
    pub(crate) fn told(&self, now: Stamp) -> impl Iterator<Item = LinkPeer> + '_ {
        let fresh = self.table.iter().filter(move |record| record.age_us(now) <= self.timeout_us);
        fresh.map(move |record| {
            let Beacon { robot, pose_wb, twist_b, .. } = record.beacon;
            let ahead_w = pose_wb.transform(Vec2::new(1.0, 0.0)) - pose_wb.position();
            let vel_w = ahead_w * twist_b.speed_mps;
            LinkPeer { id: robot, pos_w: pose_wb.position(), vel_w, age_s: seconds(record.age_us(now)) }
        })
    }

    /// Every body ever heard of, sorted by id, whatever its state; but for those that are surely farther than `range_m`
    /// from `centre_w` with all of their bound.
    pub(crate) fn bodies(&self, now: Stamp, centre_w: Vec2, range_m: f64) -> impl Iterator<Item = Body> + '_ {
        let near = self.table.iter().filter(move |record| self.may_be_within(record, now, centre_w, range_m));
        near.map(move |record| self.body(record, now))
    }

    /// Whether some part of a body may be within `range_m` of a place: cheaper than where exactly it is.
    fn may_be_within(&self, record: &Record, now: Stamp, centre_w: Vec2, range_m: f64) -> bool {
        let beacon = &record.beacon;
        let way_m = beacon.twist_b.speed_mps.abs() * seconds(self.timeout_us);
        let widest_m = beacon.radius_m.max(record.radius_m) + beacon.pos_bound_m + record.reach_m(now);
        let within_m = range_m + way_m + widest_m;
        (beacon.pose_wb.position() - centre_w).norm_squared() <= within_m * within_m
    }

    fn body(&self, record: &Record, now: Stamp) -> Body {
        Body {
            pos_w: self.pose_wb(record, now).position(),
            radius_m: record.beacon.radius_m.max(record.radius_m),
            bound_m: record.beacon.pos_bound_m + record.reach_m(now),
            heard: record.age_us(now) <= self.timeout_us,
            stands: seconds(record.age_us(now)) > SILENT_S,
        }
    }

    fn pose_wb(&self, record: &Record, now: Stamp) -> Pose {
        let ahead_us = record.age_us(now).min(self.timeout_us);
        record.beacon.pose_wb.advance(record.beacon.twist_b, seconds(ahead_us))
    }

    fn radius_m(&self, id: RobotId) -> f64 {
        self.roster.radius_m.get(&id).copied().unwrap_or(0.0)
    }

    /// Who was heard within the timeout, and how long ago, sorted by id.
    pub(crate) fn ages(&self, now: Stamp) -> impl Iterator<Item = (RobotId, Duration)> + '_ {
        let aged = self.table.iter().map(move |record| (record.beacon.robot, record.age_us(now)));
        let fresh = aged.filter(|(_, age_us)| *age_us <= self.timeout_us);
        fresh.map(|(id, age_us)| (id, Duration::from_micros(age_us)))
    }

    /// How many peers were heard within the timeout.
    pub(crate) fn heard(&self, now: Stamp) -> usize {
        self.table.iter().filter(|record| record.age_us(now) <= self.timeout_us).count()
    }

    /// How many peers the swarm has.
    pub(crate) fn known(&self) -> usize {
        self.roster.radius_m.len() - usize::from(self.roster.radius_m.contains_key(&self.own))
    }

    /// Heap bytes held, the roster's apart.
    pub(crate) fn bytes(&self) -> usize {
        self.table.capacity() * size_of::<Record>()
    }

    pub(crate) fn counts(&self) -> BeaconCounts {
        self.counts
    }
}

/// What becomes of a beacon.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Intake {
    Take,
    Old,
    Duplicate,
    Own,
    Unknown,
    Malformed,
}

impl Record {
    fn new(now: Stamp, beacon: &Beacon, life: Option<&Self>) -> Self {
        let transit_us = now.as_micros() as i64 - beacon.sent.as_micros() as i64;
        let offset_us = life.map_or(transit_us, |life| {
            let since_us = now.as_micros().saturating_sub(life.received.as_micros());
            let drift_us = seconds(since_us) * DRIFT_US_PER_S;
            transit_us.min(life.offset_us.saturating_add(drift_us as i64))
        });
        let delay_us = transit_us.saturating_sub(offset_us).max(0) as u64;
        Self { beacon: *beacon, received: now, offset_us, delay_us, radius_m: 0.0 }
    }

    fn age_us(&self, now: Stamp) -> u64 {
        now.as_micros().saturating_sub(self.received.as_micros()).saturating_add(self.delay_us)
    }

    /// How far the peer may be from where its last velocity leads, metres.
    fn reach_m(&self, now: Stamp) -> f64 {
        let age_s = seconds(self.age_us(now));
        if age_s > SILENT_S { 0.0 } else { (A_UNSEEN_MPS2 * age_s * age_s / 2.0).min(REACH_M_MAX) }
    }

    fn neighbour(&self, pose_wb: Pose) -> Neighbour {
        let Beacon { robot: id, twist_b, accel_mps2, state, leader, .. } = self.beacon;
        Neighbour { id, pose_wb, twist_b, accel_mps2, state, leader, radius_m: self.radius_m }
    }
}

/// Microseconds as seconds.
fn seconds(us: u64) -> f64 {
    us as f64 * 1e-6
}

/// Whether a beacon's numbers can be a robot's. NaN fails every comparison and is refused with the rest.
fn plausible(beacon: &Beacon) -> bool {
    let pose = beacon.pose_wb;
    let twist = beacon.twist_b;
    let within = |value: f64, most: f64| value.abs() <= most;
    within(pose.x_m, PLACE_M_MAX)
        && within(pose.y_m, PLACE_M_MAX)
        && within(pose.yaw_rad, 7.0)
        && within(twist.speed_mps, RATE_MAX)
        && within(twist.yaw_rate_radps, RATE_MAX)
        && within(beacon.accel_mps2, RATE_MAX)
        && (0.0..=PLACE_M_MAX).contains(&beacon.pos_bound_m)
        && (0.0..=RADIUS_M_MAX).contains(&beacon.radius_m)
        && (0.0..=1.0).contains(&beacon.progress)
}

#[cfg(test)]
#[path = "peers_tests.rs"]
mod tests;
