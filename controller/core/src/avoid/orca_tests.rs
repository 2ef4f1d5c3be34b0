use super::*;
use drover_contract::Pose;
use drover_contract::math::{cos, sin};
use proptest::prelude::*;
use std::f64::consts::TAU;

const RADIUS_M: f64 = 0.25;

fn v(x: f64, y: f64) -> Vec2 {
    Vec2::new(x, y)
}

fn params() -> OrcaParams {
    OrcaParams {
        radius_m: RADIUS_M,
        keep_m: 0.0,
        tracking_m: 0.0,
        horizon_s: 2.0,
        wall_horizon_s: 0.5,
        dt_s: 0.1,
        speed_mps_max: 1.0,
    }
}

fn nobody() -> std::iter::Empty<OrcaPeer> {
    std::iter::empty()
}

fn no_wall() -> std::iter::Empty<Capsule> {
    std::iter::empty()
}

/// Straight to `goal_w`, to arrive at the end of a step.
fn wish(pos_w: Vec2, goal_w: Vec2, speed_mps: f64, dt_s: f64) -> Vec2 {
    let way = goal_w - pos_w;
    way * (speed_mps / way.norm().max(speed_mps * dt_s))
}

/// Smallest distance of two points that move straight at once.
fn nearest_m(from: [Vec2; 2], to: [Vec2; 2]) -> f64 {
    Capsule::disc(Vec2::zeros(), 0.0).clearance_m(from[1] - from[0], to[1] - to[0])
}

/// What a swarm of discs did.
#[derive(Debug)]
struct Run {
    /// Nearest that two middles came in continuous time.
    nearest_m: f64,
    /// When the last arrived; infinite if not all did.
    arrived_s: f64,
    /// Slowest that anybody was before all had arrived, of those at least 0.5 m from their goals.
    slowest_mps: f64,
    /// Worst breach of a bound by a chosen velocity.
    excess_mps: f64,
}

/// Holonomic discs that take the velocities they choose, all at once.
fn run(starts_goals_w: &[(Vec2, Vec2)], params: OrcaParams, speed_mps: f64, most_s: f64) -> Run {
    let mut discs: Vec<OrcaPeer> = Vec::new();
    let peer = |pos_w: Vec2| OrcaPeer { pos_w, vel_w: Vec2::zeros(), radius_m: params.disc_m() };
    discs.extend(starts_goals_w.iter().map(|(start_w, _)| peer(*start_w)));
    let (mut orca, mut now_s) = (Orca::new(params), 0.0);
    let mut run =
        Run { nearest_m: f64::INFINITY, arrived_s: f64::INFINITY, slowest_mps: f64::INFINITY, excess_mps: 0.0 };
    while now_s < most_s {
        let before = discs.clone();
        for (at, (_, goal_w)) in starts_goals_w.iter().enumerate() {
            let own = before[at];
            let others = before.iter().enumerate().filter(|(other, _)| *other != at).map(|(_, peer)| *peer);
            let wish_w = wish(own.pos_w, *goal_w, speed_mps, params.dt_s);
            let vel_w = orca.velocity((own.pos_w, own.vel_w), wish_w, others, no_wall());
            run.excess_mps = run.excess_mps.max(orca.excess_mps(vel_w));
            discs[at] = OrcaPeer { pos_w: own.pos_w + vel_w * params.dt_s, vel_w, ..own };
            if (goal_w - own.pos_w).norm() > 0.5 && now_s > 0.0 {
                run.slowest_mps = run.slowest_mps.min(vel_w.norm());
            }
        }
        for (a, b) in (0..discs.len()).flat_map(|a| (0..a).map(move |b| (a, b))) {
            let (from, to) = ([before[a].pos_w, before[b].pos_w], [discs[a].pos_w, discs[b].pos_w]);
            run.nearest_m = run.nearest_m.min(nearest_m(from, to));
        }
        now_s += params.dt_s;
        if discs.iter().zip(starts_goals_w).all(|(disc, (_, goal_w))| (disc.pos_w - goal_w).norm() < 0.05) {
            run.arrived_s = now_s;
            break;
        }
    }
    run
}

