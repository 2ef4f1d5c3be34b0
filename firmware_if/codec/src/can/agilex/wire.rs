//! Byte layouts of protocol v2, both directions. Wire units stay in here: names carry them.
//!
//! | Id | Frame | Bytes |
//! |---|---|---|
//! | 0x111 | motion command | 8: i16 mm/s, i16 mrad/s, i16 lateral mm/s, i16 steering mrad |
//! | 0x421 | control mode | 1: 0 standby, 1 CAN, 2 serial |
//! | 0x441 | clear errors | 1: 0 all, else which |
//! | 0x211 | system state | 8: vehicle, mode, u16 0.1 V, 16 error bits, park, counter |
//! | 0x221 | motion feedback | 8: as 0x111 |
//! | 0x241 | remote control | 8: switches, four sticks, knob, 0, counter |
//! | 0x251..0x258 | motor, fast | 8: i16 rpm, i16 0.1 A, i32 pulses |
//! | 0x261..0x268 | motor, slow | 8: u16 0.1 V, i16 driver C, i8 motor C, state bits |
//! | 0x311 | odometer | 8: i32 left mm, i32 right mm |
//! | 0x361 | battery monitor | 8: charge %, health %, u16 V, i16 0.1 A, i16 0.1 C |
//!
//! Parsing is total: any frame gives a value or a [`WireError`].

use crate::can::standard;
use drover_contract::{CanFrame, CanId};
use thiserror::Error;

const ID_MOTION_COMMAND: u16 = 0x111;
const ID_CONTROL_MODE: u16 = 0x421;
const ID_CLEAR_ERRORS: u16 = 0x441;
const ID_STATE: u16 = 0x211;
const ID_MOTION: u16 = 0x221;
const ID_REMOTE: u16 = 0x241;
const ID_MOTOR_FAST: u16 = 0x251;
const ID_MOTOR_SLOW: u16 = 0x261;
const ID_ODOMETER: u16 = 0x311;
const ID_BMS: u16 = 0x361;
/// State frame of protocol v1: who sends it does not speak v2.
const ID_V1_STATE: u16 = 0x151;
/// Motors in the id ranges 0x251..=0x258 and 0x261..=0x268.
pub const MOTORS: u8 = 8;

/// A frame that says nothing to us.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
pub enum WireError {
    /// An identifier of no frame in the table.
    #[error("no AgileX v2 frame has the identifier {0:?}")]
    Foreign(CanId),
    /// The right identifier with the wrong number of bytes.
    #[error("frame {id:03X} has {got} bytes, not {want}")]
    Length {
        /// Its identifier.
        id: u16,
        /// How many bytes the table says.
        want: usize,
        /// How many it had.
        got: usize,
    },
}

/// A motion: 0x111 commands it, 0x221 reports it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Motion {
    /// Forward, mm/s.
    pub speed_mmps: i16,
    /// Counter-clockwise, 0.001 rad/s.
    pub yaw_rate_mradps: i16,
    /// To the left, mm/s; 0 on a differential drive.
    pub lateral_mmps: i16,
    /// Inner wheel's angle, 0.001 rad; 0 but on a Hunter.
    pub steering_mrad: i16,
}

impl Motion {
    fn parse(data: &[u8; 8]) -> Self {
        let [a, b, c, d, e, f, g, h] = *data;
        Self {
            speed_mmps: i16::from_be_bytes([a, b]),
            yaw_rate_mradps: i16::from_be_bytes([c, d]),
            lateral_mmps: i16::from_be_bytes([e, f]),
            steering_mrad: i16::from_be_bytes([g, h]),
        }
    }

    fn emit(self) -> [u8; 8] {
        let [a, b] = self.speed_mmps.to_be_bytes();
        let [c, d] = self.yaw_rate_mradps.to_be_bytes();
        let [e, f] = self.lateral_mmps.to_be_bytes();
        let [g, h] = self.steering_mrad.to_be_bytes();
        [a, b, c, d, e, f, g, h]
    }
}

