//! Velocities that walls and peers leave open: half-planes, and the one nearest to a wish.
//!
//! A wall at distance r in direction n may be approached no faster than (r - keep) / tau: the robot slides along it and
//! comes to rest in front of it without a force that would close every door. Of the gap to a peer each may use half (a
//! buffered Voronoi cell, as velocities); who has to give way keeps a gap of its own and backs off when it is less.

use drover_contract::Vec2;

/// v.n <= most.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Plane {
    pub(super) normal_w: Vec2,
    pub(super) most_mps: f64,
}

/// Planes are few: the walls' nearest places and the peers around.
pub(super) const PLANES_MAX: usize = 24;
/// Rounding, m/s.
const ROUNDING_MPS: f64 = 1e-9;

/// Half-planes, the tightest first come; what is beyond the room for them is left to the last layer.
#[derive(Clone, Copy, Debug)]
pub(super) struct Planes {
    all: [Plane; PLANES_MAX],
    count: usize,
}

impl Default for Planes {
    fn default() -> Self {
        Self { all: [Plane { normal_w: Vec2::zeros(), most_mps: 0.0 }; PLANES_MAX], count: 0 }
    }
}

impl Planes {
    pub(super) fn push(&mut self, plane: Plane) {
        if self.count < PLANES_MAX {
            self.all[self.count] = plane;
            self.count += 1;
        } else if let Some(loosest) = self.all.iter_mut().max_by(|a, b| a.most_mps.total_cmp(&b.most_mps))
            && plane.most_mps < loosest.most_mps
        {
            *loosest = plane;
        }
    }

    pub(super) fn as_slice(&self) -> &[Plane] {
        &self.all[..self.count]
    }

    /// The allowed velocity nearest to `wish`, of the candidates a plane program has: the wish, its foot on each
    /// border, the corners. Where nothing is allowed, who has to back off need not, and standing is allowed.
    pub(super) fn nearest(&self, wish: Vec2) -> Vec2 {
        let planes = self.as_slice();
        if let Some(best) = nearest_of(planes, wish) {
            return best;
        }
        let mut relaxed = *self;
        relaxed.all.iter_mut().for_each(|plane| plane.most_mps = plane.most_mps.max(0.0));
        nearest_of(relaxed.as_slice(), wish).unwrap_or_else(Vec2::zeros)
    }
}

fn allowed(planes: &[Plane], v: Vec2) -> bool {
    planes.iter().all(|plane| v.dot(&plane.normal_w) <= plane.most_mps + ROUNDING_MPS)
}

fn nearest_of(planes: &[Plane], wish: Vec2) -> Option<Vec2> {
    if allowed(planes, wish) {
        return Some(wish);
    }
    let mut best: Option<Vec2> = None;
    let mut consider = |v: Vec2| {
        let nearer = best.is_none_or(|best| (v - wish).norm_squared() < (best - wish).norm_squared());
        if nearer && allowed(planes, v) {
            best = Some(v);
        }
    };
    for (at, plane) in planes.iter().enumerate() {
        consider(wish - plane.normal_w * (wish.dot(&plane.normal_w) - plane.most_mps));
        for other in &planes[at + 1..] {
            let cross = plane.normal_w.perp(&other.normal_w);
            if cross.abs() > 1e-9 {
                let (a, b) = (plane, other);
                let x = (a.most_mps * b.normal_w.y - b.most_mps * a.normal_w.y) / cross;
                let y = (b.most_mps * a.normal_w.x - a.most_mps * b.normal_w.x) / cross;
                consider(Vec2::new(x, y));
            }
        }
    }
    best
}
