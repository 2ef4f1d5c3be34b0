//! From a tree to values: one file for each part of a configuration.

pub(crate) mod behaviour;
pub(crate) mod by_mode;
pub(crate) mod deploy;
pub(crate) mod explore;
pub(crate) mod fleet;
pub(crate) mod flock;
pub(crate) mod generate;
pub(crate) mod kind;
pub(crate) mod plane;
pub(crate) mod robot;
pub(crate) mod swarm;
pub(crate) mod world;
