//! Deployment must be one that these robots can do in this place: numbers that go together, a layout with room for all,
//! a network that is one at its start and at its end.

use super::Checker;
use crate::assign::TARGETS_MAX;
use crate::crowd::{Near, TOUCH_M, parted};
use crate::geometry::{Point, distance};
use crate::path::join;
use crate::read::robot::RobotParts;
use crate::report::Words;
use crate::walls::Walls;
use crate::{
    Assignment, BeaconPlane, Behaviour, Deploy, DeployGuard, DeployMode, Escape, Exchange, Kind, Peer, Radio,
    SimMotion, Swarm,
};

/// Two targets nearer than this are one, metres.
const TARGET_GAP_M_MIN: f64 = 0.001;

/// What the radius of `kind` adds to distances: points count from centre to centre.
fn reach_m(kind: &Kind) -> f64 {
    match kind.sim.motion {
        SimMotion::Point => 0.0,
        SimMotion::DiffDrive => kind.body.radius_m,
    }
}

/// The greatest reach of `kinds`.
pub(crate) fn reach_m_max<'k>(kinds: impl Iterator<Item = &'k Kind>) -> f64 {
    kinds.map(reach_m).fold(0.0, f64::max)
}

/// The greatest reach of a robot and its `peers`: where it is a point, so are they.
pub(crate) fn reach_m_beside<'p>(own_m: f64, peers: impl Iterator<Item = &'p Peer>) -> f64 {
    peers.map(|peer| peer.radius_m).filter(|_| own_m > 0.0).fold(own_m, f64::max)
}

