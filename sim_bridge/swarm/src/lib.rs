//! A whole swarm in one place: robots, world and what lies between, in real or virtual time.
//!
//! [`up`] runs it against the wall clock, over UDP and CAN, with the robots as tasks of this process or as processes of
//! their own. [`VirtualSwarm`] runs the same robots, the same firmware and the same bytes over memory links in virtual
//! time, where one seed gives the same recordings twice.

mod children;
mod ether;
mod recording;
mod rehearsal;
mod summary;
mod tasks;
mod up;

pub use recording::RunFolder;
pub use rehearsal::VirtualSwarm;
pub use summary::{RobotSummary, Summary, Tally};
pub use up::{UpError, UpOptions, up};
