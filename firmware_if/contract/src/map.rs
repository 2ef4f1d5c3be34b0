//! What robots tell each other of the map that they make together: `drover_core::map` says what for.

use crate::RobotId;

/// How many writers' heads one report tells; with more writers they take turns.
pub const HEADS_TOLD_MAX: usize = 5;
/// Bytes of changes in one report at most.
pub const CHANGES_BYTES_MAX: usize = 88;

/// One life of a robot. What it says of the map is numbered within it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Writer {
    /// The robot.
    pub robot: RobotId,
    /// Which life of it.
    pub epoch: u32,
}

/// How much one robot has of what a writer said.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct MapHead {
    /// Whose.
    pub writer: Writer,
    /// Everything up to this index, and nothing beyond it.
    pub head: u32,
}

/// A piece of what a writer said, from its own mouth or passed on.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct MapChunk {
    /// Whose.
    pub writer: Writer,
    /// It begins behind this index ...
    pub after: u32,
    /// ... and ends with this one: nothing in between is missing.
    pub upto: u32,
    /// Runs of cells, packed as `drover_core::map::ledger` says; at most [`CHANGES_BYTES_MAX`].
    pub changes: Vec<u8>,
}

/// One robot's part in making the map, told beside its beacon.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct MapReport {
    /// Who speaks, in which life.
    pub from: Writer,
    /// Greater with every report of one life.
    pub seq: u32,
    /// A hash of where the cells lie: two robots with other cells do not understand each other.
    pub lattice: u32,
    /// The cell to which it goes: a lease, which ends with the next report, or with its sender.
    pub goal: Option<u32>,
    /// Whether it knows of nothing that is left to see.
    pub done: bool,
    /// What it has of others and of itself.
    pub heads: [Option<MapHead>; HEADS_TOLD_MAX],
    /// Something that somebody it hears has not.
    pub chunk: Option<MapChunk>,
}
