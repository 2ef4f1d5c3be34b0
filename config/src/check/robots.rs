//! Robots: each its own id, a kind that there is, a place of its own.

use super::Checker;
use crate::crowd::Crowd;
use crate::geometry::distance;
use crate::path::join;
use crate::read::kind::KindParts;
use crate::read::robot::{RobotFileParts, RobotParts};
use crate::report::Words;
use crate::suggest::nearest;
use crate::walls::Walls;
use crate::{Drive, Mover};
use std::collections::{BTreeMap, BTreeSet};

/// MAVLink system ids above are ground stations' by custom.
const MAVLINK_ID_MAX: u32 = 250;

impl Checker<'_> {
    /// Ids and kinds of `robots`.
    pub(crate) fn robots(&mut self, robots: &[RobotParts], kinds: &BTreeMap<String, KindParts>) {
        let is_empty = |key: &str| self.root.get(key).is_none_or(|list| list.items().is_some_and(<[_]>::is_empty));
        if robots.is_empty() && is_empty("robot") && is_empty("fleet") {
            let advice = "add a [[robot]] with id, kind and start, or a [[fleet]] with kind and count";
            self.report.push_path(self.root, "robot", Words::new("no robot", "at least one", advice));
        }
        let mut ids: BTreeMap<u32, &str> = BTreeMap::new();
        let mut said = BTreeSet::new();
        for robot in robots {
            // What is wrong with one robot of a fleet is wrong with many: it is said once.
            if robot.of_fleet && said.contains(robot.path.as_str()) {
                continue;
            }
            let mut wrong = false;
            if let Some(id) = robot.id
                && let Some(other) = ids.insert(id, &robot.path)
            {
                let words = Words::new(format!("{id}, which {other} has already"), "an id of its own", "change one");
                self.report.push_path(self.root, &robot.id_path(), words);
                wrong = true;
            }
            wrong |= self.kind_is_unknown(robot, kinds);
            let drive = robot.kind.as_ref().and_then(|kind| kinds.get(kind)?.drive);
            wrong |= self.mavlink_id_is_wrong(robot, drive);
            if wrong {
                said.insert(robot.path.as_str());
            }
        }
    }

    fn kind_is_unknown(&mut self, robot: &RobotParts, kinds: &BTreeMap<String, KindParts>) -> bool {
        let Some(name) = robot.kind.as_ref().filter(|_| !self.report.is_full()) else { return false };
        let named = self.root.get("kinds").and_then(|kinds| kinds.fields());
        if kinds.contains_key(name) || named.is_some_and(|named| named.contains_key(name)) {
            return false; // a kind that is there but wrong has its own problems
        }
        let known: Vec<&str> = named.into_iter().flatten().map(|(name, _)| name.as_str()).collect();
        let advice = match nearest(name, known.iter().copied()) {
            Some(near) => format!("did you mean \"{near}\"?"),
            None => "add it to [kinds]".to_owned(),
        };
        let expected = format!("one of the kinds {}", known.join(", "));
        self.report.push_path(self.root, &join(&robot.path, "kind"), Words::new(format!("{name:?}"), expected, advice));
        true
    }

    /// A MAVLink robot's id is its system id.
    fn mavlink_id_is_wrong(&mut self, robot: &RobotParts, drive: Option<Drive>) -> bool {
        let (Some(id), Some(Drive::Mavlink { .. })) = (robot.id, drive) else { return false };
        let wrong = id > MAVLINK_ID_MAX;
        if wrong {
            let expected = format!("1..={MAVLINK_ID_MAX} for a MAVLink robot");
            let words = Words::new(id.to_string(), expected, "choose a smaller id: it is the MAVLink system id");
            self.report.push_path(self.root, &robot.id_path(), words);
        }
        wrong
    }

    /// No body starts in a wall, in another body or in one of the world's movers. What comes back are the places that
    /// are taken.
    pub(crate) fn starts(
        &mut self,
        robots: &[RobotParts],
        kinds: &BTreeMap<String, KindParts>,
        movers: &[(usize, Mover)],
        walls: Option<&Walls<'_>>,
    ) -> Crowd {
        let mut crowd = Crowd::default();
        let mut paths = Vec::with_capacity(movers.len() + robots.len());
        for (index, mover) in movers {
            let Some(start) = mover.waypoints_m.first() else { continue };
            crowd.add(*start, mover.radius_m);
            paths.push(format!("world.movers[{index}]"));
        }
        for robot in robots {
            let Some(start) = robot.start.filter(|_| !self.report.is_full()) else { continue };
            // Of a body that could not be read, the centre at least must be clear.
            let body = robot.kind.as_ref().and_then(|kind| kinds.get(kind)?.body.as_ref());
            let (point, radius_m) = ([start.x_m, start.y_m], body.map_or(0.0, |body| body.radius_m));
            let path = join(&robot.path, "start");
            if let Some(walls) = walls {
                self.clear_of_walls(&path, point, radius_m, walls);
            }
            if let Some(other) = crowd.overlapping(point, radius_m) {
                let found = format!("{:.3} m from {}", distance(point, other.centre_m), paths[other.index]);
                let expected = format!("at least {:.3} m, both radii together", radius_m + other.radius_m);
                self.report.push_path(self.root, &path, Words::new(found, expected, "move one of the two"));
            }
            crowd.add(point, radius_m);
            paths.push(robot.path.clone());
        }
        crowd
    }
}

impl Checker<'_> {
    /// The robot of a robot's file has that file's kind.
    pub(crate) fn own_kind(&mut self, parts: &RobotFileParts) {
        let (Some(robot), Some(kind)) = (&parts.robot, &parts.kind) else { return };
        self.mavlink_id_is_wrong(robot, kind.drive);
        let Some(name) = &kind.name else { return };
        if let Some(named) = robot.kind.as_ref().filter(|named| *named != name) {
            let expected = format!("{name:?}, the name of [kind]");
            self.report.push_path(
                self.root,
                "robot.kind",
                Words::new(format!("{named:?}"), expected, "make them equal"),
            );
        }
    }

    /// The peers of a robot's file: each once, and not the robot itself.
    pub(crate) fn peers(&mut self, parts: &RobotFileParts) {
        let own = parts.robot.as_ref().and_then(|robot| robot.id);
        let mut ids: BTreeMap<u32, String> = own.map(|id| (id, "robot".to_owned())).into_iter().collect();
        for (index, peer) in &parts.peers {
            let path = format!("peers[{index}]");
            if let Some(other) = ids.get(&peer.id) {
                let found = format!("{}, which {other} has already", peer.id);
                let words = Words::new(found, "an id of its own", "leave the robot itself and doubles out");
                self.report.push_path(self.root, &join(&path, "id"), words);
            } else {
                ids.insert(peer.id, path);
            }
        }
    }
}
