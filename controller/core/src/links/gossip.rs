//! What is known of links anywhere: that they existed, how long they were, and whose robots are gone.
//!
//! A fact stays true for ever (it says that a link *existed*), so age and order of messages do not matter; only a
//! robot's death makes facts of its links void, and then a floor says up to which term. The table is bounded: of each
//! pair the newest fact, of all pairs the newest.

use drover_contract::{Departure, EDGES_TOLD_MAX, LinkEdge, RobotId};
use std::cmp::{Ordering, Reverse};
use std::collections::BTreeMap;

/// Facts held.
const FACTS_MAX: usize = 256;
/// Departures held.
const GONE_MAX: usize = 64;
/// News is passed on so often before what is no news: the radio loses some.
const FRESH_TELLS: u8 = 2;
/// Older facts are thrown away: ages of up to 254 terms can be told.
const FACT_TERMS_MAX: u32 = 250;

#[derive(Clone, Copy, Debug)]
struct Fact {
    made: u32,
    weight_m: f64,
    /// The round in which it was last passed on, whenever it was made; 0: never.
    told: u64,
    /// How often it is still to be passed on before all that is known already.
    fresh: u8,
}

#[derive(Clone, Copy, Debug)]
struct Gone {
    /// Facts of its links that were made in this term or before are void.
    floor: u32,
    /// A link made later is known: it lives (again).
    back: bool,
    told: u64,
}

/// The tables.
#[derive(Clone, Debug, Default)]
pub(super) struct Gossip {
    facts: BTreeMap<(RobotId, RobotId), Fact>,
    gone: BTreeMap<RobotId, Gone>,
    /// Something was learned since [`Gossip::take_news`].
    news: bool,
    /// How often something was passed on.
    rounds: u64,
}

/// A bound on links: made in term `made_min` or later, and before `weight_m`, `ends` in the order of length.
#[derive(Clone, Copy, Debug)]
pub(super) struct Bound {
    /// Between whom; the lower id first.
    pub(super) ends: (RobotId, RobotId),
    pub(super) made_min: u32,
    pub(super) weight_m: f64,
}

impl Bound {
    fn admits(&self, ends: (RobotId, RobotId), fact: &Fact) -> bool {
        let shorter = fact.weight_m.total_cmp(&self.weight_m).then(ends.cmp(&self.ends)) == Ordering::Less;
        fact.made >= self.made_min && shorter && ends != self.ends
    }
}

impl Gossip {
    /// A link existed.
    pub(super) fn learn(&mut self, edge: &LinkEdge) {
        let ends = (edge.low, edge.high);
        if edge.low >= edge.high || [edge.low, edge.high].iter().any(|id| edge.made <= self.floor(*id)) {
            return;
        }
        for id in [edge.low, edge.high] {
            if let Some(gone) = self.gone.get_mut(&id) {
                gone.back = true;
            }
        }
        let known = self.facts.get(&ends);
        if known.is_some_and(|known| (known.made, Reverse(Order(known.weight_m))) >= (edge.made, weight_of(edge))) {
            return;
        }
        // A fact that is made anew keeps its place in the queue: else few would crowd out many.
        let told = known.map_or(0, |known| known.told);
        self.facts.insert(ends, Fact { made: edge.made, weight_m: edge.weight_m, told, fresh: FRESH_TELLS });
        self.news = true;
        if self.facts.len() > FACTS_MAX {
            let oldest = self.facts.iter().min_by_key(|(_, fact)| fact.made).map(|(ends, _)| *ends);
            oldest.map(|ends| self.facts.remove(&ends));
        }
    }

    /// A robot was given up, or lives anew: its links up to `term` are no more.
    pub(super) fn depart(&mut self, departure: Departure) {
        let Departure { robot, term } = departure;
        if self.gone.get(&robot).is_some_and(|known| known.floor >= term) {
            return;
        }
        self.facts.retain(|(low, high), fact| (*low != robot && *high != robot) || fact.made > term);
        let back = self.facts.keys().any(|(low, high)| *low == robot || *high == robot);
        self.gone.insert(robot, Gone { floor: term, back, told: 0 });
        self.news = true;
        if self.gone.len() > GONE_MAX {
            let oldest = self.gone.iter().min_by_key(|(_, gone)| (!gone.back, gone.floor)).map(|(robot, _)| *robot);
            oldest.map(|robot| self.gone.remove(&robot));
        }
    }

