//! Why a world cannot be made.

use super::{Mm, metres};
use crate::report::Words;

/// Parameters that do not fit together.
pub(crate) struct Misfit {
    /// The key that is to change.
    pub(crate) key: &'static str,
    /// Found, allowed, what to do.
    pub(crate) words: Words,
}

impl Misfit {
    /// A problem with the value of `key`.
    pub(super) fn new(
        key: &'static str,
        found: impl Into<String>,
        expected: impl Into<String>,
        advice: impl Into<String>,
    ) -> Self {
        Self { key, words: Words::new(found, expected, advice) }
    }
}

/// A length that must have room for something.
pub(super) struct Room {
    /// The key that gives the length.
    pub(super) key: &'static str,
    /// What there is, millimetres.
    pub(super) found: Mm,
    /// What it takes, millimetres.
    pub(super) least: Mm,
}

impl Room {
    /// Refuses a length that is too short; `sum` says what it must hold.
    pub(super) fn check(&self, sum: &str) -> Result<(), Misfit> {
        if self.found >= self.least {
            return Ok(());
        }
        let found = format!("{} m", metres(self.found));
        let expected = format!("at least {} m: {sum}", metres(self.least));
        Err(Misfit::new(self.key, found, expected, "enlarge it, or make what it must hold smaller"))
    }
}
