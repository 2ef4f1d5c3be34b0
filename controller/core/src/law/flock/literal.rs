//! The paper's follower: sections 2 to 4 with the printed numbers, blind reversing and all; for comparison.
//!
//! **Readings.** N_i is everybody of the party that is heard. A wall within S repels with the pair potential, L = S,
//! from its nearest return: the paper leaves this open. What of [5] would avoid robots is rigid-body contact: a wall
//! follower waits for whoever is within D ahead. The wall mode turns as fast as it likes (15 degrees every 10 ms) and
//! goes where it looks. The attractor r_c is the middle of the robots that are still flocking, the leader among them.
//! Each of the repairs can be switched on by itself, which is what the comparison's rows do.

use super::deadlock::{Displacement, refractory_over};
use super::laser::{companion_w, returns_w, wall_direction_w};
use super::pledge::{Along, Pledge, Room, Side};
use super::potential::{Head, acceleration_w, drive, pair_force};
use super::{Params, is_mate};
use crate::law::View;
use crate::peers::Neighbour;
use drover_config::WallFollowing;
use drover_contract::math::{atan2, cos, sin};
use drover_contract::{Stamp, Twist, Vec2, wrap};

/// Delta theta_s: how far a robot turns away from a wall that is nearer than at first, radians.
const AWAY_RAD: f64 = 15.0 / 180.0 * std::f64::consts::PI;
/// A peer counts as ahead within 60 degrees of the heading: cosine.
const AHEAD_COS: f64 = 0.5;
/// With a Pledge exit the way is looked along for this share of S.
const LOOK: f64 = 0.4;

/// What a literal follower remembers.
#[derive(Clone, Debug, Default)]
pub(super) struct Literal {
    before: Twist,
    displacement: Displacement,
    left: Option<Stamp>,
    wall: Option<Wall>,
    entries: u32,
}

/// A wall that is followed.
#[derive(Clone, Copy, Debug)]
struct Wall {
    /// d_s0.
    distance_m: f64,
    /// Where the companion was last.
    companion_w: Vec2,
    side: Side,
    pledge: Option<Pledge>,
}

impl Literal {
    /// One that asked for `before` in the tick before.
    #[cfg(test)]
    pub(super) fn of(before: Twist) -> Self {
        Self { before, ..Self::default() }
    }

    pub(super) fn on_wall(&self) -> bool {
        self.wall.is_some()
    }

    pub(super) fn entries(&self) -> u32 {
        self.entries
    }

    pub(super) fn halt(&mut self) {
        self.before = Twist::ZERO;
        self.displacement.restart();
    }

    /// One step behind `leader`.
    pub(super) fn step(&mut self, params: &Params, leader: &Neighbour, view: &View<'_>) -> Twist {
        let at_w = view.motion.pose_wb.position();
        let attractor_w = attractor_w(params, leader, view);
        let nearest_w = companion_w(returns_w(params, view), at_w);
        if let Some(wall) = self.wall {
            self.wall = wall.goes_on(params, (nearest_w, attractor_w), view);
            if self.wall.is_none() {
                self.left = Some(view.now);
                self.displacement.restart();
            }
        } else if let Some(nearest_w) = nearest_w.filter(|_| self.is_trapped(params, nearest_w, attractor_w, view)) {
            self.entries += 1;
            self.wall = Some(Wall::begin(params, (nearest_w, attractor_w), view));
        }
        let twist = match &self.wall {
            Some(wall) => wall.follow(params, view),
            None => {
                let force_w = force_w(params, leader, nearest_w, view);
                drive(params, force_w, self.before, (&view.motion, view.dt_s))
            }
        };
        self.before = twist;
        twist
    }

    fn is_trapped(&mut self, params: &Params, nearest_w: Option<Vec2>, attractor_w: Vec2, view: &View<'_>) -> bool {
        let at_w = view.motion.pose_wb.position();
        let speed_mps = self.displacement.speed_mps(view.now, at_w, params.deadlock);
        let Some(nearest_w) = nearest_w else { return false };
        params.walls != WallFollowing::None
            && refractory_over(view.now, self.left)
            && speed_mps.is_some_and(|speed_mps| speed_mps < params.deadlock_mps)
            && returns_w(params, view).nth(1).is_some()
            && (at_w - nearest_w).dot(&(attractor_w - at_w)) < 0.0
    }
}

/// (4): the sum of all forces on the reference point.
fn force_w(params: &Params, leader: &Neighbour, nearest_w: Option<Vec2>, view: &View<'_>) -> Vec2 {
    let own = Head::own(&view.motion, params.head_offset_m);
    let led = Head::of(leader, params.head_offset_m);
    let mut sum_w = (own.vel_w - led.vel_w) * -params.damping_per_s + acceleration_w(leader);
    for peer in view.neighbours.iter().filter(|peer| is_mate(params, peer)) {
        // The agent law's r is the reference point.
        let apart_w = own.pos_w - Head::of(peer, params.head_offset_m).pos_w;
        sum_w += pair_force(params.gain, params.spacing_m, apart_w);
    }
    if let Some(nearest_w) = nearest_w {
        let away_w = own.pos_w - nearest_w;
        if away_w.norm() < params.obstacle_range_m {
            sum_w += pair_force(params.gain, params.obstacle_range_m, away_w);
        }
    }
    sum_w
}

