//! A robot kind: what many robots of one build share.

use serde::Serialize;

/// A robot kind: body, drive, lidar, limits and timeouts. One file in `config/robots/` each.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Kind {
    /// The kind's name, as swarm files say it.
    pub name: String,
    /// The body.
    pub body: Body,
    /// How the drive is spoken to.
    pub drive: Drive,
    /// What it may be asked to do at most.
    pub motion: Motion,
    /// The range sensor.
    pub lidar: Lidar,
    /// How long anything may be late or silent.
    pub timeouts: Timeouts,
    /// What the simulator needs to know beyond that. The field never reads it.
    pub sim: Sim,
}

impl Kind {
    /// How far from its centre a body at its top speed must see an obstacle to stop short of it, metres:
    /// `v^2 / (2 brake) + v (scan_ms + tick_ms + command_age_ms) + margin_m + radius_m`. Never more than
    /// `lidar.range_m_max` in a configuration that was read.
    #[must_use]
    pub fn stopping_distance_m(&self) -> f64 {
        let speed_mps = self.motion.speed_mps_max.max(self.motion.reverse_mps_max);
        let waits = [self.timeouts.scan_ms, self.timeouts.tick_ms, self.timeouts.command_age_ms];
        let reaction_s = waits.map(f64::from).iter().sum::<f64>() / 1_000.0;
        let braking_m = speed_mps * speed_mps / (2.0 * self.motion.brake_mps2);
        braking_m + speed_mps * reaction_s + self.motion.margin_m + self.body.radius_m
    }
}

/// The body, around the point between the wheels.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Body {
    /// Radius of the disc that holds the whole body, metres, 0.005..=5. Robots know themselves and each other as discs.
    pub radius_m: f64,
    /// Distance between left and right wheels, metres, 0.005..=5 (what the drive's own odometry assumes).
    pub track_m: f64,
    /// Corners of the convex outline that the simulated body really has, body frame, metres, counter-clockwise, within
    /// the disc; empty: the disc itself.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub footprint_m: Vec<[f64; 2]>,
}

/// How the drive is spoken to.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(tag = "protocol", rename_all = "snake_case")]
pub enum Drive {
    /// A rover autopilot (ArduPilot Rover's dialect of MAVLink 2).
    Mavlink {
        /// The autopilot's system id is the robot's id; ours on that link is this component (191: onboard computer).
        component: u8,
        /// How often odometry is asked for, Hz, 1..=40 (ArduPilot refuses more at its default loop rate).
        telemetry_hz: u32,
    },
    /// An AgileX chassis, protocol v2.
    AgilexV2 {
        /// Which chassis: mode and error tables differ.
        model: AgilexModel,
    },
}

/// AgileX chassis whose tables are known.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum AgilexModel {
    /// Scout 2.0.
    Scout,
    /// Scout Mini.
    ScoutMini,
    /// Tracer.
    Tracer,
    /// Hunter (Ackermann; listed for its tables).
    Hunter,
    /// Bunker.
    Bunker,
}

/// What the body may be asked to do at most.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Motion {
    /// Fastest forward, m/s, 0.01..=10.
    pub speed_mps_max: f64,
    /// Fastest backwards, m/s, 0..=10.
    pub reverse_mps_max: f64,
    /// Fastest turn, rad/s, 0.01..=200.
    pub yaw_rate_radps_max: f64,
    /// Strongest speeding up, m/s^2, 0.01..=20.
    pub accel_mps2_max: f64,
    /// Braking that the body is sure to reach, m/s^2, 0.01..=20.
    pub brake_mps2: f64,
    /// Strongest change of turn, rad/s^2, 0.01..=10000.
    pub yaw_accel_radps2_max: f64,
    /// Gap to anything that the supervisor keeps, metres, 0.001..=5.
    pub margin_m: f64,
}

/// The range sensor.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Lidar {
    /// How it is spoken to.
    pub link: LidarLink,
    /// Beams (or sectors) of a full turn, 8..=3600 (72 at most over OBSTACLE_DISTANCE).
    pub beams: u32,
    /// Nearer than this it cannot measure, metres, >= 0.
    pub range_m_min: f64,
    /// Farther than this it cannot measure, metres, > range_m_min.
    pub range_m_max: f64,
    /// Scans per second, 1..=50.
    pub rate_hz: f64,
    /// Field of view, radians, in (0, 2 pi], about the sensor's forward direction. What lies outside is never seen.
    pub fov_rad: f64,
    /// Where the sensor sits.
    pub mount: Mount,
}

/// Where a sensor sits: its frame in the body frame.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Mount {
    /// Forward of the point between the wheels, metres.
    pub x_m: f64,
    /// To the left of it, metres.
    pub y_m: f64,
    /// How its forward direction is turned from the body's, radians, counter-clockwise.
    pub yaw_rad: f64,
}

/// How a range sensor is spoken to.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(tag = "protocol", rename_all = "snake_case")]
pub enum LidarLink {
    /// OBSTACLE_DISTANCE from a lidar bridge on the autopilot's link.
    ObstacleDistance {
        /// The bridge's MAVLink component id (196: obstacle avoidance).
        component: u8,
    },
    /// A DroneCAN node that sends Proximity, a message a sector.
    Dronecan {
        /// The node's id, 1..=127.
        node: u8,
        /// Whether the node says nothing about a sector without an obstacle (AP_Periph does so). If true, a silent
        /// sector counts as clear as long as NodeStatus is fresh and healthy; if false it is unknown.
        silent_is_clear: bool,
    },
}

/// How long anything may be late or silent before the robot stops. No timeout can be 0: absent means stop.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct Timeouts {
    /// The robot's tick, ms, 5..=200.
    pub tick_ms: u32,
    /// A scan older than this stops the robot, ms, 20..=2000.
    pub scan_ms: u32,
    /// Odometry or pose older than this stops the robot, ms, 20..=2000.
    pub odometry_ms: u32,
    /// A drive that is silent for longer than this is lost, ms, 100..=5000.
    pub link_ms: u32,
    /// A command older than this is never sent, ms, 10..=1000.
    pub command_age_ms: u32,
    /// A peer's beacon older than this is no longer followed, ms, 100..=5000.
    pub peer_ms: u32,
    /// A robot that is not driving this long after start says why, s, 1..=300.
    pub bringup_s: u32,
}

/// What the simulator needs to know of a kind.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Sim {
    /// Standard deviation of each wheel's slip, as a share of its speed, 0..=0.5.
    pub slip_std: f64,
    /// Standard deviation of a range, metres, 0..=1.
    pub range_noise_m: f64,
    /// Share of beams without a reading, 0..=1.
    pub beam_dropout: f64,
    /// From power-on until the autopilot can be armed, s, 0..=120 (a real one takes about 40 for its GPS).
    pub prearm_s: f64,
    /// Ranges come in steps of this, metres, 0..=1; 0: none.
    pub range_step_m: f64,
    /// Whether a scan takes the whole time up to the next one, so that the body moves while it is taken; else it is
    /// taken in an instant.
    pub scan_sweep: bool,
    /// How the simulated body moves.
    pub motion: SimMotion,
}

/// How a simulated body moves.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum SimMotion {
    /// On two wheels that speed up, brake and slip.
    #[default]
    DiffDrive,
    /// A point of the theory books: whatever speed and turn it is asked for within its limits, it has at once.
    Point,
}
