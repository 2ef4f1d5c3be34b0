//! The leader's way: pure pursuit along the straight legs between points.
//!
//! **In**: own pose (world), neighbours with fresh beacons, limits. **Out**: a twist in the body frame.
//!
//! **Idea**: aim at the place on the leg that lies `ahead_m` beyond our own foot on it; turn in place while it lies far
//! off the heading, else drive the arc that leads through it, curvature 2 sin(a) / distance, slowly enough for the turn
//! and, at the last point, for the brake. Aiming at the leg and not at its far end keeps the leader on the line that
//! the swarm file draws, where its author has looked for obstacles.
//!
//! **Source**: R. C. Coulter, "Implementation of the pure pursuit path tracking algorithm", CMU-RI-TR-92-01, 1992.
//!
//! It does not steer around obstacles: the supervisor slows it down and, if one stands on the leg, holds it there.
//!
//! **Cost**: nothing. **Cannot solve**: never; without points it stands.

use crate::law::View;
use drover_contract::math::{atan2, sin};
use drover_contract::{Twist, Vec2, wrap};

/// Farther off the heading than this, the robot turns in place, radians.
const TURN_IN_PLACE_RAD: f64 = 0.9;
/// Turn towards the point, 1/s.
const TURN_GAIN: f64 = 2.0;
/// Places nearer than this share of `ahead_m` are aimed at as if this far away: the curvature has a pole.
const AIM_SHARE_MIN: f64 = 5.0 / 12.0;

/// The way and how far it is done.
#[derive(Clone, Debug)]
pub(super) struct Route {
    /// A point is reached within this distance, metres.
    radius_m: f64,
    /// How far ahead on the leg to aim, metres.
    ahead_m: f64,
    points_w: Vec<Vec2>,
    next: usize,
    /// Where the leader was first, and where it was last.
    from_w: Option<Vec2>,
    at_w: Vec2,
}

impl Route {
    pub(super) fn new(radius_m: f64, ahead_m: f64, points_w: Vec<Vec2>) -> Self {
        Self { radius_m, ahead_m, points_w, next: 0, from_w: None, at_w: Vec2::zeros() }
    }

    /// The leader is at `at_w`: points that it has come to are done. Whoever may take over keeps count as well.
    pub(super) fn see(&mut self, at_w: Vec2) {
        self.at_w = at_w;
        self.from_w.get_or_insert(at_w);
        while self.next < self.points_w.len() && self.gap_m(self.next) <= self.radius_m {
            self.next += 1;
        }
    }

    /// One tick along the way at `cruise_mps` at most.
    pub(super) fn pursue(&self, cruise_mps: f64, view: &View<'_>) -> Twist {
        self.points_w.get(self.next).map_or(Twist::ZERO, |end_w| self.arc(*end_w, cruise_mps, view))
    }

    /// The place to aim at; none at the end.
    pub(super) fn aim_w(&self) -> Option<Vec2> {
        self.points_w.get(self.next).map(|end_w| self.aim_on_w(*end_w))
    }

    /// The last point, while it lies ahead.
    pub(super) fn end_w(&self) -> Option<Vec2> {
        self.points_w.last().copied().filter(|_| !self.reached())
    }

    /// The place to aim at: ahead of our foot on the leg that ends at `end_w`, never beyond its end.
    fn aim_on_w(&self, end_w: Vec2) -> Vec2 {
        let before = self.next.checked_sub(1).and_then(|index| self.points_w.get(index)).copied();
        let from_w = before.or(self.from_w).unwrap_or(self.at_w);
        let leg = end_w - from_w;
        let Some(along) = leg.try_normalize(1e-6) else { return end_w };
        let foot_m = (self.at_w - from_w).dot(&along).max(0.0);
        from_w + along * (foot_m + self.ahead_m).min(leg.norm())
    }

    fn gap_m(&self, index: usize) -> f64 {
        (self.points_w[index] - self.at_w).norm()
    }

    fn arc(&self, end_w: Vec2, cruise_mps: f64, view: &View<'_>) -> Twist {
        let aim_b = view.motion.pose_wb.inverse_transform(self.aim_on_w(end_w));
        let off_rad = wrap(atan2(aim_b.y, aim_b.x));
        let turn_max = view.limits.yaw_rate_radps_max;
        if off_rad.abs() > TURN_IN_PLACE_RAD {
            return Twist::new(0.0, (TURN_GAIN * off_rad).clamp(-turn_max, turn_max));
        }
        let curvature = 2.0 * sin(off_rad) / aim_b.norm().max(AIM_SHARE_MIN * self.ahead_m);
        // Some turn is kept in reserve, so that the arc can still be corrected.
        let turn_mps = 0.8 * turn_max / curvature.abs().max(1e-6);
        let gap_m = (end_w - self.at_w).norm();
        let speed_mps = cruise_mps.min(turn_mps).min(self.ending_mps(gap_m, view.limits.brake_mps2));
        Twist::new(speed_mps, (speed_mps * curvature).clamp(-turn_max, turn_max))
    }

    /// As fast as still allows to stop at the last point at half of the brake.
    fn ending_mps(&self, gap_m: f64, brake_mps2: f64) -> f64 {
        if self.next + 1 < self.points_w.len() { f64::INFINITY } else { (brake_mps2 * gap_m).sqrt() }
    }

    /// The point that is driven to; none at the end.
    pub(super) fn next_w(&self) -> Option<Vec2> {
        self.points_w.get(self.next).copied()
    }

    pub(super) fn reached(&self) -> bool {
        self.next >= self.points_w.len()
    }

    /// Share of the way that is done, by length.
    pub(super) fn progress(&self) -> f64 {
        let Some(from_w) = self.from_w else { return 0.0 };
        if self.reached() {
            return 1.0;
        }
        let corners: Vec<Vec2> = std::iter::once(from_w).chain(self.points_w.iter().copied()).collect();
        let legs_m = |legs: &[Vec2]| legs.windows(2).map(|leg| (leg[1] - leg[0]).norm()).sum::<f64>();
        let left_m = self.gap_m(self.next) + legs_m(&self.points_w[self.next..]);
        (1.0 - left_m / legs_m(&corners).max(1e-3)).clamp(0.0, 1.0)
    }
}

#[cfg(test)]
#[path = "route_tests.rs"]
mod tests;
