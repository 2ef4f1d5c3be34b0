//! Times at which groups of robots do not hear each other.

use drover_config::Partition as Rule;
use drover_contract::Stamp;
use std::time::Duration;

/// One partition, from `from` to just before `until`.
#[derive(Clone, Debug)]
struct Partition {
    from: Stamp,
    until: Stamp,
    /// By robot: whether it is on the side that the configuration names.
    named_side: Vec<bool>,
}

/// All partitions of a run.
#[derive(Clone, Debug)]
pub(super) struct Partitions(Vec<Partition>);

impl Partitions {
    /// What the configuration asks, for the robots with these ids.
    pub(super) fn new(rules: &[Rule], ids: &[u32]) -> Self {
        let moment = |s: f64| Stamp::ZERO + Duration::from_micros((s.max(0.0) * 1e6) as u64);
        let build = |rule: &Rule| Partition {
            from: moment(rule.from_s),
            until: moment(rule.until_s),
            named_side: ids.iter().map(|id| rule.ids.contains(id)).collect(),
        };
        Self(rules.iter().map(build).collect())
    }

    /// Whether two robots do not hear each other at `now`.
    pub(super) fn part(&self, now: Stamp, a: u32, b: u32) -> bool {
        self.0
            .iter()
            .any(|one| (one.from..one.until).contains(&now) && one.named_side[a as usize] != one.named_side[b as usize])
    }

    /// Heap bytes held.
    pub(super) fn bytes(&self) -> usize {
        let sides: usize = self.0.iter().map(|one| one.named_side.capacity()).sum();
        sides + self.0.capacity() * size_of::<Partition>()
    }
}
