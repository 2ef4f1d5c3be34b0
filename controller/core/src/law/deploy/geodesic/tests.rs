//! Ways are as short as geometry allows, keep their distance, and lead where they should.

use super::testing::{keeps, polygon, shortest_m, string_m, v};
use super::{CELL_M, Field, Geodesic, grid};
use crate::avoid::Capsule;
use drover_contract::Vec2;
use drover_contract::math::sin_cos;
use proptest::prelude::{ProptestConfig, Strategy, prop_assert, prop_assert_eq, prop_oneof, proptest};
use std::f64::consts::PI;

const KEEP_M: f64 = 0.3;
const STEP_M: f64 = 0.5;

/// A U that opens to the west, 10 m wide and 8 m deep inside.
fn pocket() -> Vec<Capsule> {
    let inside = [(24.0, 25.0), (32.0, 25.0), (32.0, 15.0), (24.0, 15.0)];
    polygon(&[&[(24.0, 14.0), (33.0, 14.0), (33.0, 26.0), (24.0, 26.0)], &inside[..]].concat())
}

/// A wall on the y axis with a door of this width in the middle.
fn wall_with_door(width_m: f64) -> Vec<Capsule> {
    let half = |side: f64| Capsule::edge(v(0.0, side * width_m / 2.0), v(0.0, side * 30.0));
    vec![half(1.0), half(-1.0)]
}

/// Corridors of `gap_m`, wound from the middle outwards.
fn spiral(turns: u16, gap_m: f64) -> Vec<Capsule> {
    let directions = [v(1.0, 0.0), v(0.0, 1.0), v(-1.0, 0.0), v(0.0, -1.0)];
    let mut corner_w = v(0.0, 0.0);
    let mut edge = |turn: u16| {
        let from_w = corner_w;
        corner_w += directions[usize::from(turn % 4)] * gap_m * f64::from(turn + 1);
        Capsule::edge(from_w, corner_w)
    };
    (0..turns).map(&mut edge).collect()
}

fn map(walls: &[Capsule], bounds_w: (Vec2, Vec2)) -> Geodesic {
    Geodesic::new(walls, bounds_w, KEEP_M, CELL_M)
}

/// Follow the aim step by step, with or without the memory of the one before. The length that was gone; every step
/// keeps `keep_m` from all walls.
fn follow(walls: &[Capsule], (map, field): (&Geodesic, &Field), from_w: Vec2, keep_m: f64, memory: bool) -> f64 {
    let (mut at_w, mut gone_m) = (from_w, 0.0);
    let mut aim = field.aim(map, from_w, None).expect("a way");
    let steps_max = (aim.length_m / STEP_M * 1.1) as usize + 50;
    for _ in 0..steps_max {
        let to_aim = aim.at_w - at_w;
        let to_w = at_w + to_aim * (STEP_M / to_aim.norm()).min(1.0);
        assert!(keeps(walls, at_w, to_w, keep_m - 1e-9), "from {at_w} to {to_w}");
        let step_m = (to_w - at_w).norm();
        gone_m += step_m;
        at_w = to_w;
        if (at_w - field.target_w()).norm() < 1e-9 {
            return gone_m;
        }
        let before_m = aim.length_m;
        aim = field.aim(map, at_w, memory.then_some(aim)).expect("who follows a way never loses it");
        assert!(!memory || aim.length_m <= before_m - step_m + 1e-9, "{before_m} m, after {step_m} m {aim:?}");
    }
    panic!("not there after {steps_max} steps from {from_w}, but at {at_w}");
}

/// The length of the way is `exact_m` to 2 %, from both ends, and who follows it goes that far.
fn assert_length(walls: &[Capsule], map: &Geodesic, ends_w: (Vec2, Vec2), exact_m: f64) {
    for (from_w, to_w) in [ends_w, (ends_w.1, ends_w.0)] {
        let field = map.field(to_w);
        let length_m = field.length_m(map, from_w).expect("a way");
        assert!((0.999..1.02).contains(&(length_m / exact_m)), "{length_m} m instead of {exact_m} m");
        for memory in [false, true] {
            let gone_m = follow(walls, (map, &field), from_w, KEEP_M, memory);
            assert!((0.999..1.02).contains(&(gone_m / exact_m)), "gone {gone_m} m instead of {exact_m} m");
        }
    }
}

