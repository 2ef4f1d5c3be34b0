//! TIMESYNC (111): how long a question takes to the autopilot and back, and whether the autopilot has restarted.
//!
//! An autopilot answers with the time since it started; it does so even where its telemetry is switched off.

use drover_contract::{MavId, Stamp};
use mavlink::dialects::common::{MavMessage, TIMESYNC_DATA};
use std::time::Duration;

const SPACING: Duration = Duration::from_secs(5);
/// An answer that took longer than this measured something else.
const ROUND_TRIP_MAX: Duration = Duration::from_secs(2);

/// The autopilot's time may fall by this much (answers are corrected for the way of the question) without a restart.
const FALL_NS_MAX: i64 = 1_000_000_000;

/// What a message means for us.
#[derive(Clone, Debug)]
pub(crate) enum Heard {
    /// A question: this is the answer to it.
    Question(Box<MavMessage>),
    /// The autopilot's time has fallen.
    Restart,
    /// Nothing to be done.
    Nothing,
}

/// Asks, answers and measures.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Timesync {
    next: Stamp,
    asked: Option<Stamp>,
    round_trip: Option<Duration>,
    /// What the autopilot answered last, nanoseconds since it started.
    answered_ns: Option<i64>,
}

impl Timesync {
    pub(crate) const fn new(now: Stamp) -> Self {
        Self { next: now, asked: None, round_trip: None, answered_ns: None }
    }

    pub(crate) const fn round_trip(&self) -> Option<Duration> {
        self.round_trip
    }

    pub(crate) const fn due(&self) -> Stamp {
        self.next
    }

    /// The autopilot has restarted: its time starts anew.
    pub(crate) fn forget(&mut self) {
        self.answered_ns = None;
    }

    /// The question, when it is time for one.
    pub(crate) fn ask(&mut self, now: Stamp, to: MavId) -> Option<MavMessage> {
        if now < self.next {
            return None;
        }
        self.next = now + SPACING;
        self.asked = Some(now);
        Some(message(0, nanoseconds(now), to))
    }

    /// A question is answered with our time; an answer to our own question is measured.
    pub(crate) fn handle(&mut self, now: Stamp, wire: &TIMESYNC_DATA, from: MavId) -> Heard {
        if wire.tc1 == 0 {
            return Heard::Question(Box::new(message(nanoseconds(now), wire.ts1, from)));
        }
        let Some(asked) = self.asked.filter(|asked| nanoseconds(*asked) == wire.ts1) else { return Heard::Nothing };
        self.asked = None;
        let took = now.since(asked);
        if took <= ROUND_TRIP_MAX {
            self.round_trip = Some(took);
        }
        let before = self.answered_ns.replace(wire.tc1);
        let fell = before.is_some_and(|before| wire.tc1 < before.saturating_sub(FALL_NS_MAX));
        if fell { Heard::Restart } else { Heard::Nothing }
    }
}

fn message(tc1: i64, ts1: i64, to: MavId) -> MavMessage {
    let (target_system, target_component) = (to.system, to.component);
    MavMessage::TIMESYNC(TIMESYNC_DATA { tc1, ts1, target_system, target_component })
}

/// Never 0, which would read as a question.
fn nanoseconds(stamp: Stamp) -> i64 {
    i64::try_from(stamp.as_micros()).unwrap_or(i64::MAX).saturating_mul(1_000).saturating_add(1)
}