#[test]
fn in_front_of_a_peer_the_front_of_the_obstacle_bounds_by_hand_computed_numbers() {
    let peer = OrcaPeer { pos_w: v(4.0, 0.0), vel_w: Vec2::zeros(), radius_m: 0.5 };
    let own = OrcaPeer { pos_w: Vec2::zeros(), vel_w: v(1.0, 0.0), radius_m: 0.5 };
    let bound = share_with(own, peer, &params()).expect("a bound");
    // The front is a circle about (2, 0) of radius 0.5. The two close in by more than that, so (1, 0) is shifted by 0.5
    // to the right and the line turned by 1 to 2. Not turned it were at 1.25: half of the way from 1 to the front.
    let (along, across) = (2.0 / 5.0_f64.sqrt(), 1.0 / 5.0_f64.sqrt());
    assert!((bound.normal_w - v(along, across)).norm() < 1e-12, "{bound:?}");
    assert!((bound.speed_mps - (1.5 * along - 0.25)).abs() < 1e-12, "{bound:?}");
}

#[test]
fn beside_its_front_the_flank_of_the_obstacle_bounds_by_hand_computed_numbers() {
    let mut params = params();
    (params.radius_m, params.speed_mps_max) = (0.5, 3.0);
    let peer = OrcaPeer { pos_w: v(2.0, 0.0), vel_w: Vec2::zeros(), radius_m: 0.5 };
    let vel_w = Orca::new(params).velocity((Vec2::zeros(), v(3.0, 0.0)), v(3.0, 0.0), std::iter::once(peer), no_wall());
    // The flanks are 30 degrees off; (3, 0) is 1.5 deep, half of it is 0.75, to the right and back.
    assert!((vel_w - v(3.0 - 0.375, -0.75 * 0.75_f64.sqrt())).norm() < 1e-12, "{vel_w}");
}

#[test]
fn who_overlap_part_within_a_step_but_for_rounding() {
    let peers = [v(0.0, 0.0), v(0.44, 0.0)].map(|pos_w| OrcaPeer { pos_w, vel_w: Vec2::zeros(), radius_m: RADIUS_M });
    let mut orca = Orca::new(params());
    let [left_w, right_w] = [(0, 1), (1, 0)].map(|(own, other)| {
        let own: OrcaPeer = peers[own];
        orca.velocity((own.pos_w, own.vel_w), Vec2::zeros(), std::iter::once(peers[other]), no_wall())
    });
    assert!((left_w + right_w).norm() < 1e-12, "each half: {left_w} {right_w}");
    let apart_m = (peers[1].pos_w - peers[0].pos_w + (right_w - left_w) * params().dt_s).norm();
    assert!((2.0 * RADIUS_M..2.0 * RADIUS_M + 0.001).contains(&(apart_m + 1e-9)), "{apart_m}");
}

#[test]
fn two_at_the_very_same_place_get_finite_velocities() {
    let peer = OrcaPeer { pos_w: v(1.0, 1.0), vel_w: Vec2::zeros(), radius_m: RADIUS_M };
    let vel_w =
        Orca::new(params()).velocity((v(1.0, 1.0), Vec2::zeros()), v(0.3, 0.0), std::iter::once(peer), no_wall());
    assert_eq!(vel_w, v(0.3, 0.0));
}

#[test]
fn exactly_head_on_both_pass_on_the_right_without_touching_and_keep_going() {
    for speed_mps in [1.0, 0.3, 0.05] {
        let way = v(4.0 * speed_mps + 1.0, 0.0);
        let run = run(&[(-way, way), (way, -way)], params(), speed_mps, 60.0 + 2.0 * way.x / speed_mps);
        assert!(run.nearest_m >= 2.0 * RADIUS_M - 1e-9, "{speed_mps}: {run:?}");
        assert!(run.slowest_mps >= 0.3 * speed_mps, "{speed_mps}: {run:?}");
        assert!(run.arrived_s < 1.5 * 2.0 * way.x / speed_mps + 10.0, "{speed_mps}: {run:?}");
    }
}

#[test]
fn nose_to_nose_at_rest_is_no_place_to_stay() {
    let starts = [(v(-RADIUS_M, 0.0), v(3.0, 0.0)), (v(RADIUS_M, 0.0), v(-3.0, 0.0))];
    for speed_mps in [1.0, 0.1] {
        let run = run(&starts, params(), speed_mps, 200.0);
        assert!(run.nearest_m >= 2.0 * RADIUS_M - 1e-9 && run.arrived_s < 200.0, "{run:?}");
    }
}

