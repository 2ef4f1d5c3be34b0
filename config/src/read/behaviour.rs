//! Reads what a swarm is to do.

use super::deploy::deploy;
use super::explore::explore;
use super::flock::flock;
use crate::reader::Table;
use crate::{Behaviour, Diffuse};

/// Reads `[behaviour]`.
pub(crate) fn behaviour(table: &mut Table<'_>) -> Option<Behaviour> {
    match table.word("kind", &["flock", "diffuse", "deploy", "explore"])? {
        0 => flock(table).map(Behaviour::Flock),
        1 => diffuse(table).map(Behaviour::Diffuse),
        2 => deploy(table).map(Behaviour::Deploy),
        _ => explore(table).map(Behaviour::Explore),
    }
}

fn diffuse(table: &mut Table<'_>) -> Option<Diffuse> {
    // A walk's pace, a third of what the shipped robots can do: many of them meet each other all the time.
    let speed_mps = table.number("speed_mps", 0.01..=10.0, Some(0.5));
    // A half turn in three seconds: at 20 Hz the heading moves 3 degrees a tick, less than a beam's width.
    let turn_radps = table.number("turn_radps", 0.01..=10.0, Some(1.0));
    // Body and margin of the shipped robots, and as much again: the law turns before the supervisor stops.
    let clearance_m = table.number("clearance_m", 0.05..=100.0, Some(1.0));
    // A little over a right angle: what lies less aside, the supervisor may not let pass, and the robot would freeze.
    let ahead_rad = table.number("ahead_rad", 0.1..=std::f64::consts::PI, Some(1.6));
    Some(Diffuse { speed_mps: speed_mps?, turn_radps: turn_radps?, clearance_m: clearance_m?, ahead_rad: ahead_rad? })
}
