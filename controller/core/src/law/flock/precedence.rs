//! Who goes first, who is in whose way, and when a flock is at its end.

use super::{Params, is_mate};
use crate::law::View;
use crate::peers::Neighbour;
use drover_contract::Vec2;

/// A peer comes towards us if it looks against our way by more than this share.
const AGAINST: f64 = 0.3;
/// Slower than this share of the speed along walls, or of its own, a robot stands.
pub(super) const STANDS: f64 = 0.1;
/// Who sees no wall is near the flock's end within its reach and so many spacings.
const OPEN_SPACINGS: f64 = 2.0;

/// Whether a peer goes before us: the leader, or who is nearer to it.
pub(super) fn goes_first(params: &Params, leader: &Neighbour, peer: &Neighbour, at_w: Vec2) -> bool {
    let leader_w = leader.pose_wb.position();
    let theirs_m = (leader_w - peer.pose_wb.position()).norm();
    peer.id == params.leader || (theirs_m, peer.id) < ((leader_w - at_w).norm(), params.own)
}

/// Whether a leader stands.
pub(super) fn stands(params: &Params, leader: &Neighbour) -> bool {
    leader.twist_b.speed_mps.abs() < STANDS * params.leader_speed_mps
}

/// What a peer near a wall follower is to it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Meeting {
    /// Too far, or on its way.
    None,
    /// It looks against our way.
    Oncoming,
    /// It stands, and looks elsewhere.
    Standing,
}

impl Meeting {
    pub(super) fn of(params: &Params, peer: &Neighbour, at_w: Vec2, way_w: Vec2) -> Self {
        let apart_w = peer.pose_wb.position() - at_w;
        let gap_m = apart_w.norm() - params.radius_m - peer.radius_m;
        if gap_m > params.avoid_m - 2.0 * params.radius_m {
            Self::None
        } else if peer.pose_wb.heading().dot(&way_w) < -AGAINST && apart_w.dot(&way_w) > 0.0 {
            Self::Oncoming
        } else if peer.twist_b.speed_mps.abs() < STANDS * params.wall_speed_mps {
            Self::Standing
        } else {
            Self::None
        }
    }
}

/// Whether a flock comes to rest around its leader, that stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum End {
    /// It does not, or is still far.
    No,
    /// We are behind a mate that stands, too, and whoever is in front of it does not go on; or near and in the open.
    Behind,
    /// We are within its reach.
    Here,
}

impl End {
    /// `reach_m` is how far the flock reaches from its leader; `in_open`: no wall is seen.
    pub(super) fn of(params: &Params, leader: &Neighbour, (view, reach_m): (&View<'_>, f64), in_open: bool) -> Self {
        let at_w = view.motion.pose_wb.position();
        let near_m = |peer: &Neighbour| (peer.pose_wb.position() - at_w).norm();
        let in_front = |peer: &Neighbour| {
            is_mate(params, peer)
                && near_m(peer) <= params.spacing_m
                && peer.twist_b.speed_mps.abs() < STANDS * params.wall_speed_mps
                && goes_first(params, leader, peer, at_w)
        };
        if !stands(params, leader) {
            Self::No
        } else if near_m(leader) <= reach_m {
            Self::Here
        } else if (in_open && near_m(leader) <= reach_m + OPEN_SPACINGS * params.spacing_m)
            || view.neighbours.iter().any(in_front)
        {
            Self::Behind
        } else {
            Self::No
        }
    }
}