#[test]
fn eight_on_a_circle_exchange_places_without_contact() {
    let places_w = |turn: f64| (0..8).map(move |at| turn_of(3.0, f64::from(at) / 8.0 + turn));
    let ways: Vec<(Vec2, Vec2)> = places_w(0.0).zip(places_w(0.5)).collect();
    let run = run(&ways, params(), 1.0, 60.0);
    assert!(run.nearest_m >= 2.0 * RADIUS_M - 1e-9, "{run:?}");
    assert!(run.arrived_s < 12.0, "6 m at 1 m/s and some for the others: {run:?}");
}

fn turn_of(length: f64, turns: f64) -> Vec2 {
    v(cos(turns * TAU), sin(turns * TAU)) * length
}

/// Walls of a corner, an end of an edge, a tree, and a lidar's returns along a line.
fn walls() -> Vec<Capsule> {
    let mut walls = vec![
        Capsule::edge(v(2.0, -3.0), v(2.0, 2.0)),
        Capsule::edge(v(2.0, 2.0), v(-1.0, 3.0)),
        Capsule::edge(v(-0.7, -0.6), v(-3.0, -0.6)),
        Capsule::disc(v(0.5, -2.0), 0.4),
    ];
    walls.extend((0..60).map(|at| Capsule::disc(v(-2.0 + f64::from(at) * 0.05, -3.0), 0.0)));
    walls
}

#[test]
fn no_wall_is_ever_come_too_near_to_whatever_is_wished() {
    let mut params = params();
    params.keep_m = 0.05;
    let walls = walls();
    for direction in 0..72 {
        let wish_w = turn_of(1.0, f64::from(direction) / 72.0);
        let (mut orca, mut pos_w, mut vel_w) = (Orca::new(params), Vec2::zeros(), Vec2::zeros());
        for _ in 0..60 {
            vel_w = orca.velocity((pos_w, vel_w), wish_w, nobody(), walls.iter().copied());
            let next_w = pos_w + vel_w * params.dt_s;
            let clear_m = walls.iter().map(|wall| wall.clearance_m(pos_w, next_w)).fold(f64::INFINITY, f64::min);
            assert!(clear_m >= params.disc_m() - 1e-9, "{direction}: {clear_m} at {pos_w}");
            assert!(vel_w.dot(&wish_w) >= -1e-12, "standing still was nearer");
            pos_w = next_w;
        }
    }
}

#[test]
fn along_a_wall_one_slides_at_full_speed() {
    let wall = Capsule::edge(v(-10.0, RADIUS_M), v(10.0, RADIUS_M));
    let vel_w =
        Orca::new(params()).velocity((v(0.0, 0.0), Vec2::zeros()), v(0.6, 0.5), nobody(), std::iter::once(wall));
    assert!((vel_w - v(0.6, 0.0)).norm() < 1e-12, "{vel_w}");
}

fn vec2(most: f64) -> impl Strategy<Value = Vec2> {
    (-most..most, -most..most).prop_map(|(x, y)| v(x, y))
}

fn peer(most_m: f64) -> impl Strategy<Value = OrcaPeer> {
    (vec2(most_m), vec2(0.7)).prop_map(|(pos_w, vel_w)| OrcaPeer { pos_w, vel_w, radius_m: RADIUS_M })
}

/// The best on a fine polar grid: (least distance to the wish of what satisfies all, least breach of the peers' bounds
/// of what satisfies the walls).
fn best_on_grid(orca: &Orca, wish_w: Vec2) -> (f64, f64) {
    let (walls, peers) = orca.bounds.split_at(orca.walls);
    let worst = |bounds: &[Bound], vel_w| bounds.iter().map(|b| b.excess_mps(vel_w)).fold(0.0, f64::max);
    let mut best = (f64::INFINITY, f64::INFINITY);
    let grid = (0..=40).flat_map(|ring| (0..180).map(move |turn| (f64::from(ring) / 40.0, f64::from(turn) / 180.0)));
    for vel_w in grid.map(|(length, turns)| turn_of(length, turns)) {
        if worst(walls, vel_w) > 0.0 {
            continue;
        }
        let excess_mps = worst(peers, vel_w);
        best.1 = best.1.min(excess_mps);
        if excess_mps <= 0.0 {
            best.0 = best.0.min((vel_w - wish_w).norm());
        }
    }
    best
}

