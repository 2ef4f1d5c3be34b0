//! What the runs of one row say together.

use super::runs::FlockRun;
use drover_swarm::{Spread, Worst};
use serde::Serialize;

/// The runs of one row on one scene. Shares have Wilson's 95 % interval, numbers Student's.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct FlockSummary {
    /// Share of the runs in which nobody was lost.
    pub success: Option<Spread>,
    /// Followers that were lost, a run.
    pub lost: Option<Spread>,
    /// Polarisation at the end, of the least ordered party.
    pub order: Option<Spread>,
    /// Mean distance from the party's middle at the end, of the most scattered party, metres.
    pub cohesion_m: Option<Spread>,
    /// The least gap of two bodies, metres.
    pub min_gap_robot_m: Option<Spread>,
    /// The least gap of a body and a wall, metres.
    pub min_gap_wall_m: Option<Spread>,
    /// Share of the runs in which somebody touched something.
    pub touched: Option<Spread>,
    /// Of the successes: when everybody was near to the leader for good, s.
    pub gathered_s: Option<Spread>,
    /// Of the successes: ways driven over shortest ways. Who is lost drives less, which is no merit.
    pub path_ratio: Option<Spread>,
    /// The longest time that a robot stayed at a place while its leader was under way, s.
    pub stuck_s: Option<Spread>,
    /// The longest time that a leader said to be giving way, s.
    pub gave_way_s: Option<Spread>,
    /// How often robots began to follow a wall, a run.
    pub wall_entries: Option<Spread>,
}

impl FlockSummary {
    pub(super) fn of(runs: &[FlockRun]) -> Self {
        use Worst::{Largest, Smallest};
        let shares = |of: fn(&FlockRun) -> bool, worst| Spread::of_truths(runs.iter().map(of), worst);
        let numbers = |of: fn(&FlockRun) -> f64, worst| Spread::of_numbers(runs.iter().map(of), worst);
        let some = |of: fn(&FlockRun) -> Option<f64>, worst| Spread::of_numbers(runs.iter().filter_map(of), worst);
        Self {
            success: shares(|run| run.figures.success, Smallest),
            lost: numbers(|run| run.figures.lost as f64, Largest),
            order: numbers(|run| run.figures.order, Smallest),
            cohesion_m: numbers(|run| run.figures.cohesion_m, Largest),
            min_gap_robot_m: some(|run| run.min_gap_robot_m, Smallest),
            min_gap_wall_m: some(|run| run.min_gap_wall_m, Smallest),
            touched: shares(|run| run.touched > 0, Largest),
            gathered_s: some(|run| run.figures.gathered_s.filter(|_| run.figures.success), Largest),
            path_ratio: some(|run| run.figures.path_ratio.filter(|_| run.figures.success), Largest),
            stuck_s: numbers(|run| run.figures.stuck_s, Largest),
            gave_way_s: numbers(|run| run.figures.gave_way_s, Largest),
            wall_entries: numbers(|run| run.figures.wall_entries as f64, Largest),
        }
    }
}
