//! Every layout, for many seeds: sound outlines, one free floor, and words for what does not fit.

use super::*;
use crate::geometry::{Point, area, contains, edges, segment_distance, self_intersection};
use proptest::prelude::*;

/// Seeds that every layout is made for.
const SEEDS: u64 = 50;
/// Place of the layouts below, metres.
const PLACE_M: [f64; 2] = [15.0, 13.0];

/// A layout, the width that its free floor promises, and whether chance has a part in it.
struct Sample {
    layout: Layout,
    passage_m: f64,
    random: bool,
}

fn sample(layout: Layout, passage_m: f64, random: bool) -> Sample {
    Sample { layout, passage_m, random }
}

fn maze(passage_m: f64, wall_m: f64, loops: f64) -> Layout {
    Layout::Maze(Maze { passage_m, wall_m, loops })
}

fn field(count: usize) -> ConvexField {
    let (margin_m, west_m, east_m) = (1.5, 1.5, 1.5);
    let (size_min_m, size_max_m) = (0.5, 2.0);
    ConvexField { count, count_max: count, size_min_m, size_max_m, passage_m: 1.0, margin_m, west_m, east_m }
}

fn office(corridors: usize, desks: usize) -> Layout {
    Layout::Office(Office { corridors, passage_m: 1.5, room_m: 3.0, door_m: 1.0, wall_m: 0.2, desks })
}

fn warehouse(gaps: f64) -> Layout {
    Layout::Warehouse(Warehouse { rack_m: 3.0, rack_depth_m: 1.0, passage_m: 1.2, margin_m: 1.5, gaps })
}

fn cave(density: f64) -> Cave {
    Cave { passage_m: 1.0, density, smoothing: 4, clear_m: [3.0, 3.0], clear_radius_m: 1.5 }
}

fn corridor(bends: usize) -> Layout {
    Layout::Corridor(Corridor { bends, passage_m: 1.5, wall_m: 0.5 })
}

fn pocket() -> Pocket {
    let (opening_m, depth_m, turn_rad_max) = ([2.0, 5.0], [1.0, 4.0], 0.5);
    Pocket { opening_m, depth_m, wall_m: 0.3, turn_rad_max, offset_m_max: 1.0, passage_m: 1.5 }
}

fn samples() -> Vec<Sample> {
    let rooms = |loops| Layout::Rooms(Rooms { columns: 4, rows: 3, door_m: 1.0, wall_m: 0.15, loops });
    let mut samples = vec![
        sample(Layout::ConvexField(field(14)), 1.0, true),
        sample(rooms(0.0), 1.0, true),
        sample(rooms(0.6), 1.0, true),
        sample(office(1, 0), 1.0, true),
        sample(office(2, 3), 1.0, true),
        sample(warehouse(0.3), 1.2, true),
        sample(warehouse(0.0), 1.2, false),
        sample(maze(1.0, 0.2, 0.0), 1.0, true),
        sample(maze(1.3, 0.4, 0.5), 1.3, true),
        sample(Layout::Cave(cave(0.45)), 1.0, true),
        sample(Layout::Cave(Cave { clear_radius_m: 0.0, ..cave(0.4) }), 1.0, true),
        sample(Layout::U(U { opening_m: 5.4, depth_m: 3.6, wall_m: 0.3, passage_m: 1.5 }), 1.5, false),
        sample(Layout::T(Tee { bar_m: 5.4, stem_m: 3.6, wall_m: 0.3, passage_m: 1.5 }), 1.5, false),
        sample(Layout::Spiral(Spiral { turns: 3, passage_m: 1.5, wall_m: 0.2 }), 1.5, false),
        sample(Layout::Comb(Comb { pockets: 7, depth_m: 5.0, wall_m: 0.2, passage_m: 1.5 }), 1.5, false),
        sample(Layout::Door(Door { door_m: 0.9, wall_m: 0.2 }), 0.9, false),
    ];
    samples.push(sample(Layout::ConvexField(ConvexField { count_max: 12, west_m: 5.0, ..field(6) }), 1.0, true));
    samples.push(sample(Layout::Pocket(pocket()), 1.5, true));
    samples.extend((0..=5).map(|bends| sample(corridor(bends), 1.5, false)));
    samples
}

