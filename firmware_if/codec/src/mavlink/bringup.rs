//! From silent to driving: what to ask an ArduPilot Rover next, and why it does not drive yet.
//!
//! heartbeat -> pre-arm check -> HOLD -> arm -> GUIDED -> telemetry -> heartbeat shows armed and GUIDED -> ready.
//!
//! HOLD comes before arming because the autopilot keeps a setpoint that reached it in GUIDED while disarmed and drives
//! it as soon as it is armed; entering GUIDED anew clears it. An acknowledgement alone never makes a drive ready: its
//! own HEARTBEAT must show it.
//!
//! Once it was ready, a heartbeat that shows another mode or disarmed is somebody else's decision: an operator's at a
//! ground station, or a failsafe's of the autopilot itself. No mode and no arming is asked for then, whatever else
//! happens on the link, until the autopilot has restarted. When its heartbeat shows armed and GUIDED again, authority
//! was given back: what it may still follow is stopped, telemetry asked for, and it is ready for fresh commands.
//!
//! Pure: time is an argument, requests are polled.

use super::raw::Heartbeat;
use super::request::{Request, ack};
use super::{id, mode};
use drover_contract::{DriveState, Severity, Stamp, Watchdog};
use std::collections::VecDeque;
use std::time::Duration;

/// ArduPilot Rover stops by itself so long after its last setpoint; it is no parameter.
const SETPOINT_WATCHDOG: Duration = Duration::from_secs(3);
/// An acknowledgement takes 8 to 14 ms from a real autopilot; a request without one is repeated after this.
const ACK_PATIENCE: Duration = Duration::from_millis(700);
/// So often a request is sent before its silence counts as a refusal.
const TRIES_MAX: u8 = 4;
/// A request that the autopilot is still working on may take this long.
const PROGRESS_PATIENCE: Duration = Duration::from_secs(5);
/// A real autopilot needs 42 s for its position. With its checks turned off the bit never rises, so at some point
/// arming is tried anyway: the autopilot itself refuses if it is not ready.
const PREARM_PATIENCE: Duration = Duration::from_secs(60);
/// HEARTBEAT comes at 1 Hz: two of them may be lost before an accepted mode counts as not taken.
const CONFIRM_PATIENCE: Duration = Duration::from_millis(3500);
/// The first pause after a refusal; it doubles with each refusal in a row.
const PAUSE_MIN: Duration = Duration::from_secs(1);
const PAUSE_MAX: Duration = Duration::from_secs(8);
/// A text explains a refusal if it came at most this long before it.
const TEXT_AGE_MAX: Duration = Duration::from_secs(2);
/// Let go of the drive: so often, so far apart.
const RELEASE_TRIES: u8 = 6;
const RELEASE_SPACING: Duration = Duration::from_millis(400);

/// The telemetry that is asked for, in this order; the first two are needed to drive.
const STREAMS: [u32; 4] = [id::LOCAL_POSITION_NED, id::ATTITUDE, id::SYS_STATUS, id::BATTERY_STATUS];
const STREAMS_NEEDED: usize = 2;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Step {
    /// No heartbeat of an autopilot.
    Silent,
    /// Its pre-arm check has not passed.
    Prearm,
    Hold,
    Arm,
    Guided,
    /// Asking for telemetry number so and so.
    Stream(usize),
    /// All accepted; its heartbeat has to show it.
    Confirm,
    Ready,
    /// Refused, or lost: try again at this moment.
    Pause(Stamp),
    /// Somebody else has decided how it is: wait until they let go or, once it was ready, give it back.
    Taken,
    /// It is no ground rover that we know how to drive.
    Foreign,
    /// Let go of for good.
    Released,
}

/// The request that waits for its acknowledgement.
#[derive(Clone, Copy, Debug)]
struct Pending {
    request: Request,
    tries: u8,
    due: Stamp,
}

