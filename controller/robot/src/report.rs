//! What a robot's loop tells: views while it runs, a report at its end. Programs read them as JSON, people as lines.

use crate::adapter::LinkCounters;
use crate::map_files::MapFiles;
use crate::robot_loop::RobotLoop;
use drover_contract::{Battery, Beam, Pose, Scan, Stamp, Twist};
use drover_core::{HeardPeer, Status};
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
    /// Measured turn, rad/s.
    pub yaw_rate_radps: f64,
    /// What its law asked for in the newest tick, limited, body frame; none if it asked for nothing.
    pub request_b: Option<Twist>,
    /// The command of the newest tick, body frame.
    pub command_b: Twist,
    /// Why that command is not what was asked for; none if it is.
    pub changed: Option<String>,
    /// Where it is heading for, world frame, metres.
    pub target_m: Option<[f64; 2]>,
    /// The nearest thing its lidar sees, metres from its centre.
    pub nearest_m: Option<f64>,
    /// Age of its newest scan, ms.
    pub scan_age_ms: Option<u64>,
    /// Age of its newest odometry, ms: its drive's link.
    pub odometry_age_ms: Option<u64>,
    /// To whom it gives way, standing aside on purpose.
    #[serde(default)]
    pub gives_way_to: Option<u32>,
    /// How much of its task is done, 0..=1.
    pub progress: f64,
    /// Whether it says that its task is done.
    pub reached: bool,
    /// Peers it hears.
    pub peers_heard: usize,
    /// Who they are.
    #[serde(default)]
    pub heard: Vec<HeardView>,
    /// Its newest scan.
    #[serde(default)]
    pub scan: Option<ScanView>,
    /// Its supply, as last heard.
    pub battery: Option<Battery>,
    /// Ticks of its node.
    pub ticks: u64,
    /// Requests that its supervisor changed, by reason.
    pub commands_changed: BTreeMap<String, u64>,
    /// How often it has begun to follow a wall.
    #[serde(default)]
    pub wall_entries: u64,
    /// Commands replaced by STOP because they had grown too old before they could be sent.
    pub withheld_commands: u64,
    /// Commands that were too old when they had left.
    pub aged_commands: u64,
    /// Messages on the beacon plane that were refused.
    pub beacons_refused: u64,
    /// Beacons taken, dropped as old, dropped as duplicates.
    pub beacons: [u64; 3],
    /// What its links have been through.
    pub links: LinkCounters,
}

/// A peer that a robot hears.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct HeardView {
    /// Whom.
    pub id: u32,
    /// Age of its newest beacon, ms.
    pub age_ms: u64,
    /// Whether the law relies on it.
    pub kept: bool,
}

impl From<HeardPeer> for HeardView {
    fn from(peer: HeardPeer) -> Self {
        Self { id: peer.id.0, age_ms: millis(peer.age), kept: peer.kept }
    }
}

/// A scan, as programs read it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ScanView {
    /// When the oldest of it was received, microseconds on the robot's clock.
    pub stamp_us: u64,
    /// Direction of the first beam, radians from the sensor's forward direction.
    pub angle_first_rad: f64,
    /// From one beam to the next, radians, counter-clockwise.
    pub angle_step_rad: f64,
    /// Farther than this it cannot measure, metres.
    pub range_m_max: f64,
    /// A range a beam, metres; -1: nothing up to the greatest range; none: no reading.
    pub ranges_m: Vec<Option<f64>>,
}

impl From<&Scan> for ScanView {
    fn from(scan: &Scan) -> Self {
        let range_m = |beam: &Beam| match beam {
            Beam::Hit(range_m) => Some(*range_m),
            Beam::Clear => Some(-1.0),
            Beam::Unknown => None,
        };
        Self {
            stamp_us: scan.stamp.as_micros(),
            angle_first_rad: scan.angle_first_rad,
            angle_step_rad: scan.angle_step_rad,
            range_m_max: scan.range_m_max,
            ranges_m: scan.beams.iter().map(range_m).collect(),
        }
    }
}

fn millis(span: Duration) -> u64 {
    u64::try_from(span.as_millis()).unwrap_or(u64::MAX)
}

impl View {
    /// The heading of the table whose rows are views.
    pub const HEADER: &'static str = " robot  link          state    speed      nearest   scan age  done   reason";

    /// The robot of `robot` as of now.
    #[must_use]
    pub fn of(robot: &RobotLoop, now: Stamp) -> Self {
        let status = robot.status();
        let heard = robot.heard(now).map(HeardView::from).collect();
        Self {
            heard,
            scan: robot.scan().map(ScanView::from),
            withheld_commands: robot.withheld_commands(),
            aged_commands: robot.aged_commands(),
            beacons_refused: robot.beacons_refused() + status.counters.beacons_refused,
            links: robot.links().clone(),
            ..Self::of_status(robot.file().robot.id, status, now)
        }
    }

    /// What a node alone can tell, without links, scan and peers.
    #[must_use]
    pub fn of_status(id: u32, status: &Status, now: Stamp) -> Self {
        // Ages grow between ticks, too: a loop that hangs must not show a fresh scan.
        let since_tick = now.since(status.stamp);
        let counters = &status.counters;
        let age_ms = |age: Option<Duration>| age.map(|age| millis(age + since_tick));
        Self {
            id,
            link: status.drive.to_string(),
            state: status.state.word().into(),
            reason: status.verdict.to_string(),
            pose_wb: Some(status.pose_wb).filter(|pose| pose.is_finite()),
            pos_bound_m: status.pos_bound_m,
            speed_mps: status.twist_b.speed_mps,
            yaw_rate_radps: status.twist_b.yaw_rate_radps,
            request_b: status.request,
            command_b: status.command.twist_b(),
            changed: status.changed.map(str::to_owned),
            target_m: status.target_w.map(|target| [target.x, target.y]),
            nearest_m: status.nearest_m,
            scan_age_ms: age_ms(status.scan_age),
            odometry_age_ms: age_ms(status.odometry_age),
            gives_way_to: status.gives_way_to.map(|id| id.0),
            progress: status.progress,
            reached: status.reached,
            peers_heard: status.peers_heard,
            heard: Vec::new(),
            scan: None,
            battery: status.battery,
            ticks: counters.ticks,
            commands_changed: counters.changed.iter().map(|(why, count)| ((*why).to_owned(), *count)).collect(),
            wall_entries: counters.wall_entries,
            withheld_commands: 0,
            aged_commands: 0,
            beacons_refused: counters.beacons_refused,
            beacons: [counters.beacons_taken, counters.beacons_old, counters.beacons_duplicate],
            links: LinkCounters::default(),
        }
    }
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
    /// The map that it made, if its behaviour makes one: for who has a folder for it.
    #[serde(skip)]
    pub map: Option<MapFiles>,
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
            map: robot.map().map(|map| MapFiles::of(robot.file().robot.id, map)),
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
            map: robot.map().map(|map| MapFiles::of(robot.file().robot.id, map)),
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
