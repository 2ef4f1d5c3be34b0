//! What single keys cannot say: how values must fit together.

pub(crate) mod behaviour;
pub(crate) mod deploy;
pub(crate) mod explore;
pub(crate) mod fleet;
pub(crate) mod flock;
pub(crate) mod kind;
pub(crate) mod links;
pub(crate) mod movers;
pub(crate) mod place;
pub(crate) mod robots;

use crate::report::Report;
use crate::tree::Node;

/// Where problems go and where their places are looked up.
pub(crate) struct Checker<'c> {
    pub(crate) report: &'c mut Report,
    pub(crate) root: &'c Node,
}
