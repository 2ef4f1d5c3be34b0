//! A virtual AgileX chassis: bytes, states, rates and watchdog as the maker's manuals have them.
//!
//! The bytes are written here straight from the manuals' tables and not by `drover-codec`, so that the two prove each
//! other. Sources: Scout user manual v1.3.0 (chapter 3.3), Tracer v1.2, Hunter CAN protocol v2.1.
//!
//! ```text
//! power on --> standby --0x421 = 1--> CAN --500 ms without 0x111--> speed 0, still CAN
//!                ^  the remote control masks every command; switched off, it leaves the chassis in standby
//!                '-- power cycle: no word on the bus, counters at zero
//! ```
//!
//! Departures, for want of a source: an emergency stop that was released stays an exception until 0x441 (the manual
//! only says that latched errors are cleared so); motors turn at wheel speed, without a gear; the battery does not
//! run down; the motor frames come every 100 ms and not every 20 ms, to spare a simulated bus
//! ([`AgilexSimParams::motor_period`]).

mod schedule;

use super::BodyState;
use drover_codec::can::agilex::Model;
use drover_contract::{CanFrame, CanId, Stamp, Twist, WheelTravel};
use rand::{Rng, SeedableRng};
use rand_pcg::Pcg32;
use schedule::Schedule;
use std::collections::VecDeque;
use std::f64::consts::{FRAC_PI_4, FRAC_PI_6, TAU};
use std::time::Duration;

/// "Communication protection" (Scout manual, table of 0x111).
const WATCHDOG: Duration = Duration::from_millis(500);
/// Wheels of a Scout Mini: 175 mm across.
const WHEEL_RADIUS_M: f64 = 0.0875;
/// Frames that wait to be sent; far more than one step makes.
const OUTPUTS_MAX: usize = 128;

/// What a virtual chassis is like.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AgilexSimParams {
    /// Which chassis: tables, limits, number of motors.
    pub model: Model,
    /// Distance between left and right wheels, metres: its feedback is computed with it.
    pub track_m: f64,
    /// Between two frames of one motor (0x251.. and 0x261..); 20 ms by the manual.
    pub motor_period: Duration,
    /// From a power cycle until it speaks again.
    pub boot: Duration,
}

impl AgilexSimParams {
    /// A chassis with motor frames every 100 ms that starts in 1 s.
    #[must_use]
    pub const fn new(model: Model, track_m: f64) -> Self {
        Self { model, track_m, motor_period: Duration::from_millis(100), boot: Duration::from_secs(1) }
    }

    /// Fastest forward (m/s) and turn (rad/s): ugv_sdk's limits (which write 0.5235 for 30 degrees), and for the
    /// Tracer what 100 % means in its manual v1.2 (0.7853 for 45 degrees).
    const fn limits(&self) -> (f64, f64) {
        match self.model {
            Model::Scout => (1.5, FRAC_PI_6),
            Model::ScoutMini | Model::Bunker => (3.0, 2.5235),
            Model::Tracer => (1.5, FRAC_PI_4),
            Model::Hunter => (1.5, 0.444),
        }
    }

    const fn motors(&self) -> u16 {
        match self.model {
            Model::Scout | Model::ScoutMini => 4,
            Model::Hunter => 3,
            Model::Tracer | Model::Bunker => 2,
        }
    }
}

/// Who commands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Authority {
    Standby,
    Can,
    Uart,
    Remote,
}

/// A virtual chassis. Pure: frames and its body's state in, frames and a demanded twist out.
#[derive(Clone, Debug)]
pub struct VirtualAgilex {
    params: AgilexSimParams,
    now: Stamp,
    on_from: Stamp,
    authority: Authority,
    remote_on: bool,
    estop: bool,
    fault: u16,
    latched: bool,
    latched_bits: u16,
    setpoint: Option<(Stamp, Twist)>,
    wheels: Option<(Stamp, WheelTravel)>,
    wheels_at_power_on: Option<WheelTravel>,
    wheel_mps: [f64; 2],
    schedule: Option<Schedule>,
    counter: u8,
    charge_pct: u8,
    rng: Pcg32,
    outputs: VecDeque<CanFrame>,
}

impl VirtualAgilex {
    /// A chassis that has just been switched on and is ready to speak.
    #[must_use]
    pub fn new(params: AgilexSimParams, seed: u64) -> Self {
        let mut rng = Pcg32::seed_from_u64(seed);
        let charge_pct = rng.random_range(70..=100);
        Self {
            params,
            now: Stamp::ZERO,
            on_from: Stamp::ZERO,
            authority: at_power_on(params.model),
            remote_on: false,
            estop: false,
            fault: 0,
            latched: false,
            latched_bits: 0,
            setpoint: None,
            wheels: None,
            wheels_at_power_on: None,
            wheel_mps: [0.0; 2],
            schedule: None,
            counter: 0,
            charge_pct,
            rng,
            outputs: VecDeque::new(),
        }
    }

