//! Plane geometry that the checks need: discs against polygons and circles. Metres, world frame.

/// A point, metres.
pub(crate) type Point = [f64; 2];

/// Twice the signed area of the triangle `a`, `b`, `c`: positive counter-clockwise, 0 on one line.
fn cross(a: Point, b: Point, c: Point) -> f64 {
    (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
}

/// Distance between two points.
pub(crate) fn distance(a: Point, b: Point) -> f64 {
    (a[0] - b[0]).hypot(a[1] - b[1])
}

/// Distance from `p` to the segment `a`-`b`.
fn segment_distance(p: Point, (a, b): (Point, Point)) -> f64 {
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

/// Distance from `p` to the outline.
pub(crate) fn outline_distance(p: Point, points: &[Point]) -> f64 {
    edges(points).map(|edge| segment_distance(p, edge)).fold(f64::INFINITY, f64::min)
}

/// Whether `p` is inside (even-odd rule); on the outline either answer may come.
pub(crate) fn contains(points: &[Point], p: Point) -> bool {
    let crosses = |(a, b): &(Point, Point)| {
        (a[1] > p[1]) != (b[1] > p[1]) && p[0] < (b[0] - a[0]) * (p[1] - a[1]) / (b[1] - a[1]) + a[0]
    };
    edges(points).filter(crosses).count() % 2 == 1
}

/// The area, never negative.
pub(crate) fn area(points: &[Point]) -> f64 {
    let origin = points.first().copied().unwrap_or_default();
    edges(points).map(|(a, b)| cross(origin, a, b)).sum::<f64>().abs() / 2.0
}

/// Two edges (by their first corners) that touch where they should not, if any do.
pub(crate) fn self_intersection(points: &[Point]) -> Option<(usize, usize)> {
    let all: Vec<_> = edges(points).collect();
    let count = all.len();
    for (i, first) in all.iter().enumerate() {
        for (j, second) in all.iter().enumerate().skip(i + 1) {
            let next = j == i + 1;
            let previous = i == 0 && j == count - 1;
            let touch = match (next, previous) {
                (true, _) => folds_back(first.0, first.1, second.1),
                (_, true) => folds_back(second.0, second.1, first.1),
                (false, false) => segments_touch(*first, *second),
            };
            if touch {
                return Some((i, j));
            }
        }
    }
    None
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
    use super::{area, contains, outline_distance, self_intersection};

    const SQUARE: [[f64; 2]; 4] = [[0.0, 0.0], [2.0, 0.0], [2.0, 2.0], [0.0, 2.0]];

    #[test]
    fn a_square_is_simple_and_knows_its_inside() {
        assert_eq!(self_intersection(&SQUARE), None);
        assert!((area(&SQUARE) - 4.0).abs() < 1e-12);
        assert!(contains(&SQUARE, [1.0, 1.9]) && !contains(&SQUARE, [1.0, 2.1]));
        assert!((outline_distance([3.0, 3.0], &SQUARE) - 2.0_f64.sqrt()).abs() < 1e-12);
    }

    #[test]
    fn a_bow_tie_a_spike_and_a_repeated_corner_intersect_themselves() {
        assert_eq!(self_intersection(&[[0.0, 0.0], [2.0, 2.0], [2.0, 0.0], [0.0, 2.0]]), Some((0, 2)));
        assert!(self_intersection(&[[0.0, 0.0], [2.0, 0.0], [4.0, 0.0], [2.0, 0.0], [0.0, 2.0]]).is_some());
        assert!(self_intersection(&[[0.0, 0.0], [2.0, 0.0], [2.0, 0.0], [0.0, 2.0]]).is_some());
    }
}
