//! What an autopilot and the lidar bridge beside it say.

use crate::mavlink::outbox::heartbeat as companion_heartbeat;
use crate::mavlink::wire::Emitter;
use crate::mavlink::{id, ned, obstacle};
use drover_contract::{Battery, MavId, Pose, Scan, Twist};
use mavlink::Message;
use mavlink::dialects::common::{
    ATTITUDE_DATA, AUTOPILOT_VERSION_DATA, BATTERY_STATUS_DATA, DISTANCE_SENSOR_DATA, HEARTBEAT_DATA,
    LOCAL_POSITION_NED_DATA, MavAutopilot, MavBatteryFault, MavBatteryFunction, MavBatteryType, MavDistanceSensor,
    MavMessage, MavModeFlag, MavProtocolCapability, MavSensorOrientation, MavSeverity, MavState, MavSysStatusSensor,
    MavSysStatusSensorExtended, MavType, STATUSTEXT_DATA, SYS_STATUS_DATA, TIMESYNC_DATA,
};

/// MAV_RESULT, as far as a rover uses it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum AckResult {
    /// Done.
    Accepted = 0,
    /// Understood and not possible now.
    TemporarilyRejected = 1,
    /// Understood and never possible.
    Denied = 2,
    /// Not understood.
    Unsupported = 3,
    /// Tried in vain.
    Failed = 4,
}

/// One of the eight 45 degree sectors around the body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sector {
    /// 0 ahead, then clockwise.
    pub index: u8,
    /// The nearest thing in it; `None`: nothing up to the greatest range.
    pub nearest_m: Option<f64>,
    /// The sensor's least range, metres.
    pub range_m_min: f64,
    /// The sensor's greatest range, metres.
    pub range_m_max: f64,
}

/// One message. Moments are on the autopilot's own clock, since it started.
#[derive(Clone, Debug, PartialEq)]
pub enum Telemetry {
    /// HEARTBEAT of a ground rover under ArduPilot.
    Heartbeat {
        /// Mode.
        custom_mode: u32,
        /// Motors live.
        armed: bool,
    },
    /// HEARTBEAT of the lidar bridge: an onboard controller.
    BridgeHeartbeat,
    /// SYS_STATUS.
    SysStatus {
        /// It would arm.
        prearm_ok: bool,
        /// It has fresh obstacle data (the LASER_POSITION bit, as this autopilot does).
        obstacles_ok: bool,
        /// Supply.
        battery: Battery,
    },
    /// BATTERY_STATUS of battery 0.
    BatteryStatus {
        /// Supply.
        battery: Battery,
    },
    /// COMMAND_ACK.
    Ack {
        /// MAV_CMD, known or not.
        command: u16,
        /// The answer.
        result: AckResult,
        /// Who asked.
        to: MavId,
    },
    /// LOCAL_POSITION_NED.
    Position {
        /// Milliseconds since start.
        boot_ms: u32,
        /// Where it is.
        pose_wb: Pose,
        /// How it moves.
        twist_b: Twist,
    },
    /// ATTITUDE, on level ground.
    Attitude {
        /// Milliseconds since start.
        boot_ms: u32,
        /// Heading in the world, counter-clockwise from east.
        yaw_rad: f64,
        /// Turn, counter-clockwise.
        yaw_rate_radps: f64,
    },
    /// OBSTACLE_DISTANCE, about the body's front.
    Obstacles {
        /// Microseconds since start.
        boot_us: u64,
        /// The scan; more than 72 beams are thinned.
        scan: Scan,
    },
    /// DISTANCE_SENSOR of one sector.
    Sector {
        /// Milliseconds since start.
        boot_ms: u32,
        /// The reading.
        sector: Sector,
    },
    /// STATUSTEXT, one piece: see [`text_pieces`].
    Text {
        /// MAV_SEVERITY.
        severity: u8,
        /// At most 50 bytes.
        text: String,
        /// 0: the whole text.
        id: u16,
        /// Which piece.
        chunk: u8,
    },
    /// TIMESYNC answer.
    Time {
        /// Our time, nanoseconds, not 0.
        now_ns: i64,
        /// The asker's, as it came.
        asked_ns: i64,
        /// Who asked.
        to: MavId,
    },
    /// AUTOPILOT_VERSION.
    Version,
}

/// One component that speaks on one link: it counts its own frames.
#[derive(Clone, Copy, Debug)]
pub struct Speaker(Emitter);

impl Speaker {
    /// A speaker that has said nothing yet.
    #[must_use]
    pub const fn new(own: MavId) -> Self {
        Self(Emitter::new(own))
    }

    /// `telemetry` as a frame.
    pub fn encode(&mut self, telemetry: &Telemetry) -> Vec<u8> {
        match telemetry {
            // The command may be one that no dialect knows: the typed message could not hold it.
            Telemetry::Ack { command, result, to } => {
                let [low, high] = command.to_le_bytes();
                let payload = [low, high, *result as u8, 0, 0, 0, 0, 0, to.system, to.component];
                self.0.encode_raw(id::COMMAND_ACK, MavMessage::extra_crc(id::COMMAND_ACK), &payload)
            }
            other => self.0.encode(&other.message()),
        }
    }
}

