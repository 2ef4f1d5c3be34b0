//! Chance from a seed, by whole numbers: the same on every machine and with every version of the libraries.

use rand::{RngCore, SeedableRng};
use rand_pcg::Pcg32;

/// A source of chance.
pub(super) struct Chance(Pcg32);

impl Chance {
    /// The one that belongs to `seed`.
    pub(super) fn new(seed: u64) -> Self {
        Self(Pcg32::seed_from_u64(seed))
    }

    /// A number below `count` (0 for none): each is as likely as the others, but for one part in 2^32 / `count`.
    pub(super) fn below(&mut self, count: usize) -> usize {
        let share = (u128::from(self.0.next_u32()) * count as u128) >> 32;
        usize::try_from(share).unwrap_or(0)
    }

    /// A number in `low..=high`; `low` if that is empty.
    pub(super) fn between(&mut self, low: i64, high: i64) -> i64 {
        let count = usize::try_from(high - low + 1).unwrap_or(0);
        low + self.below(count) as i64
    }

    /// A number in `0..1`.
    pub(super) fn share(&mut self) -> f64 {
        f64::from(self.0.next_u32()) / 4_294_967_296.0
    }

    /// Puts `items` into any order (Fisher and Yates).
    pub(super) fn shuffle<T>(&mut self, items: &mut [T]) {
        for last in (1..items.len()).rev() {
            items.swap(last, self.below(last + 1));
        }
    }
}
