//! From files to values that cannot be wrong.

use crate::check::Checker;
use crate::include;
use crate::overrides::Override;
use crate::path::join;
use crate::problem::Problems;
use crate::read::robot::{self, RobotFileParts};
use crate::read::swarm::{self, SwarmParts};
use crate::read::{kind, world};
use crate::reader::read_table;
use crate::report::{Report, Words};
use crate::tree::{Node, Value};
use crate::{Behaviour, Kind, RobotFile, Swarm, World};
use std::path::Path;

/// Reads a swarm, its kinds and its world; `overrides` count before anything is checked.
///
/// # Errors
/// [`Problems`]: everything that is wrong, in all files at once.
pub fn load_swarm(path: &Path, overrides: &[Override]) -> Result<Swarm, Problems> {
    let mut report = Report::default();
    let swarm = read_swarm(&mut report, path, overrides);
    report.finish(swarm)
}

/// Reads the file of one robot in the field.
///
/// # Errors
/// [`Problems`]: everything that is wrong, at once.
pub fn load_robot(path: &Path, overrides: &[Override]) -> Result<RobotFile, Problems> {
    let mut report = Report::default();
    let file = read_robot_file(&mut report, path, overrides);
    report.finish(file)
}

/// Reads a robot kind.
///
/// # Errors
/// [`Problems`]: everything that is wrong, at once.
pub fn load_kind(path: &Path) -> Result<Kind, Problems> {
    let mut report = Report::default();
    let kind = include::read_root(&mut report, path).and_then(|root| read_kind(&mut report, &root));
    report.finish(kind)
}

/// Reads a world.
///
/// # Errors
/// [`Problems`]: everything that is wrong, at once.
pub fn load_world(path: &Path) -> Result<World, Problems> {
    let mut report = Report::default();
    let world = include::read_root(&mut report, path).and_then(|root| read_world(&mut report, &root));
    report.finish(world)
}

/// A file of any kind that was read without problems.
#[derive(Clone, Debug, PartialEq)]
pub enum Checked {
    /// A swarm.
    Swarm(Box<Swarm>),
    /// The file of one robot in the field.
    Robot(Box<RobotFile>),
    /// A robot kind.
    Kind(Box<Kind>),
    /// A world.
    World(Box<World>),
}

/// Reads any configuration file: its tables say which sort it is.
///
/// # Errors
/// [`Problems`]: everything that is wrong, at once; also if it is no configuration at all.
pub fn check_file(path: &Path) -> Result<Checked, Problems> {
    let mut report = Report::default();
    let Some(root) = include::read_root(&mut report, path) else { return report.finish(None) };
    match Sort::of(&root) {
        Some(Sort::Swarm) => load_swarm(path, &[]).map(|swarm| Checked::Swarm(Box::new(swarm))),
        Some(Sort::Robot) => load_robot(path, &[]).map(|file| Checked::Robot(Box::new(file))),
        Some(Sort::Kind) => load_kind(path).map(|kind| Checked::Kind(Box::new(kind))),
        Some(Sort::World) => load_world(path).map(|world| Checked::World(Box::new(world))),
        None => {
            let expected = "the tables of a swarm ([[robot]], [kinds]), a robot's file ([robot], [kind]), a robot kind \
                            ([drive], [lidar]) or a world ([[polygons]], [[circles]])";
            let words = Words::new("none of Drover's tables", expected, "compare it with the files in config/");
            report.push(root.at, "", words);
            report.finish(None)
        }
    }
}

/// The sorts of configuration files.
enum Sort {
    Swarm,
    Robot,
    Kind,
    World,
}

impl Sort {
    /// The sort whose own keys `root` has most of.
    fn of(root: &Node) -> Option<Self> {
        let count = |keys: &[&str]| keys.iter().filter(|key| root.get(key).is_some()).count();
        let robots = root.get("robot").map(|node| matches!(node.value, Value::Array(_)));
        let swarm = count(&["kinds", "world", "radio", "duration_s", "mavlink_port_base", "step_ms", "seed"])
            + usize::from(robots == Some(true));
        let robot = count(&["kind", "peers", "swarm"]) + usize::from(robots == Some(false));
        let scores = [
            (swarm, Self::Swarm),
            (robot, Self::Robot),
            (count(&["drive", "body", "lidar", "sim"]), Self::Kind),
            (count(&["polygons", "circles"]), Self::World),
        ];
        let best = scores.into_iter().filter(|(score, _)| *score > 0).reduce(|a, b| if b.0 > a.0 { b } else { a });
        best.map(|(_, sort)| sort)
    }
}

fn read_kind(report: &mut Report, root: &Node) -> Option<Kind> {
    let kind = read_table(report, root, ("", ""), |table| kind::kind(table, None))?;
    Checker { report, root }.kind("", &kind);
    Some(kind)
}

fn read_world(report: &mut Report, root: &Node) -> Option<World> {
    let parts = read_table(report, root, ("", ""), world::world)?;
    Checker { report, root }.world("", &parts);
    parts.world()
}

