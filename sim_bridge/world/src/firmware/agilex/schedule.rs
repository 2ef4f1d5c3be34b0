//! How often a chassis sends what: the periods of the manuals' tables.

use super::AgilexSimParams;
use crate::periodic::Periodic;
use drover_codec::can::agilex::Model;
use drover_contract::Stamp;
use std::time::Duration;

const FAST: Duration = Duration::from_millis(20);
const STATE_PERIOD: Duration = Duration::from_millis(100);
const BMS_PERIOD: Duration = Duration::from_millis(500);

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
        let every = |period| Periodic::new(start, period);
        let state = if params.model == Model::Tracer { FAST } else { STATE_PERIOD };
        Self { state: every(state), fast: every(FAST), motors: every(params.motor_period), bms: every(BMS_PERIOD) }
    }
}
