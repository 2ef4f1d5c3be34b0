//! The virtual rover against the host that drives it in the field, and against ground stations.

use super::*;
use drover_codec::mavlink::{MavHost, MavHostParams};
use drover_contract::{Beam, DriveState, Event, Limits, Pose, SafeCommand};

const STEP: Duration = Duration::from_millis(10);
const ROBOT: u8 = 7;
const LIMITS: Limits = Limits {
    speed_mps_max: 2.0,
    reverse_mps_max: 2.0,
    yaw_rate_radps_max: 2.0,
    accel_mps2_max: 1.0,
    brake_mps2: 1.0,
    yaw_accel_radps2_max: 1.0,
};

fn params(prearm_s: u64) -> RoverParams {
    RoverParams { system_id: ROBOT, lidar_component: 196, prearm_after: Duration::from_secs(prearm_s) }
}

fn host(now: Stamp) -> MavHost {
    let params = MavHostParams {
        robot: ROBOT,
        component: 191,
        telemetry_hz: 40,
        lidar_component: 196,
        range_m_min: 0.1,
        range_m_max: 8.0,
        link_timeout: Duration::from_millis(500),
    };
    MavHost::new(params, now)
}

/// A rover whose body does at once what it is asked for, and the computers on its links.
struct Lab {
    rover: VirtualRover,
    hosts: Vec<(PeerKey, MavHost)>,
    body: BodyState,
    now: Stamp,
    scans: bool,
    events: Vec<(Stamp, Event)>,
    /// Frames that reached hosts: link, component, sequence number.
    heard: Vec<(PeerKey, u8, u8)>,
}

impl Lab {
    fn new(prearm_s: u64, hosts: usize) -> Self {
        let hosts = (0..hosts as u64).map(|key| (PeerKey(key), host(Stamp::ZERO))).collect();
        Self {
            rover: VirtualRover::new(params(prearm_s), 1),
            hosts,
            body: BodyState { pose_wb: Pose::new(3.0, -2.0, 0.5), ..BodyState::default() },
            now: Stamp::ZERO,
            scans: true,
            events: Vec::new(),
            heard: Vec::new(),
        }
    }

    fn scan(&self) -> Scan {
        let mut beams = vec![Beam::Clear; 72];
        beams[9] = Beam::Hit(1.5);
        Scan {
            stamp: self.now,
            angle_first_rad: 0.0,
            angle_step_rad: 5.0_f64.to_radians(),
            range_m_min: 0.1,
            range_m_max: 8.0,
            beams,
        }
    }

    fn step(&mut self) {
        self.now = self.now + STEP;
        self.body.twist_b = self.rover.demand();
        self.body.pose_wb = self.body.pose_wb.advance(self.body.twist_b, STEP.as_secs_f64());
        let scan = (self.scans && self.now.as_millis().is_multiple_of(100)).then(|| self.scan());
        self.rover.step(self.now, &self.body, scan.as_ref());
        for (key, host) in &mut self.hosts {
            host.handle_timeout(self.now);
            while let Some(bytes) = host.poll_output() {
                self.rover.handle_datagram(self.now, *key, &bytes);
            }
        }
        while let Some((key, bytes)) = self.rover.poll_output() {
            for (_, host) in self.hosts.iter_mut().filter(|(its, _)| *its == key) {
                self.heard.push((key, bytes[6], bytes[4]));
                host.handle_datagram(self.now, &bytes);
            }
        }
        if let Some((_, host)) = self.hosts.first_mut() {
            self.events.extend(std::iter::from_fn(|| host.poll_event()).map(|event| (self.now, event)));
        }
    }

    fn run(&mut self, seconds: f64) {
        for _ in 0..(seconds / STEP.as_secs_f64()).round() as usize {
            self.step();
        }
    }

    /// Drive at 20 Hz.
    fn drive(&mut self, seconds: f64, twist_b: Twist) {
        for _ in 0..(seconds * 20.0).round() as usize {
            let command = SafeCommand::bounded(twist_b, &LIMITS).expect("finite");
            self.hosts[0].1.command(self.now, command);
            self.run(0.05);
        }
    }

    fn ready(&self) -> bool {
        matches!(self.hosts[0].1.drive_state(), DriveState::Ready(_))
    }

    fn until_ready(&mut self, patience_s: f64) {
        let start = self.now;
        while !self.ready() {
            self.step();
            let waited = self.now.since(start).as_secs_f64();
            assert!(waited < patience_s, "still {} after {waited} s", self.hosts[0].1.drive_state());
        }
    }

