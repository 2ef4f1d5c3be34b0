//! What a robot's loop tells: views while it runs, a report at its end. Programs read them as JSON, people as lines.

use crate::adapter::LinkCounters;
use crate::robot_loop::RobotLoop;
use drover_contract::{Battery, Pose, Stamp};
use drover_core::Status;
use serde::{Deserialize, Serialize};
use std::any::Any;
use std::collections::BTreeMap;
use std::fmt;
use std::time::Duration;

/// One robot at one moment.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct View {
    /// Its id.
    pub id: u32,
    /// How far its drive is on the way to obeying.
    pub link: String,
    /// What it is doing, in one word.
    pub state: String,
    /// Why it does not do more, or what it waits for.
    pub reason: String,
    /// Where it believes to be.
    pub pose_wb: Option<Pose>,
    /// It is within this distance of there, metres, as far as it knows.
    pub pos_bound_m: f64,
    /// Measured speed along its heading, m/s.
    pub speed_mps: f64,
    /// The nearest thing its lidar sees, metres from its centre.
    pub nearest_m: Option<f64>,
    /// Age of its newest scan, ms.
    pub scan_age_ms: Option<u64>,
    /// How much of its task is done, 0..=1.
    pub progress: f64,
    /// Whether it says that its task is done.
    pub reached: bool,
    /// Peers it hears.
    pub peers_heard: usize,
    /// Its supply, as last heard.
    pub battery: Option<Battery>,
    /// Ticks of its node.
    pub ticks: u64,
    /// Requests that its supervisor changed, by reason.
    pub commands_changed: BTreeMap<String, u64>,
    /// Commands replaced by STOP because they had grown too old before they could be sent.
    pub withheld_commands: u64,
    /// Commands that were too old when they had left.
    pub aged_commands: u64,
    /// Messages on the beacon plane that were refused.
    pub beacons_refused: u64,
    /// What its links have been through.
    pub links: LinkCounters,
}

impl View {
    /// The heading of the table whose rows are views.
    pub const HEADER: &'static str = " robot  link          state    speed      nearest   scan age  done   reason";

    /// The robot of `robot` as of now.
    #[must_use]
    pub fn of(robot: &RobotLoop, now: Stamp) -> Self {
        let status = robot.status();
        let millis = |age: Duration| u64::try_from(age.as_millis()).unwrap_or(u64::MAX);
        // Ages grow between ticks, too: a loop that hangs must not show a fresh scan.
        let since_tick = now.since(status.stamp);
        let changed = &status.counters.changed;
        Self {
            id: robot.file().robot.id,
            link: status.drive.to_string(),
            state: status.state.word().into(),
            reason: status.verdict.to_string(),
            pose_wb: Some(status.pose_wb).filter(|pose| pose.is_finite()),
            pos_bound_m: status.pos_bound_m,
            speed_mps: status.twist_b.speed_mps,
            nearest_m: status.nearest_m,
            scan_age_ms: status.scan_age.map(|age| millis(age + since_tick)),
            progress: status.progress,
            reached: status.reached,
            peers_heard: status.peers_heard,
            battery: status.battery,
            ticks: status.counters.ticks,
            commands_changed: changed.iter().map(|(reason, count)| ((*reason).to_owned(), *count)).collect(),
            withheld_commands: robot.withheld_commands(),
            aged_commands: robot.aged_commands(),
            beacons_refused: refused(robot, status),
            links: robot.links().clone(),
        }
    }
}

fn refused(robot: &RobotLoop, status: &Status) -> u64 {
    robot.beacons_refused() + status.counters.beacons_refused
}

impl fmt::Display for View {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let nearest = self.nearest_m.map_or_else(|| "-".into(), |nearest_m| format!("{nearest_m:.2} m"));
        let scan = self.scan_age_ms.map_or_else(|| "none".into(), |age_ms| format!("{age_ms} ms"));
        let link: String = self.link.chars().take(12).collect();
        write!(
            f,
            "{:>6}  {link:<12}  {:<7}  {:>5.2} m/s  {nearest:>7}  {scan:>8}  {:>3.0} %  {}",
            self.id,
            self.state,
            self.speed_mps,
            self.progress * 100.0,
            self.reason
        )
    }
}

/// How a robot's loop ended.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Report {
    /// Its id.
    pub id: u32,
    /// Whether it says that its task was done.
    pub reached: bool,
    /// Why it was stopped, in words.
    pub reason: String,
    /// Whether its drive's own odometry showed it standing after the stop.
    pub seen_stopped: bool,
    /// How often the guard had to stop it from outside.
    pub guard_stops: u64,
    /// What its loop panicked with, if it did.
    pub panic: Option<String>,
}

impl Report {
    /// The report of a loop that has ended.
    #[must_use]
    pub fn of(robot: &RobotLoop, guard_stops: u64) -> Self {
        let status = robot.status();
        Self {
            id: robot.file().robot.id,
            reached: robot.reached_before_end(),
            reason: status.verdict.to_string(),
            seen_stopped: robot.seen_stopped(),
            guard_stops,
            panic: None,
        }
    }

    /// The report of a loop that panicked; nobody has seen its robot stand.
    #[must_use]
    pub fn of_panic(robot: &RobotLoop, panic: &(dyn Any + Send)) -> Self {
        let words = panic.downcast_ref::<&str>().map(|words| (*words).to_owned());
        let words = words.or_else(|| panic.downcast_ref::<String>().cloned());
        Self {
            id: robot.file().robot.id,
            reached: false,
            reason: "its loop panicked".into(),
            seen_stopped: false,
            guard_stops: 0,
            panic: Some(words.unwrap_or_else(|| "no words".into())),
        }
    }
}

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let seen = if self.seen_stopped { "seen to stand" } else { "NOT seen to stand" };
        let reached = if self.reached { "reached" } else { "not reached" };
        write!(f, "robot {}: {reached}; {}; {seen}", self.id, self.reason)?;
        self.panic.as_ref().map_or(Ok(()), |panic| write!(f, "; panicked: {panic}"))
    }
}

/// One line that `drover run --json` prints.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Line {
    /// A view.
    View(Box<View>),
    /// The last line.
    Report(Box<Report>),
}
