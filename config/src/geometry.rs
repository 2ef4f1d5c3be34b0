//! Plane geometry that the checks need: discs against polygons and circles. Metres, world frame.

use crate::boxes::{Boxes, bounds};

/// A point, metres.
pub(crate) type Point = [f64; 2];

/// Twice the signed area of the triangle `a`, `b`, `c`: positive counter-clockwise, 0 on one line.
fn cross(a: Point, b: Point, c: Point) -> f64 {
    (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
}

/// Distance between two points.
pub(crate) fn distance(a: Point, b: Point) -> f64 {
    libm::hypot(a[0] - b[0], a[1] - b[1])
}

/// Distance from `p` to the segment `a`-`b`.
pub(crate) fn segment_distance(p: Point, (a, b): (Point, Point)) -> f64 {
    let along = [b[0] - a[0], b[1] - a[1]];
    let length2 = along[0] * along[0] + along[1] * along[1];
    if length2 <= 0.0 {
        return distance(p, a);
    }
    let share = (((p[0] - a[0]) * along[0] + (p[1] - a[1]) * along[1]) / length2).clamp(0.0, 1.0);
    distance(p, [a[0] + share * along[0], a[1] + share * along[1]])
}

/// The edges of a polygon, the last back to the first corner.
pub(crate) fn edges(points: &[Point]) -> impl Iterator<Item = (Point, Point)> + '_ {
    points.iter().copied().zip(points.iter().copied().cycle().skip(1))
}

/// Whether `p` is inside (even-odd rule); on the outline either answer may come.
pub(crate) fn contains(points: &[Point], p: Point) -> bool {
    edges(points).filter(|edge| crosses_ray(*edge, p)).count() % 2 == 1
}

/// Whether an edge crosses the ray from `p` to the east; its lower end counts, its upper one does not.
pub(crate) fn crosses_ray((a, b): (Point, Point), p: Point) -> bool {
    (a[1] > p[1]) != (b[1] > p[1]) && p[0] < (b[0] - a[0]) * (p[1] - a[1]) / (b[1] - a[1]) + a[0]
}

/// The area, never negative.
pub(crate) fn area(points: &[Point]) -> f64 {
    signed_area(points).abs()
}

/// The area: positive if the corners go counter-clockwise.
pub(crate) fn signed_area(points: &[Point]) -> f64 {
    let origin = points.first().copied().unwrap_or_default();
    edges(points).map(|(a, b)| cross(origin, a, b)).sum::<f64>() / 2.0
}

/// The first corner at which a counter-clockwise outline does not turn left, if any.
pub(crate) fn reflex_corner(points: &[Point]) -> Option<usize> {
    let count = points.len();
    let turn =
        |corner: usize| cross(points[(corner + count - 1) % count], points[corner], points[(corner + 1) % count]);
    (0..count).find(|corner| turn(*corner) <= 0.0)
}

/// Two edges (by their first corners) that touch where they should not, if any do.
pub(crate) fn self_intersection(points: &[Point]) -> Option<(usize, usize)> {
    let all: Vec<_> = edges(points).collect();
    let count = all.len();
    let touch = |i: usize, j: usize| {
        let (first, second) = (all[i], all[j]);
        match (j == i + 1, i == 0 && j == count - 1) {
            (true, _) => folds_back(first.0, first.1, second.1),
            (_, true) => folds_back(second.0, second.1, first.1),
            (false, false) => segments_touch(first, second),
        }
    };
    let area_of = |(a, b): (Point, Point)| bounds([a, b]).unwrap_or([a, b]);
    let boxes = Boxes::new(all.iter().enumerate().map(|(index, edge)| (area_of(*edge), index)).collect());
    (0..count).find_map(|i| {
        let mut first: Option<usize> = None;
        boxes.overlapping(area_of(all[i]), &mut |j| {
            if *j > i && first.is_none_or(|first| *j < first) && touch(i, *j) {
                first = Some(*j);
            }
        });
        first.map(|j| (i, j))
    })
}

/// Whether going `a` -> `b` -> `c` turns straight back (or stands still).
fn folds_back(a: Point, b: Point, c: Point) -> bool {
    let ahead = (b[0] - a[0]) * (c[0] - b[0]) + (b[1] - a[1]) * (c[1] - b[1]);
    cross(a, b, c) == 0.0 && ahead <= 0.0
}

fn segments_touch((a, b): (Point, Point), (c, d): (Point, Point)) -> bool {
    let (side_c, side_d) = (cross(a, b, c), cross(a, b, d));
    let (side_a, side_b) = (cross(c, d, a), cross(c, d, b));
    let straddles = side_c * side_d < 0.0 && side_a * side_b < 0.0;
    let on = |side: f64, p: Point, (from, to): (Point, Point)| {
        let within = |axis: usize| p[axis] >= from[axis].min(to[axis]) && p[axis] <= from[axis].max(to[axis]);
        side == 0.0 && within(0) && within(1)
    };
    straddles || on(side_c, c, (a, b)) || on(side_d, d, (a, b)) || on(side_a, a, (c, d)) || on(side_b, b, (c, d))
}

#[cfg(test)]
mod tests {
    use super::{area, contains, edges, reflex_corner, segment_distance, self_intersection};

    const SQUARE: [[f64; 2]; 4] = [[0.0, 0.0], [2.0, 0.0], [2.0, 2.0], [0.0, 2.0]];

    #[test]
    fn a_square_is_simple_and_knows_its_inside() {
        assert_eq!(self_intersection(&SQUARE), None);
        assert!((area(&SQUARE) - 4.0).abs() < 1e-12);
        assert!(contains(&SQUARE, [1.0, 1.9]) && !contains(&SQUARE, [1.0, 2.1]));
        let nearest_m = edges(&SQUARE).map(|edge| segment_distance([3.0, 3.0], edge)).fold(f64::INFINITY, f64::min);
        assert!((nearest_m - 2.0_f64.sqrt()).abs() < 1e-12);
        assert_eq!(reflex_corner(&SQUARE), None);
        assert_eq!(reflex_corner(&[[0.0, 0.0], [2.0, 0.0], [0.5, 0.5], [0.0, 2.0]]), Some(2));
    }

    #[test]
    fn a_bow_tie_a_spike_and_a_repeated_corner_intersect_themselves() {
        assert_eq!(self_intersection(&[[0.0, 0.0], [2.0, 2.0], [2.0, 0.0], [0.0, 2.0]]), Some((0, 2)));
        assert!(self_intersection(&[[0.0, 0.0], [2.0, 0.0], [4.0, 0.0], [2.0, 0.0], [0.0, 2.0]]).is_some());
        assert!(self_intersection(&[[0.0, 0.0], [2.0, 0.0], [2.0, 0.0], [0.0, 2.0]]).is_some());
    }
}
