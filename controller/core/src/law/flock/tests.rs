use super::laser::wall_direction_w;
use super::literal::Literal;
use super::potential::{drive, pair_force};
use super::*;
use crate::estimate::Motion;
use crate::links::{LinkPeer, Place as LinkPlace};
use crate::testing::{Chance, Place, SimSwarm, flock_config, limits, robot_file};
use drover_config::{LeaderLoss, Party};
use drover_contract::{BehaviourState, Limits, Pose, Stamp};
use std::f64::consts::PI;

const TICK_S: f64 = 0.05;

fn params(flock: &Flock) -> Params {
    let kind = robot_file(2, 5, Pose::default(), flock).kind;
    Params::new(flock, &kind, RobotId(2), TICK_S)
}

fn literal() -> Params {
    let flock = flock_config(vec![[20.0, 0.0]]);
    let laser_rad = PI;
    Params { mode: FlockMode::Literal, reverse: true, laser_rad, walls: WallFollowing::Literal, ..params(&flock) }
}

fn peer(id: u32, pose_wb: Pose, speed_mps: f64) -> Neighbour {
    Neighbour {
        id: RobotId(id),
        pose_wb,
        twist_b: Twist::new(speed_mps, 0.0),
        accel_mps2: 0.0,
        state: BehaviourState::Active,
        leader: Some(RobotId(1)),
        radius_m: 0.4,
    }
}

fn view<'a>(neighbours: &'a [Neighbour], twist_b: Twist, limits: &'a Limits) -> View<'a> {
    let motion = Motion { pose_wb: Pose::default(), twist_b, accel_mps2: 0.0, pos_bound_m: 0.0 };
    View {
        now: Stamp::ZERO,
        dt_s: TICK_S,
        motion,
        neighbours,
        walls_b: &[],
        points_b: &[],
        unseen_b: &[],
        scan: None,
        bodies: &[],
        discs: &[],
        limits,
    }
}

/// What a literal follower asks for that asked for `before` in the tick before.
fn asked(before: Twist, view: &View<'_>) -> Twist {
    let params = literal();
    let leader = view.neighbours.iter().find(|peer| peer.id == params.leader).expect("a leader");
    Literal::of(before).step(&params, leader, view)
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
    let got = asked(twist, &view(&neighbours, twist, &limits));
    assert!((got.speed_mps - 0.8).abs() < 1e-12 && got.yaw_rate_radps.abs() < 1e-12, "{got:?}");
}

#[test]
fn a_follower_that_is_behind_speeds_up_and_one_that_is_too_near_slows_down() {
    let limits = limits();
    let twist = Twist::new(0.8, 0.0);
    let ask = |gap_m: f64| asked(twist, &view(&[peer(1, Pose::new(gap_m, 0.0, 0.0), 0.8)], twist, &limits)).speed_mps;
    assert!(ask(3.0) > 0.8);
    assert!(ask(1.2) < 0.8);
    assert!(ask(50.0) < ask(3.0), "as printed, the pull fades with the distance");
}

#[test]
fn the_damping_of_the_turn_is_that_of_the_reference_point() {
    // Alone with a leader at the rest distance, a turning robot loses k d^2 / I of its turn a second.
    let limits = limits();
    let twist = Twist::new(0.0, 0.5);
    let got = asked(twist, &view(&[peer(1, Pose::new(1.8, 0.0, 0.0), 0.0)], twist, &limits));
    let expected = 0.5 * (1.0 - 1.5 * 0.3 * 0.3 / 0.04 * TICK_S);
    assert!((got.yaw_rate_radps - expected).abs() < 1e-12, "{got:?}, expected {expected}");
}

#[test]
fn the_leaders_acceleration_is_fed_forward() {
    let limits = limits();
    let twist = Twist::new(0.5, 0.0);
    let neighbours = [Neighbour { accel_mps2: 0.4, ..peer(1, Pose::new(1.8, 0.0, 0.0), 0.5) }];
    let got = asked(twist, &view(&neighbours, twist, &limits));
    assert!((got.speed_mps - (0.5 + 0.4 * TICK_S)).abs() < 1e-12);
}

#[test]
fn equation_10_clips_both_ways_and_without_reverse_at_zero() {
    let params = literal();
    let motion = view(&[], Twist::ZERO, &limits()).motion;
    let pushed =
        |params: &Params, force_mps2: f64| drive(params, Vec2::new(force_mps2, 1e3), Twist::ZERO, (&motion, TICK_S));
    assert_eq!(pushed(&params, 1e4), Twist::new(params.speed_mps, params.turn_radps));
    assert_eq!(pushed(&params, -1e4), Twist::new(-params.speed_mps, params.turn_radps));
    assert!(pushed(&Params { reverse: false, ..params }, -1e4).speed_mps.abs() < 1e-12);
}

