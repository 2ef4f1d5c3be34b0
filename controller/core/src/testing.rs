//! Values and a small world for tests: bodies with a drive's lag, walls, a lidar, delayed beacons.

use crate::{Node, StopReason};
use drover_config::{
    AgilexModel, Assignment, Avoidance, BeaconPlane, Behaviour, Body, Deploy, DeployGuard, DeployMode, DeploySteer,
    Drive, Escape, Exchange, Flock, FlockGuard, FlockMode, Forces, KeptLinks, Kind, LeaderLoss, LeaderWay, Lidar,
    LidarLink, Links, Motion, Mount, Party, Peer, Robot, RobotFile, Rotation, Sim, SimMotion, Start, Timeouts,
    WallFollowing,
};
use drover_contract::{
    Beacon, Beam, BehaviourState, DriveState, Event, Limits, Odometry, Pose, RobotId, Scan, Stamp, Twist, Vec2,
    Watchdog,
};
use std::collections::VecDeque;
use std::f64::consts::TAU;
use std::time::Duration;

pub(crate) const STEP_MS: u64 = 10;
pub(crate) const BEAMS: usize = 72;

pub(crate) fn limits() -> Limits {
    Limits {
        speed_mps_max: 1.5,
        reverse_mps_max: 0.5,
        yaw_rate_radps_max: 1.5,
        accel_mps2_max: 1.0,
        brake_mps2: 1.5,
        yaw_accel_radps2_max: 4.0,
    }
}

pub(crate) fn beacon(id: u32, seq: u32) -> Beacon {
    Beacon {
        robot: RobotId(id),
        epoch: 1,
        seq,
        sent: Stamp::ZERO,
        pose_wb: Pose::default(),
        twist_b: Twist::ZERO,
        accel_mps2: 0.0,
        pos_bound_m: 0.05,
        radius_m: 0.4,
        state: BehaviourState::Active,
        progress: 0.0,
        leader: None,
    }
}

pub(crate) fn flock_config(waypoints_m: Vec<[f64; 2]>) -> Flock {
    Flock {
        mode: FlockMode::Safe,
        parties: vec![Party::of_all(1, waypoints_m)],
        leader_speed_mps: 0.8,
        waypoint_radius_m: 0.5,
        arrive_radius_m: 4.5,
        speed_mps: 10.0,
        turn_radps: 10.0,
        spacing_m: 1.8,
        gain: 1.0,
        obstacle_range_m: 1.0,
        head_offset_m: 0.3,
        damping_per_s: 1.5,
        mass_kg: 1.0,
        inertia_kgm2: 0.04,
        wall_speed_mps: 0.6,
        wall_turn_radps: 10.0,
        wall_distance_m: 0.8,
        avoid_m: 1.4,
        deadlock_mps: 0.05,
        deadlock_s: 1.0,
        period_s: 0.01,
        reverse: false,
        laser_rad: TAU,
        walls: WallFollowing::Pledge,
        side_latch: true,
        right_of_way: true,
        trail: true,
        lose_nobody: false,
        leader_way: LeaderWay::Pursuit,
        guard: FlockGuard::Collision,
        avoidance: Avoidance::Voronoi,
        link_range_m: 0.0,
        solid: true,
        leader_loss: LeaderLoss::Stop,
    }
}

/// Deployment to `targets_m` with the paper's numbers; the literal paper's choices or those that ship.
pub(crate) fn deploy_config(mode: DeployMode, targets_m: Vec<[f64; 2]>) -> Deploy {
    let safe = mode == DeployMode::Safe;
    Deploy {
        mode,
        targets_m,
        range_m: 7.0,
        speed_mps: 0.5,
        period_s: 1.0,
        exchange: Exchange::Snapshot,
        links: if safe { KeptLinks::Lmst } else { KeptLinks::Rng },
        hops: if safe { 0 } else { 1 },
        goalward: if safe { 0.6 } else { 0.0 },
        spread: if safe { 0.5 } else { 0.0 },
        assignment: Assignment::Given,
        rotation: Rotation::Independent,
        forces: Forces::Sslp,
        guard: if safe { DeployGuard::Full } else { DeployGuard::None },
        steer: DeploySteer::Heading,
        follow: safe,
        detours: safe,
        escape: Escape::None,
        goal_gain: if safe { 1.0 } else { 0.2 },
        link_gain: if safe { 2.0 } else { 0.4 },
        repel_gain: if safe { 2.0 } else { 0.4 },
        view_rad: std::f64::consts::FRAC_PI_4,
        epsilon_m: 0.2,
        avoid_m_min: 0.2,
        interval_m: 2.5,
        robot_gap_m: 0.3,
        wall_gap_m: 0.3,
        arrive_m: 0.25,
        peer_lost_s: 5.0,
    }
}

