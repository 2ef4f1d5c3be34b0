//! Which move of the safe set to take for the one that the law wants.
//!
//! *Least deviation*: what is allowed is taken as it is. Else directions to both sides of it are tried, and shorter
//! steps, and the one is taken that deviates least, counting half of the turn from the last move: a robot in front of a
//! wall picks a side, keeps it, and passes at full speed. The nearest allowed point, the textbook's projection, sticks
//! to faces, where sliding leads farther from the wish than standing still (`Steer::Project`, kept for comparison).

use super::SafeSet;
use drover_contract::Vec2;
use drover_contract::math::{atan2, cos, sin};
use drover_contract::wrap;
use std::f64::consts::PI;

/// Directions on each side of the wish.
const DIRECTIONS: i32 = 14;
/// The farthest of them, radians: 100 degrees.
const DEVIATION_RAD_MAX: f64 = 100.0 / 180.0 * PI;
/// Shares of the wished length, and what each is dearer than the one before, radians of deviation.
const SHARES: [f64; 4] = [1.0, 0.75, 0.5, 0.25];
const SHARE_COST_RAD: f64 = 0.15;
/// A radian of turning away from the last move costs this much of a radian of deviation.
const TURN_COST: f64 = 0.5;
/// A wish shorter than this is none, metres.
const WISH_M_MIN: f64 = 1e-9;
/// Rounds of alternating projections.
const PROJECTIONS: usize = 60;

/// How a move is chosen.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Steer {
    /// Least deviation.
    Heading,
    /// The nearest point of the set.
    Project,
    /// As far along the wish as is allowed.
    Clip,
}

/// Directions of the last move, for its sense of side.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Steering {
    last_rad: Option<f64>,
}

impl Steering {
    /// The end of the move for `wish` (a displacement, metres, world frame); always in `set`.
    pub fn choose(&mut self, set: &SafeSet, wish: Vec2, steer: Steer) -> Vec2 {
        let at_w = set.at_w();
        let end_w = if wish.norm() < WISH_M_MIN {
            at_w
        } else if set.allows(at_w + wish) {
            at_w + wish
        } else {
            match steer {
                Steer::Heading => self.least_deviation(set, wish),
                Steer::Project => project(set, wish),
                Steer::Clip => clip(set, wish),
            }
        };
        let step = end_w - at_w;
        if step.norm() > WISH_M_MIN {
            self.last_rad = Some(atan2(step.y, step.x));
        }
        end_w
    }

    /// The direction of the last move, radians.
    #[must_use]
    pub fn last_rad(&self) -> Option<f64> {
        self.last_rad
    }

    fn least_deviation(self, set: &SafeSet, wish: Vec2) -> Vec2 {
        let (wish_rad, length_m) = (atan2(wish.y, wish.x), wish.norm());
        let mut best = (f64::INFINITY, set.at_w());
        for direction in -DIRECTIONS..=DIRECTIONS {
            let deviation_rad = f64::from(direction) / f64::from(DIRECTIONS) * DEVIATION_RAD_MAX;
            let heading_rad = wish_rad + deviation_rad;
            let turn_rad = self.last_rad.map_or(0.0, |last| wrap(heading_rad - last).abs());
            let base = deviation_rad.abs() + TURN_COST * turn_rad;
            if base >= best.0 {
                continue;
            }
            let unit = Vec2::new(cos(heading_rad), sin(heading_rad));
            let costs = SHARES.iter().zip(0_u8..).map(|(share, at)| (*share, base + SHARE_COST_RAD * f64::from(at)));
            for (share, cost) in costs {
                let end_w = set.at_w() + unit * (length_m * share);
                if cost < best.0 && set.allows(end_w) {
                    best = (cost, end_w);
                    break;
                }
            }
        }
        best.1
    }
}

/// The nearest point of C and R to the wish by alternating projections (Dykstra's), then as far towards it as O allows.
fn project(set: &SafeSet, wish: Vec2) -> Vec2 {
    let at_w = set.at_w();
    let mut end_w = at_w + wish;
    let bounds = set.discs().len() + set.planes().len();
    let mut corrections = vec![Vec2::zeros(); bounds];
    for _ in 0..PROJECTIONS {
        for (bound, correction) in corrections.iter_mut().enumerate() {
            let from = end_w + *correction;
            end_w = nearest_in(set, bound, from);
            *correction = from - end_w;
        }
    }
    clip(set, slide_along_walls(set, end_w - at_w))
}

/// The nearest point of one bound of C or R.
fn nearest_in(set: &SafeSet, bound: usize, from: Vec2) -> Vec2 {
    let discs = set.discs();
    if let Some(disc) = discs.get(bound) {
        let out = from - disc.centre_w;
        return if out.norm() <= disc.radius_m { from } else { disc.centre_w + out * (disc.radius_m / out.norm()) };
    }
    let plane = &set.planes()[bound - discs.len()];
    let beyond_m = (from - set.at_w()).dot(&plane.normal_w) - plane.advance_m;
    if beyond_m <= 0.0 { from } else { from - plane.normal_w * beyond_m }
}

/// The part of a step that does not lead into the walls that it would come too near to.
fn slide_along_walls(set: &SafeSet, step: Vec2) -> Vec2 {
    let at_w = set.at_w();
    set.walls().iter().fold(step, |step, (wall, keep_m)| {
        if wall.clearance_m(at_w, at_w + step) >= *keep_m {
            return step;
        }
        let Some(into) = (wall.nearest_w(at_w) - at_w).try_normalize(1e-12) else { return step };
        let room_m = (wall.distance_m(at_w) - keep_m).max(0.0);
        step - into * (step.dot(&into) - room_m).max(0.0)
    })
}

/// As far along `wish` as is allowed: all, or a share found by halving. Discs, planes and walls that are convex allow
/// everything up to it; where they are not, what is found is allowed all the same.
fn clip(set: &SafeSet, wish: Vec2) -> Vec2 {
    let at_w = set.at_w();
    if set.allows(at_w + wish) {
        return at_w + wish;
    }
    let (mut allowed, mut refused) = (0.0, 1.0);
    for _ in 0..30 {
        let middle = f64::midpoint(allowed, refused);
        if set.allows(at_w + wish * middle) { allowed = middle } else { refused = middle }
    }
    at_w + wish * allowed
}
