//! What lidars see of the walls: pieces in square tiles, ready to be drawn into a depth buffer.
//!
//! Long walls are cut into pieces no longer than a tile, each piece belongs to the tile that holds its middle, and a
//! tile keeps its pieces relative to its own centre, as f32 in lanes. A scan touches the tiles within its range and
//! nothing else; how large the place is does not matter. Of a tile's pieces it picks those that face the sensor within
//! its range, a few operations each, and only these are turned, given angles and drawn.

use crate::depth::DepthBuffer;
use crate::geometry::{Disc, Segment};
use crate::lanes::{LANES, Lanes};
use drover_contract::{Pose, Vec2};

/// Pieces a tile, on average, where there are many.
const PIECES_PER_TILE: f64 = 24.0;
/// Sides of tiles, metres.
const TILE_M_MIN: f64 = 2.0;
const TILE_M_MAX: f64 = 16.0;
/// Pieces that are drawn together, and the tiles that they come from, at most.
const PICKS: usize = 64;
const PICK_TILES: usize = 32;
/// Corners of walls, sensors and tiles' centres lie on a grid of this pitch, 1 µm: differences of up to 16 m are then
/// exact in f32, and pieces that share a corner see it in the same direction, whichever tiles they belong to.
const GRID_M: f64 = 1.0 / 1_048_576.0;
/// Where tiles begin and their sides are multiples of this many pitches.
const TILE_GRID_M: f64 = 1_024.0 * GRID_M;
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

/// Pieces relative to their tile's centre, from a to b, and half of their lengths, metres.
#[derive(Clone, Copy, Debug, Default)]
struct WallLanes {
    ax: Lanes,
    ay: Lanes,
    bx: Lanes,
    by: Lanes,
    half: Lanes,
}

impl WallLanes {
    /// Which pieces face a sensor at `(x, y)` within `range_m`: a bit a lane.
    #[inline]
    fn facing(&self, [x, y]: [f32; 2], range_m: f32) -> u32 {
        let (ax, ay) = (self.ax - Lanes::all(x), self.ay - Lanes::all(y));
        let (ex, ey) = (self.bx - self.ax, self.by - self.ay);
        let (mx, my) = (ax + ex * 0.5, ay + ey * 0.5);
        let reach = Lanes::all(range_m) + self.half;
        (mx * mx + my * my).less_bits(reach * reach) & (ay * ex).less_bits(ax * ey)
    }
}

/// Pieces that face the sensor, on their way into the buffer: most pieces are sorted out before anything costly is done
/// to them, and what is left fills its lanes.
struct Picks {
    turn: Turn,
    count: usize,
    /// The piece (its lanes' index times [`LANES`] plus its lane), and the number of its tile's sensor.
    pieces: [(u32, u32); PICKS],
    /// Where the sensor is relative to each tile's centre.
    sensors: [[f32; 2]; PICK_TILES],
    tiles: usize,
}

/// Discs relative to their tile's centre, metres.
#[derive(Clone, Copy, Debug, Default)]
struct DiscLanes {
    px: Lanes,
    py: Lanes,
    radius: Lanes,
}

/// A turn in f32: what takes a place relative to the sensor, world axes, into the sensor's frame.
#[derive(Clone, Copy, Debug)]
struct Turn {
    cos: f32,
    sin: f32,
}

impl Turn {
    #[inline]
    fn turned(self, [x, y]: [Lanes; 2]) -> [Lanes; 2] {
        [x * self.cos + y * self.sin, y * self.cos - x * self.sin]
    }
}

impl Picks {
    fn new(turn: Turn) -> Self {
        Self { turn, count: 0, pieces: [(0, 0); PICKS], sensors: [[0.0; 2]; PICK_TILES], tiles: 0 }
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
        let low_w = low_w.map(|along| (along / TILE_GRID_M).floor() * TILE_GRID_M);
        let extent = (high_w - low_w).map(|along| if along.is_finite() { along.max(1.0) } else { 1.0 });
        let count = (segments.len() + discs.len()).max(1) as f64;
        let wished_m = (extent.x * extent.y * PIECES_PER_TILE / count).sqrt().clamp(TILE_M_MIN, TILE_M_MAX);
        let tile_m = wished_m.max((extent.x * extent.y / TILES_MAX).sqrt());
        let tile_m = (tile_m / TILE_GRID_M).ceil() * TILE_GRID_M;
        let (columns, rows) = ((extent.x / tile_m) as usize + 1, (extent.y / tile_m) as usize + 1);
        let tiles = vec![Tile::default(); columns * rows];
        let disc_radius_m_max = discs.iter().map(|disc| disc.radius_m).fold(0.0, f64::max);
        Self { low_w, tile_m, columns, rows, tiles, walls: Vec::new(), discs: Vec::new(), disc_radius_m_max }
    }

