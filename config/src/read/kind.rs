//! Reads a robot kind.

use crate::geometry::signed_area;
use crate::reader::{NAME, Table};
use crate::report::Words;
use crate::{AgilexModel, Body, Drive, Kind, Lidar, LidarLink, Motion, Mount, Sim, SimMotion, Timeouts};
use std::f64::consts::TAU;
use std::ops::RangeInclusive;

/// MAVLink component ids; 0 is "all".
const COMPONENTS: RangeInclusive<u8> = 1..=255;
/// ArduPilot refuses 50 Hz at its default loop rate and grants 40.
const TELEMETRY_HZ: RangeInclusive<u32> = 1..=40;
/// MAV_COMP_ID_ONBOARD_COMPUTER: what we are on the autopilot's link.
const COMPONENT_ONBOARD_COMPUTER: u8 = 191;
/// MAV_COMP_ID_OBSTACLE_AVOIDANCE: what lidar bridges call themselves.
const COMPONENT_OBSTACLE_AVOIDANCE: u8 = 196;
/// 20 Hz: one odometry a tick at the default tick.
const TELEMETRY_HZ_DEFAULT: u32 = 20;

/// Most corners of a footprint: the simulated body is held against walls edge by edge.
const FOOTPRINT_CORNERS_MAX: usize = 64;

/// A number's key and its least and greatest value.
type NumberKey = (&'static str, f64, f64);

/// The one limit that is tighter the greater it is.
const MARGIN: &str = "margin_m";

/// Keys of `[motion]`, in the order of [`motion_of`].
const MOTION_KEYS: [NumberKey; 7] = [
    ("speed_mps_max", 0.01, 10.0),
    ("reverse_mps_max", 0.0, 10.0),
    ("yaw_rate_radps_max", 0.01, 200.0),
    ("accel_mps2_max", 0.01, 20.0),
    ("brake_mps2", 0.01, 20.0),
    ("yaw_accel_radps2_max", 0.01, 10_000.0),
    (MARGIN, 0.001, 5.0),
];

/// Keys of `[timeouts]` with least, greatest and default value, in the order of [`timeouts_of`].
const TIMEOUT_KEYS: [(&str, u32, u32, u32); 7] = [
    // 20 Hz: what ArduPilot's telemetry feeds, and five times faster than its setpoint timeout needs.
    ("tick_ms", 5, 200, 50),
    // Three scans at 10 Hz: one lost scan does not stop the robot, two in a row do.
    ("scan_ms", 20, 2_000, 300),
    // Six messages at 20 Hz; the same bound as the scan's, so that neither hides the other.
    ("odometry_ms", 20, 2_000, 300),
    // A chassis speaks every 20 ms and an autopilot's heartbeat comes each second; streams come faster than either.
    ("link_ms", 100, 5_000, 1_000),
    // Two ticks: whatever waited longer belongs to a world that is gone.
    ("command_age_ms", 10, 1_000, 100),
    // Five beacons at 10 Hz.
    ("peer_ms", 100, 5_000, 500),
    // A real autopilot takes about 40 s until its GPS lets it arm.
    ("bringup_s", 1, 300, 60),
];

/// What a swarm says of all its kinds: each value that is there tightens every kind.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Tightening {
    pub(crate) motion: [Option<f64>; 7],
    pub(crate) timeouts: [Option<u32>; 7],
}

/// What could be read of a kind.
#[derive(Clone, Debug)]
pub(crate) struct KindParts {
    pub(crate) name: Option<String>,
    pub(crate) body: Option<Body>,
    pub(crate) drive: Option<Drive>,
    motion: Option<Motion>,
    lidar: Option<Lidar>,
    timeouts: Option<Timeouts>,
    sim: Option<Sim>,
}

impl KindParts {
    /// The kind, if all of it could be read.
    pub(crate) fn kind(&self) -> Option<Kind> {
        Some(Kind {
            name: self.name.clone()?,
            body: self.body.clone()?,
            drive: self.drive?,
            motion: self.motion?,
            lidar: self.lidar?,
            timeouts: self.timeouts?,
            sim: self.sim?,
        })
    }
}

/// A kind called `name`; in a file of its own it says its name itself.
pub(crate) fn kind(table: &mut Table<'_>, name: Option<&str>) -> Option<KindParts> {
    Some(KindParts {
        name: kind_name(table, name),
        body: table.table("body", body),
        drive: table.table("drive", drive),
        motion: table.table("motion", motion),
        lidar: table.table("lidar", lidar),
        timeouts: table.section("timeouts", timeouts),
        sim: table.section("sim", sim),
    })
}

fn kind_name(table: &mut Table<'_>, name: Option<&str>) -> Option<String> {
    let Some(name) = name else { return table.text("name", &NAME, None) };
    let said = table.optional_text("name", &NAME);
    if let Some(said) = said.filter(|said| said != name) {
        let words = Words::new(format!("{said:?}"), format!("{name:?}"), "leave it out: the table's key is the name");
        table.problem("name", words);
    }
    Some(name.to_owned())
}

