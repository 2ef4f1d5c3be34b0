//! The walls of a place, sorted into a grid, so that the nearest one is found without asking all of them.

use crate::{MapSetting, PlaceSetting};

/// Walls farther than this from a point are not looked for, metres.
pub const FAR_M: f64 = 5.0;

/// Side of a cell of the grid, metres, unless the place is so large that this would be too many cells.
const CELL_M: f64 = 1.0;
/// Cells along a side of the grid at most.
const CELLS_MAX: f64 = 512.0;
/// A map of more cells than this (16 km by 16 km in metres) is left out.
const MAP_CELLS_MAX: usize = 1 << 28;

/// A closed outline with the box around it.
#[derive(Clone, Debug)]
struct Outline {
    points: Vec<[f64; 2]>,
    bounds: [f64; 4],
}

/// A grid map and where it lies.
#[derive(Clone, Debug)]
pub(super) struct Cells {
    map: MapSetting,
    solid: Vec<bool>,
}

/// A place, prepared for questions about distances. Make it once for a run.
#[derive(Clone, Debug)]
pub struct PlaceIndex {
    segments: Vec<[f64; 4]>,
    circles: Vec<[f64; 3]>,
    enclosure: Option<Outline>,
    polygons: Vec<Outline>,
    cells: Option<Cells>,
    bounds: Option<[f64; 4]>,
    grid: Grid,
}

impl PlaceIndex {
    /// Prepare a place. Outlines of fewer than two points, and whatever is not finite, are left out.
    #[must_use]
    pub fn new(place: &PlaceSetting) -> Self {
        let mut segments = Vec::new();
        let closed = place.polygons_m.iter().chain(std::iter::once(&place.enclosure_m));
        closed.for_each(|outline| chain(&mut segments, outline, true));
        place.polylines_m.iter().for_each(|points| chain(&mut segments, points, false));
        let cells = place.map.as_ref().and_then(Cells::new);
        if let Some(cells) = &cells {
            cells.faces(&mut segments);
        }
        segments.retain(|segment| segment.iter().all(|value| value.is_finite()));
        let mut circles = place.circles_m.clone();
        circles.retain(|circle| circle.iter().all(|value| value.is_finite()) && circle[2] >= 0.0);
        let bounds = bounds_of(&segments, &circles, cells.as_ref());
        let grid = Grid::new(&segments, &circles);
        let enclosure = outline(&place.enclosure_m);
        let polygons = place.polygons_m.iter().filter_map(|points| outline(points)).collect();
        Self { segments, circles, enclosure, polygons, cells, bounds, grid }
    }

    /// Whether there is no wall at all, so that every distance is `None`.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.segments.is_empty() && self.circles.is_empty()
    }

    /// The box around everything: least x, least y, greatest x, greatest y, world frame, metres. `None`: there is
    /// nothing.
    #[must_use]
    pub fn bounds_m(&self) -> Option<[f64; 4]> {
        self.bounds
    }

    /// Whether a point (world frame, metres) is where a robot's centre can be: within the enclosure, and not in an
    /// obstacle.
    #[must_use]
    pub fn is_free(&self, at_w: [f64; 2]) -> bool {
        self.enclosure.as_ref().is_none_or(|outline| outline.holds(at_w))
            && !self.polygons.iter().any(|outline| outline.holds(at_w))
            && !self.circles.iter().any(|[x, y, r]| (at_w[0] - x).hypot(at_w[1] - y) < *r)
            && !self.cells.as_ref().is_some_and(|cells| cells.is_solid(at_w))
    }

    /// From a point (world frame, metres) to the nearest wall, metres; `None`: there is none within [`FAR_M`]. Below 0
    /// for a point in an obstacle or outside of the enclosure: about how deep.
    #[must_use]
    pub fn wall_distance(&self, at_w: [f64; 2]) -> Option<f64> {
        if !at_w.iter().all(|value| value.is_finite()) {
            return None;
        }
        let nearest = self.grid.nearest(at_w, |item| self.item_distance(item, at_w));
        let solid = !self.is_free(at_w);
        // A centre deep in a solid is no nearer to being right because its border is far away.
        match nearest {
            Some(distance_m) if solid => Some(-distance_m.abs()),
            None if solid => Some(-FAR_M),
            nearest => nearest.filter(|distance_m| *distance_m <= FAR_M),
        }
    }

    fn item_distance(&self, item: u32, at_w: [f64; 2]) -> f64 {
        let item = item as usize;
        match self.segments.get(item) {
            Some(segment) => segment_distance(*segment, at_w),
            None => {
                let [x, y, r] = self.circles[item - self.segments.len()];
                (at_w[0] - x).hypot(at_w[1] - y) - r
            }
        }
    }
}

fn chain(segments: &mut Vec<[f64; 4]>, points: &[[f64; 2]], closed: bool) {
    segments.extend(points.windows(2).map(|pair| [pair[0][0], pair[0][1], pair[1][0], pair[1][1]]));
    if let (true, [first, .., last]) = (closed && points.len() > 2, points) {
        segments.push([last[0], last[1], first[0], first[1]]);
    }
}

