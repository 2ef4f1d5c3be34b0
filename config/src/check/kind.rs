//! A kind: its parts must fit together, and it must be able to stop within what it sees.

use super::Checker;
use crate::geometry::{contains, distance, reflex_corner, self_intersection};
use crate::path::join;
use crate::report::Words;
use crate::{AgilexModel, BeaconPlane, Body, Drive, Kind, Lidar, LidarLink, Mount};
use std::collections::BTreeMap;

/// A chassis is told its turn in thousandths, in 16 bits: rad/s.
const AGILEX_YAW_RATE_RADPS_MAX: f64 = 32.0;
/// OBSTACLE_DISTANCE carries this many ranges.
const OBSTACLE_DISTANCE_BEAMS_MAX: u32 = 72;
/// Proximity carries its distance as a 16-bit float, and a node sends a message a sector: more would fill the bus.
const DRONECAN_SECTORS_MAX: u32 = 360;

impl Checker<'_> {
    /// Everything about `kind`, whose table is at `prefix`.
    pub(crate) fn kind(&mut self, prefix: &str, kind: &Kind) {
        self.body(prefix, kind);
        self.drive(prefix, kind);
        self.lidar_link(prefix, kind);
        self.lidar_range(prefix, kind);
        self.mount(prefix, kind);
        self.stopping_distance(prefix, kind);
        self.periods(prefix, kind);
    }

    /// The key that decides: the swarm-wide one, if there is one.
    fn deciding(&self, prefix: &str, table: &str, key: &str) -> String {
        let swarm_wide = self.root.get(table).and_then(|table| table.get(key)).is_some();
        let inner = join(table, key);
        if swarm_wide { inner } else { join(prefix, &inner) }
    }

    fn body(&mut self, prefix: &str, kind: &Kind) {
        let diameter_m = 2.0 * kind.body.radius_m;
        if kind.body.track_m > diameter_m {
            let expected = format!("at most the body's diameter, 2 * radius_m = {diameter_m}");
            let words = Words::new(kind.body.track_m.to_string(), expected, "make the disc hold the wheels");
            self.report.push_path(self.root, &join(prefix, "body.track_m"), words);
        }
        self.footprint(prefix, &kind.body);
    }

    /// The outline of the simulated body: convex, around the origin, within the disc.
    fn footprint(&mut self, prefix: &str, body: &Body) {
        let points = &body.footprint_m;
        if points.is_empty() {
            return;
        }
        let path = join(prefix, "body.footprint_m");
        let far_m = points.iter().map(|point| distance(*point, [0.0, 0.0])).fold(0.0, f64::max);
        let words = if let Some((first, second)) = self_intersection(points) {
            let found = format!("edges {first} and {second} that touch or cross");
            Words::new(found, "a convex outline", "list the corners in order, each once")
        } else if let Some(corner) = reflex_corner(points) {
            let [x_m, y_m] = points[corner];
            let found = format!("a corner [{x_m}, {y_m}] that points inwards or lies on an edge");
            Words::new(found, "a convex outline", "leave that corner out: the outline may be larger than the body")
        } else if far_m > body.radius_m {
            let expected = format!("corners within radius_m = {} of the point between the wheels", body.radius_m);
            Words::new(format!("a corner {far_m:.3} m away"), expected, "raise body.radius_m: the disc holds the body")
        } else if !contains(points, [0.0, 0.0]) {
            let advice = "give corners in the body frame: x ahead, y to the left";
            Words::new("an outline beside it", "an outline around the point between the wheels", advice)
        } else {
            return;
        };
        self.report.push_path(self.root, &path, words);
    }

    /// The sensor sits on the body.
    fn mount(&mut self, prefix: &str, kind: &Kind) {
        let away_m = mount_distance_m(&kind.lidar);
        if away_m > kind.body.radius_m {
            let expected = format!("within body.radius_m = {} of the point between the wheels", kind.body.radius_m);
            let words = Words::new(format!("{away_m:.3} m away from it"), expected, "measure again");
            self.report.push_path(self.root, &join(prefix, "lidar.mount"), words);
        }
    }

    fn drive(&mut self, prefix: &str, kind: &Kind) {
        let Drive::AgilexV2 { model } = kind.drive else { return };
        if model == AgilexModel::Hunter {
            let words = Words::new(
                "\"hunter\"",
                "a chassis that turns on the spot",
                "choose another chassis: a Hunter steers like a car",
            );
            self.report.push_path(self.root, &join(prefix, "drive.model"), words);
        }
        if kind.motion.yaw_rate_radps_max > AGILEX_YAW_RATE_RADPS_MAX {
            let expected = format!("at most {AGILEX_YAW_RATE_RADPS_MAX}, which can be said to this chassis");
            let words = Words::new(kind.motion.yaw_rate_radps_max.to_string(), expected, "lower it");
            let path = self.deciding(prefix, "motion", "yaw_rate_radps_max");
            self.report.push_path(self.root, &path, words);
        }
        let Some(chassis_mps) = chassis_speed_mps(model) else { return };
        let limits = [("speed_mps_max", kind.motion.speed_mps_max), ("reverse_mps_max", kind.motion.reverse_mps_max)];
        for (key, value) in limits {
            if value > chassis_mps {
                let expected = format!("at most {chassis_mps}, which this chassis reaches");
                let words = Words::new(value.to_string(), expected, "lower it");
                let path = self.deciding(prefix, "motion", key);
                self.report.push_path(self.root, &path, words);
            }
        }
    }

    fn lidar_link(&mut self, prefix: &str, kind: &Kind) {
        let place = join(prefix, "lidar.link.protocol");
        let words = match (kind.drive, kind.lidar.link) {
            (Drive::Mavlink { component, .. }, LidarLink::ObstacleDistance { component: bridge }) => {
                return self.components(prefix, component, bridge, &kind.lidar);
            }
            (Drive::AgilexV2 { .. }, LidarLink::Dronecan { .. }) => return self.sectors(prefix, &kind.lidar),
            (Drive::Mavlink { .. }, LidarLink::Dronecan { .. }) => {
                Words::new("\"dronecan\"", "\"obstacle_distance\" with a mavlink drive", "use the autopilot's link")
            }
            (Drive::AgilexV2 { .. }, LidarLink::ObstacleDistance { .. }) => {
                Words::new("\"obstacle_distance\"", "\"dronecan\" with an agilex_v2 drive", "use a CAN lidar")
            }
        };
        self.report.push_path(self.root, &place, words);
    }

    fn components(&mut self, prefix: &str, ours: u8, bridge: u8, lidar: &Lidar) {
        const AUTOPILOT: u8 = 1;
        for (key, value) in [("drive.component", ours), ("lidar.link.component", bridge)] {
            if value == AUTOPILOT {
                let words = Words::new("1", "2..=255", "choose another: 1 is the autopilot itself");
                self.report.push_path(self.root, &join(prefix, key), words);
            }
        }
        if ours == bridge {
            let expected = "a component other than drive.component";
            let words = Words::new(bridge.to_string(), expected, "give each its own component");
            self.report.push_path(self.root, &join(prefix, "lidar.link.component"), words);
        }
        if lidar.beams > OBSTACLE_DISTANCE_BEAMS_MAX {
            let expected = "a whole number in 8..=72 over obstacle_distance";
            let words = Words::new(lidar.beams.to_string(), expected, "let the bridge merge beams into 72 bins");
            self.report.push_path(self.root, &join(prefix, "lidar.beams"), words);
        }
    }

    fn sectors(&mut self, prefix: &str, lidar: &Lidar) {
        if lidar.beams > DRONECAN_SECTORS_MAX {
            let expected = "a whole number in 8..=360 over dronecan";
            let words = Words::new(lidar.beams.to_string(), expected, "use fewer sectors: each is a message");
            self.report.push_path(self.root, &join(prefix, "lidar.beams"), words);
        }
        if lidar.fov_rad < std::f64::consts::TAU {
            let expected = format!("{}, a full turn, over dronecan", std::f64::consts::TAU);
            let words = Words::new(lidar.fov_rad.to_string(), expected, "leave it out: the sectors go all around");
            self.report.push_path(self.root, &join(prefix, "lidar.fov_rad"), words);
        }
    }

    fn lidar_range(&mut self, prefix: &str, kind: &Kind) {
        let (near_m, far_m) = (kind.lidar.range_m_min, kind.lidar.range_m_max);
        let path = join(prefix, "lidar.range_m_min");
        if near_m >= far_m {
            let words = Words::new(near_m.to_string(), format!("less than range_m_max, {far_m}"), "swap them?");
            return self.report.push_path(self.root, &path, words);
        }
        let gap_m = kind.body.radius_m + kind.motion.margin_m;
        if near_m > gap_m {
            let expected = format!("at most radius_m + margin_m = {gap_m:.3}");
            let advice = "raise motion.margin_m: what is nearer than range_m_min is not seen";
            self.report.push_path(self.root, &path, Words::new(near_m.to_string(), expected, advice));
        }
    }

    fn stopping_distance(&mut self, prefix: &str, kind: &Kind) {
        // A sensor that sits at the back sees less far ahead.
        let (stop_m, far_m) = (kind.stopping_distance_m(), kind.lidar.range_m_max - mount_distance_m(&kind.lidar));
        if stop_m > far_m {
            let found = format!("{} (stops within {stop_m:.2} m)", kind.motion.speed_mps_max);
            let expected = match kind.lidar.mount == Mount::default() {
                true => format!("a stopping distance of at most lidar.range_m_max = {far_m} m"),
                false => format!("a stopping distance of at most lidar.range_m_max less the mount's = {far_m:.3} m"),
            };
            let advice = "lower speed_mps_max, raise brake_mps2, shorten timeouts.scan_ms, or see farther";
            let path = self.deciding(prefix, "motion", "speed_mps_max");
            self.report.push_path(self.root, &path, Words::new(found, expected, advice));
        }
    }

    fn periods(&mut self, prefix: &str, kind: &Kind) {
        self.period(prefix, "scan_ms", kind.timeouts.scan_ms, ("lidar.rate_hz", kind.lidar.rate_hz));
        if let Drive::Mavlink { telemetry_hz, .. } = kind.drive {
            let rate = ("drive.telemetry_hz", f64::from(telemetry_hz));
            self.period(prefix, "odometry_ms", kind.timeouts.odometry_ms, rate);
        }
    }

    /// A timeout shorter than one period of what it waits for would always be over.
    fn period(&mut self, prefix: &str, key: &str, timeout_ms: u32, (rate_key, rate_hz): (&str, f64)) {
        let period_ms = 1_000.0 / rate_hz;
        if f64::from(timeout_ms) < period_ms {
            let expected = format!("at least one period of {rate_key}, {period_ms:.0} ms");
            let words = Words::new(timeout_ms.to_string(), expected, "raise it to two or three periods");
            let path = self.deciding(prefix, "timeouts", key);
            self.report.push_path(self.root, &path, words);
        }
    }

    /// The simulated bodies must move at least once a tick.
    pub(crate) fn step(&mut self, step_ms: Option<u32>, kinds: &BTreeMap<String, Kind>) {
        let tick_ms = kinds.values().map(|kind| kind.timeouts.tick_ms).min();
        if let (Some(step_ms), Some(tick_ms)) = (step_ms, tick_ms)
            && step_ms > tick_ms
        {
            let expected = format!("at most the shortest timeouts.tick_ms, {tick_ms}");
            let words = Words::new(step_ms.to_string(), expected, "lower it to a fifth of a tick");
            self.report.push_path(self.root, "step_ms", words);
        }
    }

    /// The same for the beacons of peers.
    pub(crate) fn peer_period(&mut self, prefix: &str, kind: &Kind, beacon: &BeaconPlane) {
        self.period(prefix, "peer_ms", kind.timeouts.peer_ms, ("beacon.rate_hz", beacon.rate_hz));
    }
}

/// How far the sensor sits from the point between the wheels, metres.
fn mount_distance_m(lidar: &Lidar) -> f64 {
    distance([lidar.mount.x_m, lidar.mount.y_m], [0.0, 0.0])
}

/// What the maker's driver clamps to (ugv_sdk), m/s, where it is known.
fn chassis_speed_mps(model: AgilexModel) -> Option<f64> {
    match model {
        AgilexModel::Scout | AgilexModel::Hunter => Some(1.5),
        AgilexModel::ScoutMini | AgilexModel::Bunker => Some(3.0),
        AgilexModel::Tracer => None,
    }
}
