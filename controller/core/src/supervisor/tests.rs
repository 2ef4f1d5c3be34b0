use super::conditions::{DriveFact, Freshness, RequestFact};
use super::*;
use crate::estimate::Motion;
use crate::peers::Body;
use crate::sight::{Matches, Surroundings};
use crate::testing::{Chance, Place, SimBody, limits};
use drover_contract::{Beam, Pose, Scan, Stamp, Vec2};
use proptest::prelude::*;

const FIT: Conditions = Conditions {
    drive: DriveFact::Ready,
    scan: Freshness::Fresh,
    blind: false,
    odometry: Freshness::Fresh,
    pose: Freshness::Fresh,
    late: false,
    request: RequestFact::Finite,
};
const FORWARD: Twist = Twist::new(0.5, 0.0);

fn params() -> GuardParams {
    GuardParams { limits: limits(), radius_m: 0.4, margin_m: 0.15, latency_s: 0.1, tick_s: 0.05 }
}

fn supervisor() -> Supervisor {
    Supervisor::new(params())
}

/// One whose command before was to drive forward.
fn cruising() -> Supervisor {
    let mut supervisor = supervisor();
    supervisor.tick(&FIT, Some(FORWARD), FORWARD, &Obstacles::default(), &mut Scratch::default());
    supervisor
}

fn motion(pose_wb: Pose, twist_b: Twist) -> Motion {
    Motion { pose_wb, twist_b, accel_mps2: 0.0, pos_bound_m: 0.0 }
}

fn around(place: &Place, pose_wb: Pose, twist_b: Twist) -> Obstacles {
    let scan = place.scan(pose_wb, Stamp::ZERO);
    let motion = motion(pose_wb, twist_b);
    obstacles_of(&surroundings(&scan, &motion, Stamp::ZERO), &motion, &[], params().keep_m(), false)
}

fn surroundings(scan: &Scan, motion: &Motion, now: Stamp) -> Surroundings {
    let mut seen = Surroundings::default();
    seen.look(scan, &nalgebra::Isometry2::identity(), motion, now);
    seen
}

fn obstacles_of(seen: &Surroundings, motion: &Motion, bodies: &[Body], keep_m: f64, unheard: bool) -> Obstacles {
    let mut matches = Matches::default();
    matches.find(seen, motion, bodies);
    let mut obstacles = Obstacles::default();
    let peers = Peers { bodies, matches: &matches, own_bound_m: motion.pos_bound_m, unheard };
    obstacles.fill(seen, &peers, keep_m, 100.0);
    obstacles
}

#[test]
fn with_everything_in_order_the_request_reaches_the_wheels_unchanged() {
    let mut supervisor = supervisor();
    let decision = supervisor.tick(&FIT, Some(FORWARD), Twist::ZERO, &Obstacles::default(), &mut Scratch::default());
    assert_eq!((decision.command.twist_b(), decision.changed), (FORWARD, None));
    assert_eq!(supervisor.verdict(), Verdict::Driving);
}

#[test]
fn whatever_is_absent_or_old_stops_the_robot_and_is_named() {
    let cases = [
        (Conditions { drive: DriveFact::Silent, ..FIT }, Verdict::Waiting(Reason::DriveSilent)),
        (Conditions { drive: DriveFact::Refused, ..FIT }, Verdict::Waiting(Reason::DriveRefused)),
        (Conditions { drive: DriveFact::BringUp("arming"), ..FIT }, Verdict::Waiting(Reason::DriveBringUp("arming"))),
        (Conditions { scan: Freshness::Absent, ..FIT }, Verdict::Waiting(Reason::NoScan)),
        (Conditions { odometry: Freshness::Absent, ..FIT }, Verdict::Waiting(Reason::NoOdometry)),
        (Conditions { pose: Freshness::Absent, ..FIT }, Verdict::Waiting(Reason::NoPose)),
        (Conditions { scan: Freshness::Old, ..FIT }, Verdict::Held(Reason::ScanOld)),
        (Conditions { blind: true, ..FIT }, Verdict::Held(Reason::ScanBlind)),
        (Conditions { odometry: Freshness::Old, ..FIT }, Verdict::Held(Reason::OdometryOld)),
        (Conditions { pose: Freshness::Old, ..FIT }, Verdict::Held(Reason::PoseOld)),
        (Conditions { late: true, ..FIT }, Verdict::Held(Reason::LateTick)),
        (Conditions { request: RequestFact::NotFinite, ..FIT }, Verdict::Held(Reason::RequestNotFinite)),
        (Conditions { request: RequestFact::Missing("leader lost"), ..FIT }, Verdict::Held(Reason::Law("leader lost"))),
    ];
    for (facts, verdict) in cases {
        let mut supervisor = supervisor();
        let decision =
            supervisor.tick(&facts, Some(FORWARD), Twist::ZERO, &Obstacles::default(), &mut Scratch::default());
        assert_eq!(supervisor.verdict(), verdict);
        assert!(decision.command.is_stop(), "{verdict}");
        // It goes on by itself when the reason ends.
        supervisor.tick(&FIT, Some(FORWARD), Twist::ZERO, &Obstacles::default(), &mut Scratch::default());
        assert_eq!(supervisor.verdict(), Verdict::Driving);
    }
}

