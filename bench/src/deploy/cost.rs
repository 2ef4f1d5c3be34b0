//! What a round costs: one robot's share of it against the number of robots, and how much faster than real time the
//! whole swarm decides, on one thread.

use super::runs::Task;
use crate::contest::{load, one_thread};
use drover_config::Swarm;
use drover_contract::Vec2;
use drover_core::deploy::Lockstep;
use drover_swarm::{PointSwarm, Trial};
use serde::Serialize;
use std::path::Path;
use std::time::{Duration, Instant};

/// Columns and rows of the squares that are formed.
const LAYOUTS: [(u32, u32); 5] = [(5, 2), (6, 5), (10, 10), (20, 15), (40, 25)];
/// Those of a quick run are the first so many.
const LAYOUTS_QUICK: usize = 3;
/// The square's own spacing, and how much room a robot has at the start, as in experiment 2.
const SPACING_M: f64 = 2.5;
const ROOM_M2: f64 = 7.2;
/// From the start to the layout, metres.
const APART_M: f64 = 23.0;
/// The start's west end, and the height of both middles, metres.
const WEST_M: f64 = 3.0;
const MIDDLE_M: f64 = 30.0;
/// A drive and a lidar on CAN, on which nothing hangs for a point: ids of MAVLink robots end at 250.
const ON_CAN: [&str; 3] = [
    "kinds.point.drive={protocol=\"agilex_v2\", model=\"scout_mini\"}",
    "kinds.point.lidar.link={protocol=\"dronecan\", node=42}",
    "kinds.point.lidar.beams=36",
];
/// Whole ways are repeated until they have taken this long together.
const MEASURE: Duration = Duration::from_secs(2);
const MEASURE_QUICK: Duration = Duration::from_millis(50);

/// The cost with so many robots.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct DeployCostRow {
    /// How many there are.
    pub robots: u32,
    /// How many others one hears, mean over robots and rounds.
    pub neighbours: f64,
    /// One robot's decision, with its share of graph and trees, microseconds.
    pub round_us: f64,
    /// Simulated seconds a second of the rounds alone.
    pub real_time: f64,
    /// The same with the world that moves the points in steps of 50 ms.
    pub real_time_world: f64,
    /// When all had arrived, simulated s; none if they had not.
    pub arrived_s: Option<f64>,
}

/// Measure with `file`, with other numbers of robots.
pub(super) fn measure(file: &Path, quick: bool) -> anyhow::Result<Vec<DeployCostRow>> {
    let (layouts, least) = if quick { (LAYOUTS_QUICK, MEASURE_QUICK) } else { (LAYOUTS.len(), MEASURE) };
    one_thread()?.install(|| LAYOUTS[..layouts].iter().map(|layout| row(&square(file, *layout)?, least)).collect())
}

/// Experiment 2 with another number of robots, as close together at the start and in the layout as there.
fn square(file: &Path, (columns, rows): (u32, u32)) -> anyhow::Result<Swarm> {
    let count = columns * rows;
    let side_m = (ROOM_M2 * f64::from(count)).sqrt();
    let (east_m, half_m) = (WEST_M + side_m, side_m / 2.0);
    let (south_m, north_m) = (MIDDLE_M - half_m, MIDDLE_M + half_m);
    let origin_m = [east_m + APART_M, MIDDLE_M - f64::from(rows - 1) * SPACING_M / 2.0];
    let set = [
        format!("fleet[0].count={count}"),
        format!("fleet[0].region_m=[[{WEST_M:?}, {south_m:?}], [{east_m:?}, {north_m:?}]]"),
        format!("behaviour.layout.origin_m={origin_m:?}"),
        format!("behaviour.layout.columns={columns}"),
        format!("behaviour.layout.rows={rows}"),
        format!("behaviour.layout.spacing_m={SPACING_M:?}"),
        "duration_s=2000".to_owned(),
    ];
    load(file, ON_CAN.into_iter().chain(set.iter().map(String::as_str)))
}

/// Rounds of whole ways, summed.
#[derive(Clone, Copy, Debug, Default)]
struct Rounds {
    count: u64,
    neighbours: u64,
    took: Duration,
}

fn row(swarm: &Swarm, least: Duration) -> anyhow::Result<DeployCostRow> {
    let task = Task::of(swarm)?;
    let mut rounds = Rounds::default();
    let mut arrived_s = None;
    while rounds.took < least {
        arrived_s = whole_way(&task, swarm.duration_s, &mut rounds);
    }
    let robots = swarm.robots.len() as u32;
    let robot_rounds = f64::from(robots) * rounds.count as f64;
    let took_s = rounds.took.as_secs_f64();
    Ok(DeployCostRow {
        robots,
        neighbours: rounds.neighbours as f64 / robot_rounds,
        round_us: took_s / robot_rounds * 1e6,
        real_time: task.deploy.period_s * rounds.count as f64 / took_s,
        real_time_world: real_time_world(swarm, &task, arrived_s.unwrap_or(swarm.duration_s)),
        arrived_s,
    })
}

/// Rounds from the start until all have arrived: when that was.
fn whole_way(task: &Task<'_>, duration_s: f64, rounds: &mut Rounds) -> Option<f64> {
    let mut mind = Lockstep::new(task.deploy, &task.starts_w, Vec::new());
    let mut at_w: Vec<Option<Vec2>> = task.starts_w.iter().copied().map(Some).collect();
    let mut now_s = 0.0;
    while now_s < duration_s {
        let begun = Instant::now();
        let moves = mind.round(&at_w);
        rounds.took += begun.elapsed();
        rounds.count += 1;
        rounds.neighbours += (0..at_w.len()).map(|robot| moves.graph.neighbours(robot).len() as u64).sum::<u64>();
        let arrived = moves.ends_w.iter().enumerate().all(|(robot, end_w)| mind.has_arrived(robot, *end_w));
        at_w = moves.ends_w.into_iter().map(Some).collect();
        now_s += task.deploy.period_s;
        if arrived {
            return Some(now_s);
        }
    }
    None
}

/// The same way with the world around it.
fn real_time_world(swarm: &Swarm, task: &Task<'_>, until_s: f64) -> f64 {
    let mut points = PointSwarm::new(swarm, task.deploy);
    let begun = Instant::now();
    while points.now().as_secs_f64() < until_s {
        points.step();
    }
    points.now().as_secs_f64() / begun.elapsed().as_secs_f64()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_square_of_every_size_starts_as_one_network() {
        let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../config/swarms/deploy_exp2.toml");
        for (columns, rows) in LAYOUTS {
            // Whether starts and layout hang together is asked when it is read.
            let swarm = square(&file, (columns, rows)).unwrap_or_else(|error| panic!("{columns} x {rows}: {error:#}"));
            assert_eq!(swarm.robots.len() as u32, columns * rows);
        }
    }
}
