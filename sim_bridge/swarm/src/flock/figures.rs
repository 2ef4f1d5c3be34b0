//! What a flock is measured by, from outside: where the bodies truly are, step by step.

use crate::measures::Said;
use crate::points::capsules;
use drover_config::{Flock, Party, Swarm};
use drover_contract::Vec2;
use drover_core::deploy::Geodesic;
use drover_core::flock::longest_link_m;
use drover_world::Arena;
use serde::Serialize;
use std::collections::VecDeque;

/// The end of a run, over which the order is averaged, as long as the leader drives, s.
const ORDER_S: f64 = 5.0;
/// It is looked at this often, s.
const ORDER_EVERY_S: f64 = 0.1;
/// A leader drives, and a robot moves, if it is faster than this share of the leader's speed.
const DRIVES: f64 = 0.2;
const MOVES: f64 = 0.02;
/// A cell of the map for shortest ways is as large as the smallest body's radius, but no smaller, metres.
const CELL_M_MIN: f64 = 0.01;

/// One run of a flock.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct FlockFigures {
    /// Whether nobody was lost and nobody died.
    pub success: bool,
    /// Followers whose bodies ended farther than `arrive_radius_m` from their leader's.
    pub lost: u64,
    /// Velocity polarisation, the length of the mean of all directions of motion, 0..=1, of the least ordered party;
    /// over the last five seconds in which its leader drove. Who stands counts as having no direction.
    pub order: f64,
    /// Mean distance from the middle of the party at the end, of the most scattered party, metres.
    pub cohesion_m: f64,
    /// When everybody was within `arrive_radius_m` of the leader for good, s; none if somebody was lost.
    pub gathered_s: Option<f64>,
    /// What a robot drove over the shortest way, around walls, from where it began to where its leader ended; the mean
    /// of all robots. None where no way is known.
    pub path_ratio: Option<f64>,
    /// The longest time that a robot stayed within its radius of a place while its leader was not at its end, and did
    /// not say that it gives way to others, s.
    pub stuck_s: f64,
    /// The longest time that a leader said to be giving way, s.
    pub gave_way_s: f64,
    /// The longest link that any party needed at any moment to be one network, metres: of its tree of shortest links.
    /// None where the file asks for no links.
    pub link_m: Option<f64>,
    /// How often robots began to follow a wall.
    pub wall_entries: u64,
}

/// Watches one run.
#[derive(Clone, Debug)]
pub(crate) struct Flocking {
    parties: Vec<Members>,
    leader_speed_mps: f64,
    radius_m: f64,
    order_due_s: f64,
    spots: Vec<Spot>,
    gathered_s: f64,
    stuck_s: f64,
    gave_way_s: f64,
    link_m: Option<f64>,
}

/// A party, by the robots' places in the file.
#[derive(Clone, Debug)]
struct Members {
    leader: usize,
    robots: Vec<usize>,
    /// When, and how ordered.
    orders: VecDeque<(f64, f64)>,
}

/// Where a robot has been, and since when.
#[derive(Clone, Copy, Debug)]
struct Spot {
    start_w: Vec2,
    at_w: Vec2,
    since_s: f64,
    radius_m: f64,
    gives_way_since_s: Option<f64>,
}

impl Flocking {
    /// Before the first step of `swarm`.
    pub(crate) fn new(swarm: &Swarm, flock: &Flock) -> Self {
        let members = |party: &Party| Members {
            leader: swarm.robots.iter().position(|robot| robot.id == party.leader).unwrap_or(0),
            robots: (0..swarm.robots.len()).filter(|robot| party.has(swarm.robots[*robot].id)).collect(),
            orders: VecDeque::new(),
        };
        let spot = |robot: &drover_config::Robot| {
            let at_w = Vec2::new(robot.start.x_m, robot.start.y_m);
            let radius_m = swarm.kind_of(robot).body.radius_m;
            Spot { start_w: at_w, at_w, since_s: 0.0, radius_m, gives_way_since_s: None }
        };
        Self {
            parties: flock.parties.iter().map(members).collect(),
            leader_speed_mps: flock.leader_speed_mps,
            radius_m: flock.arrive_radius_m,
            order_due_s: 0.0,
            spots: swarm.robots.iter().map(spot).collect(),
            link_m: (flock.link_range_m > 0.0).then_some(0.0),
            gathered_s: 0.0,
            stuck_s: 0.0,
            gave_way_s: 0.0,
        }
    }

    /// The bodies at `now_s`; `said` is what robots say of themselves, `None` for the dead.
    pub(crate) fn see(&mut self, arena: &Arena, said: impl Fn(usize) -> Option<Said>, now_s: f64) {
        for party in 0..self.parties.len() {
            let rests = |said: Said| said.reached || said.gives_way;
            let ended = said(self.parties[party].leader).is_none_or(rests);
            for at in 0..self.parties[party].robots.len() {
                let robot = self.parties[party].robots[at];
                self.see_robot(robot, arena, said(robot), (now_s, ended));
            }
            if self.strays(&self.parties[party], arena).next().is_some() {
                self.gathered_s = now_s;
            }
        }
        let lives = |robot: &usize| said(*robot).is_some();
        if let Some(link_m) = &mut self.link_m {
            *link_m = self.parties.iter().map(|party| party.link_m(arena, lives)).fold(*link_m, f64::max);
        }
        if now_s >= self.order_due_s {
            self.order_due_s = now_s + ORDER_EVERY_S;
            let leader_speed_mps = self.leader_speed_mps;
            self.parties.iter_mut().for_each(|party| party.see_order(arena, lives, (now_s, leader_speed_mps)));
        }
    }

