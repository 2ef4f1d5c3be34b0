//! From files to values that cannot be wrong.

use crate::assign::assign;
use crate::check::Checker;
use crate::check::deploy::{reach_m_beside, reach_m_max};
use crate::include;
use crate::overrides::Override;
use crate::path::join;
use crate::problem::Problems;
use crate::read::kind::KindParts;
use crate::read::robot::{self, RobotFileParts};
use crate::read::swarm::{self, SEED, SwarmParts};
use crate::read::{kind, world};
use crate::reader::read_table;
use crate::report::{Report, Words};
use crate::source::Source;
use crate::tree::{Node, Value, parse_document};
use crate::walls::Walls;
use crate::{Behaviour, Deploy, Kind, RobotFile, Swarm, World};
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

/// Reads a swarm, its kinds and its world; `overrides` count before anything is checked.
///
/// # Errors
/// [`Problems`]: everything that is wrong, in all files at once.
pub fn load_swarm(path: &Path, overrides: &[Override]) -> Result<Swarm, Problems> {
    load(path, overrides, read_swarm)
}

/// Reads the file of one robot in the field.
///
/// # Errors
/// [`Problems`]: everything that is wrong, at once.
pub fn load_robot(path: &Path, overrides: &[Override]) -> Result<RobotFile, Problems> {
    load(path, overrides, read_robot_file)
}

/// Reads the same from `text`, which problems call `name`: a robot's file as a recording holds it.
///
/// # Errors
/// [`Problems`]: everything that is wrong, at once.
pub fn robot_from_text(text: &str, name: &str) -> Result<RobotFile, Problems> {
    let mut report = Report::default();
    let source = report.add(Source::file(Path::new(name), text.to_owned()));
    let root = parse_document(&mut report, source);
    let value = read_robot_file(&mut report, root, &[]);
    report.finish(value)
}

/// Reads a robot kind.
///
/// # Errors
/// [`Problems`]: everything that is wrong, at once.
pub fn load_kind(path: &Path) -> Result<Kind, Problems> {
    load(path, &[], read_kind)
}

/// Reads a world.
///
/// # Errors
/// [`Problems`]: everything that is wrong, at once.
pub fn load_world(path: &Path) -> Result<World, Problems> {
    load(path, &[], read_world)
}

/// How a sort of file is read, once it is a tree.
pub(crate) type Read<T> = fn(&mut Report, Node, &[Override]) -> Option<T>;

fn load<T>(path: &Path, overrides: &[Override], read: Read<T>) -> Result<T, Problems> {
    let mut report = Report::default();
    let value = include::read_root(&mut report, path).and_then(|root| read(&mut report, root, overrides));
    report.finish(value)
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

impl Checked {
    /// What sort of file it is, in words for the user.
    #[must_use]
    pub const fn kind_name(&self) -> &'static str {
        match self {
            Self::Swarm(_) => "swarm",
            Self::Robot(_) => "robot file",
            Self::Kind(_) => "robot kind",
            Self::World(_) => "world",
        }
    }
}

/// Reads any configuration file: its tables say which sort it is.
///
/// # Errors
/// [`Problems`]: everything that is wrong, at once; also if it is no configuration at all.
pub fn check_file(path: &Path) -> Result<Checked, Problems> {
    check_file_with(path, &[])
}

/// The same with overrides.
///
/// # Errors
/// [`Problems`]: everything that is wrong, at once; also if it is no configuration at all.
pub fn check_file_with(path: &Path, overrides: &[Override]) -> Result<Checked, Problems> {
    let mut report = Report::default();
    let Some(root) = include::read_root(&mut report, path) else { return report.finish(None) };
    let Some(sort) = Sort::of(&root) else {
        let expected = "the tables of a swarm ([[robot]], [kinds]), a robot's file ([robot], [kind]), a robot kind \
                        ([drive], [lidar]) or a world ([[polygons]], [[circles]], map, generate)";
        let advice = "compare it with the files in config/";
        report.push(root.at, "", Words::new("none of Drover's tables", expected, advice));
        return report.finish(None);
    };
    let checked = match sort {
        Sort::Swarm => read_swarm(&mut report, root, overrides).map(|swarm| Checked::Swarm(Box::new(swarm))),
        Sort::Robot => read_robot_file(&mut report, root, overrides).map(|file| Checked::Robot(Box::new(file))),
        Sort::Kind => read_kind(&mut report, root, overrides).map(|kind| Checked::Kind(Box::new(kind))),
        Sort::World => read_world(&mut report, root, overrides).map(|world| Checked::World(Box::new(world))),
    };
    report.finish(checked)
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
        let swarm = count(&["kinds", "world", "radio", "duration_s", "mavlink_port_base", "step_ms", "seed", "fleet"])
            + usize::from(robots == Some(true));
        let robot = count(&["kind", "peers", "swarm"]) + usize::from(robots == Some(false));
        let scores = [
            (swarm, Self::Swarm),
            (robot, Self::Robot),
            (count(&["drive", "body", "lidar", "sim"]), Self::Kind),
            (count(&["polygons", "circles", "polylines", "movers", "map", "generate"]), Self::World),
        ];
        let best = scores.into_iter().filter(|(score, _)| *score > 0).reduce(|a, b| if b.0 > a.0 { b } else { a });
        best.map(|(_, sort)| sort)
    }
}

