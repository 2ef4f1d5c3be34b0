//! Following a wall out of a trap: a hand on the wall, and a count of the turns.
//!
//! **Side**: the one whose tangent leads more towards the attractor; latched. **Way**: directions are swept from the
//! wall's away until one is free, which rounds tips, turns in corners and passes gaps alike; what was in the way last
//! is the wall's new nearest place, the virtual accompanying robot. A wall that is lost is remembered for a while.
//! **Exit**: c, the unwrapped angle from the attractor's bearing to the way, begins on the wall's side; when it is
//! undone the robot heads for the attractor without having turned once more round the obstacle than out of it (the
//! Pledge algorithm: H. Abelson, A. diSessa, "Turtle Geometry", 1981). The attractor may move: c counts its turning
//! too.

use drover_contract::math::{atan2, cos, sin};
use drover_contract::{Pose, Stamp, Vec2, wrap};
use std::f64::consts::PI;
use std::time::Duration;

/// Directions are tried in steps of this, radians: 5 degrees.
const SWEEP_RAD: f64 = PI / 36.0;
/// The sweep begins this far beyond the wall's bearing: a tip that falls back is followed round.
const BEHIND_RAD: f64 = PI / 6.0;
/// The turns are undone when no more than this is left of them, radians.
const UNDONE_RAD: f64 = 0.1;
/// Of two sides that lead as much towards the attractor, the one that the robot looks to takes the least turning: what
/// its heading counts beside the attractor's direction.
const HEADING: f64 = 0.3;
/// A wall lost for this long is given up.
const LOST: Duration = Duration::from_secs(4);

/// Which hand is on the wall.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Side {
    /// The wall is on the left.
    Left,
    /// The wall is on the right.
    Right,
}

impl Side {
    /// Along the wall that lies in direction `wall_w`.
    pub(super) fn along_w(self, wall_w: Vec2) -> Vec2 {
        match self {
            Self::Left => Vec2::new(wall_w.y, -wall_w.x),
            Self::Right => Vec2::new(-wall_w.y, wall_w.x),
        }
    }

    /// The side whose way along the wall in direction `wall_w` leads more towards `wish_w`.
    pub(super) fn towards(wall_w: Vec2, wish_w: Vec2) -> Self {
        if Self::Right.along_w(wall_w).dot(&wish_w) >= 0.0 { Self::Right } else { Self::Left }
    }

    /// +1: counter-clockwise is away from the wall.
    fn away(self) -> f64 {
        match self {
            Self::Left => -1.0,
            Self::Right => 1.0,
        }
    }
}

/// What stands around, and how much room is wanted.
#[derive(Clone, Copy, Debug)]
pub(super) struct Room<'a> {
    pub(super) at_w: Vec2,
    /// Places to keep away from, each with its distance, metres: walls first, `walls` of them, and then peers.
    pub(super) points_w: &'a [(Vec2, f64)],
    pub(super) walls: usize,
    /// How far a way is looked along, metres.
    pub(super) look_m: f64,
}

/// A robot that follows a wall.
#[derive(Clone, Copy, Debug)]
pub(super) struct Pledge {
    side: Side,
    wall_w: Vec2,
    seen: Stamp,
    /// Bearings of that place and of the attractor, radians; they are not wrapped: whole turns count.
    wall_rad: f64,
    wish_rad: f64,
}

/// What a step of it says.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Along {
    /// Go this way, a unit vector.
    Way(Vec2),
    /// There is no way: all around is too near.
    Nowhere,
    /// The trap is left.
    Done,
}

impl Pledge {
    /// Begin at the wall's place `wall_w` to get to `attractor_w`.
    pub(super) fn begin(now: Stamp, wall_w: Vec2, attractor_w: Vec2, pose_wb: &Pose) -> Self {
        let (to_wall, wish_w) = (wall_w - pose_wb.position(), attractor_w - pose_wb.position());
        let leans_w = wish_w.try_normalize(1e-9).unwrap_or_else(Vec2::zeros) + pose_wb.heading() * HEADING;
        let wish_rad = atan2(wish_w.y, wish_w.x);
        let wall_rad = unwrapped(to_wall, wish_rad);
        Self { side: Side::towards(to_wall, leans_w), wall_w, seen: now, wall_rad, wish_rad }
    }

    pub(super) fn side(&self) -> Side {
        self.side
    }

    pub(super) fn wall_w(&self) -> Vec2 {
        self.wall_w
    }

    /// Without the latch: choose the side anew.
    pub(super) fn choose_side(&mut self, at_w: Vec2, wish_w: Vec2) {
        let side = Side::towards(self.wall_w - at_w, wish_w);
        if side != self.side {
            self.side = side;
            self.begin_anew();
        }
    }

