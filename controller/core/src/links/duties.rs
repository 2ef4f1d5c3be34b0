//! What a robot does about its links in every tick, in this order.
//!
//! silent robots are given up -> links with a known way around are dropped -> wanted links -> proposals -> root

use super::centre::{End, better, between};
use super::gossip::Bound;
use super::local_mst::local_mst;
use super::peer::{Peer, Seen};
use super::{LinkPeer, Links, Place, bound};
use drover_contract::{LINKS_TOLD_MAX, RobotId, Stamp, Vec2, WEIGHT_M_MAX, on_grid_m};
use std::time::Duration;

/// Nobody is ready before: first of all the neighbours have to be heard, seconds.
const SETTLE_S: f64 = 2.0;
/// So many links of the swarm can be told around in about one term.
const EDGES_PER_TERM: u32 = 16;
/// A new link has to be that much shorter than the longest one on the way around.
const GAIN: f64 = 1.1;
/// What a robot asked for longer ago does not count, seconds.
const ASKED_S: f64 = 1.0;
/// Where a robot was longer ago is not where it is, seconds.
const SEEN_S: f64 = 1.0;
/// A proposal is expected to be heard within that time, seconds: the peer moves on meanwhile.
const UNHEARD_S: f64 = 0.2;

impl Links {
    /// Does what is due. `neighbours` are the robots heard not long ago; `metric` is this robot's own fitness as root:
    /// the smaller the better. From now on the robot has to stay in [`Links::discs`] as they are after this call.
    pub fn tick(&mut self, now: Stamp, place: &Place, neighbours: &[LinkPeer], metric: f64) {
        self.now = now;
        let new_term = self.terms.advance(now, self.params.term_s);
        if new_term {
            self.gossip.age(self.terms.now);
        }
        self.note_places(neighbours);
        self.give_up_silent();
        if self.gossip.take_news() || new_term {
            self.review();
        }
        self.want(place, neighbours);
        self.propose(place);
        self.roots.choose(now, metric);
        self.ready = self.ready || self.settled();
    }

    fn note_places(&mut self, neighbours: &[LinkPeer]) {
        for neighbour in neighbours {
            let age_us = (neighbour.age_s.clamp(0.0, 3600.0) * 1e6) as u64;
            let at = Stamp::from_micros(self.now.as_micros().saturating_sub(age_us));
            if let Some(peer) = self.peers.get_mut(&neighbour.id) {
                peer.seen = Some(Seen { at, pos_w: neighbour.pos_w, vel_w: neighbour.vel_w });
            }
        }
    }

    /// Links with robots that are silent for too long end, whatever they hold.
    fn give_up_silent(&mut self) {
        let (now, lost_s) = (self.now, self.params.lost_s);
        let silent = self.peers.iter().filter(|(_, peer)| peer.pair.binds() && peer.silent_s(now) > lost_s);
        let silent: Vec<RobotId> = silent.map(|(id, _)| *id).collect();
        for id in silent {
            // Where nothing was agreed it may just have gone out of range, and is not called dead for that.
            if self.holds(id) {
                self.note_loss(id, self.loss_of(id));
            }
            if let Some(peer) = self.peers.get_mut(&id) {
                peer.pair.abandon();
            }
        }
    }

    /// Drops every link that there is a known way around, and marks those for which there seems to be one.
    fn review(&mut self) {
        let (own, recent_min) = (self.own, self.recent_min());
        for (id, peer) in &mut self.peers {
            let Some(held) = peer.pair.held else { continue };
            if peer.pair.pending.is_none() && self.gossip.bypass(&bound(own, *id, &held)) {
                peer.pair.end();
                peer.rest_until = self.now + Duration::from_millis(super::REST_MS);
                peer.suspect = false;
                continue;
            }
            let recent = Bound { made_min: recent_min, ..bound(own, *id, &held) };
            peer.suspect = self.gossip.bypass(&recent);
        }
    }

    fn want(&mut self, place: &Place, neighbours: &[LinkPeer]) {
        let fresh = neighbours.iter().filter(|neighbour| neighbour.age_s <= SEEN_S);
        let sites = fresh.map(|neighbour| (neighbour.id, neighbour.pos_w));
        let mut chosen = local_mst((self.own, place.pos_w), sites, self.params.propose_range_m());
        chosen.retain(|id| !self.holds(*id) && !self.superfluous(*id, place));
        self.wanted.retain(|id, _| chosen.binary_search(id).is_ok());
        for id in chosen {
            self.wanted.entry(id).or_insert(self.now);
        }
    }

    /// Whether there seems to be a way around a link with `peer` over links that are not much longer.
    fn superfluous(&self, peer: RobotId, place: &Place) -> bool {
        let seen = self.peers.get(&peer).and_then(|peer| peer.seen);
        seen.is_some_and(|seen| {
            let weight_m = (seen.pos_w - place.pos_w).norm() * GAIN;
            let ends = (self.own.min(peer), self.own.max(peer));
            self.gossip.bypass(&Bound { ends, made_min: self.recent_min(), weight_m })
        })
    }

