//! How much of a place the swarm's scans have swept.

use super::index::PlaceIndex;
use crate::{CLEAR, Moment, Place, ScanMoment, Setting};
use std::collections::BTreeMap;

/// Side of a cell, metres, unless the place is so large that this would be too many cells.
pub const COVERAGE_CELL_M: f64 = 0.25;

const CELLS_MAX: f64 = 4e6;

/// How much of a place the scans of a run have swept so far.
///
/// Cells of [`COVERAGE_CELL_M`] over the box around the place. A cell is free if its middle is within the enclosure and
/// in no obstacle (without an enclosure: within the box); it is seen once a beam has crossed it, up to what it met or
/// as far as it can measure. What no robot can get to or see counts as free, so the share need not reach 1.
#[derive(Clone, Debug)]
pub struct Coverage {
    origin: [f64; 2],
    side_m: f64,
    size: [usize; 2],
    free: Vec<bool>,
    seen: Vec<bool>,
    free_count: usize,
    seen_count: usize,
    mounts: BTreeMap<u32, [f64; 3]>,
    newest: BTreeMap<u32, f64>,
}

impl Coverage {
    /// Nothing is seen yet. In a setting without a place nothing can be seen.
    #[must_use]
    pub fn new(setting: &Setting) -> Self {
        let index = PlaceIndex::new(&setting.place);
        let mounts = setting.robots.iter().map(|robot| (robot.id, robot.lidar_mount)).collect();
        let bounds = index.bounds_m();
        let [west, south, east, north] = bounds.unwrap_or([0.0; 4]);
        let area = (east - west) * (north - south);
        let side_m = COVERAGE_CELL_M.max((area / CELLS_MAX).sqrt()).max((east - west).max(north - south) / CELLS_MAX);
        let cells = |length: f64| if bounds.is_some() { ((length / side_m).ceil() as usize).max(1) } else { 0 };
        let size = [cells(east - west), cells(north - south)];
        let middle = |at: usize| {
            let (column, row) = ((at % size[0]) as f64, (at / size[0]) as f64);
            [west + (column + 0.5) * side_m, south + (row + 0.5) * side_m]
        };
        let free: Vec<bool> = (0..size[0] * size[1]).map(|at| index.is_free(middle(at))).collect();
        let free_count = free.iter().filter(|free| **free).count();
        let seen = vec![false; free.len()];
        let origin = [west, south];
        Self { origin, side_m, size, free, seen, free_count, seen_count: 0, mounts, newest: BTreeMap::new() }
    }

    /// Take in the scans of a moment. One that was taken in already, by its time, costs nothing.
    pub fn add(&mut self, moment: &Moment) {
        for robot in &moment.robots {
            let (Some(place), Some(scan)) = (robot.place(), &robot.scan) else { continue };
            let known = self.newest.insert(robot.id, scan.time_s);
            if known.is_none_or(|time_s| (time_s - scan.time_s).abs() > 0.0) {
                let mount = self.mounts.get(&robot.id).copied().unwrap_or_default();
                self.sweep(place, mount, scan);
            }
        }
    }

    /// Share of the free area that was seen, 0..=1; `None`: there is no free area, because there is no place.
    #[must_use]
    pub fn fraction(&self) -> Option<f64> {
        (self.free_count > 0).then(|| self.seen_count as f64 / self.free_count as f64)
    }

    /// The free area that was seen, square metres.
    #[must_use]
    pub fn seen_m2(&self) -> f64 {
        self.seen_count as f64 * self.side_m * self.side_m
    }

    /// The free area, square metres.
    #[must_use]
    pub fn free_m2(&self) -> f64 {
        self.free_count as f64 * self.side_m * self.side_m
    }

    fn sweep(&mut self, place: Place, [mount_x, mount_y, mount_yaw]: [f64; 3], scan: &ScanMoment) {
        let (sin, cos) = place.yaw_rad.sin_cos();
        let from = [place.x_m + mount_x * cos - mount_y * sin, place.y_m + mount_x * sin + mount_y * cos];
        let first_rad = place.yaw_rad + mount_yaw + scan.angle_first_rad;
        for (beam, range_m) in scan.ranges_m.iter().enumerate() {
            let Some(range_m) = *range_m else { continue };
            let met = if range_m <= CLEAR { scan.range_m_max } else { range_m.min(scan.range_m_max) };
            let (sin, cos) = (first_rad + beam as f64 * scan.angle_step_rad).sin_cos();
            self.walk(from, [cos, sin], met);
        }
    }

    /// Mark the cells along a ray, from one border between cells to the next (Amanatides and Woo, 1987).
    fn walk(&mut self, from: [f64; 2], direction: [f64; 2], length_m: f64) {
        let finite = from.iter().chain(&direction).all(|value| value.is_finite()) && length_m.is_finite();
        if !finite || self.free_count == 0 {
            return;
        }
        let start = [(from[0] - self.origin[0]) / self.side_m, (from[1] - self.origin[1]) / self.side_m];
        let mut cell = [start[0].floor() as i64, start[1].floor() as i64];
        let mut next = [f64::INFINITY; 2];
        for axis in 0..2 {
            let ahead = if direction[axis] > 0.0 { 1.0 } else { 0.0 };
            if direction[axis].abs() > 1e-12 {
                next[axis] = (cell[axis] as f64 + ahead - start[axis]) / direction[axis];
            }
        }
        let length = length_m / self.side_m;
        // Not more steps than a ray can cross cells of the box and come to it; a far start must not take forever.
        for _ in 0..4 * (self.size[0] + self.size[1]) {
            self.see(cell);
            let axis = usize::from(next[1] < next[0]);
            if next[axis] > length {
                break;
            }
            cell[axis] += if direction[axis] > 0.0 { 1 } else { -1 };
            next[axis] += 1.0 / direction[axis].abs();
        }
    }

    fn see(&mut self, [column, row]: [i64; 2]) {
        let (Ok(column), Ok(row)) = (usize::try_from(column), usize::try_from(row)) else { return };
        if column >= self.size[0] || row >= self.size[1] {
            return;
        }
        let at = row * self.size[0] + column;
        if self.free[at] && !self.seen[at] {
            self.seen[at] = true;
            self.seen_count += 1;
        }
    }
}
