//! What a CAN bus has been through, and whether one may send on it: the part of a bus that needs no kernel.

use crate::errno::link_error;
use ::socketcan::CanError;
use ::socketcan::errors::ControllerProblems;
use drover_contract::{BusHealth, LinkError};
use std::io;
use std::time::{Duration, Instant};

/// How long nothing is sent after the transmit queue was full for the first time.
const PAUSE_MIN: Duration = Duration::from_millis(5);
/// The pause doubles with each further time, up to this: well under the 500 ms after which a chassis stops.
const PAUSE_MAX: Duration = Duration::from_millis(100);

#[derive(Default)]
pub(crate) struct BusState {
    health: BusHealth,
    /// The transmit queue was full: nothing is sent until the moment, and the next pause is twice the span.
    held: Option<(Instant, Duration)>,
}

impl BusState {
    pub(crate) fn health(&self) -> BusHealth {
        self.health
    }

    /// Whether sending has to be asked for: the transmit queue was full not long ago.
    pub(crate) fn is_held(&self) -> bool {
        self.held.is_some()
    }

    /// Whether a frame may be sent now; if not, it counts as dropped.
    pub(crate) fn may_send(&mut self, now: Instant) -> bool {
        let held = self.held.is_some_and(|(until, _)| now < until);
        self.health.dropped_full += u64::from(held);
        !held
    }

    pub(crate) fn handle_sent(&mut self) {
        self.held = None;
        self.handle_back();
    }

    pub(crate) fn handle_data(&mut self) {
        self.handle_back();
    }

    pub(crate) fn handle_reopened(&mut self) {
        self.held = None;
        self.handle_back();
    }

    /// A controller that was down starts anew, with clean counters.
    fn handle_back(&mut self) {
        if self.health.down {
            self.health = BusHealth { down: false, bus_off: false, error_passive: false, ..self.health };
        }
    }

    pub(crate) fn handle_error(&mut self, now: Instant, error: &io::Error) -> LinkError {
        let error = link_error(error);
        match error {
            LinkError::Full => {
                let pause = self.held.map_or(PAUSE_MIN, |(_, last)| (last * 2).min(PAUSE_MAX));
                self.held = Some((now + pause, pause));
                self.health.dropped_full += 1;
            }
            LinkError::Down(_) | LinkError::Gone(_) => self.health.down = true,
            LinkError::Os(_) => {}
        }
        error
    }

    /// See linux/can/error.h. A change of state names the new state, so that warning means "no longer passive".
    pub(crate) fn handle_error_frame(&mut self, error: &CanError) {
        const PASSIVE: ControllerProblems = ControllerProblems::RX_PASSIVE.union(ControllerProblems::TX_PASSIVE);
        const BETTER: ControllerProblems =
            ControllerProblems::RX_WARNING.union(ControllerProblems::TX_WARNING).union(ControllerProblems::ACTIVE);
        self.health.error_frames = self.health.error_frames.saturating_add(1);
        if error.is_restarted() {
            self.health.bus_off = false;
            self.health.error_passive = false;
        }
        if let Some(problems) = error.controller() {
            if problems.intersects(PASSIVE) {
                self.health.error_passive = true;
            } else if problems.intersects(BETTER) {
                self.health.error_passive = false;
                self.health.bus_off = false;
            }
        }
        if error.is_bus_off() {
            self.health.bus_off = true;
        }
    }
}
