//! docs/configuration.md and the reader must agree: every key, its range and its default.

use super::shipped;
use crate::report::Report;
use crate::{Override, include, load};
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

/// What is said of keys ("allowed | default"), by section of the page. Behaviours may share a key and differ in that:
/// then it has a row for each of them.
type Keys = BTreeMap<(String, String), BTreeSet<String>>;

const KIND: &str = "Robot kind";
const WORLD: &str = "World";
const SWARM: &str = "Swarm";
const ROBOT_FILE: &str = "Robot file";

#[test]
fn every_key_that_is_read_is_documented_with_its_range_and_default() {
    let rows = documented();
    let mut wrong = Vec::new();
    for ((section, key), expected) in accepted() {
        let found = rows.get(&(section.clone(), key.clone())).cloned().unwrap_or_default();
        let missing = expected.difference(&found).map(|row| format!("{section}: | `{key}` | {row} | is missing"));
        let stale = found.difference(&expected).map(|row| format!("{section}: `{key}` says '{row}'"));
        wrong.extend(stale.chain(missing));
    }
    assert!(wrong.is_empty(), "docs/configuration.md:\n{}", wrong.join("\n"));
}

#[test]
fn every_documented_key_is_read() {
    let known = accepted();
    let stale: Vec<_> = documented().into_keys().filter(|row| !known.contains_key(row)).collect();
    assert!(stale.is_empty(), "docs/configuration.md has rows that nobody reads: {stale:?}");
}

/// What the page's tables say.
fn documented() -> Keys {
    let page = std::fs::read_to_string(shipped("../docs/configuration.md")).expect("the page is part of the project");
    let mut rows = Keys::new();
    let mut section = String::new();
    for line in page.lines() {
        if let Some(title) = line.strip_prefix("## ") {
            section = title.to_owned();
        }
        let cells: Vec<&str> = line.split(" | ").map(|cell| cell.trim_matches(['|', ' '])).collect();
        if let [key, allowed, default, _meaning] = cells.as_slice()
            && let Some(key) = key.strip_prefix('`').and_then(|key| key.strip_suffix('`'))
        {
            rows.entry((section.clone(), key.to_owned())).or_default().insert(format!("{allowed} | {default}"));
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
    // Whatever may be left out altogether.
    let more = [
        "fleet=[{ kind = \"scout_mini\", count = 1, first_id = 6 }]",
        "radio.burst={ enter_per_s = 1, leave_per_s = 1 }",
        "radio.propagation={ half_range_m = 50 }",
        "radio.airtime={}",
        "radio.partitions=[{ from_s = 1, until_s = 2, ids = [1] }]",
        "behaviour={ kind = \"flock\", party = [{ leader = 1, first_id = 1, last_id = 6, waypoints_m = [[20, 9]] }] }",
    ];
    let more = more.map(|set| Override::parse(set).expect("a key"));
    assert!(read(&mut report, &path, &more, load::read_swarm).is_some());
    // Other reports: of a key that two behaviours share, one report holds one of them.
    let mut diffuse = Report::default();
    let behaviour = Override::parse("behaviour={ kind = \"diffuse\" }").expect("a key");
    assert!(read(&mut diffuse, &path, &[behaviour], load::read_swarm).is_some());
    keep(&mut keys, SWARM, &diffuse, &["kinds.NAME.", "world."]);
    let mut deploy = Report::default();
    assert!(read(&mut deploy, &shipped("swarms/deploy_exp1.toml"), &[], load::read_swarm).is_some());
    keep(&mut keys, SWARM, &deploy, &["kinds.NAME.", "world."]);
    let mut explore = Report::default();
    assert!(read(&mut explore, &shipped("swarms/explore_rooms.toml"), &[], load::read_swarm).is_some());
    keep(&mut keys, SWARM, &explore, &["kinds.NAME.", "world."]);
    let mut world = Report::default();
    let room = [
        "polylines=[{ points_m = [[1, 1], [2, 1]] }]",
        "movers=[{ radius_m = 0.4, waypoints_m = [[10, 5], [10, 9]], speed_mps = 0.5 }]",
    ];
    let room = room.map(|set| Override::parse(set).expect("a key"));
    assert!(read(&mut world, &shipped("worlds/room.toml"), &room, load::read_world).is_some());
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
            let default = doc.default.clone().unwrap_or_else(|| "required".to_owned());
            let said = keys.entry((section.to_owned(), shape.clone())).or_default();
            said.insert(format!("{} | {default}", doc.allowed));
        }
    }
}
