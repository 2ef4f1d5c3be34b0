//! A team on cells: the paper's robots, one cell large, which go one step to one of eight neighbours at a time, see a
//! square around them without error, and know where they are.

use super::apart::Apart;
use super::ground::Ground;
use drover_config::Explore;
use drover_core::explore::{Explorer, Mate, Move, View, population};
use drover_core::map::{Board, Field, Known, Sight, Unknowns};
use drover_world::RadioTally;
use std::time::Instant;

/// A robot, as it truly is.
struct Body {
    at: usize,
    alive: bool,
    /// How often it has decided.
    turns: u64,
    /// Its way, in cells' sides.
    path_cells: f64,
    explorer: Explorer,
    target: Option<usize>,
    /// What it has seen itself.
    seen: Vec<bool>,
}

/// The team and the ground.
pub(crate) struct CellTeam {
    ground: Ground,
    sight: Sight,
    /// What is known of the ground.
    board: Board,
    /// The same with the cells of the dead occupied: nobody gets past them, and what is behind them is no reason to go
    /// on. None as long as all live.
    passable: Option<Board>,
    finders: Vec<u16>,
    /// What each knows for itself, if they do not share one map: `board` is then what somebody knows.
    apart: Option<Apart>,
    bodies: Vec<Body>,
    step: u32,
    /// Targets that were chosen, and those of them that another robot had seen first.
    chosen: u64,
    chosen_of_others: u64,
    finished: Option<u32>,
    blocked: u64,
    /// How long each decision took, if anybody wants to know.
    decisions_us: Option<Vec<f64>>,
}

impl CellTeam {
    /// Robots on `starts`, which are free cells of `ground`.
    pub(crate) fn new(params: &Explore, ground: Ground, starts: &[usize]) -> Self {
        let board = Board::new(ground.columns(), ground.rows());
        let count = board.count();
        let body = |at: &usize| Body {
            at: *at,
            alive: true,
            turns: 0,
            path_cells: 0.0,
            explorer: Explorer::new(params),
            target: None,
            seen: vec![false; count],
        };
        let mut team = Self {
            sight: Sight::new(params.reach_cells),
            finders: vec![0; count],
            bodies: starts.iter().map(body).collect(),
            step: 0,
            chosen: 0,
            chosen_of_others: 0,
            finished: None,
            blocked: 0,
            decisions_us: None,
            ground,
            board,
            passable: None,
            apart: None,
        };
        team.look();
        team
    }

    /// The same team, each of which has a map of its own.
    pub(crate) fn apart(mut self, apart: Option<Apart>) -> Self {
        self.apart = apart;
        self.look();
        self
    }

    /// Everybody decides and goes one step, in the order of ranks; then everybody looks.
    pub(crate) fn step(&mut self) {
        let mut idle = true;
        for own in 0..self.bodies.len() {
            if self.bodies[own].alive {
                idle &= !self.turn(own);
            }
        }
        self.step += 1;
        if idle && self.finished.is_none() {
            self.finished = Some(self.step - 1);
        }
        self.look();
        let bodies = self.everybody();
        if let Some(apart) = &mut self.apart {
            apart.talk(self.step, &bodies);
        }
    }

    /// One robot's step; whether it has anything left to do.
    fn turn(&mut self, own: usize) -> bool {
        let part = self.apart.as_ref().and_then(|apart| apart.own_part(own));
        let mut moved = self.decide(own, part.as_ref());
        if part.is_some() && moved.target.is_none() {
            self.apart.iter_mut().for_each(|apart| apart.leave_part(own));
            moved = self.decide(own, None);
        }
        let (at, idle) = (self.bodies[own].at, moved.target.is_none());
        if let Some((place, next)) = self.apart.as_mut().and_then(|apart| apart.called(own, at, idle)) {
            self.bodies[own].target = (!idle).then_some(place);
            next.filter(|next| !self.is_taken(own, *next)).into_iter().for_each(|next| self.go(own, next));
            return !idle;
        }
        let Some(target) = moved.target else {
            self.bodies[own].target = None;
            return false;
        };
        self.take(own, moved, target);
        let Some(next) = moved.next else { return true };
        if self.is_taken(own, next) {
            self.blocked += 1;
            let dead = self.bodies.iter().any(|body| body.at == next && !body.alive);
            if let Some(apart) = self.apart.as_mut().filter(|_| dead) {
                apart.meet(own, next);
            }
            self.go_around(own);
        } else {
            self.go(own, next);
        }
        true
    }

