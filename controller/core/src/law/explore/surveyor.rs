//! Exploration by a real robot: a body of some size with a lidar, among others, over a radio that loses things.
//!
//! **In**: own pose (world) and twist (body); the scan, with the sensor's place on the body; where peers' bodies are;
//! their beacons and map reports. **Out**: a twist (body frame, m/s and rad/s), and a map report beside every beacon.
//!
//! **Map**: beams go into the evidence ([`SharedMap`]), each as far as it is no wider than two cells; hits on peers'
//! bodies are no walls (invariant 6). Around what is occupied the body has no room ([`Space`]).
//!
//! **Where to**: the same methods as for points on cells ([`super::Explorer`]), on the space of the body, seen
//! through the map without it; every `decide_s`, on arrival, or when the way is closed. **How**: A* on the space
//! ([`super::way`]), again whenever the map has closed the way; then straight for the farthest point of the way that
//! can be seen through the space, and the supervisor's guard has the last word.
//!
//! **Together**: words about the map and everybody's goal (a lease) go round by gossip ([`Exchange`]). Who is silent or
//! stopped has no part any more: what it was going for is open to all, and its body is an obstacle for as long as it is
//! there. One that stands is gone around; if there is no other way and nothing else to do, the one with the higher id
//! makes room.
//!
//! **End**: a certificate. Nothing that the body can reach over free cells borders on anything it could enter and
//! does not know, in the map of all that it hears, of whom nobody has anything it has not. News that opens something
//! ends it.
//!
//! **Cost**: a decision every `decide_s`, see the method; a scan's beams; between them, the points of the way.
//!
//! **Cannot solve**: without a free cell within [`HOME_M`] it stands still, and says so.

use super::mates::{Fellow, Fellows};
use super::way;
use super::{Explorer, Mate, View as Choice};
use crate::law::{Outcome, View, drive};
use crate::map::{Board, Exchange, Field, Known, Lattice, Ray, SharedMap, Sight, Space};
use crate::peers::Body;
use crate::sight::match_radius_m;
use drover_config::{Explore, Kind};
use drover_contract::math::atan2;
use drover_contract::{Beam, MapReport, Pose, RobotId, Scan, Stamp, Twist, Vec2, Writer, wrap};
use nalgebra::{Isometry2, Point2};
use std::time::Duration;

/// A map remembers: what may be a peer's is taken this much wider for it than for what a law sees now, metres.
const BODY_SLACK_M: f64 = 0.05;
/// Of the way to a peer's body the last bit is not taken for free, metres.
const BODY_FRINGE_M: f64 = 0.4;
/// It likes to keep this much more from walls than it has to, metres.
const CALM_M: f64 = 0.15;
/// A body that is closer to walls than it should plans from the nearest free cell within this, metres.
const HOME_M: f64 = 1.0;
/// It heads for a point of its way no farther ahead than this, metres.
const AHEAD_M: f64 = 1.5;
/// ... and near walls no farther than this.
const CLOSE_M: f64 = 0.45;
/// It is there when it is this close to a point, in cells.
const THERE_CELLS: f64 = 0.75;
/// Beside two bodies and the supervisor's gap, those who pass one that stands keep this, metres.
const PASS_M: f64 = 0.1;
/// Who makes room goes as far as this from the other, metres, and stays for so long.
const ROOM_M: f64 = 4.0;
const ROOM: Duration = Duration::from_secs(6);
/// Too little room to be a way, metres in this time, is none: what it went for is left alone for a while.
const STUCK: Duration = Duration::from_secs(12);
const STUCK_M: f64 = 0.3;
const SHUN: Duration = Duration::from_secs(20);
/// Whoever has arrived, or whose way is closed, decides no sooner after the last decision.
const AGAIN: Duration = Duration::from_millis(300);
/// Reports beside one beacon at most: some 8 kB/s a robot at 10 Hz.
const REPORTS_MAX: usize = 4;
/// Around what is left alone, cells.
const SHUN_CELLS: i32 = 2;

