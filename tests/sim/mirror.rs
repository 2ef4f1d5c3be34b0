//! Mirrored worlds give mirrored runs: nothing in the simulation or in a law knows left from right.
//!
//! Rounding does (beams are counted counter-clockwise, and the sines of a beam and of its mirror image differ in the
//! last bit), so two runs stay mirror images only until something tips over: a guard's threshold, a contact. A flock's
//! 36 s are its whole journey; diffusion, which only asks which side has more, is its mirror image to the last bit.

use crate::swarms::{CROWD, EVERYTHING, MAZE, shipped, written};
use drover_config::{Behaviour, Swarm};
use drover_contract::wrap;
use drover_swarm::{DirectSwarm, Trial};

/// The same with y turned round: walls, starts, ways, lidars and outlines.
fn mirrored(swarm: &Swarm) -> Swarm {
    let flip = |point: &mut [f64; 2]| point[1] = -point[1];
    let mut mirrored = swarm.clone();
    let world = &mut mirrored.world;
    assert!(world.map.is_none(), "a map has no mirror image here");
    world.polygons.iter_mut().flat_map(|polygon| &mut polygon.points_m).for_each(flip);
    world.polylines.iter_mut().flat_map(|line| &mut line.points_m).for_each(flip);
    world.circles.iter_mut().for_each(|circle| flip(&mut circle.centre_m));
    for robot in &mut mirrored.robots {
        robot.start.y_m = -robot.start.y_m;
        robot.start.yaw_rad = -robot.start.yaw_rad;
    }
    match &mut mirrored.behaviour {
        Behaviour::Flock(flock) => {
            flock.parties.iter_mut().flat_map(|party| &mut party.waypoints_m).for_each(flip);
        }
        Behaviour::Diffuse(_) | Behaviour::Explore(_) => {}
        Behaviour::Deploy(deploy) => deploy.targets_m.iter_mut().for_each(flip),
    }
    for kind in mirrored.kinds.values_mut() {
        let mount = &mut kind.lidar.mount;
        (mount.y_m, mount.yaw_rad) = (-mount.y_m, -mount.yaw_rad);
        kind.body.footprint_m.iter_mut().for_each(flip);
        kind.body.footprint_m.reverse();
    }
    mirrored
}

/// Nothing by chance, and nothing that knows left from right: chance is not mirrored, a sweep goes counter-clockwise.
///
/// Every lidar is turned a little. One beam that looks straight ahead and meets something alone is a tie between left
/// and right, which diffusion breaks to the left; with a beam on the heading that happens within seconds.
fn without_chance(mut swarm: Swarm) -> Swarm {
    for kind in swarm.kinds.values_mut() {
        (kind.sim.slip_std, kind.sim.range_noise_m, kind.sim.beam_dropout) = (0.0, 0.0, 0.0);
        kind.sim.scan_sweep = false;
        kind.lidar.mount.yaw_rad = 0.07;
    }
    swarm
}

/// How far a run is from its mirror image's mirror image at most.
#[derive(Debug, Default)]
struct Asymmetry {
    place_m: f64,
    /// Heading, speed and turn, in rad, m/s and rad/s.
    motion: f64,
    /// How far a robot drove on average, metres.
    driven_m: f64,
}

/// Run a swarm and its mirror image side by side.
fn asymmetry(swarm: &Swarm, run_s: f64) -> Asymmetry {
    let (mut here, mut there) = (DirectSwarm::new(swarm), DirectSwarm::new(&mirrored(swarm)));
    let mut all = Asymmetry::default();
    while here.now().as_secs_f64() < run_s {
        here.step();
        there.step();
        for robot in 0..swarm.robots.len() {
            let (a, b) = (here.arena().state(robot), there.arena().state(robot));
            let (pose_a, pose_b, twist_a, twist_b) = (a.pose_wb, b.pose_wb, a.twist_b, b.twist_b);
            let place = [pose_a.x_m - pose_b.x_m, pose_a.y_m + pose_b.y_m];
            let motion = [
                wrap(pose_a.yaw_rad + pose_b.yaw_rad),
                twist_a.speed_mps - twist_b.speed_mps,
                twist_a.yaw_rate_radps + twist_b.yaw_rate_radps,
            ];
            all.place_m = place.iter().fold(all.place_m, |worst, apart| worst.max(apart.abs()));
            all.motion = motion.iter().fold(all.motion, |worst, apart| worst.max(apart.abs()));
        }
    }
    let driven_m = (0..swarm.robots.len()).map(|robot| here.arena().path_m(robot)).sum::<f64>();
    Asymmetry { driven_m: driven_m / swarm.robots.len() as f64, ..all }
}

fn assert_mirrors(swarm: Swarm, run_s: f64) {
    let all = asymmetry(&without_chance(swarm.clone()), run_s);
    assert!(all.driven_m > 0.15 * run_s, "{}, {all:?}: they stood too much to show anything", swarm.name);
    assert!(all.place_m <= 1e-6 && all.motion <= 1e-5, "{} after {run_s} s: {all:?}", swarm.name);
}

#[test]
fn a_flock_in_a_mirrored_room_makes_the_mirrored_journey() {
    for seed in 1..=2 {
        assert_mirrors(shipped("swarms/first.toml", &[&format!("seed={seed}")]), 36.0);
    }
}

#[test]
fn a_crowd_in_a_mirrored_hall_spreads_as_its_mirror_image() {
    assert_mirrors(written(CROWD, &[]), 3.0);
}

#[test]
fn outlines_mounted_lidars_and_bad_radios_in_a_mirrored_cave_and_maze_are_as_their_mirror_images() {
    assert_mirrors(written(MAZE, &[]), 15.0);
    assert_mirrors(written(EVERYTHING, &[]), 15.0);
}
