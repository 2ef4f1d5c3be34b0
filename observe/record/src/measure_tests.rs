use super::*;
use crate::{CLEAR, Heard, MapSetting, MoverSetting, Place, PlaceSetting, RobotSetting, ScanMoment, Truth};
use std::f64::consts::{FRAC_PI_2, PI};

fn setting(robots: u32) -> Setting {
    let robot = |id| RobotSetting { id, radius_m: 0.3, peer_ms: 500, ..RobotSetting::default() };
    Setting { robots: (1..=robots).map(robot).collect(), ..Setting::default() }
}

fn robot(id: u32, x_m: f64, y_m: f64) -> RobotMoment {
    let truth = Truth { place: Place { x_m, y_m, yaw_rad: 0.0 }, ..Truth::default() };
    RobotMoment { id, truth: Some(truth), ..RobotMoment::default() }
}

fn moment(robots: Vec<RobotMoment>) -> Moment {
    Moment { robots, ..Moment::default() }
}

fn near(found: Option<f64>, expected: f64) -> bool {
    found.is_some_and(|found| (found - expected).abs() < 1e-9)
}

fn room() -> PlaceSetting {
    PlaceSetting {
        enclosure_m: vec![[0.0, 0.0], [10.0, 0.0], [10.0, 8.0], [0.0, 8.0]],
        polygons_m: vec![vec![[4.0, 3.0], [6.0, 3.0], [6.0, 5.0], [4.0, 5.0]]],
        ..PlaceSetting::default()
    }
}

#[test]
fn gaps_are_measured_from_surface_to_surface() {
    let mut setting = setting(3);
    setting.place = room();
    let index = PlaceIndex::new(&setting.place);
    let moment = moment(vec![robot(1, 1.0, 4.0), robot(2, 1.0, 6.0), robot(3, 8.0, 4.0)]);
    let found = gaps_per_robot(&setting, &index, &moment);
    // 2 m between the centres, two radii of 0.3 m; the west wall is 1 m from both centres.
    assert!(near(found[0].robot_m, 1.4) && near(found[0].wall_m, 0.7), "{found:?}");
    assert!(near(found[1].robot_m, 1.4) && near(found[1].wall_m, 0.7), "{found:?}");
    // Its nearest peer is 7 m away; the block's east side and the east wall are both 2 m away.
    assert!(near(found[2].robot_m, 6.4) && near(found[2].wall_m, 1.7), "{found:?}");
    assert_eq!(gaps(&setting, &index, &moment), Gaps { robot_m: found[0].robot_m, wall_m: found[0].wall_m });
}

#[test]
fn movers_count_as_walls_where_they_are_now() {
    let mut setting = setting(1);
    setting.place.movers = vec![MoverSetting { radius_m: 0.5, round_m: vec![[2.0, 0.0], [9.0, 0.0]] }];
    let index = PlaceIndex::new(&setting.place);
    let wall_m = |movers_m| gaps(&setting, &index, &Moment { movers_m, ..moment(vec![robot(1, 0.0, 0.0)]) }).wall_m;
    assert!(near(wall_m(vec![[3.0, 4.0]]), 5.0 - 0.5 - 0.3));
    assert_eq!(wall_m(vec![[9.0, 0.0]]), None, "too far");
    assert_eq!(wall_m(Vec::new()), None, "nobody told where it is");
}

#[test]
fn what_overlaps_has_a_gap_below_zero() {
    let mut setting = setting(2);
    setting.place = room();
    let index = PlaceIndex::new(&setting.place);
    let found = gaps(&setting, &index, &moment(vec![robot(1, 5.0, 4.0), robot(2, 5.4, 4.0)]));
    assert!(near(found.robot_m, -0.2), "{found:?}");
    assert!(near(found.wall_m, -1.3), "1 m deep in the block: {found:?}");
    assert!(near(index.wall_distance([-0.5, 4.0]), -0.5), "outside of the enclosure");
}