/// One robot that explores.
#[derive(Clone, Debug)]
pub(crate) struct Surveyor {
    speed_mps: f64,
    decide: Duration,
    decide_due: Stamp,
    /// Not before this, even if it has arrived or its way is closed: a decision is dear.
    decide_again: Stamp,
    /// From a centre to the body of another robot's centre, less that one's radius, metres.
    pass_m: f64,
    own: RobotId,
    /// Everybody's id, in the order of ranks.
    ids: Vec<RobotId>,
    rank: usize,
    map: SharedMap,
    space: Space,
    finders: Vec<u16>,
    exchange: Exchange,
    explorer: Explorer,
    sight: Sight,
    fellows: Fellows,
    scanned: Option<Stamp>,
    decisions: u32,
    goal: Option<usize>,
    /// Where it would go if nobody stood in its way: told to the others, who may make room.
    waits_for: Option<usize>,
    /// Cells that are still to be gone through, the next one last.
    way: Vec<usize>,
    makes_room_until: Option<Stamp>,
    /// Where and when it last got on.
    moved: (Vec2, Stamp),
    shunned: Vec<(usize, Stamp)>,
    done: bool,
}

impl Surveyor {
    /// Robot `own`, in its present life, of a swarm with these ids.
    pub(crate) fn new(explore: &Explore, kind: &Kind, own: Writer, ids: impl Iterator<Item = RobotId>) -> Self {
        let [low, high] = explore.area_m.unwrap_or_default().map(|[x, y]| Vec2::new(x, y));
        // The faces of walls at the rim lie on it: half of their returns fall outside.
        let rim = Vec2::repeat(explore.cell_m);
        let lattice = Lattice::over(low - rim, high + rim, explore.cell_m);
        let mut ids: Vec<RobotId> = ids.filter(|id| *id != own.robot).chain([own.robot]).collect();
        ids.sort_unstable();
        // The wall of an occupied cell may be half a cell nearer than its middle.
        let keep_m = kind.body.radius_m + kind.motion.margin_m + explore.cell_m / 2.0;
        Self {
            speed_mps: explore.speed_mps.min(kind.motion.speed_mps_max),
            decide: Duration::from_secs_f64(explore.decide_s),
            decide_due: Stamp::ZERO,
            decide_again: Stamp::ZERO,
            pass_m: keep_m + PASS_M,
            own: own.robot,
            rank: ids.iter().position(|id| *id == own.robot).unwrap_or(0),
            exchange: Exchange::new(own, hash_of(&lattice), ids.len().saturating_sub(1)),
            ids,
            map: SharedMap::new(lattice, own),
            space: Space::new(&lattice, keep_m, keep_m + CALM_M),
            finders: vec![0; lattice.columns() * lattice.rows()],
            explorer: Explorer::new(explore),
            sight: Sight::new(explore.reach_cells),
            fellows: Fellows::default(),
            scanned: None,
            decisions: 0,
            goal: None,
            waits_for: None,
            way: Vec::new(),
            makes_room_until: None,
            moved: (Vec2::zeros(), Stamp::ZERO),
            shunned: Vec::new(),
            done: false,
        }
    }

    /// How far a scan can matter to it, metres.
    pub(crate) fn range_m(kind: &Kind) -> f64 {
        kind.lidar.range_m_max
    }

    /// The map, as this robot has it.
    pub(crate) fn map(&self) -> &SharedMap {
        &self.map
    }

    /// Take in what a peer tells of the map.
    pub(crate) fn handle_report(&mut self, now: Stamp, report: &MapReport) {
        self.exchange.hear(now, report, &mut self.map);
    }

    /// What to tell of it, the first last: one report, and more while somebody lacks something.
    pub(crate) fn reports(&mut self, now: Stamp) -> Vec<MapReport> {
        let goal = self.goal.or(self.waits_for).filter(|_| !self.done).and_then(|cell| u32::try_from(cell).ok());
        let mut reports = vec![self.exchange.report(now, &self.map, goal, self.done)];
        while reports.len() < REPORTS_MAX && reports.last().is_some_and(|report| report.chunk.is_some()) {
            reports.push(self.exchange.report(now, &self.map, goal, self.done));
        }
        reports.reverse();
        reports
    }

