//! The paper's swarm: every period all robots see one snapshot of the positions around them, decide, and move at once.
//!
//! Each robot's decision uses only what it could know: peers within radio range, kept links from its own k-hop
//! neighbourhood, walls nearby, and its parent in the tree of kept links.

use super::Params;
use super::known_map::KnownMap;
use super::pilot::{Pilot, Sight};
use super::topology::{Graph, KeptGraph};
use crate::avoid::{Capsule, Disc, SafeSet};
use drover_config::{Deploy, DeployGuard, Escape, KeptLinks};
use drover_contract::Vec2;

/// Walls farther than this beyond what may matter are not looked at, metres.
const SLACK_M: f64 = 1e-6;

/// A swarm of points in lockstep.
#[derive(Clone, Debug)]
pub struct Lockstep {
    params: Params,
    links: KeptLinks,
    hops: u32,
    guard: DeployGuard,
    walls: Vec<Capsule>,
    map: Option<KnownMap>,
    pilots: Vec<Pilot>,
}

/// Links are kept that much shorter than the range, metres: rounding adds up over many steps, and a link that is longer
/// than the range by a rounding is not there.
const LINK_SLACK_M: f64 = 1e-4;

/// What all robots do in one period.
#[derive(Clone, Debug, Default)]
pub struct Moves {
    /// Where each goes, straight; where it is for one that is not there.
    pub ends_w: Vec<Vec2>,
    /// Whether the last layer changed its wish.
    pub changed: Vec<bool>,
    /// Who heard whom.
    pub graph: Graph,
    /// The kept links of this period.
    pub kept: KeptGraph,
    /// Robots that told where they are.
    pub beacons: u64,
    /// Places of others that they told, summed: what trees of more than one hop need.
    pub relayed: u64,
}

impl Lockstep {
    /// The robots of `deploy`, one a target, in their order, among `walls`, starting at `starts_w`.
    #[must_use]
    pub fn new(deploy: &Deploy, starts_w: &[Vec2], walls: Vec<Capsule>) -> Self {
        let params = Params::of(deploy);
        let targets = deploy.targets_m.iter().take(starts_w.len()).map(|[x, y]| Vec2::new(*x, *y));
        let targets_w: Vec<Vec2> = targets.collect();
        let map = match deploy.escape {
            Escape::None => None,
            Escape::Geodesic => Some(KnownMap::new(&params, &walls, starts_w, &targets_w)),
        };
        Self {
            params,
            map,
            links: deploy.links,
            hops: deploy.hops,
            guard: deploy.guard,
            walls,
            pilots: targets_w.into_iter().map(Pilot::new).collect(),
        }
    }

    /// Robot `robot`'s law.
    ///
    /// # Panics
    /// If there is no such robot.
    #[must_use]
    pub fn pilot(&self, robot: usize) -> &Pilot {
        &self.pilots[robot]
    }

    /// Whether a robot at `at_w` is where it is to go.
    #[must_use]
    pub fn has_arrived(&self, robot: usize, at_w: Vec2) -> bool {
        self.pilots[robot].has_arrived(&self.params, at_w)
    }

    /// One period of robots at `at_w`; one that is `None` is not there any more.
    #[must_use]
    pub fn round(&mut self, at_w: &[Option<Vec2>]) -> Moves {
        let graph = Graph::new(at_w, self.params.range_m);
        let graph = graph.goalward(self.params.goalward, |at_w| self.to_layout_m(at_w));
        let kept = match self.links {
            KeptLinks::All => graph.all(),
            KeptLinks::Rng => graph.rng(),
            KeptLinks::Lmst => graph.lmst(self.hops),
        };
        let parents = kept.parents(|robot| at_w[robot].map_or(f64::INFINITY, |at_w| self.to_layout_m(at_w)));
        let beacons = at_w.iter().flatten().count() as u64;
        let mut moves = Moves { relayed: kept.relayed(), kept, graph, beacons, ..Moves::default() };
        for robot in 0..at_w.len() {
            let Some(here_w) = at_w[robot] else {
                moves.ends_w.push(Vec2::zeros());
                moves.changed.push(false);
                continue;
            };
            let parent_w = parents[robot].and_then(|parent| at_w[parent]);
            let around = Around { at_w, graph: &moves.graph, kept: &moves.kept, parent_w };
            let (end_w, changed) = self.decide(robot, here_w, &around);
            moves.ends_w.push(end_w);
            moves.changed.push(changed);
        }
        moves
    }

    fn decide(&mut self, robot: usize, here_w: Vec2, around: &Around<'_>) -> (Vec2, bool) {
        let positions =
            |robots: &[usize]| -> Vec<Vec2> { robots.iter().filter_map(|other| around.at_w[*other]).collect() };
        let (peers_w, linked_w) = (positions(around.graph.neighbours(robot)), positions(around.kept.of(robot)));
        let walls = self.walls_near(here_w);
        let pilot = &mut self.pilots[robot];
        let target_aim_w = self.map.as_mut().map(|map| map.aim_w(robot, here_w));
        let parent_aim_w =
            self.map.as_ref().zip(around.parent_w).map(|(map, parent_w)| map.towards_w(here_w, parent_w));
        let sight = Sight {
            at_w: here_w,
            peers_w: &peers_w,
            linked_w: &linked_w,
            parent_w: around.parent_w,
            parent_aim_w,
            walls: &walls,
            goal_aim_w: target_aim_w.unwrap_or(self.params.goal_w),
            target_aim_w: target_aim_w.unwrap_or_else(|| pilot.target_w()),
            towed: false,
            hurry: false,
            dt_s: self.params.period_s,
        };
        let wish = pilot.wish(&self.params, &sight);
        let range_m = self.params.range_m - LINK_SLACK_M;
        let discs = linked_w.iter().map(|peer_w| Disc::between(here_w, *peer_w, range_m));
        let (safe, peers) = (self.params.safe, peers_w.iter().copied());
        let set = match self.guard {
            DeployGuard::None => None,
            DeployGuard::Collision => Some(SafeSet::around(safe, here_w, std::iter::empty(), peers, &walls)),
            DeployGuard::Full => Some(SafeSet::around(safe, here_w, discs, peers, &walls)),
        };
        let end_w = pilot.steer(&self.params, here_w, wish, set.as_ref());
        (end_w, (end_w - here_w - wish).norm() > SLACK_M)
    }

    /// How far it is to the layout's centre, metres.
    fn to_layout_m(&self, at_w: Vec2) -> f64 {
        self.map.as_ref().map_or_else(|| (at_w - self.params.goal_w).norm(), |map| map.to_layout_m(at_w))
    }

    fn walls_near(&self, here_w: Vec2) -> Vec<Capsule> {
        let safe = &self.params.safe;
        let reach_m = self.params.gains.avoid_m.max(safe.wall_gap_m + safe.step_m_max) + SLACK_M;
        self.walls.iter().filter(|wall| wall.at_least_m(here_w) <= reach_m).copied().collect()
    }
}

/// What a robot's decision needs of the snapshot.
struct Around<'a> {
    at_w: &'a [Option<Vec2>],
    graph: &'a Graph,
    kept: &'a KeptGraph,
    parent_w: Option<Vec2>,
}