/// The state machine. One an autopilot.
#[derive(Debug)]
pub(crate) struct BringUp {
    telemetry_hz: u32,
    step: Step,
    since: Stamp,
    state: DriveState,
    pending: Option<Pending>,
    outbox: VecDeque<(Request, u8)>,
    heartbeat: Option<Heartbeat>,
    prearm_ok: bool,
    /// The newest heartbeat since GUIDED was asked for shows armed and GUIDED.
    confirmed: bool,
    /// It was ready since it last started: who changes its mode now has decided, and nothing here undoes it.
    led: bool,
    /// What it may still follow has to be stopped.
    stop_due: bool,
    refusals: u32,
    /// The newest complaint: it may explain a refusal.
    complaint: Option<(Stamp, String)>,
    /// The refusal in words, without the complaint.
    refusal: Option<(Stamp, String)>,
    releases: u8,
}

impl BringUp {
    pub(crate) fn new(telemetry_hz: u32, now: Stamp) -> Self {
        Self {
            telemetry_hz,
            step: Step::Silent,
            since: now,
            state: DriveState::Silent,
            pending: None,
            outbox: VecDeque::new(),
            heartbeat: None,
            prearm_ok: false,
            confirmed: false,
            led: false,
            stop_due: false,
            refusals: 0,
            complaint: None,
            refusal: None,
            releases: 0,
        }
    }

    pub(crate) const fn state(&self) -> &DriveState {
        &self.state
    }

    pub(crate) fn is_ready(&self) -> bool {
        self.step == Step::Ready
    }

    /// The next request, with its confirmation number (how often it was sent before).
    pub(crate) fn poll_request(&mut self) -> Option<(Request, u8)> {
        self.outbox.pop_front()
    }

    /// Whether a zero setpoint has to leave now; it is said once.
    pub(crate) fn take_stop(&mut self) -> bool {
        std::mem::take(&mut self.stop_due)
    }

    /// When time alone changes something.
    pub(crate) fn poll_timeout(&self) -> Option<(Stamp, &'static str)> {
        if let Some(pending) = self.pending {
            return Some((pending.due, "acknowledgement"));
        }
        match self.step {
            Step::Prearm => Some((self.since + PREARM_PATIENCE, "pre-arm check")),
            Step::Confirm => Some((self.since + CONFIRM_PATIENCE, "heartbeat in GUIDED")),
            Step::Pause(until) => Some((until, "next try")),
            Step::Released if self.releases < RELEASE_TRIES => Some((self.since + RELEASE_SPACING, "release")),
            Step::Silent | Step::Hold | Step::Arm | Step::Guided | Step::Stream(_) => None,
            Step::Ready | Step::Taken | Step::Foreign | Step::Released => None,
        }
    }

    pub(crate) fn handle_timeout(&mut self, now: Stamp) {
        if let Some(pending) = self.pending {
            if pending.due <= now {
                self.retry(now, pending);
            }
            return;
        }
        if self.poll_timeout().is_none_or(|(due, _)| due > now) {
            return;
        }
        match self.step {
            Step::Prearm => self.enter(now, Step::Hold),
            Step::Confirm => self.refuse(now, self.contradiction()),
            Step::Pause(_) => self.begin(now),
            Step::Released => self.repeat_release(now),
            Step::Silent | Step::Hold | Step::Arm | Step::Guided | Step::Stream(_) => {}
            Step::Ready | Step::Taken | Step::Foreign => {}
        }
    }