/// The file of robot `id` of `count`, starting at `start_wb`. It drives by CAN: its pose is dead reckoned.
pub(crate) fn robot_file(id: u32, count: u32, start_wb: Pose, flock: &Flock) -> RobotFile {
    let limits = limits();
    RobotFile {
        swarm: "test".into(),
        robot: Robot {
            id,
            kind: "test".into(),
            start: Start { x_m: start_wb.x_m, y_m: start_wb.y_m, yaw_rad: start_wb.yaw_rad },
            links: Links::Can { drive: "a".into(), lidar: "b".into() },
        },
        kind: kind(&limits),
        behaviour: Behaviour::Flock(flock.clone()),
        beacon: BeaconPlane { group: "239.0.0.1".into(), port: 20_000, interface: "127.0.0.1".into(), rate_hz: 10.0 },
        peers: (1..=count).filter(|peer| *peer != id).map(|id| Peer { id, radius_m: 0.4 }).collect(),
        record_dir: None,
    }
}

fn kind(limits: &Limits) -> Kind {
    Kind {
        name: "test".into(),
        body: Body { radius_m: 0.4, track_m: 0.5, footprint_m: Vec::new() },
        drive: Drive::AgilexV2 { model: AgilexModel::ScoutMini },
        motion: Motion {
            speed_mps_max: limits.speed_mps_max,
            reverse_mps_max: limits.reverse_mps_max,
            yaw_rate_radps_max: limits.yaw_rate_radps_max,
            accel_mps2_max: limits.accel_mps2_max,
            brake_mps2: limits.brake_mps2,
            yaw_accel_radps2_max: limits.yaw_accel_radps2_max,
            margin_m: 0.15,
        },
        lidar: Lidar {
            link: LidarLink::Dronecan { node: 10, silent_is_clear: true },
            beams: BEAMS as u32,
            range_m_min: 0.1,
            range_m_max: 8.0,
            rate_hz: 10.0,
            fov_rad: std::f64::consts::TAU,
            mount: Mount::default(),
        },
        timeouts: Timeouts {
            tick_ms: 50,
            scan_ms: 300,
            odometry_ms: 200,
            link_ms: 500,
            command_age_ms: 100,
            peer_ms: 600,
            bringup_s: 10,
        },
        sim: Sim {
            slip_std: 0.0,
            range_noise_m: 0.0,
            beam_dropout: 0.0,
            prearm_s: 0.0,
            range_step_m: 0.0,
            scan_sweep: false,
            motion: SimMotion::DiffDrive,
        },
    }
}

/// A small stream of numbers in 0..1, the same every time.
#[derive(Clone, Debug)]
pub(crate) struct Chance(pub(crate) u64);

impl Chance {
    pub(crate) fn unit(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }

    pub(crate) fn within(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }
}

/// A body that follows its command as fast as the limits say.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SimBody {
    pub(crate) pose_wb: Pose,
    pub(crate) twist_b: Twist,
    pub(crate) radius_m: f64,
}

impl SimBody {
    pub(crate) fn step(&mut self, command: Twist, dt_s: f64) {
        self.twist_b = crate::limit::limit(command, self.twist_b, &limits(), dt_s);
        self.pose_wb = self.pose_wb.advance(self.twist_b, dt_s);
    }
}

/// Straight walls and round things.
#[derive(Clone, Debug, Default)]
pub(crate) struct Place {
    pub(crate) walls: Vec<(Vec2, Vec2)>,
    pub(crate) discs: Vec<(Vec2, f64)>,
}

impl Place {
    pub(crate) fn room(x_m: (f64, f64), y_m: (f64, f64)) -> Self {
        let corners = [(x_m.0, y_m.0), (x_m.1, y_m.0), (x_m.1, y_m.1), (x_m.0, y_m.1)].map(|(x, y)| Vec2::new(x, y));
        let walls = (0..4).map(|k| (corners[k], corners[(k + 1) % 4])).collect();
        Self { walls, discs: Vec::new() }
    }

