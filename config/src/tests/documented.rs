//! docs/configuration.md and the reader must agree: every key, its range and its default.

use super::shipped;
use crate::report::{KeyDoc, Report};
use crate::{Override, include, load};
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

/// Keys by section of the page.
type Keys = BTreeMap<(&'static str, String), KeyDoc>;

const KIND: &str = "Robot kind";
const WORLD: &str = "World";
const SWARM: &str = "Swarm";
const ROBOT_FILE: &str = "Robot file";

#[test]
fn every_key_that_is_read_is_documented_with_its_range_and_default() {
    let rows = documented();
    let mut wrong = Vec::new();
    for ((section, key), doc) in accepted() {
        let default = doc.default.unwrap_or_else(|| "required".to_owned());
        let expected = format!("{} | {default}", doc.allowed);
        match rows.get(&(section.to_owned(), key.clone())) {
            Some(found) if *found == expected => {}
            Some(found) => wrong.push(format!("{section}: `{key}` says '{found}', not '{expected}'")),
            None => wrong.push(format!("{section}: | `{key}` | {expected} | is missing")),
        }
    }
    assert!(wrong.is_empty(), "docs/configuration.md:\n{}", wrong.join("\n"));
}

#[test]
fn every_documented_key_is_read() {
    let known: BTreeSet<(String, String)> =
        accepted().into_keys().map(|(section, key)| (section.to_owned(), key)).collect();
    let stale: Vec<_> = documented().into_keys().filter(|row| !known.contains(row)).collect();
    assert!(stale.is_empty(), "docs/configuration.md has rows that nobody reads: {stale:?}");
}

/// Section and key -> "allowed | default", from the page's tables.
fn documented() -> BTreeMap<(String, String), String> {
    let page = std::fs::read_to_string(shipped("../docs/configuration.md")).expect("the page is part of the project");
    let mut rows = BTreeMap::new();
    let mut section = String::new();
    for line in page.lines() {
        if let Some(title) = line.strip_prefix("## ") {
            section = title.to_owned();
        }
        let cells: Vec<&str> = line.split(" | ").map(|cell| cell.trim_matches(['|', ' '])).collect();
        if let [key, allowed, default, _meaning] = cells.as_slice()
            && let Some(key) = key.strip_prefix('`').and_then(|key| key.strip_suffix('`'))
        {
            rows.insert((section.clone(), key.to_owned()), format!("{allowed} | {default}"));
        }
    }
    rows
}

/// Every key that the shipped files make the reader ask for. What stands inside of another file's sort is listed there.
fn accepted() -> Keys {
    let mut keys = Keys::new();
    for kind in ["robots/rover_mavlink.toml", "robots/scout_mini.toml"] {
        let mut report = Report::default();
        assert!(read(&mut report, &shipped(kind), &[], load::read_kind).is_some());
        keep(&mut keys, KIND, &report, &[]);
    }
    let mut report = Report::default();
    assert!(read(&mut report, &shipped("worlds/room.toml"), &[], load::read_world).is_some());
    keep(&mut keys, WORLD, &report, &[]);
    let mut report = Report::default();
    assert!(read(&mut report, &shipped("worlds/cafe.toml"), &[], load::read_world).is_some());
    keep(&mut keys, WORLD, &report, &[]);
    for path in super::generated::worlds() {
        let mut report = Report::default();
        assert!(read(&mut report, &path, &[], load::read_world).is_some());
        keep(&mut keys, WORLD, &report, &[]);
    }
    let path = shipped("swarms/first.toml");
    let mut report = Report::default();
    let swarm = read(&mut report, &path, &[], load::read_swarm).expect("shipped");
    let tighter = ["motion.margin_m=0.5", "timeouts.scan_ms=250"].map(|set| Override::parse(set).expect("a key"));
    assert!(read(&mut report, &path, &tighter, load::read_swarm).is_some());
    // Whatever may be left out altogether, and the other behaviour.
    let more = [
        "fleet=[{ kind = \"scout_mini\", count = 1, first_id = 6 }]",
        "radio.burst={ enter_per_s = 1, leave_per_s = 1 }",
        "radio.propagation={ half_range_m = 50 }",
        "radio.airtime={}",
        "radio.partitions=[{ from_s = 1, until_s = 2, ids = [1] }]",
        "behaviour={ kind = \"diffuse\" }",
    ];
    let more = more.map(|set| Override::parse(set).expect("a key"));
    assert!(read(&mut report, &path, &more, load::read_swarm).is_some());
    // Another report: keys that two behaviours share stand on the page once.
    let mut deploy = Report::default();
    assert!(read(&mut deploy, &shipped("swarms/deploy_exp1.toml"), &[], load::read_swarm).is_some());
    keep(&mut keys, SWARM, &deploy, &["kinds.NAME.", "world."]);
    let mut world = Report::default();
    let room = Override::parse("polylines=[{ points_m = [[1, 1], [2, 1]] }]").expect("a key");
    assert!(read(&mut world, &shipped("worlds/room.toml"), &[room], load::read_world).is_some());
    keep(&mut keys, WORLD, &world, &[]);
    keep(&mut keys, SWARM, &report, &["kinds.NAME.", "world."]);
    keep_robot_file(&mut keys, &swarm);
    keys
}

fn keep_robot_file(keys: &mut Keys, swarm: &crate::Swarm) {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("robot.toml");
    let file = swarm.robot_file(3).expect("shipped");
    std::fs::write(&path, file.to_toml()).expect("written");
    let mut report = Report::default();
    assert!(read(&mut report, &path, &[], load::read_robot_file).is_some());
    keep(keys, ROBOT_FILE, &report, &["kind.", "behaviour.", "beacon.", "robot."]);
}

/// Reads the file at `path` as one sort of file.
fn read<T>(report: &mut Report, path: &Path, set: &[Override], read: load::Read<T>) -> Option<T> {
    include::read_root(report, path).and_then(|root| read(report, root, set))
}

/// Keeps the keys of `report`, but for those under `elsewhere`, which another section lists.
fn keep(keys: &mut Keys, section: &'static str, report: &Report, elsewhere: &[&str]) {
    for (shape, doc) in report.accepted() {
        let is_file = shape == "kinds.NAME.file" || shape == "world.file";
        if is_file || !elsewhere.iter().any(|prefix| shape.starts_with(prefix)) {
            keys.insert((section, shape.clone()), doc.clone());
        }
    }
}
