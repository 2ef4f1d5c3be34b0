//! A skid-steer rover under ArduPilot, with a lidar bridge on the same link: the far side of a MAVLink robot.
//!
//! It has the habits that were measured on the real autopilot's code: it can be armed only some time after power-on,
//! keeps a setpoint that reaches it in GUIDED while disarmed and drives it once armed, stops 3 s after its last
//! setpoint, ignores the frames and masks that the real one ignores, answers every command (unknown ones with
//! UNSUPPORTED), holds rates per link, and reduces obstacles to eight sectors. The full scan comes from the bridge,
//! another component of the same system. Motor ramps belong to the body; here is only what the motors are asked for.

mod guided;
mod sectors;
mod streams;
#[cfg(test)]
mod tests;

use super::{BodyState, PeerKey};
use drover_codec::mavlink::device::{
    AckResult, Ask, Command, Demand, Inbound, Received, Setpoint, Speaker, Telemetry, decode, text_pieces,
};
use drover_codec::mavlink::{WireCounters, mode};
use drover_contract::{Battery, MavId, Scan, Stamp, Twist};
use rand::SeedableRng;
use rand_pcg::Pcg32;
use sectors::Sectors;
use std::collections::VecDeque;
use std::time::Duration;
use streams::{Peer, Peers, Stream};

/// ArduPilot Rover's own command timeout; it is no parameter.
const SETPOINT_TIMEOUT: Duration = Duration::from_secs(3);
/// From power-on until it says anything.
const BOOT: Duration = Duration::from_secs(1);
const OUTPUTS_MAX: usize = 1024;

/// MAV_SEVERITY.
const CRITICAL: u8 = 2;
const WARNING: u8 = 4;
const INFO: u8 = 6;

/// What makes one rover differ from another.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RoverParams {
    /// MAVLink system id.
    pub system_id: u8,
    /// The lidar bridge's component id (196: obstacle avoidance).
    pub lidar_component: u8,
    /// From power-on until it knows its position and can be armed (a real one takes 42 s).
    pub prearm_after: Duration,
}

/// The rover. Pure: datagrams, steps and time are handed in.
#[derive(Debug)]
pub struct VirtualRover {
    params: RoverParams,
    started: Stamp,
    custom_mode: u32,
    armed: bool,
    target: Option<Target>,
    body: BodyState,
    sectors: Sectors,
    peers: Peers,
    outputs: VecDeque<(PeerKey, Vec<u8>)>,
    text_id: u16,
    counters: WireCounters,
}

/// The stored setpoint.
#[derive(Clone, Copy, Debug)]
struct Target {
    demand: Demand,
    received: Stamp,
}

impl VirtualRover {
    /// A rover that was powered on at [`Stamp::ZERO`]. The seed spreads its messages in time.
    #[must_use]
    pub fn new(params: RoverParams, seed: u64) -> Self {
        Self {
            params,
            started: Stamp::ZERO,
            custom_mode: mode::MANUAL,
            armed: false,
            target: None,
            body: BodyState::default(),
            sectors: Sectors::default(),
            peers: Peers::new(params.system_id, params.lidar_component, Pcg32::seed_from_u64(seed)),
            outputs: VecDeque::new(),
            text_id: 0,
            counters: WireCounters::default(),
        }
    }

    /// A datagram from `from`. Whoever sends one good frame is a peer from then on.
    pub fn handle_datagram(&mut self, now: Stamp, from: PeerKey, datagram: &[u8]) {
        if !self.running(now) {
            return;
        }
        let frames_before = self.counters.frames;
        let received = decode(self.params.system_id, datagram, &mut self.counters);
        if self.counters.frames > frames_before {
            self.peers.hear(now, from);
        }
        for Received { from: sender, what } in received {
            self.handle_inbound(now, from, sender, what);
        }
    }

