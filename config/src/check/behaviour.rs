//! The behaviour must be one that these robots can do in this place.

use super::Checker;
use crate::read::swarm::SwarmParts;
use crate::report::Words;
use crate::{Diffuse, Kind};
use std::collections::BTreeSet;

impl Checker<'_> {
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
