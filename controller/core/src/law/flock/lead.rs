//! Who leads a party, and who takes over when its leader is lost.
//!
//! A leader is never taken by accident: a robot follows the leader that its file names, or, with
//! `leader_loss = "elect"`, a mate of its party that *says* in its beacon that it leads itself. Of those who may, the
//! file's leader comes first and then the lowest id. Who hears of no leader for `ELECT` and would be the first of those
//! that it hears claims the lead; who leads and hears a claim that comes before its own gives it up. Two parts of a
//! party that do not hear each other may have a leader each; they agree when they meet.

use super::{Params, is_mate};
use crate::law::{View, leads};
use crate::peers::Neighbour;
use drover_config::{Flock, LeaderLoss};
use drover_contract::{BehaviourState, RobotId, Stamp};
use std::time::Duration;

/// A leader silent for this long is lost: longer than any robot's own timeout for peers.
const ELECT: Duration = Duration::from_secs(3);

/// Who leads, as this robot sees it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Lead {
    own: RobotId,
    named: RobotId,
    elects: bool,
    now: RobotId,
    heard: Option<Stamp>,
}

impl Lead {
    pub(super) fn new(flock: &Flock, own: RobotId) -> Self {
        let named = flock.party_of(own.0).map_or(own, |party| RobotId(party.leader));
        Self { own, named, elects: flock.leader_loss == LeaderLoss::Elect, now: named, heard: None }
    }

    /// Whom to follow from now on.
    pub(super) fn decide(&mut self, params: &Params, view: &View<'_>) -> RobotId {
        if !self.elects {
            return self.named;
        }
        let claims = |peer: &&Neighbour| peer.leader == Some(peer.id) && is_mate(params, peer) && leads(peer.state);
        let first = view.neighbours.iter().filter(claims).map(|peer| peer.id).min_by_key(|id| self.rank(*id));
        match first {
            Some(first) if self.now != self.own || self.rank(first) < self.rank(self.own) => self.now = first,
            _ => {}
        }
        if self.now == self.own || first == Some(self.now) {
            self.heard = Some(view.now);
        }
        let since = *self.heard.get_or_insert(view.now);
        if view.now.since(since) >= ELECT && self.is_first(params, view) {
            self.now = self.own;
            self.heard = Some(view.now);
        }
        self.now
    }

    /// The file's leader comes before everybody, then the lowest id.
    fn rank(&self, id: RobotId) -> (bool, u32) {
        (id != self.named, id.0)
    }

    fn is_first(&self, params: &Params, view: &View<'_>) -> bool {
        let able = |peer: &&Neighbour| is_mate(params, peer) && peer.state != BehaviourState::Stopped;
        view.neighbours.iter().filter(able).all(|peer| self.rank(self.own) < self.rank(peer.id))
    }
}
