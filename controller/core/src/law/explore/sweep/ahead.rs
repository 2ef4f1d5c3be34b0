//! The next steps: which of all short walks sees most, and sees it early.
//!
//! **In**: the map, where the robot stands, what each unknown cell weighs. **Out**: where the best walk ends, how it
//! begins and what it sees a step.
//!
//! **Idea**: step by step keep, for each cell, the walk that ends there and has seen most, and of those the best few
//! (a beam). What a walk has seen already it does not see again: so lanes lie side by side, a passage wider than sight
//! is walked in zigzags that miss nothing, and of all ways to a place the one that sees more on it is taken. What is
//! seen later counts less: who knows what is found until then.
//!
//! **Cost**: about `STEPS` x `WIDTH` x 8 unions of squares, each cell of which is a bit; nothing grows with the map.
//!
//! **Cannot solve**: what is more than `STEPS` away, which is left to [`super::afar`].

use super::super::view::View;
use crate::map::{Board, Known};

/// The window that is looked at, cells to a side: a row of it is a word.
const SIDE: usize = 32;
/// The robot stands in its middle.
const MIDDLE: i32 = SIDE as i32 / 2;
/// How far walks go: two lanes and the turn between them, in a passage.
const STEPS: usize = 10;
/// How many are kept.
const WIDTH: usize = 20;
/// What is seen a step later counts this much.
const DISCOUNT: f64 = 0.95;
const NEIGHBOURS: [[i32; 2]; 8] = [[1, 0], [-1, 0], [0, 1], [0, -1], [1, 1], [1, -1], [-1, 1], [-1, -1]];
const NOBODY: u32 = u32::MAX;

/// The best walk.
#[derive(Clone, Copy, Debug)]
pub(super) struct Plan {
    /// Where it ends.
    pub(super) end: usize,
    /// Its first step.
    pub(super) first: usize,
    /// Weights that it sees a step, what is late counting less.
    pub(super) rate: f64,
}

/// A walk.
#[derive(Clone, Debug)]
struct Walk {
    end: usize,
    first: usize,
    worth: f64,
    /// What it has seen of the window, row by row.
    seen: [u32; SIDE],
}

/// Finds it; keeps nothing but memory.
#[derive(Clone, Debug, Default)]
pub(super) struct Ahead {
    window: Window,
    walks: Vec<Walk>,
    longer: Vec<Walk>,
    /// Which of the longer walks ends on a cell of the window.
    ends: Vec<u32>,
}

impl Ahead {
    /// The best walk; none if nothing that weighs is seen on any.
    pub(super) fn plan(&mut self, view: &View<'_>, mut weight: impl FnMut(usize) -> f64) -> Option<Plan> {
        self.window.begin(view);
        self.walks.clear();
        self.walks.push(Walk { end: view.at(), first: view.at(), worth: 0.0, seen: [0; SIDE] });
        let (mut discount, mut steps) = (1.0, 0.0);
        // Sight must not leave the window: one that is wide sees far without walks.
        for step in 0..STEPS.min((MIDDLE - 1 - view.sight.reach()).max(1) as usize) {
            self.longer.clear();
            self.ends.clear();
            self.ends.resize(SIDE * SIDE, NOBODY);
            for walk in 0..self.walks.len() {
                self.go_on(view, walk, (step == 0, discount), &mut weight);
            }
            core::mem::swap(&mut self.walks, &mut self.longer);
            let order = |a: &Walk, b: &Walk| b.worth.total_cmp(&a.worth).then(a.end.cmp(&b.end));
            if self.walks.len() > WIDTH {
                self.walks.select_nth_unstable_by(WIDTH, order);
                self.walks.truncate(WIDTH);
            }
            self.walks.sort_unstable_by(order);
            steps += discount;
            discount *= DISCOUNT;
        }
        let best = self.walks.first().filter(|walk| walk.worth > 0.0)?;
        Some(Plan { end: best.end, first: best.first, rate: best.worth / steps })
    }