fn outline(points: &[[f64; 2]]) -> Option<Outline> {
    let finite = points.iter().flatten().all(|value| value.is_finite());
    (points.len() > 2 && finite).then(|| {
        let mut bounds = [f64::INFINITY, f64::INFINITY, f64::NEG_INFINITY, f64::NEG_INFINITY];
        points.iter().for_each(|point| stretch(&mut bounds, *point, 0.0));
        Outline { points: points.to_vec(), bounds }
    })
}

impl Outline {
    /// Whether a point lies within: it is crossed an odd number of times on the way out.
    fn holds(&self, [x, y]: [f64; 2]) -> bool {
        if x < self.bounds[0] || y < self.bounds[1] || x > self.bounds[2] || y > self.bounds[3] {
            return false;
        }
        let mut inside = false;
        let mut before = self.points[self.points.len() - 1];
        for point in &self.points {
            let spans = (point[1] > y) != (before[1] > y);
            if spans && x < (before[0] - point[0]) * (y - point[1]) / (before[1] - point[1]) + point[0] {
                inside = !inside;
            }
            before = *point;
        }
        inside
    }
}

impl Cells {
    /// `None` for a map of an absurd size: no file of ours says that, and it would take forever.
    fn new(map: &MapSetting) -> Option<Self> {
        let cells = map.width.saturating_mul(map.height);
        (cells <= MAP_CELLS_MAX).then(|| Self { map: map.clone(), solid: map.solid() })
    }

    fn at(&self, x: Option<usize>, y: Option<usize>) -> bool {
        let (Some(x), Some(y)) = (x, y) else { return false };
        let within = x < self.map.width && y < self.map.height;
        within && self.solid.get(y * self.map.width + x).copied().unwrap_or(false)
    }

    fn is_solid(&self, at_w: [f64; 2]) -> bool {
        let (sin, cos) = self.map.origin_yaw_rad.sin_cos();
        let from = [at_w[0] - self.map.origin_m[0], at_w[1] - self.map.origin_m[1]];
        let x = (from[0] * cos + from[1] * sin) / self.map.resolution_m;
        let y = (from[1] * cos - from[0] * sin) / self.map.resolution_m;
        x >= 0.0 && y >= 0.0 && self.at(Some(x as usize), Some(y as usize))
    }

    fn corner(&self, x: usize, y: usize) -> [f64; 2] {
        let (sin, cos) = self.map.origin_yaw_rad.sin_cos();
        let (x, y) = (x as f64 * self.map.resolution_m, y as f64 * self.map.resolution_m);
        [self.map.origin_m[0] + x * cos - y * sin, self.map.origin_m[1] + x * sin + y * cos]
    }

    /// The sides between solid and free cells; those in one line are one segment.
    fn faces(&self, segments: &mut Vec<[f64; 4]>) {
        let (width, height) = (self.map.width, self.map.height);
        for y in 0..=height {
            let differs = |x: usize| self.at(Some(x), y.checked_sub(1)) != self.at(Some(x), Some(y));
            runs(width, differs, |from, to| push(segments, self.corner(from, y), self.corner(to, y)));
        }
        for x in 0..=width {
            let differs = |y: usize| self.at(x.checked_sub(1), Some(y)) != self.at(Some(x), Some(y));
            runs(height, differs, |from, to| push(segments, self.corner(x, from), self.corner(x, to)));
        }
    }
}

fn push(segments: &mut Vec<[f64; 4]>, from: [f64; 2], to: [f64; 2]) {
    segments.push([from[0], from[1], to[0], to[1]]);
}

/// Tell `found` of every longest run in `0..count` for which `holds`: its first, and the one after its last.
fn runs(count: usize, holds: impl Fn(usize) -> bool, mut found: impl FnMut(usize, usize)) {
    let mut from = None;
    for at in 0..=count {
        match (at < count && holds(at), from) {
            (true, None) => from = Some(at),
            (false, Some(first)) => {
                found(first, at);
                from = None;
            }
            _ => {}
        }
    }
}

fn segment_distance([ax, ay, bx, by]: [f64; 4], [x, y]: [f64; 2]) -> f64 {
    let (dx, dy) = (bx - ax, by - ay);
    let square = dx * dx + dy * dy;
    let along = if square > 0.0 { (((x - ax) * dx + (y - ay) * dy) / square).clamp(0.0, 1.0) } else { 0.0 };
    (x - ax - along * dx).hypot(y - ay - along * dy)
}

fn stretch(bounds: &mut [f64; 4], [x, y]: [f64; 2], by: f64) {
    *bounds = [bounds[0].min(x - by), bounds[1].min(y - by), bounds[2].max(x + by), bounds[3].max(y + by)];
}

