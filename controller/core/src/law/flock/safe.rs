//! The follower that ships.
//!
//! **Flocking**: the velocity at which the forces of (4) balance, v_L + (F + dv_L/dt) / k, within what walls and peers
//! leave open ([`super::planes`]); the robot turns towards it and drives forwards. The leader's pull does not fade: it
//! grows until the straggler comes as fast as it can. Robots that follow a wall, and those of other parties, only
//! repel.
//!
//! **Trap**: walls, and not peers, have kept the robot from its wish for `deadlock_s`. It goes where its leader went
//! ([`super::trail`]). Where that is not known, or not free either, it follows the wall: [`super::pledge`], with the
//! leader, or the trail, as the attractor that moves.
//!
//! **Sight**: what stood around a moment ago counts ([`super::recent`]), and who is held with its way clear looks
//! around.
//!
//! **Right of way** ([`super::precedence`]): of two flocking robots the one nearer to the leader goes first, the other
//! backs off; of two that meet along a wall, the one with the wall on its right keeps to it and the other swings round
//! it, by the same sweep that rounds tips, or turns round where there is no room.

use super::deadlock::Blocked;
use super::laser::companion_w;
use super::planes::{Plane, Planes};
use super::pledge::{Along, Pledge, Room, Side};
use super::potential::{acceleration_w, pair_force};
use super::precedence::{End, Meeting, STANDS, goes_first, stands};
use super::recent::{LOOK_RAD, Recent, look_s};
use super::trail::{Aim, Trail};
use super::{Params, bonds, is_mate, spread_m, turned};
use crate::avoid::{Capsule, Orca, OrcaPeer};
use crate::law::View;
use crate::peers::Neighbour;
use drover_config::{Avoidance, WallFollowing};
use drover_contract::math::{atan2, cos};
use drover_contract::{Stamp, Twist, Vec2, wrap};
use std::f64::consts::{PI, TAU};

/// What a wall lets through of a wish, as a share: below this the wall is in the way.
const THROUGH: f64 = 0.35;
/// A wish smaller than this share of the leader's speed is none.
const WISH: f64 = 0.2;
/// The same behind a mate that stands: a flock at rest presses against walls a little.
const WISH_BEHIND: f64 = 1.0;
/// The way along a wall is looked along for this share of the distance to it.
const LOOK: f64 = 0.9;
/// The attraction of peers fades from the first to the second, spacings.
const FADES: f64 = 1.5;
const ENDS: f64 = 2.5;
/// Behind a leader that stands, this share of its speed is taken off every wish: a flock comes to rest and does not
/// dither.
const AT_REST: f64 = 0.4;
/// Who turns on the spot faster than this share of what it can does not stand.
const TURNS: f64 = 0.5;
/// Who has stood along a wall for so long goes round whoever is in its way, whoever has the right of way; and then
/// turns round, seconds.
const PATIENCE_S: f64 = 2.0;
const TURN_ROUND_S: f64 = 15.0;
/// Towards a velocity of this share of the leader's, and any faster one, a robot turns as fast as it can.
const TURNS_FULLY: f64 = 0.1;
/// Who stays at its place, within this share of its radius, for so long with its way clear sees too little of what
/// holds it: it looks to both sides of its way, seconds.
const STAYS: f64 = 0.5;
const STUCK_S: f64 = 3.0;
const LOOK_S: f64 = 1.0;
/// What lies farther off the heading than this is behind, radians.
const BEHIND_RAD: f64 = 2.6;
/// A way that brushes past a peer brings the two no nearer than this share of their distance.
const BRUSH: f64 = 0.9;
/// Who has stood for so long along a wall backs off from whoever is nearer to the leader, seconds.
const JAM_S: f64 = 1.0;

/// What a safe follower remembers.
#[derive(Clone, Debug, Default)]
pub(super) struct Safe {
    blocked: Blocked,
    recent: Recent,
    trail: Trail,
    wall: Option<Pledge>,
    /// Since when the robot has wished to move and stood.
    stands_since: Option<Stamp>,
    /// Where it has been since when.
    spot: Option<(Stamp, Vec2)>,
    orca: Option<Box<Orca>>,
    entries: u32,
}

