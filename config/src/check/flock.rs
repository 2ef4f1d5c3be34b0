//! Flocking must be one that these robots can do in this place: leaders that are there and fast enough, one party for
//! each robot, distances that bodies have room for, and nothing on bodies that only points can do.

use super::Checker;
use crate::path::join;
use crate::read::robot::RobotParts;
use crate::report::Words;
use crate::walls::Walls;
use crate::{
    Flock, FlockGuard, FlockMode, Kind, LINK_BEGUN_SHARE, POSE_ERROR_M, Party, Radio, SimMotion, WallFollowing,
};

/// Most ids that a problem lists.
const SHOWN_MAX: usize = 10;

const PARTY: &str = "behaviour.party";

/// The longest link that is begun, metres.
fn begun_m(flock: &Flock, bodies: bool) -> f64 {
    let error_m = if bodies { 2.0 * POSE_ERROR_M } else { 0.0 };
    (LINK_BEGUN_SHARE * (flock.link_range_m - error_m)).max(0.0)
}

fn shown(ids: &[u32]) -> String {
    let shown: Vec<String> = ids.iter().take(SHOWN_MAX).map(u32::to_string).collect();
    let more = if ids.len() > SHOWN_MAX { ", ..." } else { "" };
    format!("{}{more}", shown.join(", "))
}

