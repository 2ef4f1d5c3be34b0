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
//! A peer that the scan sees is measured by the scan: the bounds on both poses then do not matter. One that it does not
//! see is taken from its beacon, as large as the bounds make it.

use super::Reason;
use crate::estimate::Motion;
use crate::peers::Body;
use crate::sight::{Surroundings, on_body};
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
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Plane {
    pub(super) normal_b: Vec2,
    pub(super) advance_m: f64,
    pub(super) reason: Reason,
}

impl Obstacles {
    /// From the raw scan and the peers' bodies. `keep_m` is the body's radius and margin; `unheard` says that some peer
    /// of the swarm is not heard now.
    pub(crate) fn new(seen: &Surroundings, motion: &Motion, bodies: &[Body], keep_m: f64, unheard: bool) -> Self {
        let peers = bodies.iter().filter_map(|body| peer_plane(seen, motion, body, keep_m));
        // A blind spot is an obstacle at the margin: no advance into it.
        let blind = seen.blind_b.iter().map(|ray_b| plane(*ray_b, 0.0, Reason::Obstacle));
        let strangers = seen.points_b.iter().filter(|_| unheard).filter_map(|hit_b| stranger_plane(*hit_b, keep_m));
        Self { points_b: seen.points_b.clone(), planes: peers.chain(blind).chain(strangers).collect() }
    }
}

fn plane(normal_b: Vec2, advance_m: f64, reason: Reason) -> Plane {
    Plane { normal_b, advance_m: advance_m.max(0.0), reason }
}

fn stranger_plane(hit_b: Vec2, keep_m: f64) -> Option<Plane> {
    let normal_b = hit_b.try_normalize(1e-6)?;
    let in_the_way = normal_b.x.abs() >= IN_THE_WAY_COS;
    in_the_way.then(|| plane(normal_b, (hit_b.norm() - keep_m) / 2.0, Reason::Obstacle))
}

fn peer_plane(seen: &Surroundings, motion: &Motion, body: &Body, keep_m: f64) -> Option<Plane> {
    let hits_b =
        seen.points_b.iter().filter(|point_b| on_body(motion.pose_wb.transform(**point_b), body, motion.pos_bound_m));
    let nearest_b = hits_b.min_by(|a, b| a.norm_squared().total_cmp(&b.norm_squared()));
    let (towards_b, gap_m) = match nearest_b {
        Some(hit_b) => (*hit_b, hit_b.norm() - keep_m),
        None => {
            let centre_b = motion.pose_wb.inverse_transform(body.pos_w);
            let bound_m = (body.bound_m + motion.pos_bound_m).min(BOUND_M_MAX);
            (centre_b, centre_b.norm() - body.radius_m - bound_m - keep_m)
        }
    };
    let normal_b = towards_b.try_normalize(1e-6)?;
    Some(plane(normal_b, gap_m / 2.0, Reason::Peer))
}
