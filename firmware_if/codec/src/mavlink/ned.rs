//! North-east-down and forward-right-down to ours, and back.
//!
//! World: `x_east = y_ned`, `y_north = x_ned`, `yaw = pi/2 - yaw_ned`. Body: forward stays, right becomes minus left,
//! and every turn changes sign. Both conversions are their own inverse.

use drover_contract::math::sin_cos;
use drover_contract::{Pose, Twist, wrap};
use std::f64::consts::FRAC_PI_2;

/// A heading, clockwise from north, counter-clockwise from east; and the other way round.
pub(crate) fn flip_heading(yaw_rad: f64) -> f64 {
    wrap(FRAC_PI_2 - yaw_rad)
}

/// The pose of a body at `north_m`, `east_m` that heads `yaw_ned_rad`.
pub(crate) fn pose_from_ned(north_m: f64, east_m: f64, yaw_ned_rad: f64) -> Pose {
    Pose::new(east_m, north_m, flip_heading(yaw_ned_rad))
}

/// The body's own twist from its velocity over ground and its turn to the right.
pub(crate) fn twist_from_ned(velocity_ne: [f64; 2], yaw_ned_rad: f64, yaw_speed_radps: f64) -> Twist {
    let (sin, cos) = sin_cos(yaw_ned_rad);
    Twist::new(velocity_ne[0] * cos + velocity_ne[1] * sin, 0.0 - yaw_speed_radps)
}

/// `[north, east]` velocity over ground of a body at `pose_wb` that moves with `twist_b`.
pub(crate) fn velocity_to_ned(pose_wb: &Pose, twist_b: Twist) -> [f64; 2] {
    let heading = pose_wb.heading();
    [twist_b.speed_mps * heading.y, twist_b.speed_mps * heading.x]
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::PI;

    #[test]
    fn a_body_that_heads_east_has_yaw_zero_here_and_ninety_degrees_there() {
        let pose = pose_from_ned(2.0, 5.0, FRAC_PI_2);
        assert_eq!((pose.x_m, pose.y_m), (5.0, 2.0));
        assert!(pose.yaw_rad.abs() < 1e-12);
        assert!((flip_heading(0.0) - FRAC_PI_2).abs() < 1e-12, "north");
        assert!((flip_heading(-FRAC_PI_2).abs() - PI).abs() < 1e-12, "west");
    }

    #[test]
    fn driving_backwards_while_heading_south_west_is_a_negative_speed() {
        let yaw_ned = -3.0 * PI / 4.0;
        let velocity = [-1.5 * drover_contract::math::cos(yaw_ned), -1.5 * drover_contract::math::sin(yaw_ned)];
        let twist = twist_from_ned(velocity, yaw_ned, 0.25);
        assert!((twist.speed_mps + 1.5).abs() < 1e-12);
        assert!((twist.yaw_rate_radps + 0.25).abs() < 1e-12, "to the right is negative");
    }

    #[test]
    fn velocity_over_ground_comes_back_as_the_same_twist() {
        for yaw_ned in [-2.8, -1.0, 0.0, 0.4, 2.2] {
            let pose = pose_from_ned(0.0, 0.0, yaw_ned);
            let twist = Twist::new(0.8, -0.3);
            let again = twist_from_ned(velocity_to_ned(&pose, twist), yaw_ned, 0.3);
            assert!((again.speed_mps - 0.8).abs() < 1e-12);
            assert!((again.yaw_rate_radps + 0.3).abs() < 1e-12);
        }
    }
}
