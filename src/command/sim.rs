//! `drover sim SWARM.toml`: headless, in virtual time, as fast as it goes; one run or a batch over seeds.

use crate::command::{asked_to_end, overrides, refuse};
use crate::exit::Exit;
use crate::meter;
use crate::table::print_batch;
use anyhow::anyhow;
use drover_config::{Override, Problems, Swarm, load_swarm};
use drover_swarm::{Batch, BatchResult, Fidelity, Progress};
use indicatif::ProgressBar;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};
use std::time::{Instant, SystemTime, UNIX_EPOCH};

/// Most runs of one batch.
const RUNS_MAX: u64 = 1_000_000;

/// Arguments of `drover sim`.
#[derive(clap::Args)]
pub(crate) struct Arguments {
    /// The swarm's file
    file: PathBuf,
    /// Seeds: `A..B` (without B), `A..=B`, or one; the file's own unless given
    #[arg(long, value_name = "A..B", value_parser = seeds)]
    seeds: Option<Seeds>,
    /// direct: laws and supervisors on values; wire: every byte through the codecs and the virtual firmware
    #[arg(long, value_enum, default_value_t = Level::Direct)]
    fidelity: Level,
    /// Print one JSON document on stdout; everything else goes to stderr
    #[arg(long)]
    json: bool,
    /// End each run after this long, s of simulated time, if not everything was reached before
    #[arg(long, value_name = "S")]
    duration: Option<f64>,
    /// Set any configuration key, for example behaviour.leader_speed_mps=0.5
    #[arg(long, value_name = "KEY=VALUE")]
    set: Vec<String>,
    /// Record every run under the swarm's record_dir: everybody's way, the result, with wire the links' bytes too
    #[arg(long)]
    record: bool,
    /// Threads; as many as there are cores unless given. No result depends on it
    #[arg(long, value_name = "N")]
    threads: Option<usize>,
}

/// How much is simulated.
#[derive(Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
enum Level {
    /// Laws and supervisors on values
    Direct,
    /// Every byte
    Wire,
}

/// A range of seeds: first, and one past the last.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Seeds {
    first: u64,
    count: u64,
}

pub(crate) fn execute(arguments: &Arguments) -> Exit {
    let set = match settings(arguments) {
        Ok(set) => set,
        Err(exit) => return exit,
    };
    // What is wrong whatever the seed is said once, before anything runs.
    let swarm = match load_swarm(&arguments.file, &set) {
        Ok(swarm) => swarm,
        Err(problems) => return refuse(&problems),
    };
    match run(arguments, &set, &swarm) {
        Ok(result) => {
            if arguments.json {
                // Only strings and finite numbers: this cannot fail to print.
                println!("{}", serde_json::to_string_pretty(&result).unwrap_or_default());
            } else {
                print_batch(&result);
            }
            conclude(&result)
        }
        Err(error) => {
            eprintln!("{error:#}");
            if error.is::<Problems>() { Exit::BadInput } else { Exit::CannotStart }
        }
    }
}

fn settings(arguments: &Arguments) -> Result<Vec<Override>, Exit> {
    let mut set = overrides(&arguments.set)?;
    let duration: Vec<String> =
        arguments.duration.iter().map(|duration_s| format!("duration_s={duration_s:?}")).collect();
    set.extend(overrides(&duration)?);
    Ok(set)
}

fn run(arguments: &Arguments, set: &[Override], swarm: &Swarm) -> anyhow::Result<BatchResult> {
    let seeds = arguments.seeds.unwrap_or(Seeds { first: swarm.seed, count: 1 });
    let seeds: Vec<u64> = (0..seeds.count).map(|n| seeds.first.wrapping_add(n)).collect();
    let meter = Meter::new(seeds.len(), swarm.duration_s);
    let batch = Batch {
        swarm: swarm.name.clone(),
        fidelity: match arguments.fidelity {
            Level::Direct => Fidelity::Direct,
            Level::Wire => Fidelity::Wire,
        },
        record_to: arguments.record.then(|| folder(swarm)),
        load: |seed| with_seed(&arguments.file, set, seed),
        on_progress: |progress| meter.add(progress),
        seeds,
    };
    let threads = rayon::ThreadPoolBuilder::new().num_threads(arguments.threads.unwrap_or(0)).build()?;
    let end = Arc::new(AtomicBool::new(false));
    end_when_asked(&end)?;
    let result = threads.install(|| batch.run(&end));
    meter.end();
    if let (Ok(_), Some(folder)) = (&result, &batch.record_to) {
        eprintln!("recorded to {}", folder.display());
    }
    result
}

