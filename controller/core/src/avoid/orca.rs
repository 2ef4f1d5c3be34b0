//! Optimal reciprocal collision avoidance: the velocity nearest to the wish with which nobody touches anybody for a
//! while, if every other chooses by the same rule. Nothing is agreed on; each takes half of every change.
//!
//! - **Peers.** What two robots must not move like relative to each other for `horizon_s` is a cone with a round front
//!   (the velocity obstacle), convex. Each leaves it across one line that both choose alike, and each takes half of the
//!   way: one half-plane of velocities a peer. Who overlap already part within `dt_s`.
//! - **Walls.** Towards the nearest place of a piece, which is `d` away, at most `(d - keep) / wall_horizon_s`, and 0
//!   where it is nearer than allowed already. A piece is convex and lies beyond the line through that place, so this
//!   keeps clear of all of it for `wall_horizon_s`, whatever its length; it is stricter than a velocity obstacle where
//!   a robot could pass the piece's end. Standing still always satisfies the walls. Edges are of both sides here.
//! - **The choice** is a linear program in the plane, solved line by line. If no velocity satisfies all, the walls hold
//!   and the worst breach among the peers is made as small as can be (the three-dimensional program of the paper).
//!
//! **Symmetry.** Two head-on who choose the nearest side of the front both brake, and stand nose to nose for ever;
//! more of them stop in a ring. So the relative velocity by which a side is chosen is first shifted to the right: by as
//! much as the two close in, at most by the radius of the front, at least by `SIDESTEP` of it. That is the same for
//! both, seen from each: they pass on the right, and many turn about their middle. Any line that touches the obstacle
//! is as safe, and on the flanks the half-planes are the paper's own. Both must have the same `horizon_s` and `dt_s`
//! for their lines to be the same. A crowd may still stop for good: this is no planner.
//!
//! **What is assumed**: own and other velocities are known as they are and can be changed at once, within a disc.
//! [`track`] follows such a velocity with a differential drive, for which the radii grow by the error of following.
//!
//! **Source**: J. van den Berg, S. Guy, M. Lin, D. Manocha, "Reciprocal n-body collision avoidance", Robotics Research
//! (ISRR 2009), 2011; J. Alonso-Mora, A. Breitenmoser, M. Rufli, P. Beardsley, R. Siegwart, "Optimal reciprocal
//! collision avoidance for multiple non-holonomic robots", DARS 2010. Walls and the choice of side: ours.

use super::Capsule;
use drover_contract::math::{atan2, sin_cos};
use drover_contract::{Limits, Twist, Vec2, wrap};
use std::f64::consts::{FRAC_PI_2, PI};

/// Bounds hold but for this, m/s: three lines through one point must not count as a contradiction.
const ROUNDING_MPS: f64 = 1e-9;
/// Lines whose directions differ by less are parallel, radians.
const PARALLEL_RAD: f64 = 1e-9;
/// Shift to the right of the velocity by which a side is chosen for two who do not close in, in radii of the front.
const SIDESTEP: f64 = 0.05;

/// A robot's own numbers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OrcaParams {
    /// Of the body's disc, metres.
    pub radius_m: f64,
    /// Room to keep beyond it, metres.
    pub keep_m: f64,
    /// The error of following a velocity ([`Tracking::error_m`]), metres; 0 for who moves any way at once.
    pub tracking_m: f64,
    /// Peers are not touched for so long, seconds; the same for all.
    pub horizon_s: f64,
    /// Walls are not touched for so long, seconds.
    pub wall_horizon_s: f64,
    /// From one choice to the next, seconds; no horizon is shorter.
    pub dt_s: f64,
    /// Fastest, any way, m/s.
    pub speed_mps_max: f64,
}

impl OrcaParams {
    /// Radius of the disc that others must leave free: what a peer of the same kind has for its
    /// [`OrcaPeer::radius_m`].
    #[must_use]
    pub fn disc_m(&self) -> f64 {
        self.radius_m + self.keep_m + self.tracking_m
    }
}

/// A moving disc: another robot, or the own.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OrcaPeer {
    /// Its middle, world frame, metres.
    pub pos_w: Vec2,
    /// World frame, m/s.
    pub vel_w: Vec2,
    /// With all the room it keeps, metres ([`OrcaParams::disc_m`]).
    pub radius_m: f64,
}

