//! The onboard computer's end of the link to a rover autopilot.
//!
//! Sans-IO: datagrams in by [`MavHost::handle_datagram`], out by [`MavHost::poll_output`], what was learned by
//! [`MavHost::poll_event`], time by [`MavHost::handle_timeout`] at the moments that [`MavHost::poll_timeout`] names.
//!
//! Only the autopilot (component 1 of the robot's own system) says how the drive is, and only the lidar bridge's
//! component is believed about obstacles: an autopilot forwards what others on its ports say under the same system id.
//! Its own eight DISTANCE_SENSOR sectors are the second opinion, [`MavHost::sector_nearest_m`], and never a scan: a
//! sector of 45 degrees says how far something is, not where, and an empty one may be silent.

use super::bringup::BringUp;
use super::clock::{Heard, Timesync};
use super::motion::Motion;
use super::obstacle::{self, NoScan, RangeLimits};
use super::outbox::{self, Outbox};
use super::params::{MavCounters, MavHostParams};
use super::raw::{BatteryStatus, CommandAck, DistanceSensor, Heartbeat, SysStatus, TextPiece};
use super::text::Texts;
use super::wire::{Frame, frames};
use super::{AUTOPILOT_COMPONENT, id};
use drover_contract::{Battery, DriveState, Event, MavId, SafeCommand, Severity, Stamp, Twist};
use mavlink::dialects::common::MavMessage;
use mavlink::{MavlinkVersion, Message};
use std::collections::VecDeque;
use std::time::Duration;

const HEARTBEAT_SPACING: Duration = Duration::from_secs(1);
const EVENTS_MAX: usize = 256;
/// HEARTBEAT comes at 1 Hz, and until rates are asked for so does everything else.
const HEARTBEAT_PATIENCE: Duration = Duration::from_millis(3500);
/// Telemetry that stays away this long while driving is asked for again.
const STREAM_PATIENCE: Duration = Duration::from_millis(500);
/// An older sector reading is forgotten: the autopilot repeats each at least once a second.
const SECTOR_AGE_MAX: Duration = Duration::from_millis(1500);
const SECTORS: usize = 8;

/// The onboard computer's end of the link.
#[derive(Debug)]
pub struct MavHost {
    params: MavHostParams,
    bringup: BringUp,
    told: DriveState,
    motion: Motion,
    clock: Timesync,
    texts: Texts,
    outbox: Outbox,
    stop: Vec<u8>,
    events: VecDeque<Event>,
    counters: MavCounters,
    heartbeat_due: Stamp,
    /// Last frame and last heartbeat of the autopilot, and last pose.
    heard: Option<Stamp>,
    heartbeat_heard: Option<Stamp>,
    pose_heard: Stamp,
    frame_told: bool,
    sectors: [Option<(Stamp, u16)>; SECTORS],
}

impl MavHost {
    /// A host that has heard nothing yet. Its first heartbeat is ready at once.
    #[must_use]
    pub fn new(params: MavHostParams, now: Stamp) -> Self {
        let own = MavId { system: params.robot, component: params.component };
        Self {
            params,
            bringup: BringUp::new(params.telemetry_hz, now),
            told: DriveState::Silent,
            motion: Motion::default(),
            clock: Timesync::new(now + HEARTBEAT_SPACING),
            texts: Texts::default(),
            outbox: Outbox::new(own),
            stop: outbox::stop_frame(own),
            events: VecDeque::new(),
            counters: MavCounters::default(),
            heartbeat_due: now,
            heard: None,
            heartbeat_heard: None,
            pose_heard: now,
            frame_told: false,
            sectors: [None; SECTORS],
        }
    }

    /// Digest one datagram: any number of frames, and whatever else it holds.
    pub fn handle_datagram(&mut self, now: Stamp, datagram: &[u8]) {
        self.counters.wire.datagrams += 1;
        for found in frames(datagram) {
            match found {
                Ok(frame) => {
                    self.counters.wire.frames += 1;
                    self.route(now, &frame);
                }
                Err(skipped) => self.counters.wire.skip(skipped),
            }
        }
        self.settle(now);
    }