#[test]
fn an_operators_stop_is_latched_and_the_first_reason_stays() {
    let mut supervisor = supervisor();
    supervisor.handle_stop(StopReason::Operator);
    supervisor.handle_stop(StopReason::Fault("panic"));
    let decision = supervisor.tick(&FIT, Some(FORWARD), Twist::ZERO, &Obstacles::default(), &mut Scratch::default());
    assert!(decision.command.is_stop());
    assert_eq!(supervisor.verdict(), Verdict::Stopped(StopReason::Operator));
}

#[test]
fn a_wall_ahead_blocks_the_way_but_not_a_turn_in_place_or_a_retreat() {
    let place = Place { walls: vec![(Vec2::new(0.5, -5.0), Vec2::new(0.5, 5.0))], discs: vec![] };
    let obstacles = around(&place, Pose::default(), Twist::ZERO);
    let mut supervisor = supervisor();
    let ahead = supervisor.tick(&FIT, Some(Twist::new(0.3, 0.4)), Twist::ZERO, &obstacles, &mut Scratch::default());
    assert_eq!(ahead.command.twist_b(), Twist::new(0.0, 0.4));
    assert_eq!((supervisor.verdict(), ahead.changed), (Verdict::Held(Reason::Obstacle), Some(Reason::Obstacle)));
    let back = supervisor.tick(&FIT, Some(Twist::new(-0.3, 0.0)), Twist::ZERO, &obstacles, &mut Scratch::default());
    assert_eq!((back.command.twist_b(), back.changed), (Twist::new(-0.3, 0.0), None));
}

#[test]
fn noise_in_the_measured_speed_does_not_lock_a_robot_at_a_wall() {
    let place = Place { walls: vec![(Vec2::new(0.5, -5.0), Vec2::new(0.5, 5.0))], discs: vec![] };
    let creeping = Twist::new(0.015, 0.0);
    let obstacles = around(&place, Pose::default(), creeping);
    let decision = supervisor().tick(&FIT, Some(Twist::new(-0.2, 0.3)), creeping, &obstacles, &mut Scratch::default());
    assert_eq!(decision.command.twist_b(), Twist::new(-0.2, 0.3));
}

#[test]
fn a_robot_slides_along_a_wall_at_its_margin() {
    let place = Place { walls: vec![(Vec2::new(-20.0, 0.54), Vec2::new(20.0, 0.54))], discs: vec![] };
    let obstacles = around(&place, Pose::default(), FORWARD);
    let decision = supervisor().tick(&FIT, Some(FORWARD), FORWARD, &obstacles, &mut Scratch::default());
    assert_eq!(decision.command.twist_b(), FORWARD);
}

#[test]
fn an_unseen_peer_ahead_is_taken_from_its_beacon_and_leaves_half_of_the_gap() {
    let motion = motion(Pose::default(), Twist::ZERO);
    let ahead = |x_m: f64| {
        let body = Body { pos_w: Vec2::new(x_m, 0.0), radius_m: 0.4, bound_m: 0.1, heard: true, stands: false };
        obstacles_of(&Surroundings::default(), &motion, &[body], params().keep_m(), false)
    };
    assert_eq!(ahead(1.35).planes.len(), 1);
    assert!((ahead(1.35).planes[0].advance_m - 0.15).abs() < 1e-12);
    let mut supervisor = cruising();
    let decision = supervisor.tick(&FIT, Some(FORWARD), FORWARD, &ahead(1.35), &mut Scratch::default());
    assert!(decision.command.twist_b().speed_mps < FORWARD.speed_mps && !decision.command.is_stop());
    assert_eq!(decision.changed, Some(Reason::Peer));
    supervisor.tick(&FIT, Some(FORWARD), Twist::ZERO, &ahead(1.05), &mut Scratch::default());
    assert_eq!(supervisor.verdict(), Verdict::Held(Reason::Peer));
}

