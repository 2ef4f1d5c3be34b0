//! `drover bench sim`: robot-steps a second on the peers' work, how the cost grows with the number of robots, and how
//! much faster than real time the wire runs.
//!
//! A robot-step is one robot through one tick of 0.1 s (flocks: 0.05 s): sense, decide, move. *Off* is the world and a
//! law on true values: casting, contacts, diffusion. *On* is everything that a run on values has: slip, range noise,
//! dropout, the whole node with its supervisor, beacons through a lossy radio. Both on one thread.

mod scenes;

use crate::machine::{Conditions, ProcessUse};
use crate::peers::{PeerRate, peers};
use drover_config::Swarm;
use drover_contract::math::sin_cos;
use drover_contract::{Beam, Scan, Stamp, Twist, Vec2};
use drover_core::Diffusion;
use drover_swarm::{DirectSwarm, Trial, VirtualSwarm};
use drover_world::{Arena, BodySpec};
use scenes::{FOOT_BOT, KHEPERA, Peers, TICK_MS};
use serde::Serialize;
use std::f64::consts::TAU;
use std::fmt;
use std::time::{Duration, Instant};

/// What ARGoS 3 reached on its own work, one thread, on an idle 2-core machine: recorded, not measured here.
const ARGOS_FOOT_BOT: [(u32, f64); 3] = [(100, 56e3), (1_000, 45e3), (10_000, 20e3)];
const ARGOS_KHEPERA: [(u32, f64); 2] = [(100, 8.6e3), (1_000, 5.8e3)];

/// What the bench says.
#[derive(Clone, Debug, Serialize)]
pub struct SimResult {
    /// Machine and build.
    pub conditions: Conditions,
    /// The peers' work.
    pub diffusion: Vec<DiffusionRow>,
    /// Peers that ran beside us just now.
    pub beside: Vec<PeerRow>,
    /// Flocks of twenty, on one thread and on all.
    pub flocks: Vec<FlockRow>,
    /// The wire.
    pub wire: WireRow,
}

/// One line of the peers' table.
#[derive(Clone, Debug, Serialize)]
pub struct DiffusionRow {
    /// What the robots carry.
    pub work: &'static str,
    /// How many there are.
    pub robots: u32,
    /// Robot-steps/s with everything off, median of the rounds.
    pub off_per_s: f64,
    /// With everything on.
    pub on_per_s: f64,
    /// ARGoS', recorded.
    pub argos_per_s: f64,
    /// Ours, off, over ARGoS'.
    pub off_ratio: f64,
    /// Ours, on, over ARGoS'.
    pub on_ratio: f64,
}

/// A peer that ran in this same run.
#[derive(Clone, Debug, Serialize)]
pub struct PeerRow {
    /// The peer's own words.
    pub peer: PeerRate,
    /// Ours on the same number of robots and beams, off, robot-steps/s.
    pub ours_per_s: f64,
    /// Ours over the peer's.
    pub ratio: f64,
}

/// What a flocking robot costs among so many.
#[derive(Clone, Debug, Serialize)]
pub struct FlockRow {
    /// How many there are.
    pub robots: u32,
    /// Of one robot-step on one thread, microseconds.
    pub step_us: f64,
    /// Simulated seconds a second, on one thread.
    pub real_time_1: f64,
    /// The same on all cores.
    pub real_time_all: f64,
    /// Beacons that a robot hears a second.
    pub heard_per_s: f64,
    /// Heap bytes a robot.
    pub bytes_per_robot: u64,
    /// Resident bytes a robot that this row added to the process.
    pub resident_per_robot: f64,
}

/// A convoy over every byte in virtual time.
#[derive(Clone, Debug, Serialize)]
pub struct WireRow {
    /// How many there are.
    pub robots: u32,
    /// Simulated seconds a second, on one thread.
    pub real_time: f64,
}

/// How long and how often things are measured.
#[derive(Clone, Copy, Debug)]
struct Effort {
    rounds: usize,
    round: Duration,
    robots_max: u32,
}

/// Measure. `convoy` is what the wire runs.
///
/// # Errors
/// If a thread pool cannot be made, a swarm not be opened, or /proc not be read.
pub fn sim(convoy: &Swarm, quick: bool) -> anyhow::Result<SimResult> {
    let effort = if quick {
        Effort { rounds: 1, round: Duration::from_millis(50), robots_max: 100 }
    } else {
        Effort { rounds: 5, round: Duration::from_millis(1_500), robots_max: 10_000 }
    };
    let conditions = Conditions::now();
    let alone = rayon::ThreadPoolBuilder::new().num_threads(1).build()?;
    let diffusion = alone.install(|| diffusion(&effort));
    let beside = beside(&effort, quick)?;
    let flocks = flock_rows(&effort)?;
    let wire = alone.install(|| wire(convoy, &effort))?;
    Ok(SimResult { conditions, diffusion, beside, flocks, wire })
}

