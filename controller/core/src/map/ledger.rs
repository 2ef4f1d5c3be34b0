//! Who said what of which cell, so that maps can be joined in any order, late, twice, and through others.
//!
//! Every robot writes down what its own sensor has made it sure of, free or occupied, as entries with rising indices.
//! Nobody else writes into its log; others copy it, in order and without gaps, and pass it on. So how much one has of a
//! writer is one number, its *head*; a robot tells its heads, and who hears them knows what to send. Nothing counts
//! twice: a copy is a copy, however often it comes. (Single-writer logs under a version vector; a grow-only
//! replicated type.)
//!
//! **Bounded**: an entry that a later one of the same cell replaces is dropped when such are half of a log, so a log
//! holds at most twice as many entries as there are cells; and there are no more writers than [`WRITERS_MAX`].
//!
//! **Packed**: a chunk is runs of cells, each two or three bytes. A variable-length integer, seven bits a byte, the low
//! ones first, has the first cell of the run less the one behind the last run, folded to be positive; then a byte has
//! the length less one (0..=127) times two, plus one if the cells are occupied.

use super::tiles::Tiles;
use super::{Known, Lattice};
use drover_contract::{CHANGES_BYTES_MAX, MapChunk, MapHead, Writer};
use std::collections::BTreeMap;

/// Lives of robots that a ledger knows at most; what more there are is not taken.
pub const WRITERS_MAX: usize = 64;
/// Cells of a run at most.
const RUN_MAX: usize = 128;
/// A log this short is left alone.
const ENTRIES_MIN: usize = 256;
/// A chunk leaves so many bytes free: passed on, its first run may lie farther from the one before.
const SPARE_BYTES: usize = 4;

/// What was said of a cell.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Entry {
    index: u32,
    cell: u32,
    occupied: bool,
}

/// One writer's words.
#[derive(Clone, Debug)]
struct Log {
    /// With rising indices; in a copy, several may have one.
    entries: Vec<Entry>,
    head: u32,
    /// The last word on each cell.
    said: Tiles<Word>,
    /// Entries that later ones have replaced.
    stale: usize,
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum Word {
    #[default]
    Nothing,
    Free,
    Occupied,
}

impl Word {
    const fn known(self) -> Known {
        match self {
            Self::Nothing => Known::Unknown,
            Self::Free => Known::Free,
            Self::Occupied => Known::Occupied,
        }
    }
}

/// A writer has changed its word on a cell.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Change {
    /// Which cell.
    pub cell: usize,
    /// What the writer held before.
    pub before: Known,
    /// What it holds now.
    pub now: Known,
}

/// All writers' logs.
#[derive(Clone, Debug)]
pub struct Ledger {
    columns: usize,
    rows: usize,
    logs: BTreeMap<Writer, Log>,
}

impl Ledger {
    /// Nobody has said anything of these cells.
    #[must_use]
    pub fn new(lattice: &Lattice) -> Self {
        Self { columns: lattice.columns(), rows: lattice.rows(), logs: BTreeMap::new() }
    }

    /// What a writer holds of a cell.
    #[must_use]
    pub fn word(&self, writer: Writer, cell: usize) -> Known {
        self.logs.get(&writer).map_or(Known::Unknown, |log| log.said.get(cell).known())
    }

    /// How much is here of a writer; 0: nothing.
    #[must_use]
    pub fn head(&self, writer: Writer) -> u32 {
        self.logs.get(&writer).map_or(0, |log| log.head)
    }