fn read_swarm(report: &mut Report, path: &Path, overrides: &[Override]) -> Option<Swarm> {
    let mut root = include::read_root(report, path)?;
    let (first, then): (Vec<_>, Vec<_>) = overrides.iter().partition(|change| change.names_file());
    first.iter().for_each(|change| change.apply(report, &mut root));
    include::expand_swarm(report, &mut root);
    then.iter().for_each(|change| change.apply(report, &mut root));
    let mut parts = read_table(report, &root, ("", ""), swarm::swarm)?;
    check_swarm(&mut Checker { report, root: &root }, &mut parts);
    if report.is_clean() { resolved(parts) } else { None }
}

fn check_swarm(checker: &mut Checker<'_>, parts: &mut SwarmParts) {
    for key in parts.tightening.idle_keys(parts.kinds.values()) {
        let words = Words::new(
            "a value looser than every kind's own",
            "a value that tightens at least one kind",
            "lower it (a margin: raise it), or set it in the kind itself: kinds.NAME",
        );
        checker.report.push_path(checker.root, &key, words);
    }
    for (name, kind) in &mut parts.kinds {
        parts.tightening.apply(kind);
        let prefix = join("kinds", name);
        checker.kind(&prefix, kind);
        if let Some(beacon) = &parts.beacon {
            checker.peer_period(&prefix, kind, beacon);
        }
    }
    if let Some(world) = &parts.world {
        checker.world("world", world);
    }
    checker.robots(&parts.robots, &parts.kinds);
    checker.links(&parts.robots, parts.beacon.as_ref());
    checker.starts(&parts.robots, &parts.kinds, parts.world.as_ref());
    check_behaviour(checker, parts);
}

fn check_behaviour(checker: &mut Checker<'_>, parts: &SwarmParts) {
    let Some(Behaviour::Flock(flock)) = &parts.behaviour else { return };
    let ids: Vec<u32> = parts.robots.iter().filter_map(|robot| robot.id).collect();
    let leader = parts.robots.iter().find(|robot| robot.id == Some(flock.leader));
    let leader_kind = leader.and_then(|robot| parts.kinds.get(robot.kind.as_ref()?));
    checker.leader(flock, &ids, leader_kind);
    let used = parts.robots.iter().filter_map(|robot| parts.kinds.get(robot.kind.as_ref()?));
    checker.flock_distances(flock, used);
    if let Some(world) = &parts.world {
        checker.waypoints(flock, leader_kind, world);
    }
}

fn resolved(parts: SwarmParts) -> Option<Swarm> {
    Some(Swarm {
        name: parts.name?,
        seed: parts.seed?,
        duration_s: parts.duration_s?,
        step_ms: parts.step_ms?,
        record_dir: parts.record_dir?,
        mavlink_port_base: parts.mavlink_port_base?,
        world: parts.world?.world()?,
        kinds: parts.kinds,
        robots: parts.robots.iter().map(|robot| robot.robot()).collect::<Option<_>>()?,
        behaviour: parts.behaviour?,
        beacon: parts.beacon?,
        radio: parts.radio?,
    })
}

fn read_robot_file(report: &mut Report, path: &Path, overrides: &[Override]) -> Option<RobotFile> {
    let mut root = include::read_root(report, path)?;
    let (first, then): (Vec<_>, Vec<_>) = overrides.iter().partition(|change| change.names_file());
    first.iter().for_each(|change| change.apply(report, &mut root));
    include::expand_robot_file(report, &mut root);
    then.iter().for_each(|change| change.apply(report, &mut root));
    let parts = read_table(report, &root, ("", ""), robot::robot_file)?;
    check_robot_file(&mut Checker { report, root: &root }, &parts);
    if !report.is_clean() {
        return None;
    }
    Some(RobotFile {
        swarm: parts.swarm?,
        robot: parts.robot?.robot()?,
        kind: parts.kind?,
        behaviour: parts.behaviour?,
        beacon: parts.beacon?,
        peers: parts.peers.into_iter().map(|(_, peer)| peer).collect(),
        record_dir: parts.record_dir,
    })
}

fn check_robot_file(checker: &mut Checker<'_>, parts: &RobotFileParts) {
    if let Some(kind) = &parts.kind {
        checker.kind("kind", kind);
        if let Some(beacon) = &parts.beacon {
            checker.peer_period("kind", kind, beacon);
        }
    }
    checker.own_kind(parts);
    checker.peers(parts);
    let robots: Vec<_> = parts.robot.iter().cloned().collect();
    checker.links(&robots, parts.beacon.as_ref());
    let own = robots.first().and_then(|robot| robot.id);
    if let Some(Behaviour::Flock(flock)) = &parts.behaviour {
        let ids: Vec<u32> = own.into_iter().chain(parts.peers.iter().map(|(_, peer)| peer.id)).collect();
        checker.leader(flock, &ids, parts.kind.as_ref().filter(|_| own == Some(flock.leader)));
        checker.flock_distances(flock, parts.kind.iter());
    }
}
