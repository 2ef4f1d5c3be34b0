//! The map that a team makes together, as one robot has it: its own evidence, and what others said.
//!
//! **Evidence** is log odds in whole steps of 0.2 nat, so that sums are exact. A return in a cell is four steps for
//! occupied, a beam through it one step for free. Occupied wins: a cell that a wall's face runs through is mostly
//! free, and every beam that grazes the face goes through it, so there are many more beams than returns. Therefore
//! evidence for free ends sooner than that for occupied (p = 0.23 and 0.98), and a beam does not count against an
//! occupied cell in a scan that has a return beside it. What the own evidence has become sure of goes into the own
//! log ([`Ledger`]); a word in another's log counts [`FREE_STEPS`] or [`OCCUPIED_STEPS`]. The sum is independent of
//! the order in which words arrive and of how often, since every writer has one word a cell. Increments of evidence
//! are sent, never sums: fused sums that are fused again would count the first evidence twice (Wu 2008, eq. 1 to 3,
//! needs independent evidence; two rounds of exchanged posteriors turn .70 into .999999).
//!
//! **What is known** follows the sum with a hysteresis: a cell is free or occupied from [`SURE_FREE`] or
//! [`SURE_OCCUPIED`] on, and stays so until the sum is as sure of the opposite. So two robots that contradict each
//! other do not make a known cell unknown again, which nobody could ever finish with.
//!
//! **Sparing**: a word that the others' words already say is not written down.
//!
//! **Cost**: a scan touches the cells along its beams; a word one cell.

use super::ledger::{Change, Ledger};
use super::tiles::Tiles;
use super::{Board, Known, Lattice};
use drover_contract::{MapChunk, Vec2, Writer};

/// A return's evidence, a passing beam's, and where both end.
const HIT_STEPS: i8 = 4;
const MISS_STEPS: i8 = 1;
const STEPS_MIN: i8 = -6;
const STEPS_MAX: i8 = 20;
/// From here on evidence is sure: two beams, two returns.
const SURE_FREE: i16 = -2;
const SURE_OCCUPIED: i16 = 6;
/// What another's word counts: two robots that only ever graze a wall do not outvote one that saw it.
const FREE_STEPS: i16 = -4;
const OCCUPIED_STEPS: i16 = 12;

/// Pieces that are kept for those before them.
const EARLY_MAX: usize = 16;

/// A beam, as far as it is believed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ray {
    /// Where it ends, world frame.
    pub end_w: Vec2,
    /// Whether something stands there.
    pub hit: bool,
}

/// The map.
#[derive(Clone, Debug)]
pub struct SharedMap {
    lattice: Lattice,
    board: Board,
    own: Tiles<i8>,
    others: Tiles<i16>,
    ledger: Ledger,
    writer: Writer,
    finders: Tiles<u32>,
    /// Pieces that came before the ones before them.
    early: Vec<MapChunk>,
    /// Cells that this scan has gone through.
    passed: Vec<usize>,
    hit: Vec<usize>,
    /// Cells of which something else is known than when [`SharedMap::take_news`] was last called.
    news: Vec<usize>,
}

impl SharedMap {
    /// Nothing is known. `writer` is the robot whose map it is, in its present life.
    #[must_use]
    pub fn new(lattice: Lattice, writer: Writer) -> Self {
        let (columns, rows) = (lattice.columns(), lattice.rows());
        Self {
            lattice,
            board: Board::new(columns, rows),
            own: Tiles::new(columns, rows),
            others: Tiles::new(columns, rows),
            ledger: Ledger::new(&lattice),
            writer,
            finders: Tiles::new(columns, rows),
            early: Vec::new(),
            passed: Vec::new(),
            hit: Vec::new(),
            news: Vec::new(),
        }
    }

    /// Where its cells lie.
    #[must_use]
    pub const fn lattice(&self) -> &Lattice {
        &self.lattice
    }

    /// What is known.
    #[must_use]
    pub const fn board(&self) -> &Board {
        &self.board
    }

    /// Everybody's words.
    #[must_use]
    pub const fn ledger(&self) -> &Ledger {
        &self.ledger
    }

    /// Whose map it is.
    #[must_use]
    pub const fn writer(&self) -> Writer {
        self.writer
    }

    /// Who made a cell known, by its id; 0 for one that is not.
    #[must_use]
    pub fn finder(&self, cell: usize) -> u32 {
        self.finders.get(cell)
    }