#[test]
fn a_target_in_sight_is_aimed_at_straight() {
    let walls = pocket();
    let map = map(&walls, (v(0.0, 0.0), v(40.0, 40.0)));
    let field = map.field(v(30.123, 20.456));
    let aim = field.aim(&map, v(3.3, 18.7), None).expect("a way");
    assert_eq!(aim.at_w, v(30.123, 20.456));
    assert!((aim.length_m - (v(30.123, 20.456) - v(3.3, 18.7)).norm()).abs() < 1e-12);
    assert_eq!(field.aim_w(&map, field.target_w()), Some(field.target_w()), "there already");
    let above = field.aim_w(&map, v(28.0, 30.0)).expect("a way");
    assert!(above.x < 24.0 && map.clear(v(28.0, 30.0), above), "towards the mouth: {above}");
}

#[test]
fn out_of_a_pocket_the_way_is_tangents_and_arcs() {
    let walls = pocket();
    let map = map(&walls, (v(0.0, 0.0), v(40.0, 40.0)));
    let ends_w = (v(30.0, 21.0), v(41.0, 20.5));
    let exact_m = string_m(ends_w, &[v(24.0, 25.0), v(24.0, 26.0), v(33.0, 26.0)], KEEP_M, -1.0);
    assert!((exact_m - 27.87).abs() < 0.02, "26.93 m of lines and half a circle: {exact_m}");
    assert_length(&walls, &map, ends_w, exact_m);
}

#[test]
fn through_a_door_the_way_bends_round_its_post() {
    let walls = wall_with_door(2.0);
    let map = map(&walls, (v(-10.0, -10.0), v(10.0, 10.0)));
    let ends_w = (v(-6.0, -6.0), v(5.0, -7.0));
    assert_length(&walls, &map, ends_w, string_m(ends_w, &[v(0.0, -1.0)], KEEP_M, -1.0));
}

#[test]
fn out_of_a_spiral_the_way_is_as_short_as_a_visibility_graph_finds() {
    let walls = spiral(11, 1.7);
    let map = map(&walls, (v(-12.0, -12.0), v(12.0, 12.0)));
    let ends_w = (v(0.5, 1.0), v(11.0, 11.0));
    let exact_m = shortest_m(&walls, KEEP_M, ends_w).expect("a way");
    assert!(exact_m > 70.0, "it winds: {exact_m} m");
    assert_length(&walls, &map, ends_w, exact_m);
}

#[test]
fn what_is_walled_in_is_not_reached() {
    let mut walls = polygon(&[(5.0, 5.0), (15.0, 6.0), (13.0, 14.0), (4.0, 12.0)]);
    walls.push(Capsule::disc(v(30.0, 10.0), 3.0));
    let map = map(&walls, (v(0.0, 0.0), v(40.0, 20.0)));
    for (target_w, from_w) in [
        (v(9.0, 9.0), v(1.0, 1.0)),
        (v(1.0, 1.0), v(9.0, 9.0)),
        (v(30.5, 10.0), v(20.0, 10.0)),
        (v(5.0, 5.0), v(0.0, 0.0)),
    ] {
        assert_eq!(map.field(target_w).aim(&map, from_w, None), None, "{from_w} to {target_w}");
        assert_eq!(map.way(from_w, target_w, 60.0), None, "{from_w} to {target_w}");
    }
    let within = map.field(v(9.0, 9.0));
    assert_eq!(within.aim_w(&map, v(7.0, 10.0)), Some(v(9.0, 9.0)), "within the ring one gets about");
}

#[test]
fn a_thin_wall_is_sealed_whatever_its_direction_and_however_little_is_kept() {
    for turn in 0..12 {
        let (sin, cos) = sin_cos(f64::from(turn) / 12.0 * PI);
        let turned = |x: f64, y: f64| (x * cos - y * sin, x * sin + y * cos);
        let walls = polygon(&[turned(-4.0, -3.0), turned(4.0, -3.0), turned(4.1, 3.0), turned(-4.0, 3.2)]);
        for keep_m in [0.0, 0.05, 0.3] {
            let map = Geodesic::new(&walls, (v(-9.0, -9.0), v(9.0, 9.0)), keep_m, CELL_M);
            let field = map.field(v(0.1, 0.2));
            assert_eq!(field.length_m(&map, v(8.0, 8.0)), None, "turn {turn}, kept {keep_m} m");
            assert!(field.length_m(&map, v(1.0, -1.0)).is_some());
        }
    }
}

