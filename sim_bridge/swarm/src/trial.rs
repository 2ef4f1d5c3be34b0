//! One run of a swarm in virtual time, whatever stands between robots and world, and what is measured of it.

use crate::deployment::{DeployFigures, Deployment, is_of_points};
use crate::digest::Digest;
use crate::direct::DirectSwarm;
use crate::explore::{CellSwarm, ExploreFigures, SurveyFigures, Surveying};
use crate::flock::{FlockFigures, FlockSwarm};
use crate::measures::{Measures, Said};
use crate::points::PointSwarm;
use crate::rehearsal::VirtualSwarm;
use crate::summary::end_of;
use drover_config::{Behaviour, Deploy, Flock, Swarm};
use drover_contract::{Stamp, Vec2};
use drover_core::Status;
use drover_core::map::SharedMap;
use drover_io::OpenError;
use drover_record::Recorder;
use drover_robot::View;
use drover_world::{Arena, RadioTally};
use serde::Serialize;
use std::time::Duration;

/// How much of the way between a robot and its world is simulated.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Fidelity {
    /// Laws and supervisors on values: fast, and as many robots as there is memory.
    Direct,
    /// Every byte through the codecs and the virtual firmware, as on a real robot.
    Wire,
}

/// A swarm that moves in steps of virtual time.
pub trait Trial {
    /// The present moment.
    fn now(&self) -> Stamp;
    /// One step of the world.
    fn step(&mut self);
    /// The bodies and what is around them.
    fn arena(&self) -> &Arena;
    /// What robot `robot`'s node makes of it all; `None` if it is dead or not there.
    fn status(&self, robot: usize) -> Option<&Status>;
    /// What robot `robot` tells of itself; `None` if it is dead or not there.
    fn view(&self, robot: usize) -> Option<View>;
    /// The map that robot `robot` makes; `None` if it makes none, is dead or not there.
    fn map(&self, _robot: usize) -> Option<&SharedMap> {
        None
    }
    /// What happened on the air.
    fn radio(&self) -> RadioTally;
    /// Commands that were too old when they had left.
    fn aged_commands(&self) -> u64;
    /// Heap bytes held for robots and bodies; the place itself apart.
    fn bytes(&self) -> usize;
    /// What came out of an exploration so far; none for anything else.
    fn explored(&self) -> Option<ExploreFigures> {
        None
    }
    /// What the robots said to each other, bytes; 0 where beacons travel as values.
    fn messages_bytes(&self) -> u64 {
        0
    }
}

/// One run, in one flat object: numbers, truths and words, no time of day and nothing of the machine.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct TrialResult {
    /// Its seed.
    pub seed: u64,
    /// A hash of where every body was and how it moved, at every step.
    pub digest: String,
    /// Robots.
    pub robots: u64,
    /// Steps of the world.
    pub steps: u64,
    /// Whether every robot's body ended where it was to go; true for a behaviour without an end.
    pub reached: bool,
    /// Share of robots of which that is true.
    pub reached_fraction: f64,
    /// How long it ran, s.
    pub time_s: f64,
    /// Mean distance driven, metres.
    pub path_m_mean: f64,
    /// Smallest gap between two bodies, metres, 0 from a touch on; none for a single robot.
    pub min_gap_robot_m: Option<f64>,
    /// Smallest gap between a body and a wall, metres; none in a world without walls.
    pub min_gap_wall_m: Option<f64>,
    /// Robots that touched a wall or each other at least once.
    pub touched: u64,
    /// Ticks of all robots.
    pub ticks: u64,
    /// Commands that supervisors changed.
    pub commands_changed: u64,
    /// Commands that were too old when they had left.
    pub aged_commands: u64,
    /// Beacons that reached somebody, counted by receiver.
    pub beacons_carried: u64,
    /// Beacons that did not, within range, counted by receiver.
    pub beacons_lost: u64,
    /// Heap bytes held at the end, per robot; the place itself apart.
    pub bytes_per_robot: u64,
    /// Of a deployment: more numbers, beside the others.
    #[serde(flatten, skip_serializing_if = "Option::is_none")]
    pub deploy: Option<DeployFigures>,
    /// Of a flock: the same.
    #[serde(flatten, skip_serializing_if = "Option::is_none")]
    pub flock: Option<FlockFigures>,
    /// Of an exploration: the same.
    #[serde(flatten, skip_serializing_if = "Option::is_none")]
    pub explore: Option<ExploreFigures>,
    /// Of an exploration by bodies: the same.
    #[serde(flatten, skip_serializing_if = "Option::is_none")]
    pub survey: Option<SurveyFigures>,
}

