//! The host's side of an AgileX chassis: from silence to driving, and back again whenever the chassis goes its own way.
//!
//! ```text
//! Silent --0x211--> emergency stop? exception? (0x441) not in CAN mode? (0x421 = 1, repeated) --> Ready
//!   ^                                        any of these, at any time <---------------------------'
//!   '---- no 0x211 for `link_timeout` ----
//! ```
//!
//! The mode is read from every 0x211, for a chassis says nothing when it loses power or is taken by the remote
//! control: it is simply in another mode. A command that comes while the drive is not ready is dropped, never kept,
//! so that nothing moves after a return before a fresh command (invariant 3).
//!
//! An emergency stop is the one thing that does not end by itself: once 0x211 has shown it, nothing is asked of the
//! chassis and no command is sent until this host is made anew, for a button that is released is no order to drive.

use super::odometer::Odometer;
use super::verdict::{Ask, after_estop, error_text, verdict};
use super::wire::{ChassisFrame, HostFrame, MOTORS, Motion, SystemState, Vehicle};
use super::{Mode, Model};
use crate::can::queue::Queue;
use drover_contract::{Battery, CanFrame, DriveState, Event, Odometry, SafeCommand, Severity, Stamp, Twist};
use std::time::Duration;

/// How often a mode command or an error clearing is repeated until 0x211 shows its effect (0x211 comes every 100 ms).
const RETRY: Duration = Duration::from_millis(250);
/// Wheel counters older than this are not reported with a twist: they come as often as it does, every 20 ms.
const WHEELS_AGE_MAX: Duration = Duration::from_millis(200);
/// While the battery monitor has spoken within this, the battery field of 0x211 is not reported as well.
const BMS_AGE_MAX: Duration = Duration::from_secs(2);
/// 0x211 tells of the battery this often at most.
const BATTERY_PERIOD: Duration = Duration::from_secs(1);
const OUTPUTS_MAX: usize = 8;
const EVENTS_MAX: usize = 64;
const MODE_STANDBY: u8 = 0;
const MODE_CAN: u8 = 1;
const CLEAR_ALL: u8 = 0;

/// What a host must know of its chassis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AgilexParams {
    /// Which tables hold.
    pub model: Model,
    /// Distance between left and right wheels, metres: bounds how fast a wheel can roll when the body turns.
    pub track_m: f64,
    /// A chassis that has not sent 0x211 for this long is silent.
    pub link_timeout: Duration,
}

/// What a host has counted since it started.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct AgilexCounters {
    /// Frames understood.
    pub frames: u64,
    /// Frames of no identifier in the tables.
    pub foreign: u64,
    /// Frames of a wrong length.
    pub malformed: u64,
    /// Motion commands sent.
    pub commands: u64,
    /// Commands dropped because the drive was not ready.
    pub commands_refused: u64,
    /// Times that CAN mode was asked for.
    pub enables: u64,
    /// Times that latched errors were cleared.
    pub clears: u64,
    /// Wheel readings taken as a new start of the counters.
    pub odometer_rebases: u64,
    /// Frames or events dropped because nobody took them.
    pub overflows: u64,
}

/// One chassis, seen from its robot. Sans-IO: frames in, frames and events out, time as an argument.
#[derive(Clone, Debug)]
pub struct AgilexHost {
    params: AgilexParams,
    drive: DriveState,
    ask: Ask,
    asked: Option<Stamp>,
    state: Option<(Stamp, SystemState)>,
    motion: Option<Stamp>,
    v1: Option<Stamp>,
    closed: bool,
    /// An emergency stop was seen: for good.
    estopped: bool,
    odometer: Odometer,
    motor_states: [u8; MOTORS as usize],
    bms: Option<Stamp>,
    battery: Option<Stamp>,
    outputs: Queue<CanFrame>,
    events: Queue<Event>,
    counters: AgilexCounters,
}

