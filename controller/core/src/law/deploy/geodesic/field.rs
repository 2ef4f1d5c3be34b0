//! What a wave left behind: the length of the shortest way to its target, and where to go for it, from any place.

use super::Geodesic;
use super::grid::Patch;
use super::wave::{Aimed, NONE, Root, Wave};
use drover_contract::Vec2;

/// Halvings of the leg that a robot sees the beginning of but not the end: to a thousandth of it.
const HALVINGS: usize = 10;

/// The shortest ways to one target. Ask it with the [`Geodesic`] that made it.
#[derive(Clone, Debug)]
pub struct Field {
    patch: Patch,
    /// For each cell, the root that its way turns at next.
    root_of: Vec<u32>,
    /// The first is the target.
    roots: Vec<Root>,
}

/// A way to the target from where one asked.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Aim {
    /// The farthest place on it that can be reached straight, world frame, metres.
    pub at_w: Vec2,
    /// Its length, metres.
    pub length_m: f64,
    /// The root that it leads to from there.
    next: u32,
}

/// The first leg of a way: straight to a place, from where `next` is seen.
struct Leg {
    to_w: Vec2,
    next: u32,
    /// Of the way to the target, metres, before its string is pulled.
    length_m: f64,
}

impl Field {
    pub(super) fn new(geodesic: &Geodesic, patch: Patch, target_w: Vec2, aimed: Option<Aimed>) -> Self {
        let mut wave = Wave::new(geodesic, patch, target_w, aimed);
        wave.run();
        let mut field = Self { patch, root_of: wave.root_of, roots: wave.roots };
        field.tighten(geodesic);
        field
    }

    /// Where the ways lead, world frame.
    #[must_use]
    pub fn target_w(&self) -> Vec2 {
        self.roots[0].at_w
    }

    /// Length of the shortest way from a place, metres; `None` where no way is known.
    #[must_use]
    pub fn length_m(&self, geodesic: &Geodesic, from_w: Vec2) -> Option<f64> {
        self.aim(geodesic, from_w, None).map(|aim| aim.length_m)
    }

    /// The farthest place on the shortest way that can be reached straight; `None` where no way is known.
    #[must_use]
    pub fn aim_w(&self, geodesic: &Geodesic, from_w: Vec2) -> Option<Vec2> {
        self.aim(geodesic, from_w, None).map(|aim| aim.at_w)
    }

    /// Where to go from here and how far it is in all; `None` where no way is known.
    ///
    /// Whoever gives the aim of `before` (of this field, or `None`) goes on with it until there is a shorter way: then
    /// each metre towards the aim makes the length at least a metre less, and no two ways that seem equally long can
    /// keep a robot between them.
    #[must_use]
    pub fn aim(&self, geodesic: &Geodesic, from_w: Vec2, before: Option<Aim>) -> Option<Aim> {
        let kept = before.and_then(|before| self.leg_kept(geodesic, from_w, before));
        let leg = self.first_leg(geodesic, from_w, kept)?;
        Some(self.pull(geodesic, from_w, leg))
    }

    /// The way from a place, from turn to turn, both ends included.
    pub(super) fn way_w(&self, geodesic: &Geodesic, from_w: Vec2) -> Option<Vec<Vec2>> {
        let mut leg = self.first_leg(geodesic, from_w, None)?;
        let mut way_w = vec![from_w];
        loop {
            let aim = self.pull(geodesic, *way_w.last()?, leg);
            way_w.push(aim.at_w);
            if aim.at_w == self.target_w() {
                return Some(way_w);
            }
            leg = self.leg_to(aim.next); // it leads on towards the target each time: no root is on its own way
        }
    }

    /// Turning points are centres of cells. Pull a string from each, and put a root where it leaves the old way.
    fn tighten(&mut self, geodesic: &Geodesic) {
        for root in 1..self.roots.len() {
            let Root { at_w, next, .. } = self.roots[root]; // `next` stands before it in the list, and is done
            let aim = self.pull(geodesic, at_w, self.leg_to(next));
            let Root { at_w: after_w, length_m: after_m, .. } = self.roots[aim.next as usize];
            self.roots[root] = Root { at_w, length_m: aim.length_m, next: self.roots.len() as u32 };
            self.roots.push(Root { at_w: aim.at_w, length_m: (after_w - aim.at_w).norm() + after_m, next: aim.next });
        }
    }

