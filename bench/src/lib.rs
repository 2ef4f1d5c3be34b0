//! The measured comparisons behind `drover bench NAME`.
//!
//! Every bench prints what it measured and under which conditions, as text or (`--json`) as one document, and has a
//! `--quick` form that shows it works without claiming anything.

mod bringup;
mod contest;
mod convoy;
mod deploy;
mod explore;
mod flock;
mod latency;
mod machine;
mod peers;
mod ray_scenes;
mod rays;
mod record;
mod sim;

pub use bringup::{BringupResult, bringup};
pub use contest::Ways;
pub use convoy::convoy;
pub use deploy::{
    DeployCostRow, DeployPlan, DeployResult, DeployRow, DeployRun, DeployScene, DeploySummary, deploy, deploy_ways,
};
pub use explore::{
    ExploreConcentration, ExploreContender, ExploreCostRow, ExploreCourse, ExploreKilled, ExplorePart, ExplorePlan,
    ExploreResult, ExploreScene, ExploreTable, ExploreTeam, ExploreTeamRow, ExploreWindow, explore,
};
pub use flock::{
    FlockContender, FlockCostRow, FlockPlan, FlockRefusal, FlockResult, FlockRun, FlockScene, FlockSummary, flock,
    flock_ways,
};
pub use latency::{LatencyResult, LatencyRow, latency};
pub use machine::{Conditions, ProcessUse};
pub use peers::PeerRate;
pub use rays::{RaysResult, RaysRow, rays};
pub use record::{RecordResult, record};
pub use sim::{DiffusionRow, FlockRow, PeerRow, SimResult, WireRow, sim};