#[test]
fn a_door_as_wide_as_twice_the_distance_and_a_cell_is_open_wherever_the_cells_lie() {
    for case in 0..40 {
        let (sin, cos) = sin_cos(f64::from(case) / 40.0 * PI);
        let shift = v(0.017, 0.031) * f64::from(case);
        let turned = |at: Vec2| v(at.x * cos - at.y * sin, at.x * sin + at.y * cos) + shift;
        let door = wall_with_door(2.0 * KEEP_M + CELL_M + 1e-5);
        let walls: Vec<Capsule> = door.iter().map(|wall| Capsule::edge(turned(wall.a_w), turned(wall.b_w))).collect();
        let map = map(&walls, (v(-9.0, -9.0), v(9.0, 9.0)));
        let ends_w = (turned(v(-1.0, -3.0)), turned(v(1.0, -3.0)));
        assert!(map.field(ends_w.1).length_m(&map, ends_w.0).is_some_and(|length_m| length_m < 9.0), "case {case}");
    }
}

#[test]
fn walls_on_the_border_are_walked_around_unless_they_close() {
    let side = |from: (f64, f64), to: (f64, f64)| Capsule::edge(v(from.0, from.1), v(to.0, to.1));
    let bounds_w = (v(0.0, 0.0), v(20.0, 10.0));
    let bar = [side((10.0, 0.0), (10.0, 10.0))];
    let ends_w = (v(8.0, 4.0), v(12.0, 4.0));
    let map_of = |walls: &[Capsule]| map(walls, bounds_w);
    assert_length(&bar, &map_of(&bar), ends_w, string_m(ends_w, &[v(10.0, 0.0)], KEEP_M, 1.0));
    let room = [polygon(&[(0.0, 0.0), (20.0, 0.0), (20.0, 10.0), (0.0, 10.0)]), bar.to_vec()].concat();
    let closed = map_of(&room);
    assert_eq!(closed.field(ends_w.1).length_m(&closed, ends_w.0), None);
    assert_eq!(closed.field(v(9.0, 9.0)).aim_w(&closed, v(0.5, 0.5)), Some(v(9.0, 9.0)), "along the walls");
    let outside = map_of(&bar).field(v(500.0, 4.0));
    assert!(outside.length_m(&map_of(&bar), v(-300.0, 4.0)).is_some_and(|length_m| (800.0..801.0).contains(&length_m)));
}

#[test]
fn who_is_too_near_to_a_wall_is_led_away_and_along() {
    let walls = pocket();
    let map = map(&walls, (v(0.0, 0.0), v(40.0, 40.0)));
    let field = map.field(v(36.0, 20.0));
    for (from_w, room_m) in
        [(v(31.9, 20.0), 0.1), (v(31.95, 24.98), 0.02), (v(25.0, 26.001), 0.001), (v(23.8, 25.5), 0.2)]
    {
        let gone_m = follow(&walls, (&map, &field), from_w, room_m, false);
        assert!(gone_m < 1.01 * field.length_m(&map, from_w).expect("a way"));
    }
    let near = map.field(v(33.05, 20.0));
    assert_eq!(near.aim_w(&map, v(37.0, 22.0)), Some(v(33.05, 20.0)), "a target near a wall is approached");
    assert!(follow(&walls, (&map, &near), v(30.0, 20.0), 0.05, true) > 25.0, "but not through the wall");
}

#[test]
fn a_bounded_way_is_that_of_the_field_or_none() {
    let walls = pocket();
    let map = map(&walls, (v(0.0, 0.0), v(40.0, 40.0)));
    let (from_w, to_w) = (v(28.0, 23.0), v(28.0, 28.0));
    let exact_m = string_m((from_w, to_w), &[v(24.0, 25.0), v(24.0, 26.0)], KEEP_M, -1.0);
    let way_w = map.way(from_w, to_w, exact_m * 1.02).expect("long enough");
    assert!(way_w.windows(2).all(|leg| keeps(&walls, leg[0], leg[1], KEEP_M)));
    assert_eq!((way_w[0], way_w[way_w.len() - 1]), (from_w, to_w));
    assert_eq!(map.way(from_w, to_w, exact_m * 0.99), None);
    assert_eq!(map.way(from_w, to_w, 1.0), None);
    assert_eq!(map.way(from_w, v(24.0, 18.0), 9.0), Some(vec![from_w, v(24.0, 18.0)]), "in sight");
}