    /// From a point to the nearest surface, metres.
    pub(crate) fn gap_m(&self, from_w: Vec2) -> f64 {
        let walls = self.walls.iter().map(|(a, b)| {
            let along = (b - a).dot(&(from_w - a)) / (b - a).norm_squared();
            (from_w - (a + (b - a) * along.clamp(0.0, 1.0))).norm()
        });
        let discs = self.discs.iter().map(|(centre, radius_m)| (from_w - centre).norm() - radius_m);
        walls.chain(discs).fold(f64::INFINITY, f64::min)
    }

    fn range_m(&self, from_w: Vec2, ray_w: Vec2) -> Option<f64> {
        let walls = self.walls.iter().filter_map(|(a, b)| {
            let side = b - a;
            let cross = ray_w.x * side.y - ray_w.y * side.x;
            let to = a - from_w;
            let range_m = (to.x * side.y - to.y * side.x) / cross;
            let along = (to.x * ray_w.y - to.y * ray_w.x) / cross;
            (cross.abs() > 1e-12 && range_m >= 0.0 && (0.0..=1.0).contains(&along)).then_some(range_m)
        });
        let discs = self.discs.iter().filter_map(|(centre, radius_m)| {
            let to = centre - from_w;
            let along = to.dot(&ray_w);
            let off2 = to.norm_squared() - along * along;
            let half2 = radius_m * radius_m - off2;
            (half2 >= 0.0 && along > 0.0).then(|| (along - half2.sqrt()).max(0.0))
        });
        walls.chain(discs).min_by(f64::total_cmp)
    }

    pub(crate) fn scan(&self, pose_wb: Pose, stamp: Stamp) -> Scan {
        let step_rad = TAU / BEAMS as f64;
        let beam = |index: usize| {
            let (sin, cos) = libm::sincos(step_rad * index as f64);
            let hit = self.range_m(pose_wb.position(), pose_wb.rotate(Vec2::new(cos, sin)));
            hit.filter(|range_m| *range_m < 8.0).map_or(Beam::Clear, Beam::Hit)
        };
        Scan {
            stamp,
            angle_first_rad: 0.0,
            angle_step_rad: step_rad,
            range_m_min: 0.1,
            range_m_max: 8.0,
            beams: (0..BEAMS).map(beam).collect(),
        }
    }
}

/// How far sensors are off.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Noise {
    pub(crate) range_m: f64,
    pub(crate) dropout: f64,
    /// Share by which each robot's velocity is wrong, and rad per metre / 10 that its heading drifts to one side.
    pub(crate) odometry: f64,
}

impl Noise {
    fn spoil(&self, scan: &mut Scan, chance: &mut Chance) {
        for beam in &mut scan.beams {
            // The sum of four is near enough to a bell; its deviation is 1 / sqrt(3).
            let bell = (0..4).map(|_| chance.within(-0.5, 0.5)).sum::<f64>() * 3.0_f64.sqrt();
            *beam = match *beam {
                _ if chance.unit() < self.dropout => Beam::Unknown,
                Beam::Hit(range_m) => Beam::Hit((range_m + self.range_m * bell).max(0.0)),
                other => other,
            };
        }
    }
}

/// A swarm of nodes in a place: bodies that lag, commands that take `link_ms`, beacons that take `beacon_ms`.
pub(crate) struct SimSwarm {
    pub(crate) now: Stamp,
    pub(crate) place: Place,
    pub(crate) nodes: Vec<Node>,
    pub(crate) bodies: Vec<SimBody>,
    pub(crate) link_ms: u64,
    pub(crate) beacon_ms: u64,
    pub(crate) silent: Vec<bool>,
    pub(crate) noise: Noise,
    chance: Chance,
    /// Lidars see walls only.
    pub(crate) blind_to_peers: bool,
    /// Smallest gap between two bodies, and between a body and the place, so far.
    pub(crate) gap_robot_m: f64,
    pub(crate) gap_wall_m: f64,
    commands: Vec<VecDeque<(Stamp, Twist)>>,
    mail: VecDeque<(Stamp, Beacon)>,
}