/// What the host sends.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum HostFrame {
    /// 0x111: move so. To be repeated every 20 ms; the chassis stops after 500 ms without.
    Motion(Motion),
    /// 0x421: who shall command: 0 nobody, 1 the CAN bus, 2 the serial port.
    ControlMode(u8),
    /// 0x441: forget latched errors: 0 all of them.
    ClearErrors(u8),
}

impl HostFrame {
    /// Read a frame of the host.
    ///
    /// # Errors
    /// [`WireError`] for identifiers that are not the host's and for wrong lengths. A one-byte frame may also come
    /// as eight bytes: ugv_sdk sends it so.
    pub fn parse(frame: &CanFrame) -> Result<Self, WireError> {
        match frame.id() {
            CanId::Standard(ID_MOTION_COMMAND) => {
                exact(frame, ID_MOTION_COMMAND).map(|d| Self::Motion(Motion::parse(d)))
            }
            CanId::Standard(ID_CONTROL_MODE) => one_byte(frame, ID_CONTROL_MODE).map(Self::ControlMode),
            CanId::Standard(ID_CLEAR_ERRORS) => one_byte(frame, ID_CLEAR_ERRORS).map(Self::ClearErrors),
            other => Err(WireError::Foreign(other)),
        }
    }

    /// The frame's bytes.
    #[must_use]
    pub fn emit(self) -> CanFrame {
        match self {
            Self::Motion(motion) => standard(ID_MOTION_COMMAND, motion.emit()),
            Self::ControlMode(mode) => standard(ID_CONTROL_MODE, [mode]),
            Self::ClearErrors(which) => standard(ID_CLEAR_ERRORS, [which]),
        }
    }
}

/// The first byte of 0x211.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Vehicle {
    /// Ready to move.
    Normal,
    /// The emergency stop button is pressed.
    EmergencyStop,
    /// A fault; the error bits say which.
    Exception,
    /// A value that no manual lists.
    Other(u8),
}

/// 0x211: the only frame with the mode and the emergency stop.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SystemState {
    /// Fit to move?
    pub vehicle: Vehicle,
    /// Who commands; [`super::Model::mode`] gives it a meaning.
    pub mode: u8,
    /// Battery, 0.1 V.
    pub battery_dv: u16,
    /// Bytes 4 and 5, big-endian; [`super::Model::error_names`] gives them names.
    pub errors: u16,
    /// Byte 6: the parking brake of a Hunter, 0 elsewhere.
    pub park: u8,
    /// Byte 7: one more with every frame.
    pub counter: u8,
}

impl SystemState {
    fn parse(data: &[u8; 8]) -> Self {
        let vehicle = match data[0] {
            0 => Vehicle::Normal,
            1 => Vehicle::EmergencyStop,
            2 => Vehicle::Exception,
            other => Vehicle::Other(other),
        };
        let (battery_dv, errors) = (u16::from_be_bytes([data[2], data[3]]), u16::from_be_bytes([data[4], data[5]]));
        Self { vehicle, mode: data[1], battery_dv, errors, park: data[6], counter: data[7] }
    }

    fn emit(self) -> [u8; 8] {
        let vehicle = match self.vehicle {
            Vehicle::Normal => 0,
            Vehicle::EmergencyStop => 1,
            Vehicle::Exception => 2,
            Vehicle::Other(other) => other,
        };
        let ([b2, b3], [b4, b5]) = (self.battery_dv.to_be_bytes(), self.errors.to_be_bytes());
        [vehicle, self.mode, b2, b3, b4, b5, self.park, self.counter]
    }
}

/// 0x241: what the remote control says.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Remote {
    /// Switches SWA, SWB, SWC, SWD: 2 up, 1 middle, 3 down.
    pub switches: [u8; 4],
    /// Right stick horizontal, right vertical, left vertical, left horizontal, knob A: -100..=100.
    pub sticks: [i8; 5],
    /// Byte 7: one more with every frame.
    pub counter: u8,
}

