//! Equations 1 to 6: what robots do to each other, and how a force moves a robot that can only drive and turn.
//!
//! ```text
//!   e_perp ^  u                    u = - sum_j grad V(|r_i - r_j|) - k (v_i - v_L) + dv_L/dt         (4)
//!          | /                     V(r) = A (L^2 / r^2 + ln r^2)                                     (5)
//!   p_rc --d--> p_rp  --> e        dv/dt = u.e / m          dw/dt = d (u.e_perp) / I                 (6)
//! ```
//!
//! **Errata applied**: (2) and (4) print v_L where the acceleration dv_L/dt belongs. (6b) has no damping unless v_i in
//! (4) is the velocity of the reference point p_rp, v e + w d e_perp: then the turn decays at k d^2 / I. The logarithm
//! in (5) is the natural one.

use super::Params;
use crate::estimate::Motion;
use crate::peers::Neighbour;
use drover_contract::{Pose, Twist, Vec2};

/// Points closer than this share of the spacing repel as if at this distance: the potential has a pole.
const NEAR: f64 = 1.0 / 18.0;

/// The reference point p_rp of a robot and its velocity, world frame.
#[derive(Clone, Copy, Debug)]
pub(super) struct Head {
    pub(super) pos_w: Vec2,
    pub(super) vel_w: Vec2,
}

impl Head {
    pub(super) fn new(pose_wb: Pose, twist_b: Twist, d_m: f64) -> Self {
        let vel_b = Vec2::new(twist_b.speed_mps, twist_b.yaw_rate_radps * d_m);
        Self { pos_w: pose_wb.transform(Vec2::new(d_m, 0.0)), vel_w: pose_wb.rotate(vel_b) }
    }

    pub(super) fn of(peer: &Neighbour, d_m: f64) -> Self {
        Self::new(peer.pose_wb, peer.twist_b, d_m)
    }

    pub(super) fn own(motion: &Motion, d_m: f64) -> Self {
        Self::new(motion.pose_wb, motion.twist_b, d_m)
    }
}

/// dv_L/dt: along the heading as the leader says, across it as its turning implies.
pub(super) fn acceleration_w(leader: &Neighbour) -> Vec2 {
    let across_mps2 = leader.twist_b.speed_mps * leader.twist_b.yaw_rate_radps;
    leader.pose_wb.rotate(Vec2::new(leader.accel_mps2, across_mps2))
}

/// - grad V at `apart` (from the other to us): 2 A (L^2 / r^3 - 1 / r) along it.
pub(super) fn pair_force(gain: f64, rest_m: f64, apart: Vec2) -> Vec2 {
    let r_m = apart.norm();
    if r_m < 1e-9 {
        return Vec2::zeros();
    }
    let r_capped_m = r_m.max(NEAR * rest_m);
    let size = 2.0 * gain * (rest_m * rest_m / r_capped_m.powi(3) - 1.0 / r_capped_m);
    apart * (size / r_m)
}

/// (6) and (10): the force on the reference point changes speed and turn; clipped to the limits.
pub(super) fn drive(params: &Params, force_w: Vec2, from: Twist, (motion, dt_s): (&Motion, f64)) -> Twist {
    let heading_w = motion.pose_wb.heading();
    let along = force_w.dot(&heading_w);
    let across = heading_w.perp(&force_w);
    let speed_mps = from.speed_mps + along / params.mass_kg * dt_s;
    let yaw_rate_radps = from.yaw_rate_radps + across * params.head_offset_m / params.inertia_kgm2 * dt_s;
    let reverse_mps = if params.reverse { params.speed_mps } else { 0.0 };
    Twist {
        speed_mps: speed_mps.clamp(-reverse_mps, params.speed_mps),
        yaw_rate_radps: yaw_rate_radps.clamp(-params.turn_radps, params.turn_radps),
    }
}