/// r_c: the middle of those of the party that are still flocking, the leader among them (errata: divided by their
/// number).
fn attractor_w(params: &Params, leader: &Neighbour, view: &View<'_>) -> Vec2 {
    let flocking = view.neighbours.iter().filter(|peer| is_mate(params, peer) && peer.leader == Some(params.leader));
    let (sum_w, count) =
        flocking.fold((Vec2::zeros(), 0.0), |(sum_w, count), peer| (sum_w + peer.pose_wb.position(), count + 1.0));
    if count > 0.0 { sum_w / count } else { leader.pose_wb.position() }
}

impl Wall {
    fn begin(params: &Params, (nearest_w, attractor_w): (Vec2, Vec2), view: &View<'_>) -> Self {
        let at_w = view.motion.pose_wb.position();
        let is_m = (nearest_w - at_w).norm();
        let wish_w = attractor_w - at_w;
        let pledge = params.walls == WallFollowing::Pledge;
        Self {
            distance_m: if params.wall_distance_m > 0.0 { params.wall_distance_m } else { is_m },
            companion_w: nearest_w,
            side: Side::towards(nearest_w - at_w, wish_w),
            pledge: pledge.then(|| Pledge::begin(view.now, nearest_w, attractor_w, &view.motion.pose_wb)),
        }
    }

    /// Whether the companion stays; as it is then.
    fn goes_on(
        mut self,
        params: &Params,
        (nearest_w, attractor_w): (Option<Vec2>, Vec2),
        view: &View<'_>,
    ) -> Option<Self> {
        let at_w = view.motion.pose_wb.position();
        if let Some(pledge) = &mut self.pledge {
            let points_w: Vec<(Vec2, f64)> =
                returns_w(params, view).map(|place_w| (place_w, self.distance_m)).collect();
            let walls = points_w.len();
            let room = Room { at_w, points_w: &points_w, walls, look_m: LOOK * params.obstacle_range_m };
            if !params.side_latch {
                pledge.choose_side(at_w, attractor_w - at_w);
            }
            return match pledge.step(view.now, &room, attractor_w) {
                Along::Way(way_w) => {
                    self.companion_w = at_w + way_w;
                    Some(self)
                }
                Along::Nowhere => Some(self),
                Along::Done => None,
            };
        }
        let nearest_w = nearest_w?;
        let ends = (at_w - nearest_w).dot(&(attractor_w - at_w)) > 0.0;
        self.companion_w = nearest_w;
        (!ends).then_some(self)
    }

    fn follow(&self, params: &Params, view: &View<'_>) -> Twist {
        let pose_wb = view.motion.pose_wb;
        let (at_w, yaw_rad) = (pose_wb.position(), pose_wb.yaw_rad);
        let way_w = match self.pledge {
            Some(_) => self.companion_w - at_w,
            None => self.printed_way_w(params, view),
        };
        let off_rad = wrap(atan2(way_w.y, way_w.x) - yaw_rad);
        let most_rad = params.wall_turn_radps * view.dt_s;
        let turn_rad = off_rad.clamp(-most_rad, most_rad);
        let is_ahead = |peer: &&Neighbour| {
            let apart_w = peer.pose_wb.position() - at_w;
            apart_w.norm() < params.avoid_m && apart_w.dot(&pose_wb.heading()) > AHEAD_COS * apart_w.norm()
        };
        let waits = view.neighbours.iter().any(|peer| is_ahead(&peer));
        // Who cannot turn at once turns on the spot first.
        let speed_mps = if waits || off_rad.abs() > most_rad { 0.0 } else { params.wall_speed_mps };
        Twist::new(speed_mps, turn_rad / view.dt_s)
    }

    /// (9), and the turn away from a wall that is nearer than at first.
    fn printed_way_w(&self, params: &Params, view: &View<'_>) -> Vec2 {
        let pose_wb = view.motion.pose_wb;
        let to_wall = self.companion_w - pose_wb.position();
        let heading_w = pose_wb.heading();
        let forwards_w = if params.side_latch { self.side.along_w(to_wall) } else { heading_w };
        let along_w = match wall_direction_w(returns_w(params, view)) {
            Some(along_w) if along_w.dot(&forwards_w) < 0.0 => -along_w,
            Some(along_w) => along_w,
            None => heading_w,
        };
        if to_wall.norm() >= self.distance_m {
            return along_w;
        }
        let away = if along_w.perp(&to_wall) > 0.0 { -AWAY_RAD } else { AWAY_RAD };
        let (sin, cos) = (sin(away), cos(away));
        Vec2::new(along_w.x * cos - along_w.y * sin, along_w.x * sin + along_w.y * cos)
    }
}
