//! What an exploration is measured by, from outside: what of the ground is known, step by step.

use super::cells::CellTeam;
use serde::Serialize;

/// Shares of the free cells that can be reached.
const SHARES: [f64; 4] = [0.90, 0.95, 0.96, 0.99];

/// One run of an exploration.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ExploreFigures {
    /// Steps until 90 % of the free cells that can be reached were known; none if they never were.
    pub steps_90: Option<u32>,
    /// The same for 95 %.
    pub steps_95: Option<u32>,
    /// The same for 96 %, the paper's.
    pub steps_96: Option<u32>,
    /// The same for 99 %.
    pub steps_99: Option<u32>,
    /// Steps until nobody that lives could reach a frontier cell any more over cells that no dead robot holds.
    pub steps_finish: Option<u32>,
    /// Whether that came: the certificate.
    pub finished: bool,
    /// Frontier cells that somebody who lives can reach so, in the end.
    pub unreached_frontiers: u64,
    /// The share of the free cells that can be reached which is known; what is behind a dead robot is missing.
    pub coverage: f64,
    /// The robots' ways together, metres.
    pub path_m: f64,
    /// Views of free cells by a second, third ... robot, over the free cells that are known.
    pub overlap: f64,
    /// The share of chosen targets that another robot had seen first.
    pub obex: f64,
    /// Steps in which a body stood in another's way.
    pub blocked: u64,
    /// What was said, bytes, counted by receiver within range; none if all share one map.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub bytes: Option<u64>,
    /// Steps to 96 % over the fewest that could do if every step were diagonal and saw only new cells:
    /// `(0.96 A / n - w^2) / (2 w - 1)` with a sensor `w` cells wide.
    pub sweep_bound_ratio: Option<f64>,
}

/// When each of the shares was first known.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Milestones(pub(super) [Option<u32>; 4]);

impl Milestones {
    /// So much is known after so many steps.
    pub(super) fn see(&mut self, coverage: f64, steps: u32) {
        for (milestone, share) in self.0.iter_mut().zip(SHARES) {
            if coverage >= share {
                milestone.get_or_insert(steps);
            }
        }
    }

    /// Whether there is nothing more to wait for.
    pub(super) fn are_passed(&self) -> bool {
        self.0[SHARES.len() - 1].is_some()
    }
}

/// Watches one run.
#[derive(Clone, Debug, Default)]
pub(crate) struct Exploring {
    milestones: Milestones,
}

impl Exploring {
    /// After the first look, and after every step.
    pub(crate) fn see(&mut self, team: &CellTeam) {
        self.milestones.see(team.coverage(), team.steps());
    }

    /// What came out; cells have sides of `cell_m`.
    pub(crate) fn figures(&self, team: &CellTeam, cell_m: f64) -> ExploreFigures {
        let Milestones([steps_90, steps_95, steps_96, steps_99]) = self.milestones;
        let bound = team.sweep_bound(SHARES[2]);
        ExploreFigures {
            steps_90,
            steps_95,
            steps_96,
            steps_99,
            steps_finish: team.finished(),
            finished: team.finished().is_some(),
            unreached_frontiers: team.frontiers_in_reach(),
            coverage: team.coverage(),
            path_m: team.path_cells() * cell_m,
            overlap: team.overlap(),
            obex: team.obex(),
            blocked: team.blocked(),
            bytes: team.bytes_said(),
            sweep_bound_ratio: steps_96.filter(|_| bound >= 1.0).map(|steps| f64::from(steps) / bound),
        }
    }
}
