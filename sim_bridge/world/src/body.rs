//! One differential-drive body: what it is asked to do, what its wheels do, and where it goes.
//!
//! The demand is reached no faster than the chassis can (speeding up, braking, turning); each wheel then slips a little
//! (a first-order noise, the same as a wheel's radius and the floor's grip would make), and the body drives the arc of
//! its slipping wheels exactly. What the wheels themselves measure has no slip in it, as on a real robot.

use crate::chance::{Use, generator, normal};
use drover_config::{Kind, SimMotion};
use drover_contract::{Pose, Twist, WheelTravel};
use rand_pcg::Pcg32;

/// A wheel's slip forgets itself over this time, s.
const SLIP_TIME_S: f64 = 0.5;
/// No wheel slips more than this share of its speed.
const SLIP_MAX: f64 = 0.9;
/// How much better the chassis is than what its robot may ask of it: the robot's own limits must be what is seen, so
/// the body does not hide a limiter that fails.
const SPEED_RESERVE: f64 = 1.5;
const ACCEL_RESERVE: f64 = 1.25;
/// Braking is promised, so the reserve is small: stopping distances are tested against nearly the promise.
const BRAKE_RESERVE: f64 = 1.05;

/// What a chassis can do.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BodyParams {
    /// Radius of the disc that holds the whole body, metres.
    pub radius_m: f64,
    /// Distance between left and right wheels, metres.
    pub track_m: f64,
    /// Fastest either way, m/s.
    pub speed_mps_max: f64,
    /// Fastest turn either way, rad/s.
    pub yaw_rate_radps_max: f64,
    /// Strongest speeding up, m/s^2.
    pub accel_mps2: f64,
    /// Braking, m/s^2.
    pub brake_mps2: f64,
    /// Change of turn, rad/s^2.
    pub yaw_accel_radps2: f64,
    /// Standard deviation of each wheel's slip, as a share of its speed.
    pub slip_std: f64,
    /// Whether it speeds up, brakes and slips at all.
    pub motion: SimMotion,
}

impl BodyParams {
    /// The chassis of a robot kind: somewhat stronger than the kind says.
    #[must_use]
    pub fn of(kind: &Kind) -> Self {
        let motion = &kind.motion;
        Self {
            radius_m: kind.body.radius_m,
            track_m: kind.body.track_m,
            speed_mps_max: motion.speed_mps_max.max(motion.reverse_mps_max) * SPEED_RESERVE,
            yaw_rate_radps_max: motion.yaw_rate_radps_max * SPEED_RESERVE,
            accel_mps2: motion.accel_mps2_max * ACCEL_RESERVE,
            brake_mps2: motion.brake_mps2 * BRAKE_RESERVE,
            yaw_accel_radps2: motion.yaw_accel_radps2_max * ACCEL_RESERVE,
            slip_std: kind.sim.slip_std,
            motion: kind.sim.motion,
        }
    }
}

/// A body on its wheels.
#[derive(Clone, Debug)]
pub struct Body {
    params: BodyParams,
    pose_wb: Pose,
    /// What the wheels do.
    wheel_twist_b: Twist,
    /// What the body does: the wheels' twist with slip.
    twist_b: Twist,
    wheels: WheelTravel,
    slip: [f64; 2],
    /// How long a step was last, and what of the slip it keeps and adds: steps are alike.
    slip_step: (f64, f64, f64),
    path_m: f64,
    rng: Pcg32,
}

/// The motion of one step, before anything is in its way.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Motion {
    /// The constant twist of the step, slip included: a straight line or an arc.
    pub twist_b: Twist,
    /// The same of the wheels.
    pub wheel_twist_b: Twist,
    /// Length of the path, metres.
    pub length_m: f64,
    /// Length of the step, s.
    pub dt_s: f64,
}

impl Body {
    /// A body at rest at `start`; `seed` and `key` (the robot's id) make its slip.
    #[must_use]
    pub fn new(params: BodyParams, start: Pose, seed: u64, key: u64) -> Self {
        Self {
            params,
            pose_wb: start,
            wheel_twist_b: Twist::ZERO,
            twist_b: Twist::ZERO,
            wheels: WheelTravel::default(),
            slip: [0.0; 2],
            slip_step: (0.0, 1.0, 0.0),
            path_m: 0.0,
            rng: generator(seed, key, Use::Slip),
        }
    }

    /// Where it is.
    #[must_use]
    pub fn pose_wb(&self) -> Pose {
        self.pose_wb
    }

    /// How it truly moves.
    #[must_use]
    pub fn twist_b(&self) -> Twist {
        self.twist_b
    }

    /// How its wheels turn, as a twist: what its encoders would say.
    #[must_use]
    pub fn wheel_twist_b(&self) -> Twist {
        self.wheel_twist_b
    }

    /// How far its wheels have rolled.
    #[must_use]
    pub fn wheels(&self) -> WheelTravel {
        self.wheels
    }

    /// How far its centre has travelled, metres.
    #[must_use]
    pub fn path_m(&self) -> f64 {
        self.path_m
    }

    /// Radius of its disc, metres.
    #[must_use]
    pub fn radius_m(&self) -> f64 {
        self.params.radius_m
    }

