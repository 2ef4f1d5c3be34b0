//! Reads what a swarm is to do.

use super::deploy::deploy;
use crate::reader::Table;
use crate::{Behaviour, Diffuse, Flock};

/// Most waypoints.
const WAYPOINTS_MAX: usize = 10_000;

/// Reads `[behaviour]`.
pub(crate) fn behaviour(table: &mut Table<'_>) -> Option<Behaviour> {
    match table.word("kind", &["flock", "diffuse", "deploy"])? {
        0 => flock(table).map(Behaviour::Flock),
        1 => diffuse(table).map(Behaviour::Diffuse),
        _ => deploy(table).map(Behaviour::Deploy),
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

/// Defaults are the paper's values, scaled from its 100 mm spacing to 1.8 m (lengths times 18, times kept), unless
/// a comment says otherwise.
fn flock(table: &mut Table<'_>) -> Option<Flock> {
    let leader = table.integer_u32("leader", 1..=u32::MAX, None);
    let waypoints_m = table.points("waypoints_m", 1..=WAYPOINTS_MAX);
    // Half of what the shipped robots can do: followers must be able to catch up.
    let leader_speed_mps = table.number("leader_speed_mps", 0.01..=10.0, Some(0.8));
    // About a body's length: nearer, and a leader circles around a point that it cannot hit.
    let waypoint_radius_m = table.number("waypoint_radius_m", 0.05..=100.0, Some(0.5));
    // Two rings of neighbours around the leader.
    let arrive_radius_m = table.number("arrive_radius_m", 0.1..=1_000.0, Some(4.0));
    let spacing_m = table.number("spacing_m", 0.1..=100.0, Some(1.8));
    let gain = table.number("gain", 0.0..=1_000.0, Some(0.3));
    // More than the paper's half of the spacing: these bodies fill a third of it.
    let obstacle_range_m = table.number("obstacle_range_m", 0.05..=100.0, Some(1.2));
    let head_offset_m = table.number("head_offset_m", 0.01..=5.0, Some(0.3));
    let damping_per_s = table.number("damping_per_s", 0.0..=100.0, Some(1.0));
    // dt/m = 0.1 as in the paper, at a tick of 50 ms.
    let mass_kg = table.number("mass_kg", 0.001..=10_000.0, Some(0.5));
    // d^2 dt/I = 0.2 as in the paper, at a tick of 50 ms: well under 2, where the heading's loop would diverge.
    let inertia_kgm2 = table.number("inertia_kgm2", 0.0001..=10_000.0, Some(0.0225));
    Some(Flock {
        leader: leader?,
        waypoints_m: waypoints_m?,
        leader_speed_mps: leader_speed_mps?,
        waypoint_radius_m: waypoint_radius_m?,
        arrive_radius_m: arrive_radius_m?,
        spacing_m: spacing_m?,
        gain: gain?,
        obstacle_range_m: obstacle_range_m?,
        head_offset_m: head_offset_m?,
        damping_per_s: damping_per_s?,
        mass_kg: mass_kg?,
        inertia_kgm2: inertia_kgm2?,
    })
}