impl Remote {
    fn parse(data: &[u8; 8]) -> Self {
        let switches = [data[0] & 3, data[0] >> 2 & 3, data[0] >> 4 & 3, data[0] >> 6];
        let sticks = [data[1], data[2], data[3], data[4], data[5]].map(|byte| i8::from_be_bytes([byte]));
        Self { switches, sticks, counter: data[7] }
    }

    fn emit(self) -> [u8; 8] {
        let [a, b, c, d] = self.switches.map(|switch| switch & 3);
        let [s1, s2, s3, s4, s5] = self.sticks.map(|stick| stick.to_be_bytes()[0]);
        [a | b << 2 | c << 4 | d << 6, s1, s2, s3, s4, s5, 0, self.counter]
    }
}

/// What the chassis sends.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ChassisFrame {
    /// 0x211.
    State(SystemState),
    /// 0x221: measured at the wheels, not the command.
    Motion(Motion),
    /// 0x241.
    Remote(Remote),
    /// 0x251..=0x258.
    MotorFast {
        /// Which motor, 1..=8.
        motor: u8,
        /// Its speed, rpm.
        rpm: i16,
        /// Its current, 0.1 A; always 0 on a Tracer.
        current_da: i16,
        /// Its encoder; always 0 on a Tracer.
        pulses: i32,
    },
    /// 0x261..=0x268.
    MotorSlow {
        /// Which motor, 1..=8.
        motor: u8,
        /// Its driver's supply, 0.1 V.
        voltage_dv: u16,
        /// Its driver's temperature, C.
        driver_c: i16,
        /// Its own temperature, C.
        motor_c: i8,
        /// State bits; [`super::Model::motor_fault_names`] gives them names.
        state: u8,
    },
    /// 0x311: distance rolled, mm; wraps as i32.
    Odometer {
        /// Left side, mm.
        left_mm: i32,
        /// Right side, mm.
        right_mm: i32,
    },
    /// 0x361: the battery's own monitor.
    Bms {
        /// What is left, %.
        charge_pct: u8,
        /// What a full charge still holds, %.
        health_pct: u8,
        /// In the model's own scale ([`super::Model::bms_volts_per_count`]).
        voltage_counts: u16,
        /// 0.1 A.
        current_da: i16,
        /// 0.1 C.
        temperature_dc: i16,
    },
    /// 0x151: the chassis speaks protocol v1.
    V1,
}

impl ChassisFrame {
    /// Read a frame of the chassis.
    ///
    /// # Errors
    /// [`WireError`] for identifiers that are not the chassis' and for wrong lengths.
    pub fn parse(frame: &CanFrame) -> Result<Self, WireError> {
        let CanId::Standard(id) = frame.id() else { return Err(WireError::Foreign(frame.id())) };
        match id {
            ID_STATE => exact(frame, id).map(|d| Self::State(SystemState::parse(d))),
            ID_MOTION => exact(frame, id).map(|d| Self::Motion(Motion::parse(d))),
            ID_REMOTE => exact(frame, id).map(|d| Self::Remote(Remote::parse(d))),
            ID_MOTOR_FAST..=0x258 => exact(frame, id).map(|d| motor_fast((id - ID_MOTOR_FAST) as u8 + 1, d)),
            ID_MOTOR_SLOW..=0x268 => exact(frame, id).map(|d| motor_slow((id - ID_MOTOR_SLOW) as u8 + 1, d)),
            ID_ODOMETER => exact(frame, id).map(odometer),
            ID_BMS => exact(frame, id).map(bms),
            ID_V1_STATE => Ok(Self::V1),
            _ => Err(WireError::Foreign(frame.id())),
        }
    }

