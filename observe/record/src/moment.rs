//! A swarm at one moment: what the live view shows, what a recording holds and what pictures are made of.
//!
//! Frames: positions and headings in the world frame (ENU, metres, radians counter-clockwise), velocities in the body
//! frame. Every number is rounded to a ten-thousandth when it is written as text: nobody looks closer, and it keeps the
//! text short. What is not known is `null`, never 0.

use serde::{Deserialize, Serialize, Serializer};

/// A swarm at one moment.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Moment {
    /// Seconds since the run began, on the swarm's own clock.
    #[serde(serialize_with = "short")]
    pub time_s: f64,
    /// How the run is going.
    pub run: RunState,
    /// The robots, in the setting's order.
    pub robots: Vec<RobotMoment>,
    /// Where the place's movers are, in the setting's order, metres; empty in the field, and where nobody told.
    #[serde(default, skip_serializing_if = "Vec::is_empty", serialize_with = "short_points")]
    pub movers_m: Vec<[f64; 2]>,
    /// Smallest gap between two bodies so far, metres, by the simulator's truth; `None`: one robot, or in the field.
    #[serde(serialize_with = "short_option")]
    pub min_gap_robot_m: Option<f64>,
    /// Smallest gap between a body and a wall so far, metres, by the simulator's truth.
    #[serde(serialize_with = "short_option")]
    pub min_gap_wall_m: Option<f64>,
}

/// How a run is going.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct RunState {
    /// In one word.
    pub phase: Phase,
    /// Simulated (or replayed) seconds per second: 1 in the field, 0 while it is paused.
    #[serde(serialize_with = "short")]
    pub rate: f64,
    /// What happened last, in words for people: "stopped from the live view", "every robot reached the end".
    pub words: String,
    /// What has become of the stop that was asked for; `None` if none was.
    pub stop: Option<StopState>,
}

/// How a run is going, in one word.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Phase {
    /// Time goes on.
    #[default]
    Running,
    /// Time stands still.
    Paused,
    /// A stop was asked for, and not every robot has been seen to obey.
    Stopping,
    /// A stop was asked for, and every robot stands, latched.
    Stopped,
    /// It is over.
    Ended,
}

/// What has become of a stop.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct StopState {
    /// When it was asked for, s on the swarm's clock.
    #[serde(serialize_with = "short")]
    pub asked_s: f64,
    /// Robots that are latched: their supervisors answer STOP until they start anew.
    pub latched: usize,
    /// Robots that were seen to stand: by the simulator's truth, in the field by their own odometry.
    pub standing: usize,
    /// When the last of them stood, s; `None` while one still moves.
    #[serde(serialize_with = "short_option")]
    pub all_standing_s: Option<f64>,
}

/// One robot at one moment.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct RobotMoment {
    /// Its id.
    pub id: u32,
    /// What it is doing, in one word: waiting, active, held, done, stopped; "dead" if nothing was heard of it for long.
    pub state: String,
    /// Why it does not do more, or what it waits for: its supervisor's verdict in words.
    pub reason: String,
    /// Why its newest command is not what its law asked for; `None` if it is.
    pub changed: Option<String>,
    /// How far its drive is on the way to obeying: "ready", "silent", "arming", "refused: ...".
    pub link: String,
    /// Where its body is, by the simulator's truth; `None` in the field.
    pub truth: Option<Truth>,
    /// Where it believes to be.
    pub believed: Option<Place>,
    /// It is within this distance of there, metres, as far as it knows.
    #[serde(serialize_with = "short")]
    pub pos_bound_m: f64,
    /// Measured velocity, m/s and rad/s.
    #[serde(serialize_with = "short_pair")]
    pub twist_b: [f64; 2],
    /// The newest command, m/s and rad/s.
    #[serde(serialize_with = "short_pair")]
    pub command_b: [f64; 2],
    /// What the law asked for, limited, m/s and rad/s; `None` if it asked for nothing.
    #[serde(serialize_with = "short_pair_option")]
    pub request_b: Option<[f64; 2]>,
    /// Where it is heading for, metres; `None` for a law without a place to go.
    #[serde(serialize_with = "short_pair_option")]
    pub target_w: Option<[f64; 2]>,
    /// The nearest thing its lidar sees, metres from its centre.
    #[serde(serialize_with = "short_option")]
    pub nearest_m: Option<f64>,
    /// Age of its newest scan, ms.
    pub scan_age_ms: Option<u64>,
    /// Age of its newest odometry, ms: the drive's link.
    pub link_age_ms: Option<u64>,
    /// How much of its task is done, 0..=1.
    #[serde(serialize_with = "short")]
    pub progress: f64,
    /// Whether it says that its task is done.
    pub reached: bool,
    /// Share of its battery's charge that is left, 0..=1.
    #[serde(serialize_with = "short_option")]
    pub charge: Option<f64>,
    /// Peers that it hears.
    pub heard: Vec<Heard>,
    /// Its newest scan.
    pub scan: Option<ScanMoment>,
}

