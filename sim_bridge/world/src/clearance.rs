//! How near a body has been to something, without measuring at every step.
//!
//! A gap shrinks no faster than bodies move. What was measured once, less what has been moved since, bounds the gap
//! from below; only when that bound gets small is it measured again. Gaps below [`NEAR_M`] are measured at every step
//! and exact; larger ones are known to a tenth, and told too small and never too large.

use crate::sweep::TOUCH_M;

/// Gaps smaller than this are measured at every step, metres.
const NEAR_M: f64 = 1.0;
/// A larger gap is measured anew when its bound has shrunk to this share.
const SHARE_KNOWN: f64 = 0.9;

/// The gap between a body and the nearest of some kind of thing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Clearance {
    /// Never above the gap, metres; `None`: there is nothing to be near to.
    bound_m: Option<f64>,
    measured_m: f64,
    smallest_m: f64,
}

impl Default for Clearance {
    /// Not measured yet.
    fn default() -> Self {
        Self { bound_m: Some(f64::NEG_INFINITY), measured_m: f64::INFINITY, smallest_m: f64::INFINITY }
    }
}

impl Clearance {
    /// The two have moved, together by at most `way_m` metres.
    pub(crate) fn moved(&mut self, way_m: f64) {
        if let Some(bound_m) = &mut self.bound_m {
            *bound_m -= way_m;
        }
    }

    /// Whether it must be measured now.
    pub(crate) fn is_due(&self) -> bool {
        self.bound_m.is_some_and(|bound_m| bound_m < NEAR_M || bound_m < SHARE_KNOWN * self.measured_m)
    }

    /// It need not be measured now: its bound stands for it.
    pub(crate) fn kept(&mut self) {
        self.smallest_m = self.smallest_m.min(self.bound_m.unwrap_or(f64::INFINITY));
    }

    /// It was measured; `None`: there is nothing, and never will be.
    pub(crate) fn measured(&mut self, gap_m: Option<f64>) {
        self.bound_m = gap_m;
        if let Some(gap_m) = gap_m {
            self.measured_m = gap_m;
            self.smallest_m = self.smallest_m.min(reported_gap_m(gap_m));
        }
    }

    /// A gap that the true one is not below, metres; `None` if there is nothing to be near to.
    pub(crate) fn bound_m(&self) -> Option<f64> {
        self.bound_m
    }

    /// The smallest gap so far, metres, 0 from a touch on; `None` if there is nothing to be near to.
    pub(crate) fn smallest_m(&self) -> Option<f64> {
        self.bound_m.map(|_| self.smallest_m)
    }
}

/// A gap as it is told: touching is 0, and nothing is below 0.
pub(crate) fn reported_gap_m(gap_m: f64) -> f64 {
    if gap_m <= TOUCH_M { 0.0 } else { gap_m }
}
