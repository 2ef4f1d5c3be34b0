//! The swarms that `drover bench sim` runs: the peers' robots at the peers' densities, and flocks without number.

use drover_config::{
    Avoidance, Behaviour, Body, Circle, Diffuse, Drive, Flock, FlockGuard, FlockMode, Kind, LeaderLoss, LeaderWay,
    Lidar, LidarLink, Links, Motion, Mount, Party, Polygon, Radio, RobotFile, Sim, SimMotion, Start, Swarm, Timeouts,
    WallFollowing, World,
};
use drover_config::{BeaconPlane, Robot};
use rand::{Rng, SeedableRng};
use rand_pcg::Pcg32;
use std::f64::consts::TAU;

/// A peer's robot doing diffusion, and how closely it stands.
#[derive(Clone, Copy, Debug)]
pub(super) struct Peers {
    pub(super) radius_m: f64,
    pub(super) beams: u32,
    /// From the body's centre.
    pub(super) range_m: f64,
    pub(super) robots_per_m2: f64,
    pub(super) radio_m: f64,
}

/// ARGoS' foot-bot: 24 proximity rays of 0.1 m from a body of 8.5 cm, one robot a square metre.
pub(super) const FOOT_BOT: Peers =
    Peers { radius_m: 0.085, beams: 24, range_m: 0.185, robots_per_m2: 1.0, radio_m: 1.0 };
/// ARGoS' Khepera IV: a 360-ray lidar of 10 m, one robot on four square metres.
pub(super) const KHEPERA: Peers =
    Peers { radius_m: 0.0704, beams: 360, range_m: 10.0, robots_per_m2: 0.25, radio_m: 3.0 };

/// One tick of the peers: sense, decide and move ten times a second.
pub(super) const TICK_MS: u32 = 100;
const SPEED_MPS: f64 = 0.1;

impl Peers {
    /// What the robots do.
    pub(super) fn law(&self) -> Diffuse {
        Diffuse { speed_mps: SPEED_MPS, turn_radps: 1.0, clearance_m: self.radius_m + 0.08, ahead_rad: 1.6 }
    }

    /// `count` robots at random in a walled square. `noisy`: with slip, range noise, dropout and a lossy radio.
    pub(super) fn swarm(&self, count: u32, noisy: bool) -> Swarm {
        let side_m = (f64::from(count) / self.robots_per_m2).sqrt();
        let chance = |value: f64| if noisy { value } else { 0.0 };
        let kind = Kind {
            name: "peer".into(),
            body: Body { radius_m: self.radius_m, track_m: 1.5 * self.radius_m, footprint_m: Vec::new() },
            motion: motion(SPEED_MPS, 0.01),
            lidar: lidar(self.beams, self.range_m),
            timeouts: timeouts(TICK_MS),
            sim: sim(chance(0.02), chance(0.005), chance(0.01)),
            drive: DRIVE,
        };
        let radio = Radio { range_m: self.radio_m, loss: 0.05, ..Radio::default() };
        let starts = scattered(count, side_m, self.radius_m);
        let behaviour = Behaviour::Diffuse(self.law());
        swarm("diffusion", kind, starts, (walled(side_m), behaviour, radio, TICK_MS))
    }
}

/// Robots of one flock.
pub(super) const FLOCK: u32 = 20;
/// From one flock's place to the next, metres: beyond the radio's range and the flock's own extent.
const FLOCK_PITCH_M: f64 = 20.0;
const FLOCK_TICK_MS: u32 = 50;

/// `count` robots of 0.3 m with 72 beams of 12 m at 10 Hz, in flocks of 20, each behind a leader of its own, on a field
/// with a round obstacle in front of every flock.
pub(super) fn flocks(count: u32) -> Swarm {
    let kind = Kind {
        name: "flocker".into(),
        body: Body { radius_m: 0.3, track_m: 0.4, footprint_m: Vec::new() },
        motion: motion(1.5, 0.25),
        lidar: lidar(72, 12.0),
        timeouts: timeouts(FLOCK_TICK_MS),
        sim: sim(0.005, 0.01, 0.01),
        drive: DRIVE,
    };
    let starts: Vec<Start> = (0..count).map(|index| in_flock(index, count)).collect();
    let leads = (0..count).filter(|index| index % FLOCK == 0).map(|index| in_flock(index, count));
    let obstacle = |start: Start| Circle { centre_m: [start.x_m + 8.0, start.y_m + 1.0], radius_m: 0.5 };
    let world = World { name: "field".into(), circles: leads.map(obstacle).collect(), ..World::default() };
    let behaviour = Behaviour::Flock(flock_behind(1, [0.0, 0.0]));
    let radio = Radio { range_m: 10.0, loss: 0.05, ..Radio::default() };
    swarm("flocks", kind, starts, (world, behaviour, radio, FLOCK_TICK_MS))
}

