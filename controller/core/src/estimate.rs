//! Where the robot is and how it moves.
//!
//! A robot whose autopilot knows its pose believes the autopilot ([`PoseFix`]), carried forward by the measured
//! velocity. Any other starts at `robot.start` and adds up what its wheels rolled: `WheelTravel` and the track if the
//! drive counts it, else the measured velocity over time. The position bound is a fixed figure for a fix. For dead
//! reckoning it grows with the way: by a share of it, and by what three standard deviations of the heading, itself a
//! random walk over what the wheels have rolled, can have turned it aside. An engineering figure, not a covariance.

use drover_contract::{Odometry, Pose, PoseFix, Stamp, Twist, WheelTravel};
use std::time::Duration;

/// How well a pose fix or a surveyed start is known, metres.
const BOUND_M_KNOWN: f64 = 0.05;
/// What dead reckoning loses along the way per metre travelled, metres.
const BOUND_PER_M: f64 = 0.01;
/// Standard deviation of the heading after one metre of rolling, radians; it grows with the root of the distance. Two
/// wheels that slip by half a percent on their own, for half a second at a time, on a narrow track do this.
const HEADING_STD_PER_SQRT_M: f64 = 0.012;
/// So many standard deviations of the heading count.
const HEADING_STDS: f64 = 3.0;
/// Odometry is carried over a gap in it of this length at most.
const GAP_S_MAX: f64 = 0.5;
/// Wheels that claim to have rolled farther between two messages have started to count anew, metres.
const ROLL_M_MAX: f64 = 2.0;
/// Time constant of the measured acceleration, seconds, and its greatest believable size, m/s^2.
const ACCEL_S: f64 = 0.2;
const ACCEL_MPS2_MAX: f64 = 3.0;

/// The robot's own motion at one moment.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Motion {
    pub(crate) pose_wb: Pose,
    pub(crate) twist_b: Twist,
    /// Along the heading, m/s^2.
    pub(crate) accel_mps2: f64,
    /// The body is within this distance of `pose_wb`, metres.
    pub(crate) pos_bound_m: f64,
}

/// Adds up odometry and takes fixes.
#[derive(Clone, Debug)]
pub(crate) struct Estimate {
    track_m: f64,
    pose_wb: Pose,
    /// When `pose_wb` held.
    at: Option<Stamp>,
    fix_at: Option<Stamp>,
    odometry: Option<Odometry>,
    accel_mps2: f64,
    travelled_m: f64,
    /// By dead reckoning, turns on the spot included.
    rolled_m: f64,
    bound_m: f64,
}

impl Estimate {
    pub(crate) fn new(start_wb: Pose, track_m: f64) -> Self {
        Self {
            track_m,
            pose_wb: start_wb,
            at: None,
            fix_at: None,
            odometry: None,
            accel_mps2: 0.0,
            travelled_m: 0.0,
            rolled_m: 0.0,
            bound_m: BOUND_M_KNOWN,
        }
    }

    pub(crate) fn handle_odometry(&mut self, odometry: Odometry) {
        let newer = self.odometry.is_none_or(|held| odometry.stamp > held.stamp);
        let wheels = odometry.wheels.is_none_or(|w| w.left_m.is_finite() && w.right_m.is_finite());
        if !newer || !wheels || !odometry.twist_b.is_finite() {
            return;
        }
        if let Some(before) = self.odometry {
            self.accumulate(before, odometry);
        }
        self.odometry = Some(odometry);
    }

    fn accumulate(&mut self, before: Odometry, after: Odometry) {
        let dt_s = after.stamp.since(before.stamp).as_secs_f64().min(GAP_S_MAX);
        let change_mps2 = (after.twist_b.speed_mps - before.twist_b.speed_mps) / dt_s.max(1e-3);
        let weight = dt_s / (dt_s + ACCEL_S);
        let wished = self.accel_mps2 + weight * (change_mps2 - self.accel_mps2);
        self.accel_mps2 = wished.clamp(-ACCEL_MPS2_MAX, ACCEL_MPS2_MAX);
        let moved = match (before.wheels, after.wheels) {
            (Some(from), Some(to)) => self.rolled(from, to),
            _ => None,
        };
        let (twist_b, span_s) = moved.map_or((after.twist_b, dt_s), |arc| (arc, 1.0));
        let way_m = (twist_b.speed_mps * span_s).abs();
        self.travelled_m += way_m;
        if self.fix_at.is_none() {
            self.pose_wb = self.pose_wb.advance(twist_b, span_s);
            self.at = Some(after.stamp);
            // On the spot, too, wheels roll and the heading walks.
            self.rolled_m += way_m + (twist_b.yaw_rate_radps * span_s).abs() * self.track_m / 2.0;
            let heading_std_rad = HEADING_STD_PER_SQRT_M * self.rolled_m.sqrt();
            self.bound_m += way_m * (BOUND_PER_M + HEADING_STDS * heading_std_rad);
        }
    }

    /// The arc between two wheel counts, as a twist held for one second; `None` if the drive began to count anew.
    fn rolled(&self, from: WheelTravel, to: WheelTravel) -> Option<Twist> {
        let left_m = to.left_m - from.left_m;
        let right_m = to.right_m - from.right_m;
        let sane = left_m.abs() <= ROLL_M_MAX && right_m.abs() <= ROLL_M_MAX;
        sane.then(|| Twist::new((left_m + right_m) / 2.0, (right_m - left_m) / self.track_m))
    }

    pub(crate) fn handle_fix(&mut self, fix: PoseFix) {
        let newer = self.fix_at.is_none_or(|held| fix.stamp > held);
        if newer && fix.pose_wb.is_finite() {
            self.pose_wb = fix.pose_wb;
            self.at = Some(fix.stamp);
            self.fix_at = Some(fix.stamp);
            self.bound_m = BOUND_M_KNOWN;
        }
    }