/// A text in pieces of 50 bytes; `id` tells texts of several pieces apart.
#[must_use]
pub fn text_pieces(severity: u8, text: &str, id: u16) -> Vec<Telemetry> {
    const BYTES: usize = 50;
    let ascii: String = text.chars().map(|letter| if letter.is_ascii() { letter } else { '?' }).collect();
    let whole = ascii.len() < BYTES;
    let mut pieces = Vec::new();
    let mut rest = ascii.as_str();
    for chunk in 0..=u8::MAX {
        let (piece, tail) = rest.split_at(rest.len().min(BYTES));
        pieces.push(Telemetry::Text { severity, text: piece.into(), id: if whole { 0 } else { id.max(1) }, chunk });
        rest = tail;
        if piece.len() < BYTES {
            break;
        }
    }
    pieces
}

impl Telemetry {
    fn message(&self) -> MavMessage {
        match self {
            Self::Heartbeat { custom_mode, armed } => heartbeat(*custom_mode, *armed),
            Self::BridgeHeartbeat | Self::Ack { .. } => companion_heartbeat(),
            Self::SysStatus { prearm_ok, obstacles_ok, battery } => sys_status(*prearm_ok, *obstacles_ok, *battery),
            Self::BatteryStatus { battery } => battery_status(*battery),
            Self::Position { boot_ms, pose_wb, twist_b } => position(*boot_ms, pose_wb, *twist_b),
            Self::Attitude { boot_ms, yaw_rad, yaw_rate_radps } => MavMessage::ATTITUDE(ATTITUDE_DATA {
                time_boot_ms: *boot_ms,
                yaw: ned::flip_heading(*yaw_rad) as f32,
                yawspeed: (0.0 - yaw_rate_radps) as f32,
                ..ATTITUDE_DATA::default()
            }),
            Self::Obstacles { boot_us, scan } => MavMessage::OBSTACLE_DISTANCE(obstacle::encode(*boot_us, scan)),
            Self::Sector { boot_ms, sector } => distance_sensor(*boot_ms, sector),
            Self::Text { severity, text, id, chunk } => MavMessage::STATUSTEXT(STATUSTEXT_DATA {
                severity: mav_severity(*severity),
                text: text.as_str().into(),
                id: *id,
                chunk_seq: *chunk,
            }),
            Self::Time { now_ns, asked_ns, to } => MavMessage::TIMESYNC(TIMESYNC_DATA {
                tc1: *now_ns,
                ts1: *asked_ns,
                target_system: to.system,
                target_component: to.component,
            }),
            Self::Version => version(),
        }
    }
}

fn heartbeat(custom_mode: u32, armed: bool) -> MavMessage {
    let armed_flag = if armed { MavModeFlag::MAV_MODE_FLAG_SAFETY_ARMED } else { MavModeFlag::empty() };
    MavMessage::HEARTBEAT(HEARTBEAT_DATA {
        custom_mode,
        mavtype: MavType::MAV_TYPE_GROUND_ROVER,
        autopilot: MavAutopilot::MAV_AUTOPILOT_ARDUPILOTMEGA,
        base_mode: MavModeFlag::MAV_MODE_FLAG_CUSTOM_MODE_ENABLED | armed_flag,
        system_status: if armed { MavState::MAV_STATE_ACTIVE } else { MavState::MAV_STATE_STANDBY },
        mavlink_version: 3,
    })
}

fn sys_status(prearm_ok: bool, obstacles_ok: bool, battery: Battery) -> MavMessage {
    type Bits = MavSysStatusSensor;
    let always = Bits::MAV_SYS_STATUS_SENSOR_3D_GYRO
        | Bits::MAV_SYS_STATUS_SENSOR_3D_ACCEL
        | Bits::MAV_SYS_STATUS_SENSOR_3D_MAG
        | Bits::MAV_SYS_STATUS_SENSOR_MOTOR_OUTPUTS
        | Bits::MAV_SYS_STATUS_SENSOR_BATTERY;
    let (ready, laser) = (
        Bits::MAV_SYS_STATUS_PREARM_CHECK | Bits::MAV_SYS_STATUS_SENSOR_GPS | Bits::MAV_SYS_STATUS_AHRS,
        Bits::MAV_SYS_STATUS_SENSOR_LASER_POSITION,
    );
    let when = |ok: bool, bits: Bits| if ok { bits } else { Bits::empty() };
    let volts = battery.voltage_v.map_or(u16::MAX, |volts| (volts * 1e3).round().clamp(0.0, 65534.0) as u16);
    MavMessage::SYS_STATUS(SYS_STATUS_DATA {
        onboard_control_sensors_present: always | ready | laser,
        onboard_control_sensors_enabled: always | ready | laser,
        onboard_control_sensors_health: always | when(prearm_ok, ready) | when(obstacles_ok, laser),
        voltage_battery: volts,
        current_battery: centiamperes(battery),
        battery_remaining: percent(battery),
        onboard_control_sensors_present_extended: MavSysStatusSensorExtended::empty(),
        onboard_control_sensors_enabled_extended: MavSysStatusSensorExtended::empty(),
        onboard_control_sensors_health_extended: MavSysStatusSensorExtended::empty(),
        ..SYS_STATUS_DATA::default()
    })
}

