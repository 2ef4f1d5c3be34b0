//! The few data types of a range sensor's bus: layouts, read and written.
//!
//! Numbers are little-endian; smaller ones fill each byte from its top bit. Wire units (degrees, body frame FRD with
//! yaw clockwise positive as ArduPilot has it) stay in these structs; the host turns them into ours.

use super::{float16_decode, float16_encode};

/// uavcan.protocol.NodeStatus.
pub const NODE_STATUS_ID: u16 = 341;
/// Signature of NodeStatus.
pub const NODE_STATUS_SIGNATURE: u64 = 0x0F08_68D0_C1A7_C6F1;
/// ardupilot.equipment.proximity_sensor.Proximity.
pub const PROXIMITY_ID: u16 = 21_910;
/// Signature of Proximity.
pub const PROXIMITY_SIGNATURE: u64 = 0x99DD_3985_FB32_22CE;
/// uavcan.equipment.range_sensor.Measurement.
pub const MEASUREMENT_ID: u16 = 1_050;
/// Signature of Measurement.
pub const MEASUREMENT_SIGNATURE: u64 = 0x68FF_FE70_FC77_1952;
/// uavcan.protocol.GetNodeInfo, a service.
pub const GET_NODE_INFO_ID: u8 = 1;
/// Signature of GetNodeInfo.
pub const GET_NODE_INFO_SIGNATURE: u64 = 0xEE46_8A81_21C4_6A9E;
/// The longest name of a node.
const NAME_MAX: usize = 80;

/// How a node is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub enum Health {
    /// All well.
    #[default]
    Ok,
    /// A parameter out of range, or a minor failure.
    Warning,
    /// A major failure.
    Error,
    /// It cannot do its work.
    Critical,
}

/// What a node is doing.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum NodeMode {
    /// Its work.
    #[default]
    Operational,
    /// Starting.
    Initialization,
    /// Calibration, self test and the like.
    Maintenance,
    /// Taking new software.
    SoftwareUpdate,
    /// About to leave.
    Offline,
    /// A value that the specification reserves.
    Reserved(u8),
}

/// uavcan.protocol.NodeStatus: every node says it at least once a second.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct NodeStatus {
    /// Seconds since it started.
    pub uptime_s: u32,
    /// How it is.
    pub health: Health,
    /// What it is doing.
    pub mode: NodeMode,
    /// Reserved, 0..=7.
    pub sub_mode: u8,
    /// The maker's own.
    pub vendor: u16,
}

impl NodeStatus {
    /// Read a payload; `None` unless it has 7 bytes.
    #[must_use]
    pub fn parse(payload: &[u8]) -> Option<Self> {
        let &[a, b, c, d, bits, v0, v1] = payload else { return None };
        let health = [Health::Ok, Health::Warning, Health::Error, Health::Critical][usize::from(bits >> 6)];
        let mode = match bits >> 3 & 7 {
            0 => NodeMode::Operational,
            1 => NodeMode::Initialization,
            2 => NodeMode::Maintenance,
            3 => NodeMode::SoftwareUpdate,
            7 => NodeMode::Offline,
            other => NodeMode::Reserved(other),
        };
        let uptime_s = u32::from_le_bytes([a, b, c, d]);
        Some(Self { uptime_s, health, mode, sub_mode: bits & 7, vendor: u16::from_le_bytes([v0, v1]) })
    }

    /// The payload.
    #[must_use]
    pub fn emit(&self) -> [u8; 7] {
        let mode = match self.mode {
            NodeMode::Operational => 0,
            NodeMode::Initialization => 1,
            NodeMode::Maintenance => 2,
            NodeMode::SoftwareUpdate => 3,
            NodeMode::Offline => 7,
            NodeMode::Reserved(other) => other & 7,
        };
        let ([a, b, c, d], [v0, v1]) = (self.uptime_s.to_le_bytes(), self.vendor.to_le_bytes());
        [a, b, c, d, (self.health as u8) << 6 | mode << 3 | self.sub_mode & 7, v0, v1]
    }
}

/// What a proximity reading is worth.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ProximityReading {
    /// The distance is not known.
    NoData,
    /// The sensor behind the node does not answer.
    NotConnected,
    /// The distance holds.
    Good,
    /// A value that the type does not list.
    Reserved(u8),
}

/// ardupilot.equipment.proximity_sensor.Proximity: one direction of a sensor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Proximity {
    /// Which sensor of the node.
    pub sensor_id: u8,
    /// What the reading is worth.
    pub reading: ProximityReading,
    /// Reserved bits, 0..=31.
    pub flags: u8,
    /// Direction, degrees, clockwise from forward seen from above; `None` if it was not a finite number.
    pub yaw_deg: Option<f64>,
    /// Elevation, degrees; `None` if it was not a finite number.
    pub pitch_deg: Option<f64>,
    /// Distance, metres; `None` if it was not a finite number.
    pub distance_m: Option<f64>,
}

impl Proximity {
    /// Read a payload; `None` unless it has 8 bytes.
    #[must_use]
    pub fn parse(payload: &[u8]) -> Option<Self> {
        let &[sensor_id, bits, y0, y1, p0, p1, d0, d1] = payload else { return None };
        let reading = match bits >> 5 {
            0 => ProximityReading::NoData,
            1 => ProximityReading::NotConnected,
            2 => ProximityReading::Good,
            other => ProximityReading::Reserved(other),
        };
        let half = |low: u8, high: u8| float16_decode(u16::from_le_bytes([low, high]));
        let (yaw_deg, pitch_deg, distance_m) = (half(y0, y1), half(p0, p1), half(d0, d1));
        Some(Self { sensor_id, reading, flags: bits & 0x1F, yaw_deg, pitch_deg, distance_m })
    }

