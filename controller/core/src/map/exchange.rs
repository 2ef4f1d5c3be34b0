//! What a robot tells of the map, and what it knows of the others' maps: gossip over a radio that loses things.
//!
//! Every report tells how much its sender has of every writer ([`MapHead`]), where it goes, and one piece of a log that
//! one of those it hears lacks; all who hear it take what is the next piece to them. Whose lack it is goes round. A
//! piece that is on its way is not sent again for [`PATIENCE`]: then what was told since says whether it was lost.
//! Pieces may be anybody's, so the map goes through those who meet; nobody waits for anybody.

use super::SharedMap;
use drover_contract::{HEADS_TOLD_MAX, MapHead, MapReport, RobotId, Stamp, Writer};
use std::collections::BTreeMap;
use std::time::Duration;

/// Who was not heard for this long is not told anything, and holds no lease.
const LEASE: Duration = Duration::from_millis(2_000);
/// A piece counts as received for this long before it is sent again.
const PATIENCE: Duration = Duration::from_millis(350);

/// What one robot knows of another's map.
#[derive(Clone, Debug)]
struct Peer {
    epoch: u32,
    seq: u32,
    heard: Stamp,
    goal: Option<u32>,
    done: bool,
    heads: BTreeMap<Writer, u32>,
    /// Sent, and not yet told to have arrived.
    sent: BTreeMap<Writer, (u32, Stamp)>,
}

impl Peer {
    /// What it has of a writer as soon as all has arrived that is on its way.
    fn head(&self, writer: Writer, now: Stamp) -> u32 {
        let told = self.heads.get(&writer).copied().unwrap_or(0);
        let sent = self.sent.get(&writer).filter(|(_, at)| now.since(*at) < PATIENCE);
        sent.map_or(told, |(upto, _)| told.max(*upto))
    }
}

/// One robot's side of the exchange.
#[derive(Clone, Debug)]
pub struct Exchange {
    own: Writer,
    lattice: u32,
    seq: u32,
    peers: BTreeMap<RobotId, Peer>,
    /// Most peers that are kept.
    peers_max: usize,
    /// Whose lack is next to be seen to, and which head is next to be told.
    turn: usize,
    heads_turn: usize,
}

impl Exchange {
    /// The exchange of a robot with `peers` others on a lattice of this hash.
    #[must_use]
    pub fn new(own: Writer, lattice: u32, peers: usize) -> Self {
        Self { own, lattice, seq: 0, peers: BTreeMap::new(), peers_max: peers, turn: 0, heads_turn: 0 }
    }

    /// Take in a report and the piece in it; whether it was one for us.
    pub fn hear(&mut self, now: Stamp, report: &MapReport, map: &mut SharedMap) -> bool {
        let from = report.from;
        if report.lattice != self.lattice || from.robot == self.own.robot {
            return false;
        }
        // Pieces are welcome in any order; what else an overtaken report says is old.
        if let Some(chunk) = &report.chunk {
            map.take(chunk);
        }
        let held = self.peers.get(&from.robot).map(|peer| (peer.epoch, peer.seq));
        if held.is_none() && self.peers.len() >= self.peers_max || held >= Some((from.epoch, report.seq)) {
            return false;
        }
        if held.is_none_or(|(epoch, _)| epoch != from.epoch) {
            let (heads, sent) = (BTreeMap::new(), BTreeMap::new());
            let fresh = Peer { epoch: from.epoch, seq: 0, heard: now, goal: None, done: false, heads, sent };
            self.peers.insert(from.robot, fresh);
        }
        let Some(peer) = self.peers.get_mut(&from.robot) else { return false };
        (peer.seq, peer.heard, peer.goal, peer.done) = (report.seq, now, report.goal, report.done);
        for MapHead { writer, head } in report.heads.iter().flatten() {
            if peer.heads.contains_key(writer) || peer.heads.len() < super::WRITERS_MAX {
                peer.heads.insert(*writer, *head);
            }
        }
        true
    }

    /// What to tell now.
    pub fn report(&mut self, now: Stamp, map: &SharedMap, goal: Option<u32>, done: bool) -> MapReport {
        self.seq = self.seq.saturating_add(1);
        MapReport {
            from: self.own,
            seq: self.seq,
            lattice: self.lattice,
            goal,
            done,
            heads: self.heads(map),
            chunk: self.chunk(now, map),
        }
    }

    fn heads(&mut self, map: &SharedMap) -> [Option<MapHead>; HEADS_TOLD_MAX] {
        let all: Vec<MapHead> = map.ledger().heads().collect();
        let mut told = [None; HEADS_TOLD_MAX];
        for (place, head) in told.iter_mut().zip(all.iter().cycle().skip(self.heads_turn).take(all.len())) {
            *place = Some(*head);
        }
        self.heads_turn = if all.len() > HEADS_TOLD_MAX { (self.heads_turn + HEADS_TOLD_MAX) % all.len() } else { 0 };
        told
    }

    /// The next piece for the next one who lacks anything.
    fn chunk(&mut self, now: Stamp, map: &SharedMap) -> Option<drover_contract::MapChunk> {
        let lacks: Vec<(RobotId, Writer, u32)> = self.lacks(now, map).collect();
        let (_, writer, after) = *lacks.get(self.turn.checked_rem(lacks.len())?)?;
        self.turn = self.turn.wrapping_add(1);
        let chunk = map.ledger().chunk(writer, after)?;
        for peer in self.peers.values_mut().filter(|peer| now.since(peer.heard) < LEASE) {
            if (chunk.after..chunk.upto).contains(&peer.head(writer, now)) {
                peer.sent.insert(writer, (chunk.upto, now));
            }
        }
        Some(chunk)
    }