/// Checks a choice against the grid.
fn check(own: (Vec2, Vec2), wish_w: Vec2, peers: &[OrcaPeer], walls: &[Capsule]) -> Result<(), TestCaseError> {
    let mut orca = Orca::new(params());
    let vel_w = orca.velocity(own, wish_w, peers.iter().copied(), walls.iter().copied());
    let walls_mps = orca.bounds[..orca.walls].iter().map(|b| b.excess_mps(vel_w)).fold(0.0, f64::max);
    prop_assert!(walls_mps <= 1e-8, "the walls hold: {walls_mps}");
    prop_assert!(vel_w.norm() <= 1.0 + 1e-8);
    let (distance_mps, excess_mps) = best_on_grid(&orca, wish_w);
    prop_assert!(orca.excess_mps(vel_w) <= excess_mps + 1e-8, "{} > {excess_mps}", orca.excess_mps(vel_w));
    if distance_mps.is_finite() {
        let own_mps = (vel_w - wish_w).norm();
        prop_assert!(own_mps <= distance_mps + 1e-8, "{own_mps} > {distance_mps}");
    }
    Ok(())
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(400))]

    #[test]
    fn no_velocity_of_a_grid_is_better_among_peers(
        vel_w in vec2(0.7), wish_w in vec2(1.5), peers in prop::collection::vec(peer(3.0), 0..7),
    ) {
        check((Vec2::zeros(), vel_w), wish_w, &peers, &[])?;
    }

    #[test]
    fn nor_in_a_crowd_between_walls(
        vel_w in vec2(0.7), wish_w in vec2(1.5), peers in prop::collection::vec(peer(1.0), 2..9),
        ends in prop::collection::vec((vec2(1.0), vec2(1.0)), 0..4),
    ) {
        let walls: Vec<Capsule> = ends.iter().map(|(a_w, b_w)| Capsule::edge(*a_w, *b_w)).collect();
        check((Vec2::zeros(), vel_w), wish_w, &peers, &walls)?;
    }

    /// The theorem itself: both go on with what each chose, and do not touch for the whole horizon.
    #[test]
    fn two_who_both_choose_do_not_touch_for_the_horizon(
        to_peer in vec2(3.0), vels_w in (vec2(0.7), vec2(0.7)), wishes_w in (vec2(1.5), vec2(1.5)),
    ) {
        let apart_m = to_peer.norm();
        prop_assume!(apart_m > 2.0 * RADIUS_M);
        let own = OrcaPeer { pos_w: Vec2::zeros(), vel_w: vels_w.0, radius_m: RADIUS_M };
        let peer = OrcaPeer { pos_w: to_peer, vel_w: vels_w.1, radius_m: RADIUS_M };
        let mut orca = Orca::new(params());
        let mut choose = |own: OrcaPeer, other, wish_w| {
            let vel_w = orca.velocity((own.pos_w, own.vel_w), wish_w, std::iter::once(other), no_wall());
            (vel_w, orca.excess_mps(vel_w))
        };
        let ((own_w, own_mps), (peer_w, peer_mps)) = (choose(own, peer, wishes_w.0), choose(peer, own, wishes_w.1));
        prop_assume!(own_mps.max(peer_mps) <= 1e-8);
        let ends = [own_w * params().horizon_s, to_peer + peer_w * params().horizon_s];
        let nearest_m = nearest_m([Vec2::zeros(), to_peer], ends);
        prop_assert!(nearest_m >= 2.0 * RADIUS_M - 1e-7, "{nearest_m}");
    }
}

#[test]
fn between_two_who_close_in_the_breach_is_the_same_on_both_sides() {
    let peers = [(-0.6, 1.0), (0.6, -1.0)];
    let peers = peers.map(|(x_m, x_mps)| OrcaPeer { pos_w: v(x_m, 0.0), vel_w: v(x_mps, 0.0), radius_m: RADIUS_M });
    // A wall keeps it from going out to the side on either hand.
    let walls = [0.26, -0.26].map(|y_m| Capsule::edge(v(-2.0, y_m), v(2.0, y_m)));
    let mut orca = Orca::new(params());
    let vel_w = orca.velocity((Vec2::zeros(), Vec2::zeros()), v(1.0, 1.0), peers.into_iter(), walls.into_iter());
    assert_eq!(orca.bounds.len() - orca.walls, 2);
    let breaches = [0, 1].map(|at| orca.bounds[orca.walls + at].excess_mps(vel_w));
    assert!(breaches[0] > 0.1 && (breaches[0] - breaches[1]).abs() < 1e-9, "{breaches:?}");
    assert!(vel_w.y.abs() <= 0.02 + 1e-9, "{vel_w}");
}

