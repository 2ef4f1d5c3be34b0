//! One robot that knows its peers by beacons: late, with losses, at moments of its own.
//!
//! What the paper takes from a snapshot comes from elsewhere here. Links are kept by agreement ([`crate::links`]): the
//! discs that both ends have agreed on stand for C, whatever the radio loses. The parent is the next robot on the way
//! to an elected root. Who goes where is known beforehand from the swarm's file; when a robot is given up for lost,
//! each of the others works out from the same list who takes its place, without a word.
//!
//! **Rescue**: whoever loses a link by a death and does not hear all who were linked with the dead goes to where it was
//! last heard, as the root of its part of the network; its part is towed. There the parts hear each other.
//!
//! **Each robot needs** its peers' places (beacons), their links and the root (reports, see `DROVER_LINKS`), and who is
//! gone (reports, passed on). Ids are ranks into the list of targets.

use super::Params;
use super::pilot::{Pilot, Sight};
use super::places::Places;
use crate::avoid::{Capsule, Disc};
use crate::law::pacts::TERM_S;
use crate::links::{LinkParams, LinkPeer, Links, Place};
use drover_config::Deploy;
use drover_contract::{LinkReport, RobotId, Stamp, Vec2};
use std::sync::Arc;
use std::time::Duration;

/// A rescue is given up after this long, seconds.
const RESCUE_S_MAX: u64 = 30;
/// Who was heard within this time is in range, seconds.
const HEARD_S: f64 = 1.5;
/// Only who is nearer than this share of the range is sure to be linked with before it is out of range again.
const NEAR_SHARE: f64 = 0.85;
/// A metric that goes before every distance: who rescues leads its part.
const RESCUE_METRIC: f64 = -1.0;

/// A robot of a deployment that hears its peers.
#[derive(Clone, Debug)]
pub struct Teammate {
    params: Params,
    own: RobotId,
    pilot: Pilot,
    links: Links,
    places: Arc<Places>,
    rescue: Option<Rescue>,
    gone: Vec<RobotId>,
}

/// On the way to where a robot was lost.
#[derive(Clone, Debug)]
struct Rescue {
    to_w: Vec2,
    since: Stamp,
    /// Who else was linked with it.
    others: Vec<RobotId>,
}

/// A robot's surroundings when it decides; world frame, metres.
#[derive(Clone, Copy, Debug)]
pub struct Around<'a> {
    /// Where it is.
    pub at_w: Vec2,
    /// Whom it hears, sorted by id; as told and not carried forward.
    pub peers: &'a [LinkPeer],
    /// Walls nearby.
    pub walls: &'a [Capsule],
    /// Since it last decided, seconds.
    pub dt_s: f64,
}

impl Teammate {
    /// Robot `own` in its life `epoch`. `margin_m` is by how much positions may be wrong.
    #[must_use]
    pub fn new(deploy: &Deploy, places: Arc<Places>, own: (RobotId, u32), margin_m: f64, now: Stamp) -> Self {
        Self::with_params(Params::of(deploy), deploy, places, own, (margin_m, now))
    }

    /// The same with parameters of its own.
    pub(super) fn with_params(
        params: Params,
        deploy: &Deploy,
        places: Arc<Places>,
        own: (RobotId, u32),
        (margin_m, now): (f64, Stamp),
    ) -> Self {
        let links = LinkParams {
            range_m: deploy.range_m,
            margin_m,
            speed_mps_max: deploy.speed_mps,
            term_s: TERM_S,
            lost_s: deploy.peer_lost_s,
        };
        let target_w = places.target_w(own.0, &[]).unwrap_or(params.goal_w);
        Self {
            own: own.0,
            links: Links::new(own.0, own.1, links, now),
            pilot: Pilot::new(target_w),
            params,
            places,
            rescue: None,
            gone: Vec::new(),
        }
    }

    /// Takes what a peer reports of its links. Afterwards [`Teammate::discs`] may be others.
    pub fn handle_report(&mut self, now: Stamp, report: &LinkReport, place: &Place) {
        self.links.handle_report(now, report, place);
    }