    /// Whether it has its certificate.
    pub(crate) fn reached(&self) -> bool {
        self.done
    }

    /// Where it goes.
    pub(crate) fn target_w(&self) -> Option<Vec2> {
        self.goal.filter(|_| !self.done).map(|cell| self.map.lattice().centre_w(cell))
    }

    /// Share of the cells of the area that are known: a lower bound of what is done, since nobody knows how many there
    /// are to be known.
    pub(crate) fn progress(&self) -> f64 {
        self.map.board().known_count() as f64 / self.map.board().count() as f64
    }

    /// One tick.
    pub(crate) fn step(&mut self, view: &View<'_>) -> Outcome {
        self.fellows.see(view.now, view.neighbours);
        self.integrate(view);
        let at_w = view.motion.pose_wb.position();
        let Some(home) = self.home(at_w) else { return Outcome::Stale("no free cell to plan from") };
        self.watch_for_being_stuck(view.now, at_w);
        self.follow(at_w);
        let lost = self.is_closed() || (self.way.is_empty() && !self.done);
        if view.now >= self.decide_due || (lost && view.now >= self.decide_again) {
            self.decide_due = view.now + self.decide;
            self.decide_again = view.now + self.decide.min(AGAIN);
            self.decide(view.now, at_w, home);
            self.follow(at_w);
        }
        Outcome::Solved(self.drive(view, at_w))
    }

    /// A scan that has not been seen yet goes into the map.
    fn integrate(&mut self, view: &View<'_>) {
        let Some((scan, sensor_b)) = view.scan.filter(|(scan, _)| self.scanned != Some(scan.stamp)) else { return };
        self.scanned = Some(scan.stamp);
        let sensor_w = view.motion.pose_wb.isometry() * sensor_b;
        let own_bound_m = view.motion.pos_bound_m;
        let believed_m = believed_m(scan, self.map.lattice().cell_m());
        let rays = (0..scan.beams.len()).filter_map(|index| {
            ray(scan, index, (&sensor_w, believed_m), |end_w| is_body(end_w, view.bodies, own_bound_m))
        });
        self.map.observe(sensor_w.translation.vector, rays);
        self.learn();
        let eye_w = sensor_w.translation.vector;
        self.fellows.look_for(view.now, eye_w, |place_w| seen_m(scan, &sensor_w, place_w));
    }

    /// The body's space follows the map.
    fn learn(&mut self) {
        let Self { map, space, finders, ids, .. } = self;
        let mut found = Vec::new();
        map.take_news(|board, cell| {
            space.learn(board, cell);
            found.push(cell);
        });
        for cell in found {
            let finder = RobotId(map.finder(cell));
            finders[cell] = ids.binary_search(&finder).unwrap_or(0) as u16;
        }
    }

    /// The free cell of the space nearest to the body.
    fn home(&self, at_w: Vec2) -> Option<usize> {
        let lattice = self.map.lattice();
        let board = self.space.board();
        let at = lattice.cell_near(at_w);
        if board.at(at) != Known::Occupied {
            return Some(at);
        }
        let around = board.square(at, (HOME_M / lattice.cell_m()) as i32);
        let free = around.filter(|cell| board.at(*cell) == Known::Free);
        let far = |cell: &usize| (lattice.centre_w(*cell) - at_w).norm_squared();
        free.filter(|cell| far(cell) <= HOME_M * HOME_M).min_by(|a, b| far(a).total_cmp(&far(b)))
    }