/// A half-plane of velocities: at most `speed_mps` along `normal_w`, a unit vector, world frame.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Bound {
    normal_w: Vec2,
    speed_mps: f64,
}

impl Bound {
    /// By how much a velocity breaks it, m/s; negative if it does not.
    fn excess_mps(&self, vel_w: Vec2) -> f64 {
        vel_w.dot(&self.normal_w) - self.speed_mps
    }
}

/// The velocities that are allowed to one robot. Its lists are kept from step to step for their memory.
#[derive(Clone, Debug)]
pub struct Orca {
    params: OrcaParams,
    /// The walls' first.
    bounds: Vec<Bound>,
    walls: usize,
    /// For the program in three dimensions.
    bisectors: Vec<Bound>,
}

impl Orca {
    /// Of a robot with nobody and nothing around it.
    #[must_use]
    pub fn new(params: OrcaParams) -> Self {
        Self { params, bounds: Vec::new(), walls: 0, bisectors: Vec::new() }
    }

    /// The allowed velocity nearest to `wish_w`, m/s, for a robot at `pos_w` that moves with `vel_w`. A lidar's return
    /// is a wall too: a disc of radius 0. Among `peers` must not be the robot itself.
    pub fn velocity(
        &mut self,
        (pos_w, vel_w): (Vec2, Vec2),
        wish_w: Vec2,
        peers: impl Iterator<Item = OrcaPeer>,
        walls: impl Iterator<Item = Capsule>,
    ) -> Vec2 {
        let (params, fastest_mps) = (self.params, self.params.speed_mps_max);
        let own = OrcaPeer { pos_w, vel_w, radius_m: params.disc_m() };
        let binds = |bound: &Bound| bound.speed_mps < fastest_mps;
        self.bounds.clear();
        self.bounds.extend(walls.filter_map(|wall| keep_from(wall, pos_w, &params)).filter(binds));
        self.walls = self.bounds.len();
        self.bounds.extend(peers.filter_map(|peer| share_with(own, peer, &params)).filter(binds));
        self.nearest_to(wish_w)
    }

    /// By how much `vel_w` breaks the worst of the last call's bounds of peers, m/s; 0 if none. More than 0 for what
    /// was chosen: it is too crowded to promise anything.
    #[must_use]
    pub fn excess_mps(&self, vel_w: Vec2) -> f64 {
        self.bounds[self.walls..].iter().map(|bound| bound.excess_mps(vel_w)).fold(0.0, f64::max)
    }

    fn nearest_to(&mut self, wish_w: Vec2) -> Vec2 {
        match solve(&self.bounds, self.params.speed_mps_max, Aim::Near(wish_w)) {
            Ok(vel_w) => vel_w,
            Err((at, vel_w)) if at >= self.walls => self.least_excess(at, vel_w),
            // Never but for rounding: standing still satisfies every wall.
            Err(_) => self.least_excess(self.walls, Vec2::zeros()),
        }
    }

    /// Least breach of the peers' bounds within those of the walls, for `vel_w` that satisfies the bounds before
    /// `first`. Each bound that is broken more than all before it becomes the worst one, and is pushed as low as the
    /// bisectors with those before it (where one becomes worse than the other) let it.
    fn least_excess(&mut self, first: usize, mut vel_w: Vec2) -> Vec2 {
        let mut worst_mps = 0.0;
        for at in first..self.bounds.len() {
            let (before, worst) = (&self.bounds[..at], self.bounds[at]);
            if worst.excess_mps(vel_w) <= worst_mps {
                continue;
            }
            let (walls, peers) = before.split_at(self.walls);
            self.bisectors.clear();
            self.bisectors.extend_from_slice(walls);
            self.bisectors.extend(peers.iter().filter_map(|peer| bisector(*peer, worst)));
            // Without a solution, again but for rounding, what was found before stays.
            vel_w = solve(&self.bisectors, self.params.speed_mps_max, Aim::Along(-worst.normal_w)).unwrap_or(vel_w);
            worst_mps = worst.excess_mps(vel_w);
        }
        vel_w
    }
}

