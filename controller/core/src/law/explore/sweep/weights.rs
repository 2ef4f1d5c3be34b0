//! What an unknown cell counts is kept here while a decision is made: weights, claims, sizes of pockets.

use crate::map::{Board, Known};

/// Unknown pockets of fewer cells count more.
const POCKET_CELLS: usize = 96;
/// The smallest count 1 + this times as much ...
const POCKET_GAIN: f64 = 4.0;
/// ... those up to this many cells, and larger ones less and less.
const POCKET_FULL_CELLS: f64 = 12.0;

/// Weights of cells, each made once a decision, and which are claimed. A stamp saves emptying the lists.
#[derive(Clone, Debug, Default)]
pub(super) struct Weights {
    stamp: u32,
    claimed: Vec<u32>,
    made: Vec<u32>,
    weights: Vec<f64>,
}

impl Weights {
    pub(super) fn begin(&mut self, count: usize) {
        if self.claimed.len() != count || self.stamp == u32::MAX {
            *self = Self { stamp: 0, claimed: vec![0; count], made: vec![0; count], weights: vec![0.0; count] };
        }
        self.stamp += 1;
    }

    pub(super) fn claim(&mut self, cell: usize) {
        self.claimed[cell] = self.stamp;
    }

    pub(super) fn is_claimed(&self, cell: usize) -> bool {
        self.claimed[cell] == self.stamp
    }

    pub(super) fn get(&self, cell: usize) -> Option<f64> {
        (self.made[cell] == self.stamp).then(|| self.weights[cell])
    }

    pub(super) fn put(&mut self, cell: usize, weight: f64) {
        self.made[cell] = self.stamp;
        self.weights[cell] = weight;
    }
}

/// How large the unknown pocket around a cell is, found by flooding as far as it matters.
#[derive(Clone, Debug, Default)]
pub(super) struct Pockets {
    stamp: u32,
    made: Vec<u32>,
    sizes: Vec<u32>,
    queue: Vec<usize>,
}

impl Pockets {
    pub(super) fn begin(&mut self, count: usize) {
        if self.made.len() != count || self.stamp == u32::MAX {
            *self = Self { stamp: 0, made: vec![0; count], sizes: vec![0; count], queue: Vec::new() };
        }
        self.stamp += 1;
    }

    /// What a cell counts for the size of its pocket.
    pub(super) fn factor(&mut self, board: &Board, cell: usize) -> f64 {
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
