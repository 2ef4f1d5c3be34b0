use super::*;
use drover_codec::can::dronecan::{DronecanLidarHost, DronecanLidarParams};
use drover_codec::mavlink::{MavHost, MavHostParams};
use drover_config::load_swarm;
use drover_contract::{CanId, CanNode, DriveState, Event, Scan};
use std::collections::BTreeSet;
use std::path::Path;

/// In the shipped swarm: two rovers, then three chassis.
const ROVER: usize = 1;
const CHASSIS: usize = 2;
const PEER: PeerKey = PeerKey(7);

/// The shipped swarm's plant, with the hosts of one rover and of one lidar node on their links.
struct Bench {
    swarm: Swarm,
    plant: Plant,
    now: Stamp,
    rover: MavHost,
    rover_scans: Vec<Scan>,
    rover_drive: DriveState,
    lidar: DronecanLidarHost,
    lidar_scans: Vec<Scan>,
    /// Everything that the plant said.
    said: Vec<Output>,
}

impl Bench {
    fn new(seed: u64) -> Self {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../config/swarms/first.toml");
        let swarm = load_swarm(&path, &[]).unwrap_or_else(|problems| panic!("{problems}"));
        let swarm = Swarm { seed, ..swarm };
        let kind = swarm.kind_of(&swarm.robots[CHASSIS]);
        let lidar = DronecanLidarParams {
            node: CanNode(42),
            own_node: CanNode(10),
            beams: kind.lidar.beams,
            range_m_min: kind.lidar.range_m_min,
            range_m_max: kind.lidar.range_m_max,
            rate_hz: kind.lidar.rate_hz,
            silent_is_clear: false,
        };
        let rover = MavHostParams {
            robot: 2,
            component: 191,
            telemetry_hz: 20,
            lidar_component: 196,
            range_m_min: 0.2,
            range_m_max: 12.0,
            link_timeout: Duration::from_secs(1),
        };
        Self {
            plant: Plant::new(&swarm, Stamp::ZERO),
            swarm,
            now: Stamp::ZERO,
            rover: MavHost::new(rover, Stamp::ZERO),
            rover_scans: Vec::new(),
            rover_drive: DriveState::Silent,
            lidar: DronecanLidarHost::new(lidar, Stamp::ZERO),
            lidar_scans: Vec::new(),
            said: Vec::new(),
        }
    }

    fn run(&mut self, span_s: f64) {
        let end = self.now + Duration::from_secs_f64(span_s);
        while self.now < end {
            self.now = self.now + Duration::from_millis(10);
            self.plant.step(self.now);
            while let Some(output) = self.plant.poll_output() {
                self.hear(&output);
                self.said.push(output);
            }
            self.rover.handle_timeout(self.now);
            while let Some(bytes) = self.rover.poll_output() {
                self.plant.handle_input(self.now, ROVER, Port::Autopilot, PEER, &Packet::Datagram(bytes));
            }
        }
    }

    fn hear(&mut self, output: &Output) {
        match (output.robot, &output.packet) {
            (ROVER, Packet::Datagram(bytes)) => self.rover.handle_datagram(self.now, bytes),
            (CHASSIS, Packet::Frame(frame)) if output.port == Port::LidarBus => {
                self.lidar.handle_frame(self.now, frame);
            }
            (_, Packet::Datagram(_) | Packet::Frame(_)) => {}
        }
        while let Some(event) = self.rover.poll_event() {
            match event {
                Event::Scan(scan) => self.rover_scans.push(scan),
                Event::Drive(state) => self.rover_drive = state,
                _ => {}
            }
        }
        self.lidar.handle_timeout(self.now);
        while let Some(event) = self.lidar.poll_event() {
            if let Event::Scan(scan) = event {
                self.lidar_scans.push(scan);
            }
        }
    }

