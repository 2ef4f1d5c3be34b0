//! Where time comes from: the operating system, or a test.

use drover_contract::{Clock, Stamp};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Instant, SystemTime, UNIX_EPOCH};

/// The operating system's monotonic clock. Its epoch is the moment it was made; copies share it.
#[derive(Clone, Copy, Debug)]
pub struct OsClock {
    epoch: Instant,
}

impl OsClock {
    /// A clock that begins now.
    #[must_use]
    pub fn new() -> Self {
        Self { epoch: Instant::now() }
    }

    /// Microseconds from the Unix epoch to this clock's epoch, as the system's calendar clock has it now. Recordings
    /// add it once, so that a step of the calendar clock does not tear them.
    #[must_use]
    pub fn unix_offset_us(&self) -> u64 {
        let unix = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
        let unix_us = u64::try_from(unix.as_micros()).unwrap_or(u64::MAX);
        unix_us.saturating_sub(self.now().as_micros())
    }
}

impl Default for OsClock {
    fn default() -> Self {
        Self::new()
    }
}

impl Clock for OsClock {
    fn now(&self) -> Stamp {
        Stamp::ZERO + self.epoch.elapsed()
    }
}

/// A clock that stands still until it is set: virtual time. Clones show the same time.
#[derive(Clone, Debug, Default)]
pub struct ManualClock {
    now_us: Arc<AtomicU64>,
}

impl ManualClock {
    /// A clock that shows `now`.
    #[must_use]
    pub fn new(now: Stamp) -> Self {
        Self { now_us: Arc::new(AtomicU64::new(now.as_micros())) }
    }

    /// Show `now` from here on. Time never runs backwards: an earlier moment changes nothing.
    pub fn set(&self, now: Stamp) {
        self.now_us.fetch_max(now.as_micros(), Ordering::Relaxed);
    }
}

impl Clock for ManualClock {
    fn now(&self) -> Stamp {
        Stamp::from_micros(self.now_us.load(Ordering::Relaxed))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_clones_of_a_manual_clock_show_what_one_of_them_was_set_to() {
        let clock = ManualClock::new(Stamp::from_millis(5));
        let other = clock.clone();
        clock.set(Stamp::from_millis(25));
        assert_eq!(other.now(), Stamp::from_millis(25));
    }

    #[test]
    fn a_manual_clock_never_runs_backwards() {
        let clock = ManualClock::new(Stamp::from_millis(25));
        clock.set(Stamp::from_millis(5));
        assert_eq!(clock.now(), Stamp::from_millis(25));
    }

    #[test]
    fn the_operating_systems_clock_begins_at_zero_and_goes_forward() {
        let clock = OsClock::new();
        let first = clock.now();
        std::thread::sleep(std::time::Duration::from_millis(2));
        let second = clock.now();
        assert!(first < Stamp::from_millis(1_000), "a fresh clock showed {first}");
        assert!(second > first);
    }

    #[test]
    fn the_offset_of_the_operating_systems_clock_leads_to_the_calendar() {
        let clock = OsClock::new();
        let unix_s = (clock.unix_offset_us() + clock.now().as_micros()) / 1_000_000;
        let calendar_s = SystemTime::now().duration_since(UNIX_EPOCH).unwrap().as_secs();
        assert!(calendar_s.abs_diff(unix_s) <= 1);
    }
}