    /// Take a frame from the bus.
    pub fn handle_frame(&mut self, now: Stamp, frame: &CanFrame) {
        self.now = self.now.max(now);
        if self.now < self.on_from || self.authority == Authority::Remote {
            return;
        }
        match (frame.id(), frame.data()) {
            (CanId::Standard(0x421), [mode] | [mode, _, _, _, _, _, _, _]) => self.set_mode(*mode),
            (CanId::Standard(0x441), [_] | [_, _, _, _, _, _, _, _]) if self.authority != Authority::Standby => {
                self.clear_errors();
            }
            (CanId::Standard(0x111), &[v0, v1, w0, w1, _, _, _, _]) if self.authority == Authority::Can => {
                let milli = |high, low| f64::from(i16::from_be_bytes([high, low])) / 1000.0;
                self.setpoint = Some((self.now, Twist::new(milli(v0, v1), milli(w0, w1))));
            }
            _ => {}
        }
    }

    /// Let time pass: `body` is how the chassis finds itself now. Sends what is due.
    pub fn step(&mut self, now: Stamp, body: &BodyState) {
        self.now = self.now.max(now);
        self.feel_wheels(now, body.wheels);
        if self.now < self.on_from {
            return;
        }
        let origin = *self.wheels_at_power_on.get_or_insert(body.wheels);
        let start = self.on_from.max(self.now);
        let mut schedule = *self.schedule.get_or_insert_with(|| Schedule::new(&self.params, start));
        if schedule.fast.take(self.now) {
            self.send_odometer(body.wheels, origin);
            self.send_motion();
            self.send_remote();
        }
        if schedule.state.take(self.now) {
            self.send_state();
        }
        if schedule.motors.take(self.now) {
            self.send_motors();
        }
        if schedule.bms.take(self.now) {
            self.send_bms();
        }
        self.schedule = Some(schedule);
    }

    /// The twist that its motors aim at now.
    #[must_use]
    pub fn demand(&self) -> Twist {
        let fit = self.now >= self.on_from && !self.estop && !self.latched && self.authority == Authority::Can;
        let (speed_mps, yaw_rate_radps) = self.params.limits();
        match self.setpoint {
            Some((at, twist)) if fit && self.now.since(at) < WATCHDOG => Twist::new(
                twist.speed_mps.clamp(-speed_mps, speed_mps),
                twist.yaw_rate_radps.clamp(-yaw_rate_radps, yaw_rate_radps),
            ),
            Some(_) | None => Twist::ZERO,
        }
    }

    /// The next frame that it sends.
    pub fn poll_output(&mut self) -> Option<CanFrame> {
        self.outputs.pop_front()
    }

    /// Cut the power and give it back: silent for `boot`, then in its first mode with its counters at zero.
    pub fn power_cycle(&mut self, now: Stamp) {
        self.now = self.now.max(now);
        self.on_from = self.now + self.params.boot;
        self.authority = if self.remote_on { Authority::Remote } else { at_power_on(self.params.model) };
        (self.latched, self.latched_bits) = (self.fault != 0, self.fault);
        self.setpoint = None;
        self.wheels_at_power_on = None;
        self.schedule = None;
        self.counter = 0;
        self.outputs.clear();
    }

    /// Switch the remote control on, its sticks at rest, or off.
    pub fn set_remote_control(&mut self, on: bool) {
        if on == self.remote_on {
            return;
        }
        self.remote_on = on;
        self.setpoint = None;
        self.authority = if on { Authority::Remote } else { Authority::Standby };
    }

    /// Press the emergency stop button, or release it.
    pub fn set_estop(&mut self, pressed: bool) {
        self.latched |= self.estop && !pressed;
        self.estop = pressed;
        self.setpoint = None;
    }

    /// Give it a fault (bytes 4 and 5 of 0x211, big-endian), or take the cause away with 0: its exception then stays
    /// until it is cleared.
    pub fn set_fault(&mut self, bits: u16) {
        self.fault = bits;
        self.latched |= bits != 0;
        self.latched_bits |= bits;
    }

    fn set_mode(&mut self, mode: u8) {
        let authority = match mode {
            0 => Authority::Standby,
            1 => Authority::Can,
            2 => Authority::Uart,
            _ => return,
        };
        if authority != self.authority {
            self.setpoint = None;
        }
        self.authority = authority;
    }

    fn clear_errors(&mut self) {
        (self.latched, self.latched_bits) = (self.fault != 0, self.fault);
        self.setpoint = None;
    }

    /// Wheel speeds from how far they have rolled since the last step. The time between steps is the world's: frames
    /// arrive in between, and by their time a step would look shorter than it was.
    fn feel_wheels(&mut self, now: Stamp, wheels: WheelTravel) {
        if let Some((then, before)) = self.wheels {
            let dt_s = now.since(then).as_secs_f64();
            if dt_s <= 0.0 {
                return;
            }
            self.wheel_mps = [(wheels.left_m - before.left_m) / dt_s, (wheels.right_m - before.right_m) / dt_s];
        }
        self.wheels = Some((now, wheels));
    }

