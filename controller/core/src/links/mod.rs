//! Link pacts: a swarm that moves in continuous time stays connected although messages are late, lost and reordered.
//!
//! # Discs
//! Two linked robots agree on a disc of half the radio's range (less a margin for errors); each stays in all its discs,
//! with the room that it needs to stop. Both in one disc are in range of each other. The end with the lower id, the
//! *owner*, moves the disc by proposing a new version (`pact.rs`). It stays in both until it hears the answer. The
//! other end changes over when it accepts, which it does only if it stands in the new disc; an answer stands for ever.
//! So at every moment the two ends have a disc in common, whatever the radio does: what is lost costs room, never a
//! link. Everything is state that is told again and again; who hears nothing stands in the end.
//!
//! # Which links may be dropped
//! Each link carries when it was *made* (a term of logical time) and its *weight* (its length then). A newer version
//! has them unchanged, or is made in a later term with the length of that day. Links are ordered: `f < e` if f was made
//! in a later term, or in the same one and `(weight, ids)` is smaller. *Either end may drop e if it knows of links
//! f1 .. fk, each of which existed at some time (however long ago), each `fi < e`, that form a path between e's ends.*
//! An owner whose proposal is open waits for the answer first.
//!
//! **Why that keeps the swarm connected.** A link exists from acceptance until one end drops it or a version replaces
//! it; as long as it exists, both ends obey its disc. Let X(t) be the links that exist at t. Claim S(t): for every link
//! f that ever existed by t, its ends are joined in X(t) by links g with `g <= f`. By induction over the events, in the
//! order in which they happen:
//! - A link is *accepted*: its own ends are joined by itself; all others are as before.
//! - A version *replaces* v: the new one is `<= v` and joins the same ends. Whoever used v uses it instead.
//! - e is *dropped*: by S just before, the ends of each fi are joined by links `<= fi < e`, thus without e; together
//!   they join e's ends without e by links `< e`. Whoever used e (so `e <= f`) uses these instead.
//!
//! In particular a drop never separates its own ends, so X stays connected once it is. Nothing is assumed about how
//! fresh the knowledge is, or about two ends of one cycle dropping at once: these are two events, in either order.
//! We ask for a little more (each fi no older *and* shorter), so that what remains tends to the minimum spanning tree.
//!
//! **What is not covered.** Deaths: a robot that died (or was silent for `lost_s`) takes its links along, and what was
//! dropped because of them is not brought back; the caller hears of it (`take_lost`) and leads orphans together. The
//! proof holds again among links made in terms after the last loss was declared, since for these it never looks at
//! older ones. To get there soon, `Departure`s void the facts that the dead left (`gossip.rs`). A robot that ended a
//! link and went out of range before the other end heard of it looks dead to that one too. Robots are honest.
//!
//! # Repairs of the plain rule
//! - A disc that moves within a term keeps what the link was made with, or links would run ahead of the clock and of
//!   those that could take their place. Terms follow whoever is ahead, so they need no common clock.
//! - Entries name the life of the robot they are meant for. Without that, an answer to an earlier life's version 1
//!   could be taken for the answer to this life's, and the owner would leave a disc that the other end accepts later.
//! - A link that seems to be bypassed but for the age of what is known is not made anew (*suspect*): otherwise the
//!   longest link of a ring that takes longer to gossip around than a term lasts would never be dropped.
//!
//! # Which links are wanted
//! Neighbours in the local minimum spanning tree (`local_mst.rs`) to which no path of shorter recent links is known.
//! `root.rs` elects a root over the kept links. Cost of a tick: the square of the robots in range, and for each own
//! link a search of the facts when there are new ones.

mod centre;
mod duties;
mod gossip;
mod local_mst;
mod pact;
mod peer;
mod root;

use drover_config::LINK_BEGUN_SHARE;
use drover_contract::{Departure, LINKS_TOLD_MAX, LinkEdge, LinkEntry, LinkReport, RobotId, Stamp, Vec2};
use gossip::{Bound, Gossip};
use pact::{Heard, Pact};
use peer::{Admission, Peer, Terms, admit};
use root::Roots;
use std::collections::BTreeMap;

