//! What robots tell each other about the links that keep them together: `drover_core::links` says what for.

use crate::{RobotId, Vec2};

/// How many links one report tells. A robot keeps no more than that, so nearly always it tells all of its own.
pub const LINKS_TOLD_MAX: usize = 7;
/// How many links of others one report passes on.
pub const EDGES_TOLD_MAX: usize = 3;
/// No link is told as longer: longer ones count as equally long.
pub const WEIGHT_M_MAX: f64 = 655.35;

/// A length or coordinate as it travels, metres: both ends of a link have to mean the same point, so whoever names one
/// uses the number that the wire carries (whole centimetres).
#[must_use]
pub fn on_grid_m(value_m: f64) -> f64 {
    (value_m * 100.0).round() / 100.0
}

/// One robot's state of its links. Within a life (`epoch`) the one with the greatest `seq` counts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LinkReport {
    /// Who speaks.
    pub robot: RobotId,
    /// Which life of that robot: greater after every restart.
    pub epoch: u32,
    /// Greater with every report of one life.
    pub seq: u32,
    /// The sender's logical time: nothing that it tells was made later.
    pub term: u32,
    /// The best root that the sender knows of.
    pub root: RootOffer,
    /// The sender's own links. One that is not there says nothing.
    pub links: [Option<LinkEntry>; LINKS_TOLD_MAX],
    /// Links of others, passed on.
    pub edges: [Option<LinkEdge>; EDGES_TOLD_MAX],
    /// A robot that was given up, passed on.
    pub gone: Option<Departure>,
}

/// A way to a root, as the distance-vector election tells it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RootOffer {
    /// The root.
    pub root: RobotId,
    /// The root's own figure of merit: smaller is better.
    pub metric: f32,
    /// Raised by the root itself; compared as a serial number (it wraps).
    pub seq: u16,
    /// Over how many links.
    pub hops: u8,
}

/// What a robot says of its link with one other. The end with the lower id owns the link and proposes, the other end
/// answers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LinkEntry {
    /// The other end.
    pub peer: RobotId,
    /// The last 16 bits of that end's epoch: what is meant for an earlier life is not for the present one.
    pub peer_epoch: u16,
    /// The newest version that the owner proposed, or that the other end took or refused; 0: none.
    pub version: u16,
    /// A disc is agreed and kept.
    pub holds: bool,
    /// From the end that does not own: what it holds is `version`, which it therefore took.
    pub newest: bool,
    /// From the owner: `version` is proposed and waits for an answer; `centre_w`, `made` and `weight_m` are its.
    pub proposes: bool,
    /// From the end that does not own: please propose.
    pub asks: bool,
    /// Centre of the proposed disc, metres, whole centimetres; zeros if nothing is proposed.
    pub centre_w: Vec2,
    /// In which term the link that is held (or proposed) was made.
    pub made: u32,
    /// How long it was then, metres, whole centimetres.
    pub weight_m: f64,
}

/// That two robots were linked.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LinkEdge {
    /// The end with the lower id.
    pub low: RobotId,
    /// The end with the higher id.
    pub high: RobotId,
    /// In which term the link was made.
    pub made: u32,
    /// How long it was then, metres, whole centimetres.
    pub weight_m: f64,
}

/// That a robot was given up.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Departure {
    /// Which.
    pub robot: RobotId,
    /// Links of it that were made in this term or before ended with it.
    pub term: u32,
}
