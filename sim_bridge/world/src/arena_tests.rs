use super::*;
use crate::geometry::Disc;
use drover_config::{Circle, GridMap, Mount, Polygon, Polyline, SimMotion, load_world};
use drover_contract::math::sin_cos;
use drover_contract::{Beam, wrap};
use proptest::prelude::*;
use std::f64::consts::PI;
use std::path::Path;

#[path = "shapes_tests.rs"]
mod shapes;
use shapes::{assert_no_way_crosses, assert_nothing_overlaps, shapes};

const DT_S: f64 = 0.01;
const RADIUS_M: f64 = 0.25;

fn params(slip_std: f64) -> BodyParams {
    BodyParams {
        radius_m: RADIUS_M,
        track_m: 0.4,
        speed_mps_max: 50.0,
        yaw_rate_radps_max: 10.0,
        accel_mps2: 1.0,
        brake_mps2: 2.0,
        yaw_accel_radps2: 4.0,
        slip_std,
        motion: SimMotion::DiffDrive,
    }
}

fn spec(key: u64, start: Pose) -> BodySpec {
    let lidar = LidarParams {
        beams: 72,
        fov_rad: std::f64::consts::TAU,
        mount: Mount::default(),
        range_m_min: 0.1,
        range_m_max: 8.0,
        range_noise_m: 0.01,
        range_step_m: 0.0,
        beam_dropout: 0.01,
        sweep: false,
    };
    BodySpec { key, start, body: params(0.0), outline: None, lidar }
}

fn rectangle(enclosure: bool, [x0, y0]: [f64; 2], [x1, y1]: [f64; 2]) -> Polygon {
    Polygon { enclosure, points_m: vec![[x0, y0], [x1, y0], [x1, y1], [x0, y1]] }
}

fn world(polygons: Vec<Polygon>) -> World {
    World { name: "test".into(), polygons, circles: vec![], ..World::default() }
}

fn run(arena: &mut Arena, demands: &[Twist], steps: u32) {
    (0..steps).for_each(|_| arena.step(DT_S, demands));
}

#[test]
fn a_body_that_drives_into_a_wall_stands_at_it() {
    let room = world(vec![rectangle(true, [0.0, 0.0], [4.0, 4.0])]);
    let mut arena = Arena::new(&room, &[spec(1, Pose::new(1.0, 2.0, 0.0))], 1);
    assert!((arena.min_gap_wall_m().unwrap() - 0.75).abs() < 1e-12);
    run(&mut arena, &[Twist::new(1.0, 0.0)], 1000);
    let state = arena.state(0);
    assert!(state.in_contact && state.twist_b == Twist::ZERO);
    assert!((4.0 - RADIUS_M - TOUCH_M..4.0 - RADIUS_M).contains(&state.pose_wb.x_m), "{}", state.pose_wb.x_m);
    assert_eq!(arena.min_gap_wall_m(), Some(0.0), "a touch is a gap of 0");
}

#[test]
fn a_body_leaves_a_wall_that_it_touched_and_turns_on_the_spot_there() {
    let room = world(vec![rectangle(true, [0.0, 0.0], [4.0, 4.0])]);
    let mut arena = Arena::new(&room, &[spec(1, Pose::new(3.0, 2.0, 0.0))], 1);
    run(&mut arena, &[Twist::new(1.0, 0.0)], 300);
    assert!(arena.state(0).in_contact);
    run(&mut arena, &[Twist::new(0.0, 1.0)], 100);
    assert!(arena.state(0).pose_wb.yaw_rad > 0.5, "it turns");
    run(&mut arena, &[Twist::new(-1.0, 0.0)], 150);
    assert!(!arena.state(0).in_contact && arena.state(0).pose_wb.x_m < 3.3, "and leaves");
    assert_eq!(arena.gap_wall_m_min(0), Some(0.0), "but the touch is remembered");
}