fn diffusion(effort: &Effort) -> Vec<DiffusionRow> {
    let foot_bots = ARGOS_FOOT_BOT.map(|(robots, rate)| ("24 rays of 0.1 m, contacts, 1/m2", FOOT_BOT, robots, rate));
    let kheperas = ARGOS_KHEPERA.map(|(robots, rate)| ("360 beams of 10 m, 0.25/m2", KHEPERA, robots, rate));
    let rows = foot_bots.into_iter().chain(kheperas).filter(|(_, _, robots, _)| *robots <= effort.robots_max);
    let measured = rows.map(|(work, scene, robots, argos_per_s)| {
        let off_per_s = off(&scene, robots, effort);
        let on_per_s = on(&scene, robots, effort);
        let (off_ratio, on_ratio) = (off_per_s / argos_per_s, on_per_s / argos_per_s);
        DiffusionRow { work, robots, off_per_s, on_per_s, argos_per_s, off_ratio, on_ratio }
    });
    measured.collect()
}

/// The world and the law alone, on true values.
fn off(scene: &Peers, robots: u32, effort: &Effort) -> f64 {
    let swarm = scene.swarm(robots, false);
    let mut arena = Arena::new(&swarm.world, &BodySpec::all_of(&swarm), 1);
    let mut demands = vec![Twist::ZERO; robots as usize];
    let mut laws = vec![Diffusion::new(scene.law()); robots as usize];
    let dt_s = f64::from(TICK_MS) / 1e3;
    let rays = rays(scene.beams);
    let mut tick = || {
        for (robot, (demand, law)) in demands.iter_mut().zip(&mut laws).enumerate() {
            let scan = arena.cast(Stamp::ZERO, robot);
            *demand = law.step(near(&scan, &rays, scene.law().clearance_m));
        }
        arena.step(dt_s, &demands);
    };
    rate(f64::from(robots), effort, &mut tick)
}

/// Directions of a full turn's beams.
fn rays(beams: u32) -> Vec<Vec2> {
    let ray = |index| {
        let (sin, cos) = sin_cos(TAU * f64::from(index) / f64::from(beams));
        Vec2::new(cos, sin)
    };
    (0..beams).map(ray).collect()
}

/// What is farther than the law's clearance means nothing to it: only near beams become points.
fn near<'a>(scan: &'a Scan, rays: &'a [Vec2], clearance_m: f64) -> impl Iterator<Item = Vec2> + 'a {
    scan.beams.iter().zip(rays).filter_map(move |(beam, ray)| match beam {
        Beam::Hit(range_m) if *range_m < clearance_m => Some(ray * *range_m),
        Beam::Hit(_) | Beam::Clear | Beam::Unknown => None,
    })
}

/// Everything that a run on values has.
fn on(scene: &Peers, robots: u32, effort: &Effort) -> f64 {
    let mut swarm = DirectSwarm::new(&scene.swarm(robots, true));
    rate(f64::from(robots), effort, &mut || swarm.step())
}

/// How often a second `tick` happens, times `weight`: the median of some rounds, after two seconds of ticks to warm up.
fn rate(weight: f64, effort: &Effort, tick: &mut dyn FnMut()) -> f64 {
    const WARM_UP: usize = 20;
    (0..WARM_UP).for_each(|_| tick());
    let round = |_| {
        let begun = Instant::now();
        let mut ticks = 0;
        while begun.elapsed() < effort.round {
            tick();
            ticks += 1;
        }
        weight * f64::from(ticks) / begun.elapsed().as_secs_f64()
    };
    let mut rates: Vec<f64> = (0..effort.rounds).map(round).collect();
    rates.sort_by(f64::total_cmp);
    rates[rates.len() / 2]
}

fn beside(effort: &Effort, quick: bool) -> anyhow::Result<Vec<PeerRow>> {
    let mut rows = Vec::new();
    for robots in if quick { vec![10] } else { vec![10, 100] } {
        let ours_per_s = off(&KHEPERA, robots, effort);
        for peer in peers(robots, quick)? {
            rows.push(PeerRow { ratio: ours_per_s / peer.robot_steps_per_s, peer, ours_per_s });
        }
    }
    Ok(rows)
}

fn flock_rows(effort: &Effort) -> anyhow::Result<Vec<FlockRow>> {
    let counts = [10, 30, 100, 300, 1_000, 3_000, 10_000];
    counts.into_iter().filter(|robots| *robots <= effort.robots_max).map(|robots| flock_row(robots, effort)).collect()
}