    /// Go on to `now`: `body` is where it stands, `scan` what the lidar has just finished.
    pub fn step(&mut self, now: Stamp, body: &BodyState, scan: Option<&Scan>) {
        self.body = *body;
        if !self.running(now) {
            return;
        }
        self.peers.forget_silent(now);
        self.expire_setpoint(now);
        if let Some(scan) = scan {
            self.sectors.handle_scan(now, scan);
            let boot_us = self.boot_time(now).as_micros() as u64;
            let obstacles = Telemetry::Obstacles { boot_us, scan: scan.clone() };
            self.say_to_all(Voice::Bridge, &obstacles);
        }
        self.stream(now);
    }

    /// What the motors are asked for.
    #[must_use]
    pub fn demand(&self) -> Twist {
        match self.target {
            Some(target) if self.armed && self.custom_mode == mode::GUIDED => {
                guided::follow(&target.demand, &self.body.pose_wb)
            }
            Some(_) | None => Twist::ZERO,
        }
    }

    /// The next datagram, and to whom.
    pub fn poll_output(&mut self) -> Option<(PeerKey, Vec<u8>)> {
        self.outputs.pop_front()
    }

    /// Off and on again: disarmed, in MANUAL, nobody known, and silent for a while.
    pub fn power_cycle(&mut self, now: Stamp) {
        self.started = now;
        self.custom_mode = mode::MANUAL;
        self.armed = false;
        self.target = None;
        self.sectors = Sectors::default();
        self.peers.forget_all();
        self.outputs.clear();
    }

    /// Somebody takes the remote control: MANUAL, sticks in the middle. It stays armed.
    pub fn rc_takeover(&mut self) {
        self.change_mode(mode::MANUAL);
    }

    /// They put it down again and switch back to GUIDED, which gives it back to its computer: it stands until told.
    pub fn rc_release(&mut self) {
        self.change_mode(mode::GUIDED);
    }

    /// Somebody at a ground station sets a mode (HEARTBEAT.custom_mode); one that it does not have changes nothing.
    pub fn station_mode(&mut self, custom_mode: u32) {
        self.set_mode(custom_mode);
    }

    /// The mode, as HEARTBEAT.custom_mode says it.
    #[must_use]
    pub const fn custom_mode(&self) -> u32 {
        self.custom_mode
    }

    /// Whether the motors are live.
    #[must_use]
    pub const fn is_armed(&self) -> bool {
        self.armed
    }

    /// How its link's bytes were received.
    #[must_use]
    pub const fn counters(&self) -> WireCounters {
        self.counters
    }

    fn running(&self, now: Stamp) -> bool {
        self.boot_time(now) >= BOOT.min(self.params.prearm_after)
    }

    fn boot_time(&self, now: Stamp) -> Duration {
        now.since(self.started)
    }

    fn boot_ms(&self, now: Stamp) -> u32 {
        self.boot_time(now).as_millis() as u32
    }

    fn prearm_ok(&self, now: Stamp) -> bool {
        self.boot_time(now) >= self.params.prearm_after
    }

    fn handle_inbound(&mut self, now: Stamp, key: PeerKey, sender: MavId, what: Inbound) {
        match what {
            Inbound::Command(command) => {
                let result = self.obey(now, key, command);
                self.say(key, &Telemetry::Ack { command: command.id, result, to: sender });
            }
            Inbound::SetMode { custom_mode } => {
                self.set_mode(custom_mode);
            }
            Inbound::Setpoint(setpoint) => self.store(now, setpoint),
            Inbound::TimeQuestion { asked_ns } => {
                let now_ns = (self.boot_time(now).as_nanos() as i64).max(1);
                self.say(key, &Telemetry::Time { now_ns, asked_ns, to: sender });
            }
            Inbound::DataStream { stream, hz, on } => self.set_group(now, key, stream, if on { hz } else { 0 }),
            Inbound::Heartbeat { .. } | Inbound::Other { .. } => {}
        }
    }