    fn decide(&mut self, own: usize, board: Option<&Board>) -> Move {
        let mates = self.mates(own);
        let Self { board: map, passable, apart, finders, sight, bodies, step, decisions_us, .. } = self;
        let around = apart.as_ref().filter(|_| board.is_none()).map(|apart| apart.ways(own));
        let (map, finders, passable) = match &*apart {
            Some(apart) => (apart.board(own), apart.finders(own), around.as_deref()),
            None => (&*map, &finders[..], passable.as_ref()),
        };
        let board = board.or(passable).unwrap_or(map);
        let view = View { board, walls: map, finders, mates: &mates, own, sight, step: *step };
        bodies[own].turns += 1;
        let begun = decisions_us.as_ref().map(|_| Instant::now());
        let moved = bodies[own].explorer.step(&view);
        if let (Some(begun), Some(taken_us)) = (begun, decisions_us) {
            taken_us.push(begun.elapsed().as_secs_f64() * 1e6);
        }
        moved
    }

    /// Everybody, as robot `own` knows it.
    fn mates(&self, own: usize) -> Vec<Option<Mate>> {
        let Body { at, target, .. } = self.bodies[own];
        self.apart.as_ref().map_or_else(|| self.everybody(), |apart| apart.mates(own, Mate { at, target }))
    }

    /// Everybody that lives, as it truly is.
    fn everybody(&self) -> Vec<Option<Mate>> {
        let mate = |body: &Body| body.alive.then_some(Mate { at: body.at, target: body.target });
        self.bodies.iter().map(mate).collect()
    }

    fn take(&mut self, own: usize, moved: Move, target: usize) {
        if moved.chosen && self.bodies[own].target != Some(target) {
            self.chosen += 1;
            let foreign = self.board.at(target) != Known::Unknown && usize::from(self.finders[target]) != own;
            self.chosen_of_others += u64::from(foreign);
        }
        self.bodies[own].target = Some(target);
    }

    fn is_taken(&self, own: usize, cell: usize) -> bool {
        self.bodies.iter().enumerate().any(|(rank, body)| rank != own && body.at == cell)
    }

    /// Somebody stands in the way: choose again as if all bodies were obstacles. Of two that meet in a corridor each
    /// then takes what is on its own side.
    fn go_around(&mut self, own: usize) {
        let mut board = match &self.apart {
            Some(apart) => apart.ways(own).into_owned(),
            None => self.ways().clone(),
        };
        for (rank, body) in self.bodies.iter().enumerate() {
            if rank != own {
                board.learn(body.at, Known::Occupied);
            }
        }
        self.bodies[own].explorer.forget();
        let moved = self.decide(own, Some(&board));
        self.bodies[own].target = moved.target.or(self.bodies[own].target);
        if let Some(next) = moved.next.filter(|next| !self.is_taken(own, *next)) {
            self.go(own, next);
        }
    }

    fn go(&mut self, own: usize, next: usize) {
        let [from, to] = [self.bodies[own].at, next].map(|cell| self.board.place(cell));
        let straight = from[0] == to[0] || from[1] == to[1];
        let body = &mut self.bodies[own];
        body.at = next;
        body.path_cells += if straight { 1.0 } else { std::f64::consts::SQRT_2 };
    }

    fn look(&mut self) {
        let Self { ground, sight, board, passable, apart, finders, bodies, .. } = self;
        let mut seen = Vec::new();
        for (rank, body) in bodies.iter_mut().enumerate().filter(|(_, body)| body.alive) {
            seen.clear();
            sight.look(board, body.at, |cell| ground.is_solid(cell), |cell| seen.push(cell));
            apart.iter_mut().for_each(|apart| apart.look_from(rank, body.at));
            for cell in &seen {
                apart.iter_mut().for_each(|apart| apart.see(rank, *cell, ground.is_solid(*cell)));
                body.seen[*cell] = true;
                let known = if ground.is_solid(*cell) { Known::Occupied } else { Known::Free };
                if board.learn(*cell, known) {
                    finders[*cell] = rank as u16;
                    // News is never of a cell that a dead robot holds: it saw that itself.
                    passable.iter_mut().for_each(|passable| {
                        passable.learn(*cell, known);
                    });
                }
            }
        }
    }

    /// Take the time of every decision from now on.
    pub(crate) fn time_decisions(&mut self) {
        self.decisions_us = Some(Vec::new());
    }