impl AgilexHost {
    /// A host that has heard nothing yet. It tells so: the first event is [`DriveState::Silent`].
    #[must_use]
    pub fn new(params: AgilexParams, _now: Stamp) -> Self {
        let yaw_rate_radps_bound = 3.0; // above the fastest of the chassis (2.5235 rad/s)
        let bound = params.model.wheel_mps_bound() + yaw_rate_radps_bound * params.track_m / 2.0;
        let mut events = Queue::new(EVENTS_MAX);
        events.push(Event::Drive(DriveState::Silent));
        Self {
            params,
            drive: DriveState::Silent,
            ask: Ask::Nothing,
            asked: None,
            state: None,
            motion: None,
            v1: None,
            closed: false,
            estopped: false,
            odometer: Odometer::new(bound),
            motor_states: [0; MOTORS as usize],
            bms: None,
            battery: None,
            outputs: Queue::new(OUTPUTS_MAX),
            events,
            counters: AgilexCounters::default(),
        }
    }

    /// Take a frame from the bus.
    pub fn handle_frame(&mut self, now: Stamp, frame: &CanFrame) {
        let frame = match ChassisFrame::parse(frame) {
            Ok(frame) => frame,
            Err(super::wire::WireError::Foreign(_)) => return self.counters.foreign += 1,
            Err(super::wire::WireError::Length { .. }) => return self.counters.malformed += 1,
        };
        self.counters.frames += 1;
        match frame {
            ChassisFrame::State(state) => self.handle_state(now, state),
            ChassisFrame::Motion(motion) => self.handle_motion(now, motion),
            ChassisFrame::MotorSlow { motor, state, .. } => self.handle_motor(motor, state),
            ChassisFrame::Odometer { left_mm, right_mm } => self.odometer.read(now, left_mm, right_mm),
            ChassisFrame::Bms { charge_pct, voltage_counts, current_da, .. } => {
                self.bms = Some(now);
                self.events.push(Event::Battery(Battery {
                    voltage_v: Some(f64::from(voltage_counts) * self.params.model.bms_volts_per_count()),
                    current_a: Some(f64::from(current_da) * 0.1),
                    charge: (charge_pct <= 100).then(|| f64::from(charge_pct) * 0.01),
                }));
            }
            ChassisFrame::V1 => self.handle_v1(now),
            // Sticks and fast motor readings are parsed for their length and for tools; the robot needs neither.
            ChassisFrame::Remote(_) | ChassisFrame::MotorFast { .. } => {}
        }
    }

    /// Let time pass: notice silence, repeat what was asked for.
    pub fn handle_timeout(&mut self, now: Stamp) {
        let stale = |seen: Stamp| now.since(seen) > self.params.link_timeout;
        self.v1 = self.v1.filter(|seen| !stale(*seen));
        self.motion = self.motion.filter(|seen| !stale(*seen));
        if self.state.is_some_and(|(seen, _)| stale(seen)) {
            (self.state, self.motion) = (None, None); // the drive is lost, whatever else is still heard
            self.odometer.rebase();
            self.motor_states = [0; MOTORS as usize];
        }
        self.settle_without_state();
        self.repeat_ask(now);
    }

    /// Send `command` now if the drive is ready; else drop it. A command still waiting to be sent gives way.
    pub fn command(&mut self, now: Stamp, command: SafeCommand) {
        self.handle_timeout(now);
        if !matches!(self.drive, DriveState::Ready(_)) {
            self.counters.commands_refused += 1;
            return;
        }
        self.counters.commands += 1;
        self.drop_motions();
        self.outputs.push(motion_frame(command));
    }

    /// The next frame to send.
    pub fn poll_output(&mut self) -> Option<CanFrame> {
        self.outputs.pop()
    }

    /// The next thing learned.
    pub fn poll_event(&mut self) -> Option<Event> {
        self.events.pop()
    }

