//! What an exploration by bodies is measured by, from outside: what of the place is in some robot's map, second by
//! second, and whether the maps are true.

use super::figures::Milestones;
use crate::trial::Trial;
use drover_config::{Kind, Swarm};
use drover_contract::Vec2;
use drover_core::map::{Board, Field, Known, Lattice, Unknowns};
use drover_world::Walls;
use serde::Serialize;

/// One run of an exploration by bodies.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SurveyFigures {
    /// Steps of a second until 90 % of the cells in which a body can be were known to somebody; none if they never
    /// were.
    pub steps_90: Option<u32>,
    /// The same for 95 %.
    pub steps_95: Option<u32>,
    /// The same for 96 %.
    pub steps_96: Option<u32>,
    /// The same for 99 %.
    pub steps_99: Option<u32>,
    /// Steps until every robot that lives had its certificate.
    pub steps_finish: Option<u32>,
    /// Whether that came.
    pub finished: bool,
    /// The share of the cells in which a body can be that is known: in the map of the living robot that knows least.
    pub coverage: f64,
    /// Cells in which a body can be, beside known ones, that the robot that knows least does not know: if it has its
    /// certificate, this should be 0.
    pub unreached_frontiers: u64,
    /// The robots' ways together, metres.
    pub path_m: f64,
    /// The share of occupied cells whose middle is no farther than a cell's side from a wall, in the worst map.
    pub map_at_walls: f64,
    /// What the robots sent to each other, bytes, beacons among them; 0 where messages travel as values.
    pub bytes: u64,
}

/// Watches one run.
pub(crate) struct Surveying {
    lattice: Lattice,
    /// Where a body can be, and get to from the first robot's start.
    reachable: Vec<usize>,
    milestones: Milestones,
    next_s: f64,
    finished: Option<u32>,
}

impl Surveying {
    /// A run of bodies that explore; none for another.
    pub(crate) fn new(swarm: &Swarm, trial: &dyn Trial) -> Option<Self> {
        let lattice = *trial.map(0)?.lattice();
        let first = swarm.robots.first()?;
        // What a robot takes for a wall may be a cell nearer than the wall is: from here on it surely has room.
        let keep_m = |kind: &Kind| kind.body.radius_m + kind.motion.margin_m + lattice.cell_m();
        let keep_m = swarm.robots.iter().map(|robot| keep_m(swarm.kind_of(robot))).fold(0.0, f64::max);
        let start_w = Vec2::new(first.start.x_m, first.start.y_m);
        let reachable = reach(&lattice, trial.arena().walls(), start_w, keep_m);
        Some(Self { lattice, reachable, milestones: Milestones::default(), next_s: 0.0, finished: None })
    }

    /// After every step of the world.
    pub(crate) fn see(&mut self, trial: &dyn Trial, time_s: f64) {
        let robots = 0..trial.arena().robot_count();
        if robots.clone().filter_map(|robot| trial.status(robot)).all(|status| status.reached) {
            self.finished.get_or_insert(time_s.ceil() as u32);
        } else {
            self.finished = None; // news took a certificate back
        }
        if time_s < self.next_s || self.milestones.are_passed() {
            return;
        }
        self.next_s += 1.0;
        let boards: Vec<&Board> = robots.filter_map(|robot| trial.map(robot)).map(|map| map.board()).collect();
        let known = |cell: &&usize| boards.iter().any(|board| board.at(**cell) != Known::Unknown);
        let share = self.reachable.iter().filter(known).count() as f64 / self.reachable.len().max(1) as f64;
        self.milestones.see(share, time_s.round() as u32);
    }

    /// What came out.
    pub(crate) fn figures(&self, trial: &dyn Trial) -> SurveyFigures {
        let arena = trial.arena();
        let living = (0..arena.robot_count()).filter(|robot| trial.status(*robot).is_some());
        let boards: Vec<&Board> = living.filter_map(|robot| trial.map(robot)).map(|map| map.board()).collect();
        let unknown = |board: &&Board| self.reachable.iter().filter(|cell| board.at(**cell) == Known::Unknown).count();
        let worst = boards.iter().copied().max_by_key(unknown);
        let Milestones([steps_90, steps_95, steps_96, steps_99]) = self.milestones;
        SurveyFigures {
            steps_90,
            steps_95,
            steps_96,
            steps_99,
            steps_finish: self.finished,
            finished: self.finished.is_some(),
            coverage: worst.map_or(0.0, |board| 1.0 - unknown(&board) as f64 / self.reachable.len().max(1) as f64),
            unreached_frontiers: worst.map_or(0, |board| self.missed(board)),
            path_m: (0..arena.robot_count()).map(|robot| arena.path_m(robot)).sum(),
            map_at_walls: boards.iter().map(|board| self.at_walls(board, arena.walls())).fold(1.0, f64::min),
            bytes: trial.messages_bytes(),
        }
    }

    /// Cells in which a body can be, unknown, beside a known free one in which it can be.
    fn missed(&self, board: &Board) -> u64 {
        let here = |cell: &usize| self.reachable.binary_search(cell).is_ok();
        let missed = |cell: &&usize| {
            board.at(**cell) == Known::Unknown
                && board.neighbours(**cell).any(|other| board.at(other) == Known::Free && here(&other))
        };
        self.reachable.iter().filter(missed).count() as u64
    }

    fn at_walls(&self, board: &Board, walls: &Walls) -> f64 {
        let occupied = (0..board.count()).filter(|cell| board.at(*cell) == Known::Occupied);
        let near = |cell: &usize| {
            let centre_w = self.lattice.centre_w(*cell);
            walls.distance_m(centre_w).is_some_and(|gap_m| gap_m <= self.lattice.cell_m())
        };
        let all: Vec<usize> = occupied.collect();
        if all.is_empty() { 1.0 } else { all.iter().filter(|cell| near(cell)).count() as f64 / all.len() as f64 }
    }
}

/// The cells of the lattice whose middles are farther than `keep_m` from every wall, and that can be got to from a
/// place over such cells; sorted.
fn reach(lattice: &Lattice, walls: &Walls, start_w: Vec2, keep_m: f64) -> Vec<usize> {
    let mut board = Board::new(lattice.columns(), lattice.rows());
    for cell in 0..board.count() {
        let centre_w = lattice.centre_w(cell);
        let near = walls.is_solid(centre_w) || walls.distance_m(centre_w).is_some_and(|gap_m| gap_m <= keep_m);
        board.learn(cell, if near { Known::Occupied } else { Known::Free });
    }
    let far = |cell: &usize| (lattice.centre_w(*cell) - start_w).norm_squared();
    let free = (0..board.count()).filter(|cell| board.at(*cell) == Known::Free);
    // Who starts close to a wall goes away from it first.
    let Some(home) = free.min_by(|a, b| far(a).total_cmp(&far(b))) else { return Vec::new() };
    let mut field = Field::default();
    field.spread(&board, home, Unknowns::Solid);
    let mut reached = field.reached().to_vec();
    reached.sort_unstable();
    reached
}