#[test]
fn walls_of_every_kind_are_found_and_far_ones_are_none() {
    let circle = PlaceSetting { circles_m: vec![[5.0, 0.0, 1.0]], ..PlaceSetting::default() };
    assert!(near(PlaceIndex::new(&circle).wall_distance([2.0, 0.0]), 2.0));
    assert_eq!(PlaceIndex::new(&circle).wall_distance([-2.0, 0.0]), None, "6 m");
    let line = PlaceSetting { polylines_m: vec![vec![[0.0, 0.0], [30.0, 40.0]]], ..PlaceSetting::default() };
    // 3-4-5: (15 - 1.6, 20 + 1.2) is 2 m off the line's middle.
    assert!(near(PlaceIndex::new(&line).wall_distance([13.4, 21.2]), 2.0));
    let map = MapSetting {
        resolution_m: 0.5,
        origin_m: [10.0, 0.0],
        origin_yaw_rad: FRAC_PI_2,
        width: 4,
        height: 2,
        // The row in the south: one solid cell after two free ones; turned left by a right angle it points north.
        runs: vec![2, 1, 5],
    };
    let map = PlaceIndex::new(&PlaceSetting { map: Some(map), ..PlaceSetting::default() });
    assert!(near(map.wall_distance([10.0, 3.5]), 2.0), "{:?}", map.wall_distance([10.0, 3.5]));
    assert!(!map.is_free([9.75, 1.25]) && map.is_free([9.75, 0.75]) && map.is_free([9.25, 1.25]));
    let nothing = PlaceIndex::new(&PlaceSetting::default());
    assert!(nothing.is_empty() && nothing.wall_distance([0.0, 0.0]).is_none() && nothing.bounds_m().is_none());
}

#[test]
fn the_grid_finds_what_a_look_at_every_wall_finds() {
    let mut state = 1_u64;
    let mut chance = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 33) as f64 / f64::from(1_u32 << 31)
    };
    let lines: Vec<Vec<[f64; 2]>> = (0..300)
        .map(|_| {
            let from = [chance() * 60.0 - 30.0, chance() * 60.0 - 30.0];
            vec![from, [from[0] + chance() * 8.0 - 4.0, from[1] + chance() * 8.0 - 4.0]]
        })
        .collect();
    let all: Vec<PlaceIndex> = lines
        .iter()
        .map(|line| PlaceIndex::new(&PlaceSetting { polylines_m: vec![line.clone()], ..PlaceSetting::default() }))
        .collect();
    let index = PlaceIndex::new(&PlaceSetting { polylines_m: lines, ..PlaceSetting::default() });
    for _ in 0..500 {
        let at = [chance() * 80.0 - 40.0, chance() * 80.0 - 40.0];
        let expected = all.iter().filter_map(|one| one.wall_distance(at)).min_by(f64::total_cmp);
        let found = index.wall_distance(at);
        let same = found == expected || found.zip(expected).is_some_and(|(one, other)| (one - other).abs() < 1e-9);
        assert!(same, "{at:?}: {found:?}, not {expected:?}");
    }
}

#[test]
fn numbers_that_are_not_finite_take_no_part() {
    let mut setting = setting(2);
    setting.place = PlaceSetting { polylines_m: vec![vec![[0.0, f64::NAN], [1.0, 1.0]]], ..PlaceSetting::default() };
    let index = PlaceIndex::new(&setting.place);
    let found = gaps(&setting, &index, &moment(vec![robot(1, f64::NAN, 0.0), robot(2, 0.0, 0.0)]));
    assert_eq!(found, Gaps::default());
}

fn path(robots: usize) -> Vec<(usize, usize)> {
    (1..robots).map(|node| (node - 1, node)).collect()
}

#[test]
fn connectivity_of_known_graphs() {
    for robots in [2_usize, 3, 5, 12] {
        let found = connectivity(robots, &path(robots));
        assert_eq!(found.components, 1);
        assert!(near(found.lambda2, 2.0 * (1.0 - (PI / robots as f64).cos())), "path of {robots}: {found:?}");
        let everybody: Vec<_> = (0..robots).flat_map(|one| (one + 1..robots).map(move |other| (one, other))).collect();
        assert!(near(connectivity(robots, &everybody).lambda2, robots as f64), "complete graph of {robots}");
    }
    let apart = connectivity(4, &[(0, 1), (2, 3)]);
    assert_eq!(apart, Connectivity { lambda2: Some(0.0), components: 2 });
    assert_eq!(connectivity(1, &[]), Connectivity { lambda2: None, components: 1 });
    assert_eq!(connectivity(0, &[]), Connectivity::default());
}

