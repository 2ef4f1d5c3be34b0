//! What the runs of one row say together.

use super::runs::DeployRun;
use drover_swarm::{Spread, Worst};
use serde::Serialize;

/// The runs of one row on one scene. Shares have Wilson's 95 % interval, numbers Student's.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct DeploySummary {
    /// Share of the runs in which the swarm was one network at every moment.
    pub connected_always: Option<Spread>,
    /// Share of the runs in which all arrived.
    pub all_arrived: Option<Spread>,
    /// Share of the robots that arrived.
    pub arrived_fraction: Option<Spread>,
    /// Of all runs, s: one in which not all arrive counts with all the time it was given.
    pub time_s: Option<Spread>,
    /// Of the runs in which all arrived, s.
    pub arrival_s: Option<Spread>,
    /// What no run can beat, s.
    pub bound_s: Option<Spread>,
    /// Mean length of the robots' ways, metres.
    pub path_m_mean: Option<Spread>,
    /// The least distance of two centres, metres.
    pub min_gap_robot_m: Option<Spread>,
    /// The least distance of a centre and a wall, metres.
    pub min_gap_wall_m: Option<Spread>,
    /// Share of the runs in which somebody crossed a wall.
    pub tunnelled: Option<Spread>,
    /// The smallest algebraic connectivity.
    pub lambda2_min: Option<Spread>,
    /// Share of decisions that the last layer changed.
    pub guard_changed_fraction: Option<Spread>,
    /// How often a robot stayed because its problem had no solution.
    pub cannot_solve: Option<Spread>,
}

impl DeploySummary {
    pub(super) fn of(runs: &[DeployRun]) -> Self {
        use Worst::{Largest, Smallest};
        let shares = |of: fn(&DeployRun) -> bool, worst| Spread::of_truths(runs.iter().map(of), worst);
        let numbers = |of: fn(&DeployRun) -> f64, worst| Spread::of_numbers(runs.iter().map(of), worst);
        let some = |of: fn(&DeployRun) -> Option<f64>, worst| Spread::of_numbers(runs.iter().filter_map(of), worst);
        Self {
            connected_always: shares(|run| run.connected_always, Smallest),
            all_arrived: shares(|run| run.all_arrived, Smallest),
            arrived_fraction: numbers(|run| run.arrived_fraction, Smallest),
            time_s: numbers(|run| run.time_s, Largest),
            arrival_s: some(|run| run.all_arrived.then_some(run.time_s), Largest),
            bound_s: numbers(|run| run.bound_s, Largest),
            path_m_mean: numbers(|run| run.path_m_mean, Largest),
            min_gap_robot_m: some(|run| run.min_gap_robot_m, Smallest),
            min_gap_wall_m: some(|run| run.min_gap_wall_m, Smallest),
            tunnelled: shares(|run| run.tunnelled, Largest),
            lambda2_min: some(|run| run.lambda2_min, Smallest),
            guard_changed_fraction: some(|run| run.guard_changed_fraction, Largest),
            cannot_solve: some(|run| run.cannot_solve.map(|count| count as f64), Largest),
        }
    }
}