    fn said(&self, words: &str) -> usize {
        let texts =
            self.events.iter().filter(|(_, event)| matches!(event, Event::Text(_, text) if text.contains(words)));
        texts.count()
    }
}

#[test]
fn a_host_brings_the_rover_from_silent_to_driving_and_its_telemetry_is_the_bodys_motion() {
    let mut lab = Lab::new(3, 1);
    lab.until_ready(6.0);
    let before = lab.body.pose_wb;
    lab.drive(2.0, Twist::new(0.5, 0.2));
    assert!((lab.body.pose_wb.position() - before.position()).norm() > 0.9);
    let odometry = lab.events.iter().rev().find_map(|(_, event)| match event {
        Event::Odometry(odometry) => Some(*odometry),
        _ => None,
    });
    let twist_b = odometry.expect("odometry").twist_b;
    assert!((twist_b.speed_mps - 0.5).abs() < 1e-3 && (twist_b.yaw_rate_radps - 0.2).abs() < 1e-3, "{twist_b:?}");
    let pose = lab.events.iter().rev().find_map(|(_, event)| match event {
        Event::Pose(fix) => Some(fix.pose_wb),
        _ => None,
    });
    let error = (pose.expect("pose").position() - lab.body.pose_wb.position()).norm();
    assert!(error < 0.03, "at most one telemetry period old: {error} m");
}

#[test]
fn the_full_scan_and_the_eight_sectors_arrive() {
    let mut lab = Lab::new(0, 1);
    lab.run(3.0);
    let scans: Vec<&Scan> = lab.events.iter().filter_map(|(_, event)| scan_of(event)).collect();
    assert!((25..=30).contains(&scans.len()), "{}", scans.len());
    let scan = scans.last().expect("a scan");
    let hits: Vec<_> = scan.points_b().collect();
    assert_eq!(hits.len(), 1);
    let (_, point_b) = hits[0];
    assert!((point_b.norm() - 1.5).abs() < 1e-6);
    assert!((libm::atan2(point_b.y, point_b.x) - 45.0_f64.to_radians()).abs() < 1e-6, "ahead on the left");
    assert_eq!(scan.beams.iter().filter(|beam| **beam == Beam::Clear).count(), 71);
    assert_eq!(lab.hosts[0].1.sector_nearest_m(lab.now), Some(1.5));
    lab.scans = false;
    lab.events.clear();
    lab.run(3.0);
    assert_eq!(lab.events.iter().filter_map(|(_, event)| scan_of(event)).count(), 0);
    assert_eq!(lab.hosts[0].1.sector_nearest_m(lab.now), None);
}

fn scan_of(event: &Event) -> Option<&Scan> {
    match event {
        Event::Scan(scan) => Some(scan),
        _ => None,
    }
}

#[test]
fn without_setpoints_it_stops_by_itself_after_three_seconds_and_says_so() {
    let mut lab = Lab::new(0, 1);
    lab.until_ready(4.0);
    lab.drive(1.0, Twist::new(1.0, 0.0));
    lab.run(2.9);
    assert_eq!(lab.rover.demand(), Twist::new(1.0, 0.0));
    lab.run(0.1);
    assert_eq!(lab.rover.demand(), Twist::ZERO);
    lab.run(0.1);
    assert_eq!(lab.said("target not received last 3secs, stopping"), 1);
    assert!(lab.ready(), "it stays armed in GUIDED");
}

#[test]
fn arming_before_the_estimator_is_ready_fails_with_words() {
    let mut lab = Lab::new(30, 1);
    lab.run(2.0);
    let arm = Command { id: 400, ask: Ask::Arm { arm: true, force: false } };
    assert_eq!(lab.rover.obey(lab.now, PeerKey(0), arm), AckResult::Failed);
    lab.run(0.1);
    assert_eq!(lab.said("Arm: Need Position Estimate"), 1);
    assert_eq!(*lab.hosts[0].1.drive_state(), DriveState::BringUp("waiting for pre-arm check"));
    assert!(!lab.events.iter().any(|(_, event)| matches!(event, Event::Pose(_))), "no position before that");
    lab.until_ready(33.0);
    assert!(lab.now.as_secs_f64() > 30.0);
}

