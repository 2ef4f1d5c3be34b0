//! Many runs of one swarm, one a seed, side by side on all cores.

use crate::statistics::{Spread, Worst};
use crate::trace::Trace;
use crate::trial::{Fidelity, Trial, TrialResult, run_trial, trial_of};
use anyhow::Context;
use drover_config::Swarm;
use rayon::prelude::*;
use serde::Serialize;
use std::collections::BTreeMap;
use std::path::PathBuf;

/// What a batch is made of.
pub struct Batch<L, P> {
    /// Seeds, in the order of the results.
    pub seeds: Vec<u64>,
    /// How much is simulated.
    pub fidelity: Fidelity,
    /// Where each run's recording goes, a folder a seed; none: nothing is recorded.
    pub record_to: Option<PathBuf>,
    /// The swarm with a seed: worlds and places may depend on it.
    pub load: L,
    /// Told now and then how far the runs have come.
    pub on_progress: P,
}

/// How far a batch has come since it was last told.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Progress {
    /// Simulated seconds of all runs, out of duration times runs.
    pub simulated_s: f64,
    /// Robots times steps.
    pub robot_steps: u64,
    /// Runs that have come to their end.
    pub runs: usize,
}

/// All runs and what they say together.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct BatchResult {
    /// The swarm's name.
    pub swarm: String,
    /// How much was simulated.
    pub fidelity: Fidelity,
    /// One a seed, in the seeds' order.
    pub runs: Vec<TrialResult>,
    /// By the name of a number of the runs.
    pub summary: BTreeMap<&'static str, Spread>,
}

impl<L, P> Batch<L, P>
where
    L: Fn(u64) -> anyhow::Result<Swarm> + Sync,
    P: Fn(Progress) + Sync,
{
    /// Run all of it.
    ///
    /// # Errors
    /// The first seed's that cannot be loaded, opened or recorded.
    pub fn run(&self) -> anyhow::Result<BatchResult> {
        let runs: Vec<(String, TrialResult)> =
            self.seeds.par_iter().map(|seed| self.run_one(*seed)).collect::<anyhow::Result<_>>()?;
        let swarm = runs.first().map(|(name, _)| name.clone()).unwrap_or_default();
        let runs: Vec<TrialResult> = runs.into_iter().map(|(_, run)| run).collect();
        Ok(BatchResult { swarm, fidelity: self.fidelity, summary: summarise(&runs), runs })
    }

    fn run_one(&self, seed: u64) -> anyhow::Result<(String, TrialResult)> {
        let swarm = (self.load)(seed)?;
        let mut trial = trial_of(&swarm, self.fidelity, self.record_to.is_some())?;
        let mut trace = self.record_to.as_ref().map(|_| Trace::new(&swarm));
        let mut told_s = 0.0;
        let mut steps = 0;
        let mut watch = |trial: &dyn Trial| {
            steps += 1;
            if let Some(trace) = &mut trace {
                trace.see(trial);
            }
            let now_s = trial.now().as_secs_f64();
            if now_s - told_s >= PROGRESS_S {
                let robot_steps = std::mem::take(&mut steps) * trial.arena().robot_count() as u64;
                (self.on_progress)(Progress { simulated_s: now_s - told_s, robot_steps, runs: 0 });
                told_s = now_s;
            }
        };
        let result = run_trial(&swarm, trial.as_mut(), &mut watch);
        let robot_steps = steps * swarm.robots.len() as u64;
        if let (Some(folder), Some(trace)) = (&self.record_to, &trace) {
            let folder = folder.join(format!("seed-{seed}"));
            trace
                .write(&folder, &swarm, trial.as_ref(), &result)
                .with_context(|| format!("cannot record to {}: set record_dir to one you can write", folder.display()))?;
        }
        (self.on_progress)(Progress { simulated_s: swarm.duration_s - told_s, robot_steps, runs: 1 });
        Ok((swarm.name, result))
    }
}

/// Progress is told this often, simulated seconds.
const PROGRESS_S: f64 = 0.5;

/// Every number of the runs; which end of it is the worse one stands here.
fn summarise(runs: &[TrialResult]) -> BTreeMap<&'static str, Spread> {
    let numbers = |of: fn(&TrialResult) -> f64, worst| Spread::of_numbers(runs.iter().map(of), worst);
    let gaps = |of: fn(&TrialResult) -> Option<f64>| Spread::of_numbers(runs.iter().filter_map(of), Worst::Smallest);
    let rows = [
        ("reached", Spread::of_truths(runs.iter().map(|run| run.reached), Worst::Smallest)),
        ("reached_fraction", numbers(|run| run.reached_fraction, Worst::Smallest)),
        ("time_s", numbers(|run| run.time_s, Worst::Largest)),
        ("path_m_mean", numbers(|run| run.path_m_mean, Worst::Largest)),
        ("min_gap_robot_m", gaps(|run| run.min_gap_robot_m)),
        ("min_gap_wall_m", gaps(|run| run.min_gap_wall_m)),
        ("touched", numbers(|run| run.touched as f64, Worst::Largest)),
        ("ticks", numbers(|run| run.ticks as f64, Worst::Largest)),
        ("commands_changed", numbers(|run| run.commands_changed as f64, Worst::Largest)),
        ("aged_commands", numbers(|run| run.aged_commands as f64, Worst::Largest)),
        ("beacons_carried", numbers(|run| run.beacons_carried as f64, Worst::Smallest)),
        ("beacons_lost", numbers(|run| run.beacons_lost as f64, Worst::Largest)),
        ("bytes_per_robot", numbers(|run| run.bytes_per_robot as f64, Worst::Largest)),
    ];
    rows.into_iter().filter_map(|(name, spread)| Some((name, spread?))).collect()
}