    /// Turn round: the other hand on the wall, with the turns begun anew.
    pub(super) fn turn_round(&mut self) {
        self.side = match self.side {
            Side::Left => Side::Right,
            Side::Right => Side::Left,
        };
        self.begin_anew();
    }

    fn begin_anew(&mut self) {
        self.wall_rad = self.wish_rad + wrap(self.wall_rad - self.wish_rad);
    }

    /// One step. `attractor_w` is where it wants to be in the end.
    pub(super) fn step(&mut self, now: Stamp, room: &Room<'_>, attractor_w: Vec2) -> Along {
        let alone = Room { points_w: &room.points_w[..room.walls], ..*room };
        let wish = attractor_w - room.at_w;
        self.wish_rad = unwrapped(wish, self.wish_rad);
        self.wall_rad = unwrapped(self.wall_w - room.at_w, self.wall_rad);
        let Swept::Free(way_rad, touched) = self.sweep(room) else { return Along::Nowhere };
        if let Some((touched_w, touched_rad)) = touched {
            self.wall_w = touched_w;
            self.wall_rad = unwrapped(touched_w - room.at_w, touched_rad);
            self.seen = now;
        } else if now.since(self.seen) > LOST {
            return Along::Done;
        }
        if self.side.away() * (way_rad - self.wish_rad) <= UNDONE_RAD && is_free(&alone, wish) {
            return Along::Done;
        }
        Along::Way(Vec2::new(cos(way_rad), sin(way_rad)))
    }

    /// The first free direction from the wall's away, and the last place of a wall that was in the way before it, with
    /// the direction in which it was.
    fn sweep(&self, room: &Room<'_>) -> Swept {
        let start_rad = self.wall_rad - self.side.away() * BEHIND_RAD;
        let steps = (2.0 * PI / SWEEP_RAD) as i32;
        let alone = Room { points_w: &room.points_w[..room.walls], ..*room };
        let mut touched = None;
        for step in 0..steps {
            let way_rad = start_rad + self.side.away() * SWEEP_RAD * f64::from(step);
            let way = Vec2::new(cos(way_rad), sin(way_rad));
            if let Some(point_w) = in_the_way(&alone, way) {
                touched = Some((point_w, way_rad));
            } else if in_the_way(room, way).is_none() && !self.is_across(room, way) {
                // The remembered wall alone holds the hand when nothing is seen any more; a peer never does.
                return Swept::Free(way_rad, touched);
            }
        }
        Swept::Blocked
    }

    /// Whether a way leads into the remembered wall's place.
    fn is_across(&self, room: &Room<'_>, way: Vec2) -> bool {
        let keep_m = room.points_w.first().map_or(room.look_m, |(_, keep_m)| *keep_m);
        crosses(room.at_w, way * room.look_m, (self.wall_w, keep_m))
    }
}

enum Swept {
    Free(f64, Option<(Vec2, f64)>),
    Blocked,
}

/// The direction of a vector as it is nearest to `near_rad`, radians.
fn unwrapped(vector: Vec2, near_rad: f64) -> f64 {
    near_rad + wrap(atan2(vector.y, vector.x) - near_rad)
}

/// Whether the way towards the attractor is free as far as anything is seen: a robot that strayed from the wall heads
/// back to it, which is no turn undone.
fn is_free(room: &Room<'_>, wish: Vec2) -> bool {
    let Some(way) = wish.try_normalize(1e-9) else { return true };
    let seen_m = room.points_w.iter().map(|(point_w, _)| (point_w - room.at_w).norm()).fold(room.look_m, f64::max);
    in_the_way(&Room { look_m: seen_m.min(wish.norm()), ..*room }, way).is_none()
}

/// The place nearest to the way's begin that it comes too near to.
fn in_the_way(room: &Room<'_>, way: Vec2) -> Option<Vec2> {
    let step = way * room.look_m;
    let crossed = room.points_w.iter().filter(|point| crosses(room.at_w, step, **point));
    let nearest = crossed.min_by(|a, b| (a.0 - room.at_w).norm_squared().total_cmp(&(b.0 - room.at_w).norm_squared()));
    nearest.map(|(point_w, _)| *point_w)
}

/// Whether going `step` from `at_w` comes nearer to a place than it may; who is too near may go away from it.
fn crosses(at_w: Vec2, step: Vec2, (point_w, keep_m): (Vec2, f64)) -> bool {
    let to_point = point_w - at_w;
    let ahead = to_point.dot(&step);
    if ahead <= 0.0 {
        return false;
    }
    let share = (ahead / step.norm_squared()).min(1.0);
    let least_m = (to_point - step * share).norm();
    least_m < keep_m
}