    /// How much is here of everybody, in the order of writers.
    pub fn heads(&self) -> impl Iterator<Item = MapHead> + '_ {
        self.logs.iter().map(|(writer, log)| MapHead { writer: *writer, head: log.head })
    }

    /// Write into one's own log.
    pub fn write(&mut self, own: Writer, cell: usize, occupied: bool) {
        if let Some(log) = self.log(own) {
            log.head += 1;
            let index = log.head;
            log.put(index, cell, occupied);
            log.tidy();
        }
    }

    /// Take in a piece of another's log: what it changes, in its order. Nothing if it is not the next piece, or broken.
    pub fn take(&mut self, chunk: &MapChunk) -> Vec<Change> {
        let cells = self.columns * self.rows;
        let head = self.head(chunk.writer);
        if chunk.after > head || chunk.upto <= head || chunk.changes.len() > CHANGES_BYTES_MAX {
            return Vec::new();
        }
        let Some(said) = unpack(&chunk.changes, cells) else { return Vec::new() };
        let last = said.len();
        let Some(log) = self.log(chunk.writer) else { return Vec::new() };
        let mut changes = Vec::new();
        for (at, (cell, occupied)) in said.into_iter().enumerate() {
            let before = log.said.get(cell).known();
            // Its true index is this or a greater one, so that whoever is told less of it misses nothing.
            let index = chunk.upto.saturating_sub((last - 1 - at) as u32).max(head + 1);
            log.put(index, cell, occupied);
            let now = log.said.get(cell).known();
            if now != before {
                changes.push(Change { cell, before, now });
            }
        }
        log.head = chunk.upto;
        log.tidy();
        changes
    }

    /// The next piece of a writer's log for somebody who has it up to `after`, if there is one.
    #[must_use]
    pub fn chunk(&self, writer: Writer, after: u32) -> Option<MapChunk> {
        let log = self.logs.get(&writer)?;
        if after >= log.head {
            return None;
        }
        let first = log.entries.partition_point(|entry| entry.index <= after);
        let (changes, taken) = pack(&log.entries[first..]);
        // Entries that were dropped leave no gap: later ones say the same cells' words.
        let whole = first + taken == log.entries.len();
        let upto = if whole { log.head } else { log.entries[first + taken - 1].index };
        Some(MapChunk { writer, after, upto, changes })
    }

    fn log(&mut self, writer: Writer) -> Option<&mut Log> {
        if !self.logs.contains_key(&writer) {
            if self.logs.len() >= WRITERS_MAX {
                return None;
            }
            let said = Tiles::new(self.columns, self.rows);
            self.logs.insert(writer, Log { entries: Vec::new(), head: 0, said, stale: 0 });
        }
        self.logs.get_mut(&writer)
    }

    /// Heap bytes held.
    #[must_use]
    pub fn bytes(&self) -> usize {
        self.logs.values().map(|log| log.entries.capacity() * size_of::<Entry>() + log.said.bytes()).sum()
    }
}

impl Log {
    fn put(&mut self, index: u32, cell: usize, occupied: bool) {
        self.stale += usize::from(self.said.get(cell) != Word::Nothing);
        self.said.put(cell, if occupied { Word::Occupied } else { Word::Free });
        self.entries.push(Entry { index, cell: cell as u32, occupied });
    }

    /// Drop what has been replaced, once it is half of all.
    fn tidy(&mut self) {
        if self.entries.len() < ENTRIES_MIN || 2 * self.stale < self.entries.len() {
            return;
        }
        let mut newer = std::collections::BTreeSet::new();
        let mut kept: Vec<Entry> =
            self.entries.iter().rev().filter(|entry| newer.insert(entry.cell)).copied().collect();
        kept.reverse();
        self.entries = kept;
        self.stale = 0;
    }
}

/// As many entries as fit, those of one index together, and how many they are. Who copied a piece that began before its
/// own head may have many of one index: they came in one chunk and fit into one again, with some bytes to spare.
fn pack(entries: &[Entry]) -> (Vec<u8>, usize) {
    let (mut fits, mut bytes) = (0, Vec::new());
    let mut behind = 0;
    while fits < entries.len() {
        let len = run(&entries[fits..]);
        put_run(&mut bytes, behind, &entries[fits..fits + len]);
        if bytes.len() > CHANGES_BYTES_MAX - SPARE_BYTES {
            break;
        }
        fits += len;
        behind = behind_run(&entries[..fits]);
    }
    let ends = |at: &usize| entries.get(*at).is_none_or(|entry| entry.index != entries[*at - 1].index);
    let cut = (1..=fits).rev().find(ends).or_else(|| (fits.max(1)..=entries.len()).find(ends)).unwrap_or(0);
    (pack_all(&entries[..cut]), cut)
}

