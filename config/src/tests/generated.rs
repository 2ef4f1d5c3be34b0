//! Generated worlds, as files.

use super::{good, shipped};
use crate::{Checked, Override, Swarm, World, check_file, load_swarm, load_world};
use std::path::{Path, PathBuf};

/// A maze in which the good swarm's robots would not find a place; the lines are counted from 1.
const MAZE: &str = "name = \"m\"\n[generate]\nkind = \"maze\"\nwidth_m = 20.0\nheight_m = 20.0\n";

/// The shipped generated worlds: one of every kind.
pub(super) fn worlds() -> Vec<PathBuf> {
    let entries = std::fs::read_dir(shipped("worlds/generated")).expect("the folder is shipped");
    entries.map(|entry| entry.expect("a readable folder").path()).collect()
}

/// What is wrong with a world file of that text.
fn wrong(text: &str) -> String {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("world.toml");
    std::fs::write(&path, text).expect("written");
    load_world(&path).map_or_else(|problems| problems.to_string(), |world| format!("it loads: {}", world.name))
}

/// The good swarm in an open field of a few obstacles far from its starts and its way.
fn in_field(folder: &Path, more: &str) -> Swarm {
    let text = std::fs::read_to_string(good("swarms/first.toml")).expect("good");
    let size = "width_m = 90.0, height_m = 90.0, margin_m = 30.0";
    let field = format!("{{ name = \"f\", generate = {{ kind = \"convex_field\", {size}{more} }} }}");
    let text = text.replace("world = \"../worlds/room.toml\"", &format!("world = {field}"));
    let robots = good("robots").display().to_string();
    let path = folder.join("swarm.toml");
    std::fs::write(&path, text.replace("../robots", &robots)).expect("written");
    let set = Override::parse("seed=5").expect("a key");
    load_swarm(&path, &[set]).unwrap_or_else(|problems| panic!("{problems}"))
}

#[test]
fn every_shipped_generated_world_loads_and_is_named_as_its_kind() {
    assert_eq!(worlds().len(), 13);
    for path in worlds() {
        let world = load_world(&path).unwrap_or_else(|problems| panic!("{problems}"));
        assert_eq!(Some(world.name.as_str()), path.file_stem().and_then(|stem| stem.to_str()));
        assert_eq!(world.polygons.iter().filter(|polygon| polygon.enclosure).count(), 1, "{}", world.name);
        assert_eq!(check_file(&path).ok(), Some(Checked::World(Box::new(world))));
    }
}

#[test]
fn a_generated_world_is_written_as_its_shapes() {
    let folder = tempfile::tempdir().expect("a folder");
    let swarm = in_field(folder.path(), "");
    let path = folder.path().join("resolved.toml");
    let text = swarm.to_toml();
    assert!(!text.contains("generate"));
    std::fs::write(&path, text).expect("written");
    assert_eq!(load_swarm(&path, &[]).map_err(|problems| problems.to_string()), Ok(swarm));
}

#[test]
fn a_large_maze_is_one_outline_that_is_written_and_read_again() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("world.toml");
    let text = MAZE.replace("20.0", "150.0");
    std::fs::write(&path, text).expect("written");
    let world = load_world(&path).unwrap_or_else(|problems| panic!("{problems}"));
    assert!(world.polygons.len() == 1 && world.polygons[0].points_m.len() > 5_000);
    std::fs::write(&path, toml::to_string(&world).expect("text")).expect("written");
    assert_eq!(load_world(&path).map_err(|problems| problems.to_string()), Ok(world));
}

#[test]
fn the_swarm_s_seed_makes_the_world_unless_it_has_its_own() {
    let folder = tempfile::tempdir().expect("a folder");
    let alone = |seed: u64| -> World {
        let own = in_field(folder.path(), &format!(", seed = {seed}"));
        own.world
    };
    assert_eq!(in_field(folder.path(), "").world, alone(5));
    assert_ne!(alone(5), alone(6));
}

#[test]
fn what_cannot_be_made_is_refused_at_its_key() {
    let text = wrong(&format!("{MAZE}passage_m = 30.0\n"));
    assert!(text.contains("world.toml:6:13: key 'generate.passage_m': found 30 m"), "{text}");
    let text = wrong(&format!("{MAZE}turns = 3\n"));
    assert!(text.contains("key 'generate.turns': found an unknown key; allowed: one of kind, width_m"), "{text}");
    let text = wrong(&MAZE.replace("maze", "labyrinth"));
    assert!(text.contains("key 'generate.kind'") && text.contains("\"maze\""), "{text}");
    let text = wrong(&MAZE.replace("maze", "door").replace("20.0\n", "20.0\nseed = 3\n"));
    assert!(text.contains("key 'generate.seed': found an unknown key"), "{text}");
}

#[test]
fn a_generated_world_has_its_own_enclosure() {
    let outer = "[[polygons]]\nenclosure = true\npoints_m = [[0, 0], [9, 0], [9, 9], [0, 9]]\n";
    let text = wrong(&format!("{MAZE}{outer}"));
    assert!(text.contains("key 'generate': found an enclosure beside another one"), "{text}");
    assert!(wrong(&format!("{MAZE}{}", outer.replace("true", "false"))).contains("it loads"));
}
