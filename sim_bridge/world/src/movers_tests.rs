use super::*;
use crate::arena::{Arena, BodySpec};
use crate::body::BodyParams;
use crate::geometry::Outline;
use crate::lidar::LidarParams;
use crate::sweep::TOUCH_M;
use drover_config::{Mount, Polygon, SimMotion, World};
use drover_contract::{Beam, Pose, Stamp, Twist};
use proptest::prelude::*;
use std::sync::Arc;

const DT_S: f64 = 0.01;
const RADIUS_M: f64 = 0.25;

fn spec(start: Pose, outline: Option<Outline>) -> BodySpec {
    let body = BodyParams {
        radius_m: RADIUS_M,
        track_m: 0.4,
        speed_mps_max: 50.0,
        yaw_rate_radps_max: 10.0,
        accel_mps2: 10.0,
        brake_mps2: 10.0,
        yaw_accel_radps2: 40.0,
        slip_std: 0.0,
        motion: SimMotion::DiffDrive,
    };
    let lidar = LidarParams {
        beams: 8,
        fov_rad: std::f64::consts::TAU,
        mount: Mount::default(),
        range_m_min: 0.1,
        range_m_max: 8.0,
        range_noise_m: 0.0,
        range_step_m: 0.0,
        beam_dropout: 0.0,
        sweep: false,
    };
    BodySpec { key: 1, start, body, outline: outline.map(Arc::new), lidar }
}

fn mover(waypoints_m: &[[f64; 2]], speed_mps: f64, loops: bool) -> drover_config::Mover {
    drover_config::Mover { radius_m: 0.4, waypoints_m: waypoints_m.to_vec(), speed_mps, loops }
}

/// A mover that goes from x = 0 to x = 10 m and back, and bodies around it.
fn to_and_fro(speed_mps: f64, bodies: &[BodySpec]) -> Arena {
    let movers = vec![mover(&[[0.0, 0.0], [10.0, 0.0]], speed_mps, false)];
    Arena::new(&World { movers, ..World::default() }, bodies, 1)
}

fn run(arena: &mut Arena, demand: Twist, steps: u32) {
    (0..steps).for_each(|_| arena.step(DT_S, &[demand]));
}

fn centre_w(arena: &Arena) -> Vec2 {
    arena.place().movers()[0].disc().centre_w
}

/// Where a mover is after each of these times, s.
fn after(mover: &drover_config::Mover, times_s: &[f64]) -> Vec<[f64; 2]> {
    let place = |time_s: &f64| {
        let mut mover = Mover::new(mover);
        (0..(time_s / DT_S).round() as u32).for_each(|_| mover.go(DT_S));
        [mover.disc.centre_w.x, mover.disc.centre_w.y].map(|along_m| (along_m * 1e6).round() / 1e6 + 0.0)
    };
    times_s.iter().map(place).collect()
}

#[test]
fn a_mover_goes_to_and_fro_or_around() {
    let corner = [[0.0, 0.0], [3.0, 0.0], [3.0, 4.0]];
    let times_s = [0.0, 1.0, 5.0, 7.0, 8.0, 12.0, 14.0, 15.0];
    let fro = [[0.0, 0.0], [1.0, 0.0], [3.0, 2.0], [3.0, 4.0], [3.0, 3.0], [2.0, 0.0], [0.0, 0.0], [1.0, 0.0]];
    assert_eq!(after(&mover(&corner, 1.0, false), &times_s), fro);
    let around = [[0.0, 0.0], [1.0, 0.0], [3.0, 2.0], [3.0, 4.0], [2.4, 3.2], [0.0, 0.0], [2.0, 0.0], [3.0, 0.0]];
    assert_eq!(after(&mover(&corner, 1.0, true), &times_s), around);
}

#[test]
fn a_step_longer_than_the_way_goes_around_it() {
    let mut mover = Mover::new(&mover(&[[0.0, 0.0], [1.0, 0.0]], 20.0, false));
    mover.go(0.135);
    assert!((mover.disc.centre_w - Vec2::new(0.7, 0.0)).norm() < 1e-9, "2.7 m: there, back, and 0.7 m there again");
}

#[test]
fn a_way_that_leads_nowhere_is_none() {
    let mut mover = Mover::new(&mover(&[[1.0, 2.0], [1.0, 2.0]], 1.0, true));
    mover.go(1.0);
    assert_eq!((mover.disc.centre_w, mover.velocity_mps_w), (Vec2::new(1.0, 2.0), Vec2::zeros()));
}

