//! The behaviour must be one that these robots can do in this place.

use super::Checker;
use crate::read::swarm::SwarmParts;
use crate::report::Words;
use crate::walls::Walls;
use crate::{Diffuse, Flock, Kind};
use std::collections::BTreeSet;

impl Checker<'_> {
    /// The leader of a flock: there, and fast enough. `ids` are all robots.
    pub(crate) fn leader(&mut self, flock: &Flock, ids: &[u32], leader: Option<&Kind>) {
        if !ids.contains(&flock.leader) {
            let shown: Vec<String> = ids.iter().take(10).map(u32::to_string).collect();
            let more = if ids.len() > shown.len() { ", ..." } else { "" };
            let expected = format!("the id of a robot: {}{more}", shown.join(", "));
            let words = Words::new(flock.leader.to_string(), expected, "choose one of them");
            self.report.push_path(self.root, "behaviour.leader", words);
        }
        let Some(kind) = leader else { return };
        if flock.leader_speed_mps > kind.motion.speed_mps_max {
            let expected = format!("at most {}, the leader's motion.speed_mps_max", kind.motion.speed_mps_max);
            let words = Words::new(flock.leader_speed_mps.to_string(), expected, "lower it");
            self.report.push_path(self.root, "behaviour.leader_speed_mps", words);
        }
    }

    /// Distances of a flock against the bodies that fly in it.
    pub(crate) fn flock_distances<'k>(&mut self, flock: &Flock, kinds: impl Iterator<Item = &'k Kind> + Clone) {
        let radius_m = kinds.clone().map(|kind| kind.body.radius_m).fold(0.0, f64::max);
        if flock.spacing_m <= 2.0 * radius_m {
            let expected = format!("more than two bodies' radii, {}", 2.0 * radius_m);
            let words = Words::new(flock.spacing_m.to_string(), expected, "raise it: neighbours would touch");
            self.report.push_path(self.root, "behaviour.spacing_m", words);
        }
        let sight_m = kinds.map(|kind| kind.lidar.range_m_max).fold(f64::INFINITY, f64::min);
        if flock.obstacle_range_m > sight_m {
            let expected = format!("at most the shortest lidar.range_m_max, {sight_m}");
            let words = Words::new(flock.obstacle_range_m.to_string(), expected, "lower it: nothing is seen there");
            self.report.push_path(self.root, "behaviour.obstacle_range_m", words);
        }
    }

    /// The leader's body must fit at every waypoint.
    pub(crate) fn waypoints(&mut self, flock: &Flock, leader: Option<&Kind>, walls: &Walls<'_>) {
        let radius_m = leader.map_or(0.0, |kind| kind.body.radius_m);
        for (index, point) in flock.waypoints_m.iter().enumerate() {
            let path = format!("behaviour.waypoints_m[{index}]");
            self.clear_of_walls(&path, *point, radius_m, walls);
        }
    }

    /// Diffusion against the bodies that do it.
    pub(crate) fn diffuse<'k>(&mut self, diffuse: &Diffuse, kinds: impl Iterator<Item = &'k Kind> + Clone) {
        let least = |of: fn(&Kind) -> f64| kinds.clone().map(of).fold(f64::INFINITY, f64::min);
        let limits = [
            ("speed_mps", diffuse.speed_mps, least(|kind| kind.motion.speed_mps_max), "motion.speed_mps_max"),
            (
                "turn_radps",
                diffuse.turn_radps,
                least(|kind| kind.motion.yaw_rate_radps_max),
                "motion.yaw_rate_radps_max",
            ),
            ("clearance_m", diffuse.clearance_m, least(|kind| kind.lidar.range_m_max), "lidar.range_m_max"),
        ];
        for (key, value, limit, name) in limits {
            if value > limit {
                let expected = format!("at most the least {name} of its kinds, {limit}");
                let words = Words::new(value.to_string(), expected, "lower it");
                self.report.push_path(self.root, &format!("behaviour.{key}"), words);
            }
        }
        let radius_m = kinds.clone().map(|kind| kind.body.radius_m).fold(0.0, f64::max);
        if diffuse.clearance_m < radius_m {
            let expected = format!("at least the greatest body.radius_m of its kinds, {radius_m}");
            let words = Words::new(diffuse.clearance_m.to_string(), expected, "raise it: it counts from the centre");
            self.report.push_path(self.root, "behaviour.clearance_m", words);
        }
    }

    /// The radio can only be parted between robots that there are.
    pub(crate) fn partitions(&mut self, parts: &SwarmParts) {
        let Some(radio) = parts.radio.as_ref().filter(|radio| !radio.partitions.is_empty()) else { return };
        let ids: BTreeSet<u32> = parts.robots.iter().filter_map(|robot| robot.id).collect();
        for (at, partition) in radio.partitions.iter().enumerate() {
            let strangers = partition.ids.iter().enumerate().filter(|(_, id)| !ids.contains(id));
            for (index, id) in strangers {
                let words =
                    Words::new(id.to_string(), "the id of a robot of this swarm", "choose another or leave it out");
                self.report.push_path(self.root, &format!("radio.partitions[{at}].ids[{index}]"), words);
            }
        }
    }
}