fn flock_row(robots: u32, effort: &Effort) -> anyhow::Result<FlockRow> {
    let config = scenes::flocks(robots);
    let before = ProcessUse::now()?.resident_mib;
    let mut swarm = DirectSwarm::of(&config, |file| scenes::with_own_leader(file, robots));
    let step_s = f64::from(config.step_ms) / 1e3;
    let mut on_threads = |threads: usize| -> anyhow::Result<f64> {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build()?;
        Ok(pool.install(|| rate(step_s, effort, &mut || swarm.step())))
    };
    let (real_time_1, real_time_all) = (on_threads(1)?, on_threads(0)?);
    let resident_mib = ProcessUse::now()?.resident_mib - before;
    let count = f64::from(robots);
    Ok(FlockRow {
        robots,
        step_us: step_s / real_time_1 / count * 1e6,
        real_time_1,
        real_time_all,
        heard_per_s: swarm.radio().carried as f64 / count / swarm.now().as_secs_f64(),
        bytes_per_robot: (swarm.bytes() / robots as usize) as u64,
        resident_per_robot: resident_mib * 1_048_576.0 / count,
    })
}

fn wire(convoy: &Swarm, effort: &Effort) -> anyhow::Result<WireRow> {
    /// Bring-up is over by then, and everybody drives.
    const WARM_UP_S: u64 = 5;
    let mut swarm = VirtualSwarm::unrecorded(convoy)?;
    swarm.run_until(Stamp::from_millis(WARM_UP_S * 1_000));
    let step_s = f64::from(convoy.step_ms) / 1e3;
    let real_time = rate(step_s, effort, &mut || swarm.step());
    Ok(WireRow { robots: convoy.robots.len() as u32, real_time })
}

impl fmt::Display for SimResult {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "bench sim: {}\n", self.conditions)?;
        writeln!(f, "robot-steps/s on one thread (sense, decide, move; one tick of {TICK_MS} ms), median of rounds")?;
        writeln!(
            f,
            "{:<34} {:>7} {:>12} {:>6} {:>12} {:>6} {:>10}",
            "work", "robots", "off", "x", "on", "x", "ARGoS *"
        )?;
        for row in &self.diffusion {
            let DiffusionRow { work, robots, off_per_s, on_per_s, argos_per_s, off_ratio, on_ratio } = row;
            write!(f, "{work:<34} {robots:>7} {off_per_s:>12.0} {off_ratio:>6.1} ")?;
            writeln!(f, "{on_per_s:>12.0} {on_ratio:>6.1} {argos_per_s:>10.0}")?;
        }
        f.write_str(FIDELITY)?;
        for PeerRow { peer, ours_per_s, ratio } in &self.beside {
            let PeerRate { peer, version, robots, beams, robot_steps_per_s, notes } = peer;
            write!(f, "\nbeside us: {peer} {version}, {robots} robots, {beams} beams: {robot_steps_per_s:.0}/s; ")?;
            writeln!(f, "ours {ours_per_s:.0}/s, {ratio:.0} x ({notes})")?;
        }
        if self.beside.is_empty() {
            writeln!(f, "\nbeside us: nobody; bench/peers/setup installs IR-SIM for that")?;
        }
        writeln!(
            f,
            "\nflocks of {}, 72 beams at 10 Hz, node and supervisor at 20 Hz, beacons at 10 Hz:",
            scenes::FLOCK
        )?;
        let title = "us/robot-step   x real time, 1 thread   all cores   heard/s   heap B/robot   resident B/robot";
        writeln!(f, "{:>7}   {title}", "robots")?;
        for row in &self.flocks {
            let FlockRow { robots, step_us, real_time_1, real_time_all, heard_per_s, bytes_per_robot, .. } = row;
            write!(
                f,
                "{robots:>7}   {step_us:>13.2}   {real_time_1:>21.2}   {real_time_all:>9.2}   {heard_per_s:>7.1}"
            )?;
            writeln!(f, "   {bytes_per_robot:>12}   {:>16.0}", row.resident_per_robot)?;
        }
        let WireRow { robots, real_time } = self.wire;
        write!(f, "\nwire: {robots} MAVLink robots, every byte, one thread: {real_time:.1} x real time")
    }
}

/// Where the work is the same and where it is not.
const FIDELITY: &str = "\
* recorded figures of ARGoS 3 on its own (foot-bot: dynamics2d, 10 iterations a tick; Khepera IV: lidar), not run here.
  Theirs: rigid-body contacts that push, 10 substeps, 3-D rays. Ours: contacts that stop (swept, so nothing tunnels),
  one step a tick, planar rays on walls and bodies. Off: no noise. On: slip, range noise, dropout, the whole node with
  its supervisor, beacons at 10 Hz over a radio with 5 % loss and a range of 1 m (24 rays) or 3 m (360 beams).
";
