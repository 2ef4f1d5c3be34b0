//! Robots on cells that do not share one map: each has its own, and hears of the others' over the modelled radio.
//!
//! Two exchanges: *gossip*, what real robots do (`drover_core::map::Exchange`), and the paper's *observation points*:
//! every `global_steps` steps one tells the places from which one has looked, and one's candidates. Who hears of a
//! place takes the square around it for seen, though walls hid some of it from whoever looked, and walks into what it
//! was not told of. That is how the paper spares the map; what it costs is measured.
//!
//! Where the others start is in everybody's file. Of one that is not heard the last known place counts: its
//! surroundings are its part until one knows better, which divides the place without a word.

use drover_config::{Explore, MapExchange, Swarm};
use drover_contract::{MapReport, RobotId, Stamp, Vec2, Writer};
use drover_core::explore::{Gathering, Mate, Meetings, parts, sectors};
use drover_core::map::{Board, Exchange, Field, Known, Lattice, SharedMap, Unknowns};
use drover_world::{Radio, RadioTally};
use std::borrow::Cow;
use std::sync::Arc;
use std::time::Duration;

/// By gossip robots speak every so many steps: what is new by then goes in few messages.
const TALK_STEPS: u32 = 5;
/// So many reports at once at most, a tenth of a second apart.
const REPORTS_MAX: u64 = 10;
/// Who was not heard for so many steps has left.
const GONE_STEPS: u32 = 15;
/// A report is heard within this, or never: delays of a radio are shorter.
const LATE: Duration = Duration::from_millis(90);
/// On the air: a report without a piece, what a piece adds beside its changes; an observation point; a candidate.
const REPORT_BYTES: u64 = 12 + 84;
const PIECE_BYTES: u64 = 18;
const POINT_BYTES: u64 = 4;
const CANDIDATE_BYTES: u64 = 5;
/// Which life a robot is in: nobody comes back.
const EPOCH: u32 = 1;

/// What is said.
#[derive(Clone, Debug)]
enum Said {
    Report(MapReport),
    /// All that the sender has looked from, the oldest first.
    Points(Vec<usize>),
}

/// What one robot knows.
struct Member {
    map: SharedMap,
    exchange: Exchange,
    /// By observation points: what it takes for known.
    presumed: Board,
    /// Who first saw each cell, as far as it knows, by rank.
    finders: Vec<u16>,
    /// Where it believes the others to be, by rank, and where they go.
    mates: Vec<Mate>,
    /// From where it has looked.
    points: Vec<usize>,
    /// How many of everybody's points it has heard of, by rank.
    heard_points: Vec<usize>,
    /// When it last heard each, steps.
    heard: Vec<u32>,
    meetings: Meetings,
    /// Whose each cell is until the next meeting, by rank.
    parts: Vec<u16>,
    /// It has seen to its part as far as it got: until the next meeting all of the place is its business.
    part_done: bool,
    /// Cells of bodies that it has walked into and that do not move.
    obstacles: Vec<usize>,
}

/// All of them.
pub(crate) struct Apart {
    kind: MapExchange,
    every: u32,
    reach: i32,
    radio: Radio<Arc<(usize, Said)>>,
    range_m: f64,
    lattice: Lattice,
    members: Vec<Member>,
    now: Stamp,
    at_step: u32,
    step: Duration,
    bytes: u64,
}

