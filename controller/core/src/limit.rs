//! Keeps a request within what the body can follow: speed, turn, and how fast either may change.
//!
//! Always yields a bounded command: with a span of zero (or a clock that ran backwards) the command before is kept,
//! within the limits. A request that is not finite stays so; the supervisor refuses it.

use drover_config::Motion;
use drover_contract::{Limits, Twist};

/// What the body of a kind can follow.
pub(crate) fn limits_of(motion: &Motion) -> Limits {
    Limits {
        speed_mps_max: motion.speed_mps_max,
        reverse_mps_max: motion.reverse_mps_max,
        yaw_rate_radps_max: motion.yaw_rate_radps_max,
        accel_mps2_max: motion.accel_mps2_max,
        brake_mps2: motion.brake_mps2,
        yaw_accel_radps2_max: motion.yaw_accel_radps2_max,
    }
}

/// `request`, changed from `before` (the command before) by no more than the limits allow in `dt_s` seconds.
pub(crate) fn limit(request: Twist, before: Twist, limits: &Limits, dt_s: f64) -> Twist {
    let wish_mps = request.speed_mps.clamp(-limits.reverse_mps_max, limits.speed_mps_max);
    let wish_radps = request.yaw_rate_radps.clamp(-limits.yaw_rate_radps_max, limits.yaw_rate_radps_max);
    Twist {
        speed_mps: approach(before.speed_mps, wish_mps, limits, dt_s),
        yaw_rate_radps: step(before.yaw_rate_radps, wish_radps, limits.yaw_accel_radps2_max * dt_s),
    }
}

/// The speed after `dt_s` seconds on the way from `from` to `to`: slowing down by the brake, then speeding up.
pub(crate) fn approach(from_mps: f64, to_mps: f64, limits: &Limits, dt_s: f64) -> f64 {
    if (from_mps - to_mps).abs() <= 0.0 {
        return to_mps; // most courses spend most of their time at one speed
    }
    let slower = to_mps.clamp(from_mps.min(0.0), from_mps.max(0.0));
    let braked = step(from_mps, slower, limits.brake_mps2 * dt_s);
    // While the brake is not done, all of the time is used up and nothing is left to speed up in.
    let left_s = (dt_s - (from_mps - slower).abs() / limits.brake_mps2).max(0.0);
    step(braked, to_mps, limits.accel_mps2_max * left_s)
}

/// `from`, moved towards `to` by at most `most`.
pub(crate) fn step(from: f64, to: f64, most: f64) -> f64 {
    from + (to - from).clamp(-most, most)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::limits;
    use proptest::prelude::*;

    #[test]
    fn speeding_up_is_bounded_by_acceleration_and_slowing_down_by_the_brake() {
        let limits = limits();
        let up = limit(Twist::new(1.0, 0.0), Twist::ZERO, &limits, 0.1);
        assert!((up.speed_mps - 0.1 * limits.accel_mps2_max).abs() < 1e-12);
        let down = limit(Twist::ZERO, Twist::new(1.0, 0.0), &limits, 0.1);
        assert!((down.speed_mps - (1.0 - 0.1 * limits.brake_mps2)).abs() < 1e-12);
    }

    #[test]
    fn a_change_of_direction_first_brakes_and_then_speeds_up_in_what_time_is_left() {
        let mut limits = limits();
        limits.brake_mps2 = 2.0;
        limits.accel_mps2_max = 1.0;
        let over = approach(0.1, -1.0, &limits, 0.1);
        assert!((over + 0.05).abs() < 1e-12, "{over}");
    }

    #[test]
    fn without_time_the_command_before_stays() {
        let before = Twist::new(0.4, -0.2);
        assert_eq!(limit(Twist::new(1.0, 1.0), before, &limits(), 0.0), before);
    }

    proptest! {
        #[test]
        fn whatever_is_asked_the_answer_is_within_the_limits(
            v in -50.0..50.0f64, w in -50.0..50.0f64, v0 in -0.5..1.5f64, w0 in -1.5..1.5f64, dt in 0.0..0.1f64,
        ) {
            let limits = limits();
            let got = limit(Twist::new(v, w), Twist::new(v0, w0), &limits, dt);
            prop_assert!(got.speed_mps <= limits.speed_mps_max + 1e-12);
            prop_assert!(got.speed_mps >= -limits.reverse_mps_max - 1e-12);
            prop_assert!(got.yaw_rate_radps.abs() <= limits.yaw_rate_radps_max + 1e-12);
            let most = limits.accel_mps2_max.max(limits.brake_mps2) * dt;
            prop_assert!((got.speed_mps - v0).abs() <= most + 1e-12);
        }
    }
}