fn body(table: &mut Table<'_>) -> Option<Body> {
    let radius_m = table.number("radius_m", 0.005..=5.0, None);
    let track_m = table.number("track_m", 0.005..=5.0, None);
    let footprint_m = table.optional_points("footprint_m", 3..=FOOTPRINT_CORNERS_MAX);
    Some(Body { radius_m: radius_m?, track_m: track_m?, footprint_m: counter_clockwise(footprint_m?) })
}

/// The same outline, counter-clockwise.
fn counter_clockwise(mut points: Vec<[f64; 2]>) -> Vec<[f64; 2]> {
    if signed_area(&points) < 0.0 {
        points.reverse();
    }
    points
}

fn drive(table: &mut Table<'_>) -> Option<Drive> {
    match table.word("protocol", &["mavlink", "agilex_v2"])? {
        0 => {
            let component = table.integer_u8("component", COMPONENTS, COMPONENT_ONBOARD_COMPUTER);
            let telemetry_hz = table.integer_u32("telemetry_hz", TELEMETRY_HZ, Some(TELEMETRY_HZ_DEFAULT));
            Some(Drive::Mavlink { component: component?, telemetry_hz: telemetry_hz? })
        }
        _ => {
            const MODELS: [(&str, AgilexModel); 5] = [
                ("scout", AgilexModel::Scout),
                ("scout_mini", AgilexModel::ScoutMini),
                ("tracer", AgilexModel::Tracer),
                ("hunter", AgilexModel::Hunter),
                ("bunker", AgilexModel::Bunker),
            ];
            let index = table.word("model", &MODELS.map(|(word, _)| word))?;
            MODELS.get(index).map(|(_, model)| Drive::AgilexV2 { model: *model })
        }
    }
}

fn motion(table: &mut Table<'_>) -> Option<Motion> {
    motion_of(MOTION_KEYS.map(|(key, min, max)| table.number(key, min..=max, None)))
}

fn motion_of(values: [Option<f64>; 7]) -> Option<Motion> {
    let [speed, reverse, yaw_rate, accel, brake, yaw_accel, margin] = values;
    Some(Motion {
        speed_mps_max: speed?,
        reverse_mps_max: reverse?,
        yaw_rate_radps_max: yaw_rate?,
        accel_mps2_max: accel?,
        brake_mps2: brake?,
        yaw_accel_radps2_max: yaw_accel?,
        margin_m: margin?,
    })
}

fn timeouts(table: &mut Table<'_>) -> Option<Timeouts> {
    timeouts_of(TIMEOUT_KEYS.map(|(key, min, max, default)| table.timeout(key, min..=max, Some(default))))
}

fn timeouts_of(values: [Option<u32>; 7]) -> Option<Timeouts> {
    let [tick, scan, odometry, link, command_age, peer, bringup] = values;
    Some(Timeouts {
        tick_ms: tick?,
        scan_ms: scan?,
        odometry_ms: odometry?,
        link_ms: link?,
        command_age_ms: command_age?,
        peer_ms: peer?,
        bringup_s: bringup?,
    })
}

fn lidar(table: &mut Table<'_>) -> Option<Lidar> {
    let link = table.table("link", lidar_link);
    let beams = table.integer_u32("beams", 8..=3_600, None);
    let range_m_min = table.number("range_m_min", 0.0..=10.0, None);
    let range_m_max = table.number("range_m_max", 0.01..=600.0, None);
    let rate_hz = table.number("rate_hz", 1.0..=50.0, None);
    // All around, as most bridges give it.
    let fov_rad = table.number("fov_rad", 0.01..=TAU, Some(TAU));
    let mount = table.section("mount", mount);
    Some(Lidar {
        link: link?,
        beams: beams?,
        range_m_min: range_m_min?,
        range_m_max: range_m_max?,
        rate_hz: rate_hz?,
        fov_rad: fov_rad?,
        mount: mount?,
    })
}

/// Without it the sensor sits in the middle and looks ahead.
fn mount(table: &mut Table<'_>) -> Option<Mount> {
    let x_m = table.number("x_m", -5.0..=5.0, Some(0.0));
    let y_m = table.number("y_m", -5.0..=5.0, Some(0.0));
    let yaw_rad = table.number("yaw_rad", -TAU..=TAU, Some(0.0));
    Some(Mount { x_m: x_m?, y_m: y_m?, yaw_rad: yaw_rad? })
}