/// Ctrl-C and SIGTERM end the batch in good order: what has come to its end by then is printed.
fn end_when_asked(end: &Arc<AtomicBool>) -> anyhow::Result<()> {
    let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build()?;
    let end = Arc::clone(end);
    // The thread waits until the process ends.
    std::thread::spawn(move || {
        runtime.block_on(asked_to_end());
        end.store(true, Ordering::Relaxed);
    });
    Ok(())
}

/// The swarm with another seed: read anew, since generated worlds and random places follow from it.
fn with_seed(file: &Path, set: &[Override], seed: u64) -> anyhow::Result<Swarm> {
    let own = Override::parse(&format!("seed={seed}")).map_err(|problem| anyhow!("{problem}"))?;
    let set: Vec<Override> = set.iter().cloned().chain([own]).collect();
    load_swarm(file, &set).map_err(|problems| anyhow::Error::new(problems).context(format!("seed {seed}")))
}

fn folder(swarm: &Swarm) -> PathBuf {
    let unix = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
    Path::new(&swarm.record_dir).join(format!("{}-sim-{}", swarm.name, unix.as_millis()))
}

fn conclude(result: &BatchResult) -> Exit {
    if result.runs.iter().any(|run| run.touched > 0 || run.aged_commands > 0) {
        Exit::Unsafe
    } else if result.interrupted {
        Exit::Interrupted
    } else if result.runs.iter().all(|run| run.reached) {
        Exit::Reached
    } else {
        Exit::NotReached
    }
}

fn seeds(text: &str) -> Result<Seeds, String> {
    let number = |text: &str| {
        text.trim().parse::<u64>().map_err(|_| format!("{text:?} is no whole number from 0 to {}", u64::MAX))
    };
    let (first, count) = match text.split_once("..") {
        None => (number(text)?, 1),
        Some((first, last)) => {
            let first = number(first)?;
            let end = match last.strip_prefix('=') {
                Some(last) => number(last)?.saturating_add(1),
                None => number(last)?,
            };
            (first, end.saturating_sub(first))
        }
    };
    match count {
        0 => Err("no seed lies in it: write A..B with B greater than A".into()),
        1..=RUNS_MAX => Ok(Seeds { first, count }),
        _ => Err(format!("{count} runs; at most {RUNS_MAX} in one batch")),
    }
}

/// Progress on a terminal, nothing in a pipe; at the end a line with the rate.
struct Meter {
    bar: ProgressBar,
    runs: usize,
    so_far: Mutex<Progress>,
    begun: Instant,
}

impl Meter {
    fn new(runs: usize, duration_s: f64) -> Self {
        let milliseconds = duration_s * 1e3 * runs as f64;
        let bar = meter::bar(milliseconds as u64);
        Self { bar, runs, so_far: Mutex::default(), begun: Instant::now() }
    }

    fn add(&self, progress: Progress) {
        self.bar.inc((progress.simulated_s * 1e3) as u64);
        let Ok(mut so_far) = self.so_far.lock() else { return };
        so_far.runs += progress.runs;
        so_far.robot_steps += progress.robot_steps;
        so_far.simulated_s += progress.simulated_s;
        self.bar.set_message(format!("{} of {} runs  {}", so_far.runs, self.runs, self.rate(&so_far)));
    }

    fn rate(&self, so_far: &Progress) -> String {
        let wall_s = self.begun.elapsed().as_secs_f64().max(1e-9);
        format!("{:.3} million robot-steps/s", so_far.robot_steps as f64 / wall_s / 1e6)
    }

    fn end(&self) {
        self.bar.finish_and_clear();
        if let Ok(so_far) = self.so_far.lock() {
            let wall_s = self.begun.elapsed().as_secs_f64();
            eprintln!("{} runs in {wall_s:.1} s: {}", so_far.runs, self.rate(&so_far));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn seeds_are_ranges_or_one() {
        assert_eq!(seeds("7"), Ok(Seeds { first: 7, count: 1 }));
        assert_eq!(seeds("0..40"), Ok(Seeds { first: 0, count: 40 }));
        assert_eq!(seeds("3..=5"), Ok(Seeds { first: 3, count: 3 }));
        for wrong in ["", "5..5", "5..2", "a..b", "1..", "..4", "-1..3", "0..99999999999"] {
            assert!(seeds(wrong).is_err(), "{wrong}");
        }
    }
}
