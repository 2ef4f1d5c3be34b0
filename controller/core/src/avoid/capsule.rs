//! Pieces of walls: a segment with a radius. A point, a disc and an edge are all of this kind.

use drover_contract::Vec2;

/// All places within `radius_m` of the segment from `a_w` to `b_w`; world frame, metres. An edge of a solid has its
/// free side on the left; a thin wall is two edges, one each way.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Capsule {
    /// One end of the segment.
    pub a_w: Vec2,
    /// The other; the same place for a disc.
    pub b_w: Vec2,
    /// 0 for an edge or a point.
    pub radius_m: f64,
}

impl Capsule {
    /// An edge of a wall.
    #[must_use]
    pub fn edge(a_w: Vec2, b_w: Vec2) -> Self {
        Self { a_w, b_w, radius_m: 0.0 }
    }

    /// A round obstacle, or a single return of a lidar with radius 0.
    #[must_use]
    pub fn disc(centre_w: Vec2, radius_m: f64) -> Self {
        Self { a_w: centre_w, b_w: centre_w, radius_m }
    }

    /// Whether `at_w` is on its free side: not within the disc, nor behind the edge of a solid.
    #[must_use]
    pub fn faces(&self, at_w: Vec2) -> bool {
        if self.radius_m > 0.0 || self.a_w == self.b_w {
            return self.distance_m(at_w) > 0.0;
        }
        (self.b_w - self.a_w).perp(&(at_w - self.a_w)) >= 0.0
    }

    /// Distance from `at_w` to it, metres; negative inside of a disc.
    #[must_use]
    pub fn distance_m(&self, at_w: Vec2) -> f64 {
        (self.nearest_w(at_w) - at_w).norm() - self.radius_m
    }

    /// The place on its segment that is nearest to `at_w`.
    #[must_use]
    pub fn nearest_w(&self, at_w: Vec2) -> Vec2 {
        nearest(self.a_w, self.b_w, at_w)
    }

    /// The place on its border that is nearest to `at_w`, for `at_w` outside of it.
    #[must_use]
    pub fn border_w(&self, at_w: Vec2) -> Vec2 {
        let nearest_w = self.nearest_w(at_w);
        let out = (at_w - nearest_w).try_normalize(1e-12).unwrap_or_else(Vec2::zeros);
        nearest_w + out * self.radius_m
    }

    /// Smallest distance between it and the way from `from_w` to `to_w`, metres: exact, 0 or less if they cross.
    #[must_use]
    pub fn clearance_m(&self, from_w: Vec2, to_w: Vec2) -> f64 {
        segments_m(self.a_w, self.b_w, from_w, to_w) - self.radius_m
    }

    /// No part of it is nearer to `at_w` than this, metres: a cheap bound.
    #[must_use]
    pub fn at_least_m(&self, at_w: Vec2) -> f64 {
        let half = (self.b_w - self.a_w) / 2.0;
        (self.a_w + half - at_w).norm() - half.norm() - self.radius_m
    }
}

/// The place on the segment `a` to `b` that is nearest to `p`.
fn nearest(a: Vec2, b: Vec2, p: Vec2) -> Vec2 {
    let along = b - a;
    let length2 = along.norm_squared();
    if length2 <= 0.0 { a } else { a + along * ((p - a).dot(&along) / length2).clamp(0.0, 1.0) }
}

/// Smallest distance between two segments: 0 if they cross, else between an end of one and the other.
fn segments_m(a: Vec2, b: Vec2, c: Vec2, d: Vec2) -> f64 {
    if cross(a, b, c, d) {
        return 0.0;
    }
    let ends = [(nearest(a, b, c) - c), (nearest(a, b, d) - d), (nearest(c, d, a) - a), (nearest(c, d, b) - b)];
    ends.iter().map(Vec2::norm_squared).fold(f64::INFINITY, f64::min).sqrt()
}

/// Whether two segments cross properly; touching ends have distance 0 by their ends.
fn cross(a: Vec2, b: Vec2, c: Vec2, d: Vec2) -> bool {
    let side = |from: Vec2, to: Vec2, at: Vec2| (to - from).perp(&(at - from));
    side(a, b, c) * side(a, b, d) < 0.0 && side(c, d, a) * side(c, d, b) < 0.0
}

#[cfg(test)]
mod tests {
    use super::*;

    fn v(x: f64, y: f64) -> Vec2 {
        Vec2::new(x, y)
    }

    #[test]
    fn distances_to_the_way_are_those_of_school_geometry() {
        let wall = Capsule::edge(v(0.0, 0.0), v(10.0, 0.0));
        assert!((wall.clearance_m(v(2.0, 3.0), v(8.0, 1.0)) - 1.0).abs() < 1e-12, "the nearer end");
        assert!(wall.clearance_m(v(5.0, -1.0), v(5.0, 1.0)).abs() < 1e-12, "across");
        assert!((wall.clearance_m(v(13.0, 4.0), v(20.0, 4.0)) - 5.0).abs() < 1e-12, "end to end");
        let tree = Capsule::disc(v(0.0, 0.0), 1.0);
        assert!((tree.clearance_m(v(-5.0, 3.0), v(5.0, 3.0)) - 2.0).abs() < 1e-12, "in the middle of the way");
        assert!((tree.distance_m(v(0.5, 0.0)) + 0.5).abs() < 1e-12, "inside");
        assert!((tree.border_w(v(3.0, 0.0)) - v(1.0, 0.0)).norm() < 1e-12);
    }

    #[test]
    fn the_cheap_bound_is_never_above_the_distance() {
        let walls = [Capsule::edge(v(-3.0, 1.0), v(4.0, 2.0)), Capsule::disc(v(1.0, 1.0), 2.0)];
        for wall in walls {
            for step in 0..400 {
                let at = v(f64::from(step % 20) - 10.0, f64::from(step / 20) - 10.0);
                assert!(wall.at_least_m(at) <= wall.distance_m(at) + 1e-12, "{wall:?} {at:?}");
            }
        }
    }
}