fn params(layout: &Layout) -> Generate {
    Generate { width_m: PLACE_M[0], height_m: PLACE_M[1], seed: None, layout: layout.clone() }
}

/// Distance from a point to an outline, metres.
fn outline_distance(point: Point, points: &[Point]) -> f64 {
    edges(points).map(|edge| segment_distance(point, edge)).fold(f64::INFINITY, f64::min)
}

fn made(layout: &Layout, seed: u64) -> Vec<Polygon> {
    generate(&params(layout), seed).unwrap_or_else(|misfit| panic!("{layout:?} {seed}: {}", misfit.words.found))
}

#[test]
fn outlines_are_simple_have_an_area_and_the_first_is_the_enclosure() {
    for Sample { layout, random, .. } in samples() {
        for seed in 0..if random { SEEDS } else { 1 } {
            let world = made(&layout, seed);
            let enclosures: Vec<bool> = world.iter().map(|polygon| polygon.enclosure).collect();
            assert!(enclosures[0] && !enclosures[1..].contains(&true), "{layout:?} {seed}");
            for Polygon { points_m, .. } in &world {
                assert!(points_m.len() >= 3 && area(points_m) > 1e-4, "{layout:?} {seed}: {points_m:?}");
                assert_eq!(self_intersection(points_m), None, "{layout:?} {seed}: {points_m:?}");
                let inside = |[x, y]: &[f64; 2]| (0.0..=PLACE_M[0]).contains(x) && (0.0..=PLACE_M[1]).contains(y);
                assert!(points_m.iter().all(inside), "{layout:?} {seed}");
            }
        }
    }
}

#[test]
fn outlines_are_apart_and_obstacles_stand_in_the_enclosure() {
    for Sample { layout, random, .. } in samples() {
        for seed in 0..if random { SEEDS } else { 1 } {
            let world = made(&layout, seed);
            for (index, polygon) in world.iter().enumerate() {
                for other in &world[..index] {
                    // Corners on either side: outlines along the axes or at 45 degrees that cross come near to one.
                    let gap = |a: &Polygon, b: &Polygon| {
                        a.points_m.iter().map(|p| outline_distance(*p, &b.points_m)).fold(f64::INFINITY, f64::min)
                    };
                    assert!(gap(polygon, other).min(gap(other, polygon)) > 0.01, "{layout:?} {seed}");
                    let inside = contains(&other.points_m, polygon.points_m[0]);
                    assert_eq!(inside, other.enclosure, "{layout:?} {seed}");
                }
            }
        }
    }
}

#[test]
fn a_disc_almost_as_wide_as_the_passage_gets_everywhere_that_it_fits() {
    for Sample { layout, passage_m, random } in samples() {
        for seed in 0..if random { SEEDS } else { 1 } {
            let world = made(&layout, seed);
            let parts = parts_of(&world, passage_m);
            assert_eq!(parts.len(), 1, "{layout:?} {seed}: {parts:?}");
        }
    }
}

