//! Single-step location prediction: only what lies in the direction of the next step repels (steps 1-6).

use super::Params;
use super::forces::Force;
use drover_config::{Forces, Rotation};
use drover_contract::Vec2;

/// Step 3's "same direction": repulsion that only shortens the attraction.
const SAME_COS: f64 = 0.9999;

/// Steps 2-5: the total force of a robot at `at_w` that is drawn by `attraction` among `entities_w`: peers within d_a,
/// and the nearest place of each wall within d_a. `heading` is the direction of the last move.
pub(super) fn total(
    params: &Params,
    at_w: Vec2,
    attraction: Force,
    entities_w: &[Vec2],
    heading: Option<Vec2>,
) -> Force {
    let around = Around { params, at_w, entities_w };
    match (params.forces, params.rotation) {
        (Forces::Sum, _) => attraction + around.all(),
        (Forces::Sslp, Rotation::Independent) => around.turn_then_move(attraction),
        (Forces::Sslp, Rotation::Coupled) => around.turn_and_move(attraction, heading),
    }
}

struct Around<'a> {
    params: &'a Params,
    at_w: Vec2,
    entities_w: &'a [Vec2],
}

impl Around<'_> {
    /// The classical field: everything within d_a.
    fn all(&self) -> Force {
        self.entities_w.iter().map(|entity_w| self.params.gains.repel(self.at_w, *entity_w)).sum()
    }

    /// Steps 2 and 3.
    fn turn_then_move(&self, attraction: Force) -> Force {
        let Some(first_w) = self.ahead_w(attraction) else { return attraction };
        let once = attraction + self.params.gains.repel(self.at_w, first_w);
        let same = match (attraction.direction(), once.direction()) {
            (Some(before), Some(after)) => before.dot(&after) > SAME_COS,
            (None, _) | (_, None) => true,
        };
        match self.ahead_w(once).filter(|_| !same) {
            Some(second_w) => once + self.params.gains.repel(self.at_w, second_w),
            None => once,
        }
    }

    /// Steps 4 and 5.
    fn turn_and_move(&self, attraction: Force, heading: Option<Vec2>) -> Force {
        let (Some(heading), Some(towards)) = (heading, attraction.direction()) else {
            return self.turn_then_move(attraction);
        };
        if self.any_between(heading, towards) { attraction + self.all() } else { attraction }
    }

    /// The nearest entity within phi of a force's direction.
    fn ahead_w(&self, force: Force) -> Option<Vec2> {
        let direction = force.direction()?;
        let ahead = self.entities_w.iter().copied().filter(|entity_w| {
            let to = entity_w - self.at_w;
            to.dot(&direction) >= to.norm() * self.params.view_cos
        });
        ahead.min_by(|a, b| (a - self.at_w).norm_squared().total_cmp(&(b - self.at_w).norm_squared()))
    }

    /// Whether an entity lies in the angle between two directions.
    fn any_between(&self, from: Vec2, to: Vec2) -> bool {
        let turn = from.perp(&to).signum();
        self.entities_w.iter().any(|entity_w| {
            let at = entity_w - self.at_w;
            turn * from.perp(&at) >= 0.0 && turn * at.perp(&to) >= 0.0 && at.dot(&(from + to)) >= 0.0
        })
    }
}
