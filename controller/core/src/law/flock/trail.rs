//! Where the leader went: a way that is free, for whoever cannot go straight to it.
//!
//! A follower remembers the places from which its leader was heard, and how far along them it has come itself: to the
//! next place as soon as that is near and nothing is seen in between. Places are passed one by one, so that a trail
//! that comes back behind a wall is not taken for one that leads there. Walls that keep a follower from its leader, or
//! a leader that is far ahead, make it go along the trail until it has come up with the leader again: always towards
//! the last of the places around that it can go straight to, so that it enters a door as its leader did.
//!
//! What is remembered is bounded: of a longer trail the oldest part is forgotten.

use super::{GUARDED, Params};
use crate::peers::Neighbour;
use drover_contract::{RobotId, Vec2};
use std::collections::VecDeque;

/// Places are this share of the spacing apart.
const APART: f64 = 0.25;
/// Most places.
const PLACES_MAX: usize = 512;
/// A leader that was not heard for so many spacings of its way has left no trail: what it drove around is not known.
const GAP_SPACINGS: f64 = 2.0;
/// A place is near within this many spacings, or within the flock's own reach.
const NEAR_SPACINGS: f64 = 1.2;
/// The trail is beside us within this share of how far we see: a wall in between would be seen.
const BESIDE: f64 = 2.0;
/// Places that were passed are remembered over so many spacings.
const BEHIND_SPACINGS: f64 = 3.0;
/// A leader farther away than the flock's own reach and so many spacings is followed along its trail.
const FAR_SPACINGS: f64 = 4.0;

/// The trail of one leader.
#[derive(Clone, Debug, Default)]
pub(super) struct Trail {
    leader: Option<RobotId>,
    /// The last is where the leader was not long ago.
    places_w: VecDeque<Vec2>,
    /// How far along them we have come.
    come_to: usize,
    lags: bool,
}

/// Where to go along the trail.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Aim {
    pub(super) place_w: Vec2,
    /// Whether nothing that is seen lies in the way to it.
    pub(super) clear: bool,
}

impl Trail {
    /// The leader is heard; `walls_w` is what is seen around `at_w`, and the flock reaches `reach_m` far from it.
    pub(super) fn hear(&mut self, params: &Params, leader: &Neighbour, (at_w, walls_w): (Vec2, &[Vec2]), reach_m: f64) {
        let leader_w = leader.pose_wb.position();
        let gap_m = self.places_w.back().map_or(f64::INFINITY, |last_w| (leader_w - last_w).norm());
        if self.leader != Some(leader.id) || gap_m > GAP_SPACINGS * params.spacing_m {
            *self = Self { leader: Some(leader.id), ..Self::default() };
        }
        if self.places_w.is_empty() || gap_m >= APART * params.spacing_m {
            self.places_w.push_back(leader_w);
        }
        if self.places_w.len() > PLACES_MAX {
            self.places_w.pop_front();
            self.come_to = self.come_to.saturating_sub(1);
        }
        let near_m = reach_m.max(NEAR_SPACINGS * params.spacing_m);
        while let Some(next_w) = self.places_w.get(self.come_to + 1)
            && (next_w - at_w).norm() <= near_m
            && is_clear(params, (at_w, walls_w), *next_w)
        {
            self.come_to += 1;
        }
        while self.come_to as f64 * APART > BEHIND_SPACINGS {
            self.places_w.pop_front();
            self.come_to -= 1;
        }
        if !self.lags {
            // Whoever flocks beside the trail comes along without having been at each of its places.
            let apart_m = |place_w: &Vec2| (place_w - at_w).norm();
            let beside_m = near_m.min(BESIDE * params.obstacle_range_m);
            let beside = self.places_w.iter().enumerate().skip(self.come_to + 1);
            let nearest = beside.min_by(|a, b| apart_m(a.1).total_cmp(&apart_m(b.1)));
            if let Some((at, place_w)) = nearest.filter(|(_, place_w)| apart_m(place_w) <= beside_m)
                && is_clear(params, (at_w, walls_w), *place_w)
            {
                self.come_to = at;
            }
        }
        let far = (leader_w - at_w).norm() > reach_m + FAR_SPACINGS * params.spacing_m;
        self.lags = self.leads_on() && (self.lags || far);
    }

    /// Whether there is more of it than we have come along.
    fn leads_on(&self) -> bool {
        self.come_to + 1 < self.places_w.len()
    }

    /// Walls keep us from the leader: go where it went, if that is known. Whether this is something new.
    pub(super) fn turn_back(&mut self) -> bool {
        let new = !self.lags && self.leads_on();
        self.lags |= new;
        new
    }

    /// The leader has come to where it wanted, and so have we.
    pub(super) fn leave(&mut self) {
        self.lags = false;
    }

    /// Where to go along the trail; none for who goes straight to its leader.
    pub(super) fn aim(&self, params: &Params, at_w: Vec2, walls_w: &[Vec2]) -> Option<Aim> {
        if !self.lags {
            return None;
        }
        let around = || self.places_w.iter().take(self.come_to + 1);
        let clear = around().rev().find(|place_w| is_clear(params, (at_w, walls_w), **place_w));
        let nearest = || around().min_by(|a, b| (*a - at_w).norm().total_cmp(&(*b - at_w).norm()));
        let place_w = *clear.or_else(nearest)?;
        Some(Aim { place_w, clear: clear.is_some() })
    }
}

/// Whether nothing that is seen lies in the way to a place: where the last layer let the leader through it lets us, and
/// walls push us into the middle.
pub(super) fn is_clear(params: &Params, (at_w, walls_w): (Vec2, &[Vec2]), place_w: Vec2) -> bool {
    let room_m = params.radius_m + GUARDED * params.margin_m;
    let apart_m = (place_w - at_w).norm().max(1e-9);
    let way = (place_w - at_w) / apart_m;
    walls_w.iter().all(|wall_w| {
        let ahead_m = (wall_w - at_w).dot(&way);
        ahead_m <= 0.0 || ahead_m >= apart_m || way.perp(&(wall_w - at_w)).abs() >= room_m
    })
}
