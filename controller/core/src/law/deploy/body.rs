//! The law on a body with two wheels: its point moves become twists.
//!
//! The wish of the next period is taken to the safe set as for points, with the bodies' sizes in all gaps, and what is
//! allowed is driven: turn on the spot while it lies far off the heading, else an arc, as fast as the step is long. The
//! supervisor's guard then holds the twist to the same discs, peers and returns with what a body adds, the way that it
//! still goes until it stands.

use super::{Around, Params, Places, Teammate};
use crate::avoid::{Capsule, Disc, SafeSet};
use crate::law::pacts::{INNER_M, Tied, inner};
use crate::law::{Outcome, View, drive};
use crate::links::{LinkPeer, Place};
use drover_config::{Deploy, Exchange, POSE_ERROR_M, RobotFile};
use drover_contract::{LinkReport, RobotId, Stamp, Twist, Vec2};
use std::sync::Arc;

/// Returns farther than this are no matter, metres.
const SIGHT_M: f64 = 3.0;
/// A step shorter than this is none, metres.
const STEP_M_MIN: f64 = 0.01;

/// One robot that deploys.
#[derive(Clone, Debug)]
pub(crate) struct Deployer {
    mate: Teammate,
    period_s: f64,
    /// The file is for points that know each other at a glance.
    by_snapshot: bool,
    /// Where it wishes to move, m/s, world frame.
    wish_w: Vec2,
    start_gap_m: Option<f64>,
    gap_m: f64,
    arrived: bool,
}

impl Deployer {
    /// Robot `own` (id and life) of `file` among `ids`.
    pub(crate) fn new(
        file: &RobotFile,
        deploy: &Deploy,
        ids: impl Iterator<Item = RobotId>,
        own: (RobotId, u32),
        now: Stamp,
    ) -> Self {
        let places = Arc::new(Places::new(ids, &deploy.targets_m, deploy.range_m));
        let params = Params::of(deploy).with_bodies(file.kind.body.radius_m);
        Self {
            mate: Teammate::with_params(params, deploy, places, own, (POSE_ERROR_M, now)),
            period_s: deploy.period_s,
            by_snapshot: deploy.exchange == Exchange::Snapshot,
            wish_w: Vec2::zeros(),
            start_gap_m: None,
            gap_m: f64::INFINITY,
            arrived: false,
        }
    }

    /// One tick.
    pub(crate) fn step(&mut self, view: &View<'_>) -> Outcome {
        if self.by_snapshot {
            return Outcome::Stale("by snapshots only points deploy: use drover sim, or exchange = \"beacons\"");
        }
        let pose_wb = view.motion.pose_wb;
        let at_w = pose_wb.position();
        self.gap_m = (self.mate.target_w() - at_w).norm();
        self.start_gap_m.get_or_insert(self.gap_m.max(1e-3));
        self.arrived = self.mate.has_arrived(at_w);
        let peers: Vec<LinkPeer> = view.neighbours.iter().map(link_peer).collect();
        let near = view.walls_b.iter().filter(|point_b| point_b.norm() <= SIGHT_M);
        let walls: Vec<Capsule> = near.map(|point_b| Capsule::disc(pose_wb.transform(*point_b), 0.0)).collect();
        let wish = self.mate.wish(&Around { at_w, peers: &peers, walls: &walls, dt_s: view.dt_s });
        let (discs, peers_w) =
            (view.discs.iter().map(|disc| inner(*disc, INNER_M)), peers.iter().map(|peer| peer.pos_w));
        let set = SafeSet::around(self.mate.params().safe, at_w, discs, peers_w, &walls);
        let step = self.mate.steer(&set, wish) - at_w;
        self.wish_w = step / self.period_s;
        let stays = self.arrived || step.norm() < STEP_M_MIN;
        Outcome::Solved(if stays { Twist::ZERO } else { drive::along(view, step, step.norm() / self.period_s) })
    }

    pub(crate) fn reached(&self) -> bool {
        self.arrived
    }

    pub(crate) fn target_w(&self) -> Vec2 {
        self.mate.target_w()
    }

    pub(crate) fn relies_on(&self, peer: RobotId) -> bool {
        self.mate.relies_on(peer)
    }

    /// Share of the way that is done; never all of it before it has arrived.
    pub(crate) fn progress(&self) -> f64 {
        self.start_gap_m.map_or(0.0, |start_m| (1.0 - self.gap_m / start_m).clamp(0.0, 0.99))
    }
}

impl Tied for Deployer {
    fn wish_w(&self) -> Vec2 {
        self.wish_w
    }

    fn handle_report(&mut self, now: Stamp, report: &LinkReport, place: &Place) {
        self.mate.handle_report(now, report, place);
    }

    fn attend(&mut self, now: Stamp, place: &Place, peers: &[LinkPeer]) -> Option<LinkReport> {
        self.mate.attend(now, place, peers);
        Some(self.mate.report(now))
    }

    fn discs(&self, put: &mut dyn FnMut(Disc)) {
        self.mate.discs().for_each(put);
    }
}

fn link_peer(neighbour: &crate::peers::Neighbour) -> LinkPeer {
    let (pose_wb, speed_mps) = (neighbour.pose_wb, neighbour.twist_b.speed_mps);
    let ahead_w = pose_wb.transform(Vec2::new(1.0, 0.0)) - pose_wb.position();
    LinkPeer { id: neighbour.id, pos_w: pose_wb.position(), vel_w: ahead_w * speed_mps, age_s: 0.0 }
}