impl RobotMoment {
    /// Where it is, as well as anybody knows: the truth in simulation, its own belief in the field.
    #[must_use]
    pub fn place(&self) -> Option<Place> {
        self.truth.as_ref().map(|truth| truth.place).or(self.believed)
    }
}

/// A position and a heading in the world frame.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Place {
    /// East, metres.
    #[serde(serialize_with = "short")]
    pub x_m: f64,
    /// North, metres.
    #[serde(serialize_with = "short")]
    pub y_m: f64,
    /// Heading, radians, counter-clockwise from east.
    #[serde(serialize_with = "short")]
    pub yaw_rad: f64,
}

/// A body in the simulator.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Truth {
    /// Where it is.
    #[serde(flatten)]
    pub place: Place,
    /// Its velocity, m/s and rad/s.
    #[serde(serialize_with = "short_pair")]
    pub twist_b: [f64; 2],
    /// Whether it touches something.
    pub in_contact: bool,
}

/// A peer that a robot hears.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Heard {
    /// Whom.
    pub id: u32,
    /// How old the newest beacon is, ms.
    pub age_ms: u64,
    /// Whether the law relies on this link: it follows, or keeps, that peer.
    pub kept: bool,
}

/// A scan, in the body frame about the robot's believed place.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ScanMoment {
    /// When it was taken, s since the run began: a scan with the same time is the same scan.
    #[serde(serialize_with = "short")]
    pub time_s: f64,
    /// Direction of the first beam, radians from the sensor's forward direction.
    #[serde(serialize_with = "short")]
    pub angle_first_rad: f64,
    /// From one beam to the next, radians, counter-clockwise.
    pub angle_step_rad: f64,
    /// Farther than this it cannot measure, metres.
    #[serde(serialize_with = "short")]
    pub range_m_max: f64,
    /// A range a beam, metres; -1: nothing up to the greatest range; `null`: no reading.
    #[serde(serialize_with = "short_list")]
    pub ranges_m: Vec<Option<f64>>,
}

/// What `ranges_m` says of a beam that met nothing.
pub const CLEAR: f64 = -1.0;

fn rounded(value: f64) -> f64 {
    (value * 1e4).round() / 1e4
}

fn short<S: Serializer>(value: &f64, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.serialize_f64(rounded(*value))
}

fn short_option<S: Serializer>(value: &Option<f64>, serializer: S) -> Result<S::Ok, S::Error> {
    value.map(rounded).serialize(serializer)
}

fn short_pair<S: Serializer>(value: &[f64; 2], serializer: S) -> Result<S::Ok, S::Error> {
    value.map(rounded).serialize(serializer)
}

fn short_pair_option<S: Serializer>(value: &Option<[f64; 2]>, serializer: S) -> Result<S::Ok, S::Error> {
    value.map(|pair| pair.map(rounded)).serialize(serializer)
}

pub(crate) fn short_points<S: Serializer>(points: &[[f64; 2]], serializer: S) -> Result<S::Ok, S::Error> {
    serializer.collect_seq(points.iter().map(|point| point.map(rounded)))
}

fn short_list<S: Serializer>(values: &[Option<f64>], serializer: S) -> Result<S::Ok, S::Error> {
    serializer.collect_seq(values.iter().map(|value| value.map(rounded)))
}
