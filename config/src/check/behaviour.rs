//! The behaviour must be one that these robots can do in this place.

use super::Checker;
use crate::read::world::WorldParts;
use crate::report::Words;
use crate::{Flock, Kind};

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
    pub(crate) fn waypoints(&mut self, flock: &Flock, leader: Option<&Kind>, world: &WorldParts) {
        let radius_m = leader.map_or(0.0, |kind| kind.body.radius_m);
        for (index, point) in flock.waypoints_m.iter().enumerate() {
            let path = format!("behaviour.waypoints_m[{index}]");
            self.clear_of_walls(&path, *point, radius_m, world);
        }
    }
}