#[test]
fn the_walls_direction_is_a_mean_of_lines_and_not_of_arcs() {
    // A wall from south to north whose segments lean a little to either side: arcs of +-85 degrees average to 0.
    let wall = [(1.0, -1.0), (1.1, 0.0), (1.0, 1.0), (1.1, 2.0)].map(|(x, y)| Vec2::new(x, y));
    let along_w = wall_direction_w(wall.into_iter()).expect("a direction");
    assert!(along_w.y.abs() > 0.99, "{along_w:?}");
    assert_eq!(wall_direction_w(wall[..1].iter().copied()), None, "one return has no direction");
}

#[test]
fn a_literal_robot_in_a_trap_follows_the_wall_and_leaves_it_when_the_attractor_is_on_its_side() {
    let (params, limits) = (Params { deadlock: Duration::from_millis(100), ..literal() }, limits());
    let wall_b: Vec<Vec2> = (-5..=5).map(|k| Vec2::new(0.7, f64::from(k) * 0.1)).collect();
    let beyond = [peer(1, Pose::new(4.0, 0.5, 0.0), 0.0)];
    let mut mind = Literal::default();
    let mut ask = |tick: u64, neighbours: &[Neighbour], walls_b: &[Vec2]| {
        let now = Stamp::from_millis(tick * 50);
        let view = View { now, walls_b, ..view(neighbours, Twist::ZERO, &limits) };
        mind.step(&params, &neighbours[0], &view);
        mind.on_wall()
    };
    assert!(!ask(0, &beyond, &wall_b) && !ask(1, &beyond, &wall_b), "the window is not over");
    assert!(ask(3, &beyond, &wall_b), "standing in front of a wall, with the leader behind it");
    assert!(ask(4, &beyond, &wall_b));
    let before = [peer(1, Pose::new(-4.0, 0.5, 0.0), 0.0)];
    assert!(!ask(5, &before, &wall_b), "an acute angle ends it");
    assert!(!ask(6, &beyond, &wall_b), "not at once again");
    assert!(ask(20, &beyond, &wall_b));
    assert!(!ask(21, &beyond, &[]), "and so does a wall out of sight");
}

#[test]
fn two_robots_in_one_place_and_a_wall_in_it_still_give_a_finite_answer() {
    let limits = limits();
    let neighbours = [peer(1, Pose::default(), 0.0), peer(3, Pose::default(), 0.0)];
    let walls_b = [Vec2::zeros(), Vec2::new(0.3, 0.0)];
    let view = View { walls_b: &walls_b, ..view(&neighbours, Twist::ZERO, &limits) };
    assert!(asked(Twist::ZERO, &view).is_finite());
    let mut law = flocker(&flock_config(vec![[20.0, 0.0]]));
    assert!(matches!(law.step(&view), Outcome::Solved(twist) if twist.is_finite()));
}

fn flocker(flock: &Flock) -> Flocker {
    let kind = robot_file(2, 5, Pose::default(), flock).kind;
    Flocker::new(flock, &kind, RobotId(2), TICK_S)
}

#[test]
fn without_its_leader_or_behind_a_stopped_one_the_law_has_no_answer() {
    let limits = limits();
    let mut law = flocker(&flock_config(vec![[20.0, 0.0]]));
    let others = [peer(3, Pose::new(1.8, 0.0, 0.0), 0.8)];
    assert_eq!(law.step(&view(&others, Twist::ZERO, &limits)), Outcome::Stale("leader lost"));
    let stopped = [Neighbour { state: BehaviourState::Stopped, ..peer(1, Pose::default(), 0.0) }];
    assert_eq!(law.step(&view(&stopped, Twist::ZERO, &limits)), Outcome::Stale("leader stopped"));
}

#[test]
fn nobody_drifts_onto_another_partys_leader() {
    let limits = limits();
    let party = |leader, first_id, last_id| Party { leader, first_id, last_id, waypoints_m: vec![[20.0, 0.0]] };
    let flock = Flock {
        parties: vec![party(1, 1, 10), party(11, 11, 20)],
        leader_loss: LeaderLoss::Elect,
        ..flock_config(Vec::new())
    };
    let mut law = flocker(&flock);
    let other = [Neighbour { leader: Some(RobotId(11)), ..peer(11, Pose::new(1.0, 0.0, 0.0), 0.8) }];
    for tick in 0..40 {
        let view = View { now: Stamp::from_millis(tick * 50), ..view(&other, Twist::ZERO, &limits) };
        assert_eq!(law.step(&view), Outcome::Stale("leader lost"), "tick {tick}");
    }
}

