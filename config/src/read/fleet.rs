//! Reads a fleet: many robots of one kind, placed by rule.

use super::robot::ROBOTS_MAX;
use crate::reader::{NAME, Table};
use std::f64::consts::TAU;

/// Most fleets of one swarm.
pub(crate) const FLEETS_MAX: usize = 1_000;

/// What could be read of a fleet; `path` is its key.
#[derive(Clone, Debug)]
pub(crate) struct FleetParts {
    pub(crate) path: String,
    pub(crate) kind: Option<String>,
    pub(crate) count: Option<u32>,
    pub(crate) first_id: Option<u32>,
    pub(crate) layout: Option<Layout>,
    /// Inner `None`: the bounds of the world.
    pub(crate) region_m: Option<Option<[[f64; 2]; 2]>>,
    /// Inner `None`: the layout stays where it is.
    pub(crate) shift_m: Option<Option<[[f64; 2]; 2]>>,
    /// Inner `None`: four radii.
    pub(crate) spacing_m: Option<Option<f64>>,
    /// Inner `None`: robots may start far from each other.
    pub(crate) linked_m: Option<Option<f64>>,
    /// Inner `None`: what the layout says.
    pub(crate) yaw_rad: Option<Option<f64>>,
}

/// How a fleet's robots are placed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Layout {
    /// In rows from west to east, the southernmost first, in the middle of the region.
    Grid,
    /// Evenly at random, one after the other, where there is room.
    Random,
}

/// Reads a `[[fleet]]`.
pub(crate) fn fleet(table: &mut Table<'_>) -> Option<FleetParts> {
    let robots_max = u32::try_from(ROBOTS_MAX).unwrap_or(u32::MAX);
    let kind = table.text("kind", &NAME, None);
    let count = table.integer_u32("count", 1..=robots_max, None);
    let first_id = table.integer_u32("first_id", 1..=u32::MAX, Some(1));
    let layout = table.choice("layout", &["grid", "random"]).map(|index| match index {
        0 => Layout::Grid,
        _ => Layout::Random,
    });
    let region_m = table.optional_region("region_m", "the bounds of the world's enclosure or map");
    let shift_m = table.optional_region("shift_m", "none");
    // Two bodies' widths from centre to centre: a body fits between.
    let spacing_m = table.derived_number("spacing_m", 0.01..=1_000.0, "four radii");
    let linked_m = table.derived_number("linked_m", 0.01..=10_000.0, "none");
    let yaw_rad = table.derived_number("yaw_rad", -TAU..=TAU, "0, or random if the layout is");
    let path = table.path().to_owned();
    Some(FleetParts { path, kind, count, first_id, layout, region_m, shift_m, spacing_m, linked_m, yaw_rad })
}