    fn see_robot(&mut self, robot: usize, arena: &Arena, said: Option<Said>, (now_s, ended): (f64, bool)) {
        let at_w = arena.state(robot).pose_wb.position();
        let spot = &mut self.spots[robot];
        let Some(said) = said else { return };
        if ended || said.reached || (at_w - spot.at_w).norm() > spot.radius_m {
            (spot.at_w, spot.since_s) = (at_w, now_s);
        }
        self.stuck_s = self.stuck_s.max(now_s - spot.since_s);
        let since_s = said.gives_way.then(|| spot.gives_way_since_s.unwrap_or(now_s));
        spot.gives_way_since_s = since_s;
        self.gave_way_s = self.gave_way_s.max(since_s.map_or(0.0, |since_s| now_s - since_s));
    }

    fn strays<'a>(&'a self, party: &'a Members, arena: &'a Arena) -> impl Iterator<Item = usize> + 'a {
        let leader_w = arena.state(party.leader).pose_wb.position();
        let far = move |robot: &usize| (arena.state(*robot).pose_wb.position() - leader_w).norm() > self.radius_m;
        party.robots.iter().copied().filter(far)
    }

    /// What came out; `said` is what robots said last, `None` for the dead.
    pub(crate) fn figures(&self, arena: &Arena, said: impl Fn(usize) -> Option<Said>) -> FlockFigures {
        let living: Vec<Said> = (0..self.spots.len()).filter_map(said).collect();
        let lost: usize = self.parties.iter().map(|party| self.strays(party, arena).count()).sum();
        let worst = |of: &dyn Fn(&Members) -> f64| self.parties.iter().map(of).fold(0.0, f64::max);
        FlockFigures {
            success: lost == 0 && living.len() == self.spots.len(),
            lost: lost as u64,
            order: self.parties.iter().map(Members::order).fold(1.0, f64::min),
            cohesion_m: worst(&|party| party.cohesion_m(arena)),
            gathered_s: (lost == 0).then_some(self.gathered_s),
            path_ratio: self.path_ratio(arena),
            stuck_s: self.stuck_s,
            gave_way_s: self.gave_way_s,
            link_m: self.link_m,
            wall_entries: living.iter().map(|said| said.wall_entries).sum(),
        }
    }

    fn path_ratio(&self, arena: &Arena) -> Option<f64> {
        let walls = capsules(arena.walls());
        let ends_w = (0..self.spots.len()).map(|robot| arena.state(robot).pose_wb.position());
        let places_w: Vec<Vec2> = self.spots.iter().map(|spot| spot.start_w).chain(ends_w).collect();
        let low_w = places_w.iter().fold(places_w[0], |low, place| low.inf(place));
        let high_w = places_w.iter().fold(places_w[0], |high, place| high.sup(place));
        let radius_m = self.spots.iter().map(|spot| spot.radius_m).fold(f64::INFINITY, f64::min);
        let map = Geodesic::new(&walls, (low_w, high_w), radius_m, radius_m.max(CELL_M_MIN));
        let mut ratios = Vec::new();
        for party in &self.parties {
            let field = map.field(arena.state(party.leader).pose_wb.position());
            for robot in &party.robots {
                let shortest_m = field.length_m(&map, self.spots[*robot].start_w)?;
                ratios.push(arena.path_m(*robot) / shortest_m.max(radius_m));
            }
        }
        Some(ratios.iter().sum::<f64>() / ratios.len().max(1) as f64)
    }
}

impl Members {
    fn see_order(&mut self, arena: &Arena, lives: impl Fn(&usize) -> bool, (now_s, leader_speed_mps): (f64, f64)) {
        if arena.state(self.leader).twist_b.speed_mps.abs() < DRIVES * leader_speed_mps {
            return;
        }
        let direction = |robot: &usize| {
            let state = arena.state(*robot);
            let speed_mps = state.twist_b.speed_mps;
            let moves = speed_mps.abs() > MOVES * leader_speed_mps;
            if moves { state.pose_wb.heading() * speed_mps.signum() } else { Vec2::zeros() }
        };
        let living = self.robots.iter().filter(|robot| lives(robot));
        let (sum, count) =
            living.fold((Vec2::zeros(), 0.0), |(sum, count), robot| (sum + direction(robot), count + 1.0));
        self.orders.push_back((now_s, sum.norm() / f64::max(count, 1.0)));
        while self.orders.front().is_some_and(|(then_s, _)| now_s - then_s > ORDER_S) {
            self.orders.pop_front();
        }
    }

    /// The longest link of the tree of shortest links of those who live.
    fn link_m(&self, arena: &Arena, lives: impl Fn(&usize) -> bool) -> f64 {
        let living = self.robots.iter().filter(|robot| lives(robot));
        longest_link_m(living.map(|robot| arena.state(*robot).pose_wb.position()))
    }

    fn order(&self) -> f64 {
        self.orders.iter().map(|(_, order)| order).sum::<f64>() / self.orders.len().max(1) as f64
    }

    fn cohesion_m(&self, arena: &Arena) -> f64 {
        let places_w: Vec<Vec2> = self.robots.iter().map(|robot| arena.state(*robot).pose_wb.position()).collect();
        let count = places_w.len().max(1) as f64;
        let middle_w = places_w.iter().sum::<Vec2>() / count;
        places_w.iter().map(|place_w| (place_w - middle_w).norm()).sum::<f64>() / count
    }
}