    /// The autopilot's own heartbeat.
    pub(crate) fn handle_heartbeat(&mut self, now: Stamp, heartbeat: Heartbeat) {
        self.heartbeat = Some(heartbeat);
        let driving = obeying(heartbeat);
        match self.step {
            Step::Silent if drivable(heartbeat) => self.begin(now),
            Step::Silent | Step::Foreign => self.judge_foreign(now, heartbeat),
            Step::Stream(_) | Step::Ready | Step::Pause(_) | Step::Taken if self.led && !driving => {
                self.respect(now, heartbeat);
            }
            Step::Taken if self.led => self.resume(now),
            Step::Prearm if heartbeat.armed() => self.enter(now, Step::Hold),
            Step::Stream(_) => self.confirmed = driving,
            Step::Confirm if driving => self.enter(now, Step::Ready),
            Step::Taken if released(heartbeat) => self.pause(now, PAUSE_MIN),
            Step::Prearm | Step::Hold | Step::Arm | Step::Guided | Step::Confirm => {}
            Step::Ready | Step::Pause(_) | Step::Taken | Step::Released => {}
        }
    }

    /// SYS_STATUS said whether it would arm.
    pub(crate) fn handle_prearm(&mut self, now: Stamp, ok: bool) {
        self.prearm_ok = ok;
        if ok && self.step == Step::Prearm {
            self.enter(now, Step::Hold);
        }
    }

    /// An acknowledgement that is meant for us. Whether it answered what was asked.
    pub(crate) fn handle_ack(&mut self, now: Stamp, command: u16, result: u8) -> bool {
        let Some(pending) = self.pending.filter(|pending| pending.request.command() == command) else {
            return false;
        };
        match result {
            ack::ACCEPTED => {
                self.pending = None;
                self.advance(now);
            }
            ack::IN_PROGRESS => self.pending = Some(Pending { due: now + PROGRESS_PATIENCE, ..pending }),
            _ if self.dispensable() => {
                self.pending = None;
                self.advance(now);
            }
            _ => self.refuse(now, format!("{} {}", pending.request.words(), ack::words(result))),
        }
        true
    }

    /// The autopilot's words: they may explain a refusal, and come before or after its acknowledgement.
    pub(crate) fn handle_text(&mut self, now: Stamp, severity: Severity, text: &str) {
        if severity < Severity::Warning && !text.starts_with("Arm:") && !text.starts_with("PreArm:") {
            return;
        }
        self.complaint = Some((now, text.to_owned()));
        if let Some((when, words)) = &self.refusal
            && now.since(*when) <= TEXT_AGE_MAX
            && matches!(self.state, DriveState::Refused(_))
        {
            self.state = DriveState::Refused(format!("{words} ({text})"));
        }
    }

    /// The autopilot has restarted: nobody has decided anything about it yet.
    pub(crate) fn handle_restart(&mut self, now: Stamp) {
        self.led = false;
        self.refusals = 0;
        self.handle_lost(now);
    }

    /// Nothing was heard for too long. Who has decided about it is not forgotten.
    pub(crate) fn handle_lost(&mut self, now: Stamp) {
        self.heartbeat = None;
        self.prearm_ok = false;
        self.pending = None;
        self.outbox.clear();
        self.stop_due = false;
        if self.step != Step::Released {
            self.step = Step::Silent;
            self.since = now;
            self.state = DriveState::Silent;
        }
    }

    /// Let go of the drive for good: HOLD, disarm, and again until its heartbeat shows it. A drive that somebody else
    /// has taken is theirs: nothing is sent to it. Whether it was ours to let go of.
    pub(crate) fn release(&mut self, now: Stamp) -> bool {
        if self.step == Step::Released {
            return false;
        }
        let ours = !matches!(self.step, Step::Taken | Step::Foreign);
        self.step = Step::Released;
        self.state = DriveState::BringUp("shut down");
        self.pending = None;
        self.outbox.clear();
        if ours {
            self.repeat_release(now);
        } else {
            self.releases = RELEASE_TRIES;
        }
        ours
    }

    /// Ask again for what driving needs: somebody else on the link may have changed the rates.
    pub(crate) fn refresh_streams(&mut self) {
        for message in &STREAMS[..STREAMS_NEEDED] {
            self.outbox.push_back((Request::Interval { message: *message, hz: self.telemetry_hz }, 0));
        }
    }

