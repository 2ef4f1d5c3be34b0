//! The last layer on its own, under wishes that no law would have.

use super::{Graph, Params, Pilot};
use crate::avoid::{Capsule, Disc, SafeSet};
use crate::testing::deploy_config;
use drover_config::{Deploy, DeployMode, DeploySteer};
use drover_contract::Vec2;

pub(super) struct Guarded {
    params: Params,
    pilots: Vec<Pilot>,
}

impl Guarded {
    pub(super) fn new(count: usize, project: bool) -> Self {
        let steer = if project { DeploySteer::Project } else { DeploySteer::Heading };
        let deploy = Deploy { steer, ..deploy_config(DeployMode::Safe, vec![[0.0, 0.0]]) };
        Self { params: Params::of(&deploy), pilots: vec![Pilot::new(Vec2::zeros()); count] }
    }

    /// Ends of the moves of robots at `at_w`. Staying must be allowed, and so must be what is chosen.
    pub(super) fn round(&mut self, at_w: &[Vec2], wishes: &[Vec2], walls: &[Capsule]) -> Vec<Vec2> {
        let there: Vec<Option<Vec2>> = at_w.iter().copied().map(Some).collect();
        let graph = Graph::new(&there, self.params.range_m);
        let kept = graph.lmst(2);
        let end_w = |(robot, pilot): (usize, &mut Pilot)| {
            let here_w = at_w[robot];
            let discs = kept.of(robot).iter().map(|peer| Disc::between(here_w, at_w[*peer], self.params.range_m));
            let peers_w: Vec<Vec2> = graph.neighbours(robot).iter().map(|peer| at_w[*peer]).collect();
            let set = SafeSet::around(self.params.safe, here_w, discs, peers_w.into_iter(), walls);
            assert!(set.allows(here_w), "the set is never empty");
            let end_w = pilot.steer(&self.params, here_w, wishes[robot], Some(&set));
            assert!(set.allows(end_w), "what is chosen is allowed");
            end_w
        };
        self.pilots.iter_mut().enumerate().map(end_w).collect()
    }
}
