//! What a robot remembers of another one, and its logical time.

use super::pact::Pair;
use drover_contract::{LINKS_TOLD_MAX, LinkReport, RobotId, RootOffer, Stamp, Vec2};
use std::collections::BTreeMap;

/// Robots remembered.
pub(super) const PEERS_MAX: usize = 256;

/// Another robot.
#[derive(Clone, Debug)]
pub(super) struct Peer {
    pub(super) epoch: u32,
    seq: u32,
    /// When its newest report came.
    pub(super) heard: Stamp,
    /// Where its beacon said it was, when, and how it moved.
    pub(super) seen: Option<Seen>,
    pub(super) pair: Pair,
    /// Its best root.
    pub(super) offer: RootOffer,
    /// With whom it was linked.
    pub(super) linked: [Option<RobotId>; LINKS_TOLD_MAX],
    /// It believes to have a link with us, or proposes one: it gets an answer.
    pub(super) claims: bool,
    /// When it last asked us to propose.
    pub(super) asked: Option<Stamp>,
    /// A path around the link seems to exist: better not renewed, so that it can be dropped.
    pub(super) suspect: bool,
    /// No proposal before that.
    pub(super) rest_until: Stamp,
    /// The report in which it last had an entry.
    pub(super) told: u32,
}

/// Where a robot was.
#[derive(Clone, Copy, Debug)]
pub(super) struct Seen {
    pub(super) at: Stamp,
    pub(super) pos_w: Vec2,
    pub(super) vel_w: Vec2,
}

/// What becomes of a report.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Admission {
    /// Older than what is known, or there is no room.
    Refused,
    Newer,
    /// The sender lives anew since it was last heard: links with its earlier life ended with that.
    Restarted,
}

impl Peer {
    fn new(now: Stamp, report: &LinkReport) -> Self {
        Self {
            epoch: report.epoch,
            seq: report.seq,
            heard: now,
            seen: None,
            pair: Pair::new(),
            offer: report.root,
            linked: [None; LINKS_TOLD_MAX],
            claims: false,
            asked: None,
            suspect: false,
            rest_until: now,
            told: 0,
        }
    }

    /// Takes what a newer report says about its sender.
    fn note(&mut self, now: Stamp, report: &LinkReport) {
        (self.epoch, self.seq, self.heard, self.offer) = (report.epoch, report.seq, now, report.root);
        self.linked = report.links.map(|link| link.filter(|link| link.holds).map(|link| link.peer));
    }

    pub(super) fn silent_s(&self, now: Stamp) -> f64 {
        now.since(self.heard).as_secs_f64()
    }
}

/// Takes a report in, if it is the newest of its sender's newest life. `own` has the lower id of the two: it owns.
pub(super) fn admit(
    peers: &mut BTreeMap<RobotId, Peer>,
    now: Stamp,
    forget_s: f64,
    report: &LinkReport,
    owns: bool,
) -> Admission {
    if let Some(peer) = peers.get_mut(&report.robot) {
        if (report.epoch, report.seq) <= (peer.epoch, peer.seq) {
            return Admission::Refused;
        }
        let restarted = report.epoch > peer.epoch;
        if restarted {
            // An owner's versions start again with its life; our own proposals to it go on.
            if owns {
                peer.pair.abandon()
            } else {
                peer.pair.restart()
            }
            (peer.claims, peer.asked, peer.suspect) = (false, None, false);
        }
        peer.note(now, report);
        return if restarted { Admission::Restarted } else { Admission::Newer };
    }
    if peers.len() >= PEERS_MAX && !forget_one(peers, now, forget_s) {
        return Admission::Refused;
    }
    let mut peer = Peer::new(now, report);
    peer.note(now, report);
    peers.insert(report.robot, peer);
    Admission::Newer
}

/// Makes room: who is silent longest, if nothing binds us and none of its messages can be on its way any more.
fn forget_one(peers: &mut BTreeMap<RobotId, Peer>, now: Stamp, forget_s: f64) -> bool {
    let idle = peers.iter().filter(|(_, peer)| !peer.pair.binds() && peer.silent_s(now) > forget_s);
    let oldest = idle.min_by_key(|(_, peer)| peer.heard).map(|(id, _)| *id);
    oldest.is_some_and(|id| peers.remove(&id).is_some())
}

/// Logical time in terms: counts with the own clock, and follows whoever is ahead.
#[derive(Clone, Copy, Debug)]
pub(super) struct Terms {
    pub(super) now: u32,
    since: Stamp,
}

impl Terms {
    /// Nothing is made in term 0, which stands for an unknown age.
    pub(super) fn new(now: Stamp) -> Self {
        Self { now: 1, since: now }
    }

    /// Whether a term began.
    pub(super) fn advance(&mut self, now: Stamp, term_s: f64) -> bool {
        let due = now.since(self.since).as_secs_f64() >= term_s;
        if due {
            (self.now, self.since) = (self.now.saturating_add(1), now);
        }
        due
    }

    /// Somebody is in `term`. The own clock starts anew from there, or two clocks would drive each other.
    pub(super) fn hear(&mut self, now: Stamp, term: u32) {
        if term > self.now {
            (self.now, self.since) = (term, now);
        }
    }
}
