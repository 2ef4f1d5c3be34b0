//! The wave that spreads from a target and leaves in each cell where the shortest way turns next.
//!
//! **In**: a target (world frame, metres), the cells of a patch. **Out**: for each cell that was reached the *root*
//! that it sees: the target, or a turning point from which the way goes on to a root of its own.
//!
//! **Idea**: Dijkstra's algorithm, cell by cell in the order of length, in which a cell hangs on the roots of its
//! neighbours if it sees them, and else on a neighbour, which becomes a root. So ways have the direction that they want
//! and turn at corners only (Theta*, with the test of sight when a cell is settled rather than when it is touched).
//!
//! Seldom must sight be tested by geometry: when two settled neighbours towards the root, on either side of the way to
//! it, see it, and one may pass from both to the cell, the way lies in a quadrangle whose sides all keep the distance.
//! From a wall nearer to the way than that a side would be nearer still, or the wall would lie within, where nothing is
//! farther than half a cell from a side. So for `keep_m` > half a cell the way is clear.
//!
//! **Source**: A. Nash, S. Koenig, C. Tovey, "Lazy Theta*: any-angle path planning and path length analysis in 3D",
//! AAAI 2010. Departures: all neighbours' roots are tried, not the one that touched the cell; the quadrangle: ours.
//!
//! **Cost**: O(cells log cells), 0.12 us a cell, twice that where walls are many: sight is tested along the borders of
//! shadows, and where waves meet that came round a wall on both sides.
//! **Cannot solve**: cells behind walls without a gap are not reached.

use super::grid::{NEIGHBOURS, Patch};
use super::{Geodesic, SLACK_M};
use drover_contract::Vec2;
use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// No root.
pub(super) const NONE: u32 = u32::MAX;

/// The target, or a place where ways turn.
#[derive(Clone, Copy, Debug)]
pub(super) struct Root {
    pub(super) at_w: Vec2,
    /// From here to the target, metres.
    pub(super) length_m: f64,
    /// Where the way turns next; the target names itself.
    pub(super) next: u32,
}

/// A wave that is meant for one place: it goes where a way of at most this length may lead.
#[derive(Clone, Copy, Debug)]
pub(super) struct Aimed {
    pub(super) from_w: Vec2,
    pub(super) length_m_max: f64,
}

/// What a cell hangs on.
#[derive(Clone, Copy)]
enum Hold {
    Root(u32),
    Cell(usize),
}

/// Where the wave is.
pub(super) struct Wave<'a> {
    geodesic: &'a Geodesic,
    patch: Patch,
    /// Directions in which one may pass from each cell to the next of the patch, as bits.
    moves: Vec<u8>,
    aimed: Option<Aimed>,
    pub(super) roots: Vec<Root>,
    /// For each cell of the patch; [`NONE`] until it is settled.
    pub(super) root_of: Vec<u32>,
    /// Of a settled cell the length of its way, of another what is hoped for, metres.
    lengths_m: Vec<f64>,
    /// Which root a cell has become, if it has.
    own_root: Vec<u32>,
    /// Lengths as bits, which are in the same order, and cells.
    front: BinaryHeap<Reverse<(u64, u32)>>,
}

impl<'a> Wave<'a> {
    pub(super) fn new(geodesic: &'a Geodesic, patch: Patch, target_w: Vec2, aimed: Option<Aimed>) -> Self {
        Self {
            geodesic,
            patch,
            moves: patch.moves(&geodesic.moves, geodesic.sight.grid.columns),
            aimed,
            roots: vec![Root { at_w: target_w, length_m: 0.0, next: 0 }],
            root_of: vec![NONE; patch.cells()],
            lengths_m: vec![f64::INFINITY; patch.cells()],
            own_root: vec![NONE; patch.cells()],
            front: BinaryHeap::new(),
        }
    }

    /// Spread as far as there is a way, or until it is known from where the wave is aimed for.
    pub(super) fn run(&mut self) {
        self.start();
        let grid = &self.geodesic.sight.grid;
        let stop = self.aimed.and_then(|aimed| self.patch.ring(grid.place_of(aimed.from_w), 0).next());
        while let Some(Reverse((bits, cell))) = self.front.pop() {
            let cell = cell as usize;
            if self.root_of[cell] != NONE || f64::from_bits(bits) > self.rank_m(cell) {
                continue;
            }
            let (length_m, hold) = self.best(cell);
            if length_m > self.lengths_m[cell] + SLACK_M {
                self.lengths_m[cell] = length_m; // it hoped for a root that it does not see
                self.push(cell);
                continue;
            }
            let root = self.root_named(hold);
            self.settle(cell, root);
            if stop == Some(cell) {
                return;
            }
        }
    }

    /// Settle the cells around the target. If it is too near to a wall, each is a root: sight of the target itself
    /// would mean less than the distance to keep.
    fn start(&mut self) {
        let sight = &self.geodesic.sight;
        let target_w = self.roots[0].at_w;
        if !self.geodesic.reachable(target_w) {
            return;
        }
        let strict = sight.room_m(target_w) >= self.geodesic.keep_m;
        for cell in self.geodesic.cells_seen(self.patch, target_w) {
            let at_w = self.centre_w(cell);
            let length_m = (at_w - target_w).norm();
            self.lengths_m[cell] = length_m;
            let root = if strict { 0 } else { self.add_root(Root { at_w, length_m, next: 0 }) };
            self.settle(cell, root);
        }
    }

