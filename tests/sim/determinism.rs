//! One seed, one run: on every machine, in every build, with any number of threads.

use crate::swarms::{CROWD, EVERYTHING, MAZE, shipped, written};
use drover_config::Swarm;
use drover_swarm::{Batch, BatchResult, Fidelity, TrialResult, run_trial, trial_of};
use std::collections::BTreeMap;
use std::path::Path;
use std::sync::atomic::AtomicBool;

/// What stands at the top of the table of digests.
const TABLE_HEAD: &str = "\
# What bodies did, as one hash a run (drover_swarm's digest: poses, twists and contacts at every step, bit for bit).
# tests/sim/determinism.rs runs each and compares. A digest may change only with a change of the simulation, and the
# commit that changes it says which. The same in debug and release builds, on every machine, with any number of threads.

[digests]
";

fn run(swarm: &Swarm, fidelity: Fidelity) -> TrialResult {
    let mut trial = trial_of(swarm, fidelity, None).expect("links fit their kinds");
    run_trial(swarm, trial.as_mut(), &mut |_: &dyn drover_swarm::Trial| true).expect("nobody ends it")
}

/// The runs of the table: name, swarm, what is simulated.
fn golden_runs() -> Vec<(&'static str, Swarm, Fidelity)> {
    let first = |set: &[&str]| shipped("swarms/first.toml", set);
    vec![
        ("first, direct, seed 1", first(&["seed=1"]), Fidelity::Direct),
        ("first, direct, seed 2", first(&["seed=2"]), Fidelity::Direct),
        ("first, direct, seed 3", first(&["seed=3"]), Fidelity::Direct),
        ("first, wire, seed 1", first(&["seed=1"]), Fidelity::Wire),
        ("diffuse_1000, direct, seed 1, 2 s", shipped("swarms/diffuse_1000.toml", &["duration_s=2"]), Fidelity::Direct),
        ("cafe, direct, seed 1, 30 s", shipped("swarms/cafe.toml", &["duration_s=30"]), Fidelity::Direct),
        ("maze, direct, seed 5", written(MAZE, &[]), Fidelity::Direct),
        ("everything, direct, seed 3", written(EVERYTHING, &[]), Fidelity::Direct),
        ("everything, wire, seed 3, 8 s", written(EVERYTHING, &["duration_s=8"]), Fidelity::Wire),
    ]
}

#[test]
fn every_golden_run_has_its_golden_digest() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/golden/digests.toml");
    let text = std::fs::read_to_string(&path).expect("the table of digests");
    let table: toml::Table = text.parse().expect("a table");
    let runs: Vec<(&str, String)> =
        golden_runs().iter().map(|(name, swarm, fidelity)| (*name, run(swarm, *fidelity).digest)).collect();
    let golden = table["digests"].as_table().expect("a table");
    let is_golden = |(name, digest): &(&str, String)| golden.get(*name).and_then(toml::Value::as_str) == Some(digest);
    let same = golden.len() == runs.len() && runs.iter().all(is_golden);
    let rows: String = runs.iter().map(|(name, digest)| format!("{name:?} = {digest:?}\n")).collect();
    assert!(
        same,
        "the digests are not those of {}. A digest may change only with a change of the simulation, which the commit \
         explains. If this is one, the table is now:\n\n{TABLE_HEAD}{rows}",
        path.display()
    );
    assert!(text.starts_with(TABLE_HEAD), "{} begins otherwise than the test would print it", path.display());
}

#[test]
fn no_two_golden_runs_are_the_same_run() {
    let mut digests: Vec<String> = [1, 2, 3].map(|seed| first_for(seed, "duration_s=5", Fidelity::Direct)).into();
    digests.push(first_for(1, "duration_s=6", Fidelity::Direct));
    digests.push(first_for(1, "duration_s=5", Fidelity::Wire));
    digests.push(first_for(1, "behaviour.leader_speed_mps=0.59", Fidelity::Direct));
    let of_names: BTreeMap<&String, ()> = digests.iter().map(|digest| (digest, ())).collect();
    assert_eq!(of_names.len(), digests.len(), "a digest that anything leaves as it is proves nothing: {digests:?}");
}

fn first_for(seed: u64, set: &str, fidelity: Fidelity) -> String {
    let duration = if set.starts_with("duration_s") { set } else { "duration_s=5" };
    run(&shipped("swarms/first.toml", &[&format!("seed={seed}"), duration, set]), fidelity).digest
}

/// A batch of `swarm` over `seeds` in a pool of `threads`, as the bytes that a user gets.
fn batch_bytes(text: &'static str, seeds: &[u64], threads: usize) -> String {
    let batch = Batch {
        swarm: "batch".into(),
        seeds: seeds.to_vec(),
        fidelity: Fidelity::Direct,
        record_to: None,
        load: |seed| Ok(written(text, &[&format!("seed={seed}"), "duration_s=1"])),
        on_progress: |_| {},
    };
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
    let result: BatchResult = pool.install(|| batch.run(&AtomicBool::new(false))).expect("a good batch");
    serde_json::to_string(&result).expect("only strings and finite numbers")
}

#[test]
fn the_number_of_threads_within_one_run_changes_no_byte_of_the_result() {
    let alone = batch_bytes(CROWD, &[1], 1);
    assert!(alone.contains("\"robots\":400"), "{alone}");
    for threads in [2, 3] {
        assert_eq!(alone, batch_bytes(CROWD, &[1], threads), "{threads} threads");
    }
}

#[test]
fn the_number_of_threads_over_a_batch_changes_no_byte_of_the_result() {
    let seeds = [3, 1, 4, 15, 9, 2];
    let alone = batch_bytes(EVERYTHING, &seeds, 1);
    for threads in [2, 3, 3] {
        assert_eq!(alone, batch_bytes(EVERYTHING, &seeds, threads), "{threads} threads");
    }
}