#[test]
fn while_a_peer_is_unheard_what_lies_ahead_is_approached_by_half_of_the_gap() {
    let place = Place { walls: vec![(Vec2::new(0.8, -5.0), Vec2::new(0.8, 5.0))], discs: vec![] };
    let motion = motion(Pose::default(), FORWARD);
    let seen = surroundings(&place.scan(Pose::default(), Stamp::ZERO), &motion, Stamp::ZERO);
    let ask = |unheard| {
        let obstacles = obstacles_of(&seen, &motion, &[], params().keep_m(), unheard);
        cruising().tick(&FIT, Some(FORWARD), FORWARD, &obstacles, &mut Scratch::default()).command.twist_b().speed_mps
    };
    assert!(ask(true) < ask(false), "{} and {}", ask(true), ask(false));
}

#[test]
fn a_run_of_unknown_beams_ahead_forbids_to_drive_into_it_and_a_single_one_does_not() {
    let mut scan = Place::default().scan(Pose::default(), Stamp::ZERO);
    let ask = |scan: &Scan| {
        let motion = motion(Pose::default(), Twist::ZERO);
        let seen = surroundings(scan, &motion, Stamp::ZERO);
        let obstacles = obstacles_of(&seen, &motion, &[], params().keep_m(), false);
        supervisor().tick(&FIT, Some(FORWARD), Twist::ZERO, &obstacles, &mut Scratch::default()).command.twist_b()
    };
    scan.beams[0] = Beam::Unknown;
    assert_eq!(ask(&scan), FORWARD);
    scan.beams[1] = Beam::Unknown;
    assert_eq!(ask(&scan), FORWARD);
    scan.beams[71] = Beam::Unknown;
    assert_eq!(ask(&scan), Twist::ZERO);
}

#[test]
fn what_a_scan_does_not_cover_is_unknown_and_not_driven_into() {
    let mut scan = Place::default().scan(Pose::default(), Stamp::ZERO);
    // The front half only.
    scan.angle_first_rad = -std::f64::consts::FRAC_PI_2;
    scan.beams.truncate(36);
    let motion = motion(Pose::default(), Twist::ZERO);
    let seen = surroundings(&scan, &motion, Stamp::ZERO);
    let obstacles = obstacles_of(&seen, &motion, &[], params().keep_m(), false);
    let ask = |twist| {
        supervisor().tick(&FIT, Some(twist), Twist::ZERO, &obstacles, &mut Scratch::default()).command.twist_b()
    };
    assert_eq!(ask(Twist::new(-0.3, 0.0)), Twist::ZERO);
    assert_eq!(ask(FORWARD), FORWARD);
}

#[test]
fn a_dropped_out_beam_takes_the_nearer_of_its_neighbours() {
    let mut scan = Place::default().scan(Pose::default(), Stamp::ZERO);
    scan.beams[10] = Beam::Hit(2.0);
    scan.beams[11] = Beam::Unknown;
    scan.beams[12] = Beam::Hit(1.0);
    let seen = surroundings(&scan, &motion(Pose::default(), Twist::ZERO), Stamp::ZERO);
    let ranges: Vec<f64> = seen.points_b.iter().map(|point| (point.norm() * 1e6).round() / 1e6).collect();
    assert_eq!(ranges, vec![2.0, 1.0, 1.0]);
    assert!(seen.blind_b.is_empty());
}

#[test]
fn an_aged_scan_is_carried_along_with_the_body() {
    let mut scan = Place::default().scan(Pose::default(), Stamp::ZERO);
    scan.beams[0] = Beam::Hit(3.0);
    let motion = motion(Pose::default(), Twist::new(1.0, 0.0));
    let seen = surroundings(&scan, &motion, Stamp::from_millis(200));
    assert!((seen.points_b[0] - Vec2::new(2.8, 0.0)).norm() < 1e-9);
}

/// A body that is asked for random things in a room, with the loop's delays: the smallest gap to the walls.
fn wander(seed: u64, link_ticks: usize, seconds: usize) -> f64 {
    let mut chance = Chance(seed);
    let mut place = Place::room((-2.5, 2.5), (-2.0, 2.0));
    place.discs.push((Vec2::new(1.2, 0.9), 0.3));
    let start_wb = Pose::new(-0.5, 0.0, chance.within(-3.0, 3.0));
    let mut body = SimBody { pose_wb: start_wb, twist_b: Twist::ZERO, radius_m: 0.4 };
    let mut supervisor = supervisor();
    let mut pipe = vec![Twist::ZERO; link_ticks];
    let mut wish = Twist::ZERO;
    let mut gap_m = f64::INFINITY;
    for tick in 0..seconds * 20 {
        if tick % 25 == 0 {
            wish = Twist::new(chance.within(-0.5, 1.5), chance.within(-1.5, 1.5));
        }
        let request = crate::limit::limit(wish, supervisor.before(), &limits(), 0.05);
        let obstacles = around(&place, body.pose_wb, body.twist_b);
        let command =
            supervisor.tick(&FIT, Some(request), body.twist_b, &obstacles, &mut Scratch::default()).command.twist_b();
        assert!(command.speed_mps.abs() <= request.speed_mps.abs());
        assert!(command.yaw_rate_radps.abs() <= request.yaw_rate_radps.abs());
        pipe.push(command);
        let due = pipe.remove(0);
        for _ in 0..5 {
            body.step(due, 0.01);
            gap_m = gap_m.min(place.gap_m(body.pose_wb.position()) - body.radius_m);
        }
    }
    gap_m
}

