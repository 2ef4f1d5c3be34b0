//! What Foxglove has no message for: what a robot is at, decides, hears and puts on the wire.
//!
//! Positions and headings are in the world frame, metres and radians; velocities in the body frame, m/s and rad/s.

use super::message::message;

message! {
    /// A robot at one moment, about ten times a second. It is flat, so that any field can be plotted; what is not known
    /// is absent, never 0.
    State {
        /// Seconds since the run began, on the swarm's own clock.
        [double] time_s: f64 = 1,
        /// The robot's id.
        [uint32] id: u32 = 2,
        /// What it is doing, in one word.
        [string] state: String = 3,
        /// Why it does not do more, or what it waits for.
        [string] reason: String = 4,
        /// Why its newest command is not what its law asked for.
        [string optional] changed: Option<String> = 5,
        /// How far its drive is on the way to obeying.
        [string] link: String = 6,
        /// Where it believes to be: east, metres.
        [double optional] x_m: Option<f64> = 7,
        /// Where it believes to be: north, metres.
        [double optional] y_m: Option<f64> = 8,
        /// Its heading as believed, radians, counter-clockwise from east.
        [double optional] yaw_rad: Option<f64> = 9,
        /// It is within this distance of there, metres, as far as it knows.
        [double] pos_bound_m: f64 = 10,
        /// Where its body is, in simulation: east, metres.
        [double optional] true_x_m: Option<f64> = 11,
        /// Where its body is, in simulation: north, metres.
        [double optional] true_y_m: Option<f64> = 12,
        /// Its body's heading, in simulation, radians.
        [double optional] true_yaw_rad: Option<f64> = 13,
        /// Its body's speed, in simulation, m/s.
        [double optional] true_speed_mps: Option<f64> = 14,
        /// Its body's yaw rate, in simulation, rad/s.
        [double optional] true_yaw_rate_radps: Option<f64> = 15,
        /// Whether its body touches something, in simulation.
        [bool optional] in_contact: Option<bool> = 16,
        /// Measured speed, m/s.
        [double] speed_mps: f64 = 17,
        /// Measured yaw rate, rad/s.
        [double] yaw_rate_radps: f64 = 18,
        /// Speed of the newest command, m/s.
        [double] command_speed_mps: f64 = 19,
        /// Yaw rate of the newest command, rad/s.
        [double] command_yaw_rate_radps: f64 = 20,
        /// Speed that the law asked for, m/s.
        [double optional] request_speed_mps: Option<f64> = 21,
        /// Yaw rate that the law asked for, rad/s.
        [double optional] request_yaw_rate_radps: Option<f64> = 22,
        /// Where it is heading for: east, metres.
        [double optional] target_x_m: Option<f64> = 23,
        /// Where it is heading for: north, metres.
        [double optional] target_y_m: Option<f64> = 24,
        /// The nearest thing its lidar sees, metres from its centre.
        [double optional] nearest_m: Option<f64> = 25,
        /// Age of its newest scan, ms.
        [uint64 optional] scan_age_ms: Option<u64> = 26,
        /// Age of its newest odometry, ms.
        [uint64 optional] link_age_ms: Option<u64> = 27,
        /// How much of its task is done, 0..=1.
        [double] progress: f64 = 28,
        /// Whether it says that its task is done.
        [bool] reached: bool = 29,
        /// Share of its battery's charge that is left, 0..=1.
        [double optional] charge: Option<f64> = 30,
    }
}

message! {
    /// What a robot decided in one tick, and from what.
    Decision {
        /// When, microseconds on the robot's own clock.
        [uint64] stamp_us: u64 = 1,
        /// What the supervisor allows, and why not more, in words.
        [string] verdict: String = 2,
        /// Speed that the law asked for, m/s.
        [double optional] request_speed_mps: Option<f64> = 3,
        /// Yaw rate that the law asked for, rad/s.
        [double optional] request_yaw_rate_radps: Option<f64> = 4,
        /// Speed of the command, m/s.
        [double] command_speed_mps: f64 = 5,
        /// Yaw rate of the command, rad/s.
        [double] command_yaw_rate_radps: f64 = 6,
        /// Why the command is not what was asked for.
        [string optional] changed: Option<String> = 7,
        /// The nearest hit of the newest scan, metres from the body's origin.
        [double optional] nearest_m: Option<f64> = 8,
        /// Age of the newest scan, microseconds.
        [uint64 optional] scan_age_us: Option<u64> = 9,
        /// Age of the newest odometry, microseconds.
        [uint64 optional] odometry_age_us: Option<u64> = 10,
        /// Where the robot believes to be: east, metres.
        [double] x_m: f64 = 11,
        /// Where the robot believes to be: north, metres.
        [double] y_m: f64 = 12,
        /// Its heading as believed, radians.
        [double] yaw_rad: f64 = 13,
        /// It is within this distance of there, metres.
        [double] pos_bound_m: f64 = 14,
        /// How much of its task is done, 0..=1.
        [double] progress: f64 = 15,
        /// Whether its task is done.
        [bool] reached: bool = 16,
    }
}

