//! Links by pacts on a body: what deployment and flocking have in common there ([`crate::links`]).
//!
//! The node tells such a law what peers report of their links, asks it what to report whenever a beacon is due, and
//! has the guard hold the body in its discs. What a body adds to a point: it errs about its place, and it needs room to
//! stop.

use crate::avoid::Disc;
use crate::links::{LinkPeer, Place};
use drover_contract::{LinkReport, Stamp, Vec2};

/// Laws keep that much farther inside of their discs than the guard, metres: at their rim they could only stop.
pub(crate) const INNER_M: f64 = 0.15;
/// How long a term of the links' logical time lasts, seconds: several beacons, lost ones too.
pub(crate) const TERM_S: f64 = 1.5;
/// From a measurement to wheels that obey it, with the tick, seconds.
const REACTION_S: f64 = 0.2;

/// A law that keeps links.
pub(crate) trait Tied {
    /// Where it wishes to move, m/s, world frame.
    fn wish_w(&self) -> Vec2;

    /// Takes what a peer reports of its links. Afterwards [`Tied::discs`] may be others.
    fn handle_report(&mut self, now: Stamp, report: &LinkReport, place: &Place);

    /// What is due about links, and what to tell of them. Afterwards [`Tied::discs`] may be others.
    fn attend(&mut self, now: Stamp, place: &Place, peers: &[LinkPeer]) -> Option<LinkReport>;

    /// C, world frame: `put` takes each disc in which the robot has to stay.
    fn discs(&self, put: &mut dyn FnMut(Disc));
}

/// Where a body is for its links: at `pos_w`, with the room that it needs to stop from `speed_mps`.
pub(crate) fn place(law: &dyn Tied, pos_w: Vec2, speed_mps: f64, brake_mps2: f64) -> Place {
    let speed_mps = speed_mps.abs();
    let stop_m = speed_mps * REACTION_S + speed_mps * speed_mps / (2.0 * brake_mps2);
    Place { pos_w, wish_w: law.wish_w(), stop_m }
}

/// A disc as a law on a body keeps it: not to its rim.
pub(crate) fn inner(disc: Disc, inner_m: f64) -> Disc {
    Disc { radius_m: (disc.radius_m - inner_m).max(0.0), ..disc }
}
