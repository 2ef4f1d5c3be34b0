//! Sequential flocking: a follower keeps its distance to its neighbours and its leader's velocity.
//!
//! **In**: own pose (world) and twist (body); neighbours with fresh beacons, the leader among them: pose (world), twist
//! (body), acceleration along the heading; the nearest wall (body frame); the velocity asked for in the tick before.
//! **Out**: a twist in the body frame, m/s and rad/s, clipped to the body's limits.
//!
//! **Idea**: every robot is a point mass in the potential of all others, in a frame that moves with the leader. The
//! potential of a pair repels below the spacing L and attracts beyond it; friction works on the velocity relative to
//! the leader, so the flock settles at the leader's velocity. The force then acts on a point ahead of the wheels' axis:
//! its part along the heading speeds the robot up, its part across turns it, like a hand on a trolley's bar.
//!
//! ```text
//!   e_perp ^  u                    u = - sum_j grad V(|r_i - r_j|) - k (v_i - v_L) + dv_L/dt         (4)
//!          | /                     V(r) = A (L^2 / r^2 + ln r^2)                                     (5)
//!   p_rc --d--> p_rp  --> e        dv/dt = u.e / m          dw/dt = d (u.e_perp) / I                 (6)
//! ```
//!
//! **Source**: L. Cheng, Q. Zhu, H. Wu, Y. Wang, H. Fang, "Multi-mode sequential flocking strategy integrating
//! wall-following behavior for motion control of multiple mobile robots", Control and Decision 26(3), 2011, 477-480,
//! section 2, equations 1-6.
//!
//! **Errata applied**: (2) and (4) print v_L where the acceleration dv_L/dt belongs. (6b) has no damping unless v_i in
//! (4) is the velocity of the reference point p_rp, v e + w d e_perp: then the turn decays at k d^2 / I. The logarithm
//! in (5) is the natural one.
//!
//! **Departures**
//! - The damping has a gain k (the paper's is 1/s), and leader and neighbours are taken at *their* reference points, so
//!   that at rest all forces vanish together. N_i is everybody heard.
//! - A wall nearer than S repels with the same potential, L = S, from its nearest return: the paper leaves this open.
//!   What of the neighbours' pull leads into that wall is turned along it, the more the nearer: the pull around a
//!   corner otherwise ends in a standstill.
//! - The leader's attraction stays at its greatest value, at sqrt(3) L, instead of fading: a straggler comes back.
//! - The velocity that (6) adds to is the one asked for before, but never farther than `LEAD_*` from the measured one,
//!   or a held robot would wind up. The sum of the potential forces is capped at `FORCE_MAX`.
//! - Wall following (section 3) is not here: a concave pocket still traps. No new leader is elected, ever.
//!
//! **Stability** of the explicit step: k dt / m < 2 and k d^2 dt / I < 2, better below 0.5 because a real drive lags.
//!
//! **Cost**: one pass over the neighbours.
//!
//! **Cannot solve**: the leader is not heard, or is stopped for good: [`Outcome::Stale`]; the supervisor holds the
//! robot until the leader is back.

use super::{Outcome, View, leads};
use crate::estimate::Motion;
use drover_contract::{Pose, RobotId, Twist, Vec2};

/// The velocity asked for leads the measured one by at most this, m/s and rad/s.
const LEAD_MPS: f64 = 0.4;
const LEAD_RADPS: f64 = 0.8;
/// Points closer than this repel as if at this distance, metres: the potential has a pole.
const NEAR_M: f64 = 0.1;
/// Greatest sum of potential forces, m/s^2 for a mass of 1 kg.
const FORCE_MAX: f64 = 4.0;

/// Parameters; the letters are the paper's.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Params {
    /// Whom to follow.
    pub(crate) leader: RobotId,
    /// L, metres.
    pub(crate) spacing_m: f64,
    /// A, m^2/s^2.
    pub(crate) gain: f64,
    /// S, metres.
    pub(crate) obstacle_range_m: f64,
    /// d, metres.
    pub(crate) head_offset_m: f64,
    /// k, 1/s.
    pub(crate) damping_per_s: f64,
    /// m, kg.
    pub(crate) mass_kg: f64,
    /// I, kg m^2.
    pub(crate) inertia_kgm2: f64,
}

/// One step of the law. `before` is what it asked for in the tick before (zero after a halt).
pub(crate) fn flock(params: &Params, before: Twist, view: &View<'_>) -> Outcome {
    let Some(leader) = view.neighbours.iter().find(|peer| peer.id == params.leader) else {
        return Outcome::Stale("leader lost");
    };
    if !leads(leader.state) {
        return Outcome::Stale("leader stopped");
    }
    let d_m = params.head_offset_m;
    let own = Head::new(view.motion.pose_wb, view.motion.twist_b, d_m);
    let led = Head::new(leader.pose_wb, leader.twist_b, d_m);
    let feed_w = acceleration_w(leader.pose_wb, leader.twist_b, leader.accel_mps2);
    let friction_w = (own.vel_w - led.vel_w) * -params.damping_per_s;
    let force_w = potential_force_w(params, &own, view) + friction_w + feed_w;
    Outcome::Solved(drive(params, force_w, started(before, &view.motion), view))
}