impl Apart {
    /// Robots that start on these cells; none if they share one map.
    pub(crate) fn new(swarm: &Swarm, explore: &Explore, lattice: &Lattice, starts: &[usize]) -> Option<Self> {
        let every = match explore.exchange {
            MapExchange::Ideal => return None,
            MapExchange::Gossip => TALK_STEPS,
            MapExchange::Points => explore.global_steps.max(1),
        };
        let ids: Vec<u32> = swarm.robots.iter().map(|robot| robot.id).collect();
        let unknown = Board::new(lattice.columns(), lattice.rows());
        let seeds: Vec<[f64; 2]> = starts.iter().map(|cell| unknown.place(*cell).map(f64::from)).collect();
        let parts = parts(&unknown, &(0..unknown.count()).collect::<Vec<_>>(), &seeds);
        let member = |id: &u32| {
            let writer = Writer { robot: RobotId(*id), epoch: EPOCH };
            Member {
                map: SharedMap::new(*lattice, writer),
                exchange: Exchange::new(writer, 0, ids.len().saturating_sub(1)),
                presumed: unknown.clone(),
                finders: vec![0; unknown.count()],
                mates: starts.iter().map(|at| Mate { at: *at, target: None }).collect(),
                points: Vec::new(),
                heard_points: vec![0; starts.len()],
                heard: vec![0; starts.len()],
                meetings: Meetings::new(&unknown, starts, explore.reach_cells),
                parts: parts.clone(),
                part_done: false,
                obstacles: Vec::new(),
            }
        };
        Some(Self {
            kind: explore.exchange,
            every,
            reach: i32::from(explore.reach_cells),
            members: ids.iter().map(member).collect(),
            radio: Radio::new(&swarm.radio, &ids, swarm.seed),
            range_m: swarm.radio.range_m,
            lattice: *lattice,
            now: Stamp::ZERO,
            at_step: 0,
            step: Duration::from_secs_f64(explore.step_s),
            bytes: 0,
        })
    }

    /// What a robot knows of the ground.
    pub(super) fn board(&self, own: usize) -> &Board {
        match self.kind {
            MapExchange::Points => &self.members[own].presumed,
            MapExchange::Gossip | MapExchange::Ideal => self.members[own].map.board(),
        }
    }

