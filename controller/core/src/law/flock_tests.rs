use super::*;
use crate::peers::Neighbour;
use crate::testing::{Chance, Place, SimSwarm, flock_config, limits};
use drover_contract::{BehaviourState, Limits, Stamp};

const PARAMS: Params = Params {
    leader: RobotId(1),
    spacing_m: 1.8,
    gain: 1.0,
    obstacle_range_m: 1.0,
    head_offset_m: 0.3,
    damping_per_s: 1.5,
    mass_kg: 1.0,
    inertia_kgm2: 0.04,
};

fn peer(id: u32, pose_wb: Pose, speed_mps: f64) -> Neighbour {
    let twist_b = Twist::new(speed_mps, 0.0);
    Neighbour { id: RobotId(id), pose_wb, twist_b, accel_mps2: 0.0, state: BehaviourState::Active }
}

fn view<'a>(neighbours: &'a [Neighbour], twist_b: Twist, limits: &'a Limits) -> View<'a> {
    let motion = Motion { pose_wb: Pose::default(), twist_b, accel_mps2: 0.0, pos_bound_m: 0.0 };
    View {
        now: Stamp::ZERO,
        dt_s: 0.05,
        motion,
        neighbours,
        wall_b: None,
        walls_b: &[],
        points_b: &[],
        unseen_b: &[],
        limits,
    }
}

fn solved(outcome: Outcome) -> Twist {
    match outcome {
        Outcome::Solved(twist) => twist,
        Outcome::Stale(why) => panic!("stale: {why}"),
    }
}

#[test]
fn the_pair_force_is_the_gradient_of_equation_5() {
    let potential = |r: f64| 1.3 * (1.8 * 1.8 / (r * r) + libm::log(r * r));
    for r in [0.6, 1.0, 1.8, 2.5, 6.0] {
        let slope = (potential(r + 1e-6) - potential(r - 1e-6)) / 2e-6;
        let force = pair_force(1.3, 1.8, Vec2::new(r, 0.0));
        assert!((force.x + slope).abs() < 1e-5, "r {r}: {} and {slope}", force.x);
    }
}

#[test]
fn at_the_spacing_with_the_leaders_velocity_nothing_changes() {
    let limits = limits();
    let neighbours = [peer(1, Pose::new(1.8, 0.0, 0.0), 0.8)];
    let twist = Twist::new(0.8, 0.0);
    let got = solved(flock(&PARAMS, twist, &view(&neighbours, twist, &limits)));
    assert!((got.speed_mps - 0.8).abs() < 1e-12 && got.yaw_rate_radps.abs() < 1e-12, "{got:?}");
}

#[test]
fn a_follower_that_is_behind_speeds_up_and_one_that_is_too_near_slows_down() {
    let limits = limits();
    let twist = Twist::new(0.8, 0.0);
    let ask = |gap_m: f64| {
        let neighbours = [peer(1, Pose::new(gap_m, 0.0, 0.0), 0.8)];
        solved(flock(&PARAMS, twist, &view(&neighbours, twist, &limits))).speed_mps
    };
    assert!(ask(3.0) > 0.8);
    assert!(ask(1.2) < 0.8);
    assert!((ask(50.0) - ask(1.8 * 3.0_f64.sqrt())).abs() < 1e-12, "the leader's pull does not fade");
}

#[test]
fn the_damping_of_the_turn_is_that_of_the_reference_point() {
    // Alone with a leader at the rest distance, a turning robot loses k d^2 / I of its turn a second.
    let limits = limits();
    let neighbours = [peer(1, Pose::new(1.8, 0.0, 0.0), 0.0)];
    let twist = Twist::new(0.0, 0.5);
    let got = solved(flock(&PARAMS, twist, &view(&neighbours, twist, &limits)));
    let expected = 0.5 * (1.0 - 1.5 * 0.3 * 0.3 / 0.04 * 0.05);
    assert!((got.yaw_rate_radps - expected).abs() < 1e-12, "{got:?}, expected {expected}");
}

#[test]
fn the_leaders_acceleration_is_fed_forward() {
    let limits = limits();
    let twist = Twist::new(0.5, 0.0);
    let neighbours = [Neighbour { accel_mps2: 0.4, ..peer(1, Pose::new(1.8, 0.0, 0.0), 0.5) }];
    let got = solved(flock(&PARAMS, twist, &view(&neighbours, twist, &limits)));
    assert!((got.speed_mps - (0.5 + 0.4 * 0.05)).abs() < 1e-12);
}

#[test]
fn a_wall_ahead_slows_down_and_one_out_of_range_does_nothing() {
    let limits = limits();
    let neighbours = [peer(1, Pose::new(0.0, 1.8, 0.0), 0.5)];
    let twist = Twist::new(0.5, 0.0);
    let ask =
        |wall_b: Option<Vec2>| solved(flock(&PARAMS, twist, &View { wall_b, ..view(&neighbours, twist, &limits) }));
    let free = ask(None);
    assert_eq!(ask(Some(Vec2::new(1.31, 0.0))), free);
    assert!(ask(Some(Vec2::new(0.9, 0.0))).speed_mps < free.speed_mps);
}