/// Sizes of the parts of the floor among which a disc does not get, by a lattice of places for its centre.
fn parts_of(world: &[Polygon], passage_m: f64) -> Vec<usize> {
    let (radius_m, step_m) = (0.45 * passage_m, 0.06 * passage_m);
    let count = PLACE_M.map(|side_m| (side_m / step_m) as usize);
    let at = |[x, y]: [usize; 2]| [(x as f64 + 0.5) * step_m, (y as f64 + 0.5) * step_m];
    let walls: Vec<_> = world.iter().flat_map(|polygon| edges(&polygon.points_m)).collect();
    let mut open = vec![true; count[0] * count[1]];
    for wall in &walls {
        // Only the lattice near a wall has to be looked at.
        let low = [0, 1].map(|axis| ((wall.0[axis].min(wall.1[axis]) - radius_m) / step_m).max(1.0) as usize - 1);
        let high = [0, 1].map(|axis| ((wall.0[axis].max(wall.1[axis]) + radius_m) / step_m) as usize + 2);
        for y in low[1]..high[1].min(count[1]) {
            for x in low[0]..high[0].min(count[0]) {
                open[y * count[0] + x] &= segment_distance(at([x, y]), *wall) >= radius_m;
            }
        }
    }
    let mut parts = Vec::new();
    for start in 0..open.len() {
        let centre = at([start % count[0], start / count[0]]);
        if open[start] && world.iter().all(|polygon| contains(&polygon.points_m, centre) == polygon.enclosure) {
            parts.push(flood(&mut open, count[0], start));
        }
    }
    parts
}

/// Closes all that can be reached from `start`: how many places that are.
fn flood(open: &mut [bool], columns: usize, start: usize) -> usize {
    let mut next = vec![start];
    open[start] = false;
    let mut size = 0;
    while let Some(cell) = next.pop() {
        size += 1;
        let rows = [cell.wrapping_sub(columns), cell, cell + columns];
        for near in rows.into_iter().flat_map(|middle| [middle.wrapping_sub(1), middle, middle.wrapping_add(1)]) {
            if open.get(near) == Some(&true) {
                open[near] = false;
                next.push(near);
            }
        }
    }
    size
}

#[test]
fn the_same_seed_makes_the_same_world_and_another_seed_another() {
    for Sample { layout, random, .. } in samples() {
        for seed in 0..SEEDS {
            assert_eq!(made(&layout, seed), made(&layout, seed));
            assert_eq!(made(&layout, seed) != made(&layout, seed + 1), random, "{layout:?} {seed}");
        }
        let own = Generate { seed: Some(7), ..params(&layout) };
        assert!(generate(&own, 1).ok() == generate(&params(&layout), 7).ok());
    }
}

#[test]
fn a_maze_without_loops_is_one_outline_and_loops_make_islands() {
    assert_eq!(made(&maze(1.0, 0.2, 0.0), 3).len(), 1);
    assert!(made(&maze(1.0, 0.2, 0.5), 3).len() > 1);
}

#[test]
fn a_cave_s_start_is_free_whatever_the_seed() {
    for seed in 0..SEEDS {
        let cave = cave(0.5);
        let world = made(&Layout::Cave(cave.clone()), seed);
        for polygon in &world {
            assert!(outline_distance(cave.clear_m, &polygon.points_m) >= cave.clear_radius_m, "{seed}");
            assert_eq!(contains(&polygon.points_m, cave.clear_m), polygon.enclosure);
        }
    }
}

#[test]
fn what_a_seed_makes_stays_as_it_is() {
    // Whoever changes a generator changes every recorded batch: say so in the changelog, then change this.
    let sums: Vec<i64> = samples()
        .iter()
        .filter(|sample| sample.random)
        .map(|sample| {
            let corners = made(&sample.layout, 1).into_iter().flat_map(|polygon| polygon.points_m);
            corners.enumerate().map(|(index, [x, y])| (index as i64 + 1) * (mm(x) + 3 * mm(y))).sum()
        })
        .collect();
    let known = [
        74_611_517,
        122_867_354,
        155_930_892,
        68_178_250,
        695_609_704,
        21_174_000,
        763_954_993,
        357_746_251,
        64_345_500,
        37_320_250,
        31_064_692,
        2_310_142,
    ];
    assert_eq!(sums, known);
}