    fn leg_to(&self, root: u32) -> Leg {
        let Root { at_w, length_m, next } = self.roots[root as usize];
        Leg { to_w: at_w, next, length_m }
    }

    /// Follow the way as far as it is seen from here, over turns, and then as far as the next leg is.
    fn pull(&self, geodesic: &Geodesic, from_w: Vec2, leg: Leg) -> Aim {
        let (mut seen_w, mut next) = (leg.to_w, leg.next);
        loop {
            if seen_w == self.target_w() {
                return Aim { at_w: seen_w, length_m: (seen_w - from_w).norm(), next: 0 };
            }
            let Root { at_w: next_w, next: after, .. } = self.roots[next as usize];
            if !geodesic.passes(from_w, next_w) {
                break;
            }
            (seen_w, next) = (next_w, after);
        }
        let Root { at_w: next_w, length_m, .. } = self.roots[next as usize];
        let mut hidden_w = next_w;
        for _ in 0..HALVINGS {
            let middle_w = (seen_w + hidden_w) / 2.0;
            if geodesic.passes(from_w, middle_w) { seen_w = middle_w } else { hidden_w = middle_w }
        }
        let length_m = (seen_w - from_w).norm() + (next_w - seen_w).norm() + length_m;
        Aim { at_w: seen_w, length_m, next }
    }

    /// The leg to the aim of before, if it is still seen.
    fn leg_kept(&self, geodesic: &Geodesic, from_w: Vec2, before: Aim) -> Option<Leg> {
        let root = self.roots.get(before.next as usize)?;
        let length_m = (before.at_w - from_w).norm() + (root.at_w - before.at_w).norm() + root.length_m;
        let leg = Leg { to_w: before.at_w, next: before.next, length_m };
        geodesic.still_passes(from_w, before.at_w).then_some(leg)
    }

    /// The target if it is seen; else the best of `best` and the roots that cells around are settled on, straight or by
    /// a cell.
    fn first_leg(&self, geodesic: &Geodesic, from_w: Vec2, mut best: Option<Leg>) -> Option<Leg> {
        let straight_m = (self.target_w() - from_w).norm();
        if geodesic.reachable(self.target_w()) && geodesic.passes(from_w, self.target_w()) {
            return Some(Leg { to_w: self.target_w(), next: 0, length_m: straight_m });
        }
        let around = geodesic.sight.grid.place_of(from_w);
        let settled = |cell: &usize| self.root_of[*cell] != NONE;
        let at_home = self.patch.ring(around, 0).any(|cell| settled(&cell));
        for ring in 0..=geodesic.rings {
            self.patch
                .ring(around, ring)
                .filter(settled)
                .for_each(|cell| self.better(geodesic, from_w, cell, &mut best));
            if at_home && ring == 1 {
                break; // else it is narrow here, and what one sees of the next room counts
            }
        }
        best
    }

    /// Take the way by this cell's root, or by the cell, if it is shorter and can be gone.
    fn better(&self, geodesic: &Geodesic, from_w: Vec2, cell: usize, best: &mut Option<Leg>) {
        let root_index = self.root_of[cell];
        let root = &self.roots[root_index as usize];
        let (column, row) = self.patch.place_of(cell);
        let centre_w = geodesic.sight.grid.centre_w(column, row);
        let by_cell_m = root.length_m + (root.at_w - centre_w).norm();
        let legs = [
            Leg { to_w: root.at_w, next: root.next, length_m: root.length_m + (root.at_w - from_w).norm() },
            Leg { to_w: centre_w, next: root_index, length_m: by_cell_m + (centre_w - from_w).norm() },
        ];
        for leg in legs {
            let shorter = best.as_ref().is_none_or(|best| leg.length_m < best.length_m);
            if shorter && geodesic.passes(from_w, leg.to_w) {
                *best = Some(leg);
            }
        }
    }
}
