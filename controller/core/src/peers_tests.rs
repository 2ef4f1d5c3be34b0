use super::*;
use crate::testing::beacon;

fn peers() -> Peers {
    knowing(1..=3)
}

fn knowing(ids: impl Iterator<Item = u32>) -> Peers {
    let roster = Roster::new(ids.map(|id| (RobotId(id), 0.4)));
    Peers::new(RobotId(1), Arc::new(roster), Duration::from_millis(500))
}

fn followable(peers: &Peers, now: Stamp) -> Vec<Neighbour> {
    peers.followable(now).collect()
}

fn bodies(peers: &Peers, now: Stamp) -> Vec<Body> {
    peers.bodies(now, Vec2::zeros(), f64::INFINITY).collect()
}

fn ms(at: u64) -> Stamp {
    Stamp::from_millis(at)
}

#[test]
fn a_fresh_peer_is_followed_and_carried_forward_and_an_aged_one_is_not() {
    let mut peers = peers();
    let twist_b = Twist::new(1.0, 0.0);
    let leader = Some(RobotId(3));
    peers.handle_beacon(ms(1_000), &Beacon { twist_b, pose_wb: Pose::new(4.0, 0.0, 0.0), leader, ..beacon(2, 1) });
    let seen = followable(&peers, ms(1_200));
    assert_eq!(seen.len(), 1);
    assert_eq!(seen[0].leader, leader);
    assert!((seen[0].pose_wb.x_m - 4.2).abs() < 1e-9);
    assert_eq!(followable(&peers, ms(1_501)), vec![]);
    assert_eq!(peers.heard(ms(1_501)), 0);
}

#[test]
fn every_body_ever_heard_of_counts_for_collision_whatever_its_state_and_age() {
    let mut peers = peers();
    let twist_b = Twist::new(1.0, 0.0);
    let stopped = BehaviourState::Stopped;
    peers.handle_beacon(ms(0), &Beacon { twist_b, state: stopped, ..beacon(2, 1) });
    let young = bodies(&peers, ms(100))[0];
    let aged = bodies(&peers, ms(900))[0];
    assert!(aged.bound_m > young.bound_m);
    assert!((aged.pos_w.x - 0.5).abs() < 1e-9, "carried forward no longer than it may be followed");
    let silent = bodies(&peers, ms(60_000))[0];
    assert_eq!(silent.pos_w, aged.pos_w);
    assert!(silent.bound_m < aged.bound_m);
}

#[test]
fn epoch_and_sequence_must_grow() {
    let mut peers = peers();
    let at = |epoch, seq| Beacon { epoch, ..beacon(2, seq) };
    for beacon in [at(1, 5), at(1, 5), at(1, 4), at(2, 1), at(1, 9), at(2, 2)] {
        peers.handle_beacon(ms(10), &beacon);
    }
    let counts = peers.counts();
    assert_eq!((counts.taken, counts.duplicate, counts.old), (3, 1, 2));
}

#[test]
fn own_unknown_and_malformed_beacons_are_refused_and_counted() {
    let mut peers = peers();
    let nan = f64::NAN;
    for beacon in [
        beacon(1, 1),
        beacon(77, 1),
        Beacon { accel_mps2: nan, ..beacon(2, 1) },
        Beacon { pose_wb: Pose { x_m: nan, ..Pose::default() }, ..beacon(2, 1) },
        Beacon { pose_wb: Pose { x_m: 1e300, ..Pose::default() }, ..beacon(2, 1) },
        Beacon { pos_bound_m: -1.0, ..beacon(2, 1) },
        Beacon { radius_m: f64::INFINITY, ..beacon(2, 1) },
        Beacon { progress: 2.0, ..beacon(2, 1) },
    ] {
        peers.handle_beacon(ms(10), &beacon);
    }
    let counts = peers.counts();
    assert_eq!((counts.taken, counts.own, counts.unknown, counts.malformed), (0, 1, 1, 6));
    assert_eq!(bodies(&peers, ms(10)), vec![]);
}

#[test]
fn a_beacon_that_lay_in_a_queue_is_as_old_as_it_is() {
    let mut peers = peers();
    // The sender's clock is 7 s ahead; the first beacon took the least time.
    peers.handle_beacon(ms(1_000), &Beacon { sent: ms(8_000), ..beacon(2, 1) });
    peers.handle_beacon(ms(2_000), &Beacon { sent: ms(8_100), ..beacon(2, 2) });
    assert_eq!(followable(&peers, ms(2_000)), vec![], "900 ms late");
    peers.handle_beacon(ms(2_100), &Beacon { sent: ms(9_100), ..beacon(2, 3) });
    assert_eq!(followable(&peers, ms(2_100)).len(), 1);
}

#[test]
fn a_small_radius_in_a_beacon_does_not_shrink_the_configured_body() {
    let mut peers = peers();
    peers.handle_beacon(ms(0), &Beacon { radius_m: 0.01, ..beacon(2, 1) });
    assert!((bodies(&peers, ms(0))[0].radius_m - 0.4).abs() < 1e-12);
}

#[test]
fn the_table_holds_every_peer_of_the_file_and_nobody_else() {
    let mut peers = knowing(1..1_000);
    for id in 2..10_000 {
        peers.handle_beacon(ms(u64::from(id)), &beacon(id, 1));
    }
    assert_eq!(peers.known(), 998, "oneself is no peer");
    assert!(peers.table.iter().map(|record| record.beacon.robot).eq((2..1_000).map(RobotId)));
}

#[test]
fn a_body_that_is_surely_out_of_reach_is_left_out_and_one_that_may_be_near_is_not() {
    let mut peers = peers();
    let twist_b = Twist::new(2.0, 0.0);
    peers.handle_beacon(ms(0), &Beacon { twist_b, pose_wb: Pose::new(10.0, 0.0, 0.0), ..beacon(2, 1) });
    let within = |range_m: f64| peers.bodies(ms(100), Vec2::zeros(), range_m).count();
    assert_eq!((within(5.0), within(9.0)), (0, 1), "it may have turned back, and has a radius and a bound");
}