#[test]
fn what_does_not_fit_is_refused_with_the_key_that_is_to_change() {
    let rooms = Rooms { columns: 20, rows: 2, door_m: 1.0, wall_m: 0.2, loops: 0.0 };
    let wide_office = Office { corridors: 9, passage_m: 3.0, room_m: 4.0, door_m: 1.0, wall_m: 0.2, desks: 2 };
    let narrow_room = Office { corridors: 1, room_m: 1.2, ..wide_office.clone() };
    let rack = Warehouse { rack_m: 40.0, rack_depth_m: 1.0, passage_m: 2.0, margin_m: 3.0, gaps: 0.0 };
    let u = U { opening_m: 5.4, depth_m: 3.6, wall_m: 0.3, passage_m: 6.0 };
    let cases = [
        (maze(20.0, 0.2, 0.0), "passage_m"),
        (maze(0.05, 0.01, 0.0), "passage_m"),
        (Layout::Rooms(rooms), "width_m"),
        (Layout::Office(wide_office), "height_m"),
        (Layout::Office(narrow_room), "room_m"),
        (Layout::Warehouse(rack.clone()), "width_m"),
        (Layout::Warehouse(Warehouse { margin_m: 0.5, ..rack }), "margin_m"),
        (Layout::ConvexField(field(500)), "count"),
        (Layout::ConvexField(ConvexField { count_max: 600, ..field(500) }), "count_max"),
        (Layout::ConvexField(ConvexField { count_max: 4, ..field(5) }), "count_max"),
        (Layout::ConvexField(ConvexField { west_m: 0.5, ..field(5) }), "margin_west_m"),
        (Layout::ConvexField(ConvexField { east_m: 14.0, ..field(5) }), "width_m"),
        (Layout::ConvexField(ConvexField { size_max_m: 0.1, ..field(5) }), "size_max_m"),
        (Layout::ConvexField(ConvexField { margin_m: 0.1, ..field(5) }), "margin_m"),
        (Layout::ConvexField(ConvexField { size_max_m: 30.0, ..field(5) }), "width_m"),
        (Layout::Cave(Cave { clear_radius_m: 0.0, ..cave(0.9) }), "density"),
        (Layout::Cave(Cave { passage_m: 0.05, ..cave(0.4) }), "passage_m"),
        (Layout::Cave(Cave { clear_m: [99.0, 3.0], ..cave(0.4) }), "clear_x_m"),
        (Layout::Pocket(Pocket { opening_m: [3.0, 2.0], ..pocket() }), "opening_max_m"),
        (Layout::Pocket(Pocket { depth_m: [3.0, 2.0], ..pocket() }), "depth_max_m"),
        (Layout::Pocket(Pocket { passage_m: 2.1, ..pocket() }), "opening_min_m"),
        (Layout::Pocket(Pocket { depth_m: [3.0, 20.0], ..pocket() }), "width_m"),
        (Layout::Pocket(Pocket { offset_m_max: 1.6, ..pocket() }), "height_m"),
        (Layout::U(u.clone()), "opening_m"),
        (Layout::U(U { opening_m: 7.0, ..u }), "width_m"),
        (Layout::T(Tee { bar_m: 0.5, stem_m: 3.0, wall_m: 0.2, passage_m: 1.0 }), "bar_m"),
        (Layout::Spiral(Spiral { turns: 9, passage_m: 1.5, wall_m: 0.2 }), "width_m"),
        (Layout::Comb(Comb { pockets: 20, depth_m: 5.0, wall_m: 0.2, passage_m: 1.5 }), "width_m"),
        (Layout::Comb(Comb { pockets: 3, depth_m: 12.0, wall_m: 0.2, passage_m: 1.5 }), "height_m"),
        (Layout::Door(Door { door_m: 20.0, wall_m: 0.2 }), "width_m"),
        (corridor(40), "width_m"),
    ];
    for (layout, key) in cases {
        match generate(&params(&layout), 1) {
            Ok(_) => panic!("{layout:?} was made"),
            Err(misfit) => assert_eq!(misfit.key, key, "{layout:?}: {}", misfit.words.expected),
        }
    }
}