#[test]
fn only_those_who_hear_each_other_freshly_are_linked() {
    let hears = |id, peers: &[(u32, u64)]| {
        let heard = peers.iter().map(|(id, age_ms)| Heard { id: *id, age_ms: *age_ms, kept: false }).collect();
        RobotMoment { id, heard, ..RobotMoment::default() }
    };
    let robots = vec![
        hears(1, &[(2, 500), (3, 10), (9, 10)]),
        hears(2, &[(1, 0), (3, 501)]),
        hears(3, &[(2, 10), (4, 10)]),
        hears(4, &[(3, 10)]),
    ];
    assert_eq!(hearing(&setting(4), &moment(robots)), [(0, 1), (2, 3)]);
}

fn moving(id: u32, yaw_rad: f64, speed_mps: f64) -> RobotMoment {
    let place = Place { yaw_rad, ..Place::default() };
    RobotMoment { id, believed: Some(place), twist_b: [speed_mps, 0.0], ..RobotMoment::default() }
}

#[test]
fn velocity_order_is_the_length_of_the_mean_direction() {
    let order = |robots| velocity_order(&moment(robots));
    assert!(near(order(vec![moving(1, 0.3, 1.0), moving(2, 0.3, 0.1)]), 1.0), "speeds do not count");
    assert!(near(order(vec![moving(1, 0.0, 1.0), moving(2, PI, 1.0)]), 0.0));
    assert!(near(order(vec![moving(1, 0.0, 1.0), moving(2, PI, -1.0)]), 1.0), "one drives backwards");
    assert!(near(order(vec![moving(1, 0.0, 1.0), moving(2, FRAC_PI_2, 1.0)]), 0.5_f64.sqrt()));
    assert!(near(order(vec![moving(1, 0.0, 1.0), moving(2, PI, 0.01)]), 1.0), "one stands");
    assert_eq!(order(vec![moving(1, 0.0, 0.01)]), None);
}

fn scan(time_s: f64, ranges_m: Vec<Option<f64>>) -> ScanMoment {
    ScanMoment { time_s, angle_first_rad: 0.0, angle_step_rad: FRAC_PI_2, range_m_max: 2.0, ranges_m }
}

#[test]
fn coverage_counts_the_free_cells_that_beams_cross() {
    let mut setting = setting(1);
    setting.place.enclosure_m = vec![[0.0, 0.0], [4.0, 0.0], [4.0, 1.0], [0.0, 1.0]];
    let mut coverage = Coverage::new(&setting);
    assert_eq!(coverage.fraction(), Some(0.0));
    assert!((coverage.free_m2() - 4.0).abs() < 1e-9, "64 cells");
    let mut seer = robot(1, 0.1, 0.1);
    // East: 8 cells up to 2.1 m, and the one in which it ends. North: cut at 0.6 m: cells 0, 1, 2. West: no reading.
    seer.scan = Some(scan(1.0, vec![Some(CLEAR), Some(0.5), None]));
    coverage.add(&moment(vec![seer.clone()]));
    assert!(near(coverage.fraction(), (9.0 + 2.0) / 64.0), "{:?}", coverage.fraction());
    seer.scan = Some(scan(1.0, vec![None, None, None, None, Some(2.0), Some(0.9)]));
    coverage.add(&moment(vec![seer.clone()]));
    assert!(near(coverage.fraction(), 11.0 / 64.0), "the same scan again");
    seer.scan = Some(scan(2.0, vec![None, Some(5.0)]));
    coverage.add(&moment(vec![seer]));
    assert!(near(coverage.fraction(), 12.0 / 64.0), "one more cell to the north wall: {:?}", coverage.fraction());
}

#[test]
fn obstacles_are_no_area_and_without_a_place_there_is_no_coverage() {
    let mut setting = setting(1);
    setting.place = room();
    assert!((Coverage::new(&setting).free_m2() - 76.0).abs() < 1e-9, "80 m2 less a block of 4 m2");
    setting.place = PlaceSetting::default();
    let mut coverage = Coverage::new(&setting);
    let mut seer = robot(1, 0.0, 0.0);
    seer.scan = Some(scan(0.0, vec![Some(1.0)]));
    coverage.add(&moment(vec![seer]));
    assert_eq!(coverage.fraction(), None);
}