impl Checker<'_> {
    /// What a deployment asks of itself, of its beacons and of the `kinds` that do it.
    pub(crate) fn deploy<'k>(
        &mut self,
        deploy: &Deploy,
        kinds: impl Iterator<Item = &'k Kind> + Clone,
        beacon: Option<&BeaconPlane>,
    ) {
        self.steps(deploy);
        for kind in kinds {
            self.deploying_kind(deploy, kind);
        }
        self.over_beacons(deploy);
        let period_s = beacon.filter(|_| deploy.exchange == Exchange::Beacons).map(|beacon| 1.0 / beacon.rate_hz);
        if let Some(period_s) = period_s.filter(|period_s| deploy.peer_lost_s < *period_s) {
            let expected = format!("at least one period of beacon.rate_hz, {period_s} s");
            self.deploy_problem("peer_lost_s", Words::new(deploy.peer_lost_s.to_string(), expected, "raise it"));
        }
    }

    /// What robots that know each other by beacons cannot do: links are kept by agreement, and nobody has a map.
    fn over_beacons(&mut self, deploy: &Deploy) {
        if deploy.exchange == Exchange::Snapshot {
            return;
        }
        if deploy.mode == DeployMode::Literal {
            let words = Words::new("\"beacons\"", "\"snapshot\" with mode = \"literal\"", "change one of the two");
            return self.deploy_problem("exchange", words);
        }
        if deploy.guard != DeployGuard::Full {
            let words = Words::new("another guard", "\"full\" with exchange = \"beacons\"", "leave it out");
            self.deploy_problem("guard", words);
        }
        if deploy.escape != Escape::None {
            let words = Words::new("a known map", "\"none\" with exchange = \"beacons\"", "leave it out");
            self.deploy_problem("escape", words);
        }
    }

    /// What a step of the greatest length must not overleap.
    fn steps(&mut self, deploy: &Deploy) {
        let steps_m = 2.0 * deploy.speed_mps * deploy.period_s;
        if deploy.goal_gain * deploy.period_s >= 2.0 {
            let expected = format!("less than 2 / period_s = {}", 2.0 / deploy.period_s);
            let words = Words::new(deploy.goal_gain.to_string(), expected, "lower it: steps would overleap the target");
            self.deploy_problem("goal_gain", words);
        }
        if deploy.range_m <= 2.0 * steps_m {
            let expected = format!("more than 4 speed_mps period_s = {}", 2.0 * steps_m);
            let advice = "raise it, or lower speed_mps or period_s: no link would outlast a step";
            self.deploy_problem("range_m", Words::new(deploy.range_m.to_string(), expected, advice));
        } else if deploy.robot_gap_m + steps_m > deploy.range_m {
            let expected = format!("at most range_m - 2 speed_mps period_s = {}", deploy.range_m - steps_m);
            let advice = "lower it: robots must know of each other before they come that near";
            self.deploy_problem("robot_gap_m", Words::new(deploy.robot_gap_m.to_string(), expected, advice));
        }
        let avoid_m = steps_m + deploy.epsilon_m;
        if deploy.avoid_m_min >= avoid_m {
            let expected = format!("less than d_a = 2 speed_mps period_s + epsilon_m = {avoid_m}");
            let words = Words::new(deploy.avoid_m_min.to_string(), expected, "lower it, or raise epsilon_m");
            self.deploy_problem("avoid_m_min", words);
        }
    }

    /// One kind: fast enough, and a point where only points can do what is asked.
    fn deploying_kind(&mut self, deploy: &Deploy, kind: &Kind) {
        let name = &kind.name;
        let speed_mps_max = kind.motion.speed_mps_max;
        if deploy.speed_mps > speed_mps_max {
            let expected = format!("at most motion.speed_mps_max of its kinds, {speed_mps_max} of {name:?}");
            self.deploy_problem("speed_mps", Words::new(deploy.speed_mps.to_string(), expected, "lower it"));
        }
        if kind.sim.motion == SimMotion::Point {
            return;
        }
        if deploy.mode == DeployMode::Literal {
            let found = format!("\"literal\" with {name:?}, a kind that is no point");
            let expected = "\"safe\"; the paper as printed is for simulated points (sim.motion = \"point\")";
            let advice = "set it to \"safe\": as printed, robots run into each other and into walls";
            self.deploy_problem("mode", Words::new(found, expected, advice));
        }
        if deploy.exchange == Exchange::Snapshot {
            let found = format!("\"snapshot\" with {name:?}, a kind that is no point");
            let expected = "\"beacons\"; snapshots are for simulated points (sim.motion = \"point\")";
            let advice = "set it to \"beacons\": a robot knows of others what it hears";
            self.deploy_problem("exchange", Words::new(found, expected, advice));
        }
    }

    /// The radio hears as far as links are to reach.
    pub(crate) fn deploy_radio(&mut self, deploy: &Deploy, radio: &Radio) {
        if deploy.exchange == Exchange::Beacons && deploy.range_m > radio.range_m {
            let expected = format!("at most radio.range_m, {}", radio.range_m);
            let advice = "lower it, or raise radio.range_m: nothing is heard from farther away";
            self.deploy_problem("range_m", Words::new(deploy.range_m.to_string(), expected, advice));
        }
    }

    /// A layout for `robots`: enough targets, apart from each other (`reach_m` for each body), one network.
    pub(crate) fn layout(&mut self, deploy: &Deploy, robots: usize, reach_m: f64) {
        let targets = &deploy.targets_m;
        if targets.len() < robots {
            let found = format!("{} targets", targets.len());
            let words = Words::new(found, format!("at least one for each of {robots} robots"), "add targets");
            self.report.push_path(self.root, self.layout_path(), words);
        }
        if deploy.assignment == Assignment::Hungarian && targets.len() > TARGETS_MAX {
            let found = format!("\"hungarian\" with {} targets", targets.len());
            let words = Words::new(found, format!("at most {TARGETS_MAX} targets"), "write assignment = \"given\"");
            self.deploy_problem("assignment", words);
        }
        self.targets_apart(targets, (deploy.robot_gap_m + 2.0 * reach_m).max(TARGET_GAP_M_MIN));
        if let Some(parted) = parted(targets, deploy.range_m) {
            let found = format!("{:.3} m to the nearest of those that links join to the first one", parted.gap_m);
            let expected = format!("a layout that links up to range_m = {} m join", deploy.range_m);
            self.target_problem(targets, parted.index, Words::new(found, expected, "move targets nearer together"));
        }
    }

    fn targets_apart(&mut self, targets: &[Point], apart_m: f64) {
        let mut near = Near::new(apart_m - TOUCH_M);
        for (index, target) in targets.iter().enumerate() {
            if near.has_room(*target) {
                near.add(*target);
                continue;
            }
            let gap_m = targets.iter().take(index).map(|other| distance(*target, *other)).fold(f64::INFINITY, f64::min);
            let expected = format!("at least {apart_m} m, robot_gap_m and both radii of bodies together");
            let words = Words::new(format!("{gap_m:.3} m to another target"), expected, "move them apart");
            return self.target_problem(targets, index, words);
        }
    }

    /// Every target clear of walls by `gap_m`.
    pub(crate) fn targets_clear(&mut self, deploy: &Deploy, gap_m: f64, walls: &Walls<'_>) {
        for (index, target) in deploy.targets_m.iter().enumerate() {
            let Some(wall) = walls.at(*target, gap_m - TOUCH_M) else { continue };
            let expected = format!("{gap_m} m of free floor around it: wall_gap_m, and a body's radius");
            let advice = "move it away from the wall, or lower wall_gap_m";
            self.target_problem(&deploy.targets_m, index, Words::new(wall, expected, advice));
            if self.layout_path() == LAYOUT {
                return; // one key stands for all of them: it is said once
            }
        }
    }

    /// The network of `robots` is one at the start, by links up to `range_m`, metres, which the file says as `key`.
    pub(crate) fn network(&mut self, (key, range_m): (&str, f64), robots: &[&RobotParts]) {
        // Who has no place has a problem of its own.
        let places: Option<Vec<Point>> =
            robots.iter().map(|robot| robot.start.map(|start| [start.x_m, start.y_m])).collect();
        let Some(parted) = places.and_then(|places| parted(&places, range_m)) else { return };
        let name = |index: usize| match robots.get(index).and_then(|robot| robot.id) {
            Some(id) => format!("robot {id}"),
            None => format!("robot[{index}]"),
        };
        let (first, nearest) = (name(0), name(parted.nearest));
        let found = format!(
            "a network that is parted at the start: {} is {:.3} m from {nearest}, the nearest that links join to \
             {first}",
            name(parted.index),
            parted.gap_m
        );
        let expected = format!("robots that links up to {key} = {} m join", (range_m * 1e3).round() / 1e3);
        let robot = robots.get(parted.index);
        let of_fleet = robot.is_some_and(|robot| robot.of_fleet);
        let (key, advice) = match of_fleet {
            true => ("region_m", "lower spacing_m, move region_m, or set linked_m of a random layout"),
            false => ("start", "move it nearer to the others"),
        };
        let path = robot.map(|robot| join(&robot.path, key)).unwrap_or_default();
        self.report.push_path(self.root, &path, Words::new(found, expected, advice));
    }

    /// Of more targets than robots, those that somebody goes to are one network.
    pub(crate) fn assigned(&mut self, swarm: &Swarm) {
        let Behaviour::Deploy(deploy) = &swarm.behaviour else { return };
        let used = deploy.targets_m.get(..swarm.robots.len()).unwrap_or_default();
        let Some(parted) = parted(used, deploy.range_m) else { return };
        let [x_m, y_m] = used[parted.index];
        let found = format!(
            "more targets than robots, of which those that are gone to are parted: [{x_m}, {y_m}] is {:.3} m from the \
             nearest of the others",
            parted.gap_m
        );
        let expected =
            format!("targets for {} robots that links up to range_m = {} m join", used.len(), deploy.range_m);
        let words = Words::new(found, expected, "leave targets out until there is one for each robot");
        self.report.push_path(self.root, self.layout_path(), words);
    }

    /// A robot's own file knows nothing of where its peers start.
    pub(crate) fn assigned_beforehand(&mut self, deploy: &Deploy) {
        if deploy.assignment == Assignment::Hungarian {
            let expected = "\"given\" in the file of one robot, which does not know where its peers start";
            let advice = "write assignment = \"given\", and targets_m in the order of the ids of all robots, as in the \
                          files beside a recording";
            self.deploy_problem("assignment", Words::new("\"hungarian\"", expected, advice));
        }
    }

    fn deploy_problem(&mut self, key: &str, words: Words) {
        self.report.push_path(self.root, &join("behaviour", key), words);
    }

    /// The key that gives the targets.
    fn layout_path(&self) -> &'static str {
        if self.root.has(LAYOUT) { LAYOUT } else { TARGETS }
    }

    /// A problem with one of the targets.
    fn target_problem(&mut self, targets: &[Point], index: usize, mut words: Words) {
        let [x_m, y_m] = targets[index];
        words.found = format!("[{x_m}, {y_m}], {}", words.found);
        let path = match self.layout_path() {
            TARGETS => format!("{TARGETS}[{index}]"),
            layout => layout.to_owned(),
        };
        self.report.push_path(self.root, &path, words);
    }
}

const LAYOUT: &str = "behaviour.layout";
const TARGETS: &str = "behaviour.targets_m";