impl SimSwarm {
    pub(crate) fn new(starts_wb: &[Pose], flock: &Flock, place: Place) -> Self {
        let count = starts_wb.len() as u32;
        let file = |(index, start): (usize, &Pose)| robot_file(index as u32 + 1, count, *start, flock);
        let now = Stamp::from_millis(1_000);
        let body = |pose_wb: &Pose| SimBody { pose_wb: *pose_wb, twist_b: Twist::ZERO, radius_m: 0.4 };
        Self {
            now,
            place,
            nodes: starts_wb.iter().enumerate().map(|start| Node::new(&file(start), 1, now)).collect(),
            bodies: starts_wb.iter().map(body).collect(),
            link_ms: 20,
            beacon_ms: 20,
            silent: vec![false; starts_wb.len()],
            noise: Noise::default(),
            chance: Chance(7),
            blind_to_peers: false,
            gap_robot_m: f64::INFINITY,
            gap_wall_m: f64::INFINITY,
            commands: vec![VecDeque::new(); starts_wb.len()],
            mail: VecDeque::new(),
        }
    }

    pub(crate) fn run(&mut self, seconds: f64) {
        for _ in 0..(seconds * 1_000.0) as u64 / STEP_MS {
            self.step();
        }
    }

    pub(crate) fn step(&mut self) {
        self.now = self.now + Duration::from_millis(STEP_MS);
        self.deliver();
        for index in 0..self.nodes.len() {
            self.sense(index);
            self.control(index);
            self.drive(index);
        }
        self.measure();
    }

    fn deliver(&mut self) {
        while self.mail.front().is_some_and(|(due, _)| *due <= self.now) {
            let Some((_, beacon)) = self.mail.pop_front() else { return };
            for node in &mut self.nodes {
                node.handle_beacon(self.now, &beacon);
            }
        }
    }

    fn sense(&mut self, index: usize) {
        let body = self.bodies[index];
        let node = &mut self.nodes[index];
        let watchdog = Watchdog::Fixed(Duration::from_millis(500));
        node.handle_event(self.now, Event::Drive(DriveState::Ready(watchdog)));
        if (self.now.as_millis() / STEP_MS).is_multiple_of(2) {
            let scale = 1.0 + self.noise.odometry * self.chance.within(-1.0, 1.0);
            let turn_radps =
                body.twist_b.speed_mps * self.noise.odometry * if index.is_multiple_of(2) { 0.1 } else { -0.1 };
            let twist_b = Twist::new(body.twist_b.speed_mps * scale, body.twist_b.yaw_rate_radps * scale + turn_radps);
            node.handle_event(self.now, Event::Odometry(Odometry { stamp: self.now, twist_b, wheels: None }));
        }
        if (self.now.as_millis() / STEP_MS + index as u64).is_multiple_of(10) {
            let mut seen = self.place.clone();
            let others = self.bodies.iter().enumerate().filter(|(other, _)| *other != index && !self.blind_to_peers);
            seen.discs.extend(others.map(|(_, other)| (other.pose_wb.position(), other.radius_m)));
            let mut scan = seen.scan(body.pose_wb, self.now);
            self.noise.spoil(&mut scan, &mut self.chance);
            node.handle_event(self.now, Event::Scan(scan));
        }
    }

    fn control(&mut self, index: usize) {
        let node = &mut self.nodes[index];
        if node.poll_timeout().0 > self.now {
            return;
        }
        if node.poll_timeout().1 == "tick" {
            let command = node.tick(self.now).twist_b();
            self.commands[index].push_back((self.now + Duration::from_millis(self.link_ms), command));
        }
        if let Some(beacon) = node.poll_beacon(self.now).filter(|_| !self.silent[index]) {
            self.mail.push_back((self.now + Duration::from_millis(self.beacon_ms), beacon));
        }
    }

    fn drive(&mut self, index: usize) {
        let queue = &mut self.commands[index];
        while queue.len() > 1 && queue[1].0 <= self.now {
            queue.pop_front();
        }
        let due = queue.front().filter(|(due, _)| *due <= self.now);
        let command = due.map_or(Twist::ZERO, |(_, command)| *command);
        self.bodies[index].step(command, STEP_MS as f64 * 1e-3);
    }

    fn measure(&mut self) {
        for (index, body) in self.bodies.iter().enumerate() {
            let pos_w = body.pose_wb.position();
            self.gap_wall_m = self.gap_wall_m.min(self.place.gap_m(pos_w) - body.radius_m);
            for other in &self.bodies[index + 1..] {
                let gap_m = (other.pose_wb.position() - pos_w).norm() - body.radius_m - other.radius_m;
                self.gap_robot_m = self.gap_robot_m.min(gap_m);
            }
        }
    }

    pub(crate) fn stop(&mut self, index: usize) {
        self.nodes[index].handle_stop(self.now, StopReason::Operator);
    }
}