/// The bound of a wall.
fn keep_from(wall: Capsule, pos_w: Vec2, params: &OrcaParams) -> Option<Bound> {
    let room_m = wall.distance_m(pos_w) - params.disc_m();
    let speed_mps = room_m.max(0.0) / params.wall_horizon_s.max(params.dt_s);
    // On the segment itself no way leads away from it more than another.
    let normal_w = (wall.nearest_w(pos_w) - pos_w).try_normalize(1e-12)?;
    Some(Bound { normal_w, speed_mps })
}

/// The own half of what two robots must change. None for two at the very same place and velocity: no way parts them
/// more than another.
fn share_with(own: OrcaPeer, peer: OrcaPeer, params: &OrcaParams) -> Option<Bound> {
    let (to_peer, relative) = (peer.pos_w - own.pos_w, own.vel_w - peer.vel_w);
    let gap_m = own.radius_m + peer.radius_m;
    let apart = to_peer.norm_squared() > gap_m * gap_m;
    let horizon_s = if apart { params.horizon_s.max(params.dt_s) } else { params.dt_s };
    let (out, reach_mps) = way_out(to_peer, relative, gap_m, (apart, horizon_s))?;
    // `out` leads out of the obstacle, no part of which reaches farther along it than `reach_mps`.
    let change_mps = reach_mps - relative.dot(&out);
    Some(Bound { normal_w: -out, speed_mps: -(own.vel_w.dot(&out) + change_mps / 2.0) })
}

/// The line through which to leave the obstacle: a unit vector out of it, and how far it reaches along that, m/s.
fn way_out(to_peer: Vec2, relative: Vec2, gap_m: f64, (apart, horizon_s): (bool, f64)) -> Option<(Vec2, f64)> {
    let (middle, front_mps) = (to_peer / horizon_s, gap_m / horizon_s);
    let right = to_peer.try_normalize(1e-12).map_or_else(Vec2::zeros, |ahead| Vec2::new(ahead.y, -ahead.x));
    let closing_mps = right.perp(&relative).max(0.0);
    let from_middle = relative + right * (closing_mps + SIDESTEP * front_mps).min(front_mps) - middle;
    let back = -from_middle.dot(&to_peer);
    if apart && (back < 0.0 || back * back <= gap_m * gap_m * from_middle.norm_squared()) {
        // A flank: it passes through the origin and touches the peer's disc.
        let tangent_m = (to_peer.norm_squared() - gap_m * gap_m).sqrt();
        let side = if to_peer.perp(&from_middle) > 0.0 { 1.0 } else { -1.0 };
        let left = Vec2::new(-to_peer.y, to_peer.x);
        let out = (left * (side * tangent_m) - to_peer * gap_m) / to_peer.norm_squared();
        return Some((out, 0.0));
    }
    let out = from_middle.try_normalize(1e-12)?;
    Some((out, middle.dot(&out) + front_mps))
}

/// Where `peer` is not broken more than `worst`; none if they are parallel, which says nothing about where to go.
fn bisector(peer: Bound, worst: Bound) -> Option<Bound> {
    let across = peer.normal_w - worst.normal_w;
    let length = across.norm();
    let speed_mps = peer.speed_mps - worst.speed_mps;
    (length > PARALLEL_RAD).then(|| Bound { normal_w: across / length, speed_mps: speed_mps / length })
}

/// What a program looks for: the velocity nearest to one, or the one farthest along a unit vector.
#[derive(Clone, Copy)]
enum Aim {
    Near(Vec2),
    Along(Vec2),
}

/// The best velocity within all bounds and the disc of the fastest. If there is none: the first bound that contradicts
/// those before it, and the best velocity within those.
fn solve(bounds: &[Bound], fastest_mps: f64, aim: Aim) -> Result<Vec2, (usize, Vec2)> {
    let mut vel_w = match aim {
        Aim::Near(wish_w) if wish_w.norm() <= fastest_mps => wish_w,
        Aim::Near(wish_w) => wish_w * (fastest_mps / wish_w.norm()),
        Aim::Along(way) => way * fastest_mps,
    };
    for (at, bound) in bounds.iter().enumerate() {
        // The best of one bound more either is the same, or lies on that bound.
        if bound.excess_mps(vel_w) > ROUNDING_MPS {
            vel_w = solve_on(*bound, &bounds[..at], fastest_mps, aim).ok_or((at, vel_w))?;
        }
    }
    Ok(vel_w)
}