fn battery_status(battery: Battery) -> MavMessage {
    let mut voltages = [u16::MAX; 10];
    if let Some(volts) = battery.voltage_v {
        voltages[0] = (volts * 1e3).round().clamp(0.0, 65534.0) as u16;
    }
    MavMessage::BATTERY_STATUS(BATTERY_STATUS_DATA {
        current_consumed: -1,
        energy_consumed: -1,
        temperature: i16::MAX,
        voltages,
        current_battery: centiamperes(battery),
        battery_function: MavBatteryFunction::MAV_BATTERY_FUNCTION_ALL,
        mavtype: MavBatteryType::MAV_BATTERY_TYPE_LIPO,
        battery_remaining: percent(battery),
        fault_bitmask: MavBatteryFault::empty(),
        ..BATTERY_STATUS_DATA::default()
    })
}

fn centiamperes(battery: Battery) -> i16 {
    battery.current_a.map_or(-1, |amperes| (amperes * 1e2).round().clamp(0.0, 32767.0) as i16)
}

fn percent(battery: Battery) -> i8 {
    battery.charge.map_or(-1, |share| (share * 1e2).round().clamp(0.0, 100.0) as i8)
}

fn position(boot_ms: u32, pose_wb: &Pose, twist_b: Twist) -> MavMessage {
    let [north, east] = ned::velocity_to_ned(pose_wb, twist_b);
    MavMessage::LOCAL_POSITION_NED(LOCAL_POSITION_NED_DATA {
        time_boot_ms: boot_ms,
        x: pose_wb.y_m as f32,
        y: pose_wb.x_m as f32,
        vx: north as f32,
        vy: east as f32,
        ..LOCAL_POSITION_NED_DATA::default()
    })
}

fn distance_sensor(boot_ms: u32, sector: &Sector) -> MavMessage {
    let cm = |metres: f64| (metres * 100.0).round().clamp(0.0, 65535.0) as u16;
    MavMessage::DISTANCE_SENSOR(DISTANCE_SENSOR_DATA {
        time_boot_ms: boot_ms,
        min_distance: cm(sector.range_m_min),
        max_distance: cm(sector.range_m_max),
        current_distance: cm(sector.nearest_m.unwrap_or(sector.range_m_max)),
        mavtype: MavDistanceSensor::MAV_DISTANCE_SENSOR_LASER,
        id: 10 + sector.index,
        orientation: orientation(sector.index),
        ..DISTANCE_SENSOR_DATA::default()
    })
}

fn orientation(sector: u8) -> MavSensorOrientation {
    match sector % 8 {
        0 => MavSensorOrientation::MAV_SENSOR_ROTATION_NONE,
        1 => MavSensorOrientation::MAV_SENSOR_ROTATION_YAW_45,
        2 => MavSensorOrientation::MAV_SENSOR_ROTATION_YAW_90,
        3 => MavSensorOrientation::MAV_SENSOR_ROTATION_YAW_135,
        4 => MavSensorOrientation::MAV_SENSOR_ROTATION_YAW_180,
        5 => MavSensorOrientation::MAV_SENSOR_ROTATION_YAW_225,
        6 => MavSensorOrientation::MAV_SENSOR_ROTATION_YAW_270,
        _ => MavSensorOrientation::MAV_SENSOR_ROTATION_YAW_315,
    }
}

fn mav_severity(severity: u8) -> MavSeverity {
    match severity {
        0 => MavSeverity::MAV_SEVERITY_EMERGENCY,
        1 => MavSeverity::MAV_SEVERITY_ALERT,
        2 => MavSeverity::MAV_SEVERITY_CRITICAL,
        3 => MavSeverity::MAV_SEVERITY_ERROR,
        4 => MavSeverity::MAV_SEVERITY_WARNING,
        5 => MavSeverity::MAV_SEVERITY_NOTICE,
        6 => MavSeverity::MAV_SEVERITY_INFO,
        _ => MavSeverity::MAV_SEVERITY_DEBUG,
    }
}

/// A rover that takes commands and setpoints, and holds neither parameters nor missions.
fn version() -> MavMessage {
    type Can = MavProtocolCapability;
    MavMessage::AUTOPILOT_VERSION(AUTOPILOT_VERSION_DATA {
        capabilities: Can::MAV_PROTOCOL_CAPABILITY_COMMAND_INT
            | Can::MAV_PROTOCOL_CAPABILITY_SET_POSITION_TARGET_LOCAL_NED
            | Can::MAV_PROTOCOL_CAPABILITY_MAVLINK2,
        // 4.7.0, development: the habits that are imitated here.
        flight_sw_version: 0x0407_0000,
        ..AUTOPILOT_VERSION_DATA::default()
    })
}
