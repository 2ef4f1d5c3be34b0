//! What ships: each robot goes where it sees most for its way, in its own part of the place, along what is known.
//!
//! **In**: the map, everybody's cell and target. **Out**: the cell to go to, known or not, anew at every step.
//!
//! **Idea**: an unknown cell has a weight; a candidate is worth the weights of what would be seen from it, over the
//! steps to it and one more. Candidates are all cells that can be reached if what is unknown is free, the nearest
//! first, until even a square of the greatest weights could not be better.
//!
//! - *Hug what is known*: a cell counts 1 + lambda times the known part of its eight neighbours, so that lanes lie side
//!   by side and no sliver is left between them.
//! - *Keep apart*: what another robot is nearer to counts `others_weight`, what another is about to see
//!   `claimed_weight`. Nobody negotiates; a robot that says nothing has no part.
//! - *Nobody stares at stone*: unknown cells that nobody can reach count nothing.
//! - *Finish* (`finish = "whole"`): cells of small unknown pockets count up to five times, so that one is emptied while
//!   a robot is near, and not by a journey at the end.
//!
//! Departs from section "beyond" of our reading of the paper in nothing but that targets of robots that have not yet
//! decided in this step count as claimed, too.
//!
//! **Cost**: two waves over the map and the candidates up to the bound.
//!
//! **Cannot solve**: with a weight of 0 for others' cells or claimed ones nothing may be worth going to while something
//! is left: the nearest frontier cell then. `None` if no frontier cell can be reached: that is the end.

use super::view::{Choose, View};
use crate::map::{Board, Field, Known, Owners, Unknowns};
use drover_config::{Explore, Finish};

/// Unknown pockets of fewer cells count more.
const POCKET_CELLS: usize = 96;
/// The smallest count 1 + this times as much ...
const POCKET_GAIN: f64 = 4.0;
/// ... those up to this many cells, and larger ones less and less.
const POCKET_FULL_CELLS: f64 = 12.0;

/// The method.
#[derive(Clone, Debug)]
pub(super) struct Sweep {
    hug_weight: f64,
    others_weight: f64,
    claimed_weight: f64,
    whole: bool,
    field: Field,
    owners: Owners,
    weights: Weights,
    pockets: Pockets,
}

impl Sweep {
    pub(super) fn new(params: &Explore) -> Self {
        Self {
            hug_weight: params.hug_weight,
            others_weight: params.others_weight,
            claimed_weight: params.claimed_weight,
            whole: params.finish == Finish::Whole,
            field: Field::default(),
            owners: Owners::default(),
            weights: Weights::default(),
            pockets: Pockets::default(),
        }
    }

    /// The most that a cell can count.
    fn weight_max(&self) -> f64 {
        (1.0 + self.hug_weight) * if self.whole { 1.0 + POCKET_GAIN } else { 1.0 }
    }

    /// Everybody's part, and what others are about to see.
    fn prepare(&mut self, view: &View<'_>) {
        let own = view.mates[view.own].into_iter();
        // Itself first: what two are as near to is worth looking at to both.
        let cells = own.map(|mate| mate.at).chain(view.others().map(|(_, mate)| mate.at));
        self.owners.begin(view.board, cells);
        self.weights.begin(view.board.count());
        self.pockets.begin(view.board.count());
        for target in view.others().filter_map(|(_, mate)| mate.target) {
            let weights = &mut self.weights;
            view.sight.look(view.board, target, |cell| view.blocks(cell), |cell| weights.claim(cell));
        }
    }

    fn weight(&mut self, board: &Board, cell: usize) -> f64 {
        if let Some(weight) = self.weights.get(cell) {
            return weight;
        }
        if self.owners.of(cell).is_none() {
            // What is seen from near may be far to go: a weight must not hang on how far the wave has come by chance.
            self.owners.extend(board, Unknowns::Free, u32::MAX - 1);
        }
        let weight = match self.owners.of(cell) {
            None => 0.0,
            Some(owner) => {
                let hug = 1.0 + self.hug_weight * f64::from(board.known_around(cell)) / 8.0;
                let others = if owner == 0 { 1.0 } else { self.others_weight };
                let claimed = if self.weights.is_claimed(cell) { self.claimed_weight } else { 1.0 };
                let pocket = if self.whole { self.pockets.factor(board, cell) } else { 1.0 };
                hug * others * claimed * pocket
            }
        };
        self.weights.put(cell, weight);
        weight
    }

    /// The best of all cells that can be reached. Waves go as far as a better one may be, and no farther.
    fn best(&mut self, view: &View<'_>) -> Option<usize> {
        let reach = view.sight.reach().unsigned_abs();
        let side = f64::from(2 * reach + 1);
        let gain_max = self.weight_max() * side * side;
        let (mut best, mut best_worth) = (None, 0.0);
        let (mut next, mut horizon) = (1, 0);
        self.field.begin(view.board, view.at());
        loop {
            if next == self.field.reached().len() {
                horizon += STRIDE_STEPS;
                self.field.extend(view.board, Unknowns::Free, horizon);
                self.owners.extend(view.board, Unknowns::Free, horizon + 2 * reach);
                if next == self.field.reached().len() {
                    return best; // there is nothing more
                }
            }
            let cell = self.field.reached()[next];
            next += 1;
            let steps = f64::from(self.field.steps(cell).unwrap_or(u32::MAX)) + 1.0;
            if gain_max <= best_worth * steps {
                return best;
            }
            if borders_unknown(view, cell) {
                let worth = self.gain(view, cell) / steps;
                if worth > best_worth {
                    (best, best_worth) = (Some(cell), worth);
                }
            }
        }
    }