fn bounds_of(segments: &[[f64; 4]], circles: &[[f64; 3]], cells: Option<&Cells>) -> Option<[f64; 4]> {
    let mut bounds = [f64::INFINITY, f64::INFINITY, f64::NEG_INFINITY, f64::NEG_INFINITY];
    for [ax, ay, bx, by] in segments {
        stretch(&mut bounds, [*ax, *ay], 0.0);
        stretch(&mut bounds, [*bx, *by], 0.0);
    }
    circles.iter().for_each(|[x, y, r]| stretch(&mut bounds, [*x, *y], *r));
    if let Some(cells) = cells {
        let (width, height) = (cells.map.width, cells.map.height);
        for (x, y) in [(0, 0), (width, 0), (0, height), (width, height)] {
            stretch(&mut bounds, cells.corner(x, y), 0.0);
        }
    }
    bounds.iter().all(|value| value.is_finite()).then_some(bounds)
}

/// Which segments and circles touch which cell of a uniform grid. Segments count from 0, circles go on after them.
#[derive(Clone, Debug)]
struct Grid {
    origin: [f64; 2],
    side_m: f64,
    size: [usize; 2],
    items: Vec<Vec<u32>>,
}

impl Grid {
    fn new(segments: &[[f64; 4]], circles: &[[f64; 3]]) -> Self {
        let bounds = bounds_of(segments, circles, None).unwrap_or([0.0; 4]);
        let extent = (bounds[2] - bounds[0]).max(bounds[3] - bounds[1]);
        let side_m = CELL_M.max(extent / CELLS_MAX);
        let cells = |length: f64| (length / side_m) as usize + 1;
        let size = [cells(bounds[2] - bounds[0]), cells(bounds[3] - bounds[1])];
        let mut grid = Self { origin: [bounds[0], bounds[1]], side_m, size, items: Vec::new() };
        grid.items.resize(size[0] * size[1], Vec::new());
        let mut number = 0;
        for segment in segments {
            grid.put_segment(number, *segment);
            number += 1;
        }
        for [x, y, r] in circles {
            let (columns, rows) = (grid.span(0, x - r, x + r), grid.span(1, y - r, y + r));
            columns.for_each(|column| grid.put(number, column, rows.clone()));
            number += 1;
        }
        grid
    }

    /// Cells along an axis from one coordinate to another, those at the rim included.
    fn span(&self, axis: usize, from: f64, to: f64) -> std::ops::RangeInclusive<usize> {
        let cell = |value: f64| ((value - self.origin[axis]) / self.side_m).max(0.0) as usize;
        // A hair wider, so that what lies on a line between two cells is in both.
        let hair = self.side_m * 1e-9;
        cell(from - hair).min(self.size[axis] - 1)..=cell(to + hair).min(self.size[axis] - 1)
    }

    fn put(&mut self, number: u32, column: usize, rows: std::ops::RangeInclusive<usize>) {
        rows.for_each(|row| self.items[row * self.size[0] + column].push(number));
    }

    /// Column by column, the rows that the part of the segment in this column touches.
    fn put_segment(&mut self, number: u32, [ax, ay, bx, by]: [f64; 4]) {
        let (from, to) = if ax <= bx { ([ax, ay], [bx, by]) } else { ([bx, by], [ax, ay]) };
        for column in self.span(0, from[0], to[0]) {
            let west = self.origin[0] + column as f64 * self.side_m;
            let y_at = |x: f64| {
                let along = (x - from[0]) / (to[0] - from[0]);
                from[1] + (to[1] - from[1]) * along.clamp(0.0, 1.0)
            };
            let upright = to[0] - from[0] <= self.side_m * 1e-6;
            let (one, other) = if upright { (from[1], to[1]) } else { (y_at(west), y_at(west + self.side_m)) };
            let rows = self.span(1, one.min(other), one.max(other));
            self.put(number, column, rows);
        }
    }

    /// The least distance of an item, ring by ring of cells about the point, until none can be nearer or all are far.
    fn nearest(&self, at_w: [f64; 2], distance: impl Fn(u32) -> f64) -> Option<f64> {
        let cell = |axis: usize| ((at_w[axis] - self.origin[axis]) / self.side_m).floor() as i64;
        let (column, row) = (cell(0), cell(1));
        let rings = (FAR_M / self.side_m).ceil() as i64 + 1;
        let mut best: Option<f64> = None;
        for ring in 0..=rings {
            // Whatever is only in this ring and beyond is at least this far away.
            let reach_m = (ring - 1) as f64 * self.side_m;
            if best.is_some_and(|best| best <= reach_m) {
                break;
            }
            for y in row.saturating_sub(ring)..=row.saturating_add(ring) {
                let edge = (y - row).abs() == ring;
                let step = if edge { 1 } else { (2 * ring).max(1) };
                let mut x = column.saturating_sub(ring);
                while x <= column.saturating_add(ring) {
                    let items = self.items_at(x, y);
                    let nearest = items.iter().map(|item| distance(*item)).min_by(f64::total_cmp);
                    best = super::smaller(best, nearest);
                    x += step;
                }
            }
        }
        best
    }

    fn items_at(&self, column: i64, row: i64) -> &[u32] {
        let (Ok(column), Ok(row)) = (usize::try_from(column), usize::try_from(row)) else { return &[] };
        let within = column < self.size[0] && row < self.size[1];
        if within { self.items.get(row * self.size[0] + column).map_or(&[], Vec::as_slice) } else { &[] }
    }
}
