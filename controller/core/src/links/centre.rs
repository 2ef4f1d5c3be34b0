//! Where to put the next disc of a link.

use drover_contract::{Vec2, on_grid_m};

/// A disc is put ahead by what both ends, on average, want to cover in this time, seconds.
const LEAD_S: f64 = 1.0;
/// A new centre is proposed if it is that much of the radius away from the old one.
const SHIFT_SHARE: f64 = 0.05;

/// One end of a link, as the owner knows it.
#[derive(Clone, Copy, Debug)]
pub(super) struct End {
    pub(super) pos_w: Vec2,
    /// Where it wants to go, m/s.
    pub(super) wish_w: Vec2,
    /// It is, or comes to stand, within this distance of `pos_w`, metres.
    pub(super) reach_m: f64,
}

impl End {
    /// Whether the end is surely within a disc.
    pub(super) fn fits(&self, centre_w: Vec2, radius_m: f64) -> bool {
        (self.pos_w - centre_w).norm() + self.reach_m <= radius_m
    }
}

/// The point of the grid between two ends.
pub(super) fn between(own: &End, peer: &End) -> Vec2 {
    on_grid(own.pos_w + (peer.pos_w - own.pos_w) / 2.0)
}

/// A better centre than `held_w`: between the ends and ahead of them, or as far in that direction as both are surely
/// within. `None` if that is no gain.
pub(super) fn better(own: &End, peer: &End, held_w: Vec2, radius_m: f64) -> Option<Vec2> {
    let middle_w = own.pos_w + (peer.pos_w - own.pos_w) / 2.0;
    let lead_w = (own.wish_w + peer.wish_w) / 2.0 * LEAD_S;
    // The nearest gain first counts less than the largest: tried from the best downwards.
    let tries = [(1.0, 1.0), (0.5, 1.0), (0.0, 1.0), (1.0, 0.5), (0.5, 0.5), (0.0, 0.5), (0.5, 0.25)];
    let centres_w = tries.into_iter().map(|(lead, way)| on_grid(held_w + (middle_w + lead_w * lead - held_w) * way));
    let mut gains = centres_w.filter(|centre_w| (centre_w - held_w).norm() >= SHIFT_SHARE * radius_m);
    gains.find(|centre_w| own.fits(*centre_w, radius_m) && peer.fits(*centre_w, radius_m))
}

fn on_grid(point_w: Vec2) -> Vec2 {
    point_w.map(on_grid_m)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn end(x_m: f64, wish_mps: f64) -> End {
        End { pos_w: Vec2::new(x_m, 0.0), wish_w: Vec2::new(wish_mps, 0.0), reach_m: 0.2 }
    }

    #[test]
    fn a_disc_goes_between_its_ends_and_ahead_of_both() {
        let centre_w = better(&end(2.0, 1.0), &end(6.0, 0.5), Vec2::zeros(), 3.0).expect("a gain");
        assert_eq!(centre_w, Vec2::new(4.75, 0.0));
        assert!(better(&end(2.0, 0.0), &end(6.0, 0.0), Vec2::new(4.1, 0.0), 3.0).is_none(), "no gain");
    }

    #[test]
    fn no_disc_is_put_where_an_end_may_be_outside() {
        let centre_w = better(&end(0.0, 1.0), &end(5.4, 1.0), Vec2::new(2.0, 0.0), 3.0).expect("a gain");
        assert_eq!(centre_w, Vec2::new(2.7, 0.0), "without the lead");
        assert!(better(&end(0.0, 1.0), &end(5.9, 1.0), Vec2::new(2.0, 0.0), 3.0).is_none(), "5.9 + 2 * 0.2 > 2 * 3");
    }
}
