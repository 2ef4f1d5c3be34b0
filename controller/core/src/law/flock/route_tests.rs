use super::*;
use crate::estimate::Motion;
use crate::testing::{SimBody, limits};
use drover_contract::{Pose, Stamp};

fn step(route: &mut Route, pose_wb: Pose) -> Twist {
    let limits = limits();
    let motion = Motion { pose_wb, twist_b: Twist::ZERO, accel_mps2: 0.0, pos_bound_m: 0.0 };
    route.see(pose_wb.position());
    let view = View {
        now: Stamp::ZERO,
        dt_s: 0.05,
        motion,
        neighbours: &[],
        walls_b: &[],
        points_b: &[],
        unseen_b: &[],
        scan: None,
        bodies: &[],
        discs: &[],
        limits: &limits,
    };
    route.pursue(0.8, &view)
}

fn route(points: &[(f64, f64)]) -> Route {
    Route::new(0.4, 1.2, points.iter().map(|(x, y)| Vec2::new(*x, *y)).collect())
}

#[test]
fn a_point_straight_ahead_is_driven_to_at_cruising_speed() {
    assert_eq!(step(&mut route(&[(10.0, 0.0)]), Pose::default()), Twist::new(0.8, 0.0));
}

#[test]
fn a_point_behind_is_turned_to_in_place() {
    let twist = step(&mut route(&[(-10.0, 1.0)]), Pose::default());
    assert!(twist.speed_mps == 0.0 && twist.yaw_rate_radps > 0.0, "{twist:?}");
}

#[test]
fn the_leader_stays_on_its_legs_and_stops_at_the_last_point() {
    let mut route = route(&[(8.0, 0.0), (8.0, 8.0)]);
    let mut body = SimBody { pose_wb: Pose::new(0.0, 0.0, 0.5), twist_b: Twist::ZERO, radius_m: 0.4 };
    let mut off_m: f64 = 0.0;
    let mut progress = 0.0;
    for _ in 0..800 {
        let asked = step(&mut route, body.pose_wb);
        body.step(asked, 0.05);
        let (x, y) = (body.pose_wb.x_m, body.pose_wb.y_m);
        off_m = off_m.max(y.abs().min((x - 8.0).abs()));
        assert!(route.progress() + 1e-3 >= progress, "progress falls");
        progress = route.progress();
    }
    assert!(off_m < 0.6, "{off_m} m off the legs");
    assert!(route.reached() && body.twist_b == Twist::ZERO);
    assert!((body.pose_wb.position() - Vec2::new(8.0, 8.0)).norm() < 0.45);
    assert!((route.progress() - 1.0).abs() < 1e-12);
}

#[test]
fn without_points_the_leader_has_reached_and_stands() {
    let mut route = route(&[]);
    assert_eq!(step(&mut route, Pose::default()), Twist::ZERO);
    assert!(route.reached());
}

#[test]
fn points_in_one_place_do_not_confuse_it() {
    let mut route = route(&[(0.0, 0.0), (0.0, 0.0), (5.0, 0.0), (5.0, 0.0)]);
    let twist = step(&mut route, Pose::default());
    assert!(twist.is_finite() && twist.speed_mps > 0.0);
    assert!(route.progress().is_finite());
}