    fn obey(&mut self, now: Stamp, key: PeerKey, command: Command) -> AckResult {
        match command.ask {
            Ask::Mode(custom_mode) => self.set_mode(custom_mode),
            Ask::Arm { arm: true, force } => self.arm(now, force),
            Ask::Arm { arm: false, .. } => {
                self.armed = false;
                AckResult::Accepted
            }
            Ask::Interval { message, interval_us } => self.set_interval(now, key, message, interval_us),
            Ask::Message(message) => self.tell_once(now, key, message),
            Ask::Unknown => AckResult::Unsupported,
        }
    }

    fn set_mode(&mut self, custom_mode: u32) -> AckResult {
        match custom_mode {
            mode::MANUAL | mode::ACRO | mode::STEERING | mode::HOLD | mode::LOITER | mode::GUIDED => {
                self.change_mode(custom_mode);
                AckResult::Accepted
            }
            // No mission, no home, no such mode.
            _ => {
                self.tell_text(WARNING, "Flight mode change failed");
                AckResult::Failed
            }
        }
    }

    /// Entering GUIDED clears the stored setpoint; naming the mode it is in already does not.
    fn change_mode(&mut self, custom_mode: u32) {
        if self.custom_mode != custom_mode {
            self.custom_mode = custom_mode;
            self.target = None;
        }
    }

    fn arm(&mut self, now: Stamp, force: bool) -> AckResult {
        if !self.armed && !force && !self.prearm_ok(now) {
            self.tell_text(CRITICAL, "Arm: Need Position Estimate");
            return AckResult::Failed;
        }
        self.armed = true;
        AckResult::Accepted
    }

    /// Setpoints count in GUIDED only, armed or not.
    fn store(&mut self, now: Stamp, setpoint: Setpoint) {
        if self.custom_mode != mode::GUIDED {
            return;
        }
        match setpoint.demand(&self.body.pose_wb) {
            Demand::Ignored => {}
            Demand::AccelerationUsed => {
                self.tell_text(WARNING, "Ignoring SET_POSITION_TARGET_LOCAL_NED; set ACC_IGNORE in mask");
            }
            demand @ (Demand::Twist(_) | Demand::Course { .. } | Demand::Point(_)) => {
                self.target = Some(Target { demand, received: now });
            }
        }
    }

    fn expire_setpoint(&mut self, now: Stamp) {
        let timed = self.target.filter(|target| !matches!(target.demand, Demand::Point(_)));
        if timed.is_some_and(|target| now.since(target.received) >= SETPOINT_TIMEOUT) {
            self.target = None;
            if self.armed {
                self.tell_text(WARNING, "target not received last 3secs, stopping");
            }
        }
    }

    fn set_interval(&mut self, now: Stamp, key: PeerKey, message: u32, interval_us: i64) -> AckResult {
        let Some(stream) = Stream::of_message(message) else { return AckResult::Denied };
        let result = self.peers.hear(now, key).set_interval(now, stream, interval_us);
        if result == AckResult::Denied {
            let words = format!("Requested rate for message ID {message} too fast. Increase SCHED_LOOP_RATE");
            self.tell_text(INFO, &words);
        }
        result
    }

    fn set_group(&mut self, now: Stamp, key: PeerKey, group: u8, hz: u16) {
        let interval_us = if hz == 0 { -1 } else { 1_000_000 / i64::from(hz.min(40)) };
        let peer = self.peers.hear(now, key);
        for stream in Stream::of_group(group) {
            peer.set_interval(now, *stream, interval_us);
        }
    }

    /// REQUEST_MESSAGE.
    fn tell_once(&mut self, now: Stamp, key: PeerKey, message: u32) -> AckResult {
        const AUTOPILOT_VERSION: u32 = 148;
        if message == AUTOPILOT_VERSION {
            self.say(key, &Telemetry::Version);
            return AckResult::Accepted;
        }
        let Some(stream) = Stream::of_message(message) else { return AckResult::Failed };
        let (voice, messages) = self.compose(now, stream);
        if messages.is_empty() {
            return AckResult::Failed;
        }
        messages.iter().for_each(|telemetry| self.speak(key, voice, telemetry));
        AckResult::Accepted
    }