    /// What went on for long without getting anywhere is left alone for a while.
    fn watch_for_being_stuck(&mut self, now: Stamp, at_w: Vec2) {
        let (from_w, since) = self.moved;
        let waits = self.done || self.goal.is_none() || self.makes_room_until.is_some();
        if waits || (at_w - from_w).norm() >= STUCK_M {
            self.moved = (at_w, now);
        } else if now.since(since) > STUCK {
            self.moved = (at_w, now);
            // The next cell of the way is the one that cannot be entered, else the goal itself.
            let cell = self.way.last().copied().or(self.goal);
            self.shunned.extend(cell.map(|cell| (cell, now + SHUN)));
            self.way.clear();
            self.decide_due = now;
        }
        self.shunned.retain(|(_, until)| now < *until);
    }

    /// Points of the way that are passed are no part of it any more.
    fn follow(&mut self, at_w: Vec2) {
        let lattice = self.map.lattice();
        let there_m = THERE_CELLS * lattice.cell_m();
        let near = |cell: &usize| (lattice.centre_w(*cell) - at_w).norm() <= there_m;
        // The way may be cut short, too: whatever lies before a point that is passed is done with.
        if let Some(first) = self.way.iter().position(near) {
            self.way.truncate(first);
        }
    }

    /// Whether the map has closed the way since it was planned.
    fn is_closed(&self) -> bool {
        self.way.iter().any(|cell| self.space.board().at(*cell) == Known::Occupied)
    }

    fn decide(&mut self, now: Stamp, at_w: Vec2, home: usize) {
        self.decisions += 1;
        if self.makes_room_until.is_some_and(|until| now < until) {
            return;
        }
        self.makes_room_until = None;
        let around = self.closed_by(at_w, |fellow| fellow.stands(now, at_w));
        let kept = self.goal.filter(|goal| self.is_worth_going_to(&around, home, *goal));
        if let Some(goal) = kept.or_else(|| self.choose(now, home, &around)) {
            self.done = false;
            return self.go(&around, home, goal);
        }
        self.explorer.forget();
        let open = self.closed_by(at_w, |fellow| fellow.lies(now, at_w));
        let blocked = self.choose(now, home, &open);
        self.waits_for = blocked;
        self.goal = None;
        self.way.clear();
        self.done = blocked.is_none() && self.shunned.is_empty() && self.exchange.is_level(now, &self.map);
        let aside = self.room_for_others(now, home, &around);
        if let Some(place) = aside {
            self.makes_room_until = Some(now + ROOM);
            self.go(&around, home, place);
        } else if !self.done && self.space.is_near(home) {
            // Whoever waits, waits where there is room, and not in a door.
            let roomy = self.nearest(&around, home, |cell| !self.space.is_near(cell));
            roomy.into_iter().for_each(|place| self.go(&around, home, place));
        }
    }

    /// Whether a goal is still ahead, with something unknown to be seen from it and nobody on it. A body turns
    /// slowly: one that changed its mind for a little more gain would turn to and fro between what is left.
    fn is_worth_going_to(&self, board: &Board, home: usize, goal: usize) -> bool {
        if self.way.is_empty() || goal == home || board.at(goal) == Known::Occupied {
            return false;
        }
        let walls = self.map.board();
        let mut unknown = board.at(goal) == Known::Unknown;
        self.sight.look(
            board,
            goal,
            |cell| walls.at(cell) == Known::Occupied,
            |cell| {
                unknown |= board.at(cell) == Known::Unknown;
            },
        );
        unknown
    }

    /// The cell to go to on a board.
    fn choose(&mut self, now: Stamp, home: usize, board: &Board) -> Option<usize> {
        let mates = self.mates(now, home);
        let view = Choice {
            board,
            walls: self.map.board(),
            finders: &self.finders,
            mates: &mates,
            own: self.rank,
            sight: &self.sight,
            step: self.decisions,
        };
        self.explorer.step(&view).target
    }

    /// Everybody that takes part, by rank.
    fn mates(&self, now: Stamp, home: usize) -> Vec<Option<Mate>> {
        let lattice = self.map.lattice();
        let cells = self.map.board().count();
        let mate = |id: &RobotId| {
            if *id == self.own {
                return Some(Mate { at: home, target: self.goal });
            }
            let fellow = self.fellows.of(*id).filter(|fellow| fellow.takes_part(now))?;
            let target = self.exchange.goal_of(*id, now).map(|cell| cell as usize).filter(|cell| *cell < cells);
            Some(Mate { at: lattice.cell_near(fellow.pos_w), target })
        };
        self.ids.iter().map(mate).collect()
    }

