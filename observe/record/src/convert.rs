//! From configurations and robots' own views to what is seen.

use crate::foxglove::{HeardLink, LinkHealth};
use crate::moment::{Heard, Place, RobotMoment, ScanMoment, Truth};
use crate::setting::{GoalSetting, MapSetting, MoverSetting, PlaceSetting, RobotSetting, Setting, Source};
use drover_config::{Behaviour, GridMap, Kind, Mover, Robot, RobotFile, Swarm, World};
use drover_contract::{Pose, Twist};
use drover_robot::{ScanView, View};

impl From<Pose> for Place {
    fn from(pose: Pose) -> Self {
        Self { x_m: pose.x_m, y_m: pose.y_m, yaw_rad: pose.yaw_rad }
    }
}

const fn pair(twist: Twist) -> [f64; 2] {
    [twist.speed_mps, twist.yaw_rate_radps]
}

impl Truth {
    /// A body that is at `pose_wb`, moves with `twist_b` and touches something or not.
    #[must_use]
    pub fn new(pose_wb: Pose, twist_b: Twist, in_contact: bool) -> Self {
        Self { place: pose_wb.into(), twist_b: pair(twist_b), in_contact }
    }
}

impl From<&ScanView> for ScanMoment {
    fn from(scan: &ScanView) -> Self {
        Self {
            time_s: scan.stamp_us as f64 * 1e-6,
            angle_first_rad: scan.angle_first_rad,
            angle_step_rad: scan.angle_step_rad,
            range_m_max: scan.range_m_max,
            ranges_m: scan.ranges_m.clone(),
        }
    }
}

impl RobotMoment {
    /// What a robot tells of itself, and where its body is if a simulator says so.
    #[must_use]
    pub fn of_view(view: &View, truth: Option<Truth>) -> Self {
        let heard = view.heard.iter().map(|peer| Heard { id: peer.id, age_ms: peer.age_ms, kept: peer.kept });
        Self {
            id: view.id,
            state: view.state.clone(),
            reason: view.reason.clone(),
            changed: view.changed.clone(),
            link: view.link.clone(),
            truth,
            believed: view.pose_wb.map(Place::from),
            pos_bound_m: view.pos_bound_m,
            twist_b: [view.speed_mps, view.yaw_rate_radps],
            command_b: pair(view.command_b),
            request_b: view.request_b.map(pair),
            target_w: view.target_m,
            nearest_m: view.nearest_m,
            scan_age_ms: view.scan_age_ms,
            link_age_ms: view.odometry_age_ms,
            progress: view.progress,
            reached: view.reached,
            charge: view.battery.and_then(|battery| battery.charge),
            heard: heard.collect(),
            scan: view.scan.as_ref().map(ScanMoment::from),
        }
    }

    /// A robot of which nothing was heard yet, or nothing any more.
    #[must_use]
    pub fn unheard(id: u32, truth: Option<Truth>) -> Self {
        Self { id, state: "unheard".into(), reason: "its loop never spoke".into(), truth, ..Self::default() }
    }
}

impl Setting {
    /// A simulated swarm whose clock's zero is `started_unix_us`.
    #[must_use]
    pub fn of_swarm(swarm: &Swarm, started_unix_us: u64) -> Self {
        let robots = swarm.robots.iter().map(|robot| robot_setting(robot, swarm.kind_of(robot))).collect();
        Self {
            swarm: swarm.name.clone(),
            seed: swarm.seed,
            source: Source::Simulation,
            started_unix_us,
            duration_s: Some(swarm.duration_s),
            robots,
            place: place_setting(&swarm.world),
            ..of_behaviour(&swarm.behaviour, None)
        }
    }

    /// One robot in the field whose clock's zero is `started_unix_us`.
    #[must_use]
    pub fn of_robot(file: &RobotFile, started_unix_us: u64) -> Self {
        Self {
            swarm: file.swarm.clone(),
            source: Source::Field,
            started_unix_us,
            robots: vec![robot_setting(&file.robot, &file.kind)],
            ..of_behaviour(&file.behaviour, Some(file.robot.id))
        }
    }
}

