//! Where the rows compete: the paper's three experiments, and fields and pockets that nobody was tuned on.

use crate::contest::{Asked, Plan, Usual};
use drover_config::{Behaviour, Deploy, Swarm};
use std::ops::Range;
use std::path::Path;

/// The file that the cost is measured with, and the only scene of a quick run.
const COST: &str = "deploy_exp2";
const QUICK: &str = "deploy_exp1";

/// The scenes, and what is overridden on them before a row's own overrides. The pockets' file ships with the map known;
/// here only the row of that name knows it, so that all others are asked the same.
const SCENES: [(&str, &[&str]); 6] = [
    (QUICK, &[]),
    (COST, &[]),
    ("deploy_exp3_row", &[]),
    ("deploy_exp3_random", &[]),
    ("deploy_field", &[]),
    ("deploy_pockets", &["behaviour.escape=none"]),
];

pub(super) const USUAL: Usual = Usual {
    scenes: &SCENES,
    quick: QUICK,
    cost: COST,
    seeds: 0..20,
    seeds_quick: 0..2,
    fits: |swarm| deploys(swarm).map(|_| ()),
};

/// What is to be measured.
#[derive(Clone, Debug)]
pub struct DeployPlan(pub(super) Plan);

impl DeployPlan {
    /// All scenes, or `swarm` alone; `seeds` unless the usual ones are meant. `quick`: few of everything.
    ///
    /// # Errors
    /// If a file is not there, cannot be read or tells a swarm to do something else.
    pub fn new(swarm: Option<&Path>, seeds: Option<Range<u64>>, quick: bool) -> anyhow::Result<Self> {
        Plan::new(&USUAL, Asked { swarm, seeds, quick }).map(Self)
    }
}

/// What the swarm is to do.
pub(super) fn deploys(swarm: &Swarm) -> anyhow::Result<&Deploy> {
    match &swarm.behaviour {
        Behaviour::Deploy(deploy) => Ok(deploy),
        Behaviour::Flock(_) | Behaviour::Diffuse(_) | Behaviour::Explore(_) => {
            anyhow::bail!("swarm {:?} does not deploy", swarm.name)
        }
    }
}