    /// The space without what is left alone, and without the places of some robots: as far as the body itself is, which
    /// may be closer to one of them than it should, and then can go away from it.
    fn closed_by(&self, at_w: Vec2, counts: impl Fn(&Fellow) -> bool) -> Board {
        let mut board = self.space.board().clone();
        let lattice = self.map.lattice();
        for (_, fellow) in self.fellows.all().filter(|(_, fellow)| counts(fellow)) {
            let own_m = (fellow.pos_w - at_w).norm() - lattice.cell_m();
            let within_m = (self.pass_m + fellow.radius_m).min(own_m);
            close_disc(&mut board, lattice, fellow.pos_w, within_m);
        }
        for (cell, _) in &self.shunned {
            close_disc(&mut board, lattice, lattice.centre_w(*cell), f64::from(SHUN_CELLS) * lattice.cell_m());
        }
        board
    }

    fn go(&mut self, board: &Board, home: usize, goal: usize) {
        // The same goal over the same way: keep it, or the robot would hesitate between ways that are as good.
        let same = self.goal.replace(goal) == Some(goal) && !self.way.is_empty();
        if same && self.way.iter().all(|cell| board.at(*cell) != Known::Occupied) {
            return;
        }
        let way = way::plan(&self.space, board, self.explorer.unknowns(), (home, goal)).unwrap_or_default();
        self.way = way.into_iter().rev().collect();
    }

    /// The nearest free cell of a kind that can be gone to.
    fn nearest(&self, board: &Board, home: usize, wanted: impl Fn(usize) -> bool) -> Option<usize> {
        let mut field = Field::default();
        field.spread(board, home, self.explorer.unknowns());
        field.reached().iter().copied().find(|cell| board.at(*cell) == Known::Free && wanted(*cell))
    }

    /// It has nothing to do here: where to go aside for somebody who stands close by and may have to pass. Of two
    /// that wait for each other, the one with the lower id stays; whoever is done makes room for whoever is not.
    fn room_for_others(&self, now: Stamp, home: usize, around: &Board) -> Option<usize> {
        let lattice = self.map.lattice();
        let at_w = lattice.centre_w(home);
        let gap_m = |fellow: &Fellow| (fellow.pos_w - at_w).norm();
        let waits = |(id, fellow): &(RobotId, &Fellow)| {
            let wants = !self.exchange.is_done(*id) && self.exchange.goal_of(*id, now).is_some();
            let yields = if self.done { wants } else { *id < self.own };
            yields && fellow.takes_part(now) && fellow.stands(now, at_w) && gap_m(fellow) < ROOM_M
        };
        let (_, fellow) = self.fellows.all().filter(waits).min_by(|(_, a), (_, b)| gap_m(a).total_cmp(&gap_m(b)))?;
        let other_w = fellow.pos_w;
        let mut field = Field::default();
        field.spread(around, home, self.explorer.unknowns());
        let far_m = |cell: &&usize| (lattice.centre_w(**cell) - other_w).norm().min(ROOM_M);
        let free = field.reached().iter().filter(|cell| around.at(**cell) == Known::Free);
        // The farthest, and of those that are far enough the first, which is the nearest to go to.
        free.rev().max_by(|a, b| far_m(a).total_cmp(&far_m(b))).copied()
    }