#[test]
fn a_world_of_too_many_corners_is_refused() {
    let params = Generate { width_m: 250.0, height_m: 250.0, ..params(&maze(1.8, 0.2, 0.0)) };
    let Err(misfit) = generate(&params, 1) else { panic!("15000 cells have more corners than that") };
    assert!(misfit.words.found.contains("corners"), "{}", misfit.words.found);
}

#[test]
fn the_test_of_one_floor_sees_a_door_that_is_too_narrow() {
    let world = made(&Layout::Door(Door { door_m: 0.9, wall_m: 0.2 }), 1);
    assert_eq!(parts_of(&world, 1.2).len(), 2);
}

/// Any layout, with lengths and counts of any size that the reader lets through.
fn any_layout() -> impl Strategy<Value = Layout> {
    // From 2 cm to 30 m, small ones as often as large ones.
    let length_m = (-3.9..3.4_f64).prop_map(libm::exp);
    let numbers = (prop::array::uniform5(length_m), prop::array::uniform2(1..12_usize), 0.0..=1.0_f64);
    (0..13, numbers).prop_map(|(kind, ([a, b, c, d, e], [m, n], share))| match kind {
        0 => {
            let (size_min_m, size_max_m) = (a, a + b);
            let margins = ConvexField { passage_m: c, margin_m: d, west_m: e, east_m: d.max(e), ..field(n) };
            Layout::ConvexField(ConvexField { count_max: n + m, size_min_m, size_max_m, ..margins })
        }
        1 => Layout::Rooms(Rooms { columns: m, rows: n, door_m: a, wall_m: b, loops: share }),
        2 => Layout::Office(Office { corridors: m, passage_m: a, room_m: b, door_m: c, wall_m: d, desks: n }),
        3 => {
            let (rack_m, rack_depth_m) = (a, b);
            Layout::Warehouse(Warehouse { rack_m, rack_depth_m, passage_m: c, margin_m: d, gaps: share })
        }
        4 => maze(a, b, share),
        5 => {
            let (clear_m, clear_radius_m) = ([b, c], d);
            Layout::Cave(Cave { passage_m: a, density: share, smoothing: n % 6, clear_m, clear_radius_m })
        }
        6 => Layout::Corridor(Corridor { bends: n, passage_m: a, wall_m: b }),
        7 => Layout::U(U { opening_m: a, depth_m: b, wall_m: c, passage_m: d }),
        8 => Layout::T(Tee { bar_m: a, stem_m: b, wall_m: c, passage_m: d }),
        9 => Layout::Spiral(Spiral { turns: n, passage_m: a, wall_m: b }),
        10 => Layout::Comb(Comb { pockets: n, depth_m: a, wall_m: b, passage_m: e }),
        11 => Layout::Door(Door { door_m: a, wall_m: b }),
        _ => {
            let (opening_m, depth_m) = ([a, a + b], [c, c + d]);
            let (wall_m, turn_rad_max, offset_m_max) = (e, 3.0 * share, share * m as f64);
            Layout::Pocket(Pocket { opening_m, depth_m, wall_m, turn_rad_max, offset_m_max, passage_m: 0.5 })
        }
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2_000))]
    #[test]
    fn any_parameters_make_sound_outlines_or_are_refused_with_words(
        layout in any_layout(),
        [width_m, height_m] in prop::array::uniform2(2.0..80.0_f64),
        seed in any::<u64>(),
    ) {
        match generate(&Generate { width_m, height_m, seed: None, layout }, seed) {
            Ok(world) => for (index, Polygon { enclosure, points_m }) in world.iter().enumerate() {
                prop_assert_eq!(*enclosure, index == 0);
                prop_assert!(area(points_m) > 1e-5 && self_intersection(points_m).is_none(), "{:?}", points_m);
            },
            Err(Misfit { words, .. }) => {
                prop_assert!(!words.found.is_empty() && !words.expected.is_empty() && !words.advice.is_empty());
            }
        }
    }
}
