//! What carries beacons: a multicast group between computers, a modelled radio within one process.

use serde::Serialize;

/// The beacon plane.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct BeaconPlane {
    /// Multicast group, 224.0.0.0/4.
    pub group: String,
    /// UDP port, 1024..=65535.
    pub port: u16,
    /// Address of the interface to use; 127.0.0.1 keeps it on this computer.
    pub interface: String,
    /// Beacons per second, 1..=50.
    pub rate_hz: f64,
}

/// The modelled radio between robots of one process.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Radio {
    /// Farther apart than this, robots never hear each other, metres, > 0.
    pub range_m: f64,
    /// Share of messages lost, each on its own, 0..=1.
    pub loss: f64,
    /// Shortest delay, ms, 0..=10000.
    pub delay_ms: f64,
    /// Added to it, uniformly, up to this, ms, 0..=10000. More than the time between two messages: they overtake.
    pub jitter_ms: f64,
    /// Share of messages that arrive twice, each copy with a delay of its own, 0..=1.
    pub duplicate: f64,
    /// How differently the two directions of a pair hear, 0..=1: each direction's range is `range_m` times a factor of
    /// its own, fixed for the run, drawn evenly from `1 - asymmetry ..= 1`.
    pub asymmetry: f64,
    /// Losses that come in bursts; none: every loss is on its own.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub burst: Option<Burst>,
    /// Loss that grows with distance and with walls between; none: within range everybody hears equally well.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub propagation: Option<Propagation>,
    /// The time that messages take on a channel that all share; none: the channel is never busy.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub airtime: Option<Airtime>,
    /// Times at which groups of robots do not hear each other.
    pub partitions: Vec<Partition>,
}

impl Default for Radio {
    /// The reader's defaults.
    fn default() -> Self {
        Self {
            range_m: 100.0,
            loss: 0.0,
            delay_ms: 2.0,
            jitter_ms: 3.0,
            duplicate: 0.0,
            asymmetry: 0.0,
            burst: None,
            propagation: None,
            airtime: None,
            partitions: Vec::new(),
        }
    }
}

/// Losses in bursts: each directed pair has a good and a bad state (Gilbert 1960, Elliott 1963). In the good state
/// messages are lost by `radio.loss`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Burst {
    /// Chance of turning bad, per second, 0..=1000.
    pub enter_per_s: f64,
    /// Chance of turning good, per second, > 0, ..=1000: a burst lasts 1 / leave_per_s on average.
    pub leave_per_s: f64,
    /// Share of messages lost in the bad state, 0..=1.
    pub loss: f64,
}

/// Log-distance path loss with walls: received power in dB above what half of the messages survive is
/// `10 exponent log10(half_range_m / d) - wall_db walls + shadow`, and the share that survives is a logistic function
/// of it, `1 / (1 + exp(-margin / soft_db))`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Propagation {
    /// Path loss exponent, 1..=6 (2: free space).
    pub exponent: f64,
    /// Distance without walls at which half of the messages are lost, metres, > 0.
    pub half_range_m: f64,
    /// What each wall between takes, dB, 0..=60.
    pub wall_db: f64,
    /// Standard deviation of what each directed pair differs by, fixed for the run, dB, 0..=20.
    pub shadow_db: f64,
    /// How softly reception fades, dB, > 0.
    pub soft_db: f64,
}

/// One channel that all robots share: a receiver hears one message at a time.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Airtime {
    /// Time that one message takes on the air, ms, > 0 (a 75-byte broadcast at 1 Mbit/s with its preamble: 1).
    pub message_ms: f64,
    /// A message that would have to wait longer than this for a free channel is lost, ms.
    pub wait_ms_max: f64,
}

/// From `from_s` to `until_s`, the robots of `ids` and all others do not hear each other.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Partition {
    /// Since the start, s.
    pub from_s: f64,
    /// Since the start, s, > `from_s`.
    pub until_s: f64,
    /// One side of it.
    pub ids: Vec<u32>,
}