    /// Drive the chassis at this speed for a while, as its host would: CAN mode, then a command every 20 ms.
    fn drive(&mut self, speed_mms: i16, span_s: f64) {
        self.send(0x421, &[1]);
        let [high, low] = speed_mms.to_be_bytes();
        for _ in 0..(span_s / 0.02).round() as u32 {
            self.send(0x111, &[high, low, 0, 0, 0, 0, 0, 0]);
            self.run(0.02);
        }
    }

    fn send(&mut self, id: u16, data: &[u8]) {
        let frame = CanFrame::new(CanId::Standard(id), data).unwrap();
        self.plant.handle_input(self.now, CHASSIS, Port::DriveBus, PeerKey(0), &Packet::Frame(frame));
    }

    fn speed_mps(&self) -> f64 {
        self.plant.truth(CHASSIS).twist_b.speed_mps
    }

    fn stands(&self) -> bool {
        self.plant.truth(CHASSIS).twist_b == Twist::ZERO
    }

    fn said_since(&self, mark: usize, robot: usize, port: Port) -> usize {
        self.said[mark..].iter().filter(|output| (output.robot, output.port) == (robot, port)).count()
    }
}

#[test]
fn a_rover_gets_ready_over_its_link_and_shows_its_scan() {
    let mut bench = Bench::new(1);
    bench.run(10.0);
    assert!(matches!(bench.rover_drive, DriveState::Ready(_)), "{}", bench.rover_drive);
    assert!((80..=101).contains(&bench.rover_scans.len()), "10 Hz: {}", bench.rover_scans.len());
    let robot = &bench.swarm.robots[ROVER];
    let scan = &bench.rover_scans[10];
    let beside_rad = |index: &usize| (scan.angle_rad(*index) - (-std::f64::consts::FRAC_PI_2)).abs();
    let right = (0..scan.beams.len()).min_by(|a, b| beside_rad(a).total_cmp(&beside_rad(b))).unwrap();
    // To the right of robot 2 stands robot 3, 2 m away, a disc of 0.42 m.
    assert_eq!((robot.start.x_m, robot.start.y_m), (3.0, 7.0));
    let nearest_m = scan.nearest_m().unwrap();
    assert!((1.0..1.7).contains(&nearest_m), "{nearest_m}");
    assert!(matches!(scan.beams[right], drover_contract::Beam::Hit(range) if (range - 1.58).abs() < 0.1), "{scan:?}");
}

#[test]
fn a_chassis_obeys_its_bus_and_stops_half_a_second_after_the_last_command() {
    let mut bench = Bench::new(1);
    bench.drive(500, 2.0);
    assert!((bench.speed_mps() - 0.5).abs() < 0.1, "{}", bench.speed_mps());
    assert!(bench.plant.truth(CHASSIS).path_m > 0.5);
    bench.run(0.4);
    assert!(bench.speed_mps() > 0.3, "its watchdog has not run out");
    bench.run(0.5);
    assert_eq!(bench.plant.truth(CHASSIS).twist_b, Twist::ZERO);
    assert_eq!(bench.plant.truth(CHASSIS).demand, Twist::ZERO);
}

#[test]
fn a_lidar_node_shows_the_same_world_as_the_arena() {
    let mut bench = Bench::new(1);
    bench.run(3.0);
    assert!((20..=31).contains(&bench.lidar_scans.len()), "10 Hz: {}", bench.lidar_scans.len());
    let nearest_m = bench.lidar_scans[5].nearest_m().unwrap();
    let gap_m = bench.plant.truth(CHASSIS).gap_robot_m_min.unwrap();
    // The nearest hit is on the nearest robot, if a beam meets it squarely; a range counts from the centre.
    assert!(nearest_m >= gap_m + 0.42 - 0.05 && nearest_m < gap_m + 0.42 + 0.3, "{nearest_m} and {gap_m}");
}

