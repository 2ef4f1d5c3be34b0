//! Movers: each on a way that leads somewhere and that no wall crosses.

use super::Checker;
use crate::Mover;
use crate::geometry::{Point, distance};
use crate::path::join;
use crate::report::Words;
use crate::walls::Walls;

/// Waypoints nearer to each other than this are a slip of the pen, metres.
const LEG_M_MIN: f64 = 0.001;
/// A mover keeps at least this from walls on its whole way, metres: where it goes is looked at as exactly as that.
const GAP_M: f64 = 0.001;
/// Places that are looked at, on the ways of all movers together: a second's work.
const LOOKS_MAX: u32 = 500_000;

/// What is in the way of a mover.
enum Block {
    /// A wall, where its centre is here.
    Wall(Point),
    /// Nothing as far as was looked at, which would take too long to the end.
    Unknown,
}

impl Checker<'_> {
    /// The movers of the world whose table is at `prefix`: nothing is in the way of any.
    pub(crate) fn movers(&mut self, prefix: &str, movers: &[(usize, Mover)], walls: &Walls<'_>) {
        let mut looks = 0;
        for (index, mover) in movers {
            let path = join(prefix, &format!("movers[{index}].waypoints_m"));
            if self.route(&path, mover) {
                self.way_is_free(&path, mover, walls, &mut looks);
            }
        }
    }

    /// Whether every waypoint is at another place than the one before.
    fn route(&mut self, path: &str, mover: &Mover) -> bool {
        let Some((from, to, _)) = legs(mover).find(|(_, _, [a, b])| distance(*a, *b) < LEG_M_MIN) else { return true };
        let found = format!("waypoints {from} and {to} at the same place");
        let words = Words::new(found, "waypoints each at another place than the one before", "leave one of them out");
        self.report.push_path(self.root, path, words);
        false
    }

    /// A mover fits everywhere on its way; one wall that is in it is said.
    fn way_is_free(&mut self, path: &str, mover: &Mover, walls: &Walls<'_>, looks: &mut u32) {
        let blocked = |(from, to, leg)| Some((from, to, block(walls, leg, mover.radius_m, looks)?));
        let Some((from, to, block)) = legs(mover).find_map(blocked) else { return };
        let radius_m = mover.radius_m;
        let words = match block {
            Block::Wall(at) => {
                let wall = walls.at(at, radius_m + GAP_M).unwrap_or_default();
                let found = format!("[{:.3}, {:.3}] on the way from waypoint {from} to {to}, {wall}", at[0], at[1]);
                let expected = format!("more than {radius_m} m of free floor around its centre all the way");
                Words::new(found, expected, "move the waypoints away from the wall, or add some around it")
            }
            Block::Unknown => {
                let found = format!("a way from waypoint {from} to {to} along walls, too long to be looked at");
                Words::new(found, "a way that is short, or not so near to walls", "move it away from them")
            }
        };
        self.report.push_path(self.root, &format!("{path}[{from}]"), words);
    }
}

/// The straight parts of a mover's way that are not the way back, with the waypoints at their ends.
fn legs(mover: &Mover) -> impl Iterator<Item = (usize, usize, [Point; 2])> {
    let points = &mover.waypoints_m;
    let count = if mover.loops { points.len() } else { points.len().saturating_sub(1) };
    let ends = points.iter().zip(points.iter().cycle().skip(1)).take(count).enumerate();
    ends.map(|(from, (a, b))| (from, (from + 1) % points.len(), [*a, *b]))
}

/// What a disc meets on its way from `a` to `b`, if anything.
///
/// A part of the way is free if a disc about its middle is that holds all of it; else its halves are looked at.
fn block(walls: &Walls<'_>, [a, b]: [Point; 2], radius_m: f64, looks: &mut u32) -> Option<Block> {
    let length_m = distance(a, b);
    let mut open = vec![(0.0, 1.0)];
    while let Some((from, to)) = open.pop() {
        *looks += 1;
        if *looks > LOOKS_MAX {
            return Some(Block::Unknown);
        }
        let (middle, half_m) = (f64::midpoint(from, to), (to - from) / 2.0 * length_m);
        let at = [a[0] + middle * (b[0] - a[0]), a[1] + middle * (b[1] - a[1])];
        if walls.is_clear(at, radius_m + half_m) {
            continue;
        }
        if half_m <= GAP_M || !walls.is_clear(at, radius_m) {
            return Some(Block::Wall(at));
        }
        open.extend([(middle, to), (from, middle)]);
    }
    None
}
