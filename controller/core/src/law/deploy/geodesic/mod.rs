//! Shortest ways on a known map, for points that keep a distance from walls: what leads robots out of concave pockets.
//!
//! **In**: walls as capsules, the corners of a box with all starts and targets (world frame, metres), the distance to
//! keep, the side of a cell. **Out**: for a target a [`Field`], which gives the length of the shortest way from any
//! place and the farthest point on it that can be reached straight; for two places that are near one another a way.
//!
//! **Idea**: free cells carry the wave that finds the ways; what is allowed is decided by exact distances between
//! segments. Every leg of a way, from place to place and not from cell to cell, keeps the distance. Legs turn near
//! corners only, in any direction, and a string is pulled over the turns before one is told where to go.
//!
//! | file | what |
//! |---|---|
//! | [`grid`] | cells, the walls that are near each, the box around a search |
//! | [`sight`] | whether a straight way keeps the distance |
//! | [`wave`] | from a target outwards: which turning point each cell sees |
//! | [`field`] | from any place inwards: length, next place to go to |
//!
//! **What is found**: every way that has 0.71 of a cell more room on both sides than is to be kept, and every straight
//! door that is as wide as twice that distance and one cell; narrower ones at times. Nothing leads through a wall,
//! however thin, since passing from cell to cell is judged by geometry too. Ways of different kinds (left or right of a
//! wall) that differ by less than the error below may be taken for one another. One may walk around the outermost walls
//! unless they are closed.
//!
//! **Source**: [`wave`] for the search; string pulling as in every navigation mesh.
//!
//! **Accuracy** (0.25 m cells, 0.3 m kept, against visibility graphs with arcs around the ends of walls): lengths are
//! never too short, 0.01 to 0.2 % too long in the mean, 1.6 % at most. Who follows the aim and remembers it never goes
//! farther than the length said; who forgets it each time, 1 % at most, and in gaps narrower than those above might
//! turn back. Cells of 0.5 m: 0.3 % in the mean, 3.3 % at most.
//!
//! **Cost**: the map 3 to 10 ms for 80 m x 60 m; a field 10 to 20 ms and 4 bytes a cell (0.3 MB); [`Field::aim`] 1 to 5
//! us, [`Geodesic::clear`] 0.1 to 0.3 us, [`Geodesic::way`] of up to 12 m 2 to 20 us. More than four million cells are
//! not made: they become larger instead ([`Geodesic::cell_m`]).
//!
//! **Cannot solve**: `None` where no way is known: behind walls without a gap, and to a target that stands in a disc or
//! nearer than a millimetre to a wall. A robot that is nearer to a wall than it should be is led away from it, and a
//! target that is too near to one is approached, no wall nearer than the closer end is; a robot deep in a crack that is
//! too narrow (more than three cells from where it widens) gets `None`.

mod field;
mod grid;
mod sight;
mod wave;

#[cfg(test)]
mod testing;
#[cfg(test)]
mod tests;

pub use field::{Aim, Field};

use crate::avoid::Capsule;
use drover_contract::Vec2;
use grid::{Grid, NEIGHBOURS, Patch};
use sight::Sight;
use wave::Aimed;

/// Side of a cell unless there is a reason for another, metres: doors of 0.85 m are open to robots that keep 0.3 m.
pub const CELL_M: f64 = 0.25;
/// Planned ways keep this much more than is asked for, metres: who is off one by rounding keeps the distance.
const SPARE_M: f64 = 1e-6;
/// Lengths that differ by less are the same, metres.
const SLACK_M: f64 = 1e-9;
/// Less is not kept, metres: a way along a wall must differ from one through it.
const KEEP_M_MIN: f64 = 1e-3;
/// More is not kept and larger cells are not asked for, metres; smaller cells neither.
const LENGTH_M_MAX: f64 = 1e3;
const CELL_M_MIN: f64 = 1e-2;
/// Beyond the distance to keep, cells are looked for this far around a place that sees none nearer.
const RINGS: usize = 3;

/// A map of walls on which ways are looked for.
#[derive(Clone, Debug)]
pub struct Geodesic {
    sight: Sight,
    /// For each cell, to which neighbours one may pass.
    moves: Vec<u8>,
    /// What the caller wants to be kept, metres.
    asked_m: f64,
    /// What planned ways keep, metres.
    keep_m: f64,
    /// Whether cells are small enough for a quadrangle of neighbours to hide no wall ([`wave`]).
    thin: bool,
    /// How far around a place cells are looked for.
    rings: usize,
    /// To the eight neighbours of a cell.
    steps: [Vec2; 8],
}

impl Geodesic {
    /// The map of `walls`. `bounds_w`: two opposite corners of a box with all starts and targets; walls may stand
    /// outside. Cells of [`CELL_M`] are a good choice; less than twice `keep_m` makes the search fast. Walls and
    /// corners that are not finite are no walls and no corners.
    #[must_use]
    pub fn new(walls: &[Capsule], bounds_w: (Vec2, Vec2), keep_m: f64, cell_m: f64) -> Self {
        let asked_m = within(keep_m, KEEP_M_MIN);
        let keep_m = asked_m + SPARE_M;
        let walls: Vec<Capsule> = walls.iter().filter(|wall| is_finite(wall)).copied().collect();
        let (low_w, high_w) = hull(&walls, bounds_w);
        let sight = Sight::new(Grid::over(low_w, high_w, keep_m, within(cell_m, CELL_M_MIN)), walls, keep_m);
        let cell_m = sight.grid.cell_m;
        Self {
            moves: sight.moves(),
            sight,
            asked_m,
            keep_m,
            thin: keep_m > cell_m / 2.0,
            rings: (keep_m / cell_m).ceil() as usize + RINGS,
            steps: NEIGHBOURS.map(|(right, up)| Vec2::new(right as f64, up as f64) * cell_m),
        }
    }

