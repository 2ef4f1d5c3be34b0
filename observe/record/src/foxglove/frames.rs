//! Where things are: transforms, scans, the map; and the log.

use super::{pose, rotation, timestamp};
use crate::{CLEAR, MapSetting, Moment, Place, RobotSetting, ScanMoment};
use drover_contract::Severity;
use foxglove::messages::packed_element_field::NumericType;
use foxglove::messages::{FrameTransform, FrameTransforms, Grid, LaserScan, Log, PackedElementField, Vector2, Vector3};

/// The frame in which everything is: ENU, metres.
pub const WORLD: &str = "world";

/// The map lies this far below the ground, metres: what is drawn on the ground must not flicker into it.
const MAP_BELOW_M: f64 = 0.01;

/// The frame of where robot `id` believes to be.
#[must_use]
pub fn robot_frame(id: u32) -> String {
    format!("robot-{id}")
}

/// The frame of where the body of robot `id` truly is; in simulation only.
#[must_use]
pub fn body_frame(id: u32) -> String {
    format!("body-{id}")
}

/// The frame of where the `number`-th mover of the place is, from 1; in simulation only.
#[must_use]
pub fn mover_frame(number: usize) -> String {
    format!("mover-{number}")
}

/// The topic of what robot `id` tells under `name`: `/robot-3/scan`.
#[must_use]
pub fn topic(id: u32, name: &str) -> String {
    format!("/robot-{id}/{name}")
}

/// Where everybody is: `world` to `robot-N` as believed, and to `body-N` and `mover-N` as it is where that is known.
#[must_use]
pub fn transforms(unix_us: u64, moment: &Moment) -> FrameTransforms {
    let mut transforms = Vec::with_capacity(2 * moment.robots.len());
    for robot in &moment.robots {
        let believed = robot.believed.map(|place| transform(unix_us, robot_frame(robot.id), place));
        let truth = robot.truth.map(|truth| transform(unix_us, body_frame(robot.id), truth.place));
        transforms.extend(believed.into_iter().chain(truth));
    }
    for (number, [x_m, y_m]) in (1..).zip(&moment.movers_m) {
        let place = Place { x_m: *x_m, y_m: *y_m, yaw_rad: 0.0 };
        transforms.push(transform(unix_us, mover_frame(number), place));
    }
    FrameTransforms { transforms }
}

fn transform(unix_us: u64, child_frame_id: String, place: Place) -> FrameTransform {
    FrameTransform {
        timestamp: Some(timestamp(unix_us)),
        parent_frame_id: WORLD.into(),
        child_frame_id,
        translation: Some(Vector3 { x: place.x_m, y: place.y_m, z: 0.0 }),
        rotation: Some(rotation(place.yaw_rad)),
    }
}

/// A scan in the frame `robot-N`, seen from where the lidar sits; `unix_us` is when it was taken. A beam that met
/// nothing is +infinity, one without a reading is not a number. The sensor's greatest range has no place in it.
#[must_use]
pub fn laser_scan(unix_us: u64, robot: &RobotSetting, scan: &ScanMoment) -> LaserScan {
    let [x_m, y_m, yaw_rad] = robot.lidar_mount;
    let steps = scan.ranges_m.len().saturating_sub(1) as f64;
    LaserScan {
        timestamp: Some(timestamp(unix_us)),
        frame_id: robot_frame(robot.id),
        pose: Some(pose([x_m, y_m], 0.0, yaw_rad)),
        start_angle: scan.angle_first_rad,
        end_angle: scan.angle_first_rad + scan.angle_step_rad * steps,
        ranges: scan.ranges_m.iter().map(range_told).collect(),
        intensities: Vec::new(),
    }
}

fn range_told(range_m: &Option<f64>) -> f64 {
    match *range_m {
        None => f64::NAN,
        Some(range_m) if range_m < 0.0 => f64::INFINITY,
        Some(range_m) => range_m,
    }
}

/// The scan that [`laser_scan`] made a message of, in a run that began at `started_unix_us`. The message does not tell
/// the sensor's greatest range, metres, so it is given. The step of a scan of one beam is lost: it is 0.
#[must_use]
pub fn scan_moment(scan: &LaserScan, started_unix_us: u64, range_m_max: f64) -> ScanMoment {
    let taken_us = scan.timestamp.map_or(0, |stamp| stamp.total_nanos() / 1_000);
    let steps = scan.ranges.len().saturating_sub(1).max(1) as f64;
    ScanMoment {
        time_s: (taken_us as f64 - started_unix_us as f64) / 1e6,
        angle_first_rad: scan.start_angle,
        angle_step_rad: (scan.end_angle - scan.start_angle) / steps,
        range_m_max,
        ranges_m: scan.ranges.iter().map(range_read).collect(),
    }
}

fn range_read(range_m: &f64) -> Option<f64> {
    match *range_m {
        range_m if range_m.is_nan() => None,
        range_m if range_m.is_infinite() => Some(CLEAR),
        range_m => Some(range_m),
    }
}