    /// Does what is due about links, at the beacons' rate. Afterwards [`Teammate::discs`] may be others.
    pub fn attend(&mut self, now: Stamp, place: &Place, peers: &[LinkPeer]) {
        let to_layout_m = (place.pos_w - self.params.goal_w).norm();
        let metric = if self.rescue.is_some() { RESCUE_METRIC } else { to_layout_m };
        self.links.tick(now, place, peers, metric);
        self.mind_losses(now, place.pos_w, peers);
        let gone: Vec<RobotId> = self.links.gone().collect();
        if gone != self.gone {
            self.gone = gone;
            if let Some(target_w) = self.places.target_w(self.own, &self.gone) {
                self.pilot.retarget(target_w);
            }
        }
    }

    fn mind_losses(&mut self, now: Stamp, at_w: Vec2, peers: &[LinkPeer]) {
        for loss in self.links.take_lost() {
            let others: Vec<RobotId> = loss.linked.into_iter().flatten().filter(|id| *id != self.own).collect();
            if let Some(to_w) = loss.pos_w.filter(|_| !loss.restarted && !others.is_empty()) {
                self.rescue = Some(Rescue { to_w, since: now, others });
            }
        }
        let near_m = NEAR_SHARE * self.params.range_m;
        let near = |peer: &LinkPeer| peer.age_s <= HEARD_S && (peer.pos_w - at_w).norm() <= near_m;
        let heard = |id: &RobotId| peers.iter().any(|peer| peer.id == *id && near(peer));
        let gone: Vec<RobotId> = self.links.gone().collect();
        let over = |rescue: &Rescue| {
            let all_heard = rescue.others.iter().all(|id| heard(id) || gone.contains(id));
            all_heard || now.since(rescue.since) > Duration::from_secs(RESCUE_S_MAX)
        };
        if self.rescue.as_ref().is_some_and(over) {
            self.rescue = None;
        }
    }

    /// What to tell of the links.
    pub fn report(&mut self, now: Stamp) -> LinkReport {
        self.links.report(now)
    }

    /// C: where the robot has to stay whatever it hears.
    pub fn discs(&self) -> impl Iterator<Item = Disc> + '_ {
        self.links.discs().map(|disc| Disc { centre_w: disc.centre_w, radius_m: disc.radius_m })
    }

    /// Whether a link with `peer` is held or being agreed.
    #[must_use]
    pub fn relies_on(&self, peer: RobotId) -> bool {
        self.links.relies_on(peer)
    }

    /// Whether it may leave its first place: its links are agreed.
    #[must_use]
    pub fn is_ready(&self) -> bool {
        self.links.ready()
    }

    /// Where it is to go.
    #[must_use]
    pub fn target_w(&self) -> Vec2 {
        self.pilot.target_w()
    }

    /// Whether it is there.
    #[must_use]
    pub fn has_arrived(&self, at_w: Vec2) -> bool {
        self.rescue.is_none() && self.pilot.has_arrived(&self.params, at_w)
    }

    /// The law's wish for the next period: a displacement, metres, world frame.
    pub fn wish(&mut self, around: &Around<'_>) -> Vec2 {
        if !self.is_ready() {
            return Vec2::zeros();
        }
        let peers_w: Vec<Vec2> = around.peers.iter().map(|peer| peer.pos_w).collect();
        let place_of = |id: RobotId| around.peers.iter().find(|peer| peer.id == id).map(|peer| peer.pos_w);
        let linked_w: Vec<Vec2> = self.links.kept().filter_map(place_of).collect();
        let towed = self.links.root_metric() < 0.0;
        let rescue_w = self.rescue.as_ref().filter(|_| self.links.root() == self.own).map(|rescue| rescue.to_w);
        let sight = Sight {
            at_w: around.at_w,
            peers_w: &peers_w,
            linked_w: &linked_w,
            parent_w: self.links.parent().and_then(place_of),
            parent_aim_w: None,
            walls: around.walls,
            goal_aim_w: rescue_w.unwrap_or(if self.pilot.is_close() { self.target_w() } else { self.params.goal_w }),
            target_aim_w: rescue_w.unwrap_or_else(|| self.pilot.target_w()),
            towed,
            hurry: rescue_w.is_some(),
            dt_s: around.dt_s,
        };
        self.pilot.wish(&self.params, &sight)
    }

    /// The law's parameters.
    #[must_use]
    pub fn params(&self) -> &Params {
        &self.params
    }

    /// Chooses the move for `wish` within `set`.
    pub fn steer(&mut self, set: &crate::avoid::SafeSet, wish: Vec2) -> Vec2 {
        self.pilot.steer(&self.params, set.at_w(), wish, Some(set))
    }
}