/// Losses that nobody asks for are forgotten beyond so many.
const LOST_MAX: usize = 16;
/// After a refused proposal or a link's end, milliseconds until the next proposal to the same robot.
const REST_MS: u64 = 300;

/// How links are kept.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LinkParams {
    /// The radio reaches that far, metres.
    pub range_m: f64,
    /// How far a robot may be from where it believes to be, metres: taken off the radius, so both ends may err.
    pub margin_m: f64,
    /// No robot is faster, m/s.
    pub speed_mps_max: f64,
    /// How long a term of logical time lasts, seconds: a few times what a beacon takes. 1 to 2 is good.
    pub term_s: f64,
    /// A linked robot silent for longer is given up, seconds.
    pub lost_s: f64,
}

impl LinkParams {
    /// Radius of a link's disc, metres.
    #[must_use]
    pub fn radius_m(&self) -> f64 {
        self.range_m / 2.0 - self.margin_m
    }

    /// No longer link is proposed, metres: both ends have some room in their first disc.
    #[must_use]
    pub fn propose_range_m(&self) -> f64 {
        2.0 * LINK_BEGUN_SHARE * self.radius_m()
    }
}

/// Where this robot is and wants to go.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Place {
    /// Its position.
    pub pos_w: Vec2,
    /// Where it would like to move, m/s: discs are led ahead by it.
    pub wish_w: Vec2,
    /// How far it may still go until it stands, metres: 0 for a point.
    pub stop_m: f64,
}

/// A robot heard nearby, by its beacon.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LinkPeer {
    /// Which.
    pub id: RobotId,
    /// Where it was.
    pub pos_w: Vec2,
    /// How it moved, m/s.
    pub vel_w: Vec2,
    /// How long ago, seconds.
    pub age_s: f64,
}

/// A disc to stay in.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PactDisc {
    /// Its centre.
    pub centre_w: Vec2,
    /// Its radius, metres.
    pub radius_m: f64,
    /// With whom it was agreed (or is being agreed).
    pub peer: RobotId,
}

/// A link that ended because its other end was lost.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LostLink {
    /// The other end.
    pub peer: RobotId,
    /// It was heard again, in a new life; else it was silent for `lost_s`.
    pub restarted: bool,
    /// Where its last beacon said that it was.
    pub pos_w: Option<Vec2>,
    /// With whom its last report said that it was linked.
    pub linked: [Option<RobotId>; LINKS_TOLD_MAX],
}

/// The links of one robot.
#[derive(Clone, Debug)]
pub struct Links {
    own: RobotId,
    epoch: u32,
    params: LinkParams,
    started: Stamp,
    now: Stamp,
    seq: u32,
    terms: Terms,
    peers: BTreeMap<RobotId, Peer>,
    gossip: Gossip,
    roots: Roots,
    /// With whom a link is wanted and not held, and since when.
    wanted: BTreeMap<RobotId, Stamp>,
    lost: Vec<LostLink>,
    ready: bool,
}

impl Links {
    /// Of robot `own` in its life `epoch`, which begins now and without links.
    #[must_use]
    pub fn new(own: RobotId, epoch: u32, params: LinkParams, now: Stamp) -> Self {
        Self {
            own,
            epoch,
            params,
            started: now,
            now,
            seq: 0,
            terms: Terms::new(now),
            peers: BTreeMap::new(),
            gossip: Gossip::default(),
            roots: Roots::new(own, now),
            wanted: BTreeMap::new(),
            lost: Vec::new(),
            ready: false,
        }
    }

