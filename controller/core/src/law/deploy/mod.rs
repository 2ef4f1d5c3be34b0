//! Deployment: a swarm moves to a commanded layout, and its radio graph is connected at every moment.
//!
//! **In**: where the robot is, where the peers within radio range are, walls within sight, the layout (world frame,
//! metres). **Out**: where to move to in the next period, at most `v_max T` away, straight.
//!
//! **Idea**: a robot is drawn to the layout, held together with its neighbours by a few links and pushed away from what
//! lies in the direction of its next step. Far from the layout (stage 1) everybody is drawn to its centre; within its
//! surroundings (stage 2) to its own target.
//!
//! | file | what |
//! |---|---|
//! | [`forces`] | eq. 1-14: attraction to goal and links, repulsion, "infinite" as priority |
//! | [`predict`] | single-step location prediction, steps 1-6 |
//! | [`pilot`] | one robot: stages, what attracts it, its wish |
//! | [`detour`] | out of standstills |
//! | [`topology`] | which links are kept: all, RNG, LMST of k hops; the tree towards the goal |
//! | [`geodesic`], [`known_map`] | shortest ways where the map is known: out of pockets |
//! | [`body`] | the law on two wheels |
//! | [`teammate`], [`places`] | one robot that knows its peers by beacons; who goes where after losses |
//! | [`lockstep`] | the paper's synchronous swarm: all decide on one snapshot |
//!
//! **Source**: Fan Gaojun et al., "Self-organized deployment of active sensor networks with preserved connectivity"
//! (2010, in Chinese), equation numbers as printed; docs/papers.md says what of it holds. Its theorems 2 and 3 do not:
//! what keeps the network together here is the safe set ([`crate::avoid`]) on kept links.
//!
//! **Departures** (`mode = "safe"`): links of the local minimum spanning tree of k hops, which opens rings around
//! obstacles that one hop cannot see; a robot of stage 1 whose parent in the tree is far follows it and nothing else;
//! the safe set is the last layer; targets are assigned by least squares of the way.
//!
//! **Cost** per robot and period: O(n) for the forces, O(n^2) for the tree of the n robots within k hops.
//! **Cannot solve**: never; where nothing is allowed the robot stays.

mod body;
mod detour;
mod forces;
mod geodesic;
mod known_map;
mod lockstep;
mod pilot;
mod places;
mod predict;
mod teammate;
mod topology;

pub(crate) use body::Deployer;
pub use geodesic::{Aim, CELL_M, Field, Geodesic};
pub use lockstep::{Lockstep, Moves};
pub use pilot::{Pilot, Sight};
pub use places::Places;
pub use teammate::{Around, Teammate};
pub use topology::{Graph, KeptGraph};

use crate::avoid::{SafeSetParams, Steer};
use drover_config::{Deploy, DeployMode, DeploySteer, Forces, KeptLinks, Rotation};
use drover_contract::Vec2;
use forces::Gains;

/// What the law knows from the file; lengths in metres, one period's speeds as metres a period.
#[derive(Clone, Debug)]
pub struct Params {
    pub(crate) gains: Gains,
    pub(crate) period_s: f64,
    pub(crate) view_cos: f64,
    pub(crate) rotation: Rotation,
    pub(crate) forces: Forces,
    /// Links are not optimised: all attract, in stage 2 too.
    pub(crate) all_links: bool,
    pub(crate) follow: bool,
    /// Whether who gets nowhere goes around: with the safe set alone.
    pub(crate) detours: bool,
    pub(crate) steer: Steer,
    pub(crate) safe: SafeSetParams,
    pub(crate) range_m: f64,
    /// Centre of the layout: what everybody is drawn to in stage 1.
    pub(crate) goal_w: Vec2,
    /// Share of the way from there to the own target that is headed for.
    pub(crate) spread: f64,
    pub(crate) goalward: f64,
    /// South-west and north-east corner of the box of stage 2.
    pub(crate) box_w: (Vec2, Vec2),
    pub(crate) arrive_m: f64,
    /// Radius of each robot, metres; 0 for points.
    pub(crate) body_m: f64,
}

impl Params {
    /// From a checked configuration.
    #[must_use]
    pub fn of(deploy: &Deploy) -> Self {
        let step_m = deploy.speed_mps * deploy.period_s;
        let targets = deploy.targets_m.iter().map(|[x, y]| Vec2::new(*x, *y));
        let first = targets.clone().next().unwrap_or_else(Vec2::zeros);
        let (low, high) = targets.fold((first, first), |(low, high), at| (low.inf(&at), high.sup(&at)));
        let interval = Vec2::repeat(deploy.interval_m);
        Self {
            gains: Gains::of(deploy),
            period_s: deploy.period_s,
            view_cos: drover_contract::math::cos(deploy.view_rad),
            rotation: deploy.rotation,
            forces: deploy.forces,
            all_links: deploy.links == KeptLinks::All,
            follow: deploy.follow,
            detours: deploy.mode == DeployMode::Safe && deploy.detours,
            steer: match deploy.steer {
                DeploySteer::Heading => Steer::Heading,
                DeploySteer::Project => Steer::Project,
            },
            safe: SafeSetParams { robot_gap_m: deploy.robot_gap_m, wall_gap_m: deploy.wall_gap_m, step_m_max: step_m },
            range_m: deploy.range_m,
            goal_w: (low + high) / 2.0,
            spread: deploy.spread,
            goalward: deploy.goalward,
            box_w: (low - interval, high + interval),
            arrive_m: deploy.arrive_m,
            body_m: 0.0,
        }
    }

    /// The same for bodies of this radius, metres: all gaps are then from rim to rim.
    #[must_use]
    pub fn with_bodies(self, radius_m: f64) -> Self {
        let SafeSetParams { robot_gap_m, wall_gap_m, step_m_max } = self.safe;
        let (robot_gap_m, wall_gap_m) = (robot_gap_m + 2.0 * radius_m, wall_gap_m + radius_m);
        Self { safe: SafeSetParams { robot_gap_m, wall_gap_m, step_m_max }, body_m: radius_m, ..self }
    }

    /// Whether a place lies in the box of stage 2.
    fn in_box(&self, at_w: Vec2) -> bool {
        let (low, high) = self.box_w;
        (low.x..=high.x).contains(&at_w.x) && (low.y..=high.y).contains(&at_w.y)
    }
}

#[cfg(test)]
mod testing;
#[cfg(test)]
mod tests;