#[test]
fn a_setpoint_kept_while_disarmed_in_guided_is_driven_on_arming_unless_hold_came_between() {
    let forward = Setpoint {
        type_mask: 1479,
        frame: 8,
        position_m: [0.0; 2],
        velocity_mps: [1.0, 0.0],
        yaw_rad: 0.0,
        yaw_rate_radps: 0.0,
    };
    let mut rover = VirtualRover::new(params(0), 1);
    let arm = Command { id: 400, ask: Ask::Arm { arm: true, force: false } };
    let now = Stamp::from_millis(1000);
    rover.set_mode(mode::GUIDED);
    rover.store(now, forward);
    assert_eq!(rover.demand(), Twist::ZERO, "disarmed");
    rover.obey(now, PeerKey(0), arm);
    assert_eq!(rover.demand(), Twist::new(1.0, 0.0), "the hazard");
    rover.set_mode(mode::HOLD);
    assert_eq!(rover.demand(), Twist::ZERO);
    rover.store(now, forward);
    rover.set_mode(mode::GUIDED);
    assert_eq!(rover.demand(), Twist::ZERO, "entering GUIDED clears it, and HOLD takes none");
}

#[test]
fn hold_and_disarm_stop_it_and_a_shut_down_host_leaves_it_so() {
    let mut lab = Lab::new(0, 1);
    lab.until_ready(4.0);
    lab.drive(1.0, Twist::new(1.0, 0.0));
    let now = lab.now;
    lab.hosts[0].1.shutdown(now);
    lab.run(0.02);
    assert_eq!(lab.rover.demand(), Twist::ZERO);
    lab.run(10.0);
    assert!(!lab.rover.is_armed());
    assert_eq!(lab.rover.custom_mode(), mode::HOLD);
}

#[test]
fn the_emergency_datagram_stops_it_from_anybody() {
    let mut lab = Lab::new(0, 1);
    lab.until_ready(4.0);
    lab.drive(1.0, Twist::new(1.0, 0.0));
    let bytes = lab.hosts[0].1.stop_bytes().to_vec();
    lab.rover.handle_datagram(lab.now, PeerKey(99), &bytes);
    assert_eq!(lab.rover.demand(), Twist::ZERO);
}

#[test]
fn remote_control_takes_it_away_and_gives_it_back() {
    let mut lab = Lab::new(0, 1);
    lab.until_ready(4.0);
    lab.drive(1.0, Twist::new(1.0, 0.0));
    lab.rover.rc_takeover();
    assert_eq!(lab.rover.demand(), Twist::ZERO);
    lab.drive(5.0, Twist::new(1.0, 0.0));
    assert_eq!(lab.rover.demand(), Twist::ZERO);
    assert!(!lab.ready());
    lab.rover.rc_release();
    lab.until_ready(4.0);
    assert_eq!(lab.rover.demand(), Twist::ZERO, "nothing old is driven");
}

#[test]
fn a_power_cycle_ends_everything_and_the_host_starts_again() {
    let mut lab = Lab::new(2, 1);
    lab.until_ready(5.0);
    lab.drive(1.0, Twist::new(1.0, 0.0));
    lab.rover.power_cycle(lab.now);
    assert_eq!(lab.rover.demand(), Twist::ZERO);
    lab.drive(0.6, Twist::new(1.0, 0.0));
    assert_eq!(*lab.hosts[0].1.drive_state(), DriveState::Silent);
    lab.until_ready(6.0);
    assert_eq!(lab.rover.demand(), Twist::ZERO);
}

#[test]
fn several_stations_have_their_own_rates_and_sequence_numbers() {
    let mut lab = Lab::new(0, 3);
    lab.until_ready(6.0);
    lab.heard.clear();
    lab.run(2.0);
    for key in [0, 1, 2].map(PeerKey) {
        for component in [1, 196] {
            let heard = lab.heard.iter().filter(|(its, from, _)| *its == key && *from == component);
            let numbers: Vec<u8> = heard.map(|(_, _, sequence)| *sequence).collect();
            assert!(numbers.len() >= 20, "component {component} on link {key:?}: {}", numbers.len());
            assert!(numbers.windows(2).all(|pair| pair[1] == pair[0].wrapping_add(1)), "no gaps on any link");
        }
    }
}

