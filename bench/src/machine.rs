//! Under which conditions something was measured, and what this process used.

use serde::Serialize;
use std::fmt;

/// The machine and the build.
#[derive(Clone, Debug, Serialize)]
pub struct Conditions {
    /// Logical processors that this process may use.
    pub cores: usize,
    /// Whether this is an optimised build.
    pub release: bool,
    /// The load average over the last minute when the bench began.
    pub load_1min: Option<f64>,
}

impl Conditions {
    /// Those of this moment.
    #[must_use]
    pub fn now() -> Self {
        let load = std::fs::read_to_string("/proc/loadavg").ok();
        Self {
            cores: std::thread::available_parallelism().map_or(1, std::num::NonZero::get),
            release: !cfg!(debug_assertions),
            load_1min: load.and_then(|text| text.split(' ').next()?.parse().ok()),
        }
    }
}

impl fmt::Display for Conditions {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let build = if self.release { "release build" } else { "DEBUG build: figures mean nothing" };
        let load = self.load_1min.map_or_else(String::new, |load| format!(", load {load:.2} at the start"));
        write!(f, "{} cores, {build}{load}", self.cores)
    }
}

/// What this process has used so far (Linux: /proc/self).
#[derive(Clone, Copy, Debug, Serialize)]
pub struct ProcessUse {
    /// Processor time of all threads, s.
    pub cpu_s: f64,
    /// Resident memory, MiB.
    pub resident_mib: f64,
}

impl ProcessUse {
    /// As of now.
    ///
    /// # Errors
    /// If /proc is not there or says what it never said before.
    pub fn now() -> anyhow::Result<Self> {
        /// Linux counts processor time in hundredths of a second for user space, on every architecture.
        const TICKS_PER_S: f64 = 100.0;
        const PAGE_KIB: f64 = 4.0;
        let stat = std::fs::read_to_string("/proc/self/stat")?;
        // The command's name stands in parentheses and may hold spaces: fields are counted behind it.
        let fields: Vec<&str> = stat.rsplit(')').next().unwrap_or_default().split_whitespace().collect();
        let field = |index: usize| -> anyhow::Result<f64> {
            Ok(fields.get(index).ok_or_else(|| anyhow::anyhow!("/proc/self/stat is short"))?.parse()?)
        };
        let statm = std::fs::read_to_string("/proc/self/statm")?;
        let pages = statm.split(' ').nth(1).ok_or_else(|| anyhow::anyhow!("/proc/self/statm is short"))?;
        Ok(Self {
            cpu_s: (field(11)? + field(12)?) / TICKS_PER_S,
            resident_mib: pages.parse::<f64>()? * PAGE_KIB / 1024.0,
        })
    }
}
