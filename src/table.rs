//! A batch of runs as a table for people; programs read `--json`.

use drover_swarm::{BatchResult, Spread, TrialResult};

/// Runs that are listed one by one; of more only the summary is printed.
const RUNS_LISTED: usize = 20;

/// Print what a batch says.
pub(crate) fn print_batch(result: &BatchResult) {
    let robots = result.runs.first().map_or(0, |run| run.robots);
    let cut = if result.interrupted { "; interrupted, the others are left out" } else { "" };
    println!(
        "{}: {} runs of {robots} robots, fidelity {:?}{}\n",
        result.swarm,
        result.runs.len(),
        result.fidelity,
        cut
    );
    if result.runs.len() <= RUNS_LISTED {
        println!("{:>20}  {:>7}  {:>9}  {:>9}  {:>9}  digest", "seed", "reached", "time s", "robot m", "wall m");
        result.runs.iter().for_each(print_run);
        println!();
    }
    let title = "median    quartiles                  worst        mean, 95 % confidence";
    println!("{:>18}  {:>5}  {title}", "", "n");
    result.summary.iter().for_each(|(name, spread)| print_spread(name, spread));
    if let Some(bytes) = result.summary.get("bytes_per_robot") {
        println!("\nmemory: {:.0} KiB of heap a robot at most, the place itself apart", bytes.worst / 1024.0);
    }
}

fn print_run(run: &TrialResult) {
    let gap = |gap_m: Option<f64>| gap_m.map_or_else(|| "-".into(), |gap_m| format!("{gap_m:.3}"));
    println!(
        "{:>20}  {:>7}  {:>9.2}  {:>9}  {:>9}  {}",
        run.seed,
        if run.reached { "yes" } else { "NO" },
        run.time_s,
        gap(run.min_gap_robot_m),
        gap(run.min_gap_wall_m),
        run.digest
    );
}

fn print_spread(name: &str, spread: &Spread) {
    let Spread { n, median, q1, q3, worst, mean, ci95_low, ci95_high } = spread;
    let interval = match (ci95_low, ci95_high) {
        (Some(low), Some(high)) => format!("{} .. {}", short(*low), short(*high)),
        _ => "-".into(),
    };
    let (median, q1, q3) = (short(*median), short(*q1), short(*q3));
    println!("{name:>18}  {n:>5}  {median:<9} {q1:>9} .. {q3:<13} {:<12} {}, {interval}", short(*worst), short(*mean));
}

/// A number with as many digits as one reads.
fn short(value: f64) -> String {
    match value.abs() {
        size if size >= 1e4 => format!("{value:.0}"),
        size if size >= 100.0 => format!("{value:.1}"),
        _ => format!("{value:.3}"),
    }
}