#[test]
fn two_bodies_that_meet_head_on_both_stand() {
    let bodies = [spec(1, Pose::new(0.0, 0.0, 0.0)), spec(2, Pose::new(3.0, 0.0, PI))];
    let mut arena = Arena::new(&world(vec![]), &bodies, 1);
    assert!((arena.min_gap_robot_m().unwrap() - 2.5).abs() < 1e-12);
    run(&mut arena, &[Twist::new(1.0, 0.0); 2], 500);
    let gap_m = arena.state(1).pose_wb.x_m - arena.state(0).pose_wb.x_m - 2.0 * RADIUS_M;
    assert!((0.0..=TOUCH_M).contains(&gap_m), "{gap_m}");
    assert!((0..2).all(|robot| arena.state(robot).in_contact && arena.state(robot).twist_b == Twist::ZERO));
    assert_eq!((arena.gap_robot_m_min(0), arena.min_gap_robot_m()), (Some(0.0), Some(0.0)));
    assert_eq!(arena.min_gap_wall_m(), None);
}

#[test]
fn a_queue_of_bodies_closes_up_and_nobody_overlaps() {
    let room = world(vec![rectangle(true, [-1.0, -1.0], [10.0, 1.0])]);
    let bodies: Vec<_> = (0..8).map(|n| spec(n, Pose::new(n as f64 * 0.6, 0.0, 0.0))).collect();
    let mut arena = Arena::new(&room, &bodies, 1);
    run(&mut arena, &[Twist::new(3.0, 0.0); 8], 2000);
    for pair in arena.place.discs().windows(2) {
        let gap_m = pair[1].centre_w.x - pair[0].centre_w.x - 2.0 * RADIUS_M;
        assert!((0.0..=TOUCH_M).contains(&gap_m), "{gap_m}");
    }
}

#[test]
fn a_body_far_from_the_others_still_knows_its_gap() {
    let bodies = [(1, 0.0), (2, 1.0), (3, 500.0)].map(|(key, x_m)| spec(key, Pose::new(x_m, 0.0, 0.0)));
    let arena = Arena::new(&world(vec![]), &bodies, 1);
    assert_eq!(arena.gap_robot_m_min(2), Some(498.5));
    assert_eq!(arena.gap_robot_m_min(0), Some(0.5));
}

#[test]
fn missing_demands_mean_standing() {
    let bodies = [spec(1, Pose::default()), spec(2, Pose::new(3.0, 0.0, 0.0))];
    let mut arena = Arena::new(&world(vec![]), &bodies, 1);
    run(&mut arena, &[Twist::new(1.0, 0.0)], 50);
    assert!(arena.path_m(0) > 0.0);
    assert!(arena.path_m(1) < 1e-12);
}

#[test]
fn bodies_see_each_other_and_not_themselves() {
    let bodies = [spec(1, Pose::default()), spec(2, Pose::new(3.0, 0.0, 0.0))];
    let mut arena = Arena::new(&world(vec![]), &bodies, 1);
    let nearest_m = arena.cast(Stamp::ZERO, 0).nearest_m().unwrap();
    assert!((nearest_m - 2.75).abs() < 0.06, "{nearest_m}");
}

#[test]
fn bodies_that_overlap_at_first_may_only_move_apart() {
    let bodies = [spec(1, Pose::default()), spec(2, Pose::new(0.3, 0.0, 0.0))];
    let mut arena = Arena::new(&world(vec![]), &bodies, 1);
    run(&mut arena, &[Twist::new(1.0, 0.0)], 100);
    assert!(arena.path_m(0) < 1e-12, "towards the other: no");
    run(&mut arena, &[Twist::new(-1.0, 0.0)], 100);
    assert!(arena.path_m(0) > 0.3, "away from it: yes");
}

/// Bodies on a grid of places, so that none overlaps another at first; any headings, any demands.
fn crowd() -> impl Strategy<Value = Vec<(Pose, Twist)>> {
    let one = (any::<bool>(), -PI..PI, -40.0..40.0f64, -5.0..5.0f64);
    prop::collection::vec(one, 16).prop_map(|cells| {
        let place = |(n, (taken, yaw, speed, turn)): (usize, (bool, f64, f64, f64))| {
            let (x_m, y_m) = (0.6 + (n % 4) as f64 * 0.9, 0.6 + (n / 4) as f64 * 0.9);
            taken.then(|| (Pose::new(x_m, y_m, yaw), Twist::new(speed, turn)))
        };
        cells.into_iter().enumerate().filter_map(place).collect()
    })
}