    /// The frame's bytes. A motor's number is taken into 1..=8.
    #[must_use]
    pub fn emit(self) -> CanFrame {
        let nth = |base: u16, motor: u8| base + u16::from(motor.clamp(1, MOTORS) - 1);
        match self {
            Self::State(state) => standard(ID_STATE, state.emit()),
            Self::Motion(motion) => standard(ID_MOTION, motion.emit()),
            Self::Remote(remote) => standard(ID_REMOTE, remote.emit()),
            Self::MotorFast { motor, rpm, current_da, pulses } => {
                let ([a, b], [c, d]) = (rpm.to_be_bytes(), current_da.to_be_bytes());
                let [e, f, g, h] = pulses.to_be_bytes();
                standard(nth(ID_MOTOR_FAST, motor), [a, b, c, d, e, f, g, h])
            }
            Self::MotorSlow { motor, voltage_dv, driver_c, motor_c, state } => {
                let ([a, b], [c, d]) = (voltage_dv.to_be_bytes(), driver_c.to_be_bytes());
                let [e] = motor_c.to_be_bytes();
                standard(nth(ID_MOTOR_SLOW, motor), [a, b, c, d, e, state, 0, 0])
            }
            Self::Odometer { left_mm, right_mm } => {
                let ([a, b, c, d], [e, f, g, h]) = (left_mm.to_be_bytes(), right_mm.to_be_bytes());
                standard(ID_ODOMETER, [a, b, c, d, e, f, g, h])
            }
            Self::Bms { charge_pct, health_pct, voltage_counts, current_da, temperature_dc } => {
                let ([c, d], [e, f]) = (voltage_counts.to_be_bytes(), current_da.to_be_bytes());
                let [g, h] = temperature_dc.to_be_bytes();
                standard(ID_BMS, [charge_pct, health_pct, c, d, e, f, g, h])
            }
            Self::V1 => standard(ID_V1_STATE, [0; 8]),
        }
    }
}

fn motor_fast(motor: u8, data: &[u8; 8]) -> ChassisFrame {
    let [a, b, c, d, e, f, g, h] = *data;
    let (rpm, current_da) = (i16::from_be_bytes([a, b]), i16::from_be_bytes([c, d]));
    ChassisFrame::MotorFast { motor, rpm, current_da, pulses: i32::from_be_bytes([e, f, g, h]) }
}

fn motor_slow(motor: u8, data: &[u8; 8]) -> ChassisFrame {
    let [a, b, c, d, e, state, ..] = *data;
    let (voltage_dv, driver_c) = (u16::from_be_bytes([a, b]), i16::from_be_bytes([c, d]));
    ChassisFrame::MotorSlow { motor, voltage_dv, driver_c, motor_c: i8::from_be_bytes([e]), state }
}

fn odometer(data: &[u8; 8]) -> ChassisFrame {
    let [a, b, c, d, e, f, g, h] = *data;
    let (left_mm, right_mm) = (i32::from_be_bytes([a, b, c, d]), i32::from_be_bytes([e, f, g, h]));
    ChassisFrame::Odometer { left_mm, right_mm }
}

fn bms(data: &[u8; 8]) -> ChassisFrame {
    let [charge_pct, health_pct, c, d, e, f, g, h] = *data;
    ChassisFrame::Bms {
        charge_pct,
        health_pct,
        voltage_counts: u16::from_be_bytes([c, d]),
        current_da: i16::from_be_bytes([e, f]),
        temperature_dc: i16::from_be_bytes([g, h]),
    }
}

fn exact(frame: &CanFrame, id: u16) -> Result<&[u8; 8], WireError> {
    let got = frame.data().len();
    frame.data().try_into().map_err(|_| WireError::Length { id, want: 8, got })
}

fn one_byte(frame: &CanFrame, id: u16) -> Result<u8, WireError> {
    match frame.data() {
        [byte] | [byte, _, _, _, _, _, _, _] => Ok(*byte),
        other => Err(WireError::Length { id, want: 1, got: other.len() }),
    }
}
