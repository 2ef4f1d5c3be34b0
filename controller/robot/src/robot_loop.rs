//! One robot from mailbox to wheel, without a clock of its own and without waiting.
//!
//! A turn is: read all links -> codecs -> node's mailboxes -> (if a tick is due or a fresh scan came) tick -> codec ->
//! links. Nothing in it blocks and nothing is kept for later, so a turn is also the unit in which a hang is noticed.

use crate::adapter::{Adapter, LinkCounters};
use crate::witness::Recording;
use drover_codec::beacon::{self, Message};
use drover_codec::{links, map};
use drover_config::RobotFile;
use drover_contract::{Clock, DriveState, Event, Link, SafeCommand, Scan, Severity, Stamp, Watchdog};
use drover_core::map::SharedMap;
use drover_core::{HeardPeer, Node, Status, StopReason};
use std::task::{Context, Poll};
use std::time::Duration;

/// A fresh scan is acted on at once, but not more often than this: a lidar gone wild must not eat the computer.
const SCAN_TICK_SPACING_MIN: Duration = Duration::from_millis(5);
/// A robot told to end is given this long to be seen standing.
const STANDSTILL_PATIENCE: Duration = Duration::from_secs(6);
/// Standing still for this long counts as stopped.
const STANDSTILL_HOLD: Duration = Duration::from_millis(300);
/// Slower than this is standing: m/s and rad/s. Above the noise of wheel odometry at rest.
const STANDSTILL_SPEED: f64 = 0.02;
/// After the drive was let go of, replies are still read for this long.
const CLOSING: Duration = Duration::from_millis(200);
/// Beacons read in one turn at most.
const BEACONS_PER_TURN: usize = 1024;

/// What a loop is made of.
pub struct LoopParts {
    /// Who it drives and how.
    pub file: RobotFile,
    /// The hardware.
    pub adapter: Adapter,
    /// The beacon plane.
    pub beacons: Box<dyn Link>,
    /// Which life of this robot: greater after every restart.
    pub epoch: u32,
    /// What writes down what it is given, decides and sends; none: nothing is recorded.
    pub recording: Option<Recording>,
}

/// How far the loop is on its way to the end.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Phase {
    Running,
    /// Told to end: standing still is awaited.
    Stopping {
        since: Stamp,
        still_since: Option<Stamp>,
    },
    /// The drive was let go of.
    Closing {
        since: Stamp,
    },
    Ended,
}

/// The run loop of one robot.
pub struct RobotLoop {
    file: RobotFile,
    node: Node,
    adapter: Adapter,
    beacons: Box<dyn Link>,
    swarm: u32,
    beacon_seq: u8,
    phase: Phase,
    last_scan_tick: Option<Stamp>,
    fresh_scan: bool,
    seen_stopped: bool,
    drive_seen_ready: bool,
    reached_before_end: bool,
    withheld_commands: u64,
    aged_commands: u64,
    beacons_refused: u64,
    links: LinkCounters,
    recording: Option<Recording>,
}

impl RobotLoop {
    /// A loop that has not turned yet.
    #[must_use]
    pub fn new(parts: LoopParts, now: Stamp) -> Self {
        Self {
            node: Node::new(&parts.file, parts.epoch, now),
            swarm: beacon::swarm_hash(&parts.file.swarm),
            file: parts.file,
            adapter: parts.adapter,
            beacons: parts.beacons,
            beacon_seq: 0,
            phase: Phase::Running,
            last_scan_tick: None,
            fresh_scan: false,
            seen_stopped: false,
            drive_seen_ready: false,
            reached_before_end: false,
            withheld_commands: 0,
            aged_commands: 0,
            beacons_refused: 0,
            links: LinkCounters::default(),
            recording: parts.recording,
        }
    }

    /// One turn: read, decide, write. Never blocks.
    pub fn turn(&mut self, clock: &dyn Clock) {
        let now = clock.now();
        if let Some(recording) = &self.recording {
            recording.tape.turn(now);
        }
        self.receive(now);
        self.adapter.handle_timeout(now);
        self.digest(now);
        if self.tick_due(now) {
            self.tick(now, clock);
        }
        self.tell_peers(now);
        self.adapter.flush(&mut self.links);
        self.advance_phase(now);
    }

    /// When the next turn is due if nothing arrives before, and why.
    #[must_use]
    pub fn poll_timeout(&self) -> (Stamp, &'static str) {
        let scan = self.scan_tick_due().map(|due| (due, "fresh scan"));
        let codec = self.adapter.poll_timeout();
        [scan, codec].into_iter().flatten().fold(self.node.poll_timeout(), std::cmp::min)
    }

    /// Ready when a link may have something to read.
    pub fn poll_readable(&mut self, cx: &mut Context<'_>) -> Poll<()> {
        let adapter = self.adapter.poll_readable(cx).is_ready();
        let beacons = self.beacons.poll_readable(cx).is_ready();
        if adapter || beacons { Poll::Ready(()) } else { Poll::Pending }
    }

