//! The quadratic program of one robot: the step nearest to a wish, within half-planes and a disc.
//!
//! minimise `|s - wish|^2` subject to `normal_k . s <= bound_k` for all k and `|s| <= radius` (all metres, one frame).
//!
//! **Idea**: take the half-planes one after another. While the best step so far satisfies the next one it stays the
//! best; if it does not, the new best lies on that half-plane's border, where the problem has one dimension: an
//! interval, cut by the disc and by the half-planes before, and the point of it that is nearest to the wish.
//!
//! **Source**: R. Seidel, "Small-dimensional linear programming and convex hulls made easy", Discrete & Computational
//! Geometry 6, 1991; with a disc: J. van den Berg, S. Guy, M. Lin, D. Manocha, "Reciprocal n-body collision avoidance",
//! 2011, section 5.2. Theirs maximises along a direction, ours takes the nearest point: exact all the same.
//!
//! **Cost**: n^2 in the worst case, with n up to about twenty. **Without a solution**: `None`.

use drover_contract::Vec2;

/// Half-planes whose borders are as parallel as this are treated as parallel.
const PARALLEL: f64 = 1e-12;
/// Rounding, metres.
const ROUNDING_M: f64 = 1e-12;

/// Steps `s` with `normal . s <= bound_m`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct HalfPlane {
    /// A unit vector.
    pub(super) normal: Vec2,
    /// Metres; negative if staying is not enough.
    pub(super) bound_m: f64,
}

/// The step nearest to `wish` that satisfies all, or none if there is none.
pub(super) fn nearest(wish: Vec2, planes: &[HalfPlane], radius_m: f64) -> Option<Vec2> {
    let mut best = super::shortened(wish, radius_m);
    for (count, plane) in planes.iter().enumerate() {
        if plane.normal.dot(&best) > plane.bound_m + ROUNDING_M {
            best = nearest_on(plane, wish, (&planes[..count], radius_m))?;
        }
    }
    Some(best)
}

/// The point of `plane`'s border that is nearest to `wish`, within the half-planes `before` and the disc.
fn nearest_on(plane: &HalfPlane, wish: Vec2, (before, radius_m): (&[HalfPlane], f64)) -> Option<Vec2> {
    let (foot, along) = (plane.normal * plane.bound_m, super::left_of(plane.normal));
    let half2 = radius_m * radius_m - plane.bound_m * plane.bound_m;
    if half2 < 0.0 {
        return None;
    }
    let (mut low, mut high) = (-half2.sqrt(), half2.sqrt());
    for other in before {
        let (slope, room) = (other.normal.dot(&along), other.bound_m - other.normal.dot(&foot));
        if slope.abs() < PARALLEL {
            if room < -ROUNDING_M {
                return None;
            }
        } else if slope > 0.0 {
            high = high.min(room / slope);
        } else {
            low = low.max(room / slope);
        }
    }
    (low <= high).then(|| foot + along * wish.dot(&along).clamp(low, high))
}

#[cfg(test)]
mod tests {
    use super::*;
    use drover_contract::math::sin_cos;
    use rand::{Rng, SeedableRng};
    use rand_pcg::Pcg64Mcg;
    use std::f64::consts::TAU;

    fn polar(length: f64, angle_rad: f64) -> Vec2 {
        let (sin, cos) = sin_cos(angle_rad);
        Vec2::new(length * cos, length * sin)
    }

    /// The best point of a fine grid in polar coordinates: its distance from the wish, if any point is allowed.
    fn brute(wish: Vec2, planes: &[HalfPlane]) -> Option<f64> {
        let polars = (0..=100).flat_map(|ring| (0..720).map(move |ray| (ring, ray)));
        let points = polars.map(|(ring, ray)| polar(f64::from(ring) * 0.005, f64::from(ray) / 720.0 * TAU));
        let allowed = points.filter(|step| planes.iter().all(|plane| plane.normal.dot(step) <= plane.bound_m));
        allowed.map(|step| (step - wish).norm()).min_by(f64::total_cmp)
    }

    #[test]
    fn the_step_found_is_as_near_as_the_best_of_all_steps() {
        let mut rng = Pcg64Mcg::seed_from_u64(7);
        let (mut solved, mut unsolved) = (0, 0);
        for _ in 0..400 {
            let wish = polar(rng.random_range(0.0..0.8), rng.random_range(0.0..TAU));
            let plane = |rng: &mut Pcg64Mcg| HalfPlane {
                normal: polar(1.0, rng.random_range(0.0..TAU)),
                bound_m: rng.random_range(-0.15..0.5),
            };
            let planes: Vec<HalfPlane> = (0..rng.random_range(0..9)).map(|_| plane(&mut rng)).collect();
            match (nearest(wish, &planes, 0.5), brute(wish, &planes)) {
                (Some(step), Some(best_m)) => {
                    solved += 1;
                    assert!(step.norm() < 0.5 + 1e-9);
                    assert!(planes.iter().all(|plane| plane.normal.dot(&step) < plane.bound_m + 1e-9));
                    let ours_m = (step - wish).norm();
                    assert!(ours_m < best_m + 1e-9, "{ours_m} is worse than {best_m} of the grid");
                }
                (Some(step), None) => {
                    let slack = planes.iter().map(|plane| plane.bound_m - plane.normal.dot(&step));
                    let slack_m = slack.fold(f64::INFINITY, f64::min);
                    assert!((-1e-9..0.01).contains(&slack_m), "the grid missed a set that is not thin");
                }
                (None, found) => {
                    unsolved += 1;
                    assert!(found.is_none(), "a solution was missed");
                }
            }
        }
        assert!(solved > 200 && unsolved > 10, "{solved} solved, {unsolved} without a solution");
    }
}
