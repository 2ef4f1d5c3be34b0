use super::*;
use drover_config::{Circle, Mount, Polygon, SimMotion};
use drover_contract::Vec2;
use proptest::prelude::*;
use std::f64::consts::PI;

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
    World { name: "hall".into(), polygons: vec![rectangle(true, [0.0, 0.0], [4.0, 4.0]), thin], circles, ..World::default() }
}

fn quick_specs(crowd: &[(Pose, Twist)]) -> Vec<BodySpec> {
    let quick = BodyParams { radius_m: RADIUS_M, accel_mps2: 400.0, brake_mps2: 400.0, ..params(0.1) };
    crowd.iter().enumerate().map(|(n, (pose, _))| BodySpec { body: quick, ..spec(n as u64, *pose) }).collect()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn no_body_overlaps_or_tunnels_at_any_speed(crowd in crowd(), dt_s in 0.001..0.05f64) {
        let specs = quick_specs(&crowd);
        let mut arena = Arena::new(&hall(), &specs, 3);
        let demands: Vec<Twist> = crowd.iter().map(|(_, demand)| *demand).collect();
        for step in 0..60 {
            let turned: Vec<Twist> = if step < 30 { demands.clone() } else { demands.iter().map(reversed).collect() };
            let before: Vec<Vec2> = arena.place.discs().iter().map(|disc| disc.centre_w).collect();
            arena.step(dt_s, &turned);
            for (n, disc) in arena.place.discs().iter().enumerate() {
                let gap_m = arena.walls().gap_m(disc).unwrap();
                prop_assert!(gap_m > 0.0, "robot {n} overlaps a wall by {gap_m} (from {})", before[n]);
                for (m, other) in arena.place.discs().iter().enumerate().skip(n + 1) {
                    let gap_m = (disc.centre_w - other.centre_w).norm() - 2.0 * RADIUS_M;
                    prop_assert!(gap_m > 0.0, "robots {n} and {m} overlap by {gap_m}");
                }
            }
            // The thin wall reaches to y = 1: who is below that stays on the side where it was.
            for (was, is) in before.iter().zip(arena.place.discs()) {
                let crossed = (was.x - 1.95) * (is.centre_w.x - 1.95) < 0.0;
                let below = was.y < 1.0 && is.centre_w.y < 1.0;
                prop_assert!(!(crossed && below && arc_stays_below(was, &is.centre_w)), "{was} -> {}", is.centre_w);
            }
        }
    }

    #[test]
    fn the_order_of_robots_changes_nothing(crowd in crowd(), dt_s in 0.001..0.05f64) {
        let specs = quick_specs(&crowd);
        let demands: Vec<Twist> = crowd.iter().map(|(_, demand)| *demand).collect();
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
}

fn reversed(twist: &Twist) -> Twist {
    Twist::new(-twist.speed_mps, twist.yaw_rate_radps)
}

/// Steps are at most 2 m long, and the arc between two points that are well below the wall's end does not pass over it.
fn arc_stays_below(was: &Vec2, is: &Vec2) -> bool {
    was.y < 0.7 && is.y < 0.7 && (was - is).norm() < 0.6
}