#[test]
fn rates_are_met_and_too_fast_ones_denied() {
    let mut lab = Lab::new(0, 1);
    lab.until_ready(4.0);
    lab.events.clear();
    lab.run(5.0);
    let poses = lab.events.iter().filter(|(_, event)| matches!(event, Event::Pose(_))).count();
    assert!((160..=202).contains(&poses), "40 Hz as far as 10 ms steps allow: {poses}");
    let set =
        |rover: &mut VirtualRover, message, interval_us| rover.set_interval(lab.now, PeerKey(0), message, interval_us);
    assert_eq!(set(&mut lab.rover, 32, 20_000), AckResult::Denied);
    assert_eq!(set(&mut lab.rover, 331, 100_000), AckResult::Denied, "ODOMETRY is never sent");
    assert_eq!(set(&mut lab.rover, 330, 100_000), AckResult::Denied, "nor is OBSTACLE_DISTANCE, by the autopilot");
    assert_eq!(set(&mut lab.rover, 32, 50_000), AckResult::Accepted);
    assert_eq!(set(&mut lab.rover, 30, -1), AckResult::Accepted);
    lab.run(0.1);
    assert_eq!(lab.said("too fast. Increase SCHED_LOOP_RATE"), 1);
}

#[test]
fn peers_that_go_away_are_forgotten_and_the_table_stays_bounded() {
    let mut rover = VirtualRover::new(params(0), 1);
    let mut host = host(Stamp::ZERO);
    host.handle_timeout(Stamp::ZERO);
    let heartbeat = host.poll_output().expect("a heartbeat");
    for key in 0..1000 {
        rover.handle_datagram(Stamp::from_millis(1000 + key), PeerKey(key), &heartbeat);
    }
    assert_eq!(rover.peers.len(), 8);
    rover.handle_datagram(Stamp::from_millis(2500), PeerKey(5000), b"no frame at all");
    rover.step(Stamp::from_millis(12_100), &BodyState::default(), None);
    assert_eq!(rover.peers.len(), 0);
    rover.step(Stamp::from_millis(13_000), &BodyState::default(), None);
    while rover.poll_output().is_some() {}
    rover.step(Stamp::from_millis(14_000), &BodyState::default(), None);
    assert_eq!(rover.poll_output(), None, "it speaks to nobody");
}

#[test]
fn outputs_that_nobody_fetches_stay_bounded() {
    let mut rover = VirtualRover::new(params(0), 1);
    let mut host = host(Stamp::ZERO);
    for ms in 0..200_000 {
        if ms % 1000 == 0 {
            host.handle_timeout(Stamp::from_millis(ms));
            while let Some(bytes) = host.poll_output() {
                (0..8).for_each(|key| rover.handle_datagram(Stamp::from_millis(ms), PeerKey(key), &bytes));
            }
            rover.step(Stamp::from_millis(ms), &BodyState::default(), None);
        }
    }
    assert_eq!(std::iter::from_fn(|| rover.poll_output()).count(), OUTPUTS_MAX);
}

#[test]
fn the_same_seed_says_the_same_bytes_and_another_spreads_them_otherwise() {
    let run = |seed| {
        let mut lab = Lab::new(1, 1);
        lab.rover = VirtualRover::new(params(1), seed);
        lab.run(4.0);
        lab.heard.len() as u64 * 1_000_003 + lab.events.iter().map(|(when, _)| when.as_micros()).sum::<u64>()
    };
    assert_eq!(run(3), run(3));
    assert_ne!(run(3), run(4));
}

#[test]
fn a_course_over_ground_and_a_point_are_driven_to() {
    let mut lab = Lab::new(0, 0);
    lab.rover.set_mode(mode::GUIDED);
    lab.rover.arm(Stamp::ZERO, false);
    let mut setpoint = Setpoint {
        type_mask: 3527,
        frame: 1,
        position_m: [0.0; 2],
        velocity_mps: [1.0, 0.0],
        yaw_rad: 0.0,
        yaw_rate_radps: 0.0,
    };
    for _ in 0..10 {
        lab.rover.store(lab.now, setpoint);
        lab.run(0.5);
    }
    assert!((lab.body.pose_wb.yaw_rad - std::f64::consts::FRAC_PI_2).abs() < 0.01, "north");
    setpoint.type_mask = 3576;
    setpoint.position_m = [4.0, -1.0];
    lab.rover.store(lab.now, setpoint);
    lab.run(40.0);
    let left = (lab.body.pose_wb.position() - drover_contract::Vec2::new(-1.0, 4.0)).norm();
    assert!(left < 0.25, "a point needs no repeating: {left} m left");
}