    fn add_root(&mut self, root: Root) -> u32 {
        self.roots.push(root);
        self.roots.len() as u32 - 1
    }

    /// The root to hang on: a cell becomes one when it is first hung on.
    fn root_named(&mut self, hold: Hold) -> u32 {
        match hold {
            Hold::Root(root) => root,
            Hold::Cell(cell) => {
                if self.own_root[cell] == NONE {
                    let (at_w, length_m) = (self.centre_w(cell), self.lengths_m[cell]);
                    self.own_root[cell] = self.add_root(Root { at_w, length_m, next: self.root_of[cell] });
                }
                self.own_root[cell]
            }
        }
    }

    /// The cell hangs on `root`; its neighbours may hope to do so too.
    fn settle(&mut self, cell: usize, root: u32) {
        self.root_of[cell] = root;
        let Root { at_w, length_m, .. } = self.roots[root as usize];
        let from_root = self.centre_w(cell) - at_w;
        self.lengths_m[cell] = length_m + from_root.norm();
        for direction in directions(self.moves[cell]) {
            let neighbour = self.neighbour(cell, direction);
            if self.root_of[neighbour] == NONE {
                let hoped_m = length_m + (from_root + self.geodesic.steps[direction]).norm();
                if hoped_m < self.lengths_m[neighbour] - SLACK_M {
                    self.lengths_m[neighbour] = hoped_m;
                    self.push(neighbour);
                }
            }
        }
    }

    fn push(&mut self, cell: usize) {
        let rank_m = self.rank_m(cell);
        if self.aimed.is_none_or(|aimed| rank_m <= aimed.length_m_max) {
            self.front.push(Reverse((rank_m.to_bits(), cell as u32)));
        }
    }

    /// Shortest possible way through the cell: what cells are settled in the order of.
    fn rank_m(&self, cell: usize) -> f64 {
        let rest_m = self.aimed.map_or(0.0, |aimed| (self.centre_w(cell) - aimed.from_w).norm());
        self.lengths_m[cell] + rest_m
    }

    /// The shortest way on from a cell with a settled neighbour, and what it hangs on.
    fn best(&self, cell: usize) -> (f64, Hold) {
        let (at_w, mut best) = (self.centre_w(cell), (f64::INFINITY, Hold::Root(0)));
        for direction in directions(self.moves[cell]) {
            let neighbour = self.neighbour(cell, direction);
            let length_m = self.lengths_m[neighbour] + self.geodesic.steps[direction].norm() + SLACK_M;
            if self.root_of[neighbour] != NONE && length_m < best.0 {
                best = (length_m, Hold::Cell(neighbour));
            }
        }
        let mut tried = [NONE; 8];
        for direction in directions(self.moves[cell]) {
            let root = self.root_of[self.neighbour(cell, direction)];
            if root == NONE || tried.contains(&root) {
                continue;
            }
            tried[direction] = root;
            let from = &self.roots[root as usize];
            let length_m = from.length_m + (at_w - from.at_w).norm();
            if length_m < best.0 && self.sees(cell, root, from.at_w - at_w) {
                best = (length_m, Hold::Root(root));
            }
        }
        best
    }

    fn sees(&self, cell: usize, root: u32, to_root: Vec2) -> bool {
        self.flanked(cell, root, to_root) || self.geodesic.keeps(self.centre_w(cell), self.roots[root as usize].at_w)
    }

    /// Whether the two neighbours on either side of the way to the root see it: then the cell does.
    fn flanked(&self, cell: usize, root: u32, to_root: Vec2) -> bool {
        // The octant of `to_root` lies between a direction along an axis and a diagonal one.
        let (east, north) = (to_root.x > 0.0, to_root.y > 0.0);
        let axis = match to_root.x.abs() > to_root.y.abs() {
            true if east => 0,
            true => 4,
            false if north => 2,
            false => 6,
        };
        let diagonal = match (east, north) {
            (true, true) => 1,
            (false, true) => 3,
            (false, false) => 5,
            (true, false) => 7,
        };
        let flanks = (1 << axis) | (1 << diagonal);
        self.geodesic.thin
            && self.moves[cell] & flanks == flanks
            && self.root_of[self.neighbour(cell, axis)] == root
            && self.root_of[self.neighbour(cell, diagonal)] == root
    }

    fn centre_w(&self, cell: usize) -> Vec2 {
        let (column, row) = self.patch.place_of(cell);
        self.geodesic.sight.grid.centre_w(column, row)
    }

    /// The neighbour of a cell in a direction in which one may pass.
    fn neighbour(&self, cell: usize, direction: usize) -> usize {
        let (right, up) = NEIGHBOURS[direction];
        cell.wrapping_add_signed(up * self.patch.columns as isize + right)
    }
}

/// The directions of which a bit is set.
fn directions(moves: u8) -> impl Iterator<Item = usize> {
    (0..8).filter(move |direction| moves & (1 << direction) != 0)
}