#[test]
fn a_leader_that_falls_silent_is_replaced_by_the_first_that_says_so() {
    let limits = limits();
    let flock = Flock { leader_loss: LeaderLoss::Elect, ..flock_config(vec![[20.0, 0.0]]) };
    let mut law = flocker(&flock);
    let at = |tick: u64, peers: &[Neighbour], law: &mut Flocker| {
        law.step(&View { now: Stamp::from_millis(tick * 50), ..view(peers, Twist::ZERO, &limits) });
        law.leader()
    };
    let claims = |id: u32| Neighbour { leader: Some(RobotId(id)), ..peer(id, Pose::new(2.0, 0.0, 0.0), 0.5) };
    let third = peer(3, Pose::new(-2.0, 0.0, 0.0), 0.0);
    assert_eq!(at(0, &[claims(1), third], &mut law), RobotId(1));
    assert_eq!(at(59, &[third], &mut law), RobotId(1), "silence must last");
    assert_eq!(at(60, &[third], &mut law), RobotId(2), "the lowest id of those left claims the lead");
    assert_eq!(law.follows(), Some(RobotId(2)), "and says so");
    assert_eq!(at(61, &[claims(3)], &mut law), RobotId(2), "a claim of a higher id does not count");
    assert_eq!(at(62, &[claims(1)], &mut law), RobotId(1), "the file's leader is back");
    assert_eq!(at(63, &[claims(3)], &mut law), RobotId(3), "a mate that leads while nobody better does");
}

#[test]
fn a_leader_waits_for_stragglers_only_if_it_is_to_lose_nobody() {
    let limits = limits();
    let speed = |x_m: f64, lose_nobody: bool| {
        let flock = Flock { lose_nobody, ..flock_config(vec![[20.0, 0.0]]) };
        let kind = robot_file(1, 5, Pose::default(), &flock).kind;
        let mut law = Flocker::new(&flock, &kind, RobotId(1), TICK_S);
        match law.step(&view(&[peer(2, Pose::new(x_m, 0.0, 0.0), 0.0)], Twist::ZERO, &limits)) {
            Outcome::Solved(twist) => twist.speed_mps,
            Outcome::Stale(why) => panic!("{why}"),
        }
    };
    assert!((speed(-1e4, false) - 0.8).abs() < 1e-12, "it does not wait");
    assert!((speed(-5.0, true) - 0.8).abs() < 1e-12);
    assert!(speed(-8.0, true) < 0.8);
    assert!(speed(-1e4, true).abs() < 1e-12);
}

#[test]
fn a_wish_into_a_wall_slides_and_never_goes_through() {
    let mut planes = planes::Planes::default();
    planes.push(planes::Plane { normal_w: Vec2::new(1.0, 0.0), most_mps: 0.1 });
    assert!((planes.nearest(Vec2::new(1.0, 0.5)) - Vec2::new(0.1, 0.5)).norm() < 1e-12);
    planes.push(planes::Plane { normal_w: Vec2::new(0.0, 1.0), most_mps: 0.0 });
    assert!((planes.nearest(Vec2::new(1.0, 0.5)) - Vec2::new(0.1, 0.0)).norm() < 1e-12, "the corner");
    // Who would have to back off into a wall need not.
    planes.push(planes::Plane { normal_w: Vec2::new(-1.0, 0.0), most_mps: -0.3 });
    assert!((planes.nearest(Vec2::new(1.0, 0.5)) - Vec2::new(0.1, 0.0)).norm() < 1e-12);
    assert!(planes.nearest(Vec2::new(-1.0, 0.0)).norm() < 1e-12);
}