    /// Take in a scan from `from_w`. A cell counts once a scan, however many beams go through it, and where something
    /// stands no passing beam counts.
    pub fn observe(&mut self, from_w: Vec2, rays: impl Iterator<Item = Ray>) {
        self.passed.clear();
        self.hit.clear();
        for ray in rays {
            let end = self.lattice.cell_at(ray.end_w);
            let passed = &mut self.passed;
            self.lattice.along(from_w, ray.end_w, |cell| {
                if !(ray.hit && Some(cell) == end) {
                    passed.push(cell);
                }
            });
            self.hit.extend(end.filter(|_| ray.hit));
        }
        for list in [&mut self.passed, &mut self.hit] {
            list.sort_unstable();
            list.dedup();
        }
        let (passed, hit) = (std::mem::take(&mut self.passed), std::mem::take(&mut self.hit));
        let is_hit = |cell: &usize| hit.binary_search(cell).is_ok();
        for cell in &passed {
            let face = self.own.get(*cell) > 0 && self.board.neighbours(*cell).any(|other| is_hit(&other));
            if !face && !is_hit(cell) {
                self.add(*cell, -MISS_STEPS);
            }
        }
        hit.iter().for_each(|cell| self.add(*cell, HIT_STEPS));
        (self.passed, self.hit) = (passed, hit);
    }

    /// Take in what a sensor without error saw of a cell.
    pub fn see(&mut self, cell: usize, occupied: bool) {
        self.own.put(cell, if occupied { STEPS_MAX } else { STEPS_MIN });
        self.conclude(cell, self.writer.robot.0);
    }

    fn add(&mut self, cell: usize, steps: i8) {
        let before = self.own.get(cell);
        let now = before.saturating_add(steps).clamp(STEPS_MIN, STEPS_MAX);
        if now != before {
            self.own.put(cell, now);
            self.conclude(cell, self.writer.robot.0);
        }
    }

    /// What the evidence for a cell comes to, now that `finder` has added some; and whether it is worth a word.
    fn conclude(&mut self, cell: usize, finder: u32) {
        let (own, others) = (i16::from(self.own.get(cell)), self.others.get(cell));
        if let Some(occupied) = sure(own)
            && self.ledger.word(self.writer, cell) != known_of(occupied)
            && sure(others) != Some(occupied)
        {
            self.ledger.write(self.writer, cell, occupied);
        }
        let Some(occupied) = sure(own + others) else { return };
        if self.board.at(cell) == Known::Unknown {
            self.finders.put(cell, finder);
        }
        if self.board.learn(cell, known_of(occupied)) {
            self.news.push(cell);
        }
    }

    /// Take in a piece of another's log; whether it was the next one. One that has overtaken another is kept until that
    /// one comes.
    pub fn take(&mut self, chunk: &MapChunk) -> bool {
        if chunk.writer == self.writer {
            return false; // nobody knows better what it said
        }
        if chunk.after > self.ledger.head(chunk.writer) {
            let there = self.early.iter().any(|early| (early.writer, early.after) == (chunk.writer, chunk.after));
            if !there && self.early.len() >= EARLY_MAX {
                self.early.remove(0);
            }
            if !there {
                self.early.push(chunk.clone());
            }
            return false;
        }
        let taken = self.join(chunk);
        while let Some(at) = self.early.iter().position(|early| early.after <= self.ledger.head(early.writer)) {
            let early = self.early.swap_remove(at);
            self.join(&early);
        }
        taken
    }

    fn join(&mut self, chunk: &MapChunk) -> bool {
        let before = self.ledger.head(chunk.writer);
        for Change { cell, before, now } in self.ledger.take(chunk) {
            let others = self.others.get(cell) + steps_of(now) - steps_of(before);
            self.others.put(cell, others);
            self.conclude(cell, chunk.writer.robot.0);
        }
        self.ledger.head(chunk.writer) != before
    }

    /// Go through the cells of which something else is known than at the last call, in the order of news.
    pub fn take_news(&mut self, mut visit: impl FnMut(&Board, usize)) {
        for cell in self.news.drain(..) {
            visit(&self.board, cell);
        }
    }

    /// Heap bytes held.
    #[must_use]
    pub fn bytes(&self) -> usize {
        self.board.bytes() + self.own.bytes() + self.others.bytes() + self.finders.bytes() + self.ledger.bytes()
    }
}

fn sure(steps: i16) -> Option<bool> {
    (steps <= SURE_FREE || steps >= SURE_OCCUPIED).then_some(steps > 0)
}

const fn known_of(occupied: bool) -> Known {
    if occupied { Known::Occupied } else { Known::Free }
}

