//! The state that follows: pure, exhaustive, no wildcard over states.

use super::{Conditions, Reason, StopReason, Verdict};

/// The verdict after `from`, given the latch, the facts and what the guard says is in the way.
///
/// Stopped is never left. Everything else follows from the facts of this tick alone: nothing lingers.
pub(super) fn transition(
    from: Verdict,
    latched: Option<StopReason>,
    facts: &Conditions,
    blocked: Option<Reason>,
) -> Verdict {
    match (from, latched) {
        (Verdict::Stopped(reason), _) => Verdict::Stopped(reason),
        (Verdict::Waiting(_) | Verdict::Driving | Verdict::Held(_), Some(reason)) => Verdict::Stopped(reason),
        (Verdict::Waiting(_) | Verdict::Driving | Verdict::Held(_), None) => running(facts, blocked),
    }
}

fn running(facts: &Conditions, blocked: Option<Reason>) -> Verdict {
    if let Some(reason) = facts.unready() {
        return Verdict::Waiting(reason);
    }
    match facts.impaired().or(facts.unasked()).or(blocked) {
        Some(reason) => Verdict::Held(reason),
        None => Verdict::Driving,
    }
}
