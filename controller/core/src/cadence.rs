//! When to tick and when to speak, and how long it has been.

use drover_contract::Stamp;
use std::time::Duration;

/// How a tick came about.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Beat {
    /// Since the tick before, seconds: 0 for the first one or when the clock did not move, at most two ticks.
    pub(crate) dt_s: f64,
    /// The tick came more than two ticks after the one before: something held the robot up.
    pub(crate) late: bool,
}

/// The robot's pulse. Ticks are due every `tick`; extra ones (a fresh scan) are welcome and do not move the due time.
#[derive(Clone, Debug)]
pub(crate) struct Cadence {
    tick: Duration,
    last: Option<Stamp>,
    due: Stamp,
}

impl Cadence {
    pub(crate) fn new(tick: Duration, now: Stamp) -> Self {
        Self { tick, last: None, due: now }
    }

    /// A tick happens now.
    pub(crate) fn beat(&mut self, now: Stamp) -> Beat {
        let since = self.last.map(|last| now.since(last));
        self.last = Some(self.last.map_or(now, |last| last.max(now)));
        if now >= self.due {
            let next = self.due + self.tick;
            // After a lag the schedule starts anew: missed ticks are not made up for.
            self.due = if next > now { next } else { now + self.tick };
        }
        let limit = self.tick * 2;
        let dt_s = since.unwrap_or_default().min(limit).as_secs_f64();
        Beat { dt_s, late: since.is_some_and(|span| span > limit) }
    }

    pub(crate) fn due(&self) -> Stamp {
        self.due
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cadence() -> Cadence {
        Cadence::new(Duration::from_millis(50), Stamp::from_millis(1_000))
    }

    #[test]
    fn the_first_tick_has_no_span_and_is_not_late() {
        let beat = cadence().beat(Stamp::from_millis(9_000));
        assert_eq!(beat, Beat { dt_s: 0.0, late: false });
    }

    #[test]
    fn a_tick_after_more_than_two_ticks_is_late_and_its_span_is_bounded() {
        let mut cadence = cadence();
        cadence.beat(Stamp::from_millis(1_000));
        assert!(!cadence.beat(Stamp::from_millis(1_100)).late);
        assert_eq!(cadence.beat(Stamp::from_millis(1_201)), Beat { dt_s: 0.1, late: true });
    }

    #[test]
    fn a_clock_that_stands_or_runs_backwards_gives_a_span_of_zero() {
        let mut cadence = cadence();
        cadence.beat(Stamp::from_millis(1_000));
        assert_eq!(cadence.beat(Stamp::from_millis(1_000)), Beat { dt_s: 0.0, late: false });
        assert_eq!(cadence.beat(Stamp::from_millis(400)), Beat { dt_s: 0.0, late: false });
        // The step back gains nothing afterwards either.
        assert_eq!(cadence.beat(Stamp::from_millis(1_010)), Beat { dt_s: 0.01, late: false });
    }

    #[test]
    fn extra_ticks_do_not_move_the_due_time_and_missed_ones_are_not_made_up_for() {
        let mut cadence = cadence();
        cadence.beat(Stamp::from_millis(1_000));
        assert_eq!(cadence.due(), Stamp::from_millis(1_050));
        cadence.beat(Stamp::from_millis(1_020));
        assert_eq!(cadence.due(), Stamp::from_millis(1_050));
        cadence.beat(Stamp::from_millis(1_500));
        assert_eq!(cadence.due(), Stamp::from_millis(1_550));
    }
}
