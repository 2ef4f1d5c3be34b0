//! What lidars see of the walls: pieces in square tiles, ready to be drawn into a depth buffer.
//!
//! Long walls are cut into pieces no longer than a tile, each piece belongs to the tile that holds its middle, and a
//! tile keeps its pieces relative to its own centre, as f32 in lanes. A scan touches the tiles within its range and
//! nothing else; how large the place is does not matter.

use crate::depth::{DepthBuffer, LANES, Lanes};
use crate::geometry::{Disc, Segment};
use drover_contract::{Pose, Vec2};

/// Pieces a tile, on average, where there are many.
const PIECES_PER_TILE: f64 = 12.0;
/// Sides of tiles, metres.
const TILE_M_MIN: f64 = 2.0;
const TILE_M_MAX: f64 = 16.0;
/// Tiles at most: a place of 10 km with little in it gets larger ones.
const TILES_MAX: f64 = 262_144.0;

/// Walls and round obstacles by tile.
pub struct Sight {
    low_w: Vec2,
    tile_m: f64,
    columns: usize,
    rows: usize,
    tiles: Vec<Tile>,
    walls: Vec<WallLanes>,
    discs: Vec<DiscLanes>,
    disc_radius_m_max: f64,
}

/// Where a tile's things are in the lists, and the box that holds them all, relative to the tile's centre, metres.
#[derive(Clone, Copy, Debug)]
struct Tile {
    walls: (u32, u32),
    discs: (u32, u32),
    low: [f32; 2],
    high: [f32; 2],
}

impl Default for Tile {
    fn default() -> Self {
        Self { walls: (0, 0), discs: (0, 0), low: [f32::INFINITY; 2], high: [f32::NEG_INFINITY; 2] }
    }
}

/// Pieces relative to their tile's centre: start and edge, metres.
#[derive(Clone, Copy, Debug, Default)]
struct WallLanes {
    ax: Lanes,
    ay: Lanes,
    ex: Lanes,
    ey: Lanes,
}

/// Discs relative to their tile's centre, metres.
#[derive(Clone, Copy, Debug, Default)]
struct DiscLanes {
    px: Lanes,
    py: Lanes,
    radius: Lanes,
}

/// A sensor's frame in f32: what turns a place relative to a tile into one relative to the sensor.
#[derive(Clone, Copy, Debug)]
struct Frame {
    cos: f32,
    sin: f32,
    x: f32,
    y: f32,
}

impl Frame {
    /// `centre_w` seen from a sensor at `origin_w` that looks along `heading`.
    fn new(origin_w: Vec2, heading: Vec2, centre_w: Vec2) -> Self {
        let d = centre_w - origin_w;
        let (x, y) = (heading.x * d.x + heading.y * d.y, heading.x * d.y - heading.y * d.x);
        Self { cos: heading.x as f32, sin: heading.y as f32, x: x as f32, y: y as f32 }
    }

    #[inline]
    fn turned(&self, x: &Lanes, y: &Lanes) -> (Lanes, Lanes) {
        let (mut along, mut across) = ([0.0; LANES], [0.0; LANES]);
        for i in 0..LANES {
            along[i] = self.cos * x[i] + self.sin * y[i];
            across[i] = self.cos * y[i] - self.sin * x[i];
        }
        (along, across)
    }

    #[inline]
    fn moved(&self, x: &Lanes, y: &Lanes) -> (Lanes, Lanes) {
        let (mut along, mut across) = self.turned(x, y);
        for i in 0..LANES {
            along[i] += self.x;
            across[i] += self.y;
        }
        (along, across)
    }
}

