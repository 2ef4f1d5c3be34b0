//! What GUIDED makes of a stored setpoint: the twist that the motors are asked for.

use drover_codec::mavlink::device::Demand;
use drover_contract::math::{atan2, cos};
use drover_contract::{Pose, Twist, wrap};

/// WP_SPEED and ATC_STR_RAT_MAX (120 degrees/s) of the measured rover.
const SPEED_MPS_MAX: f64 = 3.0;
const YAW_RATE_RADPS_MAX: f64 = 2.10;
/// Turn rate asked for per radian of heading error.
const HEADING_GAIN_PER_S: f64 = 2.0;
/// A point is reached within this distance.
const ARRIVED_M: f64 = 0.2;
/// Speed asked for per metre that is left to a point.
const APPROACH_GAIN_PER_S: f64 = 0.5;

/// The twist that follows `demand` from `pose_wb`.
pub(super) fn follow(demand: &Demand, pose_wb: &Pose) -> Twist {
    let asked = match demand {
        Demand::Twist(twist) => *twist,
        Demand::Course { yaw_rad, speed_mps } => steer(pose_wb, *yaw_rad, *speed_mps),
        Demand::Point(point) => {
            let left = point - pose_wb.position();
            let speed_mps = if left.norm() > ARRIVED_M { left.norm() * APPROACH_GAIN_PER_S } else { 0.0 };
            if speed_mps > 0.0 { steer(pose_wb, atan2(left.y, left.x), speed_mps) } else { Twist::ZERO }
        }
        Demand::AccelerationUsed | Demand::Ignored => Twist::ZERO,
    };
    Twist::new(
        asked.speed_mps.clamp(-SPEED_MPS_MAX, SPEED_MPS_MAX),
        asked.yaw_rate_radps.clamp(-YAW_RATE_RADPS_MAX, YAW_RATE_RADPS_MAX),
    )
}

/// Turn towards a heading; drive only as far as the body already points there.
fn steer(pose_wb: &Pose, yaw_rad: f64, speed_mps: f64) -> Twist {
    let error = wrap(yaw_rad - pose_wb.yaw_rad);
    Twist::new(speed_mps * cos(error).max(0.0), HEADING_GAIN_PER_S * error)
}
