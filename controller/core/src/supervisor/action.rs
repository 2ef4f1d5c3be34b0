//! The command of a state. The only caller of `SafeCommand::bounded` in the project (a test reads the sources for it).

use super::{Reason, Verdict};
use drover_contract::{Limits, SafeCommand, Twist};

/// The command that `verdict` allows. A robot that something is in the way of may still do what the guard left of its
/// request: turn in place, or move away.
pub(super) fn act(verdict: Verdict, guarded: Option<Twist>, limits: &Limits) -> SafeCommand {
    let moves = match verdict {
        Verdict::Driving | Verdict::Held(Reason::Obstacle | Reason::Peer) => true,
        Verdict::Waiting(_) | Verdict::Held(_) | Verdict::Stopped(_) => false,
    };
    let allowed = guarded.filter(|_| moves);
    allowed.and_then(|twist| SafeCommand::bounded(twist, limits).ok()).unwrap_or(SafeCommand::STOP)
}