impl Sight {
    /// Everything that stands in a place.
    #[must_use]
    pub fn new(segments: &[Segment], discs: &[Disc]) -> Self {
        let mut sight = Self::laid_out(segments, discs);
        let pieces: Vec<Segment> = segments.iter().flat_map(|segment| cut(segment, sight.tile_m)).collect();
        let mut of_tile: Vec<(usize, usize)> =
            pieces.iter().enumerate().map(|(i, p)| (sight.tile_of((p.from_w + p.to_w) / 2.0), i)).collect();
        of_tile.sort_unstable();
        for run in of_tile.chunk_by(|a, b| a.0 == b.0) {
            sight.add_walls(run[0].0, run.iter().map(|(_, index)| &pieces[*index]));
        }
        let mut of_tile: Vec<(usize, usize)> =
            discs.iter().enumerate().map(|(i, disc)| (sight.tile_of(disc.centre_w), i)).collect();
        of_tile.sort_unstable();
        for run in of_tile.chunk_by(|a, b| a.0 == b.0) {
            sight.add_discs(run[0].0, run.iter().map(|(_, index)| &discs[*index]));
        }
        sight
    }

    fn laid_out(segments: &[Segment], discs: &[Disc]) -> Self {
        let places = || segments.iter().flat_map(|s| [s.from_w, s.to_w]).chain(discs.iter().map(|d| d.centre_w));
        let mut low_w = places().fold(Vec2::repeat(f64::INFINITY), |low, place| low.inf(&place));
        let high_w = places().fold(Vec2::repeat(f64::NEG_INFINITY), |high, place| high.sup(&place));
        if !low_w.x.is_finite() {
            low_w = Vec2::zeros();
        }
        let extent = (high_w - low_w).map(|along| if along.is_finite() { along.max(1.0) } else { 1.0 });
        let count = (segments.len() + discs.len()).max(1) as f64;
        let wished_m = (extent.x * extent.y * PIECES_PER_TILE / count).sqrt().clamp(TILE_M_MIN, TILE_M_MAX);
        let tile_m = wished_m.max((extent.x * extent.y / TILES_MAX).sqrt());
        let (columns, rows) = ((extent.x / tile_m) as usize + 1, (extent.y / tile_m) as usize + 1);
        let tiles = vec![Tile::default(); columns * rows];
        let disc_radius_m_max = discs.iter().map(|disc| disc.radius_m).fold(0.0, f64::max);
        Self { low_w, tile_m, columns, rows, tiles, walls: Vec::new(), discs: Vec::new(), disc_radius_m_max }
    }

    /// Draw all that a sensor at `pose_ws` (world frame) may see.
    pub(crate) fn draw(&self, pose_ws: Pose, depth: &mut DepthBuffer) {
        let (origin_w, heading) = (pose_ws.position(), pose_ws.heading());
        // A thing lies up to half a tile outside of its own tile (a disc: up to its radius, which widens its box).
        let reach_m = f64::from(depth.range_m()) + self.tile_m / 2.0 + self.disc_radius_m_max;
        let (left, low) = self.column_row(origin_w - Vec2::repeat(reach_m));
        let (right, high) = self.column_row(origin_w + Vec2::repeat(reach_m));
        for row in low..=high {
            for column in left..=right {
                let tile = &self.tiles[row * self.columns + column];
                let centre_w = self.centre_w(column, row);
                if tile.is_empty() || tile.distance_m(origin_w - centre_w) > depth.range_m() {
                    continue;
                }
                self.draw_tile(tile, &Frame::new(origin_w, heading, centre_w), depth);
            }
        }
    }

    /// Heap bytes held.
    pub(crate) fn bytes(&self) -> usize {
        self.tiles.capacity() * size_of::<Tile>()
            + self.walls.capacity() * size_of::<WallLanes>()
            + self.discs.capacity() * size_of::<DiscLanes>()
    }

    fn draw_tile(&self, tile: &Tile, frame: &Frame, depth: &mut DepthBuffer) {
        for lanes in &self.walls[tile.walls.0 as usize..tile.walls.1 as usize] {
            let (ax, ay) = frame.moved(&lanes.ax, &lanes.ay);
            let (ex, ey) = frame.turned(&lanes.ex, &lanes.ey);
            depth.draw_walls([&ax, &ay, &ex, &ey]);
        }
        for lanes in &self.discs[tile.discs.0 as usize..tile.discs.1 as usize] {
            let (px, py) = frame.moved(&lanes.px, &lanes.py);
            depth.draw_discs([&px, &py, &lanes.radius]);
        }
    }