fn lidar_link(table: &mut Table<'_>) -> Option<LidarLink> {
    match table.word("protocol", &["obstacle_distance", "dronecan"])? {
        0 => {
            let component = table.integer_u8("component", COMPONENTS, COMPONENT_OBSTACLE_AVOIDANCE);
            Some(LidarLink::ObstacleDistance { component: component? })
        }
        _ => {
            let node = table.integer("node", 1..=127, None).and_then(|node| u8::try_from(node).ok());
            // Unknown is the safe reading of silence; clear must be asked for.
            let silent_is_clear = table.bool("silent_is_clear", Some(false));
            Some(LidarLink::Dronecan { node: node?, silent_is_clear: silent_is_clear? })
        }
    }
}

fn sim(table: &mut Table<'_>) -> Option<Sim> {
    // Wheels on a hard floor slip about 2 %; a small lidar's range is good to 1 cm and loses one beam in a hundred.
    let slip_std = table.number("slip_std", 0.0..=0.5, Some(0.02));
    let range_noise_m = table.number("range_noise_m", 0.0..=1.0, Some(0.01));
    let beam_dropout = table.number("beam_dropout", 0.0..=1.0, Some(0.01));
    // Long enough to be seen to wait, short enough for a test.
    let prearm_s = table.number("prearm_s", 0.0..=120.0, Some(1.0));
    let range_step_m = table.number("range_step_m", 0.0..=1.0, Some(0.0));
    let scan_sweep = table.bool("scan_sweep", Some(false));
    let motion = table.choice("motion", &["diff_drive", "point"]).map(|index| match index {
        0 => SimMotion::DiffDrive,
        _ => SimMotion::Point,
    });
    Some(Sim {
        slip_std: slip_std?,
        range_noise_m: range_noise_m?,
        beam_dropout: beam_dropout?,
        prearm_s: prearm_s?,
        range_step_m: range_step_m?,
        scan_sweep: scan_sweep?,
        motion: motion?,
    })
}

/// The swarm-wide `[motion]`: any of a kind's keys.
pub(crate) fn tighter_motion(table: &mut Table<'_>) -> Option<[Option<f64>; 7]> {
    Some(MOTION_KEYS.map(|(key, min, max)| table.optional_number(key, min..=max)))
}

/// The swarm-wide `[timeouts]`: any of a kind's keys.
pub(crate) fn tighter_timeouts(table: &mut Table<'_>) -> Option<[Option<u32>; 7]> {
    Some(TIMEOUT_KEYS.map(|(key, min, max, _)| table.optional_timeout(key, min..=max)))
}

impl Tightening {
    /// The keys that are looser than what every one of `kinds` says itself: they change nothing.
    pub(crate) fn idle_keys(&self, kinds: &[Kind]) -> Vec<String> {
        let motion = MOTION_KEYS.iter().zip(self.motion).enumerate().filter_map(|(index, ((key, ..), bound))| {
            let bound = bound?;
            let mut own = kinds.iter().map(|kind| motion_values(&kind.motion)[index]);
            let tightens = |own: f64| if *key == MARGIN { bound >= own } else { bound <= own };
            (!own.any(tightens)).then(|| format!("motion.{key}"))
        });
        let timeouts = TIMEOUT_KEYS.iter().zip(self.timeouts).enumerate().filter_map(|(index, ((key, ..), bound))| {
            let bound = bound?;
            let mut own = kinds.iter().map(|kind| timeout_values(&kind.timeouts)[index]);
            (!own.any(|own| bound <= own)).then(|| format!("timeouts.{key}"))
        });
        motion.chain(timeouts).collect()
    }

    /// `kind` with the tighter of both values everywhere: the smaller one, but for the margin the greater.
    pub(crate) fn apply(&self, kind: &mut Kind) {
        let mut motion = motion_values(&kind.motion);
        for (own, (bound, (key, ..))) in motion.iter_mut().zip(self.motion.iter().zip(MOTION_KEYS)) {
            let Some(bound) = bound else { continue };
            *own = if key == MARGIN { own.max(*bound) } else { own.min(*bound) };
        }
        let mut timeouts = timeout_values(&kind.timeouts);
        for (own, bound) in timeouts.iter_mut().zip(self.timeouts) {
            *own = bound.map_or(*own, |bound| bound.min(*own));
        }
        if let (Some(motion), Some(timeouts)) = (motion_of(motion.map(Some)), timeouts_of(timeouts.map(Some))) {
            kind.motion = motion;
            kind.timeouts = timeouts;
        }
    }
}

fn motion_values(motion: &Motion) -> [f64; 7] {
    [
        motion.speed_mps_max,
        motion.reverse_mps_max,
        motion.yaw_rate_radps_max,
        motion.accel_mps2_max,
        motion.brake_mps2,
        motion.yaw_accel_radps2_max,
        motion.margin_m,
    ]
}

fn timeout_values(timeouts: &Timeouts) -> [u32; 7] {
    [
        timeouts.tick_ms,
        timeouts.scan_ms,
        timeouts.odometry_ms,
        timeouts.link_ms,
        timeouts.command_age_ms,
        timeouts.peer_ms,
        timeouts.bringup_s,
    ]
}