    /// Who was given up and is in no newer link.
    pub(super) fn gone(&self) -> impl Iterator<Item = RobotId> + '_ {
        self.gone.iter().filter(|(_, gone)| !gone.back).map(|(robot, _)| *robot)
    }

    /// How many links are known.
    pub(super) fn count(&self) -> u32 {
        self.facts.len() as u32
    }

    fn floor(&self, robot: RobotId) -> u32 {
        self.gone.get(&robot).map_or(0, |gone| gone.floor)
    }

    /// Forgets facts too old to be told.
    pub(super) fn age(&mut self, term: u32) {
        self.facts.retain(|_, fact| fact.made.saturating_add(FACT_TERMS_MAX) >= term);
    }

    /// Whether something was learned since this was last asked.
    pub(super) fn take_news(&mut self) -> bool {
        std::mem::take(&mut self.news)
    }

    /// Whether a path of known links within the bound joins its two ends.
    pub(super) fn bypass(&self, bound: &Bound) -> bool {
        let admitted = self.facts.iter().filter(|(ends, fact)| bound.admits(**ends, fact));
        let mut ways: Vec<(RobotId, RobotId)> = admitted.flat_map(|(&(a, b), _)| [(a, b), (b, a)]).collect();
        ways.sort_unstable();
        let mut reached = vec![bound.ends.0];
        let mut next = 0;
        while let Some(&from) = reached.get(next) {
            let first = ways.partition_point(|way| way.0 < from);
            for &(_, to) in ways[first..].iter().take_while(|way| way.0 == from) {
                if to == bound.ends.1 {
                    return true;
                }
                if !reached.contains(&to) {
                    reached.push(to);
                }
            }
            next += 1;
        }
        false
    }

    /// What to pass on now: first what was not yet, and of that what waits longest. Own links are told elsewhere.
    pub(super) fn tell(&mut self, own: RobotId) -> [Option<LinkEdge>; EDGES_TOLD_MAX] {
        let mut told = [None; EDGES_TOLD_MAX];
        let mut others: Vec<_> = self.facts.iter_mut().filter(|((low, high), _)| *low != own && *high != own).collect();
        others.sort_by_key(|(ends, fact)| (Reverse(fact.fresh), fact.told, Reverse(fact.made), **ends));
        self.rounds += 1;
        for (place, (&(low, high), fact)) in told.iter_mut().zip(others) {
            (fact.told, fact.fresh) = (self.rounds, fact.fresh.saturating_sub(1));
            *place = Some(LinkEdge { low, high, made: fact.made, weight_m: fact.weight_m });
        }
        told
    }

    /// Which departure to pass on now.
    pub(super) fn tell_gone(&mut self) -> Option<Departure> {
        let gone = self.gone.iter_mut().filter(|(_, gone)| !gone.back).min_by_key(|(_, gone)| gone.told);
        gone.map(|(robot, gone)| {
            gone.told = self.rounds;
            Departure { robot: *robot, term: gone.floor }
        })
    }

    #[cfg(test)]
    pub(super) fn edges(&self) -> impl Iterator<Item = LinkEdge> + '_ {
        let edge = |(&(low, high), fact): (&(RobotId, RobotId), &Fact)| LinkEdge {
            low,
            high,
            made: fact.made,
            weight_m: fact.weight_m,
        };
        self.facts.iter().map(edge)
    }
}

fn weight_of(edge: &LinkEdge) -> Reverse<Order> {
    Reverse(Order(edge.weight_m))
}

/// A length in its total order.
#[derive(Clone, Copy, Debug)]
struct Order(f64);

impl PartialEq for Order {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl Eq for Order {}

impl PartialOrd for Order {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Order {
    fn cmp(&self, other: &Self) -> Ordering {
        self.0.total_cmp(&other.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn edge(low: u32, high: u32, made: u32, weight_m: f64) -> LinkEdge {
        LinkEdge { low: RobotId(low), high: RobotId(high), made, weight_m }
    }

    fn bound(low: u32, high: u32, made_min: u32, weight_m: f64) -> Bound {
        Bound { ends: (RobotId(low), RobotId(high)), made_min, weight_m }
    }

    fn square() -> Gossip {
        let mut gossip = Gossip::default();
        [edge(1, 2, 7, 1.0), edge(2, 3, 8, 2.0), edge(3, 4, 7, 1.5), edge(1, 4, 7, 2.0)]
            .iter()
            .for_each(|edge| gossip.learn(edge));
        gossip
    }

    #[test]
    fn a_link_is_bypassed_by_a_path_of_links_no_older_and_all_shorter() {
        let gossip = square();
        assert!(!gossip.bypass(&bound(1, 4, 7, 2.0)), "2-3 is as long and comes later");
        assert!(gossip.bypass(&bound(2, 3, 7, 2.01)));
        assert!(gossip.bypass(&bound(2, 3, 7, 2.0)), "1-4 is as long and comes earlier");
        assert!(gossip.bypass(&bound(1, 4, 6, 2.5)) && !gossip.bypass(&bound(1, 4, 8, 2.5)), "too old");
    }

    #[test]
    fn links_of_a_robot_that_is_gone_prove_nothing_until_there_are_newer_ones() {
        let mut gossip = square();
        gossip.depart(Departure { robot: RobotId(2), term: 9 });
        assert!(!gossip.bypass(&bound(1, 4, 0, 9.0)) && gossip.gone().eq([RobotId(2)]));
        gossip.learn(&edge(2, 3, 9, 2.0));
        assert!(gossip.gone().eq([RobotId(2)]) && gossip.count() as usize == 2, "late news of its earlier life");
        gossip.learn(&edge(2, 3, 10, 2.0));
        assert!(gossip.gone().next().is_none() && gossip.tell_gone().is_none());
        gossip.depart(Departure { robot: RobotId(2), term: 9 });
        assert!(gossip.gone().next().is_none(), "known already");
    }

    #[test]
    fn everything_is_told_in_turn_and_the_tables_are_bounded() {
        let mut gossip = Gossip::default();
        (0..1_000).for_each(|low| gossip.learn(&edge(low, low + 1, low, 1.0)));
        (0..1_000).for_each(|id| gossip.depart(Departure { robot: RobotId(5_000 + id), term: id }));
        assert!(gossip.count() as usize == FACTS_MAX && gossip.gone().count() == GONE_MAX);
        let mut told: Vec<u32> = (0..86).flat_map(|_| gossip.tell(RobotId(1))).flatten().map(|e| e.made).collect();
        assert_eq!(told[..3], [999, 998, 997], "the newest first");
        told.sort_unstable();
        told.dedup();
        assert_eq!(told.len(), FACTS_MAX);
        gossip.age(999 + FACT_TERMS_MAX);
        assert_eq!(gossip.count() as usize, 1);
    }
}
