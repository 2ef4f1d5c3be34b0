//! What stood around a moment ago: beams are degrees apart, and the corner of a door is in between.
//!
//! A robot that turns or moves looks past each place with many beams; of all that was seen in the last moments, the
//! nearest place in each direction is kept. One that stands still learns nothing: it has to look around. What moves
//! leaves its places behind for that long.

use super::Params;
use super::laser::returns_w;
use crate::law::View;
use drover_contract::{Stamp, Vec2};
use std::collections::VecDeque;
use std::f64::consts::PI;
use std::time::Duration;

/// Places are remembered for so long, and for as long as it takes to look to both sides, seconds.
const RECENT_S: f64 = 0.3;
/// How far to each side a robot looks around: beams are this far apart, radians.
pub(super) const LOOK_RAD: f64 = PI / 18.0;
/// Of at most so many scans; other scans are only looked at.
const SCANS_MAX: u32 = 8;
/// Directions that are told apart in a quarter of a turn.
const SECTORS: usize = 18;

/// The scans of the last moments, world frame.
#[derive(Clone, Debug, Default)]
pub(super) struct Recent {
    scans: VecDeque<(Stamp, Vec<Vec2>)>,
}

impl Recent {
    /// Look: the nearest place of each direction, in the order of directions.
    pub(super) fn look(&mut self, params: &Params, view: &View<'_>) -> Vec<Vec2> {
        let at_w = view.motion.pose_wb.position();
        let recent = Duration::from_secs_f64(RECENT_S + look_s(params));
        self.scans.retain(|(stamp, _)| view.now.since(*stamp) <= recent);
        let now_w: Vec<Vec2> = returns_w(params, view).collect();
        let mut nearest: [Option<(f64, Vec2)>; 4 * SECTORS] = [None; 4 * SECTORS];
        let before_w = self.scans.iter().flat_map(|(_, places_w)| places_w.iter());
        for place_w in before_w.chain(&now_w) {
            let apart = place_w - at_w;
            let (distance_m2, sector) = (apart.norm_squared(), sector(apart));
            if nearest[sector].is_none_or(|(least_m2, _)| distance_m2 < least_m2) {
                nearest[sector] = Some((distance_m2, *place_w));
            }
        }
        if self.scans.back().is_none_or(|(stamp, _)| view.now.since(*stamp) >= recent / SCANS_MAX) {
            self.scans.push_back((view.now, now_w));
        }
        let within_m2 = params.obstacle_range_m * params.obstacle_range_m;
        nearest
            .iter()
            .flatten()
            .filter(|(distance_m2, _)| *distance_m2 <= within_m2)
            .map(|(_, place_w)| *place_w)
            .collect()
    }
}

/// How long it takes to look from one side to the other, seconds.
pub(super) fn look_s(params: &Params) -> f64 {
    2.0 * LOOK_RAD / params.turn_radps
}

/// Which direction that is: the corner of a square instead of an arc, which is nearly as even and has no arctangent.
fn sector(apart: Vec2) -> usize {
    let sum_m = (apart.x.abs() + apart.y.abs()).max(1e-12);
    let share = apart.y / sum_m;
    let quarters = if apart.x < 0.0 { 2.0 - share } else { share };
    let turned = if quarters < 0.0 { quarters + 4.0 } else { quarters };
    ((turned * SECTORS as f64) as usize).min(4 * SECTORS - 1)
}