/// The reference point p_rp of a robot and its velocity, world frame.
#[derive(Clone, Copy, Debug)]
struct Head {
    pos_w: Vec2,
    vel_w: Vec2,
}

impl Head {
    fn new(pose_wb: Pose, twist_b: Twist, d_m: f64) -> Self {
        let vel_b = Vec2::new(twist_b.speed_mps, twist_b.yaw_rate_radps * d_m);
        Self { pos_w: pose_wb.transform(Vec2::new(d_m, 0.0)), vel_w: pose_wb.rotate(vel_b) }
    }
}

/// dv_L/dt: along the heading as the leader says, across it as its turning implies.
fn acceleration_w(pose_wb: Pose, twist_b: Twist, accel_mps2: f64) -> Vec2 {
    pose_wb.rotate(Vec2::new(accel_mps2, twist_b.speed_mps * twist_b.yaw_rate_radps))
}

/// - sum grad V over neighbours and the nearest wall.
fn potential_force_w(params: &Params, own: &Head, view: &View<'_>) -> Vec2 {
    let mut sum_w = Vec2::zeros();
    for peer in view.neighbours {
        let other = Head::new(peer.pose_wb, peer.twist_b, params.head_offset_m);
        let apart_w = own.pos_w - other.pos_w;
        let held_w = if peer.id == params.leader { strongest(apart_w, params.spacing_m) } else { apart_w };
        sum_w += pair_force(params.gain, params.spacing_m, held_w);
    }
    if let Some(wall_b) = view.wall_b {
        let away_w = own.pos_w - view.motion.pose_wb.transform(wall_b);
        if away_w.norm() < params.obstacle_range_m {
            sum_w += slide_w(params, sum_w, away_w, view.motion.pose_wb.heading());
            sum_w += pair_force(params.gain, params.obstacle_range_m, away_w);
        }
    }
    let size = sum_w.norm();
    if size > FORCE_MAX { sum_w * (FORCE_MAX / size) } else { sum_w }
}

/// `apart_w`, no longer than where attraction is greatest, sqrt(3) L: the leader's pull does not fade with distance.
fn strongest(apart_w: Vec2, spacing_m: f64) -> Vec2 {
    let most_m = spacing_m * 3.0_f64.sqrt();
    let is_m = apart_w.norm();
    if is_m > most_m { apart_w * (most_m / is_m) } else { apart_w }
}

/// What of `pull_w` leads into the wall, turned along it: to the side that the pull and the heading favour together.
fn slide_w(params: &Params, pull_w: Vec2, away_w: Vec2, heading_w: Vec2) -> Vec2 {
    let (Some(normal_w), Some(wish_w)) = (away_w.try_normalize(1e-6), pull_w.try_normalize(1e-6)) else {
        return Vec2::zeros();
    };
    let left_w = Vec2::new(-normal_w.y, normal_w.x);
    let favour = wish_w.dot(&left_w) + heading_w.dot(&left_w) / 2.0;
    let side_w = if favour < 0.0 { -left_w } else { left_w };
    let near = 1.0 - away_w.norm() / params.obstacle_range_m;
    side_w * (-pull_w.dot(&normal_w)).max(0.0) * near
}

/// - grad V at `apart` (from the other to us): 2 A (L^2 / r^3 - 1 / r) along it.
fn pair_force(gain: f64, rest_m: f64, apart: Vec2) -> Vec2 {
    let r_m = apart.norm();
    if r_m < 1e-6 {
        return Vec2::zeros();
    }
    let r_capped_m = r_m.max(NEAR_M);
    let size = 2.0 * gain * (rest_m * rest_m / r_capped_m.powi(3) - 1.0 / r_capped_m);
    apart * (size / r_m)
}

/// What (6) adds to: the velocity asked for before, held near the measured one.
fn started(before: Twist, motion: &Motion) -> Twist {
    let is = motion.twist_b;
    Twist {
        speed_mps: before.speed_mps.clamp(is.speed_mps - LEAD_MPS, is.speed_mps + LEAD_MPS),
        yaw_rate_radps: before.yaw_rate_radps.clamp(is.yaw_rate_radps - LEAD_RADPS, is.yaw_rate_radps + LEAD_RADPS),
    }
}

/// (6): the force on the reference point changes speed and turn; clipped to the body's limits.
fn drive(params: &Params, force_w: Vec2, from: Twist, view: &View<'_>) -> Twist {
    let heading_w = view.motion.pose_wb.heading();
    let along = force_w.dot(&heading_w);
    let across = force_w.y * heading_w.x - force_w.x * heading_w.y;
    let limits = view.limits;
    let speed_mps = from.speed_mps + along / params.mass_kg * view.dt_s;
    let yaw_rate_radps = from.yaw_rate_radps + across * params.head_offset_m / params.inertia_kgm2 * view.dt_s;
    Twist {
        speed_mps: speed_mps.clamp(-limits.reverse_mps_max, limits.speed_mps_max),
        yaw_rate_radps: yaw_rate_radps.clamp(-limits.yaw_rate_radps_max, limits.yaw_rate_radps_max),
    }
}

#[cfg(test)]
#[path = "flock_tests.rs"]
mod tests;