fn pack_all(entries: &[Entry]) -> Vec<u8> {
    let (mut bytes, mut next) = (Vec::with_capacity(CHANGES_BYTES_MAX), 0);
    while next < entries.len() {
        let len = run(&entries[next..]);
        put_run(&mut bytes, behind_run(&entries[..next]), &entries[next..next + len]);
        next += len;
    }
    bytes
}

/// The cell behind the last one of some entries.
fn behind_run(entries: &[Entry]) -> i64 {
    entries.last().map_or(0, |entry| i64::from(entry.cell) + 1)
}

/// How many entries from the first on are cells side by side of which the same is said.
fn run(entries: &[Entry]) -> usize {
    let first = entries[0];
    let goes_on =
        |(at, entry): &(usize, &Entry)| entry.cell == first.cell + *at as u32 && entry.occupied == first.occupied;
    entries.iter().take(RUN_MAX).enumerate().take_while(goes_on).count()
}

fn put_run(bytes: &mut Vec<u8>, behind: i64, run: &[Entry]) {
    let ahead = i64::from(run[0].cell) - behind;
    let mut folded = ((ahead << 1) ^ (ahead >> 63)).cast_unsigned();
    while folded >= 0x80 {
        bytes.push((folded as u8 & 0x7F) | 0x80);
        folded >>= 7;
    }
    bytes.push(folded as u8);
    bytes.push(((run.len() - 1) as u8) << 1 | u8::from(run[0].occupied));
}

/// The cells and words in a chunk, all of them within `cells`; nothing if it is broken anywhere.
fn unpack(bytes: &[u8], cells: usize) -> Option<Vec<(usize, bool)>> {
    let mut said = Vec::new();
    let (mut rest, mut behind) = (bytes, 0_i64);
    while !rest.is_empty() {
        let digits = rest.iter().position(|byte| byte & 0x80 == 0)? + 1;
        if digits > 5 {
            return None;
        }
        let folded = rest[..digits].iter().rev().fold(0_u64, |sum, byte| sum << 7 | u64::from(byte & 0x7F));
        let ahead = (folded >> 1).cast_signed() ^ -(folded & 1).cast_signed();
        let shape = *rest.get(digits)?;
        let (first, len) = (behind + ahead, i64::from(shape >> 1) + 1);
        if first < 0 || first + len > cells as i64 {
            return None;
        }
        said.extend((first..first + len).map(|cell| (cell as usize, shape & 1 == 1)));
        behind = first + len;
        rest = &rest[digits + 1..];
    }
    Some(said)
}

#[cfg(test)]
mod tests {
    use super::*;
    use drover_contract::{RobotId, Vec2};
    use proptest::prelude::*;

    fn ledger() -> Ledger {
        Ledger::new(&Lattice::over(Vec2::zeros(), Vec2::new(40.0, 30.0), 1.0))
    }

    fn writer(robot: u32) -> Writer {
        Writer { robot: RobotId(robot), epoch: 1 }
    }

    /// Everything that `from` has of a writer goes to `to`, piece by piece.
    fn copy(from: &Ledger, to: &mut Ledger, of: Writer) -> usize {
        let mut bytes = 0;
        while let Some(chunk) = from.chunk(of, to.head(of)) {
            assert!(chunk.changes.len() <= CHANGES_BYTES_MAX, "{}", chunk.changes.len());
            bytes += chunk.changes.len();
            to.take(&chunk);
            assert_eq!(to.head(of), chunk.upto, "it gets on");
        }
        bytes
    }

    #[test]
    fn a_square_of_cells_takes_three_bytes_a_row() {
        let (mut one, mut other) = (ledger(), ledger());
        for cell in (0..5).flat_map(|row| (0..5).map(move |column| 410 + row * 40 + column)) {
            one.write(writer(1), cell, false);
        }
        let bytes = copy(&one, &mut other, writer(1));
        assert!(bytes <= 5 * 2 + 1, "{bytes}");
        assert_eq!(other.word(writer(1), 410 + 84), Known::Free);
    }