    fn add_walls<'s>(&mut self, tile: usize, pieces: impl Iterator<Item = &'s Segment>) {
        let centre_w = self.centre_w(tile % self.columns, tile / self.columns);
        let first = self.walls.len() as u32;
        for (index, piece) in pieces.enumerate() {
            if index % LANES == 0 {
                self.walls.push(WallLanes::default());
            }
            let (from, to) = (piece.from_w - centre_w, piece.to_w - centre_w);
            self.tiles[tile].hold(from, 0.0);
            self.tiles[tile].hold(to, 0.0);
            let edge = piece.to_w - piece.from_w;
            if let Some(lanes) = self.walls.last_mut() {
                let i = index % LANES;
                (lanes.ax[i], lanes.ay[i]) = (from.x as f32, from.y as f32);
                (lanes.ex[i], lanes.ey[i]) = (edge.x as f32, edge.y as f32);
            }
        }
        self.tiles[tile].walls = (first, self.walls.len() as u32);
    }

    fn add_discs<'d>(&mut self, tile: usize, discs: impl Iterator<Item = &'d Disc>) {
        let centre_w = self.centre_w(tile % self.columns, tile / self.columns);
        let first = self.discs.len() as u32;
        for (index, disc) in discs.enumerate() {
            if index % LANES == 0 {
                self.discs.push(DiscLanes::default());
            }
            let place = disc.centre_w - centre_w;
            self.tiles[tile].hold(place, disc.radius_m);
            if let Some(lanes) = self.discs.last_mut() {
                let i = index % LANES;
                (lanes.px[i], lanes.py[i], lanes.radius[i]) = (place.x as f32, place.y as f32, disc.radius_m as f32);
            }
        }
        self.tiles[tile].discs = (first, self.discs.len() as u32);
    }

    fn centre_w(&self, column: usize, row: usize) -> Vec2 {
        self.low_w + Vec2::new(column as f64 + 0.5, row as f64 + 0.5) * self.tile_m
    }

    fn column_row(&self, place_w: Vec2) -> (usize, usize) {
        let from = (place_w - self.low_w) / self.tile_m;
        ((from.x as usize).min(self.columns - 1), (from.y as usize).min(self.rows - 1))
    }

    fn tile_of(&self, place_w: Vec2) -> usize {
        let (column, row) = self.column_row(place_w);
        row * self.columns + column
    }
}

impl Tile {
    fn is_empty(&self) -> bool {
        self.walls.0 == self.walls.1 && self.discs.0 == self.discs.1
    }

    fn hold(&mut self, place: Vec2, margin_m: f64) {
        for axis in 0..2 {
            self.low[axis] = self.low[axis].min((place[axis] - margin_m) as f32);
            self.high[axis] = self.high[axis].max((place[axis] + margin_m) as f32);
        }
    }

    /// How far the box is from a place relative to the tile's centre, metres.
    fn distance_m(&self, place: Vec2) -> f32 {
        let apart = |axis: usize| {
            let at = place[axis] as f32;
            (self.low[axis] - at).max(at - self.high[axis]).max(0.0)
        };
        (apart(0) * apart(0) + apart(1) * apart(1)).sqrt()
    }
}

/// A wall in equal pieces no longer than `piece_m`.
fn cut(segment: &Segment, piece_m: f64) -> impl Iterator<Item = Segment> + use<> {
    let Segment { from_w, to_w } = *segment;
    let count = ((to_w - from_w).norm() / piece_m).ceil().max(1.0);
    // Both neighbours work out a shared end in the same way: no crack.
    let at = move |index: f64| if index >= count { to_w } else { from_w + (to_w - from_w) * (index / count) };
    (0..count as usize).map(move |index| Segment { from_w: at(index as f64), to_w: at(index as f64 + 1.0) })
}