    /// What would be seen from a cell.
    fn gain(&mut self, view: &View<'_>, cell: usize) -> f64 {
        let mut gain = 0.0;
        view.sight.look(
            view.board,
            cell,
            |cell| view.blocks(cell),
            |cell| {
                if view.board.at(cell) == Known::Unknown {
                    gain += self.weight(view.board, cell);
                }
            },
        );
        gain
    }
}

/// What is found within this many steps more is looked at together.
const STRIDE_STEPS: u32 = 4;

impl Choose for Sweep {
    fn reconsiders(&self, _view: &View<'_>) -> bool {
        true
    }

    fn unknowns(&self) -> Unknowns {
        Unknowns::Free
    }

    fn ways(&self) -> Option<&Field> {
        Some(&self.field)
    }

    fn choose(&mut self, view: &View<'_>, _: &Field) -> Option<usize> {
        self.prepare(view);
        self.best(view).or_else(|| nearest_frontier(view, &self.field))
    }
}

/// Whether anything unknown lies in the square around a cell: the counts of known neighbours of cells three apart tell.
fn borders_unknown(view: &View<'_>, cell: usize) -> bool {
    let board = view.board;
    if board.at(cell) == Known::Unknown {
        return true;
    }
    let inner = view.sight.reach() - 1;
    let [column, row] = board.place(cell);
    let offsets = move || (-inner..=inner).step_by(3).chain([inner]);
    let mut places = offsets().flat_map(|dy| offsets().map(move |dx| [column + dx, row + dy]));
    places.any(|place| board.cell(place).is_some_and(|other| board.known_around(other) < 8))
}

/// The nearest frontier cell that can be reached over what is known to be free.
fn nearest_frontier(view: &View<'_>, field: &Field) -> Option<usize> {
    let mut known = Field::default();
    known.spread(view.board, view.at(), Unknowns::Solid);
    let there = |cell: &&usize| view.board.is_frontier(**cell) && field.steps(**cell).is_some_and(|steps| steps > 0);
    known.reached().iter().find(there).copied()
}

/// Weights of cells, each made once a decision, and which are claimed. A stamp saves emptying the lists.
#[derive(Clone, Debug, Default)]
struct Weights {
    stamp: u32,
    claimed: Vec<u32>,
    made: Vec<u32>,
    weights: Vec<f64>,
}

impl Weights {
    fn begin(&mut self, count: usize) {
        if self.claimed.len() != count || self.stamp == u32::MAX {
            *self = Self { stamp: 0, claimed: vec![0; count], made: vec![0; count], weights: vec![0.0; count] };
        }
        self.stamp += 1;
    }

    fn claim(&mut self, cell: usize) {
        self.claimed[cell] = self.stamp;
    }

    fn is_claimed(&self, cell: usize) -> bool {
        self.claimed[cell] == self.stamp
    }

    fn get(&self, cell: usize) -> Option<f64> {
        (self.made[cell] == self.stamp).then(|| self.weights[cell])
    }

    fn put(&mut self, cell: usize, weight: f64) {
        self.made[cell] = self.stamp;
        self.weights[cell] = weight;
    }
}

/// How large the unknown pocket around a cell is, found by flooding as far as it matters.
#[derive(Clone, Debug, Default)]
struct Pockets {
    stamp: u32,
    made: Vec<u32>,
    sizes: Vec<u32>,
    queue: Vec<usize>,
}

impl Pockets {
    fn begin(&mut self, count: usize) {
        if self.made.len() != count || self.stamp == u32::MAX {
            *self = Self { stamp: 0, made: vec![0; count], sizes: vec![0; count], queue: Vec::new() };
        }
        self.stamp += 1;
    }

    /// What a cell counts for the size of its pocket.
    fn factor(&mut self, board: &Board, cell: usize) -> f64 {
        if self.made[cell] != self.stamp {
            self.flood(board, cell);
        }
        let size = self.sizes[cell] as usize;
        if size < POCKET_CELLS { 1.0 + POCKET_GAIN * (POCKET_FULL_CELLS / size as f64).min(1.0) } else { 1.0 }
    }

    fn flood(&mut self, board: &Board, cell: usize) {
        self.queue.clear();
        self.queue.push(cell);
        self.made[cell] = self.stamp;
        let mut next = 0;
        let mut large = false;
        while next < self.queue.len() && !large {
            let cell = self.queue[next];
            next += 1;
            self.sizes[cell] = 0;
            for other in board.neighbours(cell).filter(|other| board.at(*other) == Known::Unknown) {
                if self.made[other] != self.stamp {
                    self.made[other] = self.stamp;
                    self.sizes[other] = 0;
                    self.queue.push(other);
                }
                large |= self.sizes[other] as usize >= POCKET_CELLS; // a part of what was found before to be large
            }
            large |= self.queue.len() >= POCKET_CELLS;
        }
        let size = if large { POCKET_CELLS } else { self.queue.len() };
        self.queue.iter().for_each(|cell| self.sizes[*cell] = size as u32);
    }
}
