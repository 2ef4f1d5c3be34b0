//! A whole swarm in one place: robots, world and what lies between, in real or virtual time.
//!
//! [`up`] runs it against the wall clock, over UDP and CAN, with the robots as tasks of this process or as processes of
//! their own. [`VirtualSwarm`] runs the same robots, the same firmware and the same bytes over memory links in virtual
//! time, where one seed gives the same recordings twice. [`DirectSwarm`] leaves the bytes out and runs as many robots
//! as there is memory. [`run_trial`] runs and measures either of the two.

mod batch;
mod children;
mod deployment;
mod digest;
mod direct;
mod ether;
mod explore;
mod flock;
mod measures;
mod points;
mod recording;
mod rehearsal;
mod seen;
mod statistics;
mod summary;
mod tasks;
mod trace;
mod trial;
mod up;
mod watcher;

pub use batch::{Batch, BatchResult, Progress};
pub use deployment::DeployFigures;
pub use direct::DirectSwarm;
pub use explore::{CellSwarm, ExploreFigures, SurveyFigures};
pub use flock::{FlockFigures, FlockSwarm};
pub use points::{Aftermath, PointSwarm, capsules, kill_one};
pub use recording::RunFolder;
pub use rehearsal::VirtualSwarm;
pub use statistics::{Spread, Worst};
pub use summary::{RobotSummary, Summary, Tally};
pub use trial::{Fidelity, Trial, TrialResult, Watch, run_trial, trial_of};
pub use up::{UpError, UpOptions, up};
pub use watcher::{RESTARTED, STOPPED};
