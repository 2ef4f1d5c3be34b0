use super::*;
use crate::testing::{Noise, Place, SimSwarm, beacon, flock_config, robot_file};
use drover_config::{Flock, Party};
use drover_contract::{Beam, Odometry, Vec2, Watchdog};
use drover_contract::{DriveState, Scan};

const START: Stamp = Stamp::from_millis(1_000);

fn way() -> Flock {
    flock_config(vec![[20.0, 0.0]])
}

fn node(id: u32) -> Node {
    Node::new(&robot_file(id, 2, Pose::default(), &way()), 7, START)
}

fn ready() -> Event {
    Event::Drive(DriveState::Ready(Watchdog::Fixed(Duration::from_millis(500))))
}

fn clear_scan(stamp: Stamp) -> Scan {
    Place::default().scan(Pose::default(), stamp)
}

fn odometry(stamp: Stamp, twist_b: Twist) -> Event {
    Event::Odometry(Odometry { stamp, twist_b, wheels: None })
}

/// Feeds everything that a robot needs every 50 ms, but for what `leave_out` names; the last command.
fn drive(node: &mut Node, from: Stamp, ticks: u64, leave_out: &str) -> (Stamp, SafeCommand) {
    let mut command = SafeCommand::STOP;
    let mut now = from;
    for _ in 0..ticks {
        now = now + Duration::from_millis(50);
        if leave_out != "drive" {
            node.handle_event(now, ready());
        }
        if leave_out != "odometry" {
            node.handle_event(now, odometry(now, command.twist_b()));
        }
        if leave_out != "scan" {
            node.handle_event(now, Event::Scan(clear_scan(now)));
        }
        command = node.tick(now);
    }
    (now, command)
}

#[test]
fn nothing_moves_before_drive_scan_and_odometry_are_there() {
    for missing in ["drive", "odometry", "scan"] {
        let mut node = node(1);
        let (_, command) = drive(&mut node, START, 20, missing);
        assert!(command.is_stop(), "without {missing}");
        assert_eq!(node.status().state, BehaviourState::Waiting);
    }
    let (_, command) = drive(&mut node(1), START, 20, "nothing");
    assert!(command.twist_b().speed_mps > 0.5);
}

#[test]
fn what_goes_silent_while_driving_stops_the_robot_within_its_timeout() {
    for (silent, timeout_ticks, label) in [("scan", 6, "scan old"), ("odometry", 4, "odometry old")] {
        let mut node = node(1);
        let (now, _) = drive(&mut node, START, 20, "nothing");
        let (now, command) = drive(&mut node, now, timeout_ticks, silent);
        assert!(!command.is_stop(), "{silent}: still within the timeout");
        let (_, command) = drive(&mut node, now, 1, silent);
        assert!(command.is_stop(), "{silent}");
        assert_eq!(node.status().counters.changed.get(label), Some(&1));
        assert_eq!(node.status().counters.stops, 1);
    }
}

#[test]
fn a_late_tick_is_a_stop_and_the_next_one_starts_from_rest() {
    let mut node = node(1);
    let (now, fast) = drive(&mut node, START, 40, "nothing");
    assert!(fast.twist_b().speed_mps > 0.7);
    let (now, late) = drive(&mut node, now + Duration::from_millis(60), 1, "nothing");
    assert!(late.is_stop());
    assert_eq!(node.status().counters.late_ticks, 1);
    let (_, next) = drive(&mut node, now, 1, "nothing");
    assert!(next.twist_b().speed_mps <= 0.051, "{next:?}");
}

#[test]
fn after_a_drive_was_lost_the_first_command_is_fresh() {
    let mut node = node(2);
    let leader = |seq: u32, x_m: f64| Beacon { pose_wb: Pose::new(x_m, 0.0, 0.0), ..beacon(1, seq) };
    let mut now = START;
    for seq in 1..60 {
        node.handle_beacon(now, &Beacon { sent: now, ..leader(seq, 6.0) });
        now = drive(&mut node, now, 1, "nothing").0;
    }
    assert!(node.status().command.twist_b().speed_mps > 0.1);
    node.handle_event(now, Event::Drive(DriveState::Refused("taken by the remote control".into())));
    now = now + Duration::from_millis(50);
    assert!(node.tick(now).is_stop());
    node.handle_beacon(now, &Beacon { sent: now, ..leader(99, 6.0) });
    let (_, first) = drive(&mut node, now, 1, "nothing");
    assert!(first.twist_b().speed_mps.abs() <= 0.051, "{first:?}");
}