/// The best velocity on a bound's line, within the others and the disc.
fn solve_on(line: Bound, others: &[Bound], fastest_mps: f64, aim: Aim) -> Option<Vec2> {
    let (foot_w, along) = (line.normal_w * line.speed_mps, Vec2::new(-line.normal_w.y, line.normal_w.x));
    let half2 = fastest_mps * fastest_mps - line.speed_mps * line.speed_mps;
    if half2 < 0.0 {
        return None;
    }
    let (mut low, mut high) = (-half2.sqrt(), half2.sqrt());
    for other in others {
        let (slope, room_mps) = (other.normal_w.dot(&along), -other.excess_mps(foot_w));
        if slope > PARALLEL_RAD {
            high = high.min(room_mps / slope);
        } else if slope < -PARALLEL_RAD {
            low = low.max(room_mps / slope);
        } else if room_mps < -ROUNDING_MPS {
            return None;
        }
    }
    if low > high + ROUNDING_MPS {
        return None;
    }
    let best = match aim {
        Aim::Near(wish_w) => along.dot(&wish_w).max(low).min(high),
        Aim::Along(way) => {
            if along.dot(&way) > 0.0 {
                high
            } else {
                low
            }
        }
    };
    Some(foot_w + along * best)
}

/// How a differential drive follows a velocity.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tracking {
    /// The body's.
    pub limits: Limits,
    /// Farthest it may come away from where the velocity would have led it, metres, > 0.
    pub error_m: f64,
    /// In this time it turns all of the way if it can, seconds, > 0. A few steps at most: who turns more slowly is not
    /// to the side in time, and more often a ring of drives that meet stops for good.
    pub turn_s: f64,
    /// Whether it may drive backwards to what is behind it.
    pub reverse: bool,
}

/// The twist by which a body with heading `yaw_rad` follows `vel_w`: it turns at a constant rate, to arrive after
/// `turn_s` if the body can, and drives with the constant speed that then ends nearest to where `vel_w` would have led.
///
/// What is beside its arc by more than `error_m` would be too far off: then a slower velocity of the same direction is
/// followed, down to a turn on the spot. The paper instead keeps such velocities out of the program, as a polygon; here
/// the slower one may break a half-plane, for as long as the turn takes, and the next choice sees it. A change of speed
/// takes no time here.
#[must_use]
pub fn track(vel_w: Vec2, yaw_rad: f64, tracking: &Tracking) -> Twist {
    let Tracking { limits, error_m, turn_s, reverse } = tracking;
    if vel_w.norm() <= ROUNDING_MPS {
        return Twist::ZERO;
    }
    let ahead_rad = wrap(atan2(vel_w.y, vel_w.x) - yaw_rad);
    let backwards = *reverse && limits.reverse_mps_max > 0.0 && ahead_rad.abs() > FRAC_PI_2;
    let (turn_rad, sign, fastest_mps) = if backwards {
        (wrap(ahead_rad + PI), -1.0, limits.reverse_mps_max)
    } else {
        (ahead_rad, 1.0, limits.speed_mps_max)
    };
    let yaw_rate_radps = (turn_rad / turn_s).clamp(-limits.yaw_rate_radps_max, limits.yaw_rate_radps_max);
    // The chord of the arc leads half of the turn to the side; what the way of the velocity has across it is the error.
    let half_rad = yaw_rate_radps.abs() * turn_s / 2.0;
    let (across, along) = sin_cos(turn_rad.abs() - half_rad);
    let beside_s = turn_s * if along > 0.0 { across } else { 1.0 };
    let followed_mps = vel_w.norm().min(fastest_mps).min(error_m / beside_s.max(f64::MIN_POSITIVE));
    let chord = if half_rad > 1e-9 { sin_cos(half_rad).0 / half_rad } else { 1.0 };
    Twist::new(sign * (followed_mps * along / chord).max(0.0), yaw_rate_radps)
}

#[cfg(test)]
#[path = "orca_tests.rs"]
mod tests;
