//! A controller by control barrier functions: of all velocities that keep every barrier, the one nearest to the wish.
//!
//! **In**: the snapshot of positions (world frame, metres) and the scene. **Out**: the ends of straight moves, metres.
//! Each robot solves, for its step `s` of this period,
//!
//! ```text
//! minimise |s - wish|^2   subject to   |s| <= v_max T   and, with all rates in (0, 1],
//!   robot j:      n . s <= robot_rate (d - d_s) / 2               n to j, d the distance, d_s the gap to keep
//!   wall k:       n . s <= wall_rate (d - d_o)                    n to the wall's nearest point
//!   kept link j:  n . s <= (link_rate h / 4 - (v_max T)^2) / d    n away from j, h = r_c^2 - d^2
//! ```
//!
//! **Idea**: barriers `d - d_s`, `d - d_o` and `r_c^2 - d^2` must not shrink by more than a share of themselves in one
//! period; of what concerns two robots, each takes half. Links are kept along one spanning tree of the snapshot's
//! graph, chosen anew each period: the tree that costs least, where a link costs more the more the wishes would
//! violate it.
//!
//! **Sampled**: a barrier condition on velocities at an instant says nothing about the end of a period of 1 s, so the
//! conditions are those of whole steps. Distances to robots and to walls are convex along straight moves: their
//! linearisation is a lower bound, and the conditions suffice. `r_c^2 - d^2` is concave. With `|s_i - s_j|^2 <=
//! 2 |s_i|^2 + 2 |s_j|^2` each one's share is `2 |s|^2 + 2 d n . s <= link_rate h / 2` (for rate 1 the disc of Ando et
//! al. 1999), and the longest step put for `|s|` makes that linear; it costs 7 cm of range. `s = 0` satisfies all
//! shares, so who cannot solve its program stays, and everything still holds. So robots, walls and links are kept in
//! continuous time, whatever the wishes are.
//!
//! **Source**: L. Wang, A. Ames, M. Egerstedt, "Multi-objective compositions for collision-free connectivity
//! maintenance in teams of mobile robots", CDC 2016 (barriers for both); the same, IEEE Trans. Robotics 33(3), 2017
//! (halves, deadlock); W. Luo, S. Yi, K. Sycara, "Behavior mixing with minimum global and subgroup connectivity
//! maintenance for large-scale multi-robot systems", ICRA 2020 (the tree that constrains least). **Departures**: `d`
//! instead of `d^2` towards robots (allows more); steps instead of velocities; the tree is computed centrally, where
//! theirs is distributed; detours when stuck (`detour.rs`).
//!
//! **Tuned** on this bench's scenes and on random fields, about 1000 settings: rates, tree (the shortest one does as
//! well), detours. `CbfParams::default` lies on a plateau where everybody arrives; 0.6 towards robots did slightly
//! better than 1.
//!
//! **Cost**: n^2 for the tree's links, and one program of some ten half-planes for each robot. **When it cannot
//! solve**: the robot stays for this period, and that is counted. It happens where two stretched links pull to
//! opposite sides.

use super::detour::{Detour, DetourParams};
use super::links::{self, Link};
use super::qp::{HalfPlane, nearest};
use super::{Peer, SIGHT_M, Scene};
use drover_contract::Vec2;

/// Closer than this two places have no direction between them, metres.
const APART_M_MIN: f64 = 1e-12;

/// What can be tuned.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct CbfParams {
    /// Share of the room to a robot that may be used up in one period, 0 to 1; both together.
    pub(crate) robot_rate: f64,
    /// Share of the room to a wall.
    pub(crate) wall_rate: f64,
    /// Share of what is left of a link.
    pub(crate) link_rate: f64,
    /// The remedy against deadlock.
    pub(crate) detour: DetourParams,
}

impl Default for CbfParams {
    fn default() -> Self {
        Self { robot_rate: 0.6, wall_rate: 1.0, link_rate: 1.0, detour: DetourParams::default() }
    }
}