#[test]
fn a_stop_is_latched_and_told_to_the_peers() {
    let mut node = node(1);
    let (now, _) = drive(&mut node, START, 20, "nothing");
    node.handle_stop(now, StopReason::Operator);
    assert!(node.status().command.is_stop());
    let (now, command) = drive(&mut node, now, 20, "nothing");
    assert!(command.is_stop());
    let told = node.poll_beacon(now).map(|beacon| beacon.state);
    assert_eq!(told, Some(BehaviourState::Stopped));
}

#[test]
fn a_blind_scan_and_one_with_numbers_that_are_none_stop_the_robot() {
    let mut node = node(1);
    let (now, _) = drive(&mut node, START, 20, "nothing");
    let now = now + Duration::from_millis(50);
    let mut scan = clear_scan(now);
    scan.beams[..40].fill(Beam::Unknown);
    node.handle_event(now, odometry(now, Twist::ZERO));
    node.handle_event(now, Event::Scan(scan));
    assert!(node.tick(now).is_stop());
    assert_eq!(node.status().verdict, Verdict::Held(Reason::ScanBlind));
}

#[test]
fn nan_anywhere_never_moves_the_robot() {
    let nan = f64::NAN;
    let mut node = node(1);
    let mut now = START;
    for _ in 0..20 {
        now = now + Duration::from_millis(50);
        node.handle_event(now, ready());
        node.handle_event(now, odometry(now, Twist::new(nan, 0.0)));
        let mut scan = clear_scan(now);
        scan.beams[3] = Beam::Hit(nan);
        node.handle_event(now, Event::Scan(scan));
        let pose_wb = Pose { x_m: nan, y_m: nan, yaw_rad: nan };
        node.handle_beacon(now, &Beacon { pose_wb, ..beacon(2, 1) });
        assert!(node.tick(now).is_stop());
    }
}

#[test]
fn beacons_come_at_their_rate_with_growing_numbers_and_are_not_made_up_for() {
    let mut node = node(1);
    let first = node.poll_beacon(START).unwrap();
    assert_eq!((first.robot, first.epoch, first.seq, first.state), (RobotId(1), 7, 1, BehaviourState::Waiting));
    assert_eq!(first.leader, Some(RobotId(1)), "it leads");
    assert_eq!(node.poll_beacon(START + Duration::from_millis(99)), None);
    assert_eq!(node.poll_beacon(START + Duration::from_millis(100)).unwrap().seq, 2);
    let late = START + Duration::from_secs(5);
    assert_eq!(node.poll_beacon(late).unwrap().seq, 3);
    assert_eq!(node.poll_beacon(late), None);
}

#[test]
fn the_next_deadline_is_named_and_lies_ahead_once_handled() {
    let mut node = node(1);
    let mut now = START;
    for _ in 0..200 {
        let (due, name) = node.poll_timeout();
        now = now.max(due);
        match name {
            "tick" => drop(node.tick(now)),
            _ => assert!(node.poll_beacon(now).is_some(), "{name} was due"),
        }
    }
    assert!(now > START + Duration::from_secs(5), "deadlines move on: {now}");
}

#[test]
fn two_robots_head_on_never_touch_with_beacons_200_ms_old() {
    // Both are leaders of their own file with ways through each other; sight is taken away in the second round.
    for silent in [false, true] {
        let starts = [Pose::new(-5.0, 0.0, 0.0), Pose::new(5.0, 0.05, std::f64::consts::PI)];
        let mut swarm = SimSwarm::new(&starts, &flock_config(vec![[20.0, 0.0]]), Place::default());
        let parties = vec![Party::of_all(2, vec![[-20.0, 0.0]])];
        let back = Flock { parties, ..flock_config(Vec::new()) };
        swarm.nodes[1] = Node::new(&robot_file(2, 2, starts[1], &back), 1, swarm.now);
        swarm.beacon_ms = 200;
        swarm.silent = vec![silent; 2];
        swarm.blind_to_peers = !silent;
        swarm.run(30.0);
        assert!(swarm.gap_robot_m > 0.0, "silent {silent}: {} m", swarm.gap_robot_m);
        assert!(swarm.gap_robot_m < 1.0, "they met at all");
    }
}