const fn steps_of(word: Known) -> i16 {
    match word {
        Known::Unknown => 0,
        Known::Free => FREE_STEPS,
        Known::Occupied => OCCUPIED_STEPS,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use drover_contract::RobotId;

    fn map(robot: u32) -> SharedMap {
        let lattice = Lattice::over(Vec2::zeros(), Vec2::new(10.0, 10.0), 0.5);
        SharedMap::new(lattice, Writer { robot: RobotId(robot), epoch: 1 })
    }

    fn ray(x: f64, y: f64, hit: bool) -> Ray {
        Ray { end_w: Vec2::new(x, y), hit }
    }

    fn at(map: &SharedMap, x: f64, y: f64) -> Known {
        map.board().at(map.lattice().cell_at(Vec2::new(x, y)).expect("on the lattice"))
    }

    /// All that one has and the other has not.
    fn tell(from: &SharedMap, to: &mut SharedMap) {
        let heads: Vec<_> = from.ledger().heads().collect();
        for head in heads {
            while let Some(chunk) = from.ledger().chunk(head.writer, to.ledger().head(head.writer)) {
                assert!(to.take(&chunk));
            }
        }
    }

    #[test]
    fn two_scans_make_a_wall_and_the_way_to_it() {
        let mut map = map(1);
        let from_w = Vec2::new(1.1, 5.1);
        map.observe(from_w, [ray(6.2, 5.1, true)].into_iter());
        assert_eq!((at(&map, 6.2, 5.1), at(&map, 3.0, 5.1)), (Known::Unknown, Known::Unknown));
        map.observe(from_w, [ray(6.2, 5.1, true)].into_iter());
        assert_eq!((at(&map, 6.2, 5.1), at(&map, 3.0, 5.1)), (Known::Occupied, Known::Free));
        assert_eq!(at(&map, 7.0, 5.1), Known::Unknown, "behind the wall");
        assert_eq!(map.finder(map.lattice().cell_near(Vec2::new(3.0, 5.1))), 1);
    }

    #[test]
    fn what_went_away_is_free_after_as_many_beams_as_it_took_and_some_more() {
        let mut map = map(1);
        let from_w = Vec2::new(1.1, 5.1);
        (0..20).for_each(|_| map.observe(from_w, [ray(6.2, 5.1, true)].into_iter()));
        (0..21).for_each(|_| map.observe(from_w, [ray(9.0, 5.1, false)].into_iter()));
        assert_eq!(at(&map, 6.2, 5.1), Known::Occupied);
        map.observe(from_w, [ray(9.0, 5.1, false)].into_iter());
        assert_eq!(at(&map, 6.2, 5.1), Known::Free);
    }

    #[test]
    fn maps_that_meet_are_one_and_meeting_again_changes_nothing() {
        let (mut one, mut other) = (map(1), map(2));
        for _ in 0..3 {
            one.observe(Vec2::new(1.1, 5.1), [ray(6.2, 5.1, true)].into_iter());
            other.observe(Vec2::new(9.1, 1.1), [ray(9.1, 8.0, false)].into_iter());
        }
        tell(&one, &mut other);
        tell(&other, &mut one);
        assert_eq!(one.board(), other.board());
        let (before, news) = (one.board().clone(), one.news.len());
        for head in other.ledger().heads().collect::<Vec<_>>() {
            let chunk = other.ledger().chunk(head.writer, 0).expect("something was said");
            assert!(!one.take(&chunk));
        }
        assert_eq!((one.board(), one.news.len()), (&before, news));
    }

    #[test]
    fn pieces_that_overtake_each_other_are_put_in_order() {
        let (mut one, mut other) = (map(1), map(2));
        (0..400).for_each(|cell| one.see(cell, cell % 3 == 0));
        let mut pieces = Vec::new();
        while let Some(piece) = one.ledger().chunk(one.writer(), pieces.last().map_or(0, |last: &MapChunk| last.upto)) {
            pieces.push(piece);
        }
        assert!(pieces.len() > 3, "{}", pieces.len());
        for pair in pieces.chunks(2) {
            pair.iter().rev().for_each(|piece| {
                other.take(piece);
            });
        }
        assert_eq!(one.board(), other.board());
    }

    #[test]
    fn of_a_contradiction_occupied_is_left_and_what_others_said_is_not_said_again() {
        let (mut one, mut other) = (map(1), map(2));
        one.see(45, false);
        other.see(45, true);
        tell(&one, &mut other);
        tell(&other, &mut one);
        assert_eq!((one.board().at(45), other.board().at(45)), (Known::Occupied, Known::Occupied), "occupied wins");
        let mut third = map(3);
        tell(&one, &mut third);
        third.see(45, true);
        assert_eq!(third.ledger().head(third.writer()), 0, "they say so already");
    }
}