    /// Takes what another robot reports. A proposal in it is accepted if this robot, at `place`, stands in its disc;
    /// from then on the robot has to stay in [`Links::discs`] as they are after this call.
    pub fn handle_report(&mut self, now: Stamp, report: &LinkReport, place: &Place) {
        let sender = report.robot;
        if sender == self.own {
            return;
        }
        let before = self.loss_of(sender);
        match admit(&mut self.peers, now, self.params.lost_s, report, self.own < sender) {
            Admission::Refused => return,
            Admission::Newer => {}
            Admission::Restarted => self.note_loss(sender, before.map(|loss| LostLink { restarted: true, ..loss })),
        }
        self.terms.hear(now, report.term);
        self.learn(now, report);
        let own_entry = |entry: &&LinkEntry| entry.peer == self.own && entry.peer_epoch == self.epoch as u16;
        if let Some(entry) = report.links.iter().flatten().find(own_entry) {
            self.hear_entry(now, sender, entry, place);
        }
        if self.holds(sender) {
            self.roots.hear(now, &report.root);
        }
    }

    fn learn(&mut self, now: Stamp, report: &LinkReport) {
        let kept = report.links.iter().flatten().filter(|entry| entry.holds && !entry.proposes);
        kept.for_each(|entry| self.gossip.learn(&edge(report.robot, entry.peer, entry.made, entry.weight_m)));
        report.edges.iter().flatten().for_each(|edge| self.gossip.learn(edge));
        match report.gone {
            // Others believe that we died: only links made later than that count for them.
            Some(gone) if gone.robot == self.own => self.terms.hear(now, gone.term.saturating_add(1)),
            Some(gone) => self.gossip.depart(gone),
            None => {}
        }
    }

    /// What `sender` says of its link with this robot.
    fn hear_entry(&mut self, now: Stamp, sender: RobotId, entry: &LinkEntry, place: &Place) {
        let room = self.kept().count() < LINKS_TOLD_MAX;
        let radius_m = self.params.radius_m();
        let (own, gossip) = (self.own, &self.gossip);
        let Some(peer) = self.peers.get_mut(&sender) else { return };
        peer.claims = entry.holds || entry.proposes;
        peer.asked = if entry.asks { Some(now) } else { peer.asked };
        let heard = if own < sender {
            peer.pair.hear_answer(entry)
        } else {
            peer.pair.hear_owner(entry, |offered, held| {
                let inside = (place.pos_w - offered.centre_w).norm() + place.stop_m <= radius_m;
                // A link that could be dropped at once is not begun.
                inside && (held.is_some() || (room && !gossip.bypass(&bound(own, sender, offered))))
            })
        };
        match heard {
            Heard::Nothing => {}
            Heard::Refused | Heard::Ended => peer.rest_until = now + std::time::Duration::from_millis(REST_MS),
            Heard::Agreed => {
                peer.suspect = false;
                if let Some(held) = peer.pair.held {
                    self.gossip.learn(&edge(own, sender, held.made, held.weight_m));
                }
            }
        }
    }

    /// What to broadcast now.
    pub fn report(&mut self, now: Stamp) -> LinkReport {
        self.now = now;
        self.seq = self.seq.saturating_add(1);
        LinkReport {
            robot: self.own,
            epoch: self.epoch,
            seq: self.seq,
            term: self.terms.now,
            root: self.roots.best(),
            links: self.entries(),
            edges: self.gossip.tell(self.own),
            gone: self.gossip.tell_gone(),
        }
    }

    /// Entries for those who need one, who waits longest first.
    fn entries(&mut self) -> [Option<LinkEntry>; LINKS_TOLD_MAX] {
        let (own, now, lost_s) = (self.own, self.now, self.params.lost_s);
        let wanted = &self.wanted;
        let asks = |id: RobotId| id < own && wanted.contains_key(&id);
        let needs =
            |id: RobotId, peer: &Peer| peer.pair.binds() || (peer.silent_s(now) <= lost_s && (peer.claims || asks(id)));
        let mut due: Vec<_> = self.peers.iter_mut().filter(|(id, peer)| needs(**id, peer)).collect();
        due.sort_by_key(|(id, peer)| (peer.told, **id));
        let mut entries = [None; LINKS_TOLD_MAX];
        for (place, (id, peer)) in entries.iter_mut().zip(due) {
            peer.told = self.seq;
            *place = Some(LinkEntry { asks: asks(*id), ..peer.pair.entry(*id, peer.epoch) });
        }
        entries
    }

