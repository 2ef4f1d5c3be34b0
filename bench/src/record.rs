//! What a recording costs: processor time of a swarm with and without one, in turns, and its size for ten minutes.

use crate::bringup::drive_for;
use crate::machine::Conditions;
use anyhow::Context;
use drover_config::Swarm;
use drover_swarm::{Batch, Fidelity};
use serde::Serialize;
use std::fmt;
use std::sync::atomic::AtomicBool;

/// What was measured.
#[derive(Clone, Debug, Serialize)]
pub struct RecordResult {
    /// Under which conditions.
    pub conditions: Conditions,
    /// Robots.
    pub robots: usize,
    /// How long each run was watched, s.
    pub watched_s: f64,
    /// Share of a core that the whole process used, a number a run: without recording.
    pub cores_without: Vec<f64>,
    /// The same with recording.
    pub cores_with: Vec<f64>,
    /// Median of the pairs' differences, share of a core.
    pub cores_cost: f64,
    /// Simulated seconds of the run whose size is told.
    pub size_s: f64,
    /// Its size, bytes.
    pub size_bytes: u64,
}

/// Run `swarm` in real time `pairs` times without and with a recording, `watch_s` seconds each; then once for `size_s`
/// seconds of virtual time over the wire.
///
/// # Errors
/// If a link cannot be opened, or nothing can be recorded in the system's folder for temporary files.
pub async fn record(swarm: &Swarm, (pairs, watch_s): (u32, f64), size_s: f64) -> anyhow::Result<RecordResult> {
    let conditions = Conditions::now();
    let folder = std::env::temp_dir().join(format!("drover-bench-record-{}", std::process::id()));
    std::fs::create_dir_all(&folder).with_context(|| format!("cannot make {}", folder.display()))?;
    let mut swarm = swarm.clone();
    swarm.record_dir = folder.display().to_string();
    let (mut without, mut with) = (Vec::new(), Vec::new());
    for _ in 0..pairs {
        without.push(drive_for(&swarm, watch_s, false).await?);
        with.push(drive_for(&swarm, watch_s, true).await?);
    }
    let mut costs: Vec<f64> = without.iter().zip(&with).map(|(without, with)| with - without).collect();
    costs.sort_by(f64::total_cmp);
    let size_bytes = size(&swarm, size_s, &folder);
    let removed = std::fs::remove_dir_all(&folder);
    let result = RecordResult {
        conditions,
        robots: swarm.robots.len(),
        watched_s: watch_s,
        cores_without: without,
        cores_with: with,
        cores_cost: costs.get(costs.len() / 2).copied().unwrap_or(f64::NAN),
        size_s,
        size_bytes: size_bytes?,
    };
    removed.with_context(|| format!("cannot remove {}", folder.display()))?;
    Ok(result)
}

fn size(swarm: &Swarm, size_s: f64, folder: &std::path::Path) -> anyhow::Result<u64> {
    let mut swarm = swarm.clone();
    swarm.duration_s = size_s;
    let batch = Batch {
        swarm: swarm.name.clone(),
        seeds: vec![swarm.seed],
        fidelity: Fidelity::Wire,
        record_to: Some(folder.to_owned()),
        load: |_| Ok(swarm.clone()),
        on_progress: |_| {},
    };
    batch.run(&AtomicBool::new(false))?;
    let file = folder.join(format!("seed-{}", swarm.seed)).join("run.mcap");
    Ok(std::fs::metadata(&file).with_context(|| format!("no recording at {}", file.display()))?.len())
}

impl fmt::Display for RecordResult {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let shares =
            |cores: &[f64]| cores.iter().map(|cores| format!("{:.1}", cores * 100.0)).collect::<Vec<_>>().join(", ");
        writeln!(f, "record: {} robots and their simulator in one process; {}", self.robots, self.conditions)?;
        writeln!(
            f,
            "  without recording   {} % of a core ({:.0} s each)",
            shares(&self.cores_without),
            self.watched_s
        )?;
        writeln!(f, "  with recording      {} % of a core", shares(&self.cores_with))?;
        writeln!(f, "  cost, median        {:.1} % of a core", self.cores_cost * 100.0)?;
        write!(
            f,
            "  size                {:.1} MB for {:.0} s of virtual time",
            self.size_bytes as f64 / 1e6,
            self.size_s
        )
    }
}