    /// The same without the cells of bodies that do not move.
    pub(super) fn ways(&self, own: usize) -> Cow<'_, Board> {
        without(self.board(own), &self.members[own].obstacles)
    }

    /// The same with what is unknown in others' parts occupied: for who sees to its own first. None by observation
    /// points.
    pub(super) fn own_part(&self, own: usize) -> Option<Board> {
        if self.kind == MapExchange::Points || self.members[own].part_done {
            return None;
        }
        let mut board = self.ways(own).into_owned();
        for (cell, part) in self.members[own].parts.iter().enumerate() {
            if usize::from(*part) != own && board.at(cell) == Known::Unknown {
                board.set(cell, Known::Occupied);
            }
        }
        Some(board)
    }

    /// Nothing is left in its part, or not to be got to.
    pub(super) fn leave_part(&mut self, own: usize) {
        self.members[own].part_done = true;
    }

    pub(super) fn finders(&self, own: usize) -> &[u16] {
        &self.members[own].finders
    }

    /// Where it believes everybody to be; itself it knows. Who went somewhere and was not heard since is there.
    pub(super) fn mates(&self, own: usize, itself: Mate) -> Vec<Option<Mate>> {
        let Member { mates, heard, .. } = &self.members[own];
        let believed = |(rank, mate): (usize, &Mate)| match mate.target {
            _ if rank == own => itself,
            Some(target) if self.at_step > heard[rank] + GONE_STEPS => Mate { at: target, target: None },
            Some(_) | None => *mate,
        };
        mates.iter().enumerate().map(|pair| Some(believed(pair))).collect()
    }

    /// Where a robot goes for a meeting, and its first step; none if it goes on with its work. By observation points
    /// there are none: the paper has none.
    pub(super) fn called(&mut self, own: usize, at: usize, idle: bool) -> Option<(usize, Option<usize>)> {
        if self.kind == MapExchange::Points {
            return None;
        }
        let step = self.at_step;
        let Member { map, exchange, meetings, mates, parts, part_done, obstacles, .. } = &mut self.members[own];
        let board = &*without(map.board(), obstacles);
        let complete = exchange.heard(self.now).count() + 1 == mates.len() && exchange.is_level(self.now, map);
        let before = meetings.met();
        let place = meetings.call(&Gathering { step, at, board, complete, idle });
        if meetings.met() > before {
            // All who met have one map: each reckons the same parts.
            let left: Vec<usize> = board.frontier().collect();
            let seeds = sectors(board, &left, meetings.place(), mates.len());
            *parts = drover_core::explore::parts(board, &left, &seeds);
            *part_done = false;
            if complete {
                meetings.agree(step, longest_round(board, meetings.place(), (&left, parts, mates.len())));
            }
        }
        let place = place?;
        Some((place, meetings.first_step(board, place).filter(|next| *next != at)))
    }

    /// A robot has met a body that does not move.
    pub(super) fn meet(&mut self, own: usize, cell: usize) {
        self.members[own].obstacles.push(cell);
    }

    /// A robot looks from a cell.
    pub(super) fn look_from(&mut self, own: usize, cell: usize) {
        let points = &mut self.members[own].points;
        if self.kind == MapExchange::Points && points.last() != Some(&cell) {
            points.push(cell);
        }
    }

    /// A robot sees what a cell is.
    pub(super) fn see(&mut self, own: usize, cell: usize, occupied: bool) {
        let Member { map, presumed, finders, .. } = &mut self.members[own];
        let rank = own as u16;
        match self.kind {
            MapExchange::Points => {
                let was = presumed.at(cell);
                presumed.learn(cell, if occupied { Known::Occupied } else { Known::Free });
                if was == Known::Unknown {
                    finders[cell] = rank;
                }
            }
            MapExchange::Gossip | MapExchange::Ideal => {
                map.see(cell, occupied);
                map.take_news(|_, cell| finders[cell] = rank);
            }
        }
    }

    /// After a step: everybody that lives, where it is and where it goes, may speak.
    pub(super) fn talk(&mut self, step: u32, bodies: &[Option<Mate>]) {
        self.now = Stamp::ZERO + self.step * step;
        self.at_step = step;
        if !step.is_multiple_of(self.every) {
            return;
        }
        let places_w: Vec<Vec2> = bodies.iter().map(|body| self.place_w(*body)).collect();
        match self.kind {
            MapExchange::Points => self.tell_points(&places_w, bodies),
            MapExchange::Gossip | MapExchange::Ideal => {
                for turn in 0..REPORTS_MAX {
                    if !self.gossip(turn, &places_w, bodies) {
                        return;
                    }
                }
            }
        }
    }

    /// The dead are beyond everybody's range.
    fn place_w(&self, body: Option<Mate>) -> Vec2 {
        body.map_or(Vec2::repeat(1e9), |mate| self.lattice.centre_w(mate.at))
    }

    /// Everybody speaks once; whether anybody had a piece to tell.
    fn gossip(&mut self, turn: u64, places_w: &[Vec2], bodies: &[Option<Mate>]) -> bool {
        self.now = self.now + Duration::from_millis(100);
        let mut told = false;
        for (rank, mate) in bodies.iter().enumerate().filter_map(|(rank, body)| Some((rank, (*body)?))) {
            let Member { map, exchange, .. } = &mut self.members[rank];
            let goal = mate.target.and_then(|cell| u32::try_from(cell).ok());
            let report = exchange.report(self.now, map, goal, mate.target.is_none());
            // The first report is a beacon, too; later ones are for their pieces.
            if turn > 0 && report.chunk.is_none() {
                continue;
            }
            told |= report.chunk.is_some();
            let piece = report.chunk.as_ref().map_or(0, |chunk| PIECE_BYTES + chunk.changes.len() as u64);
            self.bytes += (REPORT_BYTES + piece) * self.hearers(rank, places_w);
            self.radio.broadcast(self.now, rank, places_w, Arc::new((mate.at, Said::Report(report))));
        }
        self.deliver();
        told || turn == 0
    }

    fn tell_points(&mut self, places_w: &[Vec2], bodies: &[Option<Mate>]) {
        for (rank, mate) in bodies.iter().enumerate().filter_map(|(rank, body)| Some((rank, (*body)?))) {
            let candidates = self.board(rank).frontier().count() as u64;
            let hearers = self.hearers(rank, places_w);
            // Who hears it knows how much it had; no more than what is new is paid for.
            let points = self.members[rank].points.clone();
            self.bytes += CANDIDATE_BYTES * candidates * hearers;
            self.radio.broadcast(self.now, rank, places_w, Arc::new((mate.at, Said::Points(points))));
        }
        self.deliver();
    }

    /// How many could hear a robot.
    fn hearers(&self, from: usize, places_w: &[Vec2]) -> u64 {
        let range_m = self.range_m;
        let near = |(to, place_w): (usize, &Vec2)| to != from && (place_w - places_w[from]).norm() <= range_m;
        places_w.iter().enumerate().filter(|pair| near(*pair)).count() as u64
    }

    fn deliver(&mut self) {
        let Self { radio, members, now, reach, bytes, at_step, .. } = self;
        let step = *at_step;
        radio.deliver(*now + LATE, |to, from, said| {
            let member = &mut members[to];
            let (at, said) = said.as_ref();
            member.mates[from].at = *at;
            member.heard[from] = step;
            match said {
                Said::Report(report) => member.hear(*now, from, report),
                Said::Points(points) => *bytes += POINT_BYTES * member.presume(from, points, *reach),
            }
        });
    }

    /// What all that was said came to, bytes, counted by receiver within range.
    pub(super) const fn bytes(&self) -> u64 {
        self.bytes
    }

    pub(super) fn radio(&self) -> RadioTally {
        self.radio.tally()
    }
}