#[test]
fn a_mover_waits_for_a_robot_in_its_way_and_goes_on_when_it_has_left() {
    let mut arena = to_and_fro(0.5, &[spec(Pose::new(3.0, 0.0, 1.5), None)]);
    run(&mut arena, Twist::ZERO, 2_000);
    let gap_m = 3.0 - RADIUS_M - 0.4 - centre_w(&arena).x;
    assert!((GAP_M..GAP_M + 0.5 * DT_S).contains(&gap_m), "{gap_m}");
    assert_eq!(arena.place().movers()[0].velocity_mps_w(), Vec2::zeros());
    assert!(!arena.state(0).in_contact && arena.gap_wall_m_min(0).is_some_and(|gap_m| gap_m > TOUCH_M));
    let stays = arena.state(0).pose_wb == Pose::new(3.0, 0.0, 1.5);
    assert!(stays, "nobody pushes it");
    run(&mut arena, Twist::new(1.0, 0.0), 300);
    assert!(centre_w(&arena).x > 3.0, "{}", centre_w(&arena));
    assert!((arena.place().movers()[0].velocity_mps_w() - Vec2::new(0.5, 0.0)).norm() < 1e-9);
}

#[test]
fn no_speed_takes_a_mover_through_a_robot() {
    let mut arena = to_and_fro(20.0, &[spec(Pose::new(3.0, 0.0, 0.0), None)]);
    for _ in 0..100 {
        arena.step(0.1, &[]);
        assert!(centre_w(&arena).x < 3.0 - RADIUS_M - 0.4, "{}", centre_w(&arena));
    }
}

#[test]
fn a_lidar_sees_a_mover_where_it_is() {
    let mut arena = to_and_fro(1.0, &[spec(Pose::new(2.0, -2.0, 0.0), None)]);
    let left = |arena: &mut Arena| arena.cast(Stamp::ZERO, 0).beams[2];
    assert_eq!(left(&mut arena), Beam::Clear);
    run(&mut arena, Twist::ZERO, 200);
    let Beam::Hit(range_m) = left(&mut arena) else { panic!("it is just there") };
    assert!((range_m - 1.6).abs() < 1e-5, "{range_m}");
    let ahead = |arena: &mut Arena| arena.cast(Stamp::ZERO, 0).beams[1];
    assert_eq!(ahead(&mut arena), Beam::Clear);
    run(&mut arena, Twist::ZERO, 200);
    let Beam::Hit(range_m) = ahead(&mut arena) else { panic!("it has gone on to the north-east") };
    assert!((range_m - (8.0_f64.sqrt() - 0.4)).abs() < 1e-5, "{range_m}");
}

#[test]
fn a_body_that_drives_into_a_mover_is_stopped_by_it() {
    let mut arena = to_and_fro(0.5, &[spec(Pose::new(5.0, 0.0, std::f64::consts::PI), None)]);
    run(&mut arena, Twist::new(1.0, 0.0), 1_000);
    let gap_m = arena.state(0).pose_wb.x_m - RADIUS_M - 0.4 - centre_w(&arena).x;
    assert!((0.0..=TOUCH_M).contains(&gap_m), "{gap_m}");
    assert!(arena.state(0).in_contact && arena.state(0).twist_b == Twist::ZERO);
    assert_eq!((arena.min_gap_wall_m(), arena.min_gap_robot_m()), (Some(0.0), None), "it is no robot");
    run(&mut arena, Twist::new(-1.0, 0.0), 50);
    assert!(!arena.state(0).in_contact, "it can leave");
}

#[test]
fn a_mover_leaves_a_robot_that_has_driven_into_it() {
    // Onto the mover from behind: what it goes away from is not in its way.
    let mut arena = to_and_fro(0.5, &[spec(Pose::new(-2.0, 0.0, 0.0), None)]);
    run(&mut arena, Twist::new(5.0, 0.0), 200);
    assert_eq!(arena.min_gap_wall_m(), Some(0.0));
    assert!((centre_w(&arena).x - 1.0).abs() < 1e-9, "{}", centre_w(&arena));
}

#[test]
fn the_smallest_gap_to_a_mover_that_passes_is_a_gap_to_a_wall() {
    for outline in [None, Outline::new(&[[0.2, 0.1], [-0.2, 0.1], [-0.2, -0.1], [0.2, -0.1]])] {
        let half_m = if outline.is_some() { 0.1 } else { RADIUS_M };
        let mut arena = to_and_fro(2.0, &[spec(Pose::new(5.0, 1.0, 0.0), outline)]);
        let first_m = arena.gap_wall_m_min(0).expect("there is a mover");
        assert!(first_m > 4.0, "{first_m}");
        run(&mut arena, Twist::ZERO, 400);
        let smallest_m = arena.gap_wall_m_min(0).expect("there is a mover");
        assert!((smallest_m - (1.0 - 0.4 - half_m)).abs() < 1e-9, "{smallest_m}");
        assert_eq!(arena.movers().collect::<Vec<_>>(), [(centre_w(&arena), 0.4)]);
    }
}