    fn begin(&mut self, now: Stamp) {
        match self.heartbeat {
            Some(seen) if self.led && obeying(seen) => self.resume(now),
            Some(seen) if self.led => self.respect(now, seen),
            Some(seen) if !released(seen) => self.yield_to_driver(now, seen),
            Some(seen) if seen.armed() || self.prearm_ok => self.enter(now, Step::Hold),
            Some(_) | None => self.enter(now, Step::Prearm),
        }
    }

    /// A human or a mission drives it: keep off until they let go.
    fn yield_to_driver(&mut self, now: Stamp, seen: Heartbeat) {
        let name = mode::name(seen.custom_mode);
        self.explain(now, format!("somebody drives it in mode {name}, waiting for HOLD"));
        self.leave_alone(now);
    }

    /// It was ready and is not any more, and that was not us: keep off until it is given back.
    fn respect(&mut self, now: Stamp, seen: Heartbeat) {
        let name = mode::name(seen.custom_mode);
        let what = if seen.armed() { format!("{name} was set") } else { format!("it was disarmed (mode {name})") };
        let words = format!("{what} by somebody else (or a failsafe): set GUIDED and arm, or start this program anew");
        if self.step == Step::Taken && self.refusal.as_ref().is_some_and(|(_, told)| *told == words) {
            return;
        }
        self.explain(now, words);
        self.leave_alone(now);
    }

    fn leave_alone(&mut self, now: Stamp) {
        self.pending = None;
        self.outbox.clear();
        self.step = Step::Taken;
        self.since = now;
    }

    /// It is armed and in GUIDED as we left it, or was given back: its mode is not touched. What it may still follow
    /// is stopped, and it may have forgotten who gets which telemetry.
    fn resume(&mut self, now: Stamp) {
        self.stop_due = true;
        self.confirmed = true;
        self.enter(now, Step::Stream(0));
    }

    fn enter(&mut self, now: Stamp, step: Step) {
        self.step = step;
        self.since = now;
        self.refusal = None;
        let (words, request) = match step {
            Step::Prearm => ("waiting for pre-arm check", None),
            Step::Hold => ("setting HOLD", Some(Request::Mode(mode::HOLD))),
            Step::Arm => ("arming", Some(Request::Arm(true))),
            Step::Guided => ("setting GUIDED", Some(Request::Mode(mode::GUIDED))),
            Step::Stream(index) => ("asking for telemetry", Some(self.stream(index))),
            Step::Confirm => ("waiting for its heartbeat to show GUIDED", None),
            Step::Ready => {
                self.led = true;
                self.refusals = 0;
                self.state = DriveState::Ready(Watchdog::Fixed(SETPOINT_WATCHDOG));
                return;
            }
            Step::Silent | Step::Pause(_) | Step::Taken | Step::Foreign | Step::Released => return,
        };
        if step == Step::Guided {
            self.confirmed = false;
        }
        self.state = DriveState::BringUp(words);
        if let Some(request) = request {
            self.send(Pending { request, tries: 1, due: now + ACK_PATIENCE });
        }
    }

    fn stream(&self, index: usize) -> Request {
        let hz = if index < STREAMS_NEEDED { self.telemetry_hz } else { 1 };
        Request::Interval { message: STREAMS[index], hz }
    }

    fn send(&mut self, pending: Pending) {
        self.pending = Some(pending);
        self.outbox.push_back((pending.request, pending.tries - 1));
    }

    fn retry(&mut self, now: Stamp, pending: Pending) {
        if pending.tries < TRIES_MAX {
            self.send(Pending { tries: pending.tries + 1, due: now + ACK_PATIENCE, ..pending });
        } else if self.dispensable() {
            self.pending = None;
            self.advance(now);
        } else {
            self.refuse(now, format!("{} not acknowledged", pending.request.words()));
        }
    }

