//! Many runs of one swarm, one a seed, side by side on all cores.

use crate::deployment::DeployFigures;
use crate::statistics::{Spread, Worst};
use crate::trace::Trace;
use crate::trial::{Fidelity, Trial, TrialResult, Watch, run_trial, trial_of};
use anyhow::Context;
use drover_config::Swarm;
use drover_robot::MapFiles;
use rayon::prelude::*;
use serde::Serialize;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};

/// What a batch is made of.
pub struct Batch<L, P> {
    /// The swarm's name.
    pub swarm: String,
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
    /// Whether it was ended before all of them had come to theirs; those are left out.
    pub interrupted: bool,
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
    /// Run all of it. When `end` turns true, runs that have not come to their end are given up.
    ///
    /// # Errors
    /// The first seed's that cannot be loaded, opened or recorded.
    pub fn run(&self, end: &AtomicBool) -> anyhow::Result<BatchResult> {
        let runs: Vec<Option<TrialResult>> =
            self.seeds.par_iter().map(|seed| self.run_one(*seed, end)).collect::<anyhow::Result<_>>()?;
        let runs: Vec<TrialResult> = runs.into_iter().flatten().collect();
        let (swarm, interrupted) = (self.swarm.clone(), runs.len() < self.seeds.len());
        Ok(BatchResult { swarm, fidelity: self.fidelity, interrupted, summary: summarise(&runs), runs })
    }

    fn run_one(&self, seed: u64, end: &AtomicBool) -> anyhow::Result<Option<TrialResult>> {
        if end.load(Ordering::Relaxed) {
            return Ok(None);
        }
        let swarm = (self.load)(seed)?;
        let folder = self.record_to.as_ref().map(|folder| folder.join(format!("seed-{seed}")));
        let unwritable =
            || format!("cannot record run {seed}: set record_dir to a folder you can write, with room in it");
        let scans = self.fidelity == Fidelity::Direct;
        let trace =
            folder.as_ref().map(|folder| Trace::create(folder, &swarm, scans)).transpose().with_context(unwritable)?;
        let mut trial = trial_of(&swarm, self.fidelity, trace.as_ref().map(Trace::recorder))?;
        let mut watch = Observer { batch: self, end, trace, told_s: 0.0, steps: 0 };
        let result = run_trial(&swarm, trial.as_mut(), &mut watch);
        watch.tell(trial.as_ref(), swarm.duration_s, result.is_some());
        let (Some(result), trace) = (result, watch.trace) else { return Ok(None) };
        if let Some(folder) = &folder {
            write_maps(trial.as_ref(), &swarm, folder).with_context(unwritable)?;
        }
        if let Some(trace) = trace {
            // The robots' tapes end with them.
            drop(trial);
            trace.finish(&result).with_context(unwritable)?;
        }
        Ok(Some(result))
    }
}

/// The maps that living robots made, beside the recording.
fn write_maps(trial: &dyn Trial, swarm: &Swarm, folder: &Path) -> std::io::Result<()> {
    for (robot, config) in swarm.robots.iter().enumerate() {
        if let Some(map) = trial.map(robot) {
            MapFiles::of(config.id, map).write(folder)?;
        }
    }
    Ok(())
}

/// Looks on while a run goes on: records it, tells how far it has come, ends it when asked to.
struct Observer<'a, L, P> {
    batch: &'a Batch<L, P>,
    end: &'a AtomicBool,
    trace: Option<Trace>,
    told_s: f64,
    steps: u64,
}

impl<L, P: Fn(Progress) + Sync> Observer<'_, L, P> {
    /// Tell of the way up to `now_s`.
    fn tell(&mut self, trial: &dyn Trial, now_s: f64, finished: bool) {
        let robot_steps = std::mem::take(&mut self.steps) * trial.arena().robot_count() as u64;
        let simulated_s = now_s - self.told_s;
        self.told_s = now_s;
        (self.batch.on_progress)(Progress { simulated_s, robot_steps, runs: usize::from(finished) });
    }
}

impl<L, P: Fn(Progress) + Sync> Watch for Observer<'_, L, P> {
    fn stepped(&mut self, trial: &dyn Trial) -> bool {
        self.steps += 1;
        if let Some(trace) = &mut self.trace {
            trace.see(trial);
        }
        let now_s = trial.now().as_secs_f64();
        if now_s - self.told_s >= PROGRESS_S {
            self.tell(trial, now_s, false);
        }
        !self.end.load(Ordering::Relaxed)
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
    let deployments = deployment_rows(runs);
    rows.into_iter().chain(deployments).filter_map(|(name, spread)| Some((name, spread?))).collect()
}

/// The numbers that only deployments have.
fn deployment_rows(runs: &[TrialResult]) -> [(&'static str, Option<Spread>); 7] {
    let figures = || runs.iter().filter_map(|run| run.deploy.as_ref());
    let numbers = |of: fn(&DeployFigures) -> f64, worst| Spread::of_numbers(figures().map(of), worst);
    let lambda2 = Spread::of_numbers(figures().filter_map(|run| run.lambda2_min), Worst::Smallest);
    [
        ("connected_always", Spread::of_truths(figures().map(|run| run.connected_always), Worst::Smallest)),
        ("lambda2_min", lambda2),
        ("time_disconnected_s", numbers(|run| run.time_disconnected_s, Worst::Largest)),
        ("arrived_fraction", numbers(|run| run.arrived_fraction, Worst::Smallest)),
        ("tunnelled", numbers(|run| run.tunnelled as f64, Worst::Largest)),
        ("guard_changed_fraction", numbers(|run| run.guard_changed_fraction, Worst::Largest)),
        ("messages_bytes", numbers(|run| run.messages_bytes as f64, Worst::Largest)),
    ]
}
