//! What one robot thinks, without a clock, a socket or chance: time comes in as `now`, bytes as decoded events.
//!
//! ```text
//! handle_event, handle_beacon -> mailboxes, peers, estimate       (newest wins)
//! tick: age and drop -> estimate -> law -> limit -> supervisor -> SafeCommand
//! ```
//!
//! [`Node`] is the wiring. Every stage is a pure function or a small state machine in a file of its own.

pub mod avoid;
mod cadence;
mod estimate;
mod law;
mod limit;
pub mod links;
mod mailbox;
pub mod map;
mod node;
mod peers;
mod sight;
mod status;
mod supervisor;
#[cfg(test)]
mod testing;

pub use law::{Diffusion, deploy, explore, flock};
pub use node::{Node, Workspace};
pub use peers::Roster;
pub use status::{Counters, HeardPeer, Status};
pub use supervisor::{Reason, StopReason, Verdict};