    /// Turn the wheels towards `demand` for `dt_s` and say where that leads. A demand that is not finite is a stop.
    pub fn plan(&mut self, demand: Twist, dt_s: f64) -> Motion {
        let before = self.wheel_twist_b;
        self.wheel_twist_b = self.approach(demand, dt_s);
        if self.params.motion == SimMotion::Point {
            let twist_b = self.wheel_twist_b;
            self.twist_b = twist_b;
            return Motion { twist_b, wheel_twist_b: twist_b, length_m: twist_b.speed_mps.abs() * dt_s, dt_s };
        }
        // The mean over the step: the distance of a braking body is then v^2 / (2 brake), whatever the step.
        let wheel_twist_b = Twist::new(
            f64::midpoint(before.speed_mps, self.wheel_twist_b.speed_mps),
            f64::midpoint(before.yaw_rate_radps, self.wheel_twist_b.yaw_rate_radps),
        );
        self.step_slip(dt_s);
        self.twist_b = self.slipping(self.wheel_twist_b);
        let twist_b = self.slipping(wheel_twist_b);
        Motion { twist_b, wheel_twist_b, length_m: twist_b.speed_mps.abs() * dt_s, dt_s }
    }

    /// Carry out a share (0..=1) of a planned motion. Less than all of it is a contact: the body and its wheels stand.
    pub fn carry_out(&mut self, motion: &Motion, share: f64) {
        let dt_s = motion.dt_s * share;
        self.pose_wb = self.pose_wb.advance(motion.twist_b, dt_s);
        self.path_m += motion.length_m * share;
        let [left_mps, right_mps] = self.wheel_speeds(motion.wheel_twist_b);
        self.wheels.left_m += left_mps * dt_s;
        self.wheels.right_m += right_mps * dt_s;
        if share < 1.0 {
            self.wheel_twist_b = Twist::ZERO;
            self.twist_b = Twist::ZERO;
        }
    }

    /// A point that goes straight to `pose_wb` in `dt_s`, whatever its wheels could do.
    pub fn glide(&mut self, pose_wb: Pose, dt_s: f64) {
        let way_m = (pose_wb.position() - self.pose_wb.position()).norm();
        self.twist_b = Twist::new(way_m / dt_s, 0.0);
        self.wheel_twist_b = self.twist_b;
        self.path_m += way_m;
        self.pose_wb = pose_wb;
    }

    /// The wheels' twist one step nearer to the demand.
    fn approach(&self, demand: Twist, dt_s: f64) -> Twist {
        let p = &self.params;
        let demand = if demand.is_finite() { demand } else { Twist::ZERO };
        let speed = demand.speed_mps.clamp(-p.speed_mps_max, p.speed_mps_max);
        let yaw_rate = demand.yaw_rate_radps.clamp(-p.yaw_rate_radps_max, p.yaw_rate_radps_max);
        if p.motion == SimMotion::Point {
            return Twist::new(speed, yaw_rate);
        }
        let yaw_step = p.yaw_accel_radps2 * dt_s;
        let change = (yaw_rate - self.wheel_twist_b.yaw_rate_radps).clamp(-yaw_step, yaw_step);
        Twist {
            speed_mps: approach_speed(self.wheel_twist_b.speed_mps, speed, (p.accel_mps2, p.brake_mps2), dt_s),
            yaw_rate_radps: self.wheel_twist_b.yaw_rate_radps + change,
        }
    }

    fn step_slip(&mut self, dt_s: f64) {
        if self.params.slip_std <= 0.0 {
            return;
        }
        if (self.slip_step.0 - dt_s).abs() > 0.0 {
            let keep = libm::exp(-dt_s / SLIP_TIME_S);
            self.slip_step = (dt_s, keep, self.params.slip_std * (1.0 - keep * keep).sqrt());
        }
        let (_, keep, fresh) = self.slip_step;
        for slip in &mut self.slip {
            *slip = (*slip * keep + fresh * normal(&mut self.rng)).clamp(-SLIP_MAX, SLIP_MAX);
        }
    }

    /// What the body does when its wheels do `wheel_twist_b`.
    fn slipping(&self, wheel_twist_b: Twist) -> Twist {
        if self.params.slip_std <= 0.0 {
            return wheel_twist_b;
        }
        let [left_mps, right_mps] = self.wheel_speeds(wheel_twist_b);
        let (left_mps, right_mps) = (left_mps * (1.0 + self.slip[0]), right_mps * (1.0 + self.slip[1]));
        Twist::new(f64::midpoint(left_mps, right_mps), (right_mps - left_mps) / self.params.track_m)
    }

    fn wheel_speeds(&self, twist_b: Twist) -> [f64; 2] {
        let side_mps = twist_b.yaw_rate_radps * self.params.track_m / 2.0;
        [twist_b.speed_mps - side_mps, twist_b.speed_mps + side_mps]
    }
}

/// The speed after `dt_s`: away from 0 by the first rate, towards 0 by the second, through 0 by both in turn.
fn approach_speed(now_mps: f64, target_mps: f64, (accel_mps2, brake_mps2): (f64, f64), dt_s: f64) -> f64 {
    let turns_back = now_mps * target_mps < 0.0;
    let slows = turns_back || target_mps.abs() < now_mps.abs();
    if !slows {
        let step = accel_mps2 * dt_s;
        return now_mps + (target_mps - now_mps).clamp(-step, step);
    }
    let goal_mps = if turns_back { 0.0 } else { target_mps };
    let step = brake_mps2 * dt_s;
    if (goal_mps - now_mps).abs() > step {
        return now_mps + step.copysign(goal_mps - now_mps);
    }
    if !turns_back {
        return target_mps;
    }
    // Rounding must not leave less than no time.
    let left_s = (dt_s - now_mps.abs() / brake_mps2).max(0.0);
    let step = accel_mps2 * left_s;
    target_mps.clamp(-step, step)
}

#[cfg(test)]
#[path = "body_tests.rs"]
mod tests;