/// The tree `root`: changed by `overrides`, with the files that it names in their places.
fn resolve(report: &mut Report, mut root: Node, overrides: &[Override], expand: Expand) -> Node {
    let (before, after): (Vec<_>, Vec<_>) = overrides.iter().partition(|change| change.names_file());
    before.iter().for_each(|change| change.apply(report, &mut root));
    expand(report, &mut root);
    after.iter().for_each(|change| change.apply(report, &mut root));
    root
}

type Expand = fn(&mut Report, &mut Node);

/// Kinds and worlds name no files.
fn expand_nothing(_report: &mut Report, _root: &mut Node) {}

pub(crate) fn read_kind(report: &mut Report, root: Node, overrides: &[Override]) -> Option<Kind> {
    let root = resolve(report, root, overrides, expand_nothing);
    let kind = read_table(report, &root, ("", ""), |table| kind::kind(table, None))?.kind()?;
    Checker { report, root: &root }.kind("", &kind);
    Some(kind)
}

pub(crate) fn read_world(report: &mut Report, root: Node, overrides: &[Override]) -> Option<World> {
    let root = resolve(report, root, overrides, expand_nothing);
    let parts = read_table(report, &root, ("", ""), |table| world::world(table, SEED))?;
    let mut checker = Checker { report, root: &root };
    let sound = checker.world("", &parts);
    checker.movers("", &sound.movers, &Walls::new(&sound));
    parts.world()
}

pub(crate) fn read_swarm(report: &mut Report, root: Node, overrides: &[Override]) -> Option<Swarm> {
    let root = resolve(report, root, overrides, include::expand_swarm);
    let mut parts = read_table(report, &root, ("", ""), swarm::swarm)?;
    let kinds = parts.tightened_kinds();
    check_swarm(&mut Checker { report, root: &root }, &mut parts, &kinds);
    if !report.is_clean() {
        return None;
    }
    let mut swarm = resolved(parts, kinds)?;
    assign(&mut swarm);
    Checker { report, root: &root }.assigned(&swarm);
    Some(swarm)
}

fn check_swarm(checker: &mut Checker<'_>, parts: &mut SwarmParts, kinds: &BTreeMap<String, Kind>) {
    for key in parts.idle_keys() {
        let words = Words::new(
            "a value looser than every kind's own",
            "a value that tightens at least one kind",
            "lower it (a margin: raise it), or set it in the kind itself: kinds.NAME",
        );
        checker.report.push_path(checker.root, &key, words);
    }
    for (name, kind) in kinds {
        let prefix = join("kinds", name);
        checker.kind(&prefix, kind);
        if let Some(beacon) = &parts.beacon {
            checker.peer_period(&prefix, kind, beacon);
        }
    }
    checker.step(parts.step_ms, kinds);
    let world = parts.world.as_ref().map(|world| checker.world("world", world));
    let walls = world.as_ref().map(Walls::new);
    let movers = parts.world.as_ref().map_or(&[][..], |world| &world.movers);
    if let Some(walls) = &walls {
        checker.movers("world", movers, walls);
    }
    let crowd = checker.starts(&parts.robots, &parts.kinds, movers, walls.as_ref());
    let members = checker.fleets(parts, walls.as_ref(), crowd);
    parts.robots.extend(members);
    checker.robots(&parts.robots, &parts.kinds);
    checker.links(&parts.robots, parts.beacon.as_ref());
    checker.partitions(parts);
    check_behaviour(checker, parts, kinds, walls.as_ref());
}

