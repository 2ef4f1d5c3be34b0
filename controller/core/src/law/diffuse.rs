//! Diffusion: straight on, and a turn away from whatever is near.
//!
//! **In**: what the scan shows, peers and walls alike, and the near sides of peers that are heard but not seen (points,
//! body frame, metres): what the supervisor would not let it drive into. **Out**: a twist in the body frame.
//!
//! **Idea**: drive straight on until something lies nearer than `clearance_m` within `ahead_rad` of the heading; then
//! turn on the spot, away from where the sum of all such things lies, and on to that side until the way is clear. Many
//! robots that do so spread over a place. It needs no peer, no map and no pose: the smallest behaviour that uses all of
//! a robot, and the load that swarm simulators are compared by.
//!
//! **Source**: the controller of ARGoS' `footbot_diffusion` example (C. Pinciroli et al., "ARGoS: a modular, parallel,
//! multi-engine simulator for multi-robot systems", Swarm Intelligence 6(4), 2012), with points in metres for
//! proximity readings.
//!
//! **Cost**: one pass over the points. **Cannot solve**: never; what lies straight ahead is turned away from to the
//! left.

use drover_config::Diffuse;
use drover_contract::{Twist, Vec2};

/// A sum of unit vectors no farther aside than this lies straight ahead.
const TIE: f64 = 1e-9;

/// The law and which way it is turning.
#[derive(Clone, Copy, Debug)]
pub struct Diffusion {
    params: Diffuse,
    /// 1 to the left, -1 to the right, while the way ahead is not clear.
    turning: Option<f64>,
}

impl Diffusion {
    /// A robot that has met nothing yet.
    #[must_use]
    pub fn new(params: Diffuse) -> Self {
        Self { params, turning: None }
    }

    /// One step: `points_b` is everything that is seen, body frame, metres.
    pub fn step(&mut self, points_b: impl Iterator<Item = Vec2>) -> Twist {
        let cos_ahead = libm::cos(self.params.ahead_rad);
        let mut sum_b = Vec2::zeros();
        let mut blocked = false;
        for point_b in points_b {
            let distance_m = point_b.norm();
            if distance_m < self.params.clearance_m && point_b.x >= distance_m * cos_ahead {
                blocked = true;
                sum_b += point_b / distance_m.max(1e-6);
            }
        }
        if !blocked {
            self.turning = None;
            return Twist::new(self.params.speed_mps, 0.0);
        }
        // Two beams in opposite directions cancel but for rounding, which must not choose a side.
        let away = if sum_b.y > TIE { -1.0 } else { 1.0 };
        Twist::new(0.0, *self.turning.get_or_insert(away) * self.params.turn_radps)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const PARAMS: Diffuse = Diffuse { speed_mps: 0.5, turn_radps: 1.0, clearance_m: 1.0, ahead_rad: 1.0 };

    fn points(points_b: &[(f64, f64)]) -> impl Iterator<Item = Vec2> + '_ {
        points_b.iter().map(|(x, y)| Vec2::new(*x, *y))
    }

    fn seeing(points_b: &[(f64, f64)]) -> Twist {
        Diffusion::new(PARAMS).step(points(points_b))
    }

    #[test]
    fn with_nothing_near_ahead_it_drives_on() {
        assert_eq!(seeing(&[]), Twist::new(0.5, 0.0));
        assert_eq!(seeing(&[(2.0, 0.0), (-0.5, 0.0), (0.1, 0.9)]), Twist::new(0.5, 0.0), "far, behind, beside");
    }

    #[test]
    fn it_turns_away_from_the_side_where_more_is() {
        assert_eq!(seeing(&[(0.8, 0.3)]), Twist::new(0.0, -1.0));
        assert_eq!(seeing(&[(0.8, -0.3)]), Twist::new(0.0, 1.0));
        assert_eq!(seeing(&[(0.8, -0.3), (0.8, 0.2), (0.7, 0.4)]), Twist::new(0.0, -1.0));
        assert_eq!(seeing(&[(0.5, 0.0)]), Twist::new(0.0, 1.0), "straight ahead: to the left");
    }

    #[test]
    fn once_turning_it_turns_on_until_the_way_is_clear() {
        let mut law = Diffusion::new(PARAMS);
        assert_eq!(law.step(points(&[(0.8, 0.3)])), Twist::new(0.0, -1.0));
        assert_eq!(law.step(points(&[(0.8, -0.3)])), Twist::new(0.0, -1.0), "between two it must not dither");
        assert_eq!(law.step(points(&[])), Twist::new(0.5, 0.0));
        assert_eq!(law.step(points(&[(0.8, -0.3)])), Twist::new(0.0, 1.0));
    }
}