    /// Do what time asks for.
    pub fn handle_timeout(&mut self, now: Stamp) {
        if self.heartbeat_due <= now {
            self.heartbeat_due = now + HEARTBEAT_SPACING;
            self.outbox.push(outbox::heartbeat());
        }
        if self.silence_due().is_some_and(|due| due <= now) {
            self.lose(now);
        }
        if self.heard.is_some()
            && let Some(question) = self.clock.ask(now, self.autopilot())
        {
            self.outbox.push(question);
        }
        if self.stream_due().is_some_and(|due| due <= now) {
            self.pose_heard = now;
            self.bringup.refresh_streams();
        }
        self.bringup.handle_timeout(now);
        self.settle(now);
    }

    /// When [`MavHost::handle_timeout`] wants to be called next, and what for.
    #[must_use]
    pub fn poll_timeout(&self) -> Option<(Stamp, &'static str)> {
        let deadlines = [
            Some((self.heartbeat_due, "own heartbeat")),
            self.silence_due().map(|due| (due, "link silence")),
            self.heard.map(|_| (self.clock.due(), "time question")),
            self.stream_due().map(|due| (due, "telemetry")),
            self.bringup.poll_timeout(),
        ];
        deadlines.into_iter().flatten().min()
    }

    /// Send `command` at once, if the drive is ready; else it is withheld and counted.
    pub fn command(&mut self, now: Stamp, command: SafeCommand) {
        if self.bringup.is_ready() {
            self.outbox.set_setpoint(now, command.twist_b());
        } else {
            self.counters.withheld += 1;
        }
    }

    /// Stand still, HOLD, disarm: for an orderly end. The host then brings nothing up again, and repeats this a few
    /// times until the autopilot's heartbeat shows it. A drive that somebody else has taken is left as it is.
    pub fn shutdown(&mut self, now: Stamp) {
        let ours = self.bringup.release(now);
        self.settle(now);
        if ours {
            self.outbox.set_setpoint(now, Twist::ZERO);
        }
    }

    /// The datagram that stops the robot while it follows us, for a shell whose loop has died: a zero setpoint. It asks
    /// for no mode: a drive that somebody else has taken is not fought for, and a loop that wakes up again goes on.
    #[must_use]
    pub fn stop_bytes(&self) -> &[u8] {
        &self.stop
    }

    /// The next datagram to send. A setpoint leaves before anything else.
    pub fn poll_output(&mut self) -> Option<Vec<u8>> {
        self.outbox.pop()
    }

    /// The next thing learned, oldest first.
    pub fn poll_event(&mut self) -> Option<Event> {
        self.events.pop_front()
    }

    /// How far the drive is on the way to obeying.
    #[must_use]
    pub const fn drive_state(&self) -> &DriveState {
        self.bringup.state()
    }

    /// What was seen and not used.
    #[must_use]
    pub fn counters(&self) -> MavCounters {
        MavCounters { outputs_dropped: self.outbox.dropped(), ..self.counters }
    }

    /// How long a question last took to the autopilot and back.
    #[must_use]
    pub const fn round_trip(&self) -> Option<Duration> {
        self.clock.round_trip()
    }

    /// The nearest thing in the autopilot's own eight sectors, metres; `None` without a fresh reading.
    #[must_use]
    pub fn sector_nearest_m(&self, now: Stamp) -> Option<f64> {
        let fresh = self.sectors.iter().flatten().filter(|(when, _)| now.since(*when) <= SECTOR_AGE_MAX);
        fresh.map(|(_, cm)| f64::from(*cm) * 0.01).min_by(f64::total_cmp)
    }

    const fn autopilot(&self) -> MavId {
        MavId { system: self.params.robot, component: AUTOPILOT_COMPONENT }
    }

    fn silence_due(&self) -> Option<Stamp> {
        let frame_patience = if self.bringup.is_ready() { self.params.link_timeout } else { HEARTBEAT_PATIENCE };
        let heartbeat_patience = HEARTBEAT_PATIENCE.max(self.params.link_timeout);
        let frame_due = self.heard? + frame_patience;
        Some(self.heartbeat_heard.map_or(frame_due, |heard| frame_due.min(heard + heartbeat_patience)))
    }