#[test]
fn points_that_glide_stop_movers_too() {
    let mut arena = to_and_fro(1.0, &[spec(Pose::new(3.0, 0.0, 0.0), None)]);
    (0..1_000).for_each(|_| arena.glide(DT_S, &[Pose::new(3.0, 0.0, 0.0)]));
    assert!(centre_w(&arena).x < 3.0 - RADIUS_M - 0.4);
    (0..1_000).for_each(|_| arena.glide(DT_S, &[Pose::new(3.0, 5.0, 0.0)]));
    assert!(centre_w(&arena).x > 5.0);
}

/// A hall of 6 m with four movers that cross everywhere, in between bodies on a grid of places.
fn hall(bodies: &[(Pose, bool)]) -> Arena {
    let corners = vec![[-1.0, -1.0], [5.0, -1.0], [5.0, 5.0], [-1.0, 5.0]];
    let movers = vec![
        mover(&[[-0.5, -0.5], [4.5, 4.5]], 3.0, false),
        mover(&[[4.5, -0.5], [-0.5, 4.5]], 0.3, false),
        mover(&[[1.5, -0.5], [1.5, 4.5], [4.5, 2.5]], 1.0, true),
        mover(&[[-0.5, 2.5], [4.5, 2.5]], 15.0, false),
    ];
    let polygons = vec![Polygon { enclosure: true, points_m: corners }];
    let outline = || Outline::new(&[[0.2, 0.1], [-0.2, 0.1], [-0.2, -0.1], [0.2, -0.1]]);
    let bodies: Vec<BodySpec> =
        bodies.iter().map(|(start, shaped)| spec(*start, shaped.then(outline).flatten())).collect();
    Arena::new(&World { polygons, movers, ..World::default() }, &bodies, 1)
}

/// Bodies that start clear of all movers; any headings, any demands.
fn crowd() -> impl Strategy<Value = Vec<(Pose, bool, Twist)>> {
    let one = (any::<bool>(), any::<bool>(), -3.0..3.0f64, -20.0..20.0f64, -5.0..5.0f64);
    prop::collection::vec(one, 9).prop_map(|cells| {
        let place = |(n, (taken, shaped, yaw, speed, turn)): (usize, (bool, bool, f64, f64, f64))| {
            let start = Pose::new(0.5 + (n % 3) as f64 * 1.3, 0.6 + (n / 3) as f64 * 1.1, yaw);
            taken.then(|| (start, shaped, Twist::new(speed, turn)))
        };
        cells.into_iter().enumerate().filter_map(place).collect()
    })
}

/// Everything that is anywhere, to the last bit.
fn places(arena: &Arena) -> Vec<[u64; 3]> {
    let bits = |[a, b, c]: [f64; 3]| [a.to_bits(), b.to_bits(), c.to_bits()];
    let bodies = (0..arena.robot_count()).map(|robot| arena.state(robot).pose_wb);
    let movers = arena.movers().map(|(centre_w, radius_m)| bits([centre_w.x, centre_w.y, radius_m]));
    bodies.map(|pose| bits([pose.x_m, pose.y_m, pose.yaw_rad])).chain(movers).collect()
}

fn overlap(arena: &Arena) -> bool {
    let place = arena.place();
    (0..arena.robot_count()).any(|robot| place.wall_gap_m(robot, place.pose_wb(robot)).is_none_or(|gap_m| gap_m <= 0.0))
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn nobody_and_no_mover_ever_overlaps_and_one_start_has_one_future(crowd in crowd(), dt_s in 0.002..0.05f64) {
        let bodies: Vec<(Pose, bool)> = crowd.iter().map(|(start, shaped, _)| (*start, *shaped)).collect();
        let demands: Vec<Twist> = crowd.iter().map(|(.., demand)| *demand).collect();
        let (mut arena, mut again) = (hall(&bodies), hall(&bodies));
        for _ in 0..200 {
            arena.step(dt_s, &demands);
            again.step(dt_s, &demands);
            prop_assert!(!overlap(&arena));
        }
        prop_assert_eq!(places(&arena), places(&again));
    }
}
