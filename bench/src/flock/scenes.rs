//! Where the rows compete: the paper's two traps and its single robot, a spiral, a comb, a door, a forest and two
//! flocks that meet.

use super::rows::OF_PAPER;
use crate::contest::{Asked, Plan, Usual};
use drover_config::{Behaviour, Flock, Swarm};
use std::ops::Range;
use std::path::Path;

/// The scenes, as their files are.
const SCENES: [(&str, &[&str]); 8] = [
    (OF_PAPER[0], &[]),
    (OF_PAPER[1], &[]),
    ("flock_single", &[]),
    ("flock_spiral", &[]),
    ("flock_comb", &[]),
    ("flock_door", &[]),
    ("flock_forest", &[]),
    ("flock_headon", &[]),
];

/// As many seeds as the prototype had random starts.
pub(super) const USUAL: Usual = Usual {
    scenes: &SCENES,
    quick: OF_PAPER[0],
    cost: OF_PAPER[0],
    seeds: 0..40,
    seeds_quick: 0..2,
    fits: |swarm| flocks(swarm).map(|_| ()),
};

/// What is to be measured.
#[derive(Clone, Debug)]
pub struct FlockPlan(pub(super) Plan);

impl FlockPlan {
    /// All scenes, or `swarm` alone; `seeds` unless the usual ones are meant. `quick`: few of everything.
    ///
    /// # Errors
    /// If a file is not there, cannot be read or tells a swarm to do something else.
    pub fn new(swarm: Option<&Path>, seeds: Option<Range<u64>>, quick: bool) -> anyhow::Result<Self> {
        Plan::new(&USUAL, Asked { swarm, seeds, quick }).map(Self)
    }
}

/// What the swarm is to do.
pub(super) fn flocks(swarm: &Swarm) -> anyhow::Result<&Flock> {
    match &swarm.behaviour {
        Behaviour::Flock(flock) => Ok(flock),
        Behaviour::Deploy(_) | Behaviour::Diffuse(_) | Behaviour::Explore(_) => {
            anyhow::bail!("swarm {:?} does not flock", swarm.name)
        }
    }
}
