//! One run: who, where, with how many, and whether one of them dies.

use super::rows::Row;
use crate::contest::Scene;
use drover_config::{Behaviour, Swarm};
use drover_swarm::{CellSwarm, ExploreFigures, Trial};

/// A run that is not done after so many steps is not going to be.
pub(super) const STEPS_MAX: u32 = 15_000;
/// One robot is killed when so much is known.
const HALF: f64 = 0.5;

/// What all runs of a line have in common.
#[derive(Clone, Debug)]
pub(super) struct Case<'a> {
    pub(super) scene: &'a Scene,
    pub(super) row: Row,
    /// Overrides before the row's own.
    pub(super) base: Vec<String>,
    /// Whether a robot dies halfway.
    pub(super) kills: bool,
}

impl<'a> Case<'a> {
    pub(super) fn of(scene: &'a Scene, row: Row) -> Self {
        Self { scene, row, base: Vec::new(), kills: false }
    }

    /// The team before its first step.
    pub(super) fn begin(&self, seed: u64) -> anyhow::Result<CellSwarm> {
        let set: Vec<String> = self.base.iter().cloned().chain(self.row.overrides()).collect();
        let set: Vec<&str> = set.iter().map(String::as_str).collect();
        let swarm: Swarm = self.scene.load(&set, seed)?;
        let Behaviour::Explore(explore) = &swarm.behaviour else {
            anyhow::bail!("swarm {:?} does not explore", swarm.name)
        };
        let mut trial = CellSwarm::new(&swarm, explore);
        if self.kills {
            while trial.coverage() < HALF && trial.round() {}
            trial.kill((seed % swarm.robots.len().max(1) as u64) as usize);
        }
        Ok(trial)
    }

    /// The run to its end.
    pub(super) fn run(&self, seed: u64) -> anyhow::Result<ExploreFigures> {
        let mut trial = self.begin(seed)?;
        while trial.rounds() < STEPS_MAX && trial.round() {}
        trial.explored().ok_or_else(|| anyhow::anyhow!("{} was not measured", self.scene.name()))
    }
}

/// Whether a run ended with nothing left that could be reached.
pub(super) fn is_done(run: &ExploreFigures) -> bool {
    run.finished && run.unreached_frontiers == 0
}