fn tracking(reverse: bool) -> Tracking {
    Tracking { limits: crate::testing::limits(), error_m: 0.05, turn_s: 0.3, reverse }
}

#[test]
fn ahead_is_driven_straight_beside_is_turned_to_and_behind_is_turned_to_on_the_spot() {
    let tracking = tracking(false);
    let straight = track(v(0.0, 0.8), TAU / 4.0, &tracking);
    assert!((straight.speed_mps - 0.8).abs() < 1e-12 && straight.yaw_rate_radps.abs() < 1e-12, "{straight:?}");
    let behind = track(v(-0.8, 0.0), 0.0, &tracking);
    assert_eq!((behind.speed_mps, behind.yaw_rate_radps.abs()), (0.0, 1.5));
    // 0.3 rad take 0.3 s at 1 rad/s; the paper's V (a / 2) cot(a / 2), for which the error of 0.8 x 0.3 sin 0.15 is
    // small enough.
    let beside = track(turn_of(0.8, 0.3 / TAU), 0.0, &tracking);
    let by_hand_mps = 0.8 * 0.15 * cos(0.15) / sin(0.15);
    assert!((beside.yaw_rate_radps - 1.0).abs() < 1e-12 && (beside.speed_mps - by_hand_mps).abs() < 1e-12);
    assert_eq!(track(Vec2::zeros(), 1.0, &tracking), Twist::ZERO);
}

#[test]
fn who_may_reverse_drives_back_to_what_is_behind() {
    let back = track(v(-0.4, 0.0), 0.0, &tracking(true));
    assert!((back.speed_mps + 0.4).abs() < 1e-12 && back.yaw_rate_radps.abs() < 1e-12, "{back:?}");
    let mut never = tracking(true);
    never.limits.reverse_mps_max = 0.0;
    assert_eq!(track(v(-0.4, 0.0), 0.0, &never), track(v(-0.4, 0.0), 0.0, &tracking(false)));
}

proptest! {
    #[test]
    fn following_stays_within_its_error_and_never_reverses_unasked(
        vel_w in vec2(2.0), yaw_rad in -3.2..3.2f64, reverse in any::<bool>(), turn_s in 0.05..2.0f64,
    ) {
        let tracking = Tracking { turn_s, ..tracking(reverse) };
        let Limits { speed_mps_max, reverse_mps_max, yaw_rate_radps_max, .. } = tracking.limits;
        let twist_b = track(vel_w, yaw_rad, &tracking);
        prop_assert!(reverse || twist_b.speed_mps >= 0.0);
        prop_assert!((-reverse_mps_max..=speed_mps_max).contains(&twist_b.speed_mps));
        prop_assert!(twist_b.yaw_rate_radps.abs() <= yaw_rate_radps_max);
        let start_wb = Pose::new(0.0, 0.0, yaw_rad);
        let end_w = start_wb.advance(twist_b, turn_s).position();
        let unit = vel_w.normalize();
        let along_m = end_w.dot(&unit);
        prop_assume!(along_m > 1e-6);
        // The velocity to which the end is the nearest that the arc's speed can make it.
        let followed_w = unit * (end_w.norm_squared() / along_m / turn_s);
        prop_assert!(followed_w.norm() <= vel_w.norm() + 1e-6, "never faster than asked");
        for part in 1..=20 {
            let at_s = turn_s * f64::from(part) / 20.0;
            let error_m = (start_wb.advance(twist_b, at_s).position() - followed_w * at_s).norm();
            prop_assert!(error_m <= tracking.error_m + 1e-9, "{error_m} m after {at_s} s");
        }
    }
}