    /// The payload. A number that is absent is written as NaN.
    #[must_use]
    pub fn emit(&self) -> [u8; 8] {
        let reading = match self.reading {
            ProximityReading::NoData => 0,
            ProximityReading::NotConnected => 1,
            ProximityReading::Good => 2,
            ProximityReading::Reserved(other) => other & 7,
        };
        let [y0, y1] = half_bytes(self.yaw_deg);
        let [p0, p1] = half_bytes(self.pitch_deg);
        let [d0, d1] = half_bytes(self.distance_m);
        [self.sensor_id, reading << 5 | self.flags & 0x1F, y0, y1, p0, p1, d0, d1]
    }
}

/// What a range reading is worth.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RangeReading {
    /// Nothing.
    Undefined,
    /// The range holds.
    Valid,
    /// Something nearer than the sensor can measure.
    TooClose,
    /// Nothing as far as the sensor can measure.
    TooFar,
    /// A value that the type does not list.
    Reserved(u8),
}

/// uavcan.equipment.range_sensor.Measurement: one beam of a sensor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Measurement {
    /// Network time, microseconds, 56 bits; 0 if not known.
    pub timestamp_us: u64,
    /// Which sensor of the node.
    pub sensor_id: u8,
    /// Roll, pitch, yaw of the beam about fixed axes of the body, in steps of pi/12, -16..=15.
    pub roll_pitch_yaw: [i8; 3],
    /// Whether that orientation means anything.
    pub orientation_defined: bool,
    /// Opening angle, radians; `None` if it was not a finite number.
    pub field_of_view_rad: Option<f64>,
    /// 0 undefined, 1 sonar, 2 lidar, 3 radar; 0..=31.
    pub sensor_type: u8,
    /// What the reading is worth.
    pub reading: RangeReading,
    /// Range, metres; `None` if it was not a finite number.
    pub range_m: Option<f64>,
}

impl Measurement {
    /// Read a payload; `None` unless it has 15 bytes.
    #[must_use]
    pub fn parse(payload: &[u8]) -> Option<Self> {
        let &[t0, t1, t2, t3, t4, t5, t6, sensor_id, o0, o1, f0, f1, bits, r0, r1] = payload else { return None };
        let orientation = u16::from_be_bytes([o0, o1]);
        let five = |shift: u32| ((orientation >> shift << 11) as i16 >> 11) as i8; // sign-extended from 5 bits
        let reading = match bits & 7 {
            0 => RangeReading::Undefined,
            1 => RangeReading::Valid,
            2 => RangeReading::TooClose,
            3 => RangeReading::TooFar,
            other => RangeReading::Reserved(other),
        };
        Some(Self {
            timestamp_us: u64::from_le_bytes([t0, t1, t2, t3, t4, t5, t6, 0]),
            sensor_id,
            roll_pitch_yaw: [five(11), five(6), five(1)],
            orientation_defined: orientation & 1 != 0,
            field_of_view_rad: float16_decode(u16::from_le_bytes([f0, f1])),
            sensor_type: bits >> 3,
            reading,
            range_m: float16_decode(u16::from_le_bytes([r0, r1])),
        })
    }

    /// The payload. A number that is absent is written as NaN; numbers wider than their field are cut to it.
    #[must_use]
    pub fn emit(&self) -> [u8; 15] {
        let [t0, t1, t2, t3, t4, t5, t6, _] = self.timestamp_us.to_le_bytes();
        let [roll, pitch, yaw] = self.roll_pitch_yaw.map(|angle| (angle as u8 & 0x1F) as u16);
        let orientation = roll << 11 | pitch << 6 | yaw << 1 | u16::from(self.orientation_defined);
        let [o0, o1] = orientation.to_be_bytes();
        let reading = match self.reading {
            RangeReading::Undefined => 0,
            RangeReading::Valid => 1,
            RangeReading::TooClose => 2,
            RangeReading::TooFar => 3,
            RangeReading::Reserved(other) => other & 7,
        };
        let ([f0, f1], [r0, r1]) = (half_bytes(self.field_of_view_rad), half_bytes(self.range_m));
        let bits = (self.sensor_type & 0x1F) << 3 | reading;
        [t0, t1, t2, t3, t4, t5, t6, self.sensor_id, o0, o1, f0, f1, bits, r0, r1]
    }
}

/// The answer of uavcan.protocol.GetNodeInfo: who a node is. Versions beyond major and minor are left 0.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct NodeInfo {
    /// As in its NodeStatus.
    pub status: NodeStatus,
    /// Software version, major and minor.
    pub software: [u8; 2],
    /// Hardware version, major and minor.
    pub hardware: [u8; 2],
    /// No other node has the same.
    pub unique_id: [u8; 16],
    /// Reversed domain name, at most 80 bytes.
    pub name: String,
}

impl NodeInfo {
    /// The payload: status (7), software version (major, minor, flags, commit u32, image CRC u64), hardware version
    /// (major, minor, unique id, length of a certificate), name (its length is what is left).
    #[must_use]
    pub fn emit(&self) -> Vec<u8> {
        let mut payload = self.status.emit().to_vec();
        payload.extend_from_slice(&self.software);
        payload.extend_from_slice(&[0; 13]);
        payload.extend_from_slice(&self.hardware);
        payload.extend_from_slice(&self.unique_id);
        payload.push(0);
        payload.extend(self.name.bytes().take(NAME_MAX));
        payload
    }
}

fn half_bytes(value: Option<f64>) -> [u8; 2] {
    float16_encode(value.unwrap_or(f64::NAN)).to_le_bytes()
}
