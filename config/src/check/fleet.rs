//! Fleets become robots: each gets a place that is clear of walls and of everybody else.

use super::Checker;
use crate::boxes::Bounds;
use crate::crowd::{Crowd, Near};
use crate::geometry::Point;
use crate::path::join;
use crate::read::fleet::{FleetParts, Layout};
use crate::read::kind::KindParts;
use crate::read::robot::{ROBOTS_MAX, RobotParts, derived_links};
use crate::read::swarm::SwarmParts;
use crate::report::Words;
use crate::walls::Walls;
use crate::{Behaviour, Drive, Start};
use rand::Rng;
use rand_pcg::Pcg32;
use std::f64::consts::PI;

/// Most places that are tried for one fleet, in a grid: a second's work.
const GRID_TRIES_MAX: usize = 2_000_000;
/// Most places that are tried for each robot at random. Discs that are dropped at random jam when they cover 55 % of
/// the floor; the last ones need long.
const RANDOM_TRIES_MAX: usize = 20;
/// Places tried at random without finding one, after which there are none.
const FAILURES_MAX: usize = 20_000;
/// Stream of the generator for the first fleet; each has its own, apart from those that the simulation uses.
const STREAM: u64 = 0x666c_6565_7400_0000;

/// A fleet, all of whose keys could be read and stand for something.
struct Order {
    count: usize,
    radius_m: f64,
    region_m: Bounds,
    spacing_m: f64,
    linked_m: Option<f64>,
    yaw_rad: Option<f64>,
}

