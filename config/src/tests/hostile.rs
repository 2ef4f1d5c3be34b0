//! Files that somebody made to break a reader: a clear answer, never a panic, never for long.

use super::good;
use crate::{Override, Problems, check_file, load_robot, load_swarm};
use proptest::prelude::*;
use std::path::PathBuf;

/// Words between the signs that TOML gives a meaning.
const TOML_LIKE: &str = "([a-z_]{1,4}( ?[=.] ?|\\[|\\]|\\{|\\}|,|\"|'|#|\n|-?[0-9.e]{1,4}|nan|inf)){0,80}";

fn read(bytes: &[u8]) -> Vec<Problems> {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("hostile.toml");
    std::fs::write(&path, bytes).expect("written");
    let swarm = load_swarm(&path, &[]).err();
    let robot = load_robot(&path, &[]).err();
    let any = check_file(&path).err();
    [swarm, robot, any].into_iter().flatten().collect()
}

/// Whatever is refused is refused with words.
fn refused_with_words(bytes: &[u8]) {
    for problems in read(bytes) {
        assert!(!problems.0.is_empty());
        assert!(problems.0.len() <= 1_000);
        assert!(problems.iter().all(|problem| !problem.expected.is_empty() && !problem.advice.is_empty()));
    }
}

fn good_swarm() -> Vec<u8> {
    let swarm = load_swarm(&good("swarms/first.toml"), &[]).expect("good");
    swarm.to_toml().into_bytes()
}

#[test]
fn deep_nesting_of_every_kind_is_refused() {
    let deep = 100_000;
    let texts = [
        format!("{}a = 1", "a.".repeat(deep)),
        format!("[{}a]\n", "a.".repeat(deep)),
        format!("[[{}a]]\n", "a.".repeat(deep)),
        format!("a = {}", "[".repeat(deep)),
        format!("a = {}{}", "[".repeat(deep), "]".repeat(deep)),
        format!("a = {}", "{a=".repeat(deep)),
        format!("a = {}", "{a.a.a.a=[".repeat(deep / 2)),
        "[a.a.a.a.a.a.a.a]\na.a.a.a.a.a.a.a={a.a.a.a.a.a.a.a.a=[{a.a.a.a.a.a.a=1}]}\n".to_owned(),
    ];
    for text in texts {
        let problems = read(text.as_bytes());
        let said = problems.iter().all(|problems| problems.to_string().contains("deeper nesting"));
        assert!(said && problems.len() == 3, "{}", problems[0]);
    }
}

#[test]
fn a_megabyte_of_anything_is_answered() {
    let patterns: [&[u8]; 12] = [
        b"[[robot]]\n",
        b"[[circles]]\ncentre_m=[0,0]\n",
        b"a",
        b"=\n",
        b"\"",
        b"'''",
        b"[",
        b"]\n",
        b"{",
        b"\n",
        b"\0",
        b"x = 1\n",
    ];
    for pattern in patterns {
        refused_with_words(&pattern.repeat(1_000_000 / pattern.len()));
    }
    let many_keys: String = (0..80_000).map(|index| format!("k{index} = 1\n")).collect();
    refused_with_words(many_keys.as_bytes());
}

#[test]
fn a_hundred_thousand_robots_are_read_and_one_more_is_not() {
    let tail = "[behaviour]\nkind = \"flock\"\nleader = 1000\nwaypoints_m = [[1, 1]]\n";
    let swarm = |count: u32| {
        let robots = (0..count).map(|index| {
            let (x, y) = (index % 300 * 2, index / 300 * 2);
            format!("[[robot]]\nid={}\nkind=\"s\"\nstart={{x_m={x},y_m={y}}}\n", index + 1_000)
        });
        let kind = good("robots/scout_mini.toml");
        let head =
            format!("name=\"n\"\nduration_s=1\nworld={{name=\"w\"}}\nkinds.s={:?}\n", kind.display().to_string());
        head + &robots.collect::<String>() + tail
    };
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("swarm.toml");
    std::fs::write(&path, swarm(100_000)).expect("written");
    let read = load_swarm(&path, &[]).unwrap_or_else(|problems| panic!("{problems}"));
    assert_eq!(read.robots.len(), 100_000);
    std::fs::write(&path, swarm(100_001)).expect("written");
    let Err(problems) = load_swarm(&path, &[]) else { panic!("too many") };
    let problems = problems.to_string();
    let said = "found a list of 100001; allowed: a list of at most 100000 tables";
    assert!(problems.contains(said), "{problems}");
}

#[test]
fn every_truncation_of_a_swarm_is_answered() {
    let text = good_swarm();
    for end in (0..text.len()).step_by(7) {
        refused_with_words(&text[..end]);
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 256, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn arbitrary_bytes_never_panic(bytes in prop::collection::vec(any::<u8>(), 0..2_000)) {
        refused_with_words(&bytes);
    }

    #[test]
    fn arbitrary_toml_like_text_never_panics(text in TOML_LIKE) {
        refused_with_words(text.as_bytes());
    }

    #[test]
    fn a_mutated_swarm_never_panics(
        changes in prop::collection::vec((any::<prop::sample::Index>(), "[\\PC\n]{0,3}", 0_usize..40), 1..6),
    ) {
        let mut text = good_swarm();
        for (at, new, cut) in changes {
            let at = at.index(text.len() + 1);
            let end = (at + cut).min(text.len());
            text.splice(at..end, new.into_bytes());
        }
        refused_with_words(&text);
    }

    #[test]
    fn numbers_of_any_size_survive_the_round_trip(
        seed in any::<u64>(), x_m in -0.5..0.5_f64, yaw_rad in -6.0..6.0_f64, loss in 0.0..=1.0_f64,
    ) {
        let mut swarm = load_swarm(&good("swarms/first.toml"), &[]).expect("good");
        swarm.seed = seed;
        swarm.robots[0].start.x_m += x_m;
        swarm.robots[0].start.yaw_rad = yaw_rad;
        swarm.radio.loss = loss;
        let folder = tempfile::tempdir().expect("a folder");
        let path: PathBuf = folder.path().join("swarm.toml");
        std::fs::write(&path, swarm.to_toml()).expect("written");
        prop_assert_eq!(load_swarm(&path, &[]).map_err(|problems| problems.to_string()), Ok(swarm));
    }

    #[test]
    fn arbitrary_overrides_never_panic(text in "[a-z_]{1,9}(\\.[a-z0-9_]{1,9}|\\[[0-9]{1,3}\\]){0,4}=\\PC{0,40}") {
        if let Ok(set) = Override::parse(&text) {
            let _ = load_swarm(&good("swarms/first.toml"), &[set]).map_err(|problems| problems.to_string());
        }
    }
}
