//! What the laser shows of walls: the virtual accompanying robot and the direction of the wall (section 3.1).

use super::Params;
use crate::law::View;
use drover_contract::Vec2;
use drover_contract::math::{atan2, cos, sin};

/// The returns that count: within S and within the laser's view, world frame, in the order of beams.
pub(super) fn returns_w<'v>(params: &'v Params, view: &'v View<'_>) -> impl Iterator<Item = Vec2> + Clone + 'v {
    let within_m2 = params.obstacle_range_m * params.obstacle_range_m;
    let half_rad = params.laser_rad / 2.0 + 1e-6;
    let counts = move |point_b: &&Vec2| {
        point_b.norm_squared() <= within_m2
            && (half_rad >= std::f64::consts::PI || atan2(point_b.y, point_b.x).abs() <= half_rad)
    };
    view.walls_b.iter().filter(counts).map(|point_b| view.motion.pose_wb.transform(*point_b))
}

/// The virtual accompanying robot: the nearest return.
pub(super) fn companion_w(returns_w: impl Iterator<Item = Vec2>, at_w: Vec2) -> Option<Vec2> {
    returns_w.min_by(|a, b| (a - at_w).norm_squared().total_cmp(&(b - at_w).norm_squared()))
}

/// (7) and (8): the mean direction of the wall, a unit vector one way or the other; none from fewer than two returns.
///
/// A direction of a line is the same turned by half a turn, and a plain mean of arcs is wrong near +-90 degrees: the
/// doubled angles are averaged.
pub(super) fn wall_direction_w(returns_w: impl Iterator<Item = Vec2>) -> Option<Vec2> {
    let mut before: Option<Vec2> = None;
    let mut doubled = Vec2::zeros();
    for return_w in returns_w {
        if let Some(along) = before.and_then(|before| (return_w - before).try_normalize(1e-12)) {
            doubled += Vec2::new(along.x * along.x - along.y * along.y, 2.0 * along.x * along.y);
        }
        before = Some(return_w);
    }
    let twice = doubled.try_normalize(1e-9)?;
    let half_rad = atan2(twice.y, twice.x) / 2.0;
    Some(Vec2::new(cos(half_rad), sin(half_rad)))
}