    fn send(&mut self, id: u16, data: [u8; 8]) {
        if let Ok(frame) = CanFrame::new(CanId::Standard(id), &data) {
            if self.outputs.len() >= OUTPUTS_MAX {
                self.outputs.pop_front();
            }
            self.outputs.push_back(frame);
        }
    }

    fn send_state(&mut self) {
        let vehicle = if self.estop { 1 } else { u8::from(self.latched) * 2 };
        let mode = match (self.params.model, self.authority) {
            (_, Authority::Can) => 1,
            (_, Authority::Standby) => 0,
            (_, Authority::Uart) => 2,
            (Model::Tracer, Authority::Remote) => 0,
            (Model::Hunter, Authority::Remote) => 2,
            (Model::Scout | Model::ScoutMini | Model::Bunker, Authority::Remote) => 3,
        };
        let battery = (self.volts() * 10.0).round() as u16;
        let bits = self.fault | self.latched_bits;
        let counter = self.next_count();
        let data = [vehicle, mode, (battery >> 8) as u8, battery as u8, (bits >> 8) as u8, bits as u8, 0, counter];
        self.send(0x211, data);
    }

    fn send_motion(&mut self) {
        let [left, right] = self.wheel_mps;
        let speed = milli_i16((left + right) / 2.0);
        let turn = milli_i16((right - left) / self.params.track_m);
        self.send(0x221, [speed[0], speed[1], turn[0], turn[1], 0, 0, 0, 0]);
    }

    /// Sticks at rest; SWB up is "command mode", middle is driving by hand.
    fn send_remote(&mut self) {
        let (up, middle) = (2, 1);
        let swb = if self.remote_on { middle } else { up };
        let counter = self.next_count();
        self.send(0x241, [up | swb << 2 | up << 4 | up << 6, 0, 0, 0, 0, 0, 0, counter]);
    }

    fn send_odometer(&mut self, wheels: WheelTravel, origin: WheelTravel) {
        // Through i64: the device's counter wraps, where `as i32` would stand still at the end.
        let mm = |metres: f64| ((metres * 1000.0).round() as i64 as i32).to_be_bytes();
        let [a, b, c, d] = mm(wheels.left_m - origin.left_m);
        let [e, f, g, h] = mm(wheels.right_m - origin.right_m);
        self.send(0x311, [a, b, c, d, e, f, g, h]);
    }

    /// Odd motors stand on the left, even ones on the right.
    fn send_motors(&mut self) {
        for index in 0..self.params.motors() {
            let side = usize::from(index % 2);
            let wheel_mps = self.wheel_mps[side];
            let travel_m = self.wheels.map_or(0.0, |(_, wheels)| [wheels.left_m, wheels.right_m][side]);
            let turns = travel_m / (TAU * WHEEL_RADIUS_M);
            let rpm = ((wheel_mps / (TAU * WHEEL_RADIUS_M) * 60.0).round() as i16).to_be_bytes();
            let amperes = 0.5 + wheel_mps.abs() + self.rng.random_range(0.0..0.2);
            let current = ((amperes * 10.0).round() as i16).to_be_bytes();
            let pulses = ((turns * 1000.0).round() as i64 as i32).to_be_bytes();
            let [p0, p1, p2, p3] = pulses;
            self.send(0x251 + index, [rpm[0], rpm[1], current[0], current[1], p0, p1, p2, p3]);
            let volts = ((self.volts() * 10.0).round() as u16).to_be_bytes();
            self.send(0x261 + index, [volts[0], volts[1], 0, 35, 30, 0, 0, 0]);
        }
    }

    fn send_bms(&mut self) {
        let scale = if self.params.model == Model::Hunter { 100.0 } else { 10.0 };
        let volts = ((self.volts() * scale).round() as u16).to_be_bytes();
        let amperes = 1.5 + 2.0 * (self.wheel_mps[0].abs() + self.wheel_mps[1].abs());
        let current = ((amperes * 10.0).round() as i16).to_be_bytes();
        self.send(0x361, [self.charge_pct, 98, volts[0], volts[1], current[0], current[1], 0, 250]);
    }

    /// 24 V empty, 29 V full.
    fn volts(&self) -> f64 {
        24.0 + 0.05 * f64::from(self.charge_pct)
    }

    fn next_count(&mut self) -> u8 {
        self.counter = self.counter.wrapping_add(1);
        self.counter
    }
}

/// A Tracer is ready for commands when its remote control is off; every other chassis waits in standby.
const fn at_power_on(model: Model) -> Authority {
    match model {
        Model::Tracer => Authority::Can,
        Model::Scout | Model::ScoutMini | Model::Bunker | Model::Hunter => Authority::Standby,
    }
}

fn milli_i16(value: f64) -> [u8; 2] {
    ((value * 1000.0).round() as i16).to_be_bytes()
}

#[cfg(test)]
mod tests;
