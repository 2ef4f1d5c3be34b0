//! Shortest ways by other means than cells: what the tests of the grid are held against.

use crate::avoid::Capsule;
use drover_contract::Vec2;
use drover_contract::math::{asin, atan2, sin_cos};
use std::f64::consts::{PI, TAU};

/// Corners of the polygon around an end of a wall that stands for a circle: 0.1 % longer.
const CORNERS: u32 = 48;

/// A place, metres.
pub(super) fn v(x: f64, y: f64) -> Vec2 {
    Vec2::new(x, y)
}

/// The edges of a closed polygon.
pub(super) fn polygon(corners: &[(f64, f64)]) -> Vec<Capsule> {
    let after = corners.iter().cycle().skip(1);
    corners.iter().zip(after).map(|(a, b)| Capsule::edge(v(a.0, a.1), v(b.0, b.1))).collect()
}

/// Whether a straight way keeps the distance: all walls are asked.
pub(super) fn keeps(walls: &[Capsule], from_w: Vec2, to_w: Vec2, keep_m: f64) -> bool {
    walls.iter().all(|wall| wall.clearance_m(from_w, to_w) >= keep_m)
}

/// Length of a string from place to place that passes all `centres_w` on their left or all on their right, at
/// `keep_m`: tangents and arcs, by school geometry. `left` is 1 if the string turns left around them, else -1.
pub(super) fn string_m(ends_w: (Vec2, Vec2), centres_w: &[Vec2], keep_m: f64, left: f64) -> f64 {
    let heading = |way: Vec2| atan2(way.y, way.x);
    let (first, last) = (centres_w[0] - ends_w.0, ends_w.1 - centres_w[centres_w.len() - 1]);
    let tangent_m = |way: Vec2| (way.norm_squared() - keep_m * keep_m).sqrt();
    let mut headings = vec![heading(first) - left * asin(keep_m / first.norm())];
    headings.extend(centres_w.windows(2).map(|pair| heading(pair[1] - pair[0])));
    headings.push(heading(last) + left * asin(keep_m / last.norm()));
    let turns_rad: f64 = headings.windows(2).map(|pair| (left * (pair[1] - pair[0])).rem_euclid(TAU)).sum();
    let between_m: f64 = centres_w.windows(2).map(|pair| (pair[1] - pair[0]).norm()).sum();
    tangent_m(first) + between_m + tangent_m(last) + keep_m * turns_rad
}

/// Length of the shortest way by a visibility graph over corners around all ends of walls, each pair tested against all
/// walls: exact but for the corners.
pub(super) fn shortest_m(walls: &[Capsule], keep_m: f64, ends_w: (Vec2, Vec2)) -> Option<f64> {
    let keep_m = keep_m - 1e-9; // the sides of the polygons touch the circles
    let around = |wall: &Capsule, end_w: Vec2| {
        let radius_m = (wall.radius_m + keep_m + 2e-9) / sin_cos(PI / f64::from(CORNERS)).1;
        (0..CORNERS).map(move |corner| {
            let (sin, cos) = sin_cos(f64::from(corner) / f64::from(CORNERS) * TAU);
            end_w + v(cos, sin) * radius_m
        })
    };
    let corners = walls.iter().flat_map(|wall| around(wall, wall.a_w).chain(around(wall, wall.b_w)));
    let free = corners.filter(|at_w| keeps(walls, *at_w, *at_w, keep_m));
    let places_w: Vec<Vec2> = [ends_w.0, ends_w.1].into_iter().chain(free).collect();
    let mut lengths_m = vec![f64::INFINITY; places_w.len()];
    let mut open: Vec<usize> = (0..places_w.len()).collect();
    lengths_m[0] = 0.0;
    while let Some(nearest) = (0..open.len()).min_by(|a, b| lengths_m[open[*a]].total_cmp(&lengths_m[open[*b]])) {
        let here = open.swap_remove(nearest);
        if here == 1 || lengths_m[here].is_infinite() {
            return lengths_m[here].is_finite().then_some(lengths_m[here]);
        }
        for there in &open {
            let length_m = lengths_m[here] + (places_w[*there] - places_w[here]).norm();
            if length_m < lengths_m[*there] && keeps(walls, places_w[here], places_w[*there], keep_m) {
                lengths_m[*there] = length_m;
            }
        }
    }
    None
}