    /// What they took, microseconds.
    pub(crate) fn decisions_us(&self) -> &[f64] {
        self.decisions_us.as_deref().unwrap_or_default()
    }

    /// A robot dies where it stands, and blocks its cell for good.
    pub(crate) fn kill(&mut self, rank: usize) {
        if let Some(body) = self.bodies.get_mut(rank) {
            body.alive = false;
            body.target = None;
            self.passable.get_or_insert_with(|| self.board.clone()).learn(body.at, Known::Occupied);
        }
    }

    /// The map by which ways are found.
    fn ways(&self) -> &Board {
        self.passable.as_ref().unwrap_or(&self.board)
    }

    pub(crate) fn steps(&self) -> u32 {
        self.step
    }

    pub(crate) fn finished(&self) -> Option<u32> {
        self.finished
    }

    /// The share of free cells that can be reached which is known.
    pub(crate) fn coverage(&self) -> f64 {
        self.board.free_count() as f64 / self.ground.reachable_count().max(1) as f64
    }

    /// Views of free cells by a second, third robot, over free cells that are known.
    pub(crate) fn overlap(&self) -> f64 {
        let free = (0..self.board.count()).filter(|cell| self.board.at(*cell) == Known::Free);
        let views: usize = free.map(|cell| self.bodies.iter().filter(|body| body.seen[cell]).count()).sum();
        views as f64 / self.board.free_count().max(1) as f64 - 1.0
    }

    /// What they said to each other, bytes by receiver within range; none if they share one map.
    pub(crate) fn bytes_said(&self) -> Option<u64> {
        self.apart.as_ref().map(Apart::bytes)
    }

    /// What happened on the air.
    pub(crate) fn radio(&self) -> RadioTally {
        self.apart.as_ref().map(Apart::radio).unwrap_or_default()
    }

    /// Targets that were chosen so far, and those of them that another robot had seen first.
    pub(crate) fn targets(&self) -> [u64; 2] {
        [self.chosen, self.chosen_of_others]
    }

    pub(crate) fn obex(&self) -> f64 {
        self.chosen_of_others as f64 / self.chosen.max(1) as f64
    }

    pub(crate) fn path_cells(&self) -> f64 {
        self.bodies.iter().map(|body| body.path_cells).sum()
    }

    /// Steps in which somebody stood in the way.
    pub(crate) fn blocked(&self) -> u64 {
        self.blocked
    }

    /// Frontier cells that somebody who lives can reach over free cells that no dead robot holds.
    pub(crate) fn frontiers_in_reach(&self) -> u64 {
        let mut in_reach = vec![false; self.board.count()];
        let mut field = Field::default();
        for body in self.bodies.iter().filter(|body| body.alive) {
            field.spread(self.ways(), body.at, Unknowns::Solid);
            field.reached().iter().for_each(|cell| in_reach[*cell] = true);
        }
        self.ways().frontier().filter(|cell| in_reach[*cell]).count() as u64
    }

    /// The fewest steps in which so many robots can see a share of the ground: each first sees its square, then at
    /// every diagonal step the new cells of two sides of it.
    pub(crate) fn sweep_bound(&self, share: f64) -> f64 {
        let side = f64::from(2 * self.sight.reach() + 1);
        let each = self.ground.reachable_count() as f64 * share / self.bodies.len().max(1) as f64;
        (each - side * side) / (2.0 * side - 1.0)
    }

    /// Where a robot stands, and where it goes.
    pub(crate) fn robot(&self, rank: usize) -> (usize, Option<usize>) {
        (self.bodies[rank].at, self.bodies[rank].target)
    }

    /// The antibodies of a robot, were it to decide now by the paper's network.
    pub(crate) fn population(&self, params: &Explore, own: usize) -> Vec<[f64; 2]> {
        let mates = self.mates(own);
        let Self { finders, sight, step, .. } = self;
        population(
            params,
            &View { board: self.ways(), walls: &self.board, finders, mates: &mates, own, sight, step: *step },
        )
    }

    /// Heap bytes that the maps hold.
    pub(crate) fn bytes(&self) -> usize {
        self.board.bytes() + self.passable.as_ref().map_or(0, Board::bytes)
    }

    /// How often a robot has decided.
    pub(crate) fn turns(&self, rank: usize) -> u64 {
        self.bodies[rank].turns
    }
}