    #[test]
    fn what_comes_twice_late_or_out_of_order_changes_nothing() {
        let (mut one, mut other) = (ledger(), ledger());
        (0..10).for_each(|cell| one.write(writer(1), cell * 3, cell % 2 == 0));
        let first = one.chunk(writer(1), 0).unwrap();
        (0..10).for_each(|cell| one.write(writer(1), cell * 3, cell % 2 == 1));
        let second = one.chunk(writer(1), first.upto).unwrap();
        assert!(other.take(&second).is_empty(), "a gap before it");
        assert_eq!(other.take(&first).len(), 10);
        assert!(other.take(&first).is_empty(), "twice");
        assert_eq!(other.take(&second).len(), 10);
        assert!(other.take(&first).is_empty(), "late");
        assert_eq!(other.word(writer(1), 3), Known::Occupied);
    }

    #[test]
    fn a_log_stays_bounded_however_often_its_writer_changes_its_mind() {
        let (mut one, mut other) = (ledger(), ledger());
        for round in 0..500 {
            (0..200).for_each(|cell| one.write(writer(1), cell * 5, (round + cell) % 2 == 0));
        }
        assert!(one.logs[&writer(1)].entries.len() <= 2 * 1_200, "{}", one.logs[&writer(1)].entries.len());
        copy(&one, &mut other, writer(1));
        let same = |cell: &usize| one.word(writer(1), *cell) == other.word(writer(1), *cell);
        assert_eq!((0..1_200).filter(same).count(), 1_200);
    }

    #[test]
    fn too_many_writers_are_not_taken() {
        let mut one = ledger();
        (1..=WRITERS_MAX as u32 + 5).for_each(|robot| one.write(writer(robot), 3, true));
        assert_eq!(one.heads().count(), WRITERS_MAX);
    }

    proptest! {
        #[test]
        fn any_gossip_that_gets_through_ends_in_the_same_words(
            said in prop::collection::vec((0_usize..3, 0_usize..1_200, any::<bool>()), 1..400),
            talks in prop::collection::vec((0_usize..3, 0_usize..3, 0_usize..3, 0_u32..9), 0..200),
        ) {
            let mut all = [ledger(), ledger(), ledger()];
            // Small boards change their minds often.
            let said = said.into_iter().map(|(robot, cell, occupied)| (robot, cell % 60, occupied));
            let mut talks = talks.into_iter();
            for (robot, cell, occupied) in said {
                all[robot].write(writer(robot as u32 + 1), cell, occupied);
                let Some((from, to, of, late)) = talks.next() else { continue };
                let of = writer(of as u32 + 1);
                // The head that was heard last may be an old one.
                let heard = all[to].head(of).saturating_sub(late);
                // Nobody takes its own words from another.
                let taker = from != to && of.robot.0 as usize != to + 1;
                if let Some(chunk) = all[from].chunk(of, heard).filter(|_| taker) {
                    all[to].take(&chunk);
                }
            }
            // Through the second robot alone.
            for (from, to, of) in [(0, 1, 1), (2, 1, 3), (1, 0, 2), (1, 0, 3), (1, 2, 1), (1, 2, 2)] {
                let (source, mut target) = (all[from].clone(), all[to].clone());
                copy(&source, &mut target, writer(of));
                all[to] = target;
            }
            for (of, cell) in (1..=3).flat_map(|of| (0..1_200).map(move |cell| (writer(of), cell))) {
                let own = all[of.robot.0 as usize - 1].word(of, cell);
                prop_assert!(all.iter().all(|ledger| ledger.word(of, cell) == own), "{of:?} {cell}");
            }
        }

        #[test]
        fn broken_chunks_are_refused_whole(changes in prop::collection::vec(any::<u8>(), 0..90)) {
            let mut one = ledger();
            let chunk = MapChunk { writer: writer(9), after: 0, upto: 5, changes };
            one.take(&chunk).iter().for_each(|change| assert!(change.cell < 1_200));
        }
    }
}