    /// All walks that are one step longer. Nobody cuts the corner of an occupied cell.
    fn go_on(
        &mut self,
        view: &View<'_>,
        walk: usize,
        (is_first, discount): (bool, f64),
        weight: &mut impl FnMut(usize) -> f64,
    ) {
        let Self { window, walks, longer, ends } = self;
        let (board, walk) = (view.board, &walks[walk]);
        let [column, row] = board.place(walk.end);
        let open = |place: [i32; 2]| board.cell(place).is_some_and(|cell| !blocks(board, cell));
        for [dx, dy] in NEIGHBOURS {
            let place = [column + dx, row + dy];
            let Some(end) = board.cell(place).filter(|end| !blocks(board, *end)) else { continue };
            if dx != 0 && dy != 0 && !(open([column + dx, row]) && open([column, row + dy])) {
                continue;
            }
            let here = window.index(place);
            window.look(view, end, weight);
            let worth = walk.worth + discount * window.gain(here, &walk.seen);
            let other = ends[here] as usize;
            if longer.get(other).is_some_and(|other| other.worth >= worth) {
                continue;
            }
            let mut longest = Walk { end, first: if is_first { end } else { walk.first }, worth, seen: walk.seen };
            window.see(here, &mut longest.seen);
            if ends[here] == NOBODY {
                ends[here] = longer.len() as u32;
                longer.push(longest);
            } else {
                longer[other] = longest;
            }
        }
    }
}

fn blocks(board: &Board, cell: usize) -> bool {
    board.at(cell) == Known::Occupied
}

/// What is seen from the cells around the robot, found when it is first asked for.
#[derive(Clone, Debug, Default)]
struct Window {
    low: [i32; 2],
    reach: usize,
    looked: Vec<bool>,
    /// Unknown cells that are seen from each cell: words of the rows around it, the lowest first.
    sights: Vec<u32>,
    weights: Vec<Option<f64>>,
}

impl Window {
    fn begin(&mut self, view: &View<'_>) {
        let [column, row] = view.board.place(view.at());
        self.low = [column - MIDDLE, row - MIDDLE];
        self.reach = view.sight.reach().unsigned_abs() as usize;
        self.looked.clear();
        self.looked.resize(SIDE * SIDE, false);
        self.weights.clear();
        self.weights.resize(SIDE * SIDE, None);
        self.sights.resize(SIDE * SIDE * self.rows(), 0);
    }

    /// Rows that are seen from a cell.
    const fn rows(&self) -> usize {
        2 * self.reach + 1
    }

    const fn index(&self, [column, row]: [i32; 2]) -> usize {
        (row - self.low[1]) as usize * SIDE + (column - self.low[0]) as usize
    }

    fn look(&mut self, view: &View<'_>, cell: usize, weight: &mut impl FnMut(usize) -> f64) {
        let board = view.board;
        let here = self.index(board.place(cell));
        if core::mem::replace(&mut self.looked[here], true) {
            return;
        }
        let rows = self.rows();
        let (first, lowest) = (here * rows, here / SIDE - self.reach);
        self.sights[first..first + rows].fill(0);
        let seen = |cell: usize| {
            if board.at(cell) == Known::Unknown {
                let there = self.index(board.place(cell));
                self.sights[first + there / SIDE - lowest] |= 1 << (there % SIDE);
                self.weights[there].get_or_insert_with(|| weight(cell));
            }
        };
        view.sight.look(board, cell, |cell| view.blocks(cell), seen);
    }

    /// The rows of the window that are seen from one of its cells, and what of them is.
    fn sight(&self, here: usize) -> impl Iterator<Item = (usize, u32)> + '_ {
        let words = &self.sights[here * self.rows()..(here + 1) * self.rows()];
        words.iter().enumerate().map(move |(row, word)| (here / SIDE - self.reach + row, *word))
    }

    /// Weights of what is seen from a cell and was not before.
    fn gain(&self, here: usize, seen: &[u32; SIDE]) -> f64 {
        let mut gain = 0.0;
        for (row, word) in self.sight(here) {
            let mut fresh = word & !seen[row];
            while fresh != 0 {
                gain += self.weights[row * SIDE + fresh.trailing_zeros() as usize].unwrap_or_default();
                fresh &= fresh - 1;
            }
        }
        gain
    }

    fn see(&self, here: usize, seen: &mut [u32; SIDE]) {
        self.sight(here).for_each(|(row, word)| seen[row] |= word);
    }
}