fn check_behaviour(
    checker: &mut Checker<'_>,
    parts: &SwarmParts,
    kinds: &BTreeMap<String, Kind>,
    walls: Option<&Walls<'_>>,
) {
    let names: BTreeSet<&str> = parts.robots.iter().filter_map(|robot| robot.kind.as_deref()).collect();
    let used = names.iter().filter_map(|name| kinds.get(*name));
    let flock = match &parts.behaviour {
        Some(Behaviour::Flock(flock)) => flock,
        Some(Behaviour::Diffuse(diffuse)) => return checker.diffuse(diffuse, used),
        Some(Behaviour::Deploy(deploy)) => {
            checker.deploy(deploy, used.clone(), parts.beacon.as_ref());
            return check_deployment(checker, deploy, parts, (reach_m_max(used), walls));
        }
        Some(Behaviour::Explore(explore)) => {
            checker.exploration(explore, used);
            checker.starts_in_area(explore, parts.robots.iter());
            return parts.world.iter().for_each(|world| checker.board(explore, world));
        }
        None => return,
    };
    let ids: Vec<u32> = parts.robots.iter().filter_map(|robot| robot.id).collect();
    let kind_of = |id: u32| {
        let robot = parts.robots.iter().find(|robot| robot.id == Some(id));
        robot.and_then(|robot| kinds.get(robot.kind.as_ref()?))
    };
    checker.parties(flock, &ids, kind_of);
    checker.flock_distances(flock, used.clone());
    checker.flocking_kinds(flock, used.clone());
    checker.flock_links(flock, used, (&parts.robots, parts.radio.as_ref()));
    if let Some(walls) = walls {
        checker.waypoints(flock, kind_of, walls);
    }
}

/// The layout and the network; `reach_m` is what bodies add to distances.
fn check_deployment(
    checker: &mut Checker<'_>,
    deploy: &Deploy,
    parts: &SwarmParts,
    (reach_m, walls): (f64, Option<&Walls<'_>>),
) {
    if let Some(radio) = &parts.radio {
        checker.deploy_radio(deploy, radio);
    }
    checker.layout(deploy, parts.robots.len(), reach_m);
    if let Some(walls) = walls {
        checker.targets_clear(deploy, deploy.wall_gap_m + reach_m, walls);
    }
    checker.network(("range_m", deploy.range_m), &parts.robots.iter().collect::<Vec<_>>());
}

fn resolved(parts: SwarmParts, kinds: BTreeMap<String, Kind>) -> Option<Swarm> {
    Some(Swarm {
        name: parts.name?,
        seed: parts.seed?,
        duration_s: parts.duration_s?,
        step_ms: parts.step_ms?,
        record_dir: parts.record_dir?,
        mavlink_port_base: parts.mavlink_port_base?,
        world: parts.world?.world()?,
        kinds,
        robots: parts.robots.iter().map(|robot| robot.robot()).collect::<Option<_>>()?,
        behaviour: parts.behaviour?,
        beacon: parts.beacon?,
        radio: parts.radio?,
    })
}

pub(crate) fn read_robot_file(report: &mut Report, root: Node, overrides: &[Override]) -> Option<RobotFile> {
    let root = resolve(report, root, overrides, include::expand_robot_file);
    let parts = read_table(report, &root, ("", ""), robot::robot_file)?;
    check_robot_file(&mut Checker { report, root: &root }, &parts);
    if !report.is_clean() {
        return None;
    }
    Some(RobotFile {
        swarm: parts.swarm?,
        robot: parts.robot?.robot()?,
        kind: parts.kind?.kind()?,
        behaviour: parts.behaviour?,
        beacon: parts.beacon?,
        peers: parts.peers.into_iter().map(|(_, peer)| peer).collect(),
        record_dir: parts.record_dir,
    })
}

fn check_robot_file(checker: &mut Checker<'_>, parts: &RobotFileParts) {
    let kind = parts.kind.as_ref().and_then(KindParts::kind);
    if let Some(kind) = &kind {
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
    match &parts.behaviour {
        Some(Behaviour::Flock(flock)) => {
            let ids: Vec<u32> = own.into_iter().chain(parts.peers.iter().map(|(_, peer)| peer.id)).collect();
            checker.parties(flock, &ids, |id| kind.as_ref().filter(|_| own == Some(id)));
            checker.flock_distances(flock, kind.iter());
            checker.flocking_kinds(flock, kind.iter());
            checker.room_for_links(flock, kind.iter());
        }
        Some(Behaviour::Diffuse(diffuse)) => checker.diffuse(diffuse, kind.iter()),
        Some(Behaviour::Deploy(deploy)) => {
            checker.deploy(deploy, kind.iter(), parts.beacon.as_ref());
            checker.assigned_beforehand(deploy);
            let reach_m = reach_m_beside(reach_m_max(kind.iter()), parts.peers.iter().map(|(_, peer)| peer));
            checker.layout(deploy, 1 + parts.peers.len(), reach_m);
        }
        Some(Behaviour::Explore(explore)) => {
            checker.exploration(explore, kind.iter());
            checker.area(explore);
            checker.starts_in_area(explore, parts.robot.iter());
        }
        None => {}
    }
}