impl Safe {
    pub(super) fn on_wall(&self) -> bool {
        self.wall.is_some()
    }

    pub(super) fn entries(&self) -> u32 {
        self.entries
    }

    pub(super) fn halt(&mut self) {
        self.blocked = Blocked::default();
    }

    /// One step behind `leader`.
    pub(super) fn step(&mut self, params: &Params, leader: &Neighbour, view: &View<'_>) -> Twist {
        let at_w = view.motion.pose_wb.position();
        let leader_w = leader.pose_wb.position();
        let places_w = self.recent.look(params, view);
        let walls = wall_planes(params, &places_w, at_w);
        let reach_m = spread_m(params, view);
        if params.trail {
            self.trail.hear(params, leader, (at_w, &places_w), reach_m);
        }
        let ends = End::of(params, leader, (view, reach_m), places_w.is_empty());
        if ends != End::No {
            self.trail.leave();
        }
        if ends == End::Here {
            self.wall = None;
        }
        let aim = self.trail.aim(params, at_w, &places_w);
        let attractor_w = aim.map_or(leader_w, |aim| aim.place_w);
        let mut wish_w = bonds::drawn_w(flocking_w(params, (leader, aim), (view, reach_m)), params, view);
        self.note_standing(params, wish_w, view);
        let stays_s = self.stays_s(params, view);
        // A way that is clear and leads nowhere for longer than a turn takes is not.
        let clear = aim.is_some_and(|aim| aim.clear) && stays_s < STUCK_S + PI / params.turn_radps;
        let by_walls = !clear && are_in_the_way(params, (wish_w, ends), &walls);
        if self.wall.is_some() {
            // A way that is seen whole ends it; one beyond the laser's reach may be as blocked as the one before.
            let whole = aim.is_some_and(|aim| (aim.place_w - at_w).norm() <= params.obstacle_range_m);
            let way_w = if clear && whole { None } else { self.follow(params, (attractor_w, &places_w), view) };
            match way_w {
                Some(way_w) => wish_w = way_w * along_mps(params, way_w, view),
                None => {
                    self.wall = None;
                    self.blocked.rest(view.now);
                }
            }
        } else if self.blocked.lasts(view.now, by_walls, params.deadlock) {
            if ends == End::No && self.trail.turn_back() {
                self.blocked = Blocked::default();
            } else if params.walls != WallFollowing::None
                && let Some(nearest_w) = companion_w(places_w.iter().copied(), at_w)
            {
                self.entries += 1;
                self.wall = Some(Pledge::begin(view.now, nearest_w, attractor_w, &view.motion.pose_wb));
            }
        }
        let vel_w = match params.avoidance {
            Avoidance::Voronoi => bonds::held(self.planes(params, leader, (walls, view)), params, view).nearest(wish_w),
            Avoidance::Orca => {
                let held_w = bonds::held(walls, params, view).nearest(wish_w);
                self.orca_w(params, (held_w, &places_w), view)
            }
        };
        let vel_w = if clear && stays_s > LOOK_S { looking_around(params, vel_w, view) } else { vel_w };
        let flocks = !self.on_wall() && aim.is_none();
        let turn_radps = if flocks { params.turn_radps } else { params.wall_turn_radps };
        track(params, vel_w, turn_radps, view)
    }

    /// For how long it has been where it is, whichever way it turned, seconds.
    fn stays_s(&mut self, params: &Params, view: &View<'_>) -> f64 {
        let at_w = view.motion.pose_wb.position();
        let near = |spot: &(Stamp, Vec2)| (spot.1 - at_w).norm() <= STAYS * params.radius_m;
        let (since, _) = *self.spot.insert(self.spot.filter(near).unwrap_or((view.now, at_w)));
        view.now.since(since).as_secs_f64()
    }