/// What is looked at while a run goes on.
pub trait Watch {
    /// A step of the run has been made. Whether the run is to go on.
    fn stepped(&mut self, trial: &dyn Trial) -> bool;
}

impl<F: FnMut(&dyn Trial) -> bool> Watch for F {
    fn stepped(&mut self, trial: &dyn Trial) -> bool {
        self(trial)
    }
}

/// A swarm in virtual time; what its robots are given, decide and send goes to `recorder`, where they have links.
///
/// # Errors
/// [`OpenError`] if a robot's links do not fit its kind (wire only).
pub fn trial_of(swarm: &Swarm, fidelity: Fidelity, recorder: Option<&Recorder>) -> Result<Box<dyn Trial>, OpenError> {
    Ok(match (fidelity, recorder) {
        (Fidelity::Direct, _) => match &swarm.behaviour {
            Behaviour::Deploy(deploy) if is_of_points(swarm) => Box::new(PointSwarm::new(swarm, deploy)),
            Behaviour::Flock(flock) if is_of_points(swarm) => Box::new(FlockSwarm::new(swarm, flock)),
            Behaviour::Explore(explore) if is_of_points(swarm) => Box::new(CellSwarm::new(swarm, explore)),
            Behaviour::Deploy(_) | Behaviour::Flock(_) | Behaviour::Diffuse(_) | Behaviour::Explore(_) => {
                Box::new(DirectSwarm::new(swarm))
            }
        },
        (Fidelity::Wire, Some(recorder)) => Box::new(VirtualSwarm::recorded(swarm, recorder)?),
        (Fidelity::Wire, None) => Box::new(VirtualSwarm::unrecorded(swarm)?),
    })
}

/// Run `trial` of `swarm` until every robot says that it has reached its end, or until the swarm's duration is over;
/// `None` if `watch` ended it.
pub fn run_trial(swarm: &Swarm, trial: &mut dyn Trial, watch: &mut dyn Watch) -> Option<TrialResult> {
    let limit = Stamp::ZERO + Duration::from_secs_f64(swarm.duration_s);
    let mut digest = Digest::default();
    let mut measures = Measures::new(swarm, trial.arena());
    let mut surveying = Surveying::new(swarm, trial);
    let mut steps = 0;
    while trial.now() < limit && !all_reached(swarm, trial) {
        let before = trial.now();
        trial.step();
        steps += 1;
        digest.take_in(trial.arena());
        let times_s = (trial.now().as_secs_f64(), trial.now().since(before).as_secs_f64());
        measures.see(trial.arena(), |robot| trial.status(robot).map(Said::from), times_s);
        if let Some(surveying) = &mut surveying {
            surveying.see(trial, trial.now().as_secs_f64());
        }
        if !watch.stepped(trial) {
            return None;
        }
    }
    let result = TrialResult { steps, ..measure(swarm, trial, digest) };
    let said = |robot| trial.status(robot).map(Said::from);
    let flock = measures.flocking.map(|flocking| flocking.figures(trial.arena(), said));
    Some(match measures.deployment {
        Some(deployment) => with_deployment(result, trial, &deployment),
        None => {
            let result = with_exploration(TrialResult { flock, ..result }, trial.explored());
            with_survey(result, surveying.map(|surveying| surveying.figures(trial)))
        }
    })
}

/// What the swarm does, if it deploys.
pub(crate) fn deploys(swarm: &Swarm) -> Option<&Deploy> {
    match &swarm.behaviour {
        Behaviour::Deploy(deploy) => Some(deploy),
        Behaviour::Flock(_) | Behaviour::Diffuse(_) | Behaviour::Explore(_) => None,
    }
}

/// The same, if it flocks.
pub(crate) fn flocks(swarm: &Swarm) -> Option<&Flock> {
    match &swarm.behaviour {
        Behaviour::Flock(flock) => Some(flock),
        Behaviour::Deploy(_) | Behaviour::Diffuse(_) | Behaviour::Explore(_) => None,
    }
}

