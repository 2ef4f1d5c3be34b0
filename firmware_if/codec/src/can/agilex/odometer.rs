//! The chassis' wheel counters (0x311), made continuous.
//!
//! The device counts millimetres in i32, which wrap, and starts anew at power-on. Here only differences count: a
//! difference that no wheel could have rolled in its time is a restart or a torn reading, and is not travel.

use drover_contract::{Stamp, WheelTravel};
use std::time::Duration;

/// A difference is believed up to what the fastest wheel rolls in the time between the readings plus this: frames
/// of a full bus come late and then close together.
const LATENESS: Duration = Duration::from_millis(100);

/// One reading of both counters, mm.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Reading {
    left_mm: i32,
    right_mm: i32,
}

impl Reading {
    const ZERO: Self = Self { left_mm: 0, right_mm: 0 };
}

/// Travel of both sides since the first reading.
#[derive(Clone, Debug)]
pub(super) struct Odometer {
    wheel_mps_bound: f64,
    last: Option<(Stamp, Reading)>,
    left_mm: i64,
    right_mm: i64,
    rebases: u64,
}

impl Odometer {
    /// A counter that believes wheels up to `wheel_mps_bound`.
    pub(super) fn new(wheel_mps_bound: f64) -> Self {
        Self { wheel_mps_bound, last: None, left_mm: 0, right_mm: 0, rebases: 0 }
    }

    /// Take a reading.
    pub(super) fn read(&mut self, now: Stamp, left_mm: i32, right_mm: i32) {
        let reading = Reading { left_mm, right_mm };
        if let Some((then, last)) = self.last.replace((now, reading)) {
            let (left, right) = (left_mm.wrapping_sub(last.left_mm), right_mm.wrapping_sub(last.right_mm));
            if self.rolled(now.since(then), last, reading) {
                self.left_mm += i64::from(left);
                self.right_mm += i64::from(right);
            } else {
                self.rebases += 1;
            }
        }
    }

    /// Whether the way from `last` to `next` was rolled in `span`. Counters that fall to exactly zero were reset, even
    /// if the step is small: wheels that roll hardly ever meet both zeros in one reading.
    fn rolled(&self, span: Duration, last: Reading, next: Reading) -> bool {
        let most_mm = self.wheel_mps_bound * (span + LATENESS).as_secs_f64() * 1_000.0;
        let (left, right) = (next.left_mm.wrapping_sub(last.left_mm), next.right_mm.wrapping_sub(last.right_mm));
        let far = |step_mm: i32| f64::from(step_mm).abs() > most_mm;
        let reset = next == Reading::ZERO && last != Reading::ZERO;
        !(far(left) || far(right) || reset)
    }

    /// Forget the last reading: the device was away, what it counted meanwhile is unknown.
    pub(super) fn rebase(&mut self) {
        self.last = None;
    }

    /// Travel since the first reading; `None` before it, and if the last one is older than `age_max`.
    pub(super) fn travel(&self, now: Stamp, age_max: Duration) -> Option<WheelTravel> {
        let (then, _) = self.last?;
        let metres = |mm: i64| mm as f64 * 1e-3;
        (now.since(then) <= age_max)
            .then(|| WheelTravel { left_m: metres(self.left_mm), right_m: metres(self.right_mm) })
    }

    /// How many readings were taken as a new start.
    pub(super) fn rebases(&self) -> u64 {
        self.rebases
    }
}

#[cfg(test)]
mod tests {
    use super::Odometer;
    use drover_contract::{Stamp, WheelTravel};
    use std::time::Duration;

    const AGE: Duration = Duration::from_millis(200);

    fn after(readings: &[(u64, i32, i32)]) -> (WheelTravel, u64) {
        let mut odometer = Odometer::new(3.0);
        for (ms, left, right) in readings {
            odometer.read(Stamp::from_millis(*ms), *left, *right);
        }
        let now = Stamp::from_millis(readings.last().map_or(0, |last| last.0));
        (odometer.travel(now, AGE).unwrap(), odometer.rebases())
    }

    #[test]
    fn travel_starts_at_zero_whatever_the_device_has_counted() {
        assert_eq!(after(&[(0, 123_456, -9)]), (WheelTravel::default(), 0));
    }

    #[test]
    fn a_counter_that_wraps_goes_on() {
        let (travel, rebases) = after(&[(0, i32::MAX - 9, i32::MIN + 9), (20, i32::MIN + 10, i32::MAX - 10)]);
        assert_eq!((travel.left_m, travel.right_m, rebases), (0.02, -0.02, 0));
    }

    #[test]
    fn a_jump_that_no_wheel_could_roll_is_a_new_start() {
        let (travel, rebases) = after(&[(0, 0, 0), (20, 30, 30), (40, 90_000, 30), (60, 90_030, 60)]);
        assert_eq!((travel.left_m, travel.right_m, rebases), (0.06, 0.06, 1));
    }

    #[test]
    fn counters_that_fall_to_zero_are_a_restart_even_near_zero() {
        let (travel, rebases) = after(&[(0, 5, 5), (20, 40, 40), (40, 0, 0), (60, 10, 10)]);
        assert_eq!((travel.left_m, rebases), (0.045, 1));
    }

    #[test]
    fn an_old_reading_is_no_travel() {
        let mut odometer = Odometer::new(3.0);
        assert_eq!(odometer.travel(Stamp::ZERO, AGE), None);
        odometer.read(Stamp::ZERO, 1, 1);
        assert_eq!(odometer.travel(Stamp::from_millis(201), AGE), None);
    }
}
