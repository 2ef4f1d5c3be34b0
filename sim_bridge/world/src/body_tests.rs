use super::*;
use proptest::prelude::*;

fn params() -> BodyParams {
    BodyParams {
        radius_m: 0.25,
        track_m: 0.4,
        speed_mps_max: 2.0,
        yaw_rate_radps_max: 3.0,
        accel_mps2: 1.0,
        brake_mps2: 2.0,
        yaw_accel_radps2: 4.0,
        slip_std: 0.0,
        motion: SimMotion::DiffDrive,
    }
}

fn drive(body: &mut Body, demand: Twist, dt_s: f64, steps: u32) {
    for _ in 0..steps {
        let motion = body.plan(demand, dt_s);
        body.carry_out(&motion, 1.0);
    }
}

#[test]
fn a_body_speeds_up_and_brakes_at_its_limits() {
    let mut body = Body::new(params(), Pose::default(), 1, 1);
    drive(&mut body, Twist::new(1.0, 0.0), 0.01, 50);
    assert!((body.twist_b().speed_mps - 0.5).abs() < 1e-9);
    drive(&mut body, Twist::new(1.0, 0.0), 0.01, 50);
    assert!((body.twist_b().speed_mps - 1.0).abs() < 1e-9);
    assert!((body.pose_wb().x_m - 0.5).abs() < 1e-9, "v^2 / (2 a) = {}", body.pose_wb().x_m);
    drive(&mut body, Twist::ZERO, 0.01, 25);
    assert!((body.twist_b().speed_mps - 0.5).abs() < 1e-9);
    drive(&mut body, Twist::ZERO, 0.01, 25);
    assert!((body.pose_wb().x_m - 0.75).abs() < 1e-9, "v^2 / (2 brake) further = {}", body.pose_wb().x_m);
}

#[test]
fn turning_back_brakes_first_and_then_speeds_up() {
    let mut body = Body::new(params(), Pose::default(), 1, 1);
    drive(&mut body, Twist::new(0.5, 0.0), 0.01, 100);
    drive(&mut body, Twist::new(-0.5, 0.0), 0.1, 3);
    // 0.25 s of braking from 0.5 m/s at 2 m/s^2, then 0.05 s of speeding up at 1 m/s^2.
    assert!((body.twist_b().speed_mps + 0.05).abs() < 1e-9, "{}", body.twist_b().speed_mps);
}

#[test]
fn a_step_that_ends_just_as_the_body_stands_leaves_it_standing() {
    // Speeds that one step of braking brings to 0 but for rounding.
    for n in 1..10_000 {
        let (dt_s, brake_mps2) = (f64::from(n) * 1e-5, 420.0);
        for now_mps in [brake_mps2 * dt_s, (brake_mps2 * dt_s).next_down()] {
            assert!(approach_speed(now_mps, -1.0, (400.0, brake_mps2), dt_s).abs() < 1e-9);
        }
    }
}

#[test]
fn a_demand_that_is_not_finite_is_a_stop() {
    let mut body = Body::new(params(), Pose::default(), 1, 1);
    drive(&mut body, Twist::new(1.0, 1.0), 0.01, 100);
    drive(&mut body, Twist::new(f64::NAN, 1.0), 0.01, 100);
    assert_eq!(body.twist_b(), Twist::ZERO);
}

#[test]
fn a_circle_at_constant_twist_closes() {
    let mut body = Body::new(params(), Pose::default(), 1, 1);
    drive(&mut body, Twist::new(1.0, 0.5), 0.01, 200);
    let start = body.pose_wb();
    let turns_s = std::f64::consts::TAU / 0.5;
    drive(&mut body, Twist::new(1.0, 0.5), turns_s / 1000.0, 1000);
    assert!((body.pose_wb().position() - start.position()).norm() < 1e-9);
}

#[test]
fn wheels_measure_what_they_roll_and_the_body_goes_where_they_slip() {
    let slippery = BodyParams { slip_std: 0.05, ..params() };
    let mut body = Body::new(slippery, Pose::default(), 7, 1);
    drive(&mut body, Twist::new(1.0, 0.0), 0.01, 1000);
    let WheelTravel { left_m, right_m } = body.wheels();
    assert!((left_m - right_m).abs() < 1e-9 && (left_m - 9.5).abs() < 1e-6, "{left_m} {right_m}");
    assert!(body.pose_wb().yaw_rad.abs() > 1e-3, "slip turns the body: {:?}", body.pose_wb());
    assert!((body.path_m() - left_m).abs() < 0.5, "but it goes about as far: {}", body.path_m());
}

#[test]
fn a_standing_body_does_not_creep_however_much_its_wheels_slip() {
    let mut body = Body::new(BodyParams { slip_std: 0.5, ..params() }, Pose::default(), 7, 1);
    drive(&mut body, Twist::ZERO, 0.01, 1000);
    assert_eq!((body.pose_wb(), body.twist_b(), body.path_m()), (Pose::default(), Twist::ZERO, 0.0));
}

#[test]
fn a_contact_stops_the_body_and_its_wheels() {
    let mut body = Body::new(params(), Pose::default(), 1, 1);
    drive(&mut body, Twist::new(1.0, 0.2), 0.01, 100);
    let motion = body.plan(Twist::new(1.0, 0.2), 0.01);
    body.carry_out(&motion, 0.5);
    assert_eq!((body.twist_b(), body.wheel_twist_b()), (Twist::ZERO, Twist::ZERO));
}

proptest! {
    #[test]
    fn a_body_stops_within_its_braking_distance_and_one_step(
        speed_mps in -2.0..2.0f64, yaw_rate_radps in -3.0..3.0f64, dt_s in 0.001..0.05f64
    ) {
        let mut body = Body::new(params(), Pose::default(), 1, 1);
        drive(&mut body, Twist::new(speed_mps, yaw_rate_radps), dt_s, 5000);
        let (speed, before_m) = (body.twist_b().speed_mps, body.path_m());
        drive(&mut body, Twist::ZERO, dt_s, 5000);
        prop_assert_eq!(body.twist_b(), Twist::ZERO);
        let bound_m = speed * speed / (2.0 * params().brake_mps2) + speed.abs() * dt_s;
        prop_assert!(body.path_m() - before_m <= bound_m + 1e-9);
    }

    #[test]
    fn the_energy_of_a_coasting_body_never_grows(
        speed_mps in -2.0..2.0f64, yaw_rate_radps in -3.0..3.0f64, dt_s in 0.001..0.05f64, slip_std in 0.0..0.3f64
    ) {
        let mut body = Body::new(BodyParams { slip_std, ..params() }, Pose::default(), 1, 1);
        drive(&mut body, Twist::new(speed_mps, yaw_rate_radps), dt_s, 300);
        let energy = |twist: Twist| twist.speed_mps.powi(2) + twist.yaw_rate_radps.powi(2);
        for _ in 0..300 {
            let before = body.wheel_twist_b();
            drive(&mut body, Twist::ZERO, dt_s, 1);
            prop_assert!(energy(body.wheel_twist_b()) <= energy(before));
        }
    }
}