    /// When [`Self::handle_timeout`] must be called at the latest, and what for.
    #[must_use]
    pub fn poll_timeout(&self) -> Option<(Stamp, &'static str)> {
        let tick = Duration::from_micros(1); // silence begins after the timeout, not at it
        let stale = self.params.link_timeout + tick;
        let link = self.state.map(|(seen, _)| (seen + stale, "agilex system state"));
        let motion = self.motion.map(|seen| (seen + stale, "agilex motion feedback"));
        let v1 = self.v1.map(|seen| (seen + stale, "agilex protocol v1"));
        let retry = match (self.ask, self.asked) {
            (Ask::Enable | Ask::ClearErrors | Ask::EnableAndClear, Some(asked)) => {
                Some((asked + RETRY, "agilex retry"))
            }
            (Ask::Enable | Ask::ClearErrors | Ask::EnableAndClear, None) | (Ask::Nothing, _) => None,
        };
        [link, motion, v1, retry].into_iter().flatten().min()
    }

    /// Frames that stop the body, whatever the state of this host: for the shell to send when nothing else works.
    /// A zero command rather than standby: a chassis in CAN mode brakes on it, and its watchdog sees to the rest.
    #[must_use]
    pub fn stop_frames() -> Vec<CanFrame> {
        vec![motion_frame(SafeCommand::STOP)]
    }

    /// Stop the body and give the chassis back: a zero command, then standby. Nothing is sent or asked after that.
    pub fn shutdown(&mut self, _now: Stamp) {
        self.closed = true;
        self.enter(DriveState::BringUp("shut down"), Ask::Nothing);
        self.outputs.retain(|_| false);
        self.outputs.push(motion_frame(SafeCommand::STOP));
        self.outputs.push(HostFrame::ControlMode(MODE_STANDBY).emit());
    }

    /// How far the drive is on the way to obeying.
    #[must_use]
    pub fn drive_state(&self) -> &DriveState {
        &self.drive
    }

    /// What was counted.
    #[must_use]
    pub fn counters(&self) -> AgilexCounters {
        let overflows = self.outputs.dropped() + self.events.dropped();
        AgilexCounters { odometer_rebases: self.odometer.rebases(), overflows, ..self.counters }
    }

    fn handle_state(&mut self, now: Stamp, state: SystemState) {
        if self.v1.is_some_and(|seen| now.since(seen) <= self.params.link_timeout) {
            return; // in protocol v1 this identifier means something else
        }
        let before = self.state.replace((now, state)).map(|(_, before)| before);
        self.tell_errors(before.map_or(0, |before| before.errors), state.errors);
        self.tell_battery(now, state.battery_dv);
        if self.closed {
            return;
        }
        self.estopped |= state.vehicle == Vehicle::EmergencyStop;
        let mode = self.params.model.mode(state.mode);
        let mode_before = before.map(|before| self.params.model.mode(before.mode));
        if mode == Mode::Standby && mode_before != Some(Mode::Standby) {
            self.odometer.rebase(); // a power cycle leads here, and it sets the counters back
        }
        if mode == Mode::Can && mode_before == Some(Mode::RemoteControl) && !self.estopped {
            self.send_enable(now); // a Bunker Mini obeys again only when asked again, whatever mode it shows
        }
        let (drive, ask) = match state.vehicle {
            Vehicle::Normal | Vehicle::Exception | Vehicle::Other(_) if self.estopped => after_estop(),
            _ => verdict(self.params.model, state, mode),
        };
        self.enter(drive, ask);
        self.repeat_ask(now);
    }

    fn handle_motion(&mut self, now: Stamp, motion: Motion) {
        self.motion = Some(now);
        self.settle_without_state();
        let twist_b = Twist::new(f64::from(motion.speed_mmps) * 1e-3, f64::from(motion.yaw_rate_mradps) * 1e-3);
        let wheels = self.odometer.travel(now, WHEELS_AGE_MAX);
        self.events.push(Event::Odometry(Odometry { stamp: now, twist_b, wheels }));
    }

    /// Without a system state nothing is known of who commands: the drive is silent, or half heard.
    fn settle_without_state(&mut self) {
        if self.state.is_some() || self.v1.is_some() || self.closed {
            return;
        }
        let half_heard = self.motion.map(|_| DriveState::BringUp("waiting for the system state (0x211)"));
        self.enter(half_heard.unwrap_or(DriveState::Silent), Ask::Nothing);
    }