impl Checker<'_> {
    /// The table that says `key` of party `index`: a single party's keys may stand in the behaviour itself.
    fn party_path(&self, index: usize, key: &str) -> String {
        let table = if self.root.has(PARTY) { format!("{PARTY}[{index}]") } else { "behaviour".to_owned() };
        join(&table, key)
    }

    /// Each of the robots `ids` is in one party, and each party's leader is one of them and fast enough. `kind_of`: a
    /// robot's kind, where it is known.
    pub(crate) fn parties<'k>(&mut self, flock: &Flock, ids: &[u32], kind_of: impl Fn(u32) -> Option<&'k Kind>) {
        for (index, party) in flock.parties.iter().enumerate() {
            self.leader((index, party), ids);
            let earlier = flock.parties.iter().enumerate().take(index);
            let overlaps = |other: &Party| other.first_id <= party.last_id && party.first_id <= other.last_id;
            if let Some((other, Party { first_id, last_id, .. })) = earlier.into_iter().find(|(_, p)| overlaps(p)) {
                let found = format!("{} up to {}, some of which party[{other}] has", party.first_id, party.last_id);
                let expected = format!("ids other than its {first_id}..={last_id}");
                let words = Words::new(found, expected, "change first_id or last_id: a robot follows one leader");
                self.report.push_path(self.root, &self.party_path(index, "first_id"), words);
            }
        }
        let leaders = flock.parties.iter().filter_map(|party| kind_of(party.leader));
        self.leader_speed(flock, leaders.map(|kind| kind.motion.speed_mps_max).fold(f64::INFINITY, f64::min));
        let strays: Vec<u32> = ids.iter().copied().filter(|id| flock.party_of(*id).is_none()).collect();
        if !strays.is_empty() {
            let found = format!("no party for {}", shown(&strays));
            let words = Words::new(found, "a party for each robot", "widen a party's ids, or add one");
            self.report.push_path(self.root, PARTY, words);
        }
    }

    fn leader(&mut self, (index, party): (usize, &Party), ids: &[u32]) {
        let words = if !party.has(party.leader) {
            let expected = format!("an id in {}..={}, its party's", party.first_id, party.last_id);
            Words::new(party.leader.to_string(), expected, "choose one of them, or widen the party")
        } else if !ids.contains(&party.leader) {
            let members: Vec<u32> = ids.iter().copied().filter(|id| party.has(*id)).collect();
            let expected = match members.is_empty() {
                true => "a party with a robot in it".to_owned(),
                false => format!("the id of a robot: {}", shown(&members)),
            };
            Words::new(party.leader.to_string(), expected, "choose one of them")
        } else {
            return;
        };
        self.report.push_path(self.root, &self.party_path(index, "leader"), words);
    }

    /// `limit_mps`: the slowest leader's.
    fn leader_speed(&mut self, flock: &Flock, limit_mps: f64) {
        if flock.leader_speed_mps > limit_mps {
            let expected = format!("at most {limit_mps}, the leader's motion.speed_mps_max");
            self.flock_problem(
                "leader_speed_mps",
                Words::new(flock.leader_speed_mps.to_string(), expected, "lower it"),
            );
        }
    }

    /// Distances of a flock against the bodies that fly in it.
    pub(crate) fn flock_distances<'k>(&mut self, flock: &Flock, kinds: impl Iterator<Item = &'k Kind> + Clone) {
        let radius_m = kinds.clone().map(|kind| kind.body.radius_m).fold(0.0, f64::max);
        if flock.spacing_m <= 2.0 * radius_m {
            let expected = format!("more than two bodies' radii, {}", 2.0 * radius_m);
            let words = Words::new(flock.spacing_m.to_string(), expected, "raise it: neighbours would touch");
            self.flock_problem("spacing_m", words);
        }
        let sight_m = kinds.map(|kind| kind.lidar.range_m_max).fold(f64::INFINITY, f64::min);
        if flock.obstacle_range_m > sight_m {
            let expected = format!("at most the shortest lidar.range_m_max, {sight_m}");
            let words = Words::new(flock.obstacle_range_m.to_string(), expected, "lower it: nothing is seen there");
            self.flock_problem("obstacle_range_m", words);
        }
        if flock.guard == FlockGuard::Full && flock.link_range_m <= 0.0 {
            let words = Words::new("0", "more than 0 with guard = \"full\"", "say how long links may be");
            self.flock_problem("link_range_m", words);
        }
        if flock.mode == FlockMode::Safe && flock.walls == WallFollowing::Literal {
            let words =
                Words::new("\"literal\" with mode = \"safe\"", "\"pledge\" or \"none\"", "set mode = \"literal\", too");
            self.flock_problem("walls", words);
        }
    }

    /// What only points can do is not asked of bodies.
    pub(crate) fn flocking_kinds<'k>(&mut self, flock: &Flock, mut kinds: impl Iterator<Item = &'k Kind>) {
        let Some(name) = kinds.find(|kind| kind.sim.motion != SimMotion::Point).map(|kind| &kind.name) else { return };
        let literal = flock.mode == FlockMode::Literal;
        let found = |value: &str| format!("{value} with {name:?}, a kind that is no point");
        if literal {
            let expected = "\"safe\"; the paper as printed is for simulated points (sim.motion = \"point\")";
            let advice = "set it to \"safe\": as printed, robots reverse blindly and run into each other";
            self.flock_problem("mode", Words::new(found("\"literal\""), expected, advice));
        }
        // What follows from the mode is not said again.
        if flock.guard == FlockGuard::None && (!literal || self.root.has("behaviour.guard")) {
            let expected = "\"collision\" or \"full\"; no guard is for simulated points (sim.motion = \"point\")";
            let advice = "leave it out: bodies are never let into anything";
            self.flock_problem("guard", Words::new(found("\"none\""), expected, advice));
        }
        if !flock.solid {
            let expected = "true; walls to walk through are for simulated points (sim.motion = \"point\")";
            self.flock_problem("solid", Words::new(found("false"), expected, "leave it out"));
        }
    }

    /// Where links are kept: bodies have room for them, the radio reaches as far, and each party of `robots` is one
    /// network at its start.
    pub(crate) fn flock_links<'k>(
        &mut self,
        flock: &Flock,
        kinds: impl Iterator<Item = &'k Kind>,
        (robots, radio): (&[RobotParts], Option<&Radio>),
    ) {
        if flock.guard != FlockGuard::Full || flock.link_range_m <= 0.0 {
            return;
        }
        let bodies = self.room_for_links(flock, kinds);
        if let Some(radio) = radio.filter(|radio| bodies && flock.link_range_m > radio.range_m) {
            let expected = format!("at most radio.range_m, {}", radio.range_m);
            let advice = "lower it, or raise radio.range_m: nothing is heard from farther away";
            self.flock_problem("link_range_m", Words::new(flock.link_range_m.to_string(), expected, advice));
        }
        let key = if bodies { "0.95 (link_range_m - 0.6)" } else { "0.95 link_range_m" };
        for party in &flock.parties {
            let mates: Vec<&RobotParts> =
                robots.iter().filter(|robot| robot.id.is_some_and(|id| party.has(id))).collect();
            self.network((key, begun_m(flock, bodies)), &mates);
        }
    }

    /// Bodies err about their places, and their links are at least as long as their spacing. Whether there are bodies.
    pub(crate) fn room_for_links<'k>(&mut self, flock: &Flock, mut kinds: impl Iterator<Item = &'k Kind>) -> bool {
        let bodies = kinds.any(|kind| kind.sim.motion != SimMotion::Point);
        let full = flock.guard == FlockGuard::Full && flock.link_range_m > 0.0;
        if full && bodies && begun_m(flock, bodies) < flock.spacing_m {
            let least_m = flock.spacing_m / LINK_BEGUN_SHARE + 2.0 * POSE_ERROR_M;
            let expected =
                format!("at least {least_m:.3}: spacing_m, and {POSE_ERROR_M} m of error of each body's place");
            let words = Words::new(flock.link_range_m.to_string(), expected, "raise it: no link would be begun");
            self.flock_problem("link_range_m", words);
        }
        bodies
    }

    /// Each leader's body must fit at every waypoint.
    pub(crate) fn waypoints<'k>(
        &mut self,
        flock: &Flock,
        kind_of: impl Fn(u32) -> Option<&'k Kind>,
        walls: &Walls<'_>,
    ) {
        for (index, party) in flock.parties.iter().enumerate() {
            let radius_m = kind_of(party.leader).map_or(0.0, |kind| kind.body.radius_m);
            let path = self.party_path(index, "waypoints_m");
            for (index, point) in party.waypoints_m.iter().enumerate() {
                self.clear_of_walls(&format!("{path}[{index}]"), *point, radius_m, walls);
            }
        }
    }

    fn flock_problem(&mut self, key: &str, words: Words) {
        self.report.push_path(self.root, &join("behaviour", key), words);
    }
}
