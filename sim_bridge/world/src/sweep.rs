//! Where along a motion the first contact is: conservative advancement, so that no speed tunnels.

/// Gap that a body keeps when it touches, metres: numerical room, so that rounding never makes an overlap.
pub(crate) const SKIN_M: f64 = 1e-4;
/// Bodies this near touch, metres: reported as a gap of 0.
pub(crate) const TOUCH_M: f64 = 2.0 * SKIN_M;
/// Smaller steps along one motion than this many mean sliding along a surface: that is a contact.
const SWEEP_STEPS_MAX: u32 = 512;
/// A motion checked up to this share is done: the rest is rounding, far below the skin.
const SHARE_DONE: f64 = 1.0 - 1e-9;

/// Where along a motion, as a share 0..=1 of it, the first contact is; `None` if there is none.
///
/// `gap_at(share)` is the gap there, metres, and `length_m` bounds how much the gap can shrink over the whole motion
/// (the path lengths of all that move). Conservative advancement (Mirtich 1996): at a gap of g nothing can touch before
/// g of the way is used up, whatever the path's shape, so no speed tunnels. A motion that starts at a contact may go on
/// as long as every little step widens the gap.
pub(crate) fn first_contact(length_m: f64, gap_at: impl Fn(f64) -> f64) -> Option<f64> {
    let mut share = 0.0;
    let mut gap_m = gap_at(share);
    if length_m <= 0.0 || gap_m - length_m > SKIN_M {
        return None;
    }
    for _ in 0..SWEEP_STEPS_MAX {
        let room_m = gap_m - SKIN_M;
        let touching = room_m < SKIN_M / 2.0;
        let next = (share + room_m.max(SKIN_M / 2.0) / length_m).min(1.0);
        let next_gap_m = gap_at(next);
        if touching && next_gap_m <= gap_m {
            return Some(share);
        }
        if next >= SHARE_DONE {
            return None;
        }
        (share, gap_m) = (next, next_gap_m);
    }
    Some(share)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_head_on_motion_stops_at_the_skin() {
        let share = first_contact(2.0, |share| 1.0 - 2.0 * share).unwrap();
        assert!((1.0 - 2.0 * share - SKIN_M).abs() < SKIN_M, "gap left: {}", 1.0 - 2.0 * share);
    }

    #[test]
    fn a_motion_away_from_a_contact_is_free_and_one_into_it_is_not() {
        assert_eq!(first_contact(0.02, |share| SKIN_M + 0.02 * share), None);
        assert_eq!(first_contact(0.02, |share| SKIN_M - 0.02 * share), Some(0.0));
        assert_eq!(first_contact(0.02, |share| -0.1 + 0.02 * share), None, "an overlap may only be left");
    }

    #[test]
    fn a_fast_motion_does_not_jump_through_what_is_thin() {
        // A post of 1 mm across the middle of a motion of 1 km.
        let gap_at = |share: f64| (share * 1000.0 - 500.0).abs() - 0.0005;
        let share = first_contact(1000.0, gap_at).unwrap();
        assert!(gap_at(share) > 0.0 && gap_at(share) < 1e-3);
    }
}