    fn stream_due(&self) -> Option<Stamp> {
        let periods = Duration::from_secs(3) / self.params.telemetry_hz.max(1);
        self.bringup.is_ready().then(|| self.pose_heard + STREAM_PATIENCE.max(periods))
    }

    fn lose(&mut self, now: Stamp) {
        self.heard = None;
        self.heartbeat_heard = None;
        self.motion.forget();
        self.bringup.handle_lost(now);
    }

    /// The autopilot has restarted: it is disarmed and its streams are gone.
    fn restart(&mut self, now: Stamp) {
        self.tell(Event::Text(Severity::Warning, "the autopilot has restarted".into()));
        self.heard = Some(now);
        self.heartbeat_heard = None;
        self.motion = Motion::default();
        self.clock.forget();
        self.bringup.handle_restart(now);
    }

    /// Hand on what the bring-up asks for and tell its state if it changed.
    fn settle(&mut self, now: Stamp) {
        while let Some((request, confirmation)) = self.bringup.poll_request() {
            self.outbox.push_request(request, confirmation);
        }
        if self.told != *self.bringup.state() {
            self.told = self.bringup.state().clone();
            // What was decided for a drive that obeyed is not sent to one that has ceased to.
            self.outbox.clear_setpoint();
            self.tell(Event::Drive(self.told.clone()));
        }
        if self.bringup.take_stop() {
            self.outbox.set_setpoint(now, Twist::ZERO);
        }
    }

    fn tell(&mut self, event: Event) {
        if self.events.len() == EVENTS_MAX {
            self.events.pop_front();
            self.counters.events_dropped += 1;
        }
        self.events.push_back(event);
    }

    fn route(&mut self, now: Stamp, frame: &Frame<'_>) {
        if frame.from == self.autopilot() {
            self.heard = Some(now);
            self.handle_autopilot(now, frame);
        } else if frame.from == (MavId { component: self.params.lidar_component, ..self.autopilot() }) {
            self.handle_lidar(now, frame);
        } else {
            self.counters.foreign += 1;
        }
    }

    fn handle_autopilot(&mut self, now: Stamp, frame: &Frame<'_>) {
        match frame.message {
            id::HEARTBEAT => {
                self.heartbeat_heard = Some(now);
                self.bringup.handle_heartbeat(now, Heartbeat::read(frame.payload));
            }
            id::COMMAND_ACK => self.handle_ack(now, CommandAck::read(frame.payload)),
            id::SYS_STATUS => self.handle_sys_status(now, SysStatus::read(frame.payload)),
            id::BATTERY_STATUS => self.handle_battery(BatteryStatus::read(frame.payload)),
            id::STATUSTEXT => self.handle_text(now, frame),
            id::DISTANCE_SENSOR => self.handle_sector(now, DistanceSensor::read(frame.payload)),
            id::LOCAL_POSITION_NED | id::ATTITUDE | id::TIMESYNC => self.handle_typed(now, frame),
            // An autopilot says much more than we need.
            _ => {}
        }
        // One component may be both.
        if self.params.lidar_component == AUTOPILOT_COMPONENT && frame.message == id::OBSTACLE_DISTANCE {
            self.handle_obstacles(now, frame.payload);
        }
    }

    fn handle_lidar(&mut self, now: Stamp, frame: &Frame<'_>) {
        match frame.message {
            id::OBSTACLE_DISTANCE => self.handle_obstacles(now, frame.payload),
            id::STATUSTEXT => self.handle_text(now, frame),
            _ => {}
        }
    }

