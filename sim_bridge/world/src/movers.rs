//! Round obstacles that move: each goes along its way for ever, and waits while a robot is in it.
//!
//! Movers move at the start of a step, while bodies stand where the step before left them, and stand while bodies move.
//! A mover whose next step would leave less than [`GAP_M`] to a body does not make it, so none pushes or overlaps a
//! robot: a contact comes from the robot's own motion alone. For the same reason a mover leaves a robot that has driven
//! into it only by a way on which the gap grows. Movers do not know each other.

use crate::geometry::Disc;
use crate::sweep::{SKIN_M, first_contact};
use drover_contract::Vec2;

/// A mover does not come nearer to a body than this, metres: more than what counts as a touch.
pub(crate) const GAP_M: f64 = 1e-3;
/// Corners of a way that are nearer to each other than this are one, metres.
const CORNER_M: f64 = 1e-3;

/// A disc that moves, and waits for robots.
#[derive(Clone, Debug)]
pub struct Mover {
    disc: Disc,
    velocity_mps_w: Vec2,
    speed_mps: f64,
    /// Its way until it begins anew; none: it stands.
    legs: Vec<Leg>,
    along: Along,
}

/// A straight part of a way.
#[derive(Clone, Copy, Debug)]
struct Leg {
    from_w: Vec2,
    /// Of length 1.
    direction_w: Vec2,
    length_m: f64,
}

/// A place on a way.
#[derive(Clone, Copy, Debug, Default)]
struct Along {
    leg: usize,
    /// From where that leg begins.
    done_m: f64,
}

impl Mover {
    /// A mover at the start of its way.
    #[must_use]
    pub(crate) fn new(mover: &drover_config::Mover) -> Self {
        let legs = legs(mover.round_m().iter().map(|[x, y]| Vec2::new(*x, *y)).collect());
        let first = mover.waypoints_m.first().copied().unwrap_or_default();
        Self {
            disc: Disc { centre_w: Vec2::new(first[0], first[1]), radius_m: mover.radius_m },
            velocity_mps_w: Vec2::zeros(),
            speed_mps: mover.speed_mps,
            legs,
            along: Along::default(),
        }
    }

    /// Where it is.
    #[must_use]
    pub fn disc(&self) -> Disc {
        self.disc
    }

    /// How it moved in the last step, world frame, m/s; 0 if it waited.
    #[must_use]
    pub fn velocity_mps_w(&self) -> Vec2 {
        self.velocity_mps_w
    }

    /// Heap bytes held.
    pub(crate) fn bytes(&self) -> usize {
        self.legs.capacity() * size_of::<Leg>()
    }

    /// How far it goes in `dt_s` if nobody is in its way, metres.
    pub(crate) fn way_m(&self, dt_s: f64) -> f64 {
        if self.legs.is_empty() { 0.0 } else { self.speed_mps * dt_s }
    }

    /// Whether it can go on for `way_m` metres without coming too near to a body; `gap_m` is the body's gap to a disc.
    pub(crate) fn is_free(&self, way_m: f64, gap_m: impl Fn(&Disc) -> f64) -> bool {
        let gap_at = |share: f64| gap_m(&self.disc_at(self.ahead(share * way_m))) - (GAP_M - SKIN_M);
        first_contact(way_m, gap_at).is_none()
    }

    /// Goes on for `dt_s`.
    pub(crate) fn go(&mut self, dt_s: f64) {
        let way_m = self.way_m(dt_s);
        if way_m <= 0.0 {
            return self.wait();
        }
        let before_w = self.disc.centre_w;
        self.along = self.ahead(way_m);
        self.disc = self.disc_at(self.along);
        self.velocity_mps_w = (self.disc.centre_w - before_w) / dt_s;
    }

    /// Stays where it is.
    pub(crate) fn wait(&mut self) {
        self.velocity_mps_w = Vec2::zeros();
    }

    fn ahead(&self, way_m: f64) -> Along {
        let Along { mut leg, mut done_m } = self.along;
        done_m += way_m;
        while let Some(length_m) = self.legs.get(leg).map(|leg| leg.length_m).filter(|length_m| done_m >= *length_m) {
            done_m -= length_m;
            leg = (leg + 1) % self.legs.len();
        }
        Along { leg, done_m }
    }

    fn disc_at(&self, along: Along) -> Disc {
        let leg = self.legs.get(along.leg);
        let centre_w = leg.map_or(self.disc.centre_w, |leg| leg.from_w + leg.direction_w * along.done_m);
        Disc { centre_w, ..self.disc }
    }
}

/// The way from each of these places to the next, and from the last to the first.
fn legs(mut round_w: Vec<Vec2>) -> Vec<Leg> {
    round_w.dedup_by(|a, b| (*a - *b).norm() < CORNER_M);
    while round_w.len() > 1 && (round_w[0] - round_w[round_w.len() - 1]).norm() < CORNER_M {
        round_w.pop();
    }
    let leg = |(from_w, to_w): (&Vec2, &Vec2)| {
        let length_m = (to_w - from_w).norm();
        (length_m >= CORNER_M).then(|| Leg { from_w: *from_w, direction_w: (to_w - from_w) / length_m, length_m })
    };
    round_w.iter().zip(round_w.iter().cycle().skip(1)).filter_map(leg).collect()
}

#[cfg(test)]
#[path = "movers_tests.rs"]
mod tests;