#[test]
fn the_hand_on_the_wall_goes_round_a_tip_and_leaves_towards_the_attractor() {
    use super::pledge::{Along, Pledge, Room};
    // The end of a wall from the west, at the origin; the robot is south of it, the attractor north.
    let wall: Vec<(Vec2, f64)> = (0..200).map(|k| (Vec2::new(-0.01 * f64::from(k), 0.0), 0.3)).collect();
    let attractor_w = Vec2::new(-1.0, 5.0);
    let mut at_w = Vec2::new(-1.0, -0.35);
    let pose_wb = Pose::new(at_w.x, at_w.y, 0.0);
    let mut pledge = Pledge::begin(Stamp::ZERO, Vec2::new(-1.0, 0.0), Vec2::new(-0.9, 0.65), &pose_wb);
    for tick in 0..2_000 {
        let near: Vec<(Vec2, f64)> = wall
            .iter()
            .map(|(p, keep)| (*p, keep.min((p - at_w).norm())))
            .filter(|(p, _)| (p - at_w).norm() < 1.0)
            .collect();
        let room = Room { at_w, points_w: &near, walls: near.len(), look_m: 0.27 };
        match pledge.step(Stamp::from_millis(tick * 10), &room, attractor_w) {
            Along::Way(way_w) => at_w += way_w * 0.01,
            Along::Nowhere => panic!("no way at {at_w:?}"),
            Along::Done => {
                assert!(at_w.y > 0.0, "round the tip: {at_w:?}");
                return;
            }
        }
        let gap_m = wall.iter().map(|(p, _)| (p - at_w).norm()).fold(f64::INFINITY, f64::min);
        assert!((0.28..0.5).contains(&gap_m), "{gap_m} m from the wall at {at_w:?}");
    }
    panic!("it never left the wall: {at_w:?}");
}

#[test]
fn a_peer_in_the_way_turns_nothing_that_counts_and_never_holds_the_hand() {
    use super::pledge::{Along, Pledge, Room};
    // A straight wall north of the robot, the attractor behind it; the hand goes east.
    let wall: Vec<(Vec2, f64)> = (-100..100).map(|k| (Vec2::new(0.01 * f64::from(k), 0.35), 0.3)).collect();
    let attractor_w = Vec2::new(0.1, 5.0);
    let at_w = Vec2::zeros();
    let mut pledge = Pledge::begin(Stamp::ZERO, Vec2::new(0.0, 0.35), attractor_w, &Pose::default());
    let wall_w = |pledge: &Pledge| pledge.wall_w().y;
    let mut step = |peers: &[(Vec2, f64)], tick: u64| {
        let points: Vec<(Vec2, f64)> = wall.iter().chain(peers).copied().collect();
        let room = Room { at_w, points_w: &points, walls: wall.len(), look_m: 0.27 };
        let way = pledge.step(Stamp::from_millis(tick * 10), &room, attractor_w);
        assert!((wall_w(&pledge) - 0.35).abs() < 1e-9, "the hand stays on the wall");
        way
    };
    let Along::Way(first_w) = step(&[], 0) else { panic!("a way") };
    assert!(first_w.x > 0.9, "east: {first_w:?}");
    // All around stand peers but in the west: the way is more than half a turn from where it was.
    let ring = |k: i32| (Vec2::new(0.2 * libm::cos(0.1 * f64::from(k)), 0.2 * libm::sin(0.1 * f64::from(k))), 0.1);
    let peers: Vec<(Vec2, f64)> = (-24..=9).map(ring).collect();
    let Along::Way(round_w) = step(&peers, 1) else { panic!("a way") };
    assert!(round_w.x < 0.0, "{round_w:?}");
    // They go: the turns are what they were, and it is still no time to leave.
    for tick in 2..50 {
        let Along::Way(again_w) = step(&[], tick) else { panic!("still behind the wall") };
        assert!((again_w - first_w).norm() < 0.1, "{again_w:?}");
    }
}

#[test]
fn places_of_the_last_moments_stay_and_older_ones_go() {
    use super::recent::Recent;
    let flock = flock_config(vec![[20.0, 0.0]]);
    let params = params(&flock);
    let limits = limits();
    let mut recent = Recent::default();
    let walls_b = [Vec2::new(0.5, 0.0), Vec2::new(0.0, 5.0)];
    let mut see = |walls_b: &[Vec2], millis: u64| {
        let view = view(&[], Twist::ZERO, &limits);
        recent.look(&params, &View { now: Stamp::from_millis(millis), walls_b, ..view })
    };
    assert_eq!(see(&walls_b, 0), [Vec2::new(0.5, 0.0)], "what is beyond S does not count");
    assert_eq!(see(&[], 200), [Vec2::new(0.5, 0.0)]);
    assert_eq!(see(&[Vec2::new(0.4, 0.001)], 250), [Vec2::new(0.4, 0.001)], "the nearest of a direction");
    assert!(see(&[], 5_000).is_empty());
}