    /// For how long it has wished to move and stood, seconds.
    fn stands_s(&self, view: &View<'_>) -> f64 {
        self.stands_since.map_or(0.0, |since| view.now.since(since).as_secs_f64())
    }

    /// Since when it has wished to move and stood.
    fn note_standing(&mut self, params: &Params, wish_w: Vec2, view: &View<'_>) {
        let is_b = view.motion.twist_b;
        let turns = is_b.yaw_rate_radps.abs() > TURNS * params.wall_turn_radps.min(params.turn_radps);
        let stands =
            (!turns || bonds::is_at_rim(params, view)) && is_b.speed_mps.abs() < STANDS * params.wall_speed_mps;
        let wishes = wish_w.norm() > STANDS * params.leader_speed_mps;
        self.stands_since = (stands && wishes).then(|| self.stands_since.unwrap_or(view.now));
    }

    /// What optimal reciprocal collision avoidance leaves of a wish.
    fn orca_w(&mut self, params: &Params, (wish_w, places_w): (Vec2, &[Vec2]), view: &View<'_>) -> Vec2 {
        let at_w = view.motion.pose_wb.position();
        let near = view.neighbours.iter().filter(|peer| (peer.pose_wb.position() - at_w).norm() < 4.0 * params.avoid_m);
        let peers = near.map(|peer| OrcaPeer {
            pos_w: peer.pose_wb.position(),
            vel_w: peer.vel_w(),
            radius_m: peer.radius_m + params.margin_m,
        });
        let walls = companion_w(places_w.iter().copied(), at_w).map(|place_w| Capsule::disc(place_w, 0.0));
        let own_w = view.motion.pose_wb.heading() * view.motion.twist_b.speed_mps;
        let orca = self.orca.get_or_insert_with(|| Box::new(Orca::new(params.orca(view.dt_s))));
        orca.velocity((at_w, own_w), wish_w, peers, walls.into_iter())
    }

    /// The way along the wall; none when the trap is left.
    fn follow(&mut self, params: &Params, (attractor_w, places_w): (Vec2, &[Vec2]), view: &View<'_>) -> Option<Vec2> {
        let at_w = view.motion.pose_wb.position();
        let stands_s = self.stands_s(view);
        let wall = self.wall.as_mut()?;
        if !params.side_latch {
            wall.choose_side(at_w, attractor_w - at_w);
        }
        let own_m = params.keep_m + params.margin_m / 2.0;
        let keep_m = if params.wall_distance_m > 0.0 { params.wall_distance_m } else { own_m };
        let kept = |place_w: Vec2, keep_m: f64| (place_w, keep_m.min((place_w - at_w).norm()));
        let mut points_w: Vec<(Vec2, f64)> = places_w.iter().map(|place_w| kept(*place_w, keep_m)).collect();
        let walls = points_w.len();
        if params.right_of_way {
            let way_w = wall.side().along_w((wall.wall_w() - at_w).try_normalize(1e-9).unwrap_or_else(Vec2::zeros));
            if stands_s > TURN_ROUND_S {
                wall.turn_round();
                self.stands_since = Some(view.now);
            }
            let in_way = view.neighbours.iter().filter(|peer| {
                let meets = Meeting::of(params, peer, at_w, way_w);
                match meets {
                    Meeting::None => false,
                    Meeting::Oncoming => wall.side() == Side::Left || stands_s > PATIENCE_S,
                    Meeting::Standing => true,
                }
            });
            points_w.extend(in_way.map(|peer| {
                let peer_w = peer.pose_wb.position();
                let room_m = params.radius_m + peer.radius_m + params.margin_m;
                (peer_w, room_m.min(BRUSH * (peer_w - at_w).norm()))
            }));
        }
        let room = Room { at_w, points_w: &points_w, walls, look_m: LOOK * keep_m };
        match wall.step(view.now, &room, attractor_w) {
            Along::Way(way_w) => Some(way_w),
            Along::Nowhere => Some(Vec2::zeros()),
            Along::Done => None,
        }
    }

