//! Which robot is the root of the kept links, and the way to it: a distance-vector election.
//!
//! Every robot offers itself; the smallest metric wins, then the smallest id. A root raises its own sequence number all
//! the time, and offers of it travel over kept links with the hops counted. A robot takes an offer only if its number
//! is newer, or equal and over fewer hops: what it offers of one root therefore only ever gets better, a parent's offer
//! is better than a child's, and no loop can close (C. Perkins, P. Bhagwat, "Highly dynamic destination-sequenced
//! distance-vector routing", SIGCOMM 1994). A number that has not risen for `FRESH_S` is of a root that is not there.

use drover_contract::{RobotId, RootOffer, Stamp};
use std::cmp::Ordering;

/// How often a root raises its number, microseconds.
const BEAT_US: u64 = 250_000;
/// A root whose number has not risen for longer is not there, seconds.
const FRESH_S: f64 = 3.0;
/// After that long it is forgotten: a root that starts anew may count from anywhere, seconds.
const FORGET_S: f64 = 10.0;
/// Roots held: those in use and those on their way out.
const ROOTS_MAX: usize = 16;

#[derive(Clone, Copy, Debug)]
struct Known {
    /// As this robot offers it on.
    offer: RootOffer,
    /// When its number last rose.
    risen: Stamp,
}

/// What one robot knows of roots.
#[derive(Clone, Debug)]
pub(super) struct Roots {
    own: RobotId,
    metric: f32,
    known: Vec<Known>,
    best: RootOffer,
}

impl Roots {
    pub(super) fn new(own: RobotId, now: Stamp) -> Self {
        let best = RootOffer { root: own, metric: f32::MAX, seq: beat(now), hops: 0 };
        Self { own, metric: f32::MAX, known: Vec::new(), best }
    }

    /// An offer heard over a kept link.
    pub(super) fn hear(&mut self, now: Stamp, heard: &RootOffer) {
        if heard.root == self.own {
            return;
        }
        let offer = RootOffer { hops: heard.hops.saturating_add(1), ..*heard };
        let new = Known { offer, risen: now };
        if let Some(known) = self.known.iter_mut().find(|known| known.offer.root == heard.root) {
            if newer(offer.seq, known.offer.seq) {
                *known = new;
            } else if offer.seq == known.offer.seq && offer.hops < known.offer.hops {
                known.offer = offer;
            }
        } else if self.known.len() < ROOTS_MAX {
            self.known.push(new);
        } else if let Some(worst) = self.known.iter_mut().max_by(|a, b| rank(&a.offer, &b.offer))
            && rank(&offer, &worst.offer) == Ordering::Less
        {
            *worst = new;
        }
    }

    /// Chooses anew; `metric` is this robot's own figure.
    pub(super) fn choose(&mut self, now: Stamp, metric: f64) {
        self.metric =
            if metric.is_finite() { metric.clamp(-f64::from(f32::MAX), f64::from(f32::MAX)) as f32 } else { f32::MAX };
        self.known.retain(|known| now.since(known.risen).as_secs_f64() <= FORGET_S);
        let own = RootOffer { root: self.own, metric: self.metric, seq: beat(now), hops: 0 };
        let fresh = self.known.iter().filter(|known| now.since(known.risen).as_secs_f64() <= FRESH_S);
        let best = fresh.map(|known| known.offer).min_by(rank);
        self.best = best.filter(|best| rank(best, &own) == Ordering::Less).unwrap_or(own);
    }

    /// The best root, as this robot offers it.
    pub(super) fn best(&self) -> RootOffer {
        self.best
    }

    /// The next on the way to the root, of those at the other ends of kept links and what they last offered.
    pub(super) fn parent(&self, offers: impl Iterator<Item = (RobotId, RootOffer)>) -> Option<RobotId> {
        if self.best.root == self.own {
            return None;
        }
        let nearer = |offer: &RootOffer| {
            let fewer = offer.seq == self.best.seq && offer.hops < self.best.hops;
            offer.root == self.best.root && (fewer || newer(offer.seq, self.best.seq))
        };
        // Numbers lie close together: how far one is behind ours orders them all.
        let behind = |offer: &RootOffer| self.best.seq.wrapping_sub(offer.seq).cast_signed();
        offers
            .filter(|(_, offer)| nearer(offer))
            .min_by_key(|(id, offer)| (behind(offer), offer.hops, *id))
            .map(|(id, _)| id)
    }
}

/// A root's number at a moment: it rises as long as the root lives.
fn beat(now: Stamp) -> u16 {
    (now.as_micros() / BEAT_US) as u16
}

fn rank(a: &RootOffer, b: &RootOffer) -> Ordering {
    a.metric.total_cmp(&b.metric).then(a.root.cmp(&b.root))
}

fn newer(a: u16, b: u16) -> bool {
    a.wrapping_sub(b).cast_signed() > 0
}

#[cfg(test)]
mod tests {
    use super::*;

    fn offer(root: u32, metric: f32, seq: u16, hops: u8) -> RootOffer {
        RootOffer { root: RobotId(root), metric, seq, hops }
    }

    #[test]
    fn the_best_metric_wins_and_the_way_has_the_fewest_hops_of_the_newest_number() {
        let mut roots = Roots::new(RobotId(9), Stamp::ZERO);
        let offers =
            [(RobotId(1), offer(5, 2.0, 7, 3)), (RobotId(2), offer(5, 2.0, 7, 2)), (RobotId(3), offer(6, 2.5, 1, 0))];
        offers.iter().for_each(|(_, offer)| roots.hear(Stamp::ZERO, offer));
        roots.choose(Stamp::ZERO, 4.0);
        assert_eq!(roots.best(), offer(5, 2.0, 7, 3));
        assert_eq!(roots.parent(offers.into_iter()), Some(RobotId(2)));
        roots.choose(Stamp::ZERO, 1.0);
        assert!(roots.best().root == RobotId(9) && roots.parent(offers.into_iter()).is_none());
    }

    #[test]
    fn a_root_that_does_not_rise_ages_out_and_echoes_do_not_revive_it() {
        let mut roots = Roots::new(RobotId(9), Stamp::ZERO);
        for ms in (0..=8_000).step_by(100) {
            let seq = if ms < 1_000 { ms as u16 } else { 1_000 };
            roots.hear(Stamp::from_millis(ms), &offer(5, 2.0, seq, (ms / 100) as u8));
            roots.choose(Stamp::from_millis(ms), 4.0);
            assert_eq!(roots.best().root == RobotId(5), ms <= 4_000, "at {ms} ms");
        }
    }

    #[test]
    fn roots_held_are_bounded_and_the_worst_gives_way() {
        let mut roots = Roots::new(RobotId(900), Stamp::ZERO);
        (1..200).for_each(|id| roots.hear(Stamp::ZERO, &offer(id, 300.0 - id as f32, 1, 1)));
        roots.choose(Stamp::ZERO, f64::NAN);
        assert!(roots.known.len() == ROOTS_MAX && roots.best().root == RobotId(199));
    }
}