    /// The motion now: the pose is carried forward by the measured velocity, no longer than `GAP_S_MAX`.
    pub(crate) fn motion(&self, now: Stamp) -> Motion {
        let twist_b = self.odometry.map_or(Twist::ZERO, |odometry| odometry.twist_b);
        let ahead_s = self.at.map_or(0.0, |at| now.since(at).as_secs_f64().min(GAP_S_MAX));
        let pose_wb = self.pose_wb.advance(twist_b, ahead_s);
        Motion { pose_wb, twist_b, accel_mps2: self.accel_mps2, pos_bound_m: self.bound_m }
    }

    pub(crate) fn odometry_age(&self, now: Stamp) -> Option<Duration> {
        self.odometry.map(|odometry| now.since(odometry.stamp))
    }

    pub(crate) fn fix_age(&self, now: Stamp) -> Option<Duration> {
        self.fix_at.map(|at| now.since(at))
    }

    /// Metres travelled, as measured.
    pub(crate) fn travelled_m(&self) -> f64 {
        self.travelled_m
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::FRAC_PI_2;

    fn odometry(at_ms: u64, speed_mps: f64, wheels: Option<(f64, f64)>) -> Odometry {
        Odometry {
            stamp: Stamp::from_millis(at_ms),
            twist_b: Twist::new(speed_mps, 0.0),
            wheels: wheels.map(|(left_m, right_m)| WheelTravel { left_m, right_m }),
        }
    }

    #[test]
    fn wheels_that_roll_a_quarter_circle_turn_the_pose_by_it() {
        let mut estimate = Estimate::new(Pose::default(), 0.5);
        for step in 0..=100 {
            let share = f64::from(step) / 100.0 * FRAC_PI_2;
            // Around a centre 1 m to the left: the left wheel rolls 0.75 m per radian, the right one 1.25 m.
            let wheels = Some((0.75 * share, 1.25 * share));
            estimate.handle_odometry(odometry(u64::from(step as u32) * 20, 0.0, wheels));
        }
        let pose = estimate.motion(Stamp::from_millis(2_000)).pose_wb;
        assert!((pose.position() - drover_contract::Vec2::new(1.0, 1.0)).norm() < 1e-6, "{pose:?}");
        assert!((pose.yaw_rad - FRAC_PI_2).abs() < 1e-9);
        assert!((estimate.travelled_m() - FRAC_PI_2).abs() < 1e-6);
    }

    #[test]
    fn wheels_that_count_anew_do_not_move_the_robot() {
        let mut estimate = Estimate::new(Pose::default(), 0.5);
        estimate.handle_odometry(odometry(0, 0.0, Some((500.0, 500.0))));
        estimate.handle_odometry(odometry(20, 0.0, Some((0.0, 0.0))));
        assert_eq!(estimate.motion(Stamp::from_millis(20)).pose_wb, Pose::default());
    }

    #[test]
    fn without_wheel_counts_the_velocity_is_added_up_and_the_bound_grows() {
        let mut estimate = Estimate::new(Pose::new(1.0, 2.0, 0.0), 0.5);
        let at_start = estimate.motion(Stamp::ZERO).pos_bound_m;
        for step in 0..=50 {
            estimate.handle_odometry(odometry(step * 20, 1.0, None));
        }
        let motion = estimate.motion(Stamp::from_millis(1_000));
        assert!((motion.pose_wb.x_m - 2.0).abs() < 1e-9);
        assert!(motion.pos_bound_m > at_start);
    }

    #[test]
    fn a_fix_is_believed_and_carried_forward() {
        let mut estimate = Estimate::new(Pose::default(), 0.5);
        estimate.handle_odometry(odometry(0, 1.0, None));
        estimate.handle_fix(PoseFix { stamp: Stamp::from_millis(100), pose_wb: Pose::new(5.0, 5.0, 0.0) });
        estimate.handle_odometry(odometry(120, 1.0, None));
        let pose = estimate.motion(Stamp::from_millis(200)).pose_wb;
        assert!((pose.x_m - 5.1).abs() < 1e-9, "{pose:?}");
    }

    #[test]
    fn numbers_that_are_not_finite_and_old_messages_change_nothing() {
        let mut estimate = Estimate::new(Pose::default(), 0.5);
        estimate.handle_odometry(odometry(100, 0.5, None));
        estimate.handle_odometry(odometry(90, 0.9, None));
        estimate.handle_odometry(odometry(120, f64::NAN, None));
        estimate.handle_odometry(odometry(140, 0.5, Some((f64::INFINITY, 0.0))));
        let bad = Pose { yaw_rad: f64::NAN, ..Pose::default() };
        estimate.handle_fix(PoseFix { stamp: Stamp::from_millis(150), pose_wb: bad });
        assert_eq!(estimate.odometry_age(Stamp::from_millis(200)), Some(Duration::from_millis(100)));
        assert_eq!(estimate.fix_age(Stamp::from_millis(200)), None);
        assert_eq!(estimate.motion(Stamp::from_millis(100)).twist_b, Twist::new(0.5, 0.0));
    }

    #[test]
    fn the_measured_acceleration_follows_a_steady_one() {
        let mut estimate = Estimate::new(Pose::default(), 0.5);
        for step in 0..100_u64 {
            estimate.handle_odometry(odometry(step * 20, 0.5 * step as f64 * 0.02, None));
        }
        assert!((estimate.motion(Stamp::from_millis(2_000)).accel_mps2 - 0.5).abs() < 0.01);
    }
}
