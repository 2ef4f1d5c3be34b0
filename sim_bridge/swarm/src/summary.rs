//! What happened: the document that `drover up --json` prints.

use crate::deployment::DeployFigures;
use crate::flock::FlockFigures;
use crate::measures::{Measures, Said};
use drover_config::{Behaviour, Swarm};
use drover_contract::Vec2;
use drover_robot::{Report, View};
use drover_world::{Plant, Truth};
use serde::Serialize;
use std::collections::BTreeMap;

/// One run of a swarm.
#[derive(Clone, Debug, Serialize)]
pub struct Summary {
    /// The swarm's name.
    pub swarm: String,
    /// The seed of everything random.
    pub seed: u64,
    /// Whether every robot reached the end, by the simulator's truth.
    pub reached: bool,
    /// Why the run ended.
    pub ended: String,
    /// How long it ran, s, until the robots were told to end.
    pub time_s: f64,
    /// Simulated seconds per second of that: below 1, the simulator lagged.
    pub world_rate: f64,
    /// Smallest true gap between two bodies, surface to surface, metres; none for a single robot.
    pub min_gap_robot_m: Option<f64>,
    /// Smallest true gap between a body and a wall or obstacle, metres; none for a world without any.
    pub min_gap_wall_m: Option<f64>,
    /// Requests that the supervisors changed.
    pub commands_changed: u64,
    /// Commands that were older than `command_age_ms` when they had left.
    pub aged_commands: u64,
    /// Whether every robot was seen to stand still at the end, by the simulator's truth.
    pub stopped: bool,
    /// What stood for the CAN buses: `vcan` or `memory`.
    pub can: &'static str,
    /// The same in words.
    pub can_detail: String,
    /// Whether every robot was a process of its own.
    pub processes: bool,
    /// The recording; the resolved configuration and this summary lie beside it.
    pub recording: Option<String>,
    /// What a recorder had to drop.
    pub recording_dropped: u64,
    /// Why the recording ended before the run did; none if it did not.
    pub recording_failed: Option<String>,
    /// Of a deployment: more numbers, beside the others; looked at every 50 ms.
    #[serde(flatten, skip_serializing_if = "Option::is_none")]
    pub deploy: Option<DeployFigures>,
    /// Of a flock: the same.
    #[serde(flatten, skip_serializing_if = "Option::is_none")]
    pub flock: Option<FlockFigures>,
    /// The robots, in the file's order.
    pub robots: Vec<RobotSummary>,
}

/// One robot of a run.
#[derive(Clone, Debug, Serialize)]
pub struct RobotSummary {
    /// Its id.
    pub id: u32,
    /// Its kind.
    pub kind: String,
    /// Whether its body ended within `arrive_radius_m` of its leader's last point, by the simulator's truth; true for a
    /// behaviour without an end.
    pub reached: bool,
    /// When it first said so itself, s since the start.
    pub reached_s: Option<f64>,
    /// What it was doing when it was told to end.
    pub state: String,
    /// Why, in words.
    pub reason: String,
    /// Distance driven by the body, metres.
    pub path_m: f64,
    /// From its leader's last point at the end, metres; none for a behaviour without an end.
    pub end_distance_m: Option<f64>,
    /// From where it believed to be at the end to where it was, metres.
    pub pose_error_m: Option<f64>,
    /// The distance it believed to be within, metres.
    pub pos_bound_m: Option<f64>,
    /// Smallest true gap to another body, metres.
    pub min_gap_robot_m: Option<f64>,
    /// Smallest true gap to a wall, metres.
    pub min_gap_wall_m: Option<f64>,
    /// Ticks of its node.
    pub ticks: u64,
    /// Requests that its supervisor changed, by reason.
    pub commands_changed: BTreeMap<String, u64>,
    /// Commands that were older than `command_age_ms` when they had left.
    pub aged_commands: u64,
    /// Whether its body stood still at the end, by the simulator's truth.
    pub stopped: bool,
    /// What its loop said of its own end; none if it never answered (a killed process).
    pub report: Option<Report>,
}

/// What is gathered of one robot while a run goes on.
#[derive(Clone, Debug, Default)]
pub struct Tally {
    /// The newest view.
    pub view: Option<View>,
    /// When it first said that it had reached the end, s.
    pub reached_s: Option<f64>,
    /// What it was doing, and why, when it was told to end.
    pub at_end: Option<(String, String)>,
    /// Its last words.
    pub report: Option<Report>,
}

impl Tally {
    /// Take in the newest view, `time_s` into the run.
    pub fn see(&mut self, view: View, time_s: f64) {
        if view.reached && self.reached_s.is_none() {
            self.reached_s = Some(time_s);
        }
        self.view = Some(view);
    }

    /// What it said last; nothing yet is what a robot says that has only begun.
    pub(crate) fn said(&self) -> Said {
        self.view.as_ref().map(Said::from).unwrap_or_default()
    }

    /// The same at the end: `None` if it died, which is to end without a report, or with a panic.
    pub(crate) fn last_said(&self) -> Option<Said> {
        self.report.as_ref().filter(|report| report.panic.is_none()).map(|_| self.said())
    }

    /// The robots are about to be told to end: what they do now is what the summary says.
    pub fn note_end(&mut self) {
        self.at_end = self.view.as_ref().map(|view| (view.state.clone(), view.reason.clone()));
    }
}