    /// Along the way.
    fn drive(&self, view: &View<'_>, at_w: Vec2) -> Twist {
        let lattice = self.map.lattice();
        let Some(next) = self.way.last().copied() else { return Twist::ZERO };
        let in_sight = |cell: &usize| {
            let point_w = lattice.centre_w(*cell);
            (point_w - at_w).norm() <= AHEAD_M && self.is_open_between(at_w, point_w)
        };
        // Else not the very next cell, which is too close to steer by.
        let close = |cell: &&usize| (lattice.centre_w(**cell) - at_w).norm() <= CLOSE_M;
        let ahead = self.way.iter().rev().copied().take_while(|cell| close(&cell)).last().unwrap_or(next);
        let aim = self.way.iter().copied().find(in_sight).unwrap_or(ahead);
        let way_w = lattice.centre_w(aim) - at_w;
        let left_m = way_w.norm();
        if left_m < 1e-3 {
            return Twist::ZERO;
        }
        // As fast as it can still stop at the end.
        let stop_mps = (2.0 * view.limits.brake_mps2 * left_m).sqrt();
        drive::along(view, way_w, self.speed_mps.min(stop_mps))
    }

    /// Whether the straight way to a point keeps away from walls; the cell that the body is in does not count. Near
    /// walls it follows its way cell by cell, which leads through the middle of a door, where a straight one would
    /// cut the corner.
    fn is_open_between(&self, from_w: Vec2, to_w: Vec2) -> bool {
        let lattice = self.map.lattice();
        let own = lattice.cell_near(from_w);
        let mut open = true;
        lattice.along(from_w, to_w, |cell| open &= cell == own || !self.space.is_near(cell));
        open
    }
}

/// Cells whose middles are within a disc count as occupied.
fn close_disc(board: &mut Board, lattice: &Lattice, centre_w: Vec2, within_m: f64) {
    let reach = (within_m / lattice.cell_m()).ceil() as i32;
    let square = board.square(lattice.cell_near(centre_w), reach);
    let within: Vec<usize> = square.filter(|cell| (lattice.centre_w(*cell) - centre_w).norm() <= within_m).collect();
    within.into_iter().for_each(|cell| {
        board.learn(cell, Known::Occupied);
    });
}

/// A beam says where a return is only as finely as it is wide: it is believed as far as that is two cells, metres.
fn believed_m(scan: &Scan, cell_m: f64) -> f64 {
    (2.0 * cell_m / scan.angle_step_rad.abs().max(1e-3)).min(scan.range_m_max)
}

/// A beam as the map takes it; `is_body` says whether something is a peer. None for a beam without a reading.
fn ray(
    scan: &Scan,
    index: usize,
    (sensor_w, believed_m): (&Isometry2<f64>, f64),
    is_body: impl Fn(Vec2) -> bool,
) -> Option<Ray> {
    let (range_m, hit) = match scan.beams[index] {
        Beam::Hit(range_m) => (range_m, true),
        Beam::Clear => (scan.range_m_max, false),
        Beam::Unknown => return None,
    };
    let ahead = Pose::new(0.0, 0.0, scan.angle_rad(index)).heading();
    let at = |range_m: f64| (sensor_w * Point2::from(ahead * range_m)).coords;
    if range_m > believed_m {
        return Some(Ray { end_w: at(believed_m), hit: false });
    }
    let end_w = at(range_m);
    if hit && is_body(end_w) {
        // Up to the body nothing stands; of the cell before it nothing is known.
        return Some(Ray { end_w: at((range_m - BODY_FRINGE_M).max(0.0)), hit: false });
    }
    Some(Ray { end_w, hit })
}

/// How far the beam that points to a place goes, metres; none if it has no reading.
fn seen_m(scan: &Scan, sensor_w: &Isometry2<f64>, place_w: Vec2) -> Option<f64> {
    let place = sensor_w.inverse_transform_point(&Point2::from(place_w));
    let off_rad = wrap(atan2(place.y, place.x) - scan.angle_first_rad) / scan.angle_step_rad;
    let turn = (std::f64::consts::TAU / scan.angle_step_rad.abs()).round();
    let index = off_rad.round().rem_euclid(turn.max(1.0)) as usize;
    match scan.beams.get(index)? {
        Beam::Hit(range_m) => Some(*range_m),
        Beam::Clear => Some(scan.range_m_max),
        Beam::Unknown => None,
    }
}

