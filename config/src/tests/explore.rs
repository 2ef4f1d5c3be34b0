//! Exploration: what the defaults are, that every key can be set, and what cannot be.

use super::good;
use crate::{Behaviour, Explore, ExploreMethod, Finish, Override, Problem, Problems, Swarm, load_swarm};

const POINTS: [&str; 2] = ["kinds.rover_mavlink.sim.motion=point", "kinds.scout_mini.sim.motion=point"];
const BARE: &str = "behaviour={ kind = \"explore\" }";

fn load(changes: &[&str]) -> Result<Swarm, Problems> {
    let sets: Vec<Override> = changes.iter().map(|set| Override::parse(set).expect("a key and a value")).collect();
    load_swarm(&good("swarms/first.toml"), &sets)
}

fn explore(changes: &[&str]) -> Explore {
    let all = [&POINTS, &[BARE][..], changes].concat();
    let swarm = load(&all).unwrap_or_else(|problems| panic!("{changes:?}: {problems}"));
    let Behaviour::Explore(explore) = swarm.behaviour else { panic!("an exploration") };
    explore
}

/// What is said, and of what, when these changes are made.
fn said(changes: &[&str]) -> (String, String) {
    let problems = load(&[&[BARE][..], changes].concat()).expect_err("refused");
    let Problem { key, found, expected, .. } = problems.iter().next().expect("a problem");
    (key.clone(), format!("{found}; {expected}"))
}

#[test]
fn the_defaults_are_the_paper_s_and_the_method_is_ours() {
    assert_eq!(explore(&[]), Explore::usual(ExploreMethod::Sweep));
    let changed = explore(&["behaviour.method=min_pos", "behaviour.finish=whole", "behaviour.global_steps=7"]);
    let expected = Explore { finish: Finish::Whole, global_steps: 7, ..Explore::usual(ExploreMethod::MinPos) };
    assert_eq!(changed, expected);
}

#[test]
fn every_method_has_a_word() {
    for (word, method) in crate::read::explore::METHODS {
        assert_eq!(explore(&[&format!("behaviour.method={word}")]).method, method, "{word}");
    }
}

#[test]
fn what_cannot_be_is_refused() {
    let (key, words) = said(&[]);
    assert_eq!(key, "behaviour.cell_m");
    assert!(words.starts_with("1; at most the radius of the smallest body, 0.3"), "{words}");
    let of_points = |change| said(&[&POINTS[..], &[change]].concat());
    let (key, words) = of_points("behaviour.far_cells=4");
    assert_eq!((key.as_str(), words.as_str()), ("behaviour.far_cells", "4; more than near_cells, 4"));
    let (key, words) = of_points("behaviour.cell_m=0.02");
    assert!(
        key == "behaviour.cell_m" && words.contains("840000 cells of 24 m x 14 m; at most 250000"),
        "{key}: {words}"
    );
    let (key, words) = of_points("behaviour.area_m=[[6, 0], [24, 14]]");
    assert!(
        key.ends_with(".start") && words.contains("within behaviour.area_m, [[6.0, 0.0], [24.0, 14.0]]"),
        "{key}: {words}"
    );
    let (key, _) = of_points("behaviour.method=best");
    assert_eq!(key, "behaviour.method");
    let (key, words) = of_points("world={ name = \"open\" }");
    assert!(key == "behaviour.kind" && words.contains("without an enclosure"), "{key}: {words}");
}

#[test]
fn a_robot_s_own_file_says_what_is_to_be_mapped() {
    let swarm = load(&[BARE, "behaviour.cell_m=0.2"]).unwrap_or_else(|problems| panic!("{problems}"));
    let Behaviour::Explore(explore) = &swarm.behaviour else { panic!("an exploration") };
    assert_eq!(explore.area_m, None, "the world says it");
    let file = swarm.robot_file(3).expect("its robot");
    let Behaviour::Explore(explore) = &file.behaviour else { panic!("an exploration") };
    assert_eq!(explore.area_m, Some([[0.0, 0.0], [24.0, 14.0]]));
    let mut text = file.to_toml();
    let path = std::env::temp_dir().join(format!("drover-explore-{}.toml", std::process::id()));
    std::fs::write(&path, &text).expect("a folder for such files");
    assert_eq!(crate::load_robot(&path, &[]).unwrap_or_else(|problems| panic!("{problems}")), file);
    text = text.lines().filter(|line| !line.starts_with("area_m")).collect::<Vec<_>>().join("\n");
    std::fs::write(&path, text).expect("the same folder");
    let problems = crate::load_robot(&path, &[]).expect_err("no area");
    let _ = std::fs::remove_file(&path);
    assert_eq!(problems.iter().next().map(|problem| problem.key.clone()).as_deref(), Some("behaviour.area_m"));
}