#[test]
fn what_is_not_finite_or_too_much_is_survived() {
    let lost = v(f64::NAN, 1.0);
    let walls = [Capsule::edge(lost, v(1.0, 1.0)), Capsule::disc(v(2.0, 2.0), f64::INFINITY)];
    let map = Geodesic::new(&walls, (lost, v(4.0, 4.0)), f64::NAN, f64::INFINITY);
    let field = map.field(v(1.0, 3.0));
    assert_eq!(field.aim_w(&map, v(3.0, 1.0)), Some(v(1.0, 3.0)));
    assert_eq!(field.aim_w(&map, lost), None);
    assert_eq!(map.field(lost).aim_w(&map, v(1.0, 1.0)), None);
    assert_eq!(map.way(lost, v(1.0, 1.0), f64::INFINITY), None);
    let huge = grid::Grid::over(v(0.0, 0.0), v(9e5, 3.0), KEEP_M, CELL_M);
    assert!(huge.cells() as f64 <= grid::CELLS_MAX && huge.cell_m < 1.7, "{} m", huge.cell_m);
}

fn place() -> impl Strategy<Value = Vec2> {
    (0.0..20.0, 0.0..15.0).prop_map(|(x, y)| v(x, y))
}

fn wall() -> impl Strategy<Value = Capsule> {
    let radius = prop_oneof![proptest::strategy::Just(0.0), 0.0..1.5];
    (place(), -4.0..4.0, -4.0..4.0, radius).prop_map(|(a_w, right, up, radius_m)| {
        let b_w = a_w + v(right, up);
        Capsule { a_w, b_w, radius_m }
    })
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 64, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn among_random_walls_ways_are_short_safe_and_found(
        walls in proptest::collection::vec(wall(), 0..9),
        places in proptest::collection::vec(place(), 12),
        cell_m in prop_oneof![proptest::strategy::Just(CELL_M), 0.2..0.8],
    ) {
        let free: Vec<Vec2> = places.into_iter().filter(|at| keeps(&walls, *at, *at, KEEP_M)).collect();
        let map = Geodesic::new(&walls, (v(0.0, 0.0), v(20.0, 15.0)), KEEP_M, cell_m);
        let Some((target_w, starts_w)) = free.split_first() else { return Ok(()) };
        let field = map.field(*target_w);
        for from_w in starts_w {
            let ends_w = (*from_w, *target_w);
            let roomy_m = shortest_m(&walls, KEEP_M + 0.71 * cell_m, ends_w);
            let Some(length_m) = field.length_m(&map, *from_w) else {
                prop_assert_eq!(roomy_m, None, "a way with room is found, from {} to {}", from_w, target_w);
                continue;
            };
            let exact_m = shortest_m(&walls, KEEP_M, ends_w);
            prop_assert!(exact_m.is_some_and(|exact_m| length_m > exact_m * 0.998), "{} {:?}", length_m, exact_m);
            prop_assert!(roomy_m.is_none_or(|roomy_m| length_m < roomy_m * 1.02), "{} {:?}", length_m, roomy_m);
            let gone_m = follow(&walls, (&map, &field), *from_w, KEEP_M, true);
            let way_w = map.way(*from_w, *target_w, length_m * 1.02 + cell_m).expect("also within bounds");
            prop_assert!(way_w.windows(2).all(|leg| keeps(&walls, leg[0], leg[1], KEEP_M)));
            prop_assert!(gone_m < length_m + 1e-6, "gone {} m of {} m", gone_m, length_m);
        }
    }

    #[test]
    fn sight_through_the_index_is_sight_past_every_wall(
        walls in proptest::collection::vec(wall(), 0..15),
        ways in proptest::collection::vec((place(), place()), 60),
        keep_m in 0.01..1.0,
        cell_m in 0.1..1.0,
    ) {
        let map = Geodesic::new(&walls, (v(5.0, 5.0), v(6.0, 6.0)), keep_m, cell_m);
        for (from_w, to_w) in ways {
            let far_w = from_w + (to_w - from_w) * 3.0;
            prop_assert_eq!(map.clear(from_w, to_w), keeps(&walls, from_w, to_w, keep_m));
            prop_assert_eq!(map.clear(far_w, from_w), keeps(&walls, far_w, from_w, keep_m));
        }
    }
}