fn hall() -> World {
    let thin = rectangle(false, [1.9499, 0.0], [1.9501, 1.0]);
    let circles = vec![Circle { centre_m: [3.9, 3.9], radius_m: 0.1 }];
    World {
        name: "hall".into(),
        polygons: vec![rectangle(true, [0.0, 0.0], [4.0, 4.0]), thin],
        circles,
        ..World::default()
    }
}

/// The same room with thin walls (polylines) between the places of a crowd.
fn hall_of_screens() -> World {
    let line = |points_m: &[[f64; 2]]| Polyline { points_m: points_m.to_vec() };
    let screens = line(&[[1.05, 0.0], [1.05, 1.95], [2.85, 1.95], [2.85, 3.2]]);
    let polylines = vec![screens, line(&[[1.9, 2.85], [2.0, 2.85]])];
    World { polylines, ..world(vec![rectangle(true, [0.0, 0.0], [4.0, 4.0])]) }
}

/// The same as a map of cells of 0.1 m: walls all around, a pillar, a wall of one cell, one that meets a corner.
fn hall_of_cells() -> World {
    let (width, height) = (42, 42);
    let solid = |(x, y): (usize, usize)| {
        let rim = x == 0 || y == 0 || x == width - 1 || y == height - 1;
        let wall = (x == 20 && (5..30).contains(&y)) || (y == 29 && (12..20).contains(&x)) || (x == 11 && y == 11);
        rim || wall || (x == 12 && y == 12)
    };
    let cells = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
    let map = GridMap {
        file: String::new(),
        unknown: drover_config::UnknownCells::Solid,
        resolution_m: 0.1,
        origin_m: [-0.1, -0.1],
        origin_yaw_rad: 0.0,
        width,
        height,
        solid: cells.map(solid).collect(),
    };
    World { map: Some(Arc::new(map)), ..world(vec![]) }
}

fn any_hall() -> impl Strategy<Value = World> {
    prop::sample::select(vec![hall(), hall_of_screens(), hall_of_cells()])
}

/// Corners of a body's outline; none: its disc.
type Corners = Vec<[f64; 2]>;

/// A disc, a box, a long bar, an uneven triangle: all within a body's disc.
fn outlines() -> Vec<Corners> {
    vec![
        vec![],
        vec![[0.2, -0.15], [0.2, 0.15], [-0.2, 0.15], [-0.2, -0.15]],
        vec![[0.24, -0.03], [0.24, 0.03], [-0.24, 0.03], [-0.24, -0.03]],
        vec![[0.25, 0.0], [-0.1, 0.2], [-0.05, -0.2]],
    ]
}

fn any_outlines() -> impl Strategy<Value = Vec<Corners>> {
    prop::collection::vec(prop::sample::select(outlines()), 1..4)
}

fn any_motion() -> impl Strategy<Value = SimMotion> {
    prop::sample::select(vec![SimMotion::DiffDrive, SimMotion::Point])
}

/// Bodies that reach any speed within a step or two, of some outlines in turn.
fn quick(crowd: &[(Pose, Twist)], outlines: &[Corners], motion: SimMotion, slip_std: f64) -> Vec<BodySpec> {
    let quick =
        BodyParams { accel_mps2: 400.0, brake_mps2: 400.0, yaw_accel_radps2: 200.0, motion, ..params(slip_std) };
    let of = |(n, (pose, _)): (usize, &(Pose, Twist))| BodySpec {
        body: quick,
        outline: Outline::new(&outlines[n % outlines.len()]).map(Arc::new),
        ..spec(n as u64, *pose)
    };
    crowd.iter().enumerate().map(of).collect()
}

fn demands_of(crowd: &[(Pose, Twist)]) -> Vec<Twist> {
    crowd.iter().map(|(_, demand)| *demand).collect()
}

