//! The links of a flock's robot on a body: pacts ([`crate::links`]), within its party.
//!
//! Two flocks that meet are not tied together: what another party reports is not read. The root that pacts elect is of
//! no matter here. A mate that dies takes its links along; whom it had joined are drawn together by the flock's forces
//! alone.

use super::{Params, is_within};
use crate::avoid::Disc;
use crate::law::pacts::TERM_S;
use crate::links::{LinkParams, LinkPeer, Links, Place};
use drover_contract::{LinkReport, RobotId, Stamp};

/// A linked mate silent for longer is given up, seconds.
const LOST_S: f64 = 3.0;

/// One robot's links.
#[derive(Clone, Debug)]
pub(super) struct Ties {
    links: Links,
    party: (u32, u32),
}

impl Ties {
    /// Of a robot in its life `epoch`, links as long as `range_m`, with positions that may be wrong by `margin_m`.
    pub(super) fn new(params: &Params, (range_m, margin_m): (f64, f64), epoch: u32, now: Stamp) -> Self {
        let speed_mps_max = params.speed_mps.max(params.leader_speed_mps);
        let links = LinkParams { range_m, margin_m, speed_mps_max, term_s: TERM_S, lost_s: LOST_S };
        Self { links: Links::new(params.own, epoch, links, now), party: params.party }
    }

    pub(super) fn handle_report(&mut self, now: Stamp, report: &LinkReport, place: &Place) {
        if is_within(self.party, report.robot) {
            self.links.handle_report(now, report, place);
        }
    }

    pub(super) fn attend(&mut self, now: Stamp, place: &Place, peers: &[LinkPeer], leads: bool) -> LinkReport {
        let mates: Vec<LinkPeer> = peers.iter().filter(|peer| is_within(self.party, peer.id)).copied().collect();
        self.links.tick(now, place, &mates, if leads { 0.0 } else { 1.0 });
        self.links.take_lost();
        self.links.report(now)
    }

    pub(super) fn discs(&self) -> impl Iterator<Item = Disc> + '_ {
        self.links.discs().map(|disc| Disc { centre_w: disc.centre_w, radius_m: disc.radius_m })
    }

    /// Whether the robot may leave its first place: its links are agreed.
    pub(super) fn is_ready(&self) -> bool {
        self.links.ready()
    }

    pub(super) fn relies_on(&self, peer: RobotId) -> bool {
        self.links.relies_on(peer)
    }
}