/// Whether a return may be on one of the bodies.
fn is_body(end_w: Vec2, bodies: &[Body], own_bound_m: f64) -> bool {
    let within = |body: &Body| (end_w - body.pos_w).norm() <= match_radius_m(body, own_bound_m) + BODY_SLACK_M;
    bodies.iter().any(within)
}

/// FNV-1a of where cells lie, in millimetres.
fn hash_of(lattice: &Lattice) -> u32 {
    let mm = |length_m: f64| ((length_m * 1e3).round() as i64).to_le_bytes();
    let low_w = lattice.low_w();
    let size = [lattice.columns() as i64, lattice.rows() as i64].map(i64::to_le_bytes);
    let words = [mm(low_w.x), mm(low_w.y), mm(lattice.cell_m()), size[0], size[1]];
    let bytes = words.iter().flatten();
    bytes.fold(0x811C_9DC5, |hash, byte| (hash ^ u32::from(*byte)).wrapping_mul(0x0100_0193))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn scan(beams: Vec<Beam>) -> Scan {
        let angle_step_rad = std::f64::consts::TAU / beams.len() as f64;
        Scan { stamp: Stamp::ZERO, angle_first_rad: 0.0, angle_step_rad, range_m_min: 0.1, range_m_max: 12.0, beams }
    }

    #[test]
    fn a_beam_is_believed_as_far_as_it_is_no_wider_than_two_cells() {
        let scan = scan(vec![Beam::Hit(3.0); 72]);
        let believed_m = believed_m(&scan, 0.2);
        assert!((4.5..4.7).contains(&believed_m), "{believed_m}");
        let sensor_w = Pose::new(1.0, 2.0, std::f64::consts::FRAC_PI_2).isometry();
        let near = ray(&scan, 0, (&sensor_w, believed_m), |_| false).expect("a reading");
        assert!(near.hit && (near.end_w - Vec2::new(1.0, 5.0)).norm() < 1e-9, "{near:?}");
        let far = Scan { beams: vec![Beam::Hit(9.0); 72], ..scan.clone() };
        let far = ray(&far, 0, (&sensor_w, believed_m), |_| false).expect("a reading");
        assert!(!far.hit && (far.end_w.y - 2.0 - believed_m).abs() < 1e-9, "{far:?}");
        let silent = Scan { beams: vec![Beam::Unknown; 72], ..scan };
        assert_eq!(ray(&silent, 0, (&sensor_w, believed_m), |_| false), None, "no reading is not free");
    }

    #[test]
    fn a_peers_body_is_no_wall_and_the_way_to_it_is_free() {
        let scan = scan(vec![Beam::Hit(2.0); 72]);
        let sensor_w = Pose::default().isometry();
        let peer = Body { pos_w: Vec2::new(2.3, 0.0), radius_m: 0.3, bound_m: 0.05, heard: true, stands: false };
        let of = |index| ray(&scan, index, (&sensor_w, 4.0), |end_w| is_body(end_w, &[peer], 0.0)).expect("a reading");
        assert!(!of(0).hit && (of(0).end_w.x - 1.6).abs() < 1e-9, "{:?}", of(0));
        assert!(of(18).hit, "the wall to the left");
    }

    #[test]
    fn one_sees_as_far_as_the_beam_that_points_there() {
        let mut beams = vec![Beam::Clear; 72];
        (beams[18], beams[36]) = (Beam::Hit(1.5), Beam::Unknown);
        let scan = scan(beams);
        let sensor_w = Pose::default().isometry();
        let seen = |x: f64, y: f64| seen_m(&scan, &sensor_w, Vec2::new(x, y));
        assert_eq!(seen(0.05, 3.0), Some(1.5));
        assert_eq!((seen(3.0, -0.05), seen(-3.0, 0.0)), (Some(12.0), None));
    }

    #[test]
    fn other_cells_have_another_hash() {
        let of = |cell_m: f64| hash_of(&Lattice::over(Vec2::zeros(), Vec2::new(8.0, 4.0), cell_m));
        assert_eq!(of(0.2), of(0.2));
        assert_ne!(of(0.2), of(0.25));
    }
}