#[test]
fn nothing_passes_a_cut_link_either_way_and_all_does_when_it_is_back() {
    let mut bench = Bench::new(1);
    bench.drive(500, 1.0);
    let mark = bench.said.len();
    for robot in [ROVER, CHASSIS] {
        bench.plant.inject(bench.now, robot, Fault::LinkCut);
    }
    bench.drive(500, 2.0);
    assert!(bench.stands(), "commands do not reach it");
    assert_eq!(bench.said_since(mark, CHASSIS, Port::DriveBus) + bench.said_since(mark, ROVER, Port::Autopilot), 0);
    assert!(bench.said_since(mark, CHASSIS, Port::LidarBus) > 0, "the lidar has a link of its own");
    for robot in [ROVER, CHASSIS] {
        bench.plant.inject(bench.now, robot, Fault::LinkBack);
    }
    bench.run(0.2);
    assert!(bench.stands(), "nothing old is obeyed");
    bench.drive(500, 1.0);
    assert!(bench.speed_mps() > 0.3);
    assert!(bench.said_since(mark, ROVER, Port::Autopilot) > 0);
}

#[test]
fn a_cut_scan_is_silence_and_a_lidar_that_comes_back_starts_anew() {
    let mut bench = Bench::new(1);
    bench.run(5.0);
    for robot in [ROVER, CHASSIS] {
        bench.plant.inject(bench.now, robot, Fault::ScanCut);
    }
    let (mark, rover_scans) = (bench.said.len(), bench.rover_scans.len());
    bench.run(3.0);
    assert_eq!(bench.said_since(mark, CHASSIS, Port::LidarBus), 0, "not even NodeStatus");
    assert!(bench.rover_scans.len() <= rover_scans + 1);
    assert!(bench.said_since(mark, ROVER, Port::Autopilot) > 0, "the autopilot goes on");
    for robot in [ROVER, CHASSIS] {
        bench.plant.inject(bench.now, robot, Fault::ScanBack);
    }
    let lidar_scans = bench.lidar_scans.len();
    bench.run(2.0);
    assert!(bench.rover_scans.len() >= rover_scans + 15 && bench.lidar_scans.len() >= lidar_scans + 15);
}

#[test]
fn a_chassis_stands_after_a_power_cycle_until_it_is_enabled_again() {
    let mut bench = Bench::new(1);
    bench.drive(500, 1.0);
    bench.plant.inject(bench.now, CHASSIS, Fault::PowerCycle);
    for _ in 0..100 {
        bench.send(0x111, &[1, 0xF4, 0, 0, 0, 0, 0, 0]);
        bench.run(0.02);
    }
    assert!(bench.stands());
    bench.drive(500, 1.0);
    assert!(bench.speed_mps() > 0.3);
}

#[test]
fn a_remote_control_and_an_emergency_stop_mask_commands() {
    for (on, off) in
        [(Fault::RemoteControl(true), Fault::RemoteControl(false)), (Fault::EStop(true), Fault::EStop(false))]
    {
        let mut bench = Bench::new(1);
        bench.drive(500, 1.0);
        bench.plant.inject(bench.now, CHASSIS, on);
        bench.drive(500, 1.5);
        assert!(bench.stands(), "{on:?}");
        bench.plant.inject(bench.now, CHASSIS, off);
        bench.send(0x421, &[1]);
        bench.send(0x441, &[0]);
        bench.drive(500, 1.0);
        assert!(bench.speed_mps() > 0.3, "{off:?}");
    }
}

#[test]
fn garbage_on_any_port_of_any_robot_changes_nothing() {
    let mut bench = Bench::new(1);
    bench.run(1.0);
    let junk = Packet::Datagram((0..=255).cycle().take(4000).collect());
    let odd = Packet::Frame(CanFrame::new(CanId::Extended(0x1FFF_FFFF), &[0xFF; 8]).unwrap());
    for robot in [0, ROVER, CHASSIS, 4, 99] {
        for port in [Port::Autopilot, Port::DriveBus, Port::LidarBus] {
            bench.plant.handle_input(bench.now, robot, port, PEER, &junk);
            bench.plant.handle_input(bench.now, robot, port, PEER, &odd);
        }
    }
    bench.plant.inject(bench.now, 99, Fault::PowerCycle);
    bench.run(1.0);
    assert!((0..bench.plant.robot_count()).all(|robot| bench.plant.truth(robot).path_m == 0.0));
}