#[test]
fn whatever_is_asked_the_body_keeps_its_margin_to_standing_things() {
    for seed in 0..30 {
        for link_ticks in [0, 1, 2] {
            let gap_m = wander(seed, link_ticks, 60);
            assert!(gap_m > 0.15 - 0.05, "seed {seed}, {link_ticks} ticks of delay: {gap_m} m");
        }
    }
}

#[test]
fn whatever_is_asked_the_body_stays_in_the_discs_of_its_links() {
    for seed in 0..20 {
        let mut chance = Chance(seed);
        let mut body = SimBody { pose_wb: Pose::default(), twist_b: Twist::ZERO, radius_m: 0.4 };
        let mut supervisor = supervisor();
        let discs = [(Vec2::new(1.5, 0.5), 2.5), (Vec2::new(-0.5, 1.0), 2.5)];
        let (mut wish, mut held) = (Twist::ZERO, 0);
        for tick in 0..1_200 {
            if tick % 40 == 0 {
                wish = Twist::new(chance.within(-0.5, 1.5), chance.within(-1.0, 1.0));
            }
            let request = crate::limit::limit(wish, supervisor.before(), &limits(), 0.05);
            let mut obstacles = Obstacles::default();
            obstacles
                .stay_in(discs.iter().map(|(centre, radius_m)| (body.pose_wb.inverse_transform(*centre), *radius_m)));
            let decision = supervisor.tick(&FIT, Some(request), body.twist_b, &obstacles, &mut Scratch::default());
            held += usize::from(decision.changed == Some(Reason::Link));
            for _ in 0..5 {
                body.step(decision.command.twist_b(), 0.01);
                let outside =
                    |(centre, radius_m): &(Vec2, f64)| (body.pose_wb.position() - centre).norm() > radius_m + 0.02;
                assert!(!discs.iter().any(outside), "seed {seed}, tick {tick}: {:?}", body.pose_wb);
            }
        }
        assert!(held > 0, "seed {seed}: it never came to the rim");
    }
}

proptest! {
    #[test]
    fn a_command_is_never_more_than_the_request_and_never_beyond_the_limits(
        v in -5.0..5.0f64, w in -5.0..5.0f64, v0 in -0.5..1.5f64, w0 in -1.5..1.5f64, wall in 0.2..3.0f64,
    ) {
        let place = Place { walls: vec![(Vec2::new(wall, -5.0), Vec2::new(wall, 5.0))], discs: vec![] };
        let is_b = Twist::new(v0, w0);
        let obstacles = around(&place, Pose::default(), is_b);
        let scratch = &mut Scratch::default();
        let command = supervisor().tick(&FIT, Some(Twist::new(v, w)), is_b, &obstacles, scratch).command.twist_b();
        prop_assert!(command.speed_mps.abs() <= v.abs() && command.yaw_rate_radps.abs() <= w.abs());
        prop_assert!(command.speed_mps * v >= 0.0 && command.yaw_rate_radps * w >= 0.0);
        let limits = limits();
        prop_assert!((-limits.reverse_mps_max..=limits.speed_mps_max).contains(&command.speed_mps));
        prop_assert!(command.yaw_rate_radps.abs() <= limits.yaw_rate_radps_max);
    }

    #[test]
    fn a_request_that_is_not_finite_is_a_stop(v in any::<f64>(), w in any::<f64>()) {
        let request = Twist::new(v, w);
        let facts = Conditions { request: RequestFact::of(Ok(request)), ..FIT };
        let scratch = &mut Scratch::default();
        let decision = supervisor().tick(&facts, Some(request), Twist::ZERO, &Obstacles::default(), scratch);
        prop_assert!(decision.command.twist_b().is_finite());
        if !request.is_finite() {
            prop_assert!(decision.command.is_stop());
        }
    }
}