    /// The discs to stay in.
    pub fn discs(&self) -> impl Iterator<Item = PactDisc> + '_ {
        let radius_m = self.params.radius_m();
        let pacts = self.peers.iter().flat_map(|(id, peer)| {
            let both = [peer.pair.held, peer.pair.pending];
            both.into_iter().flatten().map(|pact| (*id, pact))
        });
        pacts.map(move |(peer, pact)| PactDisc { centre_w: pact.centre_w, radius_m, peer })
    }

    /// With whom a link is held or being agreed.
    pub fn kept(&self) -> impl Iterator<Item = RobotId> + '_ {
        self.peers.iter().filter(|(_, peer)| peer.pair.binds()).map(|(id, _)| *id)
    }

    /// Whether a link with `peer` is held or being agreed.
    #[must_use]
    pub fn relies_on(&self, peer: RobotId) -> bool {
        self.peers.get(&peer).is_some_and(|peer| peer.pair.binds())
    }

    /// Whether a link with `peer` is agreed, as far as this robot knows.
    #[must_use]
    pub fn holds(&self, peer: RobotId) -> bool {
        self.peers.get(&peer).is_some_and(|peer| peer.pair.held.is_some())
    }

    /// Whom the election chose, maybe this robot itself.
    #[must_use]
    pub fn root(&self) -> RobotId {
        self.roots.best().root
    }

    /// What it offers: the smallest metric of the robots that are linked.
    #[must_use]
    pub fn root_metric(&self) -> f64 {
        f64::from(self.roots.best().metric)
    }

    /// The linked robot that is next on the way to the root; `None` for the root itself, and while no way is known.
    #[must_use]
    pub fn parent(&self) -> Option<RobotId> {
        let held = self.peers.iter().filter(|(_, peer)| peer.pair.held.is_some());
        self.roots.parent(held.map(|(id, peer)| (*id, peer.offer)))
    }

    /// Whether the robot may leave its first place: links with its neighbours are agreed, or given up. Stays so.
    #[must_use]
    pub fn ready(&self) -> bool {
        self.ready
    }

    /// Robots that were given up, here or elsewhere, and not heard of since.
    pub fn gone(&self) -> impl Iterator<Item = RobotId> + '_ {
        let heard = |id: &RobotId| self.peers.get(id).is_some_and(|peer| peer.silent_s(self.now) <= self.params.lost_s);
        self.gossip.gone().filter(move |id| !heard(id))
    }

    /// The links lost by death since this was last asked, the oldest first.
    pub fn take_lost(&mut self) -> Vec<LostLink> {
        std::mem::take(&mut self.lost)
    }

    /// What would be lost with `robot`, if anything binds this one to it.
    fn loss_of(&self, robot: RobotId) -> Option<LostLink> {
        let peer = self.peers.get(&robot).filter(|peer| peer.pair.binds())?;
        let pos_w = peer.seen.map(|seen| seen.pos_w);
        Some(LostLink { peer: robot, restarted: false, pos_w, linked: peer.linked })
    }

    /// A robot died, as far as this one can know. Even if nothing was lost with it, what others tell of its earlier
    /// life is void.
    fn note_loss(&mut self, robot: RobotId, loss: Option<LostLink>) {
        self.gossip.depart(Departure { robot, term: self.terms.now });
        self.lost.extend(loss);
        if self.lost.len() > LOST_MAX {
            self.lost.remove(0);
        }
    }
}

/// A link as it is told.
fn edge(a: RobotId, b: RobotId, made: u32, weight_m: f64) -> LinkEdge {
    LinkEdge { low: a.min(b), high: a.max(b), made, weight_m }
}

/// What has to be known to drop `pact`.
fn bound(a: RobotId, b: RobotId, pact: &Pact) -> Bound {
    Bound { ends: (a.min(b), a.max(b)), made_min: pact.made, weight_m: pact.weight_m }
}

#[cfg(test)]
mod testing;
#[cfg(test)]
mod tests;