/// A grid map: one byte a cell, named `solid`, 1 for an obstacle and 0 for free ground. Rows go from south to north.
#[must_use]
pub fn grid(unix_us: u64, map: &MapSetting) -> Grid {
    let mut cells: Vec<u8> = map.solid().into_iter().map(u8::from).collect();
    cells.resize(map.width.saturating_mul(map.height), 0);
    let width = u32::try_from(map.width).unwrap_or(u32::MAX);
    Grid {
        timestamp: Some(timestamp(unix_us)),
        frame_id: WORLD.into(),
        pose: Some(pose(map.origin_m, -MAP_BELOW_M, map.origin_yaw_rad)),
        column_count: width,
        cell_size: Some(Vector2 { x: map.resolution_m, y: map.resolution_m }),
        row_stride: width,
        cell_stride: 1,
        fields: vec![PackedElementField { name: "solid".into(), offset: 0, r#type: NumericType::Uint8 as i32 }],
        data: cells.into(),
    }
}

/// Words for people, of one robot; `robot` 0: of the swarm as a whole (no robot has that id).
#[must_use]
pub fn log(unix_us: u64, severity: Severity, robot: u32, words: &str) -> Log {
    use foxglove::messages::log::Level;
    let level = match severity {
        Severity::Info => Level::Info,
        Severity::Warning => Level::Warning,
        Severity::Error => Level::Error,
    };
    Log {
        timestamp: Some(timestamp(unix_us)),
        level: level as i32,
        message: words.into(),
        name: if robot == 0 { "swarm".into() } else { robot_frame(robot) },
        ..Log::default()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{RobotMoment, Truth};
    use foxglove::{Decode, Encode};

    const STARTED_US: u64 = 1_700_000_000_000_000;

    fn through_bytes(scan: &LaserScan) -> LaserScan {
        let mut bytes = Vec::new();
        Encode::encode(scan, &mut bytes).expect("room for a scan");
        <LaserScan as Decode>::decode(bytes.as_slice()).expect("what was encoded")
    }

    #[test]
    fn a_scan_comes_back_as_it_was() {
        let robot = RobotSetting { id: 3, lidar_mount: [0.1, -0.2, 0.5], ..RobotSetting::default() };
        let scan = ScanMoment {
            time_s: 2.5,
            angle_first_rad: -1.0,
            angle_step_rad: 0.25,
            range_m_max: 8.0,
            ranges_m: vec![Some(1.5), Some(CLEAR), None, Some(0.25)],
        };
        let told = laser_scan(STARTED_US + 2_500_000, &robot, &scan);
        assert_eq!(told.frame_id, "robot-3");
        assert!(told.ranges[1].is_infinite() && told.ranges[2].is_nan());
        let mount = told.pose.and_then(|pose| pose.position).expect("a mount");
        assert_eq!(mount, Vector3 { x: 0.1, y: -0.2, z: 0.0 });
        assert_eq!(scan_moment(&through_bytes(&told), STARTED_US, 8.0), scan);
    }

    #[test]
    fn a_robot_is_told_where_it_believes_to_be_and_where_it_is() {
        let place = Place { x_m: 1.0, y_m: 2.0, yaw_rad: std::f64::consts::PI };
        let truth = Some(Truth { place: Place::default(), ..Truth::default() });
        let first = RobotMoment { id: 1, believed: Some(place), truth, ..RobotMoment::default() };
        let second = RobotMoment { id: 2, believed: Some(place), ..RobotMoment::default() };
        let third = RobotMoment { id: 3, ..RobotMoment::default() };
        let (robots, movers_m) = (vec![first, second, third], vec![[0.0, 1.0], [4.0, 5.0]]);
        let told = transforms(7, &Moment { robots, movers_m, ..Moment::default() });
        let frames: Vec<&str> = told.transforms.iter().map(|one| one.child_frame_id.as_str()).collect();
        assert_eq!(frames, ["robot-1", "body-1", "robot-2", "mover-1", "mover-2"]);
        assert_eq!(told.transforms[4].translation, Some(Vector3 { x: 4.0, y: 5.0, z: 0.0 }));
        let turned = told.transforms[0].rotation.expect("a rotation");
        assert!((turned.z - 1.0).abs() < 1e-12 && turned.w.abs() < 1e-12);
        assert_eq!(told.transforms[0].timestamp.map(|stamp| stamp.nsec()), Some(7_000));
    }

    #[test]
    fn a_map_is_a_byte_a_cell_from_the_south_west() {
        let map = MapSetting { resolution_m: 0.5, width: 3, height: 2, runs: vec![1, 2, 2], ..MapSetting::default() };
        let told = grid(0, &map);
        assert_eq!(told.data.as_ref(), [0, 1, 1, 0, 0, 0]);
        assert_eq!((told.column_count, told.row_stride, told.cell_stride), (3, 3, 1));
    }

    #[test]
    fn a_log_names_who_speaks() {
        let told = log(1_000_001, Severity::Warning, 4, "held: obstacle");
        assert_eq!((told.name.as_str(), told.level), ("robot-4", 3));
        assert_eq!(log(0, Severity::Info, 0, "ended").name, "swarm");
    }
}
