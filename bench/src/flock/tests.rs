//! The rows and scenes are sound, and a small run says the same twice.

use super::rows::{self, OF_PAPER, Row};
use super::scenes::{USUAL, flocks};
use super::{Conditions, FlockPlan, FlockResult, contender, flock_ways, runs, scene_rows};
use crate::contest::{Asked, Plan};
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../config/swarms")
}

fn plan(quick: bool) -> FlockPlan {
    FlockPlan(Plan::within(&folder(), &USUAL, Asked { quick, ..Asked::default() }).unwrap())
}

#[test]
fn no_two_rows_have_the_same_name() {
    let rows = rows::of(OF_PAPER[0], false);
    let names: BTreeSet<&str> = rows.iter().map(|row| row.name).collect();
    assert_eq!((names.len(), rows.len()), (25, 25));
    assert_eq!(rows::of("flock_door", false).len(), 13);
    assert_eq!(rows::of(OF_PAPER[1], true).iter().map(|row| row.name).collect::<Vec<_>>(), ["literal", "safe"]);
    let literal = &rows::of(OF_PAPER[0], true)[0];
    assert_eq!(
        ["flock_u", "flock_t", "flock_door"].map(|name| literal.prototype_on(name)),
        [Some(0.2), Some(0.47), None]
    );
}

#[test]
fn the_overrides_of_every_row_load_on_every_scene_that_it_is_for() {
    let plan = plan(false);
    assert_eq!((plan.0.scenes.len(), plan.runs()), (8, (2 * 25 + 6 * 13 - 1) * 40));
    for scene in &plan.0.scenes {
        let shipped = scene.load(&[], 0).unwrap();
        for row in rows::of(&scene.name(), false) {
            let set = row.overrides();
            let set: Vec<&str> = set.iter().map(String::as_str).collect();
            let swarm = scene.load(&set, 0).unwrap_or_else(|error| panic!("{}: {error:#}", row.name));
            assert_eq!(swarm.robots, shipped.robots, "{} starts elsewhere", row.name);
            let differs = flocks(&swarm).unwrap() != flocks(&shipped).unwrap();
            assert_eq!(differs, !set.is_empty(), "{} is not what ships", row.name);
        }
    }
}

#[test]
fn a_row_that_a_scene_refuses_says_why() {
    let plan = plan(true);
    let scene = &plan.0.scenes[0];
    let row = Row::of_all("safe, links of no length", "guard=full");
    let outcomes = (0..2).map(|seed| runs::run(scene, &row, seed).unwrap()).collect();
    let refused = contender(scene, &row, outcomes);
    assert_eq!((refused.runs.len(), refused.refused.len()), (0, 2));
    let words = refused.to_string();
    assert!(words.contains("refused: behaviour.link_range_m: found 0") && words.len() <= 160, "{words}");
}

#[test]
fn a_small_run_gives_sane_numbers_the_same_on_one_thread() {
    let plan = plan(true);
    let all = || scene_rows(&plan.0, &|| {}).unwrap();
    let alone = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    let scenes = all();
    assert_eq!(scenes, alone.install(all));
    assert_eq!((scenes.len(), scenes[0].rows.len()), (1, 2));
    for row in &scenes[0].rows {
        assert_eq!((row.runs.len(), row.refused.len()), (2, 0));
        for run in &row.runs {
            let figures = &run.figures;
            assert!((0.0..=1.0).contains(&figures.order) && figures.lost <= 4, "{}: {run:?}", row.row);
            assert_eq!((figures.success, figures.gathered_s.is_some()), (figures.lost == 0, figures.lost == 0));
            assert!(run.wall_entries_max <= figures.wall_entries && run.path_m_mean > 0.0, "{}: {run:?}", row.row);
            let numbers = [Some(figures.cohesion_m), run.min_gap_robot_m, run.min_gap_wall_m];
            assert!(numbers.into_iter().all(|number| number.is_some_and(f64::is_finite)), "{}: {run:?}", row.row);
        }
        let success = row.summary.success.as_ref().unwrap();
        assert!((0.0..=1.0).contains(&success.mean) && success.ci95_low.unwrap() <= success.mean, "{success:?}");
    }
    assert!(scenes[0].to_string().lines().all(|line| line.chars().count() <= 160), "{}", scenes[0]);
}

#[test]
fn ways_begin_at_the_start_and_show_everybody() {
    let plan = plan(true);
    let conditions = Conditions::now();
    let result = FlockResult { conditions, seeds: [0, 2], scenes: Vec::new(), cost: Vec::new() };
    let all = flock_ways(&plan, &result).unwrap();
    let names: Vec<&str> = all.iter().map(|ways| ways.name.as_str()).collect();
    assert_eq!(names, ["figure4_flock_u_literal", "figure4_flock_u_safe"]);
    for ways in &all {
        let (first, last) = (&ways.moments[0], &ways.moments[ways.moments.len() - 1]);
        let start = ways.swarm.robots[0].start;
        assert!(first.0.abs() < 1e-12 && (first.1[0].x_m - start.x_m).abs() < 1e-9);
        assert!(last.0 <= ways.swarm.duration_s + 1e-9 && last.1.len() == 5);
        assert!(ways.shows([start.x_m, start.y_m]) && ways.shows([0.82, 0.17]) && !ways.shows([6.0, 0.1]));
    }
}