    /// Proposes first discs for wanted links, and better discs for own ones.
    fn propose(&mut self, place: &Place) {
        let own = End { pos_w: place.pos_w, wish_w: place.wish_w, reach_m: place.stop_m };
        let mut room = LINKS_TOLD_MAX.saturating_sub(self.kept().count());
        let owned: Vec<RobotId> = self.peers.range(self.own..).map(|(id, _)| *id).collect();
        for id in owned {
            let idle = |peer: &&Peer| peer.pair.pending.is_none() && peer.rest_until <= self.now;
            let Some(peer) = self.peers.get(&id).filter(idle) else { continue };
            let plan = match peer.pair.held {
                Some(_) => self.plan_next(peer, &own),
                None if room > 0 && self.asked_or_wanted(id, peer) => self.plan_first(id, peer, &own, place),
                None => None,
            };
            let Some((centre_w, made, weight_m)) = plan else { continue };
            if let Some(peer) = self.peers.get_mut(&id) {
                room -= usize::from(peer.pair.held.is_none());
                peer.pair.propose(centre_w, made, weight_m);
            }
        }
    }

    fn asked_or_wanted(&self, id: RobotId, peer: &Peer) -> bool {
        let asked = peer.asked.is_some_and(|at| self.now.since(at).as_secs_f64() <= ASKED_S);
        (asked || self.wanted.contains_key(&id)) && peer.silent_s(self.now) <= SEEN_S
    }

    /// A first disc: centre, term and weight.
    fn plan_first(&self, id: RobotId, peer: &Peer, own: &End, place: &Place) -> Option<(Vec2, u32, f64)> {
        let (seen, radius_m) = (self.fresh(peer)?, self.params.radius_m());
        let length_m = (seen.pos_w - own.pos_w).norm();
        if length_m > self.params.propose_range_m() || self.superfluous(id, place) {
            return None;
        }
        // It need not be sure: a refusal costs nothing yet.
        let there = End { pos_w: seen.pos_w, wish_w: seen.vel_w, reach_m: 0.0 };
        let centre_w = between(own, &there);
        own.fits(centre_w, radius_m).then_some((centre_w, self.terms.now, weight_m(length_m)))
    }

    /// A better disc for a link that is held, or the same one made anew: centre, term and weight.
    fn plan_next(&self, peer: &Peer, own: &End) -> Option<(Vec2, u32, f64)> {
        let (held, radius_m) = (peer.pair.held?, self.params.radius_m());
        let seen = self.fresh(peer);
        let shifted_w = seen.and_then(|seen| {
            let age_s = self.now.since(seen.at).as_secs_f64();
            // By then it may be anywhere in this reach; it has no more room to stop than we, going as fast.
            let reach_m = self.params.speed_mps_max * (age_s + UNHEARD_S) + own.reach_m;
            better(own, &End { pos_w: seen.pos_w, wish_w: seen.vel_w, reach_m }, held.centre_w, radius_m)
        });
        let round = |term: u32| term / self.round_terms();
        let due = round(self.terms.now) > round(held.made);
        let renew = due && !peer.suspect && own.fits(held.centre_w, radius_m);
        match (renew, shifted_w) {
            (true, _) => {
                let length_m = seen.map_or(held.weight_m, |seen| (seen.pos_w - own.pos_w).norm());
                Some((shifted_w.unwrap_or(held.centre_w), self.terms.now, weight_m(length_m)))
            }
            (false, Some(centre_w)) => Some((centre_w, held.made, held.weight_m)),
            (false, None) => None,
        }
    }

    /// Links are made anew once in so many terms: the more there are, the longer it takes until all have heard of all.
    fn round_terms(&self) -> u32 {
        (1 + self.gossip.count() / EDGES_PER_TERM).next_power_of_two()
    }

    /// What is known of links made earlier does not keep a link from being made (anew).
    fn recent_min(&self) -> u32 {
        self.terms.now.saturating_sub(4 + 4 * self.round_terms())
    }

    fn fresh(&self, peer: &Peer) -> Option<Seen> {
        peer.seen.filter(|seen| self.now.since(seen.at).as_secs_f64() <= SEEN_S)
    }

    /// Whether every link wanted from the start is agreed, or was asked for in vain for long enough.
    fn settled(&self) -> bool {
        let waits = |since: &Stamp| self.now.since(*since).as_secs_f64() <= self.params.lost_s;
        self.now.since(self.started).as_secs_f64() >= SETTLE_S && !self.wanted.values().any(waits)
    }
}

/// A length as a link's weight.
fn weight_m(length_m: f64) -> f64 {
    on_grid_m(length_m.min(WEIGHT_M_MAX))
}