    /// Draw all that a sensor at `pose_ws` (world frame) may see.
    pub(crate) fn draw(&self, pose_ws: Pose, depth: &mut DepthBuffer) {
        let (origin_w, heading) = (on_grid(pose_ws.position()), pose_ws.heading());
        let turn = Turn { cos: heading.x as f32, sin: heading.y as f32 };
        // A thing lies up to half a tile outside of its own tile (a disc: up to its radius, which widens its box).
        let reach_m = f64::from(depth.range_m()) + self.tile_m / 2.0 + self.disc_radius_m_max;
        let (left, low) = self.column_row(origin_w - Vec2::repeat(reach_m));
        let (right, high) = self.column_row(origin_w + Vec2::repeat(reach_m));
        let mut picks = Picks::new(turn);
        for row in low..=high {
            for column in left..=right {
                let tile = &self.tiles[row * self.columns + column];
                let place = origin_w - self.centre_w(column, row);
                let sensor = [place.x as f32, place.y as f32];
                if tile.distance2_m2(sensor) > depth.range_m() * depth.range_m() {
                    continue;
                }
                self.pick(tile, sensor, &mut picks, depth);
                for lanes in &self.discs[tile.discs.0 as usize..tile.discs.1 as usize] {
                    let [x, y] = sensor.map(Lanes::all);
                    depth.draw_discs(turn.turned([lanes.px - x, lanes.py - y]), lanes.radius);
                }
            }
        }
        self.draw_picks(&mut picks, depth);
    }

    /// Pick a tile's pieces that face the sensor; what was picked is drawn when there is no more room.
    #[inline]
    fn pick(&self, tile: &Tile, sensor: [f32; 2], picks: &mut Picks, depth: &mut DepthBuffer) {
        if picks.tiles == PICK_TILES {
            self.draw_picks(picks, depth);
        }
        picks.sensors[picks.tiles] = sensor;
        picks.tiles += 1;
        for index in tile.walls.0..tile.walls.1 {
            if picks.count > PICKS - LANES {
                self.draw_picks(picks, depth);
                picks.sensors[0] = sensor;
                picks.tiles = 1;
            }
            let seen = self.walls[index as usize].facing(sensor, depth.range_m());
            for i in 0..LANES {
                // Written in any case and kept if it is seen: no branch that nothing could foresee.
                picks.pieces[picks.count % PICKS] = (index * LANES as u32 + i as u32, picks.tiles as u32 - 1);
                picks.count += (seen >> i & 1) as usize;
            }
        }
    }

    /// Draw what was picked, and forget it.
    #[inline(never)]
    fn draw_picks(&self, picks: &mut Picks, depth: &mut DepthBuffer) {
        let [mut ax, mut ay, mut bx, mut by] = [[Lanes::default(); PICKS / LANES]; 4];
        for (k, (piece, tile)) in picks.pieces[..picks.count].iter().enumerate() {
            let (lanes, i) = (&self.walls[*piece as usize / LANES], *piece as usize % LANES);
            let [x, y] = picks.sensors[*tile as usize % PICK_TILES];
            let (at, k) = (k / LANES, k % LANES);
            (ax[at].each_mut()[k], ay[at].each_mut()[k]) = (lanes.ax.each()[i] - x, lanes.ay.each()[i] - y);
            (bx[at].each_mut()[k], by[at].each_mut()[k]) = (lanes.bx.each()[i] - x, lanes.by.each()[i] - y);
        }
        for k in 0..picks.count.div_ceil(LANES) {
            depth.draw_walls(picks.turn.turned([ax[k], ay[k]]), picks.turn.turned([bx[k], by[k]]));
        }
        (picks.count, picks.tiles) = (0, 0);
    }

