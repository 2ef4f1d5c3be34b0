//! What a decision costs against the number of followers, and how much faster than real time the whole swarm runs, on
//! one thread.

use super::scenes::flocks;
use crate::contest::{load, one_thread};
use drover_config::{Flock, Swarm};
use drover_contract::{Pose, RobotId, Stamp, Twist, Vec2};
use drover_core::flock::{FlockLockstep, FlockMember, FlockScene};
use drover_swarm::{FlockSwarm, Trial};
use serde::Serialize;
use std::path::Path;
use std::time::{Duration, Instant};

/// How many follow.
const FOLLOWERS: [u32; 6] = [5, 10, 20, 50, 100, 200];
/// Those of a quick run are the first so many.
const FOLLOWERS_QUICK: usize = 3;
/// A follower's room at the start, as in the paper's scenes.
const ROOM_M2: f64 = 0.0225;
/// The start's east end, a little behind the leader, metres.
const EAST_M: f64 = 0.3;
/// How long the swarm is watched, simulated s.
const WATCH_S: f64 = 20.0;
const WATCH_QUICK_S: f64 = 2.0;
/// Nobody is lost on so short a way, and no wall is anywhere.
const IN_THE_OPEN: [&str; 4] =
    ["world={name=\"open\"}", "behaviour.waypoints_m=[[6.0, 0.0]]", "behaviour.arrive_radius_m=10.0", "seed=1"];
/// Who is within so many spacings is a neighbour; neighbours are counted this often, s.
const NEAR_SPACINGS: f64 = 2.0;
const COUNTED_EVERY_S: f64 = 1.0;

/// The cost with so many followers.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct FlockCostRow {
    /// How many there are, beside the leader.
    pub followers: u32,
    /// How many others a robot has within two spacings, mean over robots and seconds.
    pub neighbours: f64,
    /// One robot's decision with its last layer, microseconds.
    pub tick_us: f64,
    /// Simulated seconds a second of the decisions alone.
    pub real_time: f64,
    /// The same with the world: lasers are cast, bodies move and may touch.
    pub real_time_world: f64,
}

/// Measure with `file`, with other numbers of followers in the open.
pub(super) fn measure(file: &Path, quick: bool) -> anyhow::Result<Vec<FlockCostRow>> {
    let (counts, watch_s) = if quick { (FOLLOWERS_QUICK, WATCH_QUICK_S) } else { (FOLLOWERS.len(), WATCH_S) };
    let row = |followers: &u32| row(&in_the_open(file, *followers)?, *followers, watch_s);
    one_thread()?.install(|| FOLLOWERS[..counts].iter().map(row).collect())
}

/// The same robots without walls, as close together at the start.
fn in_the_open(file: &Path, followers: u32) -> anyhow::Result<Swarm> {
    let side_m = (ROOM_M2 * f64::from(followers)).sqrt();
    let (west_m, half_m) = (EAST_M - side_m, side_m / 2.0);
    let set = [
        format!("fleet[0].count={followers}"),
        format!("fleet[0].region_m=[[{west_m:?}, {:?}], [{EAST_M:?}, {half_m:?}]]", -half_m),
    ];
    load(file, IN_THE_OPEN.into_iter().chain(set.iter().map(String::as_str)))
}

fn row(swarm: &Swarm, followers: u32, watch_s: f64) -> anyhow::Result<FlockCostRow> {
    let flock = flocks(swarm)?;
    let rounds = (watch_s / flock.period_s).round().max(1.0) as u64;
    let (took, neighbours) = decisions(swarm, flock, rounds);
    let took_s = took.as_secs_f64();
    Ok(FlockCostRow {
        followers,
        neighbours,
        tick_us: took_s / (rounds as f64 * swarm.robots.len() as f64) * 1e6,
        real_time: flock.period_s * rounds as f64 / took_s,
        real_time_world: real_time_world(swarm, flock, watch_s),
    })
}

/// Decisions alone, in a world that lets every robot do as it says: how long they took, and how many others were near.
fn decisions(swarm: &Swarm, flock: &Flock, rounds: u64) -> (Duration, f64) {
    let robots = swarm.robots.iter().map(|robot| (RobotId(robot.id), swarm.kind_of(robot)));
    let mut mind = FlockLockstep::new(flock, robots);
    let at_rest = |robot: &drover_config::Robot| {
        let start = robot.start;
        Some(FlockMember { pose_wb: Pose::new(start.x_m, start.y_m, start.yaw_rad), twist_b: Twist::ZERO })
    };
    let mut members: Vec<Option<FlockMember>> = swarm.robots.iter().map(at_rest).collect();
    let returns_b = vec![Vec::new(); members.len()];
    let counted_every = (COUNTED_EVERY_S / flock.period_s).round().max(1.0) as u64;
    let (mut took, mut near, mut counts) = (Duration::ZERO, 0.0, 0.0);
    for round in 0..rounds {
        if round % counted_every == 0 {
            near += neighbours(&members, NEAR_SPACINGS * flock.spacing_m);
            counts += 1.0;
        }
        let now = Stamp::ZERO + Duration::from_secs_f64(flock.period_s * round as f64);
        let begun = Instant::now();
        let moves = mind.round(&FlockScene { now, members: &members, returns_b: &returns_b, walls: &[] });
        took += begun.elapsed();
        for (member, (twist_b, _)) in members.iter_mut().flatten().zip(moves) {
            *member = FlockMember { pose_wb: member.pose_wb.advance(twist_b, flock.period_s), twist_b };
        }
    }
    (took, near / counts)
}

/// How many others are within `near_m` of a robot, mean of all robots.
fn neighbours(members: &[Option<FlockMember>], near_m: f64) -> f64 {
    let places_w: Vec<Vec2> = members.iter().flatten().map(|member| member.pose_wb.position()).collect();
    let near = |at_w: &Vec2| places_w.iter().filter(|other_w| (*other_w - at_w).norm() <= near_m).count() - 1;
    places_w.iter().map(near).sum::<usize>() as f64 / places_w.len().max(1) as f64
}

/// The same with the world around it.
fn real_time_world(swarm: &Swarm, flock: &Flock, watch_s: f64) -> f64 {
    let mut points = FlockSwarm::new(swarm, flock);
    let begun = Instant::now();
    while points.now().as_secs_f64() < watch_s {
        points.step();
    }
    points.now().as_secs_f64() / begun.elapsed().as_secs_f64()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn any_number_starts_in_the_open_and_has_neighbours() {
        let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../config/swarms/flock_u.toml");
        for followers in FOLLOWERS {
            let swarm = in_the_open(&file, followers).unwrap_or_else(|error| panic!("{followers}: {error:#}"));
            assert_eq!(swarm.robots.len() as u32, followers + 1);
            assert!(swarm.world.polygons.is_empty());
        }
        let row = row(&in_the_open(&file, 10).unwrap(), 10, 0.1).unwrap();
        assert!(row.neighbours > 0.5 && row.neighbours < 10.0 && row.tick_us > 0.0, "{row:?}");
    }
}