    fn handle_typed(&mut self, now: Stamp, frame: &Frame<'_>) {
        match MavMessage::parse(MavlinkVersion::V2, frame.message, frame.payload) {
            Ok(MavMessage::ATTITUDE(wire)) => {
                self.watch_clock(now, wire.time_boot_ms);
                if self.motion.handle_attitude(&wire).is_err() {
                    self.counters.nonsense += 1;
                }
            }
            Ok(MavMessage::LOCAL_POSITION_NED(wire)) => {
                self.watch_clock(now, wire.time_boot_ms);
                match self.motion.handle_position(now, &wire) {
                    Ok(Some((pose, odometry))) => {
                        self.pose_heard = now;
                        self.tell(Event::Pose(pose));
                        self.tell(Event::Odometry(odometry));
                    }
                    Ok(None) => {}
                    Err(_) => self.counters.nonsense += 1,
                }
            }
            Ok(MavMessage::TIMESYNC(wire)) => match self.clock.handle(now, &wire, frame.from) {
                Heard::Question(answer) => self.outbox.push(*answer),
                Heard::Restart => self.restart(now),
                Heard::Nothing => {}
            },
            Ok(_) | Err(_) => self.counters.nonsense += 1,
        }
    }

    /// An autopilot whose clock falls has restarted. Only that is believed: a message that was long on its way looks
    /// like a restart too if its age is reckoned, and a restart gives back the right to arm.
    fn watch_clock(&mut self, now: Stamp, boot_ms: u32) {
        if self.motion.restarted(boot_ms) {
            self.restart(now);
        }
    }

    fn handle_ack(&mut self, now: Stamp, ack: CommandAck) {
        let ours = (ack.target_system, ack.target_component) == (self.params.robot, self.params.component);
        let nobodys = (ack.target_system, ack.target_component) == (0, 0);
        if !(ours || nobodys) || !self.bringup.handle_ack(now, ack.command, ack.result) {
            self.counters.stray_acks += 1;
        }
    }

    fn handle_sys_status(&mut self, now: Stamp, status: SysStatus) {
        self.bringup.handle_prearm(now, status.health & SysStatus::PREARM != 0);
        let voltage = (status.voltage_mv != u16::MAX).then_some(u32::from(status.voltage_mv));
        self.tell_battery(voltage, status.current_ca, status.remaining);
    }

    fn handle_battery(&mut self, status: BatteryStatus) {
        if status.id == 0 {
            self.tell_battery(status.voltage_mv, status.current_ca, status.remaining);
        }
    }

    fn tell_battery(&mut self, voltage_mv: Option<u32>, current_ca: i16, remaining: i8) {
        let battery = Battery {
            voltage_v: voltage_mv.map(|mv| f64::from(mv) * 1e-3),
            current_a: (current_ca >= 0).then(|| f64::from(current_ca) * 1e-2),
            charge: (0..=100).contains(&remaining).then(|| f64::from(remaining) * 1e-2),
        };
        if battery != Battery::default() {
            self.tell(Event::Battery(battery));
        }
    }

    fn handle_text(&mut self, now: Stamp, frame: &Frame<'_>) {
        let piece = TextPiece::read(frame.payload);
        if let Some((severity, text)) = self.texts.handle(frame.from.component, piece) {
            if frame.from == self.autopilot() {
                self.bringup.handle_text(now, severity, &text);
            }
            self.tell(Event::Text(severity, text));
        }
    }

    fn handle_sector(&mut self, now: Stamp, sensor: DistanceSensor) {
        self.counters.sectors += 1;
        let hit = sensor.current_cm > 0 && sensor.current_cm < sensor.max_cm;
        if let Some(sector) = self.sectors.get_mut(usize::from(sensor.orientation)) {
            *sector = hit.then_some((now, sensor.current_cm));
        }
    }

    fn handle_obstacles(&mut self, now: Stamp, payload: &[u8]) {
        let limits = RangeLimits { range_m_min: self.params.range_m_min, range_m_max: self.params.range_m_max };
        match obstacle::decode(now, payload, limits) {
            Ok(scan) => self.tell(Event::Scan(scan)),
            Err(NoScan::Geometry) => self.counters.nonsense += 1,
            Err(NoScan::Frame(frame)) => {
                self.counters.nonsense += 1;
                if !std::mem::replace(&mut self.frame_told, true) {
                    let text =
                        format!("scans refused: their frame is {frame}, and only 12 (BODY_FRD) is about the body");
                    self.tell(Event::Text(Severity::Error, text));
                }
            }
        }
    }
}
