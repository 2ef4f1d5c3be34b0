//! Links that a flock keeps (`guard = "full"`): what they ask of a robot's wish, and of the leader's pace.
//!
//! C, the discs in which a robot has to stay, is held by the last layer whatever a law wishes
//! ([`super::lockstep`], the supervisor's guard). A flock that knew nothing of it would end with every link taut, and
//! nobody could go round a trap. So, within the law:
//! - *Discs are bounds on velocities* as walls are ([`super::planes`]): the robot slides along the rim.
//! - *Who flocks gives slack*: beyond `SLACK` of a disc's radius it is drawn back to the disc's middle, so that a mate
//!   who has to go along a wall can. Who follows a wall is not drawn.
//! - *The leader waits* well before the party's worst link is taut: the longest of the tree of shortest links.

use super::planes::{Plane, Planes};
use super::{Params, is_mate};
use crate::avoid::Disc;
use crate::law::View;
use crate::law::pacts::inner;
use drover_contract::Vec2;

/// Who flocks is drawn back to the middle of a disc beyond this share of its radius.
const SLACK: f64 = 0.55;
/// Beyond this share of a disc's radius, a robot is at its rim.
const RIM: f64 = 0.98;
/// The leader slows down when the party's worst link is longer than the first share of what one may be, and stands at
/// the second.
const LOOSE: f64 = 0.45;
const TAUT: f64 = 0.7;

/// Bounds, with the discs of links beside them.
pub(super) fn held(mut planes: Planes, params: &Params, view: &View<'_>) -> Planes {
    let at_w = view.motion.pose_wb.position();
    for disc in discs(params, view) {
        let out_w = at_w - disc.centre_w;
        if let Some(normal_w) = out_w.try_normalize(1e-9) {
            planes.push(Plane { normal_w, most_mps: (disc.radius_m - out_w.norm()) / params.settle_s });
        }
    }
    planes
}

/// C as the law keeps it.
fn discs<'a>(params: &Params, view: &'a View<'_>) -> impl Iterator<Item = Disc> + 'a {
    let inner_m = params.inner_m;
    view.discs.iter().map(move |disc| inner(*disc, inner_m))
}

/// Whether a link holds it back: what it may dither there is no motion.
pub(super) fn is_at_rim(params: &Params, view: &View<'_>) -> bool {
    let at_w = view.motion.pose_wb.position();
    discs(params, view).any(|disc| (at_w - disc.centre_w).norm() > RIM * disc.radius_m)
}

/// The wish of a robot that flocks, with what its links draw.
pub(super) fn drawn_w(wish_w: Vec2, params: &Params, view: &View<'_>) -> Vec2 {
    if view.discs.is_empty() {
        return wish_w;
    }
    let at_w = view.motion.pose_wb.position();
    let pull = |disc: Disc| {
        let in_w = disc.centre_w - at_w;
        let (out_m, slack_m) = (in_w.norm(), SLACK * disc.radius_m);
        let share = ((out_m - slack_m) / (disc.radius_m - slack_m).max(1e-9)).clamp(0.0, 1.0);
        in_w * (share * params.speed_mps / out_m.max(1e-9))
    };
    let most_mps = params.speed_mps.min(view.limits.speed_mps_max);
    (wish_w + discs(params, view).map(pull).sum::<Vec2>()).cap_magnitude(most_mps)
}

/// Share of its speed at which a leader drives on: less while the party's worst link is long.
pub(super) fn pace(params: &Params, view: &View<'_>) -> f64 {
    if params.link_m <= 0.0 {
        return 1.0;
    }
    let share = worst_m(params, view) / params.link_m;
    ((TAUT - share) / (TAUT - LOOSE)).clamp(0.0, 1.0)
}

/// The longest link of the party's minimum spanning tree, metres.
fn worst_m(params: &Params, view: &View<'_>) -> f64 {
    let mates = view.neighbours.iter().filter(|peer| is_mate(params, peer));
    longest_link_m(mates.map(|peer| peer.pose_wb.position()).chain([view.motion.pose_wb.position()]))
}

/// The longest link of the minimum spanning tree of some places (Prim's way), metres; 0 of fewer than two: no shorter
/// range joins them all.
pub fn longest_link_m(places_w: impl Iterator<Item = Vec2>) -> f64 {
    let mut outside: Vec<(Vec2, f64)> = places_w.map(|place_w| (place_w, f64::INFINITY)).collect();
    let Some((mut newest_w, _)) = outside.pop() else { return 0.0 };
    let mut longest_m = 0.0_f64;
    while !outside.is_empty() {
        let mut nearest = 0;
        for at in 0..outside.len() {
            outside[at].1 = outside[at].1.min((outside[at].0 - newest_w).norm());
            nearest = if outside[at].1 < outside[nearest].1 { at } else { nearest };
        }
        let (place_w, gap_m) = outside.swap_remove(nearest);
        (newest_w, longest_m) = (place_w, longest_m.max(gap_m));
    }
    longest_m
}
