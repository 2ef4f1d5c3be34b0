//! Where time comes from: the operating system, or a test.

use drover_contract::{Clock, Stamp};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

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
        unix_offset_us(self.now())
    }
}

fn unix_offset_us(now: Stamp) -> u64 {
    let unix = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
    let unix_us = u64::try_from(unix.as_micros()).unwrap_or(u64::MAX);
    unix_us.saturating_sub(now.as_micros())
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

/// The operating system's clock, made faster or slower, or held, for simulation. Clones show the same time, and it
/// never runs backwards.
#[derive(Clone, Debug)]
pub struct PacedClock(Arc<Mutex<Paced>>);

#[derive(Clone, Copy, Debug)]
struct Paced {
    /// This clock showed `at` at the moment `since`, and has gone on at `rate` from there.
    since: Instant,
    at: Stamp,
    rate: f64,
}

impl Paced {
    fn now(&self) -> Stamp {
        self.at + self.since.elapsed().mul_f64(self.rate)
    }
}

impl PacedClock {
    /// A clock that begins now, at the pace of the wall clock.
    #[must_use]
    pub fn new() -> Self {
        Self(Arc::new(Mutex::new(Paced { since: Instant::now(), at: Stamp::ZERO, rate: 1.0 })))
    }

    /// Go on at `rate` seconds per second of the wall clock, 0..=100; 0 holds it. Anything else changes nothing.
    pub fn set_rate(&self, rate: f64) {
        if (0.0..=100.0).contains(&rate) {
            let mut paced = self.lock();
            *paced = Paced { since: Instant::now(), at: paced.now(), rate };
        }
    }

    /// Seconds per second of the wall clock.
    #[must_use]
    pub fn rate(&self) -> f64 {
        self.lock().rate
    }

    /// Microseconds from the Unix epoch to this clock's zero, as if it had always gone at the pace of the wall clock.
    #[must_use]
    pub fn unix_offset_us(&self) -> u64 {
        unix_offset_us(self.now())
    }

    fn lock(&self) -> MutexGuard<'_, Paced> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Default for PacedClock {
    fn default() -> Self {
        Self::new()
    }
}

impl Clock for PacedClock {
    fn now(&self) -> Stamp {
        self.lock().now()
    }

    fn wall(&self, span: Duration) -> Duration {
        /// Who waits for a slow or a held clock looks again after this long: a loop that slept would pass for one that
        /// hangs.
        const LOOK_AGAIN: Duration = Duration::from_millis(10);
        let rate = self.lock().rate;
        if rate >= 1.0 { span.div_f64(rate) } else { span.mul_f64(1.0 / rate.max(1e-3)).min(LOOK_AGAIN) }
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
    fn a_paced_clock_is_held_and_goes_on_from_where_it_was() {
        let clock = PacedClock::new();
        clock.set_rate(0.0);
        let held = clock.now();
        std::thread::sleep(Duration::from_millis(20));
        assert_eq!(clock.clone().now(), held);
        assert_eq!(clock.wall(Duration::from_secs(1)), Duration::from_millis(10));
        clock.set_rate(4.0);
        assert_eq!(clock.wall(Duration::from_millis(100)), Duration::from_millis(25));
        std::thread::sleep(Duration::from_millis(20));
        assert!(clock.now().since(held) >= Duration::from_millis(80), "four times as fast");
        clock.set_rate(f64::NAN);
        clock.set_rate(-1.0);
        assert_eq!(clock.rate().to_bits(), 4.0_f64.to_bits());
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