    /// Stop the robot for good and end: [`RobotLoop::ended`] turns true once it was seen standing, or after a patience.
    pub fn begin_end(&mut self, now: Stamp, reason: StopReason) {
        if self.phase == Phase::Running {
            if let Some(recording) = &self.recording {
                recording.tape.told_to_end(now, reason.to_string());
            }
            self.reached_before_end = self.node.status().reached;
            self.node.handle_stop(now, reason);
            self.phase = Phase::Stopping { since: now, still_since: None };
        }
    }

    /// Whether there is nothing left to do.
    #[must_use]
    pub fn ended(&self) -> bool {
        self.phase == Phase::Ended
    }

    /// Whether the robot was seen to stand still after it was told to end.
    #[must_use]
    pub const fn seen_stopped(&self) -> bool {
        self.seen_stopped
    }

    /// Whether the task was done when the loop was told to end.
    #[must_use]
    pub const fn reached_before_end(&self) -> bool {
        self.reached_before_end
    }

    /// What the node makes of it all.
    #[must_use]
    pub fn status(&self) -> &Status {
        self.node.status()
    }

    /// The newest scan.
    #[must_use]
    pub fn scan(&self) -> Option<&Scan> {
        self.node.scan()
    }

    /// The map that it makes, if its behaviour makes one.
    #[must_use]
    pub fn map(&self) -> Option<&SharedMap> {
        self.node.map()
    }

