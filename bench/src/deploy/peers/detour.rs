//! What both peers wish: straight to the target, and a detour when that leads nowhere.
//!
//! **In**: a robot's position and target, the walls that it sees (world frame, metres). **Out**: a step of at most
//! `step_m`, which the peer then makes safe in its own way.
//!
//! **Idea**: a controller that follows the goal and yields to constraints rests where both balance: in front of a flat
//! wall, or at the end of a link whose other end is held on the far side of an obstacle. The published remedy is a
//! perturbation to one side. Here it is made as strong as it can be without a map: who has come no nearer to its
//! target for some periods makes a detour of some periods. Beside a wall it goes along the wall; elsewhere it turns its
//! wish by more than a right angle, which gives way to the others of its chain. The first detour takes the side of the
//! wall that leads nearer to the target, each further one the other side than the last. As soon as the robot is nearer
//! to the target than it ever was, the detour ends.
//!
//! **Source**: L. Wang, A. Ames, M. Egerstedt, "Safety barrier certificates for collisions-free multirobot systems",
//! IEEE Trans. Robotics 33(3), 2017 (deadlock: a turn of the nominal control, the same way for everybody).
//! **Departures**: walls are followed, sides alternate, and it lasts for a number of periods.
//!
//! **Tuned** together with both peers. With ten robots among obstacles, barriers bring everybody home in none of 10
//! runs without detours, in about half with quarter turns always to the left, in all with these. It is a remedy that
//! the peers were given, not one that their papers have: the bench shows both peers without it as well.
//!
//! **Cost**: the walls in sight. **When it brings nothing**: the next one goes to the other side, for ever.

use super::{ARRIVED_M, Scene, left_of};
use drover_contract::Vec2;
use drover_contract::math::sin_cos;

/// When a detour is made, and what it is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct DetourParams {
    /// Periods without progress after which a detour begins; 0: there is none.
    pub(crate) patience: u32,
    /// Coming nearer by this is progress, metres.
    pub(crate) progress_m: f64,
    /// Periods that a detour lasts.
    pub(crate) periods: u32,
    /// Away from walls the wish is turned by this, radians.
    pub(crate) turn_rad: f64,
    /// Walls that are nearer than this are followed, metres.
    pub(crate) follow_m: f64,
}

impl Default for DetourParams {
    fn default() -> Self {
        Self { patience: 20, progress_m: 1.0, periods: 25, turn_rad: 2.3, follow_m: 1.6 }
    }
}

impl DetourParams {
    /// Straight to the target, whatever happens.
    pub(crate) const NONE: Self = Self { patience: 0, progress_m: 0.0, periods: 0, turn_rad: 0.0, follow_m: 0.0 };
}

/// The memory of one robot.
#[derive(Clone, Copy, Debug)]
pub(super) struct Detour {
    /// The least distance to the target so far, metres; since the last detour, if that brought nothing.
    best_m: f64,
    /// Periods without progress.
    idle: u32,
    /// Periods of the detour that are left.
    left: u32,
    /// To which side it goes: 1 is left, -1 is right; before the first: none.
    side: Option<f64>,
}

impl Detour {
    pub(super) fn new() -> Self {
        Self { best_m: f64::INFINITY, idle: 0, left: 0, side: None }
    }

    /// One period: the step that `robot` at `at_w` wishes.
    pub(super) fn wish(&mut self, params: &DetourParams, scene: &Scene<'_>, (robot, at_w): (usize, Vec2)) -> Vec2 {
        let wish = scene.wish(robot, at_w);
        let away_m = (scene.targets_w[robot] - at_w).norm();
        if params.patience == 0 || away_m < ARRIVED_M || !self.lasts(params, away_m) {
            return wish;
        }
        let nearest = scene.seen(at_w).min_by(|one, other| one.distance_m(at_w).total_cmp(&other.distance_m(at_w)));
        let along = nearest.map(|wall| left_of((wall.nearest_w(at_w) - at_w).try_normalize(1e-12).unwrap_or_default()));
        if self.left == params.periods {
            let towards_target = along.map_or(1.0, |along| along.dot(&wish).signum());
            self.side = Some(self.side.map_or(towards_target, |last| -last));
        }
        let side = self.side.unwrap_or(1.0);
        match (nearest, along) {
            (Some(wall), Some(along)) if wall.distance_m(at_w) < params.follow_m => along * (side * scene.step_m),
            _ => turned(wish, side * params.turn_rad),
        }
    }

    /// Whether this period is one of a detour.
    fn lasts(&mut self, params: &DetourParams, away_m: f64) -> bool {
        if away_m < self.best_m - params.progress_m {
            *self = Self { best_m: away_m, idle: 0, left: 0, ..*self };
        } else if self.left > 0 {
            self.left -= 1;
            if self.left == 0 {
                *self = Self { best_m: away_m, idle: 0, ..*self };
            }
        } else {
            self.idle += 1;
            if self.idle >= params.patience {
                self.left = params.periods;
            }
        }
        self.left > 0
    }
}

fn turned(step: Vec2, angle_rad: f64) -> Vec2 {
    let (sin, cos) = sin_cos(angle_rad);
    Vec2::new(step.x * cos - step.y * sin, step.x * sin + step.y * cos)
}