    fn handle_v1(&mut self, now: Stamp) {
        self.v1 = Some(now);
        self.state = None;
        if !self.closed {
            let why = "speaks protocol v1 (frame 0x151 seen): update the chassis' firmware to protocol v2";
            self.enter(DriveState::Refused(why.into()), Ask::Nothing);
        }
    }

    fn handle_motor(&mut self, motor: u8, state: u8) {
        let Some(slot) = self.motor_states.get_mut(usize::from(motor.saturating_sub(1))) else { return };
        let before = std::mem::replace(slot, state);
        if before == state {
            return;
        }
        let names: Vec<_> = self.params.model.motor_fault_names(state & !before).collect();
        if !names.is_empty() {
            let text = format!("motor {motor}: {} (state byte 0x{state:02X})", names.join(", "));
            self.events.push(Event::Text(Severity::Error, text));
        } else if self.params.model.motor_fault_names(state).next().is_none() {
            self.events.push(Event::Text(Severity::Info, format!("motor {motor}: no fault any more")));
        }
    }

    fn tell_errors(&mut self, before: u16, errors: u16) {
        if errors == before {
            return;
        }
        let text = match errors {
            0 => (Severity::Info, "chassis: no error bits any more".to_owned()),
            bits => (Severity::Warning, format!("chassis: {}", error_text(self.params.model, bits))),
        };
        self.events.push(Event::Text(text.0, text.1));
    }

    fn tell_battery(&mut self, now: Stamp, battery_dv: u16) {
        let fresh = |then: Option<Stamp>, span: Duration| then.is_some_and(|then| now.since(then) < span);
        if fresh(self.bms, BMS_AGE_MAX) || fresh(self.battery, BATTERY_PERIOD) {
            return;
        }
        self.battery = Some(now);
        let voltage_v = Some(f64::from(battery_dv) * 0.1);
        self.events.push(Event::Battery(Battery { voltage_v, ..Battery::default() }));
    }

    /// Go to `drive`, and tell if that is news. Leaving readiness takes back any command not sent yet.
    fn enter(&mut self, drive: DriveState, ask: Ask) {
        if self.ask != ask {
            self.asked = None; // a new wish is sent at once
        }
        self.ask = ask;
        if self.drive == drive {
            return;
        }
        if matches!(self.drive, DriveState::Ready(_)) {
            self.drop_motions();
        }
        self.drive = drive;
        self.events.push(Event::Drive(self.drive.clone()));
    }

    fn repeat_ask(&mut self, now: Stamp) {
        if self.asked.is_some_and(|asked| now.since(asked) < RETRY) {
            return;
        }
        match self.ask {
            Ask::Nothing => {}
            Ask::Enable => self.send_enable(now),
            Ask::ClearErrors => self.send_clear(now),
            Ask::EnableAndClear => {
                self.send_enable(now);
                self.send_clear(now);
            }
        }
    }

    fn send_enable(&mut self, now: Stamp) {
        self.asked = Some(now);
        self.counters.enables += 1;
        self.outputs.push(HostFrame::ControlMode(MODE_CAN).emit());
    }

    fn send_clear(&mut self, now: Stamp) {
        self.asked = Some(now);
        self.counters.clears += 1;
        self.outputs.push(HostFrame::ClearErrors(CLEAR_ALL).emit());
    }

    fn drop_motions(&mut self) {
        self.outputs.retain(|frame| !matches!(HostFrame::parse(frame), Ok(HostFrame::Motion(_))));
    }
}

/// The frame for `command`: SI to wire units, rounded. Every command within a chassis' limits fits in i16.
fn motion_frame(command: SafeCommand) -> CanFrame {
    let twist_b = command.twist_b();
    let milli = |value: f64| (value * 1_000.0).round() as i16; // `as` saturates
    let (speed_mmps, yaw_rate_mradps) = (milli(twist_b.speed_mps), milli(twist_b.yaw_rate_radps));
    HostFrame::Motion(Motion { speed_mmps, yaw_rate_mradps, ..Motion::default() }).emit()
}