/// Drive there for half of the steps and back for the other half; nothing may overlap or tunnel.
fn drive_there_and_back(
    arena: &mut Arena,
    specs: &[BodySpec],
    demands: &[Twist],
    dt_s: f64,
) -> Result<(), TestCaseError> {
    let back: Vec<Twist> = demands.iter().map(reversed).collect();
    for step in 0..60 {
        let before: Vec<Pose> = (0..specs.len()).map(|n| arena.state(n).pose_wb).collect();
        arena.step(dt_s, if step < 30 { demands } else { &back });
        assert_nothing_overlaps(arena.walls(), &shapes(arena, specs))?;
        for (n, from) in before.iter().enumerate() {
            assert_no_way_crosses(arena.walls(), *from, arena.state(n).pose_wb)?;
        }
    }
    Ok(())
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(96))]

    #[test]
    fn no_body_overlaps_or_tunnels_at_any_speed(
        hall in any_hall(), crowd in crowd(), outlines in any_outlines(),
        motion in any_motion(), dt_s in 0.001..0.05f64,
    ) {
        let specs = quick(&crowd, &outlines, motion, 0.1);
        let mut arena = Arena::new(&hall, &specs, 3);
        drive_there_and_back(&mut arena, &specs, &demands_of(&crowd), dt_s)?;
    }

    #[test]
    fn the_order_of_robots_changes_nothing(
        crowd in crowd(), outlines in any_outlines(), dt_s in 0.001..0.05f64,
    ) {
        let specs = quick(&crowd, &outlines, SimMotion::DiffDrive, 0.1);
        let demands = demands_of(&crowd);
        let (mut back_specs, mut back_demands) = (specs.clone(), demands.clone());
        back_specs.reverse();
        back_demands.reverse();
        let (mut a, mut b) = (Arena::new(&hall(), &specs, 3), Arena::new(&hall(), &back_specs, 3));
        for _ in 0..40 {
            a.step(dt_s, &demands);
            b.step(dt_s, &back_demands);
        }
        for n in 0..specs.len() {
            let m = specs.len() - 1 - n;
            prop_assert_eq!(a.state(n), b.state(m));
            prop_assert_eq!(a.gap_robot_m_min(n), b.gap_robot_m_min(m));
            prop_assert_eq!(a.cast(Stamp::ZERO, n), b.cast(Stamp::ZERO, m));
        }
    }

    #[test]
    fn bodies_in_a_narrow_corridor_never_change_places(
        speeds in prop::collection::vec((-45.0..45.0f64, -8.0..8.0f64, -3.0..3.0f64), 6),
        outlines in prop::collection::vec(prop::sample::select(outlines()[..2].to_vec()), 1..4),
        motion in any_motion(), dt_s in 0.001..0.05f64,
    ) {
        // 0.55 m wide: a disc of 0.5 m fits, two boxes of 0.3 m x 0.4 m do not fit beside each other however they turn.
        let corridor = world(vec![rectangle(true, [0.0, 0.0], [6.0, 0.55])]);
        let place = |(n, (speed, turn, yaw)): (usize, &(f64, f64, f64))| {
            (Pose::new(0.5 + n as f64, 0.275, *yaw), Twist::new(*speed, *turn))
        };
        let crowd: Vec<(Pose, Twist)> = speeds.iter().enumerate().map(place).collect();
        let specs = quick(&crowd, &outlines, motion, 0.1);
        let mut arena = Arena::new(&corridor, &specs, 3);
        drive_there_and_back(&mut arena, &specs, &demands_of(&crowd), dt_s)?;
        let x_m = |n: usize| arena.state(n).pose_wb.x_m;
        prop_assert!((1..specs.len()).all(|n| x_m(n - 1) < x_m(n)));
    }

    #[test]
    fn the_energy_of_a_coasting_body_never_grows_whatever_it_meets(
        hall in any_hall(), crowd in crowd(), outlines in any_outlines(),
        motion in any_motion(), dt_s in 0.001..0.05f64, lively in 1..30u32,
    ) {
        let slow = BodyParams { accel_mps2: 400.0, brake_mps2: 20.0, yaw_accel_radps2: 20.0, motion, ..params(0.0) };
        let specs: Vec<BodySpec> =
            quick(&crowd, &outlines, motion, 0.0).into_iter().map(|spec| BodySpec { body: slow, ..spec }).collect();
        let mut arena = Arena::new(&hall, &specs, 3);
        run(&mut arena, &demands_of(&crowd), lively);
        let twists = |arena: &Arena| (0..specs.len()).map(|n| arena.state(n).twist_b).collect::<Vec<_>>();
        let mut before = twists(&arena);
        for _ in 0..200 {
            arena.step(dt_s, &[]);
            let after = twists(&arena);
            for (was, is) in before.iter().zip(&after) {
                // Each on its own: no contact turns speed into turn or the other way round.
                prop_assert!(is.speed_mps.abs() <= was.speed_mps.abs(), "{was:?} -> {is:?}");
                prop_assert!(is.yaw_rate_radps.abs() <= was.yaw_rate_radps.abs(), "{was:?} -> {is:?}");
            }
            before = after;
        }
    }

    #[test]
    fn bodies_in_a_mirrored_hall_meet_as_their_mirror_images(
        crowd in crowd(), outlines in any_outlines(), motion in any_motion(),
        dt_s in 0.001..0.02f64,
    ) {
        let flip = |(pose, twist): &(Pose, Twist)| (mirrored(*pose), turned_over(*twist));
        let flipped: Vec<(Pose, Twist)> = crowd.iter().map(flip).collect();
        let images: Vec<Corners> = outlines.iter().map(image).collect();
        let (specs, image_specs) = (quick(&crowd, &outlines, motion, 0.0), quick(&flipped, &images, motion, 0.0));
        let mut arena = Arena::new(&hall_of_screens(), &specs, 3);
        let mut mirror = Arena::new(&mirrored_world(hall_of_screens()), &image_specs, 3);
        for step in 0..20 {
            arena.step(dt_s, &demands_of(&crowd));
            mirror.step(dt_s, &demands_of(&flipped));
            for n in 0..specs.len() {
                let (is, image) = (arena.state(n).pose_wb, mirrored(mirror.state(n).pose_wb));
                let apart_m = (is.position() - image.position()).norm();
                let turned_rad = wrap(is.yaw_rad - image.yaw_rad).abs();
                // Touching is decided at a ten-thousandth of a metre; rounding moves it by less than that.
                prop_assert!(apart_m < SKIN_M && turned_rad < 1e-3, "step {step}: {apart_m} m, {turned_rad} rad");
            }
        }
    }

    #[test]
    fn what_a_lidar_sees_of_bodies_is_what_rays_meet(
        crowd in crowd(), outlines in any_outlines(),
        mount in (-0.1..0.1f64, -0.1..0.1f64, -3.0..3.0f64),
    ) {
        prop_assume!(!crowd.is_empty());
        let (x_m, y_m, yaw_rad) = mount;
        let mut specs = quick(&crowd, &outlines, SimMotion::DiffDrive, 0.0);
        for spec in &mut specs {
            let exact = LidarParams { range_m_min: 0.0, range_noise_m: 0.0, beam_dropout: 0.0, ..spec.lidar };
            spec.lidar = LidarParams { mount: Mount { x_m, y_m, yaw_rad }, ..exact };
        }
        let mut arena = Arena::new(&world(vec![]), &specs, 3);
        let scan = arena.cast(Stamp::ZERO, 0);
        let body_wb = specs[0].start;
        let (sensor_w, heading_rad) = (body_wb.transform(Vec2::new(x_m, y_m)), body_wb.yaw_rad + yaw_rad);
        let others = &shapes(&arena, &specs)[1..];
        for (index, beam) in scan.beams.iter().enumerate() {
            let nearest_m = |nudge_rad: f64| {
                let (sin, cos) = sin_cos(heading_rad + scan.angle_rad(index) + nudge_rad);
                let met = others.iter().filter_map(|shape| shape.ray_m(sensor_w, Vec2::new(cos, sin)));
                met.fold(f64::INFINITY, f64::min)
            };
            let seen_m = if let Beam::Hit(range_m) = beam { *range_m } else { f64::INFINITY };
            let is = |ray_m: f64| (ray_m > 8.0 - 1e-3 && seen_m > 8.0 - 2e-3) || (ray_m - seen_m).abs() < 1e-3;
            // A beam that grazes may see either side of an edge: it then agrees with a ray turned by a hair.
            let rays = [0.0, 1e-5, -1e-5].map(nearest_m);
            prop_assert!(rays.into_iter().any(is), "beam {index}: {beam:?}, rays {rays:?}");
        }
    }
}

