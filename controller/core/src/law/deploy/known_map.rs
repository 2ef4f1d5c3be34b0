//! Ways on a known map: out of pockets, and around corners after the parent.
//!
//! With a map, "towards" means along the shortest way: each robot heads for the farthest place on it that it can reach
//! straight. Distances to the layout, which the trees prefer and the root is elected by, are lengths of such ways.

use super::Params;
use super::geodesic::{Aim, CELL_M, Field, Geodesic};
use crate::avoid::Capsule;
use drover_contract::Vec2;

/// Planned ways keep this much more from walls than the last layer asks for, metres: it must not stop who follows them.
const SPARE_M: f64 = 0.05;
/// A way to the parent that is longer than this is none: the links would not reach, metres.
const PARENT_WAY_M: f64 = 30.0;

/// The map, with the ways to the layout's centre and to each robot's target.
#[derive(Clone, Debug)]
pub(super) struct KnownMap {
    geodesic: Geodesic,
    layout: Field,
    targets: Vec<Field>,
    /// Each robot's last aim: two ways of one length must not make it turn back and forth.
    aims: Vec<Option<Aim>>,
}

impl KnownMap {
    /// Of robots that start at `starts_w` and go to `targets_w`.
    pub(super) fn new(params: &Params, walls: &[Capsule], starts_w: &[Vec2], targets_w: &[Vec2]) -> Self {
        let places = || starts_w.iter().chain(targets_w);
        let low = places().fold(params.goal_w, |low, at_w| low.inf(at_w));
        let high = places().fold(params.goal_w, |high, at_w| high.sup(at_w));
        let geodesic = Geodesic::new(walls, (low, high), params.safe.wall_gap_m + SPARE_M, CELL_M);
        Self {
            layout: geodesic.field(params.goal_w),
            targets: targets_w.iter().map(|target_w| geodesic.field(*target_w)).collect(),
            aims: vec![None; targets_w.len()],
            geodesic,
        }
    }

    /// Length of the way to the layout's centre, metres; as the crow flies where none is known.
    pub(super) fn to_layout_m(&self, at_w: Vec2) -> f64 {
        let straight_m = || (self.layout.target_w() - at_w).norm();
        self.layout.length_m(&self.geodesic, at_w).unwrap_or_else(straight_m)
    }

    /// Where robot `robot` heads for on the way to its target; the target itself where no way is known.
    pub(super) fn aim_w(&mut self, robot: usize, at_w: Vec2) -> Vec2 {
        let field = &self.targets[robot];
        let aim = field.aim(&self.geodesic, at_w, self.aims[robot]);
        self.aims[robot] = aim;
        aim.map_or_else(|| field.target_w(), |aim| aim.at_w)
    }

    /// Where to head for on the way to a parent that may be around a corner.
    pub(super) fn towards_w(&self, at_w: Vec2, parent_w: Vec2) -> Vec2 {
        if self.geodesic.clear(at_w, parent_w) {
            return parent_w;
        }
        let way = self.geodesic.way(at_w, parent_w, PARENT_WAY_M);
        way.and_then(|way| way.get(1).copied()).unwrap_or(parent_w)
    }
}
