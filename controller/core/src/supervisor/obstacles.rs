//! What the body may not touch, in the body frame of now.
//!
//! - **Points**: hits of the raw scan. The disc must stay `radius + margin` away from each. They are taken as standing.
//! - **Peers**: both sides move, so each may use at most half of the gap between them: a half-plane across the line of
//!   centres that the body's centre may not cross (a buffered Voronoi cell: D. Zhou et al., "Fast, on-line collision
//!   avoidance for dynamic vehicles using buffered Voronoi cells", IEEE RA-L 2(2), 2017). Two robots that each stay in
//!   their half never meet, whatever either does.
//!
//! - **Unheard peers**: while one of the swarm is not heard, any hit in the way, to the front or the back, may be it,
//!   on its way to us: there too the body uses half of the gap only. Nobody waits; the approach to things ahead is
//!   slower.
//!
//! - **Links**: discs on which both ends of a link have agreed; the centre stays in each ([`crate::links`]).
//!
//! A peer that has been silent for long and is not where it was last, because the scan looks through that place, is
//! wherever the scan shows something: as an unheard peer.
//!
//! A peer that the scan sees is measured by the scan: the bounds on both poses then do not matter. One that it does not
//! see is taken from its beacon, as large as the bounds make it.

use super::Reason;
use crate::peers::Body;
use crate::sight::{Matches, Sighting, Surroundings};
use drover_contract::Vec2;

/// What is added to an unseen peer for what the poses are uncertain by, metres, at most: beyond it a lost robot would
/// freeze all around it, and the scan has the word.
const BOUND_M_MAX: f64 = 0.5;

/// A hit is in the way if it lies this close to the body's axis: cosine of 30 degrees.
const IN_THE_WAY_COS: f64 = 0.866;

/// Something in the body frame that limits where the body's centre may go.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Obstacles {
    /// Standing points.
    pub(super) points_b: Vec<Vec2>,
    /// Half-planes: the centre may not advance farther than `advance_m` along `normal_b`.
    pub(super) planes: Vec<Plane>,
    /// Discs that the centre may not leave: centre and radius, metres.
    pub(super) discs: Vec<(Vec2, f64)>,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Plane {
    pub(super) normal_b: Vec2,
    pub(super) advance_m: f64,
    pub(super) reason: Reason,
}

impl Obstacles {
    /// From the raw scan and the peers' bodies, matched: what a body can come to that goes no farther than `reach_m`
    /// and keeps `keep_m`, its radius and margin. What was held before is forgotten.
    pub(crate) fn fill(&mut self, seen: &Surroundings, peers: &Peers<'_>, keep_m: f64, reach_m: f64) {
        // Half of a gap is a limit: what is farther than twice the reach limits nobody.
        let within_m = keep_m + 2.0 * reach_m;
        let near = |point_b: &&Vec2| point_b.norm_squared() <= within_m * within_m;
        self.points_b.clear();
        self.points_b.extend(seen.points_b.iter().filter(near));
        self.discs.clear();
        self.planes.clear();
        let pairs = peers.bodies.iter().zip(&peers.matches.bodies);
        self.planes.extend(pairs.filter_map(|(body, place)| peer_plane(body, *place, peers.own_bound_m, keep_m)));
        // A blind spot is an obstacle at the margin: no advance into it.
        self.planes.extend(seen.blind_b.iter().map(|ray_b| plane(*ray_b, 0.0, Reason::Obstacle)));
        if peers.unheard {
            self.planes.extend(self.points_b.iter().filter_map(|hit_b| stranger_plane(*hit_b, keep_m)));
        }
    }
}

impl Obstacles {
    /// The centre has to stay in these discs, body frame: the links that were agreed on. One that it is outside of
    /// already it may not leave farther.
    pub(crate) fn stay_in(&mut self, discs_b: impl Iterator<Item = (Vec2, f64)>) {
        self.discs.extend(discs_b.map(|(centre_b, radius_m)| (centre_b, radius_m.max(centre_b.norm()))));
    }
}

/// The peers' bodies, where they are seen, and how well we know where we are.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Peers<'a> {
    pub(crate) bodies: &'a [Body],
    pub(crate) matches: &'a Matches,
    /// Metres.
    pub(crate) own_bound_m: f64,
    /// Some peer of the swarm is not heard now.
    pub(crate) unheard: bool,
}

fn plane(normal_b: Vec2, advance_m: f64, reason: Reason) -> Plane {
    Plane { normal_b, advance_m: advance_m.max(0.0), reason }
}

fn stranger_plane(hit_b: Vec2, keep_m: f64) -> Option<Plane> {
    let distance_m = hit_b.norm();
    // First the cheap question: most hits are not in the way.
    if hit_b.x.abs() < IN_THE_WAY_COS * distance_m || distance_m < 1e-6 {
        return None;
    }
    Some(plane(hit_b / distance_m, (distance_m - keep_m) / 2.0, Reason::Obstacle))
}

/// The near side of a peer that is heard and not seen, as large as the bounds on both poses make it, body frame; `None`
/// if it is seen, or all around us.
pub(crate) fn near_side(body: &Body, sighting: Sighting, own_bound_m: f64) -> Option<Vec2> {
    let Sighting { centre_b, hit_b, gone } = sighting;
    let apart_m = centre_b.norm();
    let towards_b = centre_b.try_normalize(1e-6).filter(|_| hit_b.is_none() && !gone)?;
    Some(towards_b * (apart_m - widened_m(body, own_bound_m)).max(1e-3))
}

/// Radius of a peer's body, and what its place is uncertain by, metres.
fn widened_m(body: &Body, own_bound_m: f64) -> f64 {
    body.radius_m + (body.bound_m + own_bound_m).min(BOUND_M_MAX)
}

fn peer_plane(body: &Body, sighting: Sighting, own_bound_m: f64, keep_m: f64) -> Option<Plane> {
    let Sighting { centre_b, hit_b, gone } = sighting;
    if gone {
        return None;
    }
    let (towards_b, gap_m) = match hit_b {
        Some(hit_b) => (hit_b, hit_b.norm() - keep_m),
        None => (centre_b, centre_b.norm() - widened_m(body, own_bound_m) - keep_m),
    };
    let normal_b = towards_b.try_normalize(1e-6)?;
    Some(plane(normal_b, gap_m / 2.0, Reason::Peer))
}