impl Checker<'_> {
    /// The robots of all fleets, after the explicit ones, whose places `crowd` holds.
    pub(crate) fn fleets(
        &mut self,
        parts: &SwarmParts,
        walls: Option<&Walls<'_>>,
        mut crowd: Crowd,
    ) -> Vec<RobotParts> {
        let mut robots = Vec::new();
        let clear_m = match &parts.behaviour {
            Some(Behaviour::Deploy(deploy)) => deploy.wall_gap_m,
            Some(Behaviour::Flock(_) | Behaviour::Diffuse(_) | Behaviour::Explore(_)) | None => 0.0,
        };
        for (index, fleet) in parts.fleets.iter().enumerate() {
            let count = fleet.count.unwrap_or(0) as usize;
            let all = parts.robots.len() + robots.len() + count;
            if all > ROBOTS_MAX {
                let found = format!("{count}, which makes {all} robots in all");
                let words = Words::new(found, format!("at most {ROBOTS_MAX} robots in all"), "lower it");
                self.report.push_path(self.root, &join(&fleet.path, "count"), words);
                return robots;
            }
            let mut random = Pcg32::new(parts.seed.unwrap_or(0), STREAM + index as u64);
            let kind = fleet.kind.as_ref().and_then(|kind| parts.kinds.get(kind));
            let starts = match self.order(fleet, kind, walls).zip(walls).zip(fleet.layout) {
                Some(((mut order, walls), layout)) => {
                    if let Some(shift_m) = fleet.shift_m.flatten() {
                        order.region_m = shifted(order.region_m, shift_m, &mut random);
                    }
                    let mut floor = Floor { walls, clear_m, crowd: &mut crowd };
                    let starts = floor.place(&order, layout, &mut random);
                    self.all_fit(fleet, &order, starts.len());
                    starts
                }
                None => Vec::new(),
            };
            let drive = kind.and_then(|kind| kind.drive).zip(parts.mavlink_port_base);
            robots.extend(self.members(fleet, &starts, drive));
        }
        robots
    }

    /// What a fleet asks for; `None`, and perhaps a problem, if that cannot be said.
    fn order(&mut self, fleet: &FleetParts, kind: Option<&KindParts>, walls: Option<&Walls<'_>>) -> Option<Order> {
        let radius_m = kind?.body.as_ref()?.radius_m;
        let region_m = match fleet.region_m? {
            Some(region_m) => region_m,
            None => match walls?.bounds() {
                Some(bounds) => bounds,
                None => {
                    let words = Words::new(
                        "nothing, in a world without enclosure and map",
                        "two points [[x_min, y_min], [x_max, y_max]]",
                        "say where the fleet starts",
                    );
                    self.report.push_path(self.root, &join(&fleet.path, "region_m"), words);
                    return None;
                }
            },
        };
        let spacing_m = fleet.spacing_m?.unwrap_or(4.0 * radius_m);
        if spacing_m < 2.0 * radius_m {
            let expected = format!("at least two radii, {}", 2.0 * radius_m);
            let words = Words::new(spacing_m.to_string(), expected, "raise it: robots would touch");
            self.report.push_path(self.root, &join(&fleet.path, "spacing_m"), words);
            return None;
        }
        let linked_m = fleet.linked_m?;
        if let Some(linked_m) = linked_m {
            self.linked(fleet, linked_m, spacing_m)?;
        }
        let (count, yaw_rad) = (fleet.count? as usize, fleet.yaw_rad?);
        Some(Order { count, radius_m, region_m, spacing_m, linked_m, yaw_rad })
    }

    /// Robots at random places can be near to each other, and no nearer than they must be apart.
    fn linked(&mut self, fleet: &FleetParts, linked_m: f64, spacing_m: f64) -> Option<()> {
        let path = join(&fleet.path, "linked_m");
        let words = match fleet.layout? {
            Layout::Grid => {
                let found = format!("{linked_m} beside layout = \"grid\"");
                Words::new(found, "a random layout", "leave it out, and choose spacing_m: neighbours are that near")
            }
            Layout::Random if linked_m < spacing_m => {
                let expected = format!("at least spacing_m, {spacing_m}");
                Words::new(linked_m.to_string(), expected, "raise it, or lower spacing_m")
            }
            Layout::Random => return Some(()),
        };
        self.report.push_path(self.root, &path, words);
        None
    }

    fn all_fit(&mut self, fleet: &FleetParts, order: &Order, placed: usize) {
        if placed < order.count {
            let [[west, south], [east, north]] = order.region_m;
            let found = format!("{}, of which {placed} fit into [[{west}, {south}], [{east}, {north}]]", order.count);
            let expected = format!("as many as have {} m to each other and no wall in them", order.spacing_m);
            let advice = match order.linked_m {
                None => "lower count or spacing_m, or widen region_m (a grid is denser than a random layout)",
                Some(_) => "lower count or spacing_m, raise linked_m, or widen region_m",
            };
            self.report.push_path(self.root, &join(&fleet.path, "count"), Words::new(found, expected, advice));
        }
    }

    /// The robots of `fleet`. Those without a place are there all the same: others may name them.
    fn members(&mut self, fleet: &FleetParts, starts: &[Start], drive: Option<(Drive, u16)>) -> Vec<RobotParts> {
        let (Some(count), Some(first)) = (fleet.count, fleet.first_id) else { return Vec::new() };
        if first.checked_add(count - 1).is_none() {
            let expected = format!("at most {}, for {count} robots", u32::MAX - (count - 1));
            let words = Words::new(first.to_string(), expected, "lower it");
            self.report.push_path(self.root, &join(&fleet.path, "first_id"), words);
            return Vec::new();
        }
        let member = |index: u32| {
            let id = first + index;
            RobotParts {
                path: fleet.path.clone(),
                id: Some(id),
                kind: fleet.kind.clone(),
                start: starts.get(index as usize).copied(),
                links: drive.and_then(|(drive, port_base)| derived_links(drive, id, port_base)),
                of_fleet: true,
            }
        };
        (0..count).map(member).collect()
    }
}

/// Walls, and who stands where already.
struct Floor<'f, 'w> {
    walls: &'f Walls<'w>,
    /// What the behaviour keeps free between bodies and walls, metres.
    clear_m: f64,
    crowd: &'f mut Crowd,
}

