//! What is due again and again.

use drover_contract::Stamp;
use std::time::Duration;

/// Something that is due again and again.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Periodic {
    due: Stamp,
    period: Duration,
}

impl Periodic {
    /// First due at `due`, then every `period`.
    pub(crate) fn new(due: Stamp, period: Duration) -> Self {
        Self { due, period }
    }

    /// Whether it is due; if so, it is next due a period later. Missed turns are not made up for.
    pub(crate) fn take(&mut self, now: Stamp) -> bool {
        if now < self.due {
            return false;
        }
        let next = self.due + self.period;
        self.due = if next > now { next } else { now + self.period };
        true
    }

    /// From one turn to the next.
    pub(crate) fn period(&self) -> Duration {
        self.period
    }
}