#[test]
fn followers_stop_when_their_leader_goes_silent_and_go_on_when_it_is_back() {
    let starts = [Pose::new(2.0, 0.0, 0.0), Pose::default(), Pose::new(-2.0, 0.0, 0.0)];
    let mut swarm = SimSwarm::new(&starts, &flock_config(vec![[60.0, 0.0]]), Place::default());
    swarm.run(10.0);
    swarm.silent[0] = true;
    swarm.run(3.0);
    for index in [1, 2] {
        assert_eq!(swarm.nodes[index].status().verdict, Verdict::Held(Reason::Law("leader lost")));
        assert_eq!(swarm.bodies[index].twist_b, Twist::ZERO);
    }
    swarm.silent[0] = false;
    swarm.run(10.0);
    assert_eq!(swarm.nodes[1].status().verdict, Verdict::Driving);
    swarm.stop(0);
    swarm.run(3.0);
    assert_eq!(swarm.nodes[1].status().verdict, Verdict::Held(Reason::Law("leader stopped")));
    assert!(swarm.gap_robot_m > 0.0);
}

#[test]
fn a_lost_follower_does_not_hold_the_others_up() {
    let starts = [Pose::new(2.0, 0.0, 0.0), Pose::new(0.0, 1.0, 0.0), Pose::new(0.0, -1.0, 0.0)];
    let mut swarm = SimSwarm::new(&starts, &flock_config(vec![[20.0, 0.0]]), Place::default());
    swarm.run(4.0);
    swarm.stop(2);
    swarm.silent[2] = true;
    swarm.run(50.0);
    assert!(swarm.nodes[0].status().reached && swarm.nodes[1].status().reached);
    assert!(!swarm.nodes[2].status().reached);
}

#[test]
fn the_same_inputs_give_the_same_swarm_twice() {
    let starts = [Pose::new(2.0, 0.0, 0.3), Pose::new(0.0, 1.0, 2.0), Pose::new(0.0, -1.0, -1.0)];
    let run = || {
        let mut swarm = SimSwarm::new(&starts, &way(), Place::room((-5.0, 25.0), (-4.0, 4.0)));
        swarm.run(20.0);
        swarm.nodes.iter().map(|node| node.status().clone()).collect::<Vec<_>>()
    };
    assert_eq!(run(), run());
}

#[test]
fn noise_dropout_and_drift_bring_no_contact_and_stop_nobody() {
    let starts = [(2.0, 0.0), (0.0, 1.0), (0.0, -1.0), (-2.0, 0.9), (-2.0, -0.9)].map(|(x, y)| Pose::new(x, y, 0.0));
    let mut place = Place::room((-5.0, 26.0), (-4.0, 4.0));
    place.discs = vec![(Vec2::new(8.0, 2.2), 0.4), (Vec2::new(14.0, -2.0), 0.5)];
    for range_m in [0.01, 0.03] {
        let mut swarm = SimSwarm::new(&starts, &way(), place.clone());
        swarm.noise = Noise { range_m, dropout: 0.02, odometry: 0.05 };
        swarm.run(60.0);
        assert!(swarm.gap_robot_m > 0.0 && swarm.gap_wall_m > 0.0);
        for node in &swarm.nodes {
            assert!(node.status().reached, "{}: {}", node.id, node.status().verdict);
        }
    }
}

#[test]
fn a_robot_that_had_a_fix_stops_when_it_is_gone() {
    let mut node = node(1);
    let (now, _) = drive(&mut node, START, 20, "nothing");
    node.handle_event(now, Event::Pose(drover_contract::PoseFix { stamp: now, pose_wb: Pose::default() }));
    let (now, command) = drive(&mut node, now, 4, "nothing");
    assert!(!command.is_stop());
    let (_, command) = drive(&mut node, now, 1, "nothing");
    assert!(command.is_stop());
    assert_eq!(node.status().verdict, Verdict::Held(Reason::PoseOld));
}