    fn stream(&mut self, now: Stamp) {
        for stream in Stream::ALL {
            let due: Vec<PeerKey> =
                self.peers.iter_mut().filter_map(|(key, peer)| peer.take_due(now, stream).then_some(key)).collect();
            if due.is_empty() {
                continue;
            }
            let (voice, messages) = self.compose(now, stream);
            for key in due {
                messages.iter().for_each(|telemetry| self.speak(key, voice, telemetry));
            }
        }
    }

    fn compose(&self, now: Stamp, stream: Stream) -> (Voice, Vec<Telemetry>) {
        let boot_ms = self.boot_ms(now);
        let one = |telemetry| (Voice::Autopilot, vec![telemetry]);
        match stream {
            Stream::Heartbeat => one(Telemetry::Heartbeat { custom_mode: self.custom_mode, armed: self.armed }),
            Stream::BridgeHeartbeat => (Voice::Bridge, vec![Telemetry::BridgeHeartbeat]),
            Stream::SysStatus => one(Telemetry::SysStatus {
                prearm_ok: self.prearm_ok(now) || self.armed,
                obstacles_ok: self.sectors.fresh(now),
                battery: BATTERY,
            }),
            Stream::Battery => one(Telemetry::BatteryStatus { battery: BATTERY }),
            Stream::Attitude => one(Telemetry::Attitude {
                boot_ms,
                yaw_rad: self.body.pose_wb.yaw_rad,
                yaw_rate_radps: self.body.twist_b.yaw_rate_radps,
            }),
            // There is no position before the estimator has one.
            Stream::Position if !self.prearm_ok(now) => (Voice::Autopilot, Vec::new()),
            Stream::Position => {
                one(Telemetry::Position { boot_ms, pose_wb: self.body.pose_wb, twist_b: self.body.twist_b })
            }
            Stream::Sectors => {
                let sectors = self.sectors.readings(now);
                (Voice::Autopilot, sectors.map(|sector| Telemetry::Sector { boot_ms, sector }).collect())
            }
        }
    }

    fn tell_text(&mut self, severity: u8, text: &str) {
        self.text_id = self.text_id.wrapping_add(1);
        for piece in text_pieces(severity, text, self.text_id) {
            self.say_to_all(Voice::Autopilot, &piece);
        }
    }

    fn say_to_all(&mut self, voice: Voice, telemetry: &Telemetry) {
        let keys: Vec<PeerKey> = self.peers.iter_mut().map(|(key, _)| key).collect();
        keys.into_iter().for_each(|key| self.speak(key, voice, telemetry));
    }

    fn say(&mut self, key: PeerKey, telemetry: &Telemetry) {
        self.speak(key, Voice::Autopilot, telemetry);
    }

    fn speak(&mut self, key: PeerKey, voice: Voice, telemetry: &Telemetry) {
        let Some(peer) = self.peers.get_mut(key) else { return };
        let bytes = voice.of(peer).encode(telemetry);
        if self.outputs.len() == OUTPUTS_MAX {
            self.outputs.pop_front();
        }
        self.outputs.push_back((key, bytes));
    }
}

/// A supply that never ends.
const BATTERY: Battery = Battery { voltage_v: Some(12.6), current_a: Some(1.5), charge: Some(0.9) };

/// Which component speaks: each counts its own frames.
#[derive(Clone, Copy, Debug)]
enum Voice {
    Autopilot,
    Bridge,
}

impl Voice {
    fn of(self, peer: &mut Peer) -> &mut Speaker {
        match self {
            Self::Autopilot => &mut peer.autopilot,
            Self::Bridge => &mut peer.bridge,
        }
    }
}