/// What robot `id` is to do; without one, the first party: a setting has room for one route.
fn of_behaviour(behaviour: &Behaviour, id: Option<u32>) -> Setting {
    match behaviour {
        Behaviour::Flock(flock) => {
            let within_m = flock.arrive_radius_m.max(flock.waypoint_radius_m);
            let party = id.map_or(flock.parties.first(), |id| flock.party_of(id));
            let goal = party.map(|party| GoalSetting { at_m: party.end_m(), within_m });
            let route_m = party.map(|party| party.waypoints_m.clone()).unwrap_or_default();
            Setting { behaviour: "flock".into(), route_m, goal, ..Setting::default() }
        }
        Behaviour::Diffuse(_) => Setting { behaviour: "diffuse".into(), ..Setting::default() },
        Behaviour::Deploy(_) => Setting { behaviour: "deploy".into(), ..Setting::default() },
        Behaviour::Explore(_) => Setting { behaviour: "explore".into(), ..Setting::default() },
    }
}

fn robot_setting(robot: &Robot, kind: &Kind) -> RobotSetting {
    let mount = kind.lidar.mount;
    RobotSetting {
        id: robot.id,
        kind: robot.kind.clone(),
        radius_m: kind.body.radius_m,
        footprint_m: kind.body.footprint_m.clone(),
        lidar_mount: [mount.x_m, mount.y_m, mount.yaw_rad],
        speed_mps_max: kind.motion.speed_mps_max,
        scan_ms: kind.timeouts.scan_ms,
        odometry_ms: kind.timeouts.odometry_ms,
        peer_ms: kind.timeouts.peer_ms,
    }
}

fn place_setting(world: &World) -> PlaceSetting {
    let (inside, outside): (Vec<_>, Vec<_>) = world.polygons.iter().partition(|polygon| polygon.enclosure);
    PlaceSetting {
        name: world.name.clone(),
        enclosure_m: inside.first().map(|polygon| polygon.points_m.clone()).unwrap_or_default(),
        polygons_m: outside.into_iter().map(|polygon| polygon.points_m.clone()).collect(),
        circles_m: world
            .circles
            .iter()
            .map(|circle| [circle.centre_m[0], circle.centre_m[1], circle.radius_m])
            .collect(),
        polylines_m: world.polylines.iter().map(|line| line.points_m.clone()).collect(),
        map: world.map.as_deref().map(map_setting),
        movers: world.movers.iter().map(mover_setting).collect(),
    }
}

fn mover_setting(mover: &Mover) -> MoverSetting {
    MoverSetting { radius_m: mover.radius_m, round_m: mover.round_m() }
}

fn map_setting(map: &GridMap) -> MapSetting {
    let mut runs = Vec::new();
    let (mut current, mut length) = (false, 0_u32);
    for solid in &map.solid {
        if *solid != current {
            runs.push(length);
            (current, length) = (*solid, 0);
        }
        length += 1;
    }
    runs.push(length);
    MapSetting {
        resolution_m: map.resolution_m,
        origin_m: map.origin_m,
        origin_yaw_rad: map.origin_yaw_rad,
        width: map.width,
        height: map.height,
        runs,
    }
}

impl LinkHealth {
    /// What a robot tells of its links.
    #[must_use]
    pub fn of_view(view: &View) -> Self {
        let [beacons_taken, beacons_old, beacons_duplicate] = view.beacons;
        let heard = view.heard.iter().map(|peer| HeardLink { id: peer.id, age_ms: peer.age_ms, kept: peer.kept });
        Self {
            robot: view.id,
            received: view.links.received,
            sent: view.links.sent,
            dropped_full: view.links.dropped_full,
            errors: view.links.errors,
            last_error: view.links.last_error.clone(),
            beacons_taken,
            beacons_old,
            beacons_duplicate,
            beacons_refused: view.beacons_refused,
            heard: heard.collect(),
        }
    }
}
