//! Exploration of simulated points as a trial: the team on cells, and its bodies on their way from middle to middle.

use super::apart::Apart;
use super::cells::CellTeam;
use super::figures::{ExploreFigures, Exploring};
use super::ground::Ground;
use crate::points::pose_towards;
use crate::trial::Trial;
use drover_config::{Explore, Swarm};
use drover_contract::{BehaviourState, Pose, Stamp, Vec2};
use drover_core::map::Lattice;
use drover_core::{Status, Verdict};
use drover_robot::View;
use drover_world::{Arena, BodySpec, RadioTally, Walls};
use std::time::Duration;

/// Cells over all walls and starts, and a rim around them.
fn lattice_over(walls: &Walls, starts_w: &[Vec2], cell_m: f64) -> Lattice {
    let ends = walls.segments().iter().flat_map(|edge| [edge.from_w, edge.to_w]);
    let places_w: Vec<Vec2> = ends.chain(starts_w.iter().copied()).collect();
    let low_w = places_w.iter().copied().reduce(|low, place| low.inf(&place)).unwrap_or_default();
    let high_w = places_w.iter().copied().reduce(|high, place| high.sup(&place)).unwrap_or_default();
    let rim = Vec2::repeat(cell_m);
    Lattice::over(low_w - rim, high_w + rim, cell_m)
}

/// Cells whose middles are in walls are solid.
fn ground_of(lattice: &Lattice, walls: &Walls, start_w: Vec2) -> Ground {
    let (columns, rows) = (lattice.columns(), lattice.rows());
    let solid = |column: usize, row: usize| walls.is_solid(lattice.centre_w(row * columns + column));
    Ground::new((columns, rows), solid, |ground| free_near(lattice, ground, start_w, &[]))
}

/// The free cell nearest to a place that nobody has taken.
fn free_near(lattice: &Lattice, ground: &Ground, place_w: Vec2, taken: &[usize]) -> Option<usize> {
    let home = lattice.cell_near(place_w);
    if !ground.is_solid(home) && !taken.contains(&home) {
        return Some(home);
    }
    let count = lattice.columns() * lattice.rows();
    let free = (0..count).filter(|cell| !ground.is_solid(*cell) && !taken.contains(cell));
    let far = |cell: &usize| (lattice.centre_w(*cell) - place_w).norm_squared();
    free.min_by(|a, b| far(a).total_cmp(&far(b)))
}

/// A swarm of points on cells.
pub struct CellSwarm {
    now: Stamp,
    step: Duration,
    period: Duration,
    round_due: Stamp,
    arena: Arena,
    lattice: Lattice,
    team: CellTeam,
    exploring: Exploring,
    ids: Vec<u32>,
    alive: Vec<bool>,
    from_w: Vec<Vec2>,
    ends_w: Vec<Vec2>,
    statuses: Vec<Status>,
}

impl CellSwarm {
    /// Points at rest at time zero, on the free cells nearest to their starts. `explore` is what they do.
    #[must_use]
    pub fn new(swarm: &Swarm, explore: &Explore) -> Self {
        let bodies = BodySpec::all_of(swarm);
        let arena = Arena::new(&swarm.world, &bodies, swarm.seed);
        let starts_w: Vec<Vec2> = bodies.iter().map(|body| body.start.position()).collect();
        let lattice = lattice_over(arena.walls(), &starts_w, explore.cell_m);
        let ground = ground_of(&lattice, arena.walls(), starts_w.first().copied().unwrap_or_default());
        let mut starts = Vec::with_capacity(starts_w.len());
        for start_w in &starts_w {
            let home = lattice.cell_near(*start_w);
            starts.push(free_near(&lattice, &ground, *start_w, &starts).unwrap_or(home));
        }
        let status = |body: &BodySpec| Status {
            verdict: Verdict::Driving,
            state: BehaviourState::Active,
            ..Status::first(Stamp::ZERO, body.start)
        };
        let apart = Apart::new(swarm, explore, &lattice, &starts);
        let team = CellTeam::new(explore, ground, &starts).apart(apart);
        let mut exploring = Exploring::default();
        exploring.see(&team);
        Self {
            now: Stamp::ZERO,
            step: Duration::from_millis(u64::from(swarm.step_ms.max(1))),
            period: Duration::from_secs_f64(explore.step_s),
            round_due: Stamp::ZERO,
            ends_w: starts_w.clone(),
            from_w: starts_w,
            ids: swarm.robots.iter().map(|robot| robot.id).collect(),
            alive: vec![true; bodies.len()],
            statuses: bodies.iter().map(status).collect(),
            arena,
            lattice,
            team,
            exploring,
        }
    }