    /// Whether what is asked for now can be done without.
    fn dispensable(&self) -> bool {
        matches!(self.step, Step::Stream(index) if index >= STREAMS_NEEDED)
    }

    fn advance(&mut self, now: Stamp) {
        let next = match self.step {
            Step::Hold => Step::Arm,
            Step::Arm => Step::Guided,
            Step::Guided => Step::Stream(0),
            Step::Stream(index) if index + 1 < STREAMS.len() => Step::Stream(index + 1),
            Step::Stream(_) if self.confirmed => Step::Ready,
            Step::Stream(_) => Step::Confirm,
            step @ (Step::Silent | Step::Prearm | Step::Confirm | Step::Ready) => step,
            step @ (Step::Pause(_) | Step::Taken | Step::Foreign | Step::Released) => step,
        };
        if next != self.step {
            self.enter(now, next);
        }
    }

    /// Refused: say so, and try again after a pause.
    fn refuse(&mut self, now: Stamp, words: String) {
        self.explain(now, words);
        let wait = PAUSE_MIN.saturating_mul(1 << self.refusals.min(3)).min(PAUSE_MAX);
        self.refusals = self.refusals.saturating_add(1);
        self.pause(now, wait);
    }

    /// Say why it does not drive, in our words and those that it has just said itself.
    fn explain(&mut self, now: Stamp, words: String) {
        let fresh = self.complaint.as_ref().filter(|(when, _)| now.since(*when) <= TEXT_AGE_MAX);
        self.state = DriveState::Refused(match fresh {
            Some((_, text)) => format!("{words} ({text})"),
            None => words.clone(),
        });
        self.refusal = Some((now, words));
    }

    fn pause(&mut self, now: Stamp, wait: Duration) {
        self.pending = None;
        self.outbox.clear();
        self.step = Step::Pause(now + wait);
        self.since = now;
    }

    fn contradiction(&self) -> String {
        match self.heartbeat {
            Some(seen) if seen.armed() => format!("its heartbeat shows mode {}", mode::name(seen.custom_mode)),
            Some(_) => "its heartbeat shows it disarmed".into(),
            None => "no heartbeat".into(),
        }
    }

    fn judge_foreign(&mut self, now: Stamp, heartbeat: Heartbeat) {
        if drivable(heartbeat) {
            self.begin(now);
            return;
        }
        self.step = Step::Foreign;
        let Heartbeat { vehicle_type, autopilot, .. } = heartbeat;
        self.state = DriveState::Refused(format!(
            "vehicle type {vehicle_type} with autopilot {autopilot} is not an ArduPilot ground rover"
        ));
    }

    fn repeat_release(&mut self, now: Stamp) {
        self.since = now;
        let seen_disarmed = self.heartbeat.is_some_and(|seen| !seen.armed() && seen.custom_mode == mode::HOLD);
        if seen_disarmed && self.releases > 0 {
            self.releases = RELEASE_TRIES;
            return;
        }
        self.outbox.push_back((Request::Mode(mode::HOLD), self.releases));
        self.outbox.push_back((Request::Arm(false), self.releases));
        self.releases += 1;
    }
}

/// MAV_TYPE_GROUND_ROVER under MAV_AUTOPILOT_ARDUPILOTMEGA: the mode numbers mean other things elsewhere.
const fn drivable(heartbeat: Heartbeat) -> bool {
    heartbeat.vehicle_type == 10 && heartbeat.autopilot == 3
}

/// Whether it does what a computer asks: armed, in GUIDED.
const fn obeying(heartbeat: Heartbeat) -> bool {
    heartbeat.armed() && heartbeat.custom_mode == mode::GUIDED
}

/// Whether nobody else is driving: it is disarmed, holding, obeying a computer or starting up.
const fn released(heartbeat: Heartbeat) -> bool {
    !heartbeat.armed() || matches!(heartbeat.custom_mode, mode::HOLD | mode::GUIDED | mode::INITIALISING)
}