#[test]
fn a_trail_is_passed_place_by_place_and_not_through_a_wall() {
    use super::trail::Trail;
    let flock = flock_config(vec![[20.0, 0.0]]);
    let params = params(&flock);
    let mut trail = Trail::default();
    let heard = |x_m: f64, y_m: f64| peer(1, Pose::new(x_m, y_m, 0.0), 0.5);
    let at_w = Vec2::new(-3.0, 0.0);
    // The leader goes east past the end of a wall that lies north of us, and comes back behind it.
    let wall_w: Vec<Vec2> = (-60..20).map(|k| Vec2::new(0.1 * f64::from(k), 0.9)).collect();
    let way = (0..60).map(|k| (0.1 * f64::from(k) - 3.0, 0.0)).chain((0..20).map(|k| (3.0, 0.1 * f64::from(k))));
    for (x_m, y_m) in way.chain((0..60).map(|k| (3.0 - 0.1 * f64::from(k), 2.0))) {
        trail.hear(&params, &heard(x_m, y_m), (at_w, &wall_w), 0.0);
    }
    assert!(trail.aim(&params, at_w, &wall_w).is_none(), "nothing is wrong yet");
    assert!(trail.turn_back() && !trail.turn_back(), "news once");
    let aim = trail.aim(&params, at_w, &wall_w).expect("a trail");
    assert!(aim.clear && aim.place_w.y < 0.1 && aim.place_w.x > at_w.x, "along it, not straight: {aim:?}");
    // It goes from aim to aim and comes out behind the wall.
    let mut at_w = at_w;
    for _ in 0..1_000 {
        let Some(aim) = trail.aim(&params, at_w, &wall_w) else { break };
        at_w += (aim.place_w - at_w).cap_magnitude(0.05);
        trail.hear(&params, &heard(-2.9, 2.0), (at_w, &wall_w), 0.0);
        let gap_m = wall_w.iter().map(|place_w| (place_w - at_w).norm()).fold(f64::INFINITY, f64::min);
        assert!(gap_m > params.radius_m, "{at_w:?}");
    }
    assert!(trail.aim(&params, at_w, &wall_w).is_none() && at_w.y > 0.9, "{at_w:?}");
    // Another leader, or one that was not heard for a while: nothing is known.
    trail.hear(&params, &heard(30.0, 2.0), (at_w, &wall_w), 0.0);
    assert!(!trail.turn_back());
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

/// Somebody who keeps links as long as `link_m`.
fn tied(flock: &Flock, link_m: f64) -> Params {
    Params { link_m, ..params(flock) }
}

#[test]
fn who_keeps_links_slides_along_their_rims_and_gives_slack_while_it_flocks() {
    let (params, limits) = (tied(&flock_config(vec![[20.0, 0.0]]), 4.0), limits());
    let disc = |x_m: f64| [Disc { centre_w: Vec2::new(x_m, 0.0), radius_m: 2.0 }];
    let wish = Vec2::new(1.0, 0.5);
    let left = |x_m: f64| {
        let discs = disc(x_m);
        let view = View { discs: &discs, ..view(&[], Twist::ZERO, &limits) };
        let drawn_w = bonds::drawn_w(wish, &params, &view);
        (
            bonds::held(planes::Planes::default(), &params, &view).nearest(wish),
            drawn_w,
            bonds::is_at_rim(&params, &view),
        )
    };
    assert_eq!(left(0.0), (wish, wish, false), "in the middle nothing is asked");
    let (held_w, drawn_w, at_rim) = left(-2.0);
    assert!((held_w - Vec2::new(0.0, 0.5)).norm() < 1e-9 && at_rim, "at the rim it slides: {held_w:?}");
    assert!(drawn_w.x < wish.x, "and is drawn back: {drawn_w:?}");
    let (held_w, _, at_rim) = left(-1.9);
    assert!(
        held_w.x > 0.0 && held_w.x <= 0.1 / params.settle_s + 1e-9 && !at_rim,
        "before it, it slows down: {held_w:?}"
    );
    let body = Params { inner_m: 0.15, ..params };
    let view = View { discs: &disc(-1.86), ..view(&[], Twist::ZERO, &limits) };
    assert!(bonds::is_at_rim(&body, &view) && !bonds::is_at_rim(&params, &view), "a body keeps farther inside");
}

#[test]
fn a_leader_waits_before_its_partys_worst_link_is_taut_and_for_no_other_party() {
    let (limits, flock) = (limits(), flock_config(vec![[20.0, 0.0]]));
    let flock = Flock { parties: vec![Party { last_id: 5, ..Party::of_all(1, vec![[20.0, 0.0]]) }], ..flock };
    let params = Params { own: RobotId(1), ..tied(&flock, 5.0) };
    let pace = |places: &[(u32, f64)]| {
        let peers: Vec<Neighbour> = places.iter().map(|(id, x_m)| peer(*id, Pose::new(*x_m, 0.0, 0.0), 0.0)).collect();
        bonds::pace(&params, &view(&peers, Twist::ZERO, &limits))
    };
    assert!((pace(&[(2, -2.0), (3, -4.0), (4, -6.0)]) - 1.0).abs() < 1e-12, "a chain of short links");
    assert!(pace(&[(2, -4.5)]).abs() < 1e-12);
    assert!(pace(&[(2, -1.0), (3, -5.5)]).abs() < 1e-12, "whoever's link it is");
    assert!((0.1..0.9).contains(&pace(&[(2, -3.0)])), "slower and slower");
    assert!((pace(&[(2, -2.0), (11, 30.0)]) - 1.0).abs() < 1e-12);
    let free = Params { link_m: 0.0, ..params };
    assert!(
        (bonds::pace(&free, &view(&[peer(2, Pose::new(-9.0, 0.0, 0.0), 0.0)], Twist::ZERO, &limits)) - 1.0).abs()
            < 1e-12
    );
}

/// One exchange of what robots `ids` with links report, all at one place each `x_m` apart; their laws.
fn agree(ids: &[u32], x_m: f64, seconds: u64) -> Vec<Flocker> {
    let party = |leader, first_id, last_id| Party { leader, first_id, last_id, waypoints_m: vec![[20.0, 0.0]] };
    let parties = vec![party(1, 1, 5), party(6, 6, 9)];
    let flock = Flock { guard: FlockGuard::Full, link_range_m: 8.0, parties, ..flock_config(Vec::new()) };
    let law = |id: &u32| Flocker::on_body(&flock, &robot_file(*id, 9, Pose::default(), &flock), 1, Stamp::ZERO);
    let mut laws: Vec<Flocker> = ids.iter().map(law).collect();
    let place_w = |at: usize| Vec2::new(x_m * at as f64, 0.0);
    let heard = |at: usize| LinkPeer { id: RobotId(ids[at]), pos_w: place_w(at), vel_w: Vec2::zeros(), age_s: 0.0 };
    for tick in 0..seconds * 10 {
        let now = Stamp::from_millis(tick * 100);
        for at in 0..ids.len() {
            let others = (0..ids.len()).filter(|other| *other != at);
            let peers: Vec<LinkPeer> = others.clone().map(heard).collect();
            let place = |at| LinkPlace { pos_w: place_w(at), wish_w: Vec2::zeros(), stop_m: 0.0 };
            let report = laws[at].attend(now, &place(at), &peers).expect("links are kept");
            others.for_each(|other| laws[other].handle_report(now, &report, &place(other)));
        }
    }
    laws
}

#[test]
fn bodies_agree_on_links_within_their_party_and_stand_until_they_did() {
    let discs = |law: &Flocker| {
        let mut discs = Vec::new();
        law.discs(&mut |disc| discs.push(disc));
        discs
    };
    let limits = limits();
    let speed = |law: &mut Flocker| {
        let Outcome::Solved(twist) = law.step(&view(&[], Twist::ZERO, &limits)) else {
            panic!("a leader has an answer")
        };
        twist.speed_mps
    };
    let mut young = agree(&[1, 2, 6], 2.0, 1);
    assert!(speed(&mut young[0]).abs() < 1e-12, "it stands while links are being agreed");
    let mut laws = agree(&[1, 2, 6], 2.0, 6);
    let radius_m = 4.0 - 0.3;
    assert!(matches!(discs(&laws[0])[..], [disc] if (disc.radius_m - radius_m).abs() < 1e-9), "half less the error");
    assert_eq!(discs(&laws[0]), discs(&laws[1]));
    assert!(discs(&laws[2]).is_empty(), "two parties are not tied together");
    assert!(laws[0].relies_on(RobotId(2)) && !laws[0].relies_on(RobotId(6)));
    assert!(speed(&mut laws[0]) > 0.1);
    let mut far = agree(&[1, 2], 7.5, 6);
    assert!(discs(&far[0]).is_empty() && speed(&mut far[0]) >= 0.0, "no longer link is begun");
}
