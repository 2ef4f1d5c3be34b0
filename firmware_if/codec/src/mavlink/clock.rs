//! TIMESYNC (111): how long a question takes to the autopilot and back.

use drover_contract::{MavId, Stamp};
use mavlink::dialects::common::{MavMessage, TIMESYNC_DATA};
use std::time::Duration;

const SPACING: Duration = Duration::from_secs(5);
/// An answer that took longer than this measured something else.
const ROUND_TRIP_MAX: Duration = Duration::from_secs(2);

/// Asks, answers and measures.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Timesync {
    next: Stamp,
    asked: Option<Stamp>,
    round_trip: Option<Duration>,
}

impl Timesync {
    pub(crate) const fn new(now: Stamp) -> Self {
        Self { next: now, asked: None, round_trip: None }
    }

    pub(crate) const fn round_trip(&self) -> Option<Duration> {
        self.round_trip
    }

    pub(crate) const fn due(&self) -> Stamp {
        self.next
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
    pub(crate) fn handle(&mut self, now: Stamp, wire: &TIMESYNC_DATA, from: MavId) -> Option<MavMessage> {
        if wire.tc1 == 0 {
            return Some(message(nanoseconds(now), wire.ts1, from));
        }
        let asked = self.asked.filter(|asked| nanoseconds(*asked) == wire.ts1)?;
        self.asked = None;
        let took = now.since(asked);
        if took <= ROUND_TRIP_MAX {
            self.round_trip = Some(took);
        }
        None
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
