//! The parts of the bench, each with seeds of its own.

use std::ops::Range;

/// A part of the bench.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ExplorePart {
    /// All methods on all scenes.
    Rows,
    /// A robot dies halfway.
    Killed,
    /// Numbers of robots.
    Teams,
    /// Larger places.
    Large,
    /// The paper's figures 4 and 5.
    Figures,
    /// What a decision costs.
    Cost,
}

impl ExplorePart {
    /// All of them.
    pub const ALL: [Self; 6] = [Self::Rows, Self::Killed, Self::Teams, Self::Large, Self::Figures, Self::Cost];

    /// Its name on a command line.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Rows => "rows",
            Self::Killed => "killed",
            Self::Teams => "teams",
            Self::Large => "large",
            Self::Figures => "figures",
            Self::Cost => "cost",
        }
    }

    /// The part of this name.
    #[must_use]
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|part| part.name() == name)
    }

    /// Whether it can be had of any swarm's file; else it is of the shipped scenes alone.
    pub(super) const fn is_of_any_swarm(self) -> bool {
        matches!(self, Self::Rows | Self::Killed | Self::Figures)
    }

    /// Few enough for all parts together to take less than half an hour on a core.
    pub(super) const fn seeds(self, quick: bool) -> Range<u64> {
        match (self, quick) {
            (Self::Rows, false) => 0..10,
            (Self::Killed | Self::Figures, false) => 0..5,
            (Self::Teams, false) => 0..4,
            (Self::Rows | Self::Killed, true) => 0..2,
            (Self::Large | Self::Cost, false) | (Self::Teams | Self::Large | Self::Figures | Self::Cost, true) => 0..1,
        }
    }
}