impl Floor<'_, '_> {
    fn place(&mut self, order: &Order, layout: Layout, random: &mut Pcg32) -> Vec<Start> {
        match layout {
            Layout::Grid => self.in_rows(order),
            Layout::Random => self.at_random(order, random),
        }
    }

    fn is_free(&self, point: Point, radius_m: f64) -> bool {
        self.crowd.overlapping(point, radius_m).is_none() && self.walls.is_clear(point, radius_m + self.clear_m)
    }

    fn in_rows(&mut self, order: &Order) -> Vec<Start> {
        let [(west_m, columns), (south_m, rows)] = [0, 1].map(|axis| places(order, axis));
        let row = |y: usize| (0..columns).map(move |x| (x, y));
        let point =
            |(x, y): (usize, usize)| [west_m + x as f64 * order.spacing_m, south_m + y as f64 * order.spacing_m];
        let points = (0..rows).flat_map(row).take(GRID_TRIES_MAX).map(point);
        let yaw_rad = order.yaw_rad.unwrap_or(0.0);
        let free = points.filter(|point| self.is_free(*point, order.radius_m)).take(order.count);
        let starts: Vec<Start> = free.map(|[x_m, y_m]| Start { x_m, y_m, yaw_rad }).collect();
        // Places of a grid keep clear of each other as they are.
        starts.iter().for_each(|start| self.crowd.add([start.x_m, start.y_m], order.radius_m));
        starts
    }

    fn at_random(&mut self, order: &Order, random: &mut Pcg32) -> Vec<Start> {
        let mut starts = Vec::with_capacity(order.count);
        let mut apart = Near::new(order.spacing_m);
        let mut linked = order.linked_m.map(Near::new);
        let room = [0, 1].map(|axis| order.region_m[1][axis] - order.region_m[0][axis] - 2.0 * order.radius_m);
        if room.iter().any(|room_m| *room_m < 0.0) {
            return starts;
        }
        let mut failures = 0;
        for _ in 0..order.count * RANDOM_TRIES_MAX + FAILURES_MAX {
            if starts.len() == order.count || failures == FAILURES_MAX {
                break;
            }
            // A number in 0..1 for each axis, whether or not the place is taken.
            let share: [f64; 2] = [random.random(), random.random()];
            let point = [0, 1].map(|axis| order.region_m[0][axis] + order.radius_m + share[axis] * room[axis]);
            failures += 1;
            let joins = starts.is_empty() || linked.as_ref().is_none_or(|linked| linked.reaches(point));
            if joins && apart.has_room(point) && self.is_free(point, order.radius_m) {
                let yaw_rad = order.yaw_rad.unwrap_or_else(|| (random.random::<f64>() * 2.0 - 1.0) * PI);
                starts.push(Start { x_m: point[0], y_m: point[1], yaw_rad });
                self.crowd.add(point, order.radius_m);
                apart.add(point);
                if let Some(linked) = &mut linked {
                    linked.add(point);
                }
                failures = 0;
            }
        }
        starts
    }
}

/// `region_m` moved by an offset in `shift_m`.
fn shifted(region_m: Bounds, shift_m: Bounds, random: &mut Pcg32) -> Bounds {
    let [low_m, high_m] = shift_m;
    let offset_m = [0, 1].map(|axis| low_m[axis] + random.random::<f64>() * (high_m[axis] - low_m[axis]));
    region_m.map(|corner| [corner[0] + offset_m[0], corner[1] + offset_m[1]])
}

/// The first place of a grid along an axis, metres, and how many there are: as many as fit, in the middle.
fn places(order: &Order, axis: usize) -> (f64, usize) {
    let (low_m, high_m) = (order.region_m[0][axis], order.region_m[1][axis]);
    let room_m = high_m - low_m - 2.0 * order.radius_m;
    if room_m < 0.0 {
        return (low_m, 0);
    }
    let gaps = (room_m / order.spacing_m).floor();
    ((low_m + high_m - gaps * order.spacing_m) / 2.0, gaps as usize + 1)
}