    /// Heap bytes held.
    pub(crate) fn bytes(&self) -> usize {
        self.tiles.capacity() * size_of::<Tile>()
            + self.walls.capacity() * size_of::<WallLanes>()
            + self.discs.capacity() * size_of::<DiscLanes>()
    }

    fn add_walls<'s>(&mut self, tile: usize, pieces: impl Iterator<Item = &'s Segment>) {
        let centre_w = self.centre_w(tile % self.columns, tile / self.columns);
        let first = self.walls.len() as u32;
        for (index, piece) in pieces.enumerate() {
            if index % LANES == 0 {
                self.walls.push(WallLanes::default());
            }
            let (from, to) = (on_grid(piece.from_w) - centre_w, on_grid(piece.to_w) - centre_w);
            self.tiles[tile].hold(from, 0.0);
            self.tiles[tile].hold(to, 0.0);
            if let Some(lanes) = self.walls.last_mut() {
                let i = index % LANES;
                (lanes.ax.each_mut()[i], lanes.ay.each_mut()[i]) = (from.x as f32, from.y as f32);
                (lanes.bx.each_mut()[i], lanes.by.each_mut()[i]) = (to.x as f32, to.y as f32);
                lanes.half.each_mut()[i] = (from - to).norm() as f32 / 2.0;
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
                (lanes.px.each_mut()[i], lanes.py.each_mut()[i]) = (place.x as f32, place.y as f32);
                lanes.radius.each_mut()[i] = disc.radius_m as f32;
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
    fn hold(&mut self, place: Vec2, margin_m: f64) {
        for axis in 0..2 {
            self.low[axis] = self.low[axis].min((place[axis] - margin_m) as f32);
            self.high[axis] = self.high[axis].max((place[axis] + margin_m) as f32);
        }
    }

    /// Square of how far the box is from a place relative to the tile's centre, square metres; infinite if it is empty.
    #[inline]
    fn distance2_m2(&self, place: [f32; 2]) -> f32 {
        let apart = |axis: usize| (self.low[axis] - place[axis]).max(place[axis] - self.high[axis]).max(0.0);
        apart(0) * apart(0) + apart(1) * apart(1)
    }
}

fn on_grid(place_w: Vec2) -> Vec2 {
    place_w.map(|along| (along / GRID_M).round() * GRID_M)
}

/// A wall in equal pieces no longer than `piece_m`.
fn cut(segment: &Segment, piece_m: f64) -> impl Iterator<Item = Segment> + use<> {
    let Segment { from_w, to_w } = *segment;
    let count = ((to_w - from_w).norm() / piece_m).ceil().max(1.0);
    // Both neighbours work out a shared end in the same way: no crack.
    let at = move |index: f64| if index >= count { to_w } else { from_w + (to_w - from_w) * (index / count) };
    (0..count as usize).map(move |index| Segment { from_w: at(index as f64), to_w: at(index as f64 + 1.0) })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_wall_in_many_tiles_has_no_cracks() {
        let corners = [Vec2::new(-70.0, -31.3), Vec2::new(50.1, -45.7), Vec2::new(61.7, 40.9), Vec2::new(-55.5, 39.1)];
        let next = |i: usize| corners[(i + 1) % 4];
        let walls: Vec<Segment> = (0..4).map(|i| Segment { from_w: corners[i], to_w: next(i) }).collect();
        let sight = Sight::new(&walls, &[]);
        let mut depth = DepthBuffer::new(3_600, 0.0, std::f64::consts::TAU / 3_600.0, 200.0);
        for step in 0..200 {
            // Along the first wall, a centimetre away from it.
            let along = (corners[1] - corners[0]).normalize();
            let place = corners[0] + along * (1.0 + 0.5903 * f64::from(step)) + Vec2::new(-along.y, along.x) * 0.01;
            depth.clear();
            sight.draw(Pose::new(place.x, place.y, f64::from(step)), &mut depth);
            let leaks = depth.ranges().iter().filter(|range_m| range_m.is_infinite()).count();
            assert_eq!(leaks, 0, "at {place}");
        }
    }
}