#[test]
fn without_its_leader_or_behind_a_stopped_one_the_law_has_no_answer() {
    let limits = limits();
    let others = [peer(2, Pose::new(1.8, 0.0, 0.0), 0.8)];
    assert_eq!(flock(&PARAMS, Twist::ZERO, &view(&others, Twist::ZERO, &limits)), Outcome::Stale("leader lost"));
    let stopped = [Neighbour { state: BehaviourState::Stopped, ..peer(1, Pose::default(), 0.0) }];
    assert_eq!(flock(&PARAMS, Twist::ZERO, &view(&stopped, Twist::ZERO, &limits)), Outcome::Stale("leader stopped"));
}

#[test]
fn two_robots_in_one_place_and_a_wall_in_it_still_give_a_finite_answer() {
    let limits = limits();
    let neighbours = [peer(1, Pose::default(), 0.0), peer(2, Pose::default(), 0.0)];
    let wall_b = Some(Vec2::new(0.3, 0.0));
    let got = solved(flock(&PARAMS, Twist::ZERO, &View { wall_b, ..view(&neighbours, Twist::ZERO, &limits) }));
    assert!(got.is_finite());
}

#[test]
fn a_held_robot_does_not_wind_up() {
    let limits = limits();
    let neighbours = [peer(1, Pose::new(5.0, 0.0, 0.0), 0.8)];
    let mut asked = Twist::ZERO;
    for _ in 0..1_000 {
        asked = solved(flock(&PARAMS, asked, &view(&neighbours, Twist::ZERO, &limits)));
    }
    assert!(asked.speed_mps <= LEAD_MPS + 0.2, "{asked:?}");
}

/// Five robots with random headings, the leader in front.
fn starts_wb(seed: u64) -> Vec<Pose> {
    let mut chance = Chance(seed);
    let spots = [(2.0, 0.0), (0.0, 1.0), (0.0, -1.0), (-2.0, 0.9), (-2.0, -0.9)];
    spots.iter().map(|(x, y)| Pose::new(*x, *y, chance.within(-3.1, 3.1))).collect()
}

/// They follow a leader at 0.8 m/s in free space.
fn free_flock(seed: u64) -> SimSwarm {
    let way = flock_config(vec![[10.0, 0.0], [20.0, 3.0], [40.0, 0.0]]);
    SimSwarm::new(&starts_wb(seed), &way, Place::default())
}

#[test]
fn followers_keep_up_with_a_leader_in_free_space_from_any_heading() {
    for seed in 0..20 {
        let mut swarm = free_flock(seed);
        swarm.run(30.0);
        let leader = swarm.bodies[0];
        for body in &swarm.bodies[1..] {
            let apart_m = (body.pose_wb.position() - leader.pose_wb.position()).norm();
            assert!(apart_m < 3.0 * 1.8, "seed {seed}: {apart_m} m behind");
            let vel_w = body.pose_wb.heading() * body.twist_b.speed_mps;
            let off_mps = (vel_w - leader.pose_wb.heading() * leader.twist_b.speed_mps).norm();
            assert!(off_mps < 0.25, "seed {seed}: {off_mps} m/s off the leader's velocity");
        }
        assert!(leader.twist_b.speed_mps > 0.75);
        assert!(swarm.gap_robot_m > 0.15, "seed {seed}: {} m", swarm.gap_robot_m);
    }
}

#[test]
fn followers_arrive_stop_and_say_so() {
    let mut swarm = free_flock(3);
    swarm.run(75.0);
    for (node, body) in swarm.nodes.iter().zip(&swarm.bodies) {
        let status = node.status();
        assert!(status.reached && status.state == BehaviourState::Done, "{}", status.verdict);
        assert!((status.progress - 1.0).abs() < 1e-12);
        assert_eq!(body.twist_b, Twist::ZERO);
    }
    assert!(swarm.gap_robot_m > 0.0);
}

#[test]
fn followers_pass_a_corridor_with_a_corner_and_pillars_without_contact() {
    let corners = [(-4.0, -2.5), (18.5, -2.5), (18.5, 16.0), (13.5, 16.0), (13.5, 2.5), (-4.0, 2.5)];
    let corners = corners.map(|(x, y)| Vec2::new(x, y));
    let walls = (0..6).map(|k| (corners[k], corners[(k + 1) % 6])).collect();
    let place = Place { walls, discs: vec![(Vec2::new(8.0, -1.6), 0.3), (Vec2::new(12.0, 1.7), 0.3)] };
    for seed in 0..5 {
        let way = flock_config(vec![[8.0, 0.0], [16.0, 0.0], [16.0, 8.0], [16.0, 12.0]]);
        let mut swarm = SimSwarm::new(&starts_wb(seed), &way, place.clone());
        swarm.run(80.0);
        assert!(swarm.gap_robot_m > 0.0 && swarm.gap_wall_m > 0.0, "seed {seed}");
        assert!(swarm.nodes.iter().all(|node| node.status().reached), "seed {seed}");
    }
}