fn reversed(twist: &Twist) -> Twist {
    Twist::new(-twist.speed_mps, twist.yaw_rate_radps)
}

fn turned_over(twist: Twist) -> Twist {
    Twist::new(twist.speed_mps, -twist.yaw_rate_radps)
}

fn mirrored(pose: Pose) -> Pose {
    Pose::new(pose.x_m, -pose.y_m, -pose.yaw_rad)
}

fn image(corners: &Corners) -> Corners {
    corners.iter().rev().map(|[x, y]| [*x, -*y]).collect()
}

fn mirrored_world(mut world: World) -> World {
    let flip = |point: &mut [f64; 2]| point[1] = -point[1];
    world.polygons.iter_mut().flat_map(|polygon| &mut polygon.points_m).for_each(flip);
    world.polylines.iter_mut().flat_map(|line| &mut line.points_m).for_each(flip);
    world
}

/// Thirty bodies, each at the first free place of a low-discrepancy sequence over the world's extent.
fn scattered(walls: &Walls) -> Vec<(Pose, Twist)> {
    let ends = || walls.segments().iter().flat_map(|segment| [segment.from_w, segment.to_w]);
    let low = ends().fold(Vec2::repeat(f64::INFINITY), |low, end| low.inf(&end));
    let high = ends().fold(Vec2::repeat(f64::NEG_INFINITY), |high, end| high.sup(&end));
    let mut crowd: Vec<(Pose, Twist)> = Vec::new();
    for n in 1..4000 {
        let share = |step: f64| (f64::from(n) * step).fract();
        let place = low + Vec2::new(share(0.754_877_666), share(0.569_840_291)).component_mul(&(high - low));
        let free = walls.gap_m(&Disc { centre_w: place, radius_m: RADIUS_M }).is_none_or(|gap_m| gap_m > 1e-3);
        let apart = crowd.iter().all(|(pose, _)| (pose.position() - place).norm() > 2.0 * RADIUS_M + 1e-3);
        if free && apart && crowd.len() < 30 {
            let demand = Twist::new(share(0.31) * 90.0 - 45.0, share(0.17) * 12.0 - 6.0);
            crowd.push((Pose::new(place.x, place.y, share(0.43) * 6.0), demand));
        }
    }
    crowd
}

#[test]
fn no_body_overlaps_or_tunnels_in_any_generated_world_at_any_speed() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../config/worlds/generated");
    let entries = std::fs::read_dir(folder).expect("a folder");
    let files: Vec<_> = entries.map(|entry| entry.expect("a file").path()).collect();
    assert!(files.len() >= 10, "too few worlds");
    for file in files {
        let world = load_world(&file).unwrap_or_else(|problems| panic!("{problems}"));
        let crowd = scattered(&Walls::new(&world));
        assert!(crowd.len() >= 20, "{}: {} bodies", file.display(), crowd.len());
        for (motion, dt_s) in [(SimMotion::DiffDrive, 0.05), (SimMotion::Point, 0.02)] {
            let specs = quick(&crowd, &outlines(), motion, 0.1);
            let mut arena = Arena::new(&world, &specs, 3);
            if let Err(error) = drive_there_and_back(&mut arena, &specs, &demands_of(&crowd), dt_s) {
                panic!("{}: {error}", file.display());
            }
            let touched = (0..specs.len()).filter(|n| arena.gap_wall_m_min(*n) == Some(0.0)).count();
            assert!(touched >= 5, "{}: {touched} met a wall", file.display());
        }
    }
}
