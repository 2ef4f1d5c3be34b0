//! From a way to go to a twist of two wheels.

use super::View;
use drover_contract::math::atan2;
use drover_contract::{Twist, Vec2, wrap};

/// Farther off the heading than this, the robot turns in place, radians.
const TURN_IN_PLACE_RAD: f64 = 0.7;
/// Turn towards the way, 1/s.
const TURN_GAIN: f64 = 2.0;
/// The farther off the heading, the slower, but no slower than this share.
const SPEED_SHARE_MIN: f64 = 0.2;

/// The twist (body frame) that goes along `way_w` (world frame, of any length but none) at `speed_mps`: turn on the
/// spot while it lies far off the heading, else an arc.
pub(super) fn along(view: &View<'_>, way_w: Vec2, speed_mps: f64) -> Twist {
    let off_rad = wrap(atan2(way_w.y, way_w.x) - view.motion.pose_wb.yaw_rad);
    let turn_max = view.limits.yaw_rate_radps_max;
    let turn_radps = (TURN_GAIN * off_rad).clamp(-turn_max, turn_max);
    if off_rad.abs() > TURN_IN_PLACE_RAD {
        return Twist::new(0.0, turn_radps);
    }
    let speed_mps = speed_mps * (1.0 - off_rad.abs() / TURN_IN_PLACE_RAD).max(SPEED_SHARE_MIN);
    Twist::new(speed_mps.min(view.limits.speed_mps_max), turn_radps)
}
