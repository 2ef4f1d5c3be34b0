//! Out of a standstill: who gets nowhere for a while goes around what is in its way, for a while.
//!
//! Safe robots can hold each other up: a chain hangs over an obstacle, and every end of it wants what the next forbids.
//! A robot that is drawn to the layout, has not arrived and has made less than `PROGRESS_M` in `PATIENCE_S` follows the
//! nearest wall for `DETOUR_S`, or walks at an angle to its wish where there is none; first to the side that its wish
//! lies on, then to both sides in turn. Nothing depends on it but time: the safe set has the last word all the same.
//!
//! **Source**: ours, after the perturbation against deadlock of L. Wang, A. Ames, M. Egerstedt, "Safety barrier
//! certificates for collisions-free multirobot systems", IEEE T-RO 33(3), 2017.

use crate::avoid::Capsule;
use drover_contract::Vec2;
use drover_contract::math::{cos, sin};

/// A robot that has not come farther than this, metres, in this long, seconds, is stuck.
const PROGRESS_M: f64 = 1.0;
const PATIENCE_S: f64 = 20.0;
/// In a hurry it waits only so long, seconds.
const HURRY_S: f64 = 10.0;
/// How long it goes around then, seconds.
const DETOUR_S: f64 = 25.0;
/// A wall nearer than this is followed, metres, and how near.
const WALL_M: f64 = 1.6;
const KEEP_M: f64 = 0.7;
/// Where there is no wall the wish is turned by so much, radians.
const TURN_RAD: f64 = 2.3;

/// Watches one robot's progress.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Detour {
    /// Where it was when it last made progress, and for how long it has been there, seconds.
    mark: Option<(Vec2, f64)>,
    /// How long the detour still lasts, seconds, and to which side: 1 to the left.
    going: Option<(f64, f64)>,
    tried: u32,
    hurry: bool,
}

impl Detour {
    /// It has arrived, or somebody leads it: nothing is waited for.
    pub(super) fn rest(&mut self) {
        *self = Self::default();
    }

    /// Whether every second counts.
    pub(super) fn set_hurry(&mut self, hurry: bool) {
        self.hurry = hurry;
    }

    /// The wish to follow instead of `wish` for `dt_s`, metres. Forces can cancel: who goes around makes steps of
    /// `step_m`.
    pub(super) fn instead(&mut self, at_w: Vec2, wish: Vec2, walls: &[Capsule], (step_m, dt_s): (f64, f64)) -> Vec2 {
        if let Some((left_s, side)) = self.going {
            self.going = Some((left_s - dt_s, side)).filter(|(left_s, _)| *left_s > 0.0);
            if self.going.is_none() {
                self.mark = None;
            }
            return around(at_w, wish, walls, side) * step_m;
        }
        let (mark_w, waited_s) = self.mark.unwrap_or((at_w, 0.0));
        self.mark = Some(if (at_w - mark_w).norm() > PROGRESS_M {
            self.tried = 0;
            (at_w, 0.0)
        } else {
            (mark_w, waited_s + dt_s)
        });
        if waited_s < if self.hurry { HURRY_S } else { PATIENCE_S } {
            return wish;
        }
        let side = side_of(at_w, wish, walls) * if self.tried.is_multiple_of(2) { 1.0 } else { -1.0 };
        self.tried += 1;
        self.going = Some((if self.hurry { DETOUR_S / 2.0 } else { DETOUR_S }, side));
        around(at_w, wish, walls, side) * step_m
    }
}

/// From the nearest wall to `at_w`, and how far that is, metres.
fn off_wall(at_w: Vec2, walls: &[Capsule]) -> Option<(Vec2, f64)> {
    let offsets = walls.iter().map(|wall| at_w - wall.border_w(at_w));
    let nearest = offsets.min_by(|a, b| a.norm_squared().total_cmp(&b.norm_squared()))?;
    let apart_m = nearest.norm();
    (apart_m < WALL_M && apart_m > 1e-9).then(|| (nearest / apart_m, apart_m))
}

/// On which side of the way off the wall the wish lies.
fn side_of(at_w: Vec2, wish: Vec2, walls: &[Capsule]) -> f64 {
    off_wall(at_w, walls).map_or(1.0, |(off, _)| if off.perp(&wish) >= 0.0 { 1.0 } else { -1.0 })
}

/// The direction to go around in.
fn around(at_w: Vec2, wish: Vec2, walls: &[Capsule], side: f64) -> Vec2 {
    if let Some((off, apart_m)) = off_wall(at_w, walls) {
        let along = Vec2::new(-off.y, off.x) * side;
        return (along + off * (KEEP_M - apart_m)).normalize();
    }
    let Some(wish) = wish.try_normalize(1e-12) else { return wish };
    let (sin, cos) = (sin(side * TURN_RAD), cos(side * TURN_RAD));
    Vec2::new(wish.x * cos - wish.y * sin, wish.x * sin + wish.y * cos)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn who_stands_for_long_goes_along_the_wall_and_then_back_to_its_wish() {
        let walls = [Capsule::edge(Vec2::new(2.0, -5.0), Vec2::new(2.0, 5.0))];
        let wish = Vec2::new(0.4, 0.3);
        let mut detour = Detour::default();
        let at_w = Vec2::new(1.3, 0.0);
        let wishes: Vec<Vec2> = (0..60).map(|_| detour.instead(at_w, wish, &walls, (0.5, 1.0))).collect();
        assert!(wishes[..20].iter().all(|same| *same == wish), "patience");
        assert!(wishes[21].y > 0.49, "to the side of the wish: {}", wishes[21]);
        assert!(wishes[50] == wish, "and waits again");
        let again: Vec<Vec2> = (0..20).map(|_| detour.instead(at_w, wish, &walls, (0.5, 1.0))).collect();
        assert!(again[19].y < -0.49, "then to the other: {}", again[19]);
    }

    #[test]
    fn who_moves_never_leaves_its_way() {
        let mut detour = Detour::default();
        let wish = Vec2::new(0.5, 0.0);
        assert!(
            (0..200).all(|step| detour.instead(Vec2::new(0.5 * f64::from(step), 0.0), wish, &[], (0.5, 1.0)) == wish)
        );
    }
}
