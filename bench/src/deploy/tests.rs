//! The rows and scenes are sound, and a small run says the same twice.

use super::rows::{self, Contender};
use super::scenes::{USUAL, deploys};
use super::{DeployPlan, deploy_ways, scene_rows};
use crate::contest::{Asked, Plan};
use drover_config::Escape;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../config/swarms")
}

fn plan(quick: bool) -> DeployPlan {
    DeployPlan(Plan::within(&folder(), &USUAL, Asked { quick, ..Asked::default() }).unwrap())
}

#[test]
fn no_two_rows_have_the_same_name() {
    let rows = rows::of(false);
    let names: BTreeSet<&str> = rows.iter().map(|row| row.name).collect();
    assert_eq!(names.len(), rows.len());
    assert_eq!(rows.len(), 28);
    assert_eq!(rows::of(true).iter().map(|row| row.name).collect::<Vec<_>>(), ["literal", "safe", "cbf"]);
}

#[test]
fn the_overrides_of_every_row_load_on_every_scene() {
    let plan = plan(false);
    assert_eq!((plan.0.scenes.len(), plan.runs()), (6, 6 * 28 * 20));
    let pockets = plan.0.named("deploy_pockets").unwrap().load(&[], 0).unwrap();
    assert_eq!(deploys(&pockets).unwrap().escape, Escape::None, "one row alone knows the map");
    for scene in &plan.0.scenes {
        let shipped = scene.load(&[], 0).unwrap();
        for row in rows::of(false) {
            let Contender::Ours(set) = row.contender else { continue };
            let swarm = scene.load(set, 0).unwrap_or_else(|error| panic!("{}: {error:#}", row.name));
            assert_eq!(swarm.robots, shipped.robots, "{} starts elsewhere", row.name);
            let differs = deploys(&swarm).unwrap() != deploys(&shipped).unwrap();
            assert_eq!(differs, !set.is_empty(), "{} is not what ships", row.name);
        }
    }
}

#[test]
fn a_missing_file_is_named_with_what_to_do() {
    let asked = Asked { quick: true, ..Asked::default() };
    let error = Plan::within(Path::new("nowhere"), &USUAL, asked).unwrap_err().to_string();
    assert!(error.contains("nowhere/deploy_exp1.toml") && error.contains("--swarm"), "{error}");
}

#[test]
fn a_small_run_gives_finite_numbers_the_same_on_one_thread() {
    let plan = plan(true);
    let rows = rows::of(true);
    let all = || scene_rows(&plan.0, &rows, &|| {}).unwrap();
    let alone = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    let scenes = all();
    assert_eq!(scenes, alone.install(all));
    assert_eq!((scenes.len(), scenes[0].rows.len()), (1, 3));
    for row in &scenes[0].rows {
        assert_eq!(row.runs.len(), 2);
        for run in &row.runs {
            let numbers = [run.arrived_fraction, run.time_s, run.bound_s, run.path_m_mean];
            let gaps_m = [run.min_gap_robot_m, run.min_gap_wall_m, run.lambda2_min];
            let all = numbers.into_iter().chain(gaps_m.map(|value| value.unwrap_or(f64::NAN)));
            assert!(all.into_iter().all(f64::is_finite), "{}: {run:?}", row.row);
            assert!(run.time_s + 1.0 >= run.bound_s || !run.all_arrived, "{}: {run:?}", row.row);
        }
    }
    assert!(scenes[0].to_string().lines().all(|line| line.chars().count() <= 160), "{}", scenes[0]);
}

#[test]
fn ways_begin_at_the_start_and_end_at_the_layout() {
    let all = deploy_ways(&plan(true)).unwrap();
    let names: Vec<&str> = all.iter().map(|ways| ways.name.as_str()).collect();
    let expected = ["figure5_deploy_exp1_literal_all_links", "figure5_deploy_exp1_literal", "figure5_deploy_exp1_safe"];
    assert_eq!(names, expected);
    for ways in &all {
        let (first, last) = (&ways.moments[0], &ways.moments[ways.moments.len() - 1]);
        let start = ways.swarm.robots[0].start;
        assert!(first.0.abs() < 1e-12 && (first.1[0].x_m - start.x_m).abs() < 1e-9);
        assert!(last.0 <= ways.swarm.duration_s + 1e-9 && last.1.len() == 10);
    }
}