    /// Side of a cell, metres: what was asked for, or more if there would have been too many.
    #[must_use]
    pub fn cell_m(&self) -> f64 {
        self.sight.grid.cell_m
    }

    /// Whether the straight way keeps the distance from all walls: exact.
    #[must_use]
    pub fn clear(&self, from_w: Vec2, to_w: Vec2) -> bool {
        self.sight.clear(from_w, to_w, self.asked_m)
    }

    /// The shortest ways to a target from everywhere.
    #[must_use]
    pub fn field(&self, target_w: Vec2) -> Field {
        Field::new(self, self.sight.grid.whole(), target_w, None)
    }

    /// A shortest way between two places that is at most so long, from turn to turn, both ends included. Its cost grows
    /// with the square of the length that is allowed, not with the map.
    #[must_use]
    pub fn way(&self, from_w: Vec2, to_w: Vec2, length_m_max: f64) -> Option<Vec<Vec2>> {
        if (to_w - from_w).norm() > length_m_max {
            return None;
        }
        if self.reachable(to_w) && self.passes(from_w, to_w) {
            return Some(vec![from_w, to_w]);
        }
        // From cell to cell a way may be a little longer than when its string is pulled.
        let length_m_max_of_cells = length_m_max + 2.0 * self.cell_m();
        let (middle_w, half) = ((from_w + to_w) / 2.0, Vec2::repeat(length_m_max_of_cells / 2.0));
        let patch = self.sight.grid.patch(middle_w - half, middle_w + half);
        let aimed = Aimed { from_w, length_m_max: length_m_max_of_cells };
        let way_w = Field::new(self, patch, to_w, Some(aimed)).way_w(self, from_w)?;
        let length_m: f64 = way_w.windows(2).map(|leg| (leg[1] - leg[0]).norm()).sum();
        (length_m <= length_m_max).then_some(way_w)
    }

    /// Whether a planned leg may lead along here.
    fn keeps(&self, from_w: Vec2, to_w: Vec2) -> bool {
        self.sight.clear(from_w, to_w, self.keep_m)
    }

    /// Whether a robot may go this way: with the distance, or with less where an end has less already.
    fn passes(&self, from_w: Vec2, to_w: Vec2) -> bool {
        self.sight.passes(from_w, to_w, self.keep_m)
    }

    /// Whether it may go the rest of a way that it was allowed to go: rounding aside.
    fn still_passes(&self, from_w: Vec2, to_w: Vec2) -> bool {
        self.sight.passes(from_w, to_w, self.keep_m - SPARE_M / 2.0)
    }

    /// Whether a target stands free at all.
    fn reachable(&self, target_w: Vec2) -> bool {
        self.sight.room_m(target_w) >= KEEP_M_MIN
    }

    /// Cells of the patch around a place that can be reached from it straight: of the nearest ring with such cells, and
    /// of the next.
    fn cells_seen(&self, patch: Patch, at_w: Vec2) -> Vec<usize> {
        let mut seen = Vec::new();
        let around = self.sight.grid.place_of(at_w);
        for ring in 0..=self.rings {
            let last = !seen.is_empty();
            seen.extend(patch.ring(around, ring).filter(|cell| {
                let (column, row) = patch.place_of(*cell);
                let passable = self.moves[row * self.sight.grid.columns + column] != 0;
                passable && self.passes(at_w, self.sight.grid.centre_w(column, row))
            }));
            if last {
                break;
            }
        }
        seen
    }
}

/// A length that can be worked with.
fn within(length_m: f64, length_m_min: f64) -> f64 {
    if length_m.is_nan() { length_m_min } else { length_m.clamp(length_m_min, LENGTH_M_MAX) }
}

fn is_finite(wall: &Capsule) -> bool {
    (wall.a_w.norm() + wall.b_w.norm() + wall.radius_m).is_finite()
}

/// South-west and north-east corner of a box around walls and the corners of another box.
fn hull(walls: &[Capsule], bounds_w: (Vec2, Vec2)) -> (Vec2, Vec2) {
    let corners = [bounds_w.0, bounds_w.1].map(|corner_w| Capsule::disc(corner_w, 0.0));
    let ends = corners.iter().filter(|corner| is_finite(corner)).chain(walls).flat_map(|wall| {
        let radius = Vec2::repeat(wall.radius_m);
        [wall.a_w - radius, wall.a_w + radius, wall.b_w - radius, wall.b_w + radius]
    });
    ends.map(|at_w| (at_w, at_w))
        .reduce(|(low_w, high_w), (at_w, _)| (low_w.inf(&at_w), high_w.sup(&at_w)))
        .unwrap_or_else(|| (Vec2::zeros(), Vec2::zeros()))
}