/// The peer.
#[derive(Clone, Debug, Default)]
pub(crate) struct Cbf {
    params: CbfParams,
    detours: Vec<Detour>,
    unsolved: u64,
}

impl Cbf {
    /// One that has seen nothing yet.
    #[must_use]
    pub(crate) fn new(params: CbfParams) -> Self {
        Self { params, ..Self::default() }
    }

    fn wishes(&mut self, scene: &Scene<'_>, at_w: &[Vec2]) -> Vec<Vec2> {
        self.detours.resize(at_w.len(), Detour::new());
        let robots = self.detours.iter_mut().zip(at_w).enumerate();
        robots.map(|(robot, (detour, at_w))| detour.wish(&self.params.detour, scene, (robot, *at_w))).collect()
    }

    fn kept(&self, scene: &Scene<'_>, at_w: &[Vec2], wishes: &[Vec2]) -> Vec<Link> {
        links::tree(at_w.len(), &links::within(at_w, scene.range_m), |(i, j)| {
            let apart = at_w[i] - at_w[j];
            2.0 * apart.dot(&(wishes[i] - wishes[j])) - self.params.link_rate * left_m2(scene, apart)
        })
    }

    fn planes(&self, scene: &Scene<'_>, at_w: &[Vec2], (robot, kept): (usize, &[Link])) -> Vec<HalfPlane> {
        let CbfParams { robot_rate, wall_rate, link_rate, .. } = self.params;
        let own_w = at_w[robot];
        let others = at_w.iter().enumerate().filter(|(other, _)| *other != robot).map(|(_, peer_w)| peer_w - own_w);
        let robots = others.filter(|to| to.norm() < SIGHT_M).filter_map(|to| {
            let room_m = (to.norm() - scene.robot_gap_m).max(0.0);
            Some(HalfPlane { normal: to.try_normalize(APART_M_MIN)?, bound_m: robot_rate * room_m / 2.0 })
        });
        let walls = scene.seen(own_w).filter_map(|wall| {
            let room_m = (wall.distance_m(own_w) - scene.wall_gap_m).max(0.0);
            let normal = (wall.nearest_w(own_w) - own_w).try_normalize(APART_M_MIN)?;
            Some(HalfPlane { normal, bound_m: wall_rate * room_m })
        });
        let ends = kept.iter().filter_map(|(i, j)| match (*i == robot, *j == robot) {
            (true, _) => Some(at_w[*j]),
            (_, true) => Some(at_w[*i]),
            _ => None,
        });
        let links = ends.filter_map(|peer_w| {
            let away = own_w - peer_w;
            let share_m2 = link_rate * left_m2(scene, away) / 4.0 - scene.step_m * scene.step_m;
            Some(HalfPlane { normal: away.try_normalize(APART_M_MIN)?, bound_m: share_m2 / away.norm() })
        });
        robots.chain(walls).chain(links).collect()
    }
}

/// The barrier of a link: `r_c^2 - d^2`.
fn left_m2(scene: &Scene<'_>, apart: Vec2) -> f64 {
    scene.range_m * scene.range_m - apart.norm_squared()
}

impl Peer for Cbf {
    fn name(&self) -> &'static str {
        if self.params.detour == DetourParams::NONE { "cbf without detours" } else { "cbf" }
    }

    fn round(&mut self, scene: &Scene<'_>, at_w: &[Vec2]) -> Vec<Vec2> {
        let wishes = self.wishes(scene, at_w);
        let kept = self.kept(scene, at_w, &wishes);
        let mut ends_w = Vec::with_capacity(at_w.len());
        for (robot, wish) in wishes.iter().enumerate() {
            let step = nearest(*wish, &self.planes(scene, at_w, (robot, &kept)), scene.step_m);
            self.unsolved += u64::from(step.is_none());
            ends_w.push(at_w[robot] + step.unwrap_or_else(Vec2::zeros));
        }
        ends_w
    }

    fn cannot_solve(&self) -> u64 {
        self.unsolved
    }
}