/// Where robot `id` is to end, and the distance that counts as there; none for a behaviour without an end.
pub(crate) fn end_of(behaviour: &Behaviour, id: u32) -> Option<([f64; 2], f64)> {
    match behaviour {
        Behaviour::Flock(flock) => {
            let end_m = flock.party_of(id)?.end_m();
            Some((end_m, flock.arrive_radius_m.max(flock.waypoint_radius_m)))
        }
        // A deployment is measured by who is at which target, an exploration by what is known.
        Behaviour::Diffuse(_) | Behaviour::Deploy(_) | Behaviour::Explore(_) => None,
    }
}

/// Summarise one robot.
pub(crate) fn robot_summary(swarm: &Swarm, index: usize, plant: &Plant, tally: &Tally) -> RobotSummary {
    /// Slower than this the body stands, m/s and rad/s.
    const STANDSTILL: f64 = 0.01;
    let robot = &swarm.robots[index];
    let truth: Truth = plant.truth(index);
    let end = end_of(&swarm.behaviour, robot.id);
    let end_distance_m = end.map(|([x, y], _)| (truth.pose_wb.position() - Vec2::new(x, y)).norm());
    let view = tally.view.as_ref();
    // Where an exploration ends is nobody's to say beforehand: its end is the robot's certificate.
    let certified = view.is_some_and(|view| view.reached) || !matches!(swarm.behaviour, Behaviour::Explore(_));
    let unheard = || ("never heard".to_owned(), "its loop never spoke".to_owned());
    let (state, reason) = tally.at_end.clone().unwrap_or_else(unheard);
    let believed = view.and_then(|view| view.pose_wb);
    RobotSummary {
        id: robot.id,
        kind: robot.kind.clone(),
        reached: certified && end_distance_m.zip(end).is_none_or(|(gap_m, (_, arrive_m))| gap_m <= arrive_m),
        reached_s: tally.reached_s,
        state,
        reason,
        path_m: truth.path_m,
        end_distance_m,
        pose_error_m: believed.map(|pose| (pose.position() - truth.pose_wb.position()).norm()),
        pos_bound_m: view.map(|view| view.pos_bound_m),
        min_gap_robot_m: truth.gap_robot_m_min,
        min_gap_wall_m: truth.gap_wall_m_min,
        ticks: view.map_or(0, |view| view.ticks),
        commands_changed: view.map(|view| view.commands_changed.clone()).unwrap_or_default(),
        aged_commands: view.map_or(0, |view| view.aged_commands),
        stopped: truth.twist_b.speed_mps.abs() < STANDSTILL && truth.twist_b.yaw_rate_radps.abs() < STANDSTILL,
        report: tally.report.clone(),
    }
}

/// What the whole run adds to its robots' summaries.
pub(crate) struct RunFacts {
    pub(crate) ended: String,
    pub(crate) time_s: f64,
    pub(crate) world_rate: f64,
    pub(crate) can: &'static str,
    pub(crate) can_detail: String,
    pub(crate) processes: bool,
    pub(crate) recording: Option<String>,
    pub(crate) recording_dropped: u64,
    pub(crate) recording_failed: Option<String>,
}

/// Summarise a run.
pub(crate) fn summarise(
    swarm: &Swarm,
    plant: &Plant,
    (tallies, measures): (&[Tally], &Measures),
    facts: RunFacts,
) -> Summary {
    let deployment = measures.deployment.as_ref();
    let robot = |(index, tally): (usize, &Tally)| {
        let robot = robot_summary(swarm, index, plant, tally);
        // Everybody has a place of their own to be at.
        let there = deployment.map(|deployment| deployment.has_arrived(plant.arena(), index));
        RobotSummary { reached: there.unwrap_or(robot.reached), ..robot }
    };
    let robots: Vec<RobotSummary> = tallies.iter().enumerate().map(robot).collect();
    let changed = || robots.iter().flat_map(|robot| robot.commands_changed.values()).sum();
    let ticks = robots.iter().map(|robot| robot.ticks).sum();
    let deploy = deployment.map(|deployment| deployment.figures(plant.arena(), (changed(), ticks), 0));
    let said = |robot: usize| tallies[robot].last_said();
    let flock = measures.flocking.as_ref().map(|flocking| flocking.figures(plant.arena(), said));
    let smallest = |gap: fn(&RobotSummary) -> Option<f64>| robots.iter().filter_map(gap).min_by(f64::total_cmp);
    Summary {
        swarm: swarm.name.clone(),
        seed: swarm.seed,
        reached: robots.iter().all(|robot| robot.reached),
        ended: facts.ended,
        time_s: facts.time_s,
        world_rate: facts.world_rate,
        min_gap_robot_m: smallest(|robot| robot.min_gap_robot_m),
        min_gap_wall_m: smallest(|robot| robot.min_gap_wall_m),
        commands_changed: changed(),
        aged_commands: robots.iter().map(|robot| robot.aged_commands).sum(),
        stopped: robots.iter().all(|robot| robot.stopped),
        can: facts.can,
        can_detail: facts.can_detail,
        processes: facts.processes,
        recording: facts.recording,
        recording_dropped: facts.recording_dropped,
        recording_failed: facts.recording_failed,
        deploy,
        flock,
        robots,
    }
}