    /// The peers that are heard, sorted by id.
    pub fn heard(&self, now: Stamp) -> impl Iterator<Item = HeardPeer> + '_ {
        self.node.heard(now)
    }

    /// Whom this loop drives.
    #[must_use]
    pub const fn file(&self) -> &RobotFile {
        &self.file
    }

    /// What the links have been through.
    #[must_use]
    pub const fn links(&self) -> &LinkCounters {
        &self.links
    }

    /// Commands replaced by STOP because `command_age_ms` was over before they could be sent.
    #[must_use]
    pub const fn withheld_commands(&self) -> u64 {
        self.withheld_commands
    }

    /// Commands that were older than `command_age_ms` when they had left.
    #[must_use]
    pub const fn aged_commands(&self) -> u64 {
        self.aged_commands
    }

    /// Messages on the beacon plane that were not valid.
    #[must_use]
    pub const fn beacons_refused(&self) -> u64 {
        self.beacons_refused
    }

    fn receive(&mut self, now: Stamp) {
        self.adapter.receive(now, &mut self.links);
        let mut buf = [0; 512];
        for _ in 0..BEACONS_PER_TURN {
            match self.beacons.try_recv(&mut buf) {
                Ok(Some(len)) => self.hear(now, &buf[..len]),
                Ok(None) | Err(_) => break,
            }
        }
    }

    fn hear(&mut self, now: Stamp, bytes: &[u8]) {
        match beacon::decode(bytes) {
            Ok(Message::Beacon { swarm, beacon }) if swarm == self.swarm => self.node.handle_beacon(now, &beacon),
            Ok(Message::Links { swarm, report }) if swarm == self.swarm => self.node.handle_links(now, &report),
            Ok(Message::Map { swarm, report }) if swarm == self.swarm => self.node.handle_map(now, &report),
            Ok(Message::Stop { swarm, robot }) if swarm == self.swarm => {
                if robot.is_none_or(|id| id.0 == self.file.robot.id) {
                    self.node.handle_stop(now, StopReason::Operator);
                }
            }
            Ok(Message::Beacon { .. } | Message::Links { .. } | Message::Map { .. } | Message::Stop { .. }) => {}
            Err(_) => self.beacons_refused += 1,
        }
    }

    fn digest(&mut self, now: Stamp) {
        while let Some(event) = self.adapter.poll_event() {
            match &event {
                Event::Scan(scan) => {
                    self.fresh_scan = true;
                    if let Some(recording) = &mut self.recording {
                        recording.witness.scanned(scan);
                    }
                }
                Event::Text(severity, text) => self.log(now, *severity, text),
                Event::Drive(DriveState::Ready(watchdog)) => {
                    self.drive_seen_ready = true;
                    // A drive that goes on when we die is said aloud; what is as it should be is there for who asks.
                    let severity = if *watchdog == Watchdog::Absent { Severity::Warning } else { Severity::Info };
                    self.log(now, severity, &format!("the drive obeys; {watchdog}"));
                }
                // Some refusals last until a human acts: they must be heard of.
                Event::Drive(state @ DriveState::Refused(_)) => {
                    self.log(now, Severity::Warning, &format!("drive: {state}"))
                }
                Event::Drive(state) => self.log(now, Severity::Info, &format!("drive: {state}")),
                Event::Odometry(_) | Event::Pose(_) | Event::Battery(_) => {}
            }
            self.node.handle_event(now, event);
        }
    }

    fn log(&mut self, now: Stamp, severity: Severity, text: &str) {
        let id = self.file.robot.id;
        if let Some(recording) = &mut self.recording {
            recording.witness.said(now, severity, text);
        }
        match severity {
            Severity::Info => tracing::info!(robot = id, "{text}"),
            Severity::Warning => tracing::warn!(robot = id, "{text}"),
            Severity::Error => tracing::error!(robot = id, "{text}"),
        }
    }

    fn tick_due(&self, now: Stamp) -> bool {
        self.node.tick_due(now) || self.scan_tick_due().is_some_and(|due| now >= due)
    }

    /// When the scan that has come may be acted on.
    fn scan_tick_due(&self) -> Option<Stamp> {
        self.fresh_scan.then(|| self.last_scan_tick.map_or(Stamp::ZERO, |last| last + SCAN_TICK_SPACING_MIN))
    }

    fn tick(&mut self, now: Stamp, clock: &dyn Clock) {
        if std::mem::take(&mut self.fresh_scan) {
            self.last_scan_tick = Some(now);
        }
        let command = self.node.tick(now);
        if let Some(recording) = &mut self.recording {
            recording.witness.decided(self.node.status());
        }
        if matches!(self.phase, Phase::Closing { .. } | Phase::Ended) {
            return;
        }
        let age_max = Duration::from_millis(u64::from(self.file.kind.timeouts.command_age_ms));
        if self.look_again(clock).since(now) > age_max {
            // The computer was held up since the tick began: the world has moved on (invariant 3).
            self.withheld_commands += 1;
            self.adapter.command(now, SafeCommand::STOP);
            self.adapter.flush(&mut self.links);
            return;
        }
        self.adapter.command(now, command);
        self.adapter.flush(&mut self.links);
        // Between the look at the clock and the socket lie microseconds, unless the computer was held up just there.
        self.aged_commands += u64::from(self.look_again(clock).since(now) > age_max);
    }

    /// What the clock shows by now; on the tape, because what follows depends on it.
    fn look_again(&self, clock: &dyn Clock) -> Stamp {
        let now = clock.now();
        if let Some(recording) = &self.recording {
            recording.tape.clock(now);
        }
        now
    }

    fn tell_peers(&mut self, now: Stamp) {
        let Some(beacon) = self.node.poll_beacon(now) else { return };
        let bytes = beacon::encode_beacon(self.swarm, &beacon, self.beacon_seq);
        self.say(&bytes);
        if let Some(report) = self.node.poll_links() {
            let bytes = links::encode_links(self.swarm, &report, self.beacon_seq);
            self.say(&bytes);
        }
        while let Some(report) = self.node.poll_map() {
            let bytes = map::encode_map(self.swarm, &report, self.beacon_seq);
            self.say(&bytes);
        }
    }

    /// A message that cannot be sent is replaced by the next one; peers notice the silence by themselves.
    fn say(&mut self, bytes: &[u8]) {
        self.beacon_seq = self.beacon_seq.wrapping_add(1);
        if self.beacons.send(bytes).is_err() {
            self.links.errors += 1;
        }
    }

    fn advance_phase(&mut self, now: Stamp) {
        self.phase = match self.phase {
            Phase::Running => Phase::Running,
            Phase::Stopping { since, still_since } => self.await_standstill(now, since, still_since),
            Phase::Closing { since } if now.since(since) >= CLOSING => Phase::Ended,
            Phase::Closing { since } => Phase::Closing { since },
            Phase::Ended => Phase::Ended,
        };
    }

    fn await_standstill(&mut self, now: Stamp, since: Stamp, still_since: Option<Stamp>) -> Phase {
        let still_since = if self.stands(now) { still_since.or(Some(now)) } else { None };
        let seen = still_since.is_some_and(|still| now.since(still) >= STANDSTILL_HOLD);
        if !seen && self.drive_seen_ready && now.since(since) < STANDSTILL_PATIENCE {
            return Phase::Stopping { since, still_since };
        }
        // A drive that never obeyed has nothing to be seen; its robot has not been moved by us.
        self.seen_stopped = seen || !self.drive_seen_ready;
        self.adapter.shutdown(now);
        self.adapter.flush(&mut self.links);
        Phase::Closing { since: now }
    }

    /// Fresh odometry says that nothing moves.
    fn stands(&self, now: Stamp) -> bool {
        let age_max = Duration::from_millis(u64::from(self.file.kind.timeouts.odometry_ms));
        let status = self.node.status();
        let fresh = status.odometry_age.is_some_and(|age| age + now.since(status.stamp) <= age_max);
        let twist_b = status.twist_b;
        fresh && twist_b.speed_mps.abs() < STANDSTILL_SPEED && twist_b.yaw_rate_radps.abs() < STANDSTILL_SPEED
    }
}