    /// Who of those that are heard lacks what of whom, from where on.
    fn lacks<'a>(&'a self, now: Stamp, map: &'a SharedMap) -> impl Iterator<Item = (RobotId, Writer, u32)> + 'a {
        let heard = self.peers.iter().filter(move |(_, peer)| now.since(peer.heard) < LEASE);
        heard.flat_map(move |(robot, peer)| {
            map.ledger().heads().filter_map(move |MapHead { writer, head }| {
                let has = peer.head(writer, now);
                (has < head && writer.robot != *robot).then_some((*robot, writer, has))
            })
        })
    }

    /// Whether this robot has all that those whom it hears have.
    #[must_use]
    pub fn is_level(&self, now: Stamp, map: &SharedMap) -> bool {
        let heard = self.peers.values().filter(|peer| now.since(peer.heard) < LEASE);
        let mut heads = heard.flat_map(|peer| &peer.heads);
        heads.all(|(writer, head)| *writer == self.own || map.ledger().head(*writer) >= *head)
    }

    /// The cell to which a robot goes, as long as its lease lasts.
    #[must_use]
    pub fn goal_of(&self, robot: RobotId, now: Stamp) -> Option<u32> {
        self.peers.get(&robot).filter(|peer| now.since(peer.heard) < LEASE)?.goal
    }

    /// Whether a robot said last that it knows of nothing left to see.
    #[must_use]
    pub fn is_done(&self, robot: RobotId) -> bool {
        self.peers.get(&robot).is_some_and(|peer| peer.done)
    }

    /// Who was heard of late, by id.
    pub fn heard(&self, now: Stamp) -> impl Iterator<Item = RobotId> + '_ {
        self.peers.iter().filter(move |(_, peer)| now.since(peer.heard) < LEASE).map(|(robot, _)| *robot)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::map::{Known, Lattice};
    use drover_contract::Vec2;

    struct Team {
        maps: Vec<SharedMap>,
        exchanges: Vec<Exchange>,
        now: Stamp,
        bytes: usize,
    }

    impl Team {
        fn new(count: u32) -> Self {
            let lattice = Lattice::over(Vec2::zeros(), Vec2::new(40.0, 40.0), 1.0);
            let writer = |robot: u32| Writer { robot: RobotId(robot), epoch: 1 };
            Self {
                maps: (1..=count).map(|robot| SharedMap::new(lattice, writer(robot))).collect(),
                exchanges: (1..=count).map(|robot| Exchange::new(writer(robot), 7, count as usize - 1)).collect(),
                now: Stamp::ZERO,
                bytes: 0,
            }
        }

        /// Everybody reports once, ten times a second; `arrives` says who hears whom.
        fn round(&mut self, mut arrives: impl FnMut(usize, usize) -> bool) {
            self.now = self.now + Duration::from_millis(100);
            for from in 0..self.maps.len() {
                let report = self.exchanges[from].report(self.now, &self.maps[from], None, false);
                self.bytes += report.chunk.as_ref().map_or(0, |chunk| chunk.changes.len());
                for to in 0..self.maps.len() {
                    if to != from && arrives(from, to) {
                        self.exchanges[to].hear(self.now, &report, &mut self.maps[to]);
                    }
                }
            }
        }

        fn known(&self) -> Vec<usize> {
            self.maps.iter().map(|map| map.board().known_count()).collect()
        }
    }

    #[test]
    fn in_a_chain_that_loses_a_third_everybody_gets_everything_and_then_it_is_silent() {
        let mut team = Team::new(4);
        for (robot, map) in team.maps.iter_mut().enumerate() {
            (0..400).for_each(|cell| map.see(robot * 400 + cell, cell % 7 == 0));
        }
        let mut seed = 1_u32;
        for _ in 0..400 {
            team.round(|from, to| {
                seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                from.abs_diff(to) == 1 && seed >> 16 > u32::from(u16::MAX) / 3
            });
        }
        assert_eq!(team.known(), vec![1_600; 4]);
        assert_eq!(team.maps[0].board().at(1_207), Known::Occupied, "robot 4's, through two others");
        assert!((0..4).all(|robot| team.exchanges[robot].is_level(team.now, &team.maps[robot])));
        let before = team.bytes;
        (0..20).for_each(|_| team.round(|_, _| true));
        assert!(team.bytes - before < 400, "nobody lacks anything: {}", team.bytes - before);
    }

    #[test]
    fn a_lease_ends_with_its_holder_and_another_lattice_is_not_understood() {
        let mut team = Team::new(2);
        let report = team.exchanges[0].report(team.now, &team.maps[0], Some(5), false);
        let [_, map] = &mut team.maps[..] else { panic!("two") };
        assert!(team.exchanges[1].hear(Stamp::ZERO, &report, map));
        assert_eq!(team.exchanges[1].goal_of(RobotId(1), Stamp::from_millis(1_900)), Some(5));
        assert_eq!(team.exchanges[1].goal_of(RobotId(1), Stamp::from_millis(2_000)), None);
        assert!(!team.exchanges[1].hear(Stamp::ZERO, &report, map), "twice");
        let strange = MapReport { lattice: 8, seq: 9, ..report };
        assert!(!team.exchanges[1].hear(Stamp::ZERO, &strange, map));
    }
}