/// Differential drives to their goals: nearest two middles, and when all had arrived.
fn drive(starts_goals: &[(Pose, Vec2)], most_s: f64) -> (f64, f64) {
    let tracking = tracking(false);
    let params = OrcaParams { tracking_m: tracking.error_m, dt_s: 0.05, ..params() };
    let mut bodies: Vec<(Pose, Twist)> = starts_goals.iter().map(|(start_wb, _)| (*start_wb, Twist::ZERO)).collect();
    let (mut orca, mut nearest_m, mut now_s) = (Orca::new(params), f64::INFINITY, 0.0);
    while now_s < most_s {
        let discs: Vec<OrcaPeer> = bodies
            .iter()
            .map(|(pose_wb, twist_b)| (pose_wb.position(), pose_wb.heading() * twist_b.speed_mps))
            .map(|(pos_w, vel_w)| OrcaPeer { pos_w, vel_w, radius_m: params.disc_m() })
            .collect();
        for (at, (own, (_, goal_w))) in discs.iter().zip(starts_goals).enumerate() {
            let others = discs.iter().enumerate().filter(|(other, _)| *other != at).map(|(_, peer)| *peer);
            let wish_w = wish(own.pos_w, *goal_w, 1.0, 0.5);
            let vel_w = orca.velocity((own.pos_w, own.vel_w), wish_w, others, no_wall());
            let twist_b = track(vel_w, bodies[at].0.yaw_rad, &tracking);
            assert!(twist_b.speed_mps >= 0.0);
            bodies[at] = (bodies[at].0.advance(twist_b, params.dt_s), twist_b);
        }
        for (a, b) in (0..bodies.len()).flat_map(|a| (0..a).map(move |b| (a, b))) {
            nearest_m = nearest_m.min((bodies[a].0.position() - bodies[b].0.position()).norm());
        }
        now_s += params.dt_s;
        if bodies.iter().zip(starts_goals).all(|(body, (_, goal_w))| (body.0.position() - goal_w).norm() < 0.1) {
            return (nearest_m, now_s);
        }
    }
    (nearest_m, f64::INFINITY)
}

#[test]
fn two_differential_drives_head_on_pass_without_touching() {
    let starts_goals = [(Pose::new(-4.0, 0.0, 0.0), v(4.0, 0.0)), (Pose::new(4.0, 0.0, TAU / 2.0), v(-4.0, 0.0))];
    let (nearest_m, arrived_s) = drive(&starts_goals, 60.0);
    assert!(nearest_m >= 2.0 * RADIUS_M && arrived_s < 10.0, "{nearest_m} m, {arrived_s} s");
}

#[test]
fn six_differential_drives_cross_in_the_middle_without_touching() {
    let places = (0..6).map(|at| (turn_of(4.0, f64::from(at) / 6.0), f64::from(at) / 6.0 * TAU + TAU / 2.0));
    let starts_goals: Vec<(Pose, Vec2)> =
        places.map(|(at_w, yaw_rad)| (Pose::new(at_w.x, at_w.y, yaw_rad), -at_w)).collect();
    let (nearest_m, arrived_s) = drive(&starts_goals, 60.0);
    assert!(nearest_m >= 2.0 * RADIUS_M && arrived_s < 20.0, "{nearest_m} m, {arrived_s} s");
}

#[test]
fn a_differential_drive_comes_nearer_to_walls_by_no_more_than_its_error() {
    let tracking = tracking(false);
    let params = OrcaParams { tracking_m: tracking.error_m, dt_s: 0.05, ..params() };
    let walls = walls();
    for direction in 0..72 {
        let wish_w = turn_of(1.0, f64::from(direction) / 72.0);
        let (mut orca, mut pose_wb, mut twist_b) = (Orca::new(params), Pose::default(), Twist::ZERO);
        for _ in 0..120 {
            let own = (pose_wb.position(), pose_wb.heading() * twist_b.speed_mps);
            let vel_w = orca.velocity(own, wish_w, nobody(), walls.iter().copied());
            twist_b = track(vel_w, pose_wb.yaw_rad, &tracking);
            pose_wb = pose_wb.advance(twist_b, params.dt_s);
            let clear_m = walls.iter().map(|wall| wall.distance_m(pose_wb.position())).fold(f64::INFINITY, f64::min);
            assert!(clear_m >= RADIUS_M, "{direction}: {clear_m} at {pose_wb:?}");
        }
    }
}