    /// What walls and peers leave open.
    fn planes(&self, params: &Params, leader: &Neighbour, (walls, view): (Planes, &View<'_>)) -> Planes {
        let mut planes = walls;
        let at_w = view.motion.pose_wb.position();
        let jammed = self.stands_s(view) > JAM_S;
        for peer in view.neighbours {
            let apart_w = peer.pose_wb.position() - at_w;
            let gap_m = apart_w.norm() - params.radius_m - peer.radius_m - params.margin_m;
            let Some(normal_w) = apart_w.try_normalize(1e-9) else { continue };
            if gap_m > params.avoid_m {
                continue;
            }
            let first = goes_first(params, leader, peer, at_w);
            let yields = params.right_of_way && (!self.on_wall() || jammed) && first && is_mate(params, peer);
            let room_m = if yields { gap_m - params.radius_m } else { gap_m };
            // Who goes away makes room: a column drives as fast as its head.
            let leaves_mps = peer.vel_w().dot(&normal_w).max(0.0);
            planes.push(Plane { normal_w, most_mps: room_m / 2.0 / params.settle_s + leaves_mps });
        }
        planes
    }
}

/// The velocity at which the forces balance; along the leader's trail, towards the aim, with the forces of others.
fn flocking_w(params: &Params, (leader, aim): (&Neighbour, Option<Aim>), (view, reach_m): (&View<'_>, f64)) -> Vec2 {
    let at_w = view.motion.pose_wb.position();
    let mut force_w = Vec2::zeros();
    for peer in view.neighbours {
        let apart_w = at_w - peer.pose_wb.position();
        if aim.is_some() && !goes_first(params, leader, peer, at_w) {
            continue;
        }
        let flocks =
            aim.is_none() && is_mate(params, peer) && peer.leader == Some(params.leader) && peer.id != params.leader;
        force_w +=
            pair_force(params.gain, params.spacing_m, apart_w) * weight(apart_w.norm() / params.spacing_m, flocks);
    }
    let drawn_w = match aim {
        Some(aim) => (aim.place_w - at_w).try_normalize(1e-9).unwrap_or_else(Vec2::zeros) * params.speed_mps,
        None => {
            force_w += acceleration_w(leader);
            force_w += pull_w(params, leader.pose_wb.position() - at_w, reach_m);
            leader.vel_w()
        }
    };
    let wish_w = drawn_w + force_w / params.damping_per_s;
    let idle_mps = if aim.is_none() && stands(params, leader) { AT_REST * params.leader_speed_mps } else { 0.0 };
    let most_mps = params.speed_mps.min(view.limits.speed_mps_max);
    wish_w.cap_magnitude((wish_w.norm() - idle_mps).clamp(0.0, most_mps))
}

/// How much of the pair force counts at a distance of so many spacings: all repulsion, and of those who flock the
/// attraction, which fades: a large flock would be pressed together by its own size.
fn weight(spacings: f64, flocks: bool) -> f64 {
    if spacings <= 1.0 {
        return 1.0;
    }
    let faded = ((spacings - FADES) / (ENDS - FADES)).clamp(0.0, 1.0);
    if flocks { 1.0 - faded } else { 0.0 }
}

/// The pull of the leader, beyond its repulsion: as (5) up to where that is strongest, sqrt(3) L, and beyond the
/// flock's own reach growing, critically damped, up to what asks for full speed.
fn pull_w(params: &Params, to_aim: Vec2, spread_m: f64) -> Vec2 {
    let apart_m = to_aim.norm();
    if apart_m <= params.spacing_m {
        return Vec2::zeros();
    }
    let strongest_m = params.spacing_m * 3.0_f64.sqrt();
    let growing_m = strongest_m.max(spread_m);
    let near_m = apart_m.min(strongest_m);
    let drawn = pair_force(params.gain, params.spacing_m, to_aim * (-near_m / apart_m));
    let k = params.damping_per_s;
    let more = (k * k / 4.0 * (apart_m - growing_m)).clamp(0.0, k * params.speed_mps);
    drawn + to_aim * (more / apart_m)
}

/// How fast to go along a wall: who turns slowly turns nearly on the spot, or it would stray from the wall.
fn along_mps(params: &Params, way_w: Vec2, view: &View<'_>) -> f64 {
    let off_rad = wrap(atan2(way_w.y, way_w.x) - view.motion.pose_wb.yaw_rad).abs();
    let stray_m = params.keep_m;
    params.wall_speed_mps.min(stray_m * params.wall_turn_radps / off_rad.max(1e-3))
}

/// A plane for each of the walls' nearest places: those that are nearer than both beside them.
pub(super) fn wall_planes(params: &Params, places_w: &[Vec2], at_w: Vec2) -> Planes {
    let mut planes = Planes::default();
    let places = places_w.iter().map(|place_w| place_w - at_w);
    let distances = places.clone().map(|apart| apart.norm());
    let before = std::iter::once(f64::INFINITY).chain(distances.clone());
    let after = distances.clone().skip(1).chain(std::iter::once(f64::INFINITY));
    for ((apart, distance_m), (before_m, after_m)) in places.zip(distances).zip(before.zip(after)) {
        if distance_m <= before_m
            && distance_m <= after_m
            && let Some(normal_w) = apart.try_normalize(1e-9)
        {
            planes.push(Plane { normal_w, most_mps: (distance_m - params.keep_m) / params.settle_s });
        }
    }
    planes
}

/// Whether walls, even if there were no peers, would let too little through of a wish.
fn are_in_the_way(params: &Params, (wish_w, ends): (Vec2, End), walls: &Planes) -> bool {
    let wish_mps = wish_w.norm();
    let share = match ends {
        End::No => WISH,
        End::Behind => WISH_BEHIND,
        End::Here => return false,
    };
    wish_mps >= share * params.leader_speed_mps && walls.nearest(wish_w).dot(&wish_w) / (wish_mps * wish_mps) < THROUGH
}

/// A velocity turned a little to one side and then to the other: beams are degrees apart.
fn looking_around(params: &Params, vel_w: Vec2, view: &View<'_>) -> Vec2 {
    let ahead = vel_w.dot(&view.motion.pose_wb.heading());
    if ahead < cos(2.0 * LOOK_RAD) * vel_w.norm() {
        return vel_w; // it is still turning there
    }
    let to_left = ((view.now.as_secs_f64() / look_s(params)) as u64).is_multiple_of(2);
    let off_rad = if to_left { LOOK_RAD } else { -LOOK_RAD };
    turned(vel_w, off_rad)
}

/// Turn towards a velocity and drive forwards as far as it lies ahead.
pub(super) fn track(params: &Params, vel_w: Vec2, turn_radps: f64, view: &View<'_>) -> Twist {
    // Next to nothing has no direction that is worth a turn.
    let meant = (vel_w.norm() / (TURNS_FULLY * params.leader_speed_mps)).min(1.0);
    let yaw_rad = view.motion.pose_wb.yaw_rad;
    let off_rad = wrap(atan2(vel_w.y, vel_w.x) - yaw_rad);
    let ahead = vel_w.dot(&view.motion.pose_wb.heading());
    let backwards = params.reverse && ahead < 0.0;
    let off_rad = if backwards { wrap(off_rad + PI) } else { off_rad };
    // What is nearly behind is turned to the way that the body turns already: the wish moves a little with the beams.
    let goes_on = off_rad.abs() > BEHIND_RAD && off_rad * view.motion.twist_b.yaw_rate_radps < 0.0;
    let off_rad = if goes_on { off_rad - off_rad.signum() * TAU } else { off_rad };
    let speed_mps = if backwards { ahead } else { ahead.max(0.0) };
    Twist::new(speed_mps, (off_rad / params.turn_s).clamp(-turn_radps, turn_radps) * meant)
}
