//! Strict, typed TOML: robot kinds, worlds, swarms, and the file of one robot in the field.
//!
//! Raw text -> tree with positions -> checked values. Everything that is wrong is said at once, each with file, line,
//! column, key, the value found, the allowed range and what to do. What comes out cannot be wrong.

mod assign;
mod behaviour;
mod boxes;
mod check;
mod crowd;
mod deploy;
mod explore;
mod flock;
mod generate;
mod geometry;
mod guard;
mod include;
mod kind;
mod load;
mod map;
mod overrides;
mod path;
mod plane;
mod problem;
mod read;
mod reader;
mod report;
mod robot;
mod source;
mod suggest;
mod swarm;
mod tree;
mod walls;
mod world;
mod write;

#[cfg(test)]
mod tests;

pub use behaviour::{Behaviour, Diffuse};
pub use deploy::{
    Assignment, Deploy, DeployGuard, DeployMode, DeploySteer, Escape, Exchange, Forces, KeptLinks, Rotation,
};
pub use explore::{AffinityReading, CandidateValue, Explore, ExploreMethod, Finish, MapExchange, Suppression};
pub use flock::{
    Avoidance, Flock, FlockGuard, FlockMode, LINK_BEGUN_SHARE, LeaderLoss, LeaderWay, POSE_ERROR_M, Party,
    WallFollowing,
};
pub use kind::{AgilexModel, Body, Drive, Kind, Lidar, LidarLink, Motion, Mount, Sim, SimMotion, Timeouts};
pub use load::{Checked, check_file, check_file_with, load_kind, load_robot, load_swarm, load_world, robot_from_text};
pub use overrides::Override;
pub use plane::{Airtime, BeaconPlane, Burst, Partition, Propagation, Radio};
pub use problem::{Problem, Problems};
pub use robot::{Links, Peer, Robot, RobotFile, Start};
pub use swarm::Swarm;
pub use world::{Circle, GridMap, Mover, Polygon, Polyline, UnknownCells, World};
