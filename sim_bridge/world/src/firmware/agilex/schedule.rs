//! How often a chassis sends what: the periods of the manuals' tables.

use super::AgilexSimParams;
use drover_codec::can::agilex::Model;
use drover_contract::Stamp;
use std::time::Duration;

const FAST: Duration = Duration::from_millis(20);
const STATE_PERIOD: Duration = Duration::from_millis(100);
const BMS_PERIOD: Duration = Duration::from_millis(500);

/// A frame that is due again and again.
#[derive(Clone, Copy, Debug)]
pub(super) struct Periodic {
    due: Stamp,
    period: Duration,
}

impl Periodic {
    /// Whether it is due; if so, it is next due a period later. Missed turns are not made up for.
    pub(super) fn take(&mut self, now: Stamp) -> bool {
        if now < self.due {
            return false;
        }
        let next = self.due + self.period;
        self.due = if next > now { next } else { now + self.period };
        true
    }
}

/// When each kind of frame is due.
#[derive(Clone, Copy, Debug)]
pub(super) struct Schedule {
    pub(super) state: Periodic,
    pub(super) fast: Periodic,
    pub(super) motors: Periodic,
    pub(super) bms: Periodic,
}

impl Schedule {
    pub(super) fn new(params: &AgilexSimParams, start: Stamp) -> Self {
        let every = |period| Periodic { due: start, period };
        let state = if params.model == Model::Tracer { FAST } else { STATE_PERIOD };
        Self { state: every(state), fast: every(FAST), motors: every(params.motor_period), bms: every(BMS_PERIOD) }
    }
}