/// A robot's file with its own flock's leader in it.
pub(super) fn with_own_leader(mut file: RobotFile, count: u32) -> RobotFile {
    let first = (file.robot.id - 1) / FLOCK * FLOCK;
    let start = in_flock(first, count);
    file.behaviour = Behaviour::Flock(flock_behind(first + 1, [start.x_m + 1_000.0, start.y_m]));
    file
}

fn in_flock(index: u32, count: u32) -> Start {
    let side = f64::from(count.div_ceil(FLOCK)).sqrt().ceil();
    let (flock, member) = (f64::from(index / FLOCK), index % FLOCK);
    let (row, column) = ((flock / side).floor(), flock % side);
    // The leader, first of its flock, stands in front of the middle of the others.
    let (ahead, aside) = match member {
        0 => (0.0, 1.5),
        other => (-1.0 - f64::from((other - 1) / 4), f64::from((other - 1) % 4)),
    };
    Start { x_m: row * FLOCK_PITCH_M + ahead * 1.8, y_m: column * FLOCK_PITCH_M + aside * 1.8, yaw_rad: 0.0 }
}

fn flock_behind(leader: u32, end_m: [f64; 2]) -> Flock {
    Flock {
        mode: FlockMode::Safe,
        parties: vec![Party::of_all(leader, vec![end_m])],
        leader_speed_mps: 0.6,
        waypoint_radius_m: 0.5,
        arrive_radius_m: 8.0,
        speed_mps: 10.0,
        turn_radps: 10.0,
        spacing_m: 1.8,
        gain: 1.0,
        obstacle_range_m: 1.2,
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

const DRIVE: Drive = Drive::Mavlink { component: 191, telemetry_hz: 20 };

fn motion(speed_mps_max: f64, margin_m: f64) -> Motion {
    Motion {
        speed_mps_max,
        reverse_mps_max: speed_mps_max / 3.0,
        yaw_rate_radps_max: 1.5,
        accel_mps2_max: 1.0,
        brake_mps2: 1.0,
        yaw_accel_radps2_max: 10.0,
        margin_m,
    }
}

fn lidar(beams: u32, range_m_max: f64) -> Lidar {
    Lidar {
        link: LidarLink::ObstacleDistance { component: 196 },
        beams,
        range_m_min: 0.0,
        range_m_max,
        rate_hz: 10.0,
        fov_rad: TAU,
        mount: Mount::default(),
    }
}

fn timeouts(tick_ms: u32) -> Timeouts {
    Timeouts {
        tick_ms,
        scan_ms: 300,
        odometry_ms: 300,
        link_ms: 1_000,
        command_age_ms: 100,
        peer_ms: 500,
        bringup_s: 60,
    }
}

fn sim(slip_std: f64, range_noise_m: f64, beam_dropout: f64) -> Sim {
    Sim {
        slip_std,
        range_noise_m,
        beam_dropout,
        prearm_s: 0.0,
        range_step_m: 0.0,
        scan_sweep: false,
        motion: SimMotion::DiffDrive,
    }
}

fn walled(side_m: f64) -> World {
    let corners = vec![[0.0, 0.0], [side_m, 0.0], [side_m, side_m], [0.0, side_m]];
    let polygons = vec![Polygon { enclosure: true, points_m: corners }];
    World { name: "square".into(), polygons, ..World::default() }
}

/// Places on a jittered grid, none overlapping; any headings. The seed is fixed: the bench is the same every time.
fn scattered(count: u32, side_m: f64, radius_m: f64) -> Vec<Start> {
    let mut rng = Pcg32::seed_from_u64(1);
    let per_side = f64::from(count).sqrt().ceil();
    let pitch_m = side_m / per_side;
    let slack_m = (pitch_m / 2.0 - radius_m - 0.01).max(0.0);
    let mut jitter = |cell: f64| (cell + 0.5) * pitch_m + rng.random_range(-1.0..1.0) * slack_m;
    let mut start = |index: u32| {
        let (row, column) = ((f64::from(index) / per_side).floor(), f64::from(index) % per_side);
        Start { x_m: jitter(column), y_m: jitter(row), yaw_rad: jitter(0.0) * 1e3 % TAU }
    };
    (0..count).map(&mut start).collect()
}

fn swarm(
    name: &str,
    kind: Kind,
    starts: Vec<Start>,
    (world, behaviour, radio, step_ms): (World, Behaviour, Radio, u32),
) -> Swarm {
    let robot = |(index, start): (usize, Start)| Robot {
        id: index as u32 + 1,
        kind: kind.name.clone(),
        start,
        links: Links::Mavlink { autopilot: String::new() }, // nothing is opened on values
    };
    let beacon = BeaconPlane { group: "239.0.0.1".into(), port: 1, interface: "127.0.0.1".into(), rate_hz: 10.0 };
    Swarm {
        name: name.into(),
        seed: 1,
        duration_s: 1e6,
        step_ms,
        record_dir: String::new(),
        mavlink_port_base: 1,
        world,
        robots: starts.into_iter().enumerate().map(robot).collect(),
        kinds: [(kind.name.clone(), kind)].into(),
        behaviour,
        beacon,
        radio,
    }
}