message! {
    /// How a robot's links fare, counted since the start, about once a second.
    LinkHealth {
        /// The robot's id.
        [uint32] robot: u32 = 1,
        /// Messages received.
        [uint64] received: u64 = 2,
        /// Messages sent.
        [uint64] sent: u64 = 3,
        /// Messages dropped because a queue was full.
        [uint64] dropped_full: u64 = 4,
        /// Errors.
        [uint64] errors: u64 = 5,
        /// The newest of them, in words.
        [string optional] last_error: Option<String> = 6,
        /// Beacons taken.
        [uint64] beacons_taken: u64 = 7,
        /// Beacons dropped: older than what is held.
        [uint64] beacons_old: u64 = 8,
        /// Beacons dropped: heard before.
        [uint64] beacons_duplicate: u64 = 9,
        /// Beacons dropped: not to be believed.
        [uint64] beacons_refused: u64 = 10,
        /// The peers that it hears.
        [message repeated] heard: Vec<HeardLink> = 11,
    }
}

message! {
    /// A peer that a robot hears.
    HeardLink {
        /// Whom.
        [uint32] id: u32 = 1,
        /// How old the newest beacon is, ms.
        [uint64] age_ms: u64 = 2,
        /// Whether the law relies on this link.
        [bool] kept: bool = 3,
    }
}

message! {
    /// What a robot tells its peers.
    Beacon {
        /// Who speaks.
        [uint32] robot: u32 = 1,
        /// Which life of that robot: greater after every restart.
        [uint32] epoch: u32 = 2,
        /// Greater with every beacon of one life.
        [uint32] seq: u32 = 3,
        /// When it was sent, microseconds on the sender's own clock.
        [uint64] sent_us: u64 = 4,
        /// Where the sender believes to be: east, metres.
        [double] x_m: f64 = 5,
        /// Where the sender believes to be: north, metres.
        [double] y_m: f64 = 6,
        /// The sender's heading as believed, radians.
        [double] yaw_rad: f64 = 7,
        /// The sender's speed, m/s.
        [double] speed_mps: f64 = 8,
        /// The sender's yaw rate, rad/s.
        [double] yaw_rate_radps: f64 = 9,
        /// The sender's acceleration along its heading, m/s^2.
        [double] accel_mps2: f64 = 10,
        /// The sender is within this distance of there, metres.
        [double] pos_bound_m: f64 = 11,
        /// Radius of the sender's body, metres.
        [double] radius_m: f64 = 12,
        /// What the sender is doing, in one word.
        [string] state: String = 13,
        /// How much of its task the sender has done, 0..=1.
        [double] progress: f64 = 14,
        /// The robot whose lead the sender follows, itself if it leads.
        [uint32 optional] leader: Option<u32> = 15,
    }
}

message! {
    /// A beacon as a peer heard it.
    BeaconHeard {
        /// Who heard it.
        [uint32] by: u32 = 1,
        /// When, microseconds on the hearer's own clock.
        [uint64] stamp_us: u64 = 2,
        /// What it said.
        [message optional] beacon: Option<Beacon> = 3,
    }
}

message! {
    /// A batch of what a robot's loop was given and sent, in order, packed; `drover export` unpacks it. The first entry
    /// is at the message's own time.
    Wire {
        /// The robot's id.
        [uint32] robot: u32 = 1,
        /// A byte an entry: in the low three bits 0 turn begins, 1 clock read, 2 received, 3 sent, 4 told to end,
        /// 5 received again; above them the port: 0 autopilot, 1 drive's CAN, 2 lidar's CAN, 3 beacons.
        [bytes] marks: Vec<u8> = 2,
        /// A base-128 varint for each entry 0, 1 and 4: microseconds since the one before. What is received and sent
        /// has the time of its turn.
        [bytes] gaps_us: Vec<u8> = 3,
        /// A varint an entry that has bytes: in which group they are; groups give theirs out in order.
        [bytes] order: Vec<u8> = 4,
        /// Messages that are much alike.
        [message repeated] groups: Vec<WireGroup> = 5,
    }
}

message! {
    /// Messages of one length, in order.
    WireGroup {
        /// Bytes of each.
        [uint32] length: u32 = 1,
        /// First all first bytes, then all second ones, and so on; each as the difference to that of the message
        /// before.
        [bytes] planes: Vec<u8> = 2,
    }
}
