//! Meetings of robots that hear each other only from near: where and when is agreed before anybody starts.
//!
//! **Why**: over a radio of ten cells robots that part do not hear of each other again, and each maps the whole
//! place. Whoever divides it beforehand still has to hear at last that the others are done. So all come to one place,
//! first when they can have seen about all of it together, then ever again, tell each other everything, and go on
//! with what is left.
//!
//! **In**: the step, where one is, the map, who is heard. **Out**: the cell to go to, if it is time.
//!
//! - *Place*: the start in the middle of all starts: somebody stood there, so it can be got to, if not by a known way.
//! - *Times*: the first after `cells / (n w)` steps, with sensors `w` cells wide: what `n` robots need for straight
//!   lanes without a step for nothing. From then on as all who met agree ([`Meetings::agree`]).
//! - *Leaving for it* as late as the way allows. Who knows no way there does not come: looking for one would be
//!   exploring, which it does anyway. *Leaving it* as soon as all are heard and nobody has anything that another
//!   lacks, or after [`PATIENCE`] steps: the dead do not come.
//! - Who knows of nothing left comes at once, and waits there with what it knows.
//!
//! **Cost**: a wave over the cells in the steps before a meeting.

use crate::map::{Board, Field, Unknowns};

/// Nobody is waited for longer, steps.
const PATIENCE: u32 = 25;
/// From meeting to meeting, if nobody agrees on anything: the first one's time over this.
const SHARE: u32 = 2;

/// From one meeting to the next as much more is known as at the last over this, or the time was too short.
const NEWS_SHARE: usize = 50;

/// What a robot sees of a meeting.
#[derive(Clone, Copy, Debug)]
pub struct Gathering<'a> {
    /// Steps since the start.
    pub step: u32,
    /// Where it stands.
    pub at: usize,
    /// Its map, as far as it may go there.
    pub board: &'a Board,
    /// Whether everybody is heard and nobody lacks anything.
    pub complete: bool,
    /// Whether it knows of nothing left.
    pub idle: bool,
}

/// One robot's calendar.
#[derive(Clone, Debug)]
pub struct Meetings {
    place: usize,
    every: u32,
    /// The step of the next one.
    next: u32,
    met: u32,
    /// Cells that were known at the last one.
    known: usize,
    field: Field,
}

impl Meetings {
    /// The calendar of robots that start on `starts` and see `reach` cells to each side.
    #[must_use]
    pub fn new(board: &Board, starts: &[usize], reach: u8) -> Self {
        let count = starts.len().max(1);
        let places: Vec<[i32; 2]> = starts.iter().map(|cell| board.place(*cell)).collect();
        let far = |from: &[i32; 2]| -> i32 {
            places.iter().map(|to| (from[0] - to[0]).abs().max((from[1] - to[1]).abs())).sum()
        };
        let first = (board.count() / (count * (2 * usize::from(reach) + 1))) as u32;
        Self {
            place: places.iter().min_by_key(|at| far(at)).and_then(|at| board.cell(*at)).unwrap_or(0),
            every: (first / SHARE).max(1),
            next: first,
            met: 0,
            known: 0,
            field: Field::default(),
        }
    }

    /// The cell to go to for a meeting: the agreed one. None if it is not time.
    pub fn call(&mut self, gathering: &Gathering<'_>) -> Option<usize> {
        let Gathering { step, at, board, complete, idle } = *gathering;
        if !idle && (complete && step + PATIENCE >= self.next || step >= self.next + PATIENCE) {
            self.met = self.met.saturating_add(1);
            // What is left is farther than there was time for: more time, or all would turn back before it for ever.
            let known = board.known_count();
            if known < self.known + self.known / NEWS_SHARE {
                self.every = self.every.saturating_mul(2);
            }
            self.known = known;
            self.next = step.saturating_add(self.every);
            return None;
        }
        let longest = (board.columns() + board.rows()) as u32 * 2;
        if !idle && step + longest < self.next {
            return None;
        }
        self.field.spread(board, at, Unknowns::Solid);
        let steps = self.field.steps(self.place)?;
        (idle || step + steps >= self.next).then_some(self.place)
    }

    /// The first step to the cell of the last call.
    #[must_use]
    pub fn first_step(&self, board: &Board, to: usize) -> Option<usize> {
        self.field.first_step(board, Unknowns::Solid, to)
    }

    /// All who met agree to meet again after so many steps, but not so soon that all they do is meet.
    pub fn agree(&mut self, step: u32, steps: u32) {
        self.next = step + steps.max(self.every / 2);
    }

    /// The agreed place.
    #[must_use]
    pub const fn place(&self) -> usize {
        self.place
    }

    /// How many meetings it has left behind.
    #[must_use]
    pub const fn met(&self) -> u32 {
        self.met
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn free() -> Board {
        let mut board = Board::new(30, 10);
        (0..300).for_each(|cell| {
            board.learn(cell, crate::map::Known::Free);
        });
        board
    }

    #[test]
    fn one_leaves_in_time_and_goes_on_when_all_have_met_or_nobody_comes() {
        let board = free();
        let starts = [0, 14, 29];
        let mut meetings = Meetings::new(&board, &starts, 2);
        let call = |meetings: &mut Meetings, step, at, complete| {
            meetings.call(&Gathering { step, at, board: &board, complete, idle: false })
        };
        // 300 cells, three robots, five cells wide: the first meeting is at step 20, where the second one starts.
        assert_eq!(call(&mut meetings, 5, 0, false), None);
        assert_eq!(call(&mut meetings, 6, 0, false), Some(14));
        assert_eq!(meetings.first_step(&board, 14), Some(1));
        assert_eq!(call(&mut meetings, 20, 14, false), Some(14), "it waits");
        assert_eq!(call(&mut meetings, 21, 14, true), None, "all are there");
        assert_eq!(meetings.met(), 1);
        meetings.agree(21, 40); // not sooner than after five
        assert_eq!(call(&mut meetings, 46, 0, false), None);
        assert_eq!(call(&mut meetings, 47, 0, false), Some(14));
        let mut lonely = Meetings::new(&board, &starts, 2);
        assert_eq!(call(&mut lonely, 44, 14, false), Some(14));
        assert_eq!(call(&mut lonely, 45, 14, false), None, "nobody comes");
    }

    #[test]
    fn who_has_nothing_left_comes_at_once_and_waits() {
        let board = free();
        let mut meetings = Meetings::new(&board, &[0, 14, 29], 2);
        let gathering = Gathering { step: 1, at: 0, board: &board, complete: false, idle: true };
        assert_eq!(meetings.call(&gathering), Some(14));
    }
}