/// A board without some cells.
fn without<'a>(board: &'a Board, obstacles: &[usize]) -> Cow<'a, Board> {
    let mut board = Cow::Borrowed(board);
    for cell in obstacles {
        board.to_mut().learn(*cell, Known::Occupied);
    }
    board
}

/// How long the robot with the longest round needs to see to its part of what is left and come back, steps.
fn longest_round(board: &Board, place: usize, (left, parts, count): (&[usize], &[u16], usize)) -> u32 {
    let mut field = Field::default();
    // What others found may be joined to the place by ways that nobody knows yet.
    field.spread(board, place, Unknowns::Free);
    let mut rounds = vec![0_u32; count];
    let mut farthest = vec![0_u32; count];
    for cell in left {
        let rank = usize::from(parts[*cell]);
        rounds[rank] += 1;
        farthest[rank] = farthest[rank].max(field.steps(*cell).unwrap_or(0));
    }
    rounds.iter().zip(&farthest).map(|(cells, far)| cells + 2 * far).max().unwrap_or(0)
}

impl Member {
    fn hear(&mut self, now: Stamp, from: usize, report: &MapReport) {
        let Self { map, exchange, finders, mates, .. } = self;
        exchange.hear(now, report, map);
        let goal = report.goal.map(|cell| cell as usize).filter(|cell| *cell < finders.len());
        mates[from].target = goal;
        map.take_news(|_, cell| finders[cell] = from as u16);
    }

    /// The squares around places that another looked from count as seen, and as free where nothing else is known. How
    /// many of the places are new.
    fn presume(&mut self, from: usize, points: &[usize], reach: i32) -> u64 {
        let fresh = &points[self.heard_points[from].min(points.len())..];
        for point in fresh {
            let square: Vec<usize> = self.presumed.square(*point, reach).collect();
            for cell in square {
                if self.presumed.at(cell) == Known::Unknown {
                    self.presumed.learn(cell, Known::Free);
                    self.finders[cell] = from as u16;
                }
            }
        }
        self.heard_points[from] = points.len();
        fresh.len() as u64
    }
}