/// The result of a deployment: everybody has a place of their own to reach, and the dead reach none.
fn with_deployment(result: TrialResult, trial: &dyn Trial, deployment: &Deployment) -> TrialResult {
    let arena = trial.arena();
    let counted = (result.commands_changed, result.ticks);
    let figures = deployment.figures(arena, counted, trial.messages_bytes());
    let gaps_m = (result.min_gap_robot_m, result.min_gap_wall_m);
    let (min_gap_robot_m, min_gap_wall_m) = deployment.point_gaps_m().unwrap_or(gaps_m);
    let living = (0..arena.robot_count()).filter(|robot| trial.status(*robot).is_some());
    TrialResult {
        reached: living.clone().all(|robot| deployment.has_arrived(arena, robot)),
        reached_fraction: figures.arrived_fraction,
        touched: if deployment.point_gaps_m().is_some() { figures.tunnelled } else { result.touched },
        min_gap_robot_m,
        min_gap_wall_m,
        deploy: Some(figures),
        ..result
    }
}

/// The result of an exploration: its end is that nothing is left, wherever robots are then. A cell is free if its
/// middle is, so what is left of its walls' true outlines says nothing of where robots may be: only each other can be
/// touched.
fn with_exploration(result: TrialResult, explore: Option<ExploreFigures>) -> TrialResult {
    let Some(figures) = explore else { return result };
    let reached_fraction = f64::from(u8::from(figures.finished));
    let meet = result.min_gap_robot_m.is_some_and(|gap_m| gap_m <= 0.0);
    TrialResult {
        reached: figures.finished,
        reached_fraction,
        touched: if meet { result.touched } else { 0 },
        min_gap_wall_m: None,
        explore: Some(figures),
        ..result
    }
}

/// The same by bodies, whose walls are true.
fn with_survey(result: TrialResult, survey: Option<SurveyFigures>) -> TrialResult {
    let Some(figures) = survey else { return result };
    let reached_fraction = f64::from(u8::from(figures.finished));
    TrialResult { reached: figures.finished, reached_fraction, survey: Some(figures), ..result }
}

fn all_reached(swarm: &Swarm, trial: &dyn Trial) -> bool {
    let mut living = (0..swarm.robots.len()).filter_map(|robot| trial.status(robot)).peekable();
    living.peek().is_some() && living.all(|status| status.reached)
}

fn measure(swarm: &Swarm, trial: &dyn Trial, digest: Digest) -> TrialResult {
    let arena = trial.arena();
    let count = swarm.robots.len();
    let robots = || 0..count;
    let share = |number: usize| number as f64 / count.max(1) as f64;
    let there = |robot: &usize| {
        end_of(&swarm.behaviour, swarm.robots[*robot].id).is_none_or(|([x, y], within_m)| {
            (arena.state(*robot).pose_wb.position() - Vec2::new(x, y)).norm() <= within_m
        })
    };
    let reached = robots().filter(there).count();
    let touched = |robot: &usize| {
        let gaps_m = [arena.gap_robot_m_min(*robot), arena.gap_wall_m_min(*robot)];
        gaps_m.into_iter().flatten().any(|gap_m| gap_m <= 0.0)
    };
    let counters = || robots().filter_map(|robot| trial.status(robot)).map(|status| &status.counters);
    let radio = trial.radio();
    TrialResult {
        seed: swarm.seed,
        digest: digest.to_string(),
        robots: count as u64,
        steps: 0,
        reached: reached == count,
        reached_fraction: share(reached),
        time_s: trial.now().as_secs_f64(),
        path_m_mean: robots().map(|robot| arena.path_m(robot)).sum::<f64>() / count.max(1) as f64,
        min_gap_robot_m: arena.min_gap_robot_m(),
        min_gap_wall_m: arena.min_gap_wall_m(),
        touched: robots().filter(touched).count() as u64,
        ticks: counters().map(|counters| counters.ticks).sum(),
        commands_changed: counters().map(drover_core::Counters::changed_total).sum(),
        aged_commands: trial.aged_commands(),
        beacons_carried: radio.carried,
        beacons_lost: radio.lost + radio.crowded + radio.partitioned + radio.dropped,
        bytes_per_robot: (trial.bytes() / count.max(1)) as u64,
        deploy: None,
        flock: None,
        explore: None,
        survey: None,
    }
}