    /// Robot `robot` dies: it stands where it is, and others go around it. What they cannot get to without moving it
    /// stays unknown, and does not keep them from being done.
    pub fn kill(&mut self, robot: usize) {
        if let Some(alive) = self.alive.get_mut(robot) {
            *alive = false;
            self.team.kill(robot);
        }
    }

    /// Steps that the team has made.
    #[must_use]
    pub fn rounds(&self) -> u32 {
        self.team.steps()
    }

    /// The same team, that takes the time of every decision.
    #[must_use]
    pub fn timed(mut self) -> Self {
        self.team.time_decisions();
        self
    }

    /// The share of the free cells that can be reached, were nobody dead, which is known.
    #[must_use]
    pub fn coverage(&self) -> f64 {
        self.team.coverage()
    }

    /// Targets that were chosen so far, and those of them that another robot had seen first.
    #[must_use]
    pub fn targets(&self) -> [u64; 2] {
        self.team.targets()
    }

    /// The antibodies of a robot that lives, were it to decide now by the network of `explore`: each one's affinity and
    /// stimulation.
    #[must_use]
    pub fn population(&self, explore: &Explore, robot: usize) -> Vec<[f64; 2]> {
        self.team.population(explore, robot)
    }

    /// How long each decision took so far, microseconds; nothing unless they are timed.
    #[must_use]
    pub fn decisions_us(&self) -> &[f64] {
        self.team.decisions_us()
    }

    /// One step of the team alone, whose bodies then stand where they stood: for who wants nothing but the figures.
    /// Whether there is anything left to do.
    pub fn round(&mut self) -> bool {
        if self.team.finished().is_none() {
            self.team.step();
            self.exploring.see(&self.team);
        }
        self.team.finished().is_none()
    }

    /// Everybody decides and is on the way to the next cell.
    fn decide(&mut self) {
        self.from_w.clone_from(&self.ends_w);
        self.round();
        let done = self.team.finished().is_some();
        for (robot, status) in self.statuses.iter_mut().enumerate().filter(|(robot, _)| self.alive[*robot]) {
            let (at, target) = self.team.robot(robot);
            self.ends_w[robot] = self.lattice.centre_w(at);
            status.stamp = self.now;
            status.counters.ticks = self.team.turns(robot);
            status.target_w = target.map(|cell| self.lattice.centre_w(cell));
            status.reached = done;
            status.state = if done { BehaviourState::Done } else { BehaviourState::Active };
        }
    }

    /// The pose of a body that has gone a share of its step.
    fn pose_at(&self, robot: usize, share: f64) -> Pose {
        let to_w = self.from_w[robot] + (self.ends_w[robot] - self.from_w[robot]) * share;
        pose_towards(self.arena.state(robot).pose_wb, to_w)
    }
}

impl Trial for CellSwarm {
    fn now(&self) -> Stamp {
        self.now
    }

    fn step(&mut self) {
        if self.now >= self.round_due {
            self.round_due = self.now + self.period;
            self.decide();
        }
        self.now = self.now + self.step;
        let left = self.round_due.since(self.now).as_secs_f64() / self.period.as_secs_f64();
        let share = (1.0 - left).clamp(0.0, 1.0);
        let poses: Vec<Pose> = (0..self.ids.len()).map(|robot| self.pose_at(robot, share)).collect();
        self.arena.glide(self.step.as_secs_f64(), &poses);
        for (robot, status) in self.statuses.iter_mut().enumerate() {
            status.pose_wb = poses[robot];
            status.twist_b = self.arena.state(robot).twist_b;
            status.path_m = self.arena.path_m(robot);
        }
    }

    fn arena(&self) -> &Arena {
        &self.arena
    }

    fn status(&self, robot: usize) -> Option<&Status> {
        self.statuses.get(robot).filter(|_| self.alive[robot])
    }

    fn view(&self, robot: usize) -> Option<View> {
        Some(View::of_status(self.ids[robot], self.status(robot)?, self.now))
    }

    fn radio(&self) -> RadioTally {
        self.team.radio()
    }

    fn aged_commands(&self) -> u64 {
        0 // a point has no wheels to command
    }

    fn bytes(&self) -> usize {
        self.arena.bytes().0 + self.team.bytes() + self.statuses.capacity() * size_of::<Status>()
    }

    fn explored(&self) -> Option<ExploreFigures> {
        Some(self.exploring.figures(&self.team, self.lattice.cell_m()))
    }
}
