//! LOCAL_POSITION_NED (32) and ATTITUDE (30) put together: where the body is and how it moves.

use super::ned;
use drover_contract::{Odometry, Pose, PoseFix, Stamp, Twist};
use mavlink::dialects::common::{ATTITUDE_DATA, LOCAL_POSITION_NED_DATA};

/// The two messages must be of the same moment, give or take this, on the autopilot's own clock.
const SKEW_MS_MAX: i32 = 1200;
/// The heading is carried forward along its rate for at most this long.
const CARRY_S_MAX: f64 = 0.1;
/// Nothing drives farther than this from its origin or faster: the estimator has come apart.
const POSITION_M_MAX: f64 = 1.0e6;
const SPEED_MPS_MAX: f64 = 100.0;
/// The autopilot's clock may fall by this much (messages out of order) without having restarted.
const REORDER_MS_MAX: i32 = 1000;

/// What the autopilot's estimator said last.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Motion {
    attitude: Option<Attitude>,
    boot_ms: Option<u32>,
}

#[derive(Clone, Copy, Debug)]
struct Attitude {
    boot_ms: u32,
    yaw_ned_rad: f64,
    yaw_speed_radps: f64,
}

/// A number was not finite, or absurd.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Nonsense;

impl Motion {
    /// Take note of the autopilot's clock. Whether it has restarted since.
    pub(crate) fn restarted(&mut self, boot_ms: u32) -> bool {
        let last = self.boot_ms.replace(boot_ms);
        // The difference wraps with the clock, every 49 days.
        last.is_some_and(|last| (boot_ms.wrapping_sub(last) as i32) < -REORDER_MS_MAX)
    }

    /// The link was silent: what was heard is of the past, except how late it was on the autopilot's own clock.
    pub(crate) fn forget(&mut self) {
        self.attitude = None;
    }

    pub(crate) fn handle_attitude(&mut self, wire: &ATTITUDE_DATA) -> Result<(), Nonsense> {
        let attitude = Attitude {
            boot_ms: wire.time_boot_ms,
            yaw_ned_rad: f64::from(wire.yaw),
            yaw_speed_radps: f64::from(wire.yawspeed),
        };
        let sane = attitude.yaw_ned_rad.abs() <= 100.0 && attitude.yaw_speed_radps.abs() <= 100.0;
        self.attitude = sane.then_some(attitude);
        if sane { Ok(()) } else { Err(Nonsense) }
    }

    /// The pose and twist, or nothing as long as no attitude of about the same moment is known.
    pub(crate) fn handle_position(
        &mut self,
        now: Stamp,
        wire: &LOCAL_POSITION_NED_DATA,
    ) -> Result<Option<(PoseFix, Odometry)>, Nonsense> {
        let Some(attitude) = self.attitude else { return Ok(None) };
        let skew_ms = wire.time_boot_ms.wrapping_sub(attitude.boot_ms) as i32;
        if skew_ms.checked_abs().is_none_or(|skew| skew > SKEW_MS_MAX) {
            return Ok(None);
        }
        let carry_s = (f64::from(skew_ms) * 1e-3).clamp(-CARRY_S_MAX, CARRY_S_MAX);
        let yaw_ned_rad = attitude.yaw_ned_rad + attitude.yaw_speed_radps * carry_s;
        let pose_wb = ned::pose_from_ned(f64::from(wire.x), f64::from(wire.y), yaw_ned_rad);
        let velocity_ne = [f64::from(wire.vx), f64::from(wire.vy)];
        let twist_b = ned::twist_from_ned(velocity_ne, yaw_ned_rad, attitude.yaw_speed_radps);
        if !plausible(&pose_wb, twist_b) {
            return Err(Nonsense);
        }
        let odometry = Odometry { stamp: now, twist_b, wheels: None };
        Ok(Some((PoseFix { stamp: now, pose_wb }, odometry)))
    }
}

fn plausible(pose_wb: &Pose, twist_b: Twist) -> bool {
    let near = pose_wb.x_m.abs() <= POSITION_M_MAX && pose_wb.y_m.abs() <= POSITION_M_MAX;
    pose_wb.is_finite() && twist_b.is_finite() && near && twist_b.speed_mps.abs() <= SPEED_MPS_MAX
}