#[test]
fn one_seed_says_the_same_bytes_twice_and_another_does_not() {
    let said = |seed| {
        let mut bench = Bench::new(seed);
        bench.drive(700, 5.0);
        (bench.said, bench.plant.truth(CHASSIS))
    };
    let (first, again, other) = (said(1), said(1), said(2));
    assert!(first == again);
    assert!(first.0 != other.0);
    assert_ne!(first.1.pose_wb, other.1.pose_wb, "slip has the seed's chance in it");
}

#[test]
fn lidars_turn_out_of_step_with_each_other_at_their_rate() {
    let bench = Bench::new(1);
    let kind = bench.swarm.kind_of(&bench.swarm.robots[CHASSIS]);
    let turns_ms = |id: u32| -> Vec<u64> {
        let mut station = Station::new(kind, id, 1, Stamp::ZERO);
        (0..1000).filter(|ms| station.take_scan_turn(Stamp::from_millis(*ms))).collect()
    };
    let firsts: BTreeSet<u64> = (1..=10).map(|id| turns_ms(id)[0]).collect();
    assert!(firsts.len() >= 7 && firsts.iter().all(|ms| *ms <= 100), "{firsts:?}");
    let turns = turns_ms(1);
    assert!(turns.len() == 10 && turns.windows(2).all(|pair| (99..=101).contains(&(pair[1] - pair[0]))), "{turns:?}");
}

#[test]
fn messages_that_nobody_takes_are_bounded_and_time_goes_in_whole_steps() {
    let mut bench = Bench::new(1);
    let step_ms = u64::from(bench.swarm.step_ms);
    assert_eq!(bench.plant.poll_timeout(), Some((Stamp::from_millis(step_ms), "world step")));
    bench.plant.step(Stamp::from_micros(step_ms * 1000 * 2 + 999));
    assert_eq!(bench.plant.poll_timeout(), Some((Stamp::from_millis(3 * step_ms), "world step")));
    bench.plant.step(Stamp::from_millis(60_000));
    assert!(bench.plant.outputs.len() <= OUTPUTS_MAX);
    assert_eq!(bench.plant.outputs_dropped() > 0, bench.plant.outputs.len() == OUTPUTS_MAX);
}

#[test]
fn a_mover_goes_with_the_plant_and_is_in_the_scans_that_firmware_sends() {
    let mut bench = Bench::new(1);
    bench.run(5.0);
    let before = bench.rover_scans.last().expect("it scans").nearest_m().expect("there are walls");
    let place = bench.plant.arena().state(ROVER).pose_wb.position();
    let waypoints_m = vec![[place.x, place.y - 1.0], [place.x + 1.0, place.y - 1.0]];
    let movers = vec![drover_config::Mover { radius_m: 0.3, waypoints_m, speed_mps: 0.1, loops: false }];
    let mut bench = Bench::new(1);
    bench.swarm.world.movers = movers;
    bench.plant = Plant::new(&bench.swarm, Stamp::ZERO);
    bench.run(5.0);
    let nearest_m = bench.rover_scans.last().expect("it scans").nearest_m().expect("there is a mover");
    assert!(nearest_m < before - 0.1, "{nearest_m} after {before}");
    let (centre_w, _) = bench.plant.arena().movers().next().expect("there is one");
    assert!((centre_w.x - place.x - 0.5).abs() < 0.01, "{centre_w}");
    let gap_m = bench.plant.truth(ROVER).gap_wall_m_min.expect("there are walls");
    assert!(gap_m < 1.0 - 0.3, "{gap_m}");
}
