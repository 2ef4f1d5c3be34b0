//! A controller by the gradient of algebraic connectivity: the swarm holds together as a whole, not link by link.
//!
//! **In**: the snapshot of positions (world frame, metres) and the scene. **Out**: the ends of straight moves, metres.
//! Each robot moves with
//!
//! ```text
//! u = u_goal + gain csch^2(lambda2 - lambda_min) d lambda2 / d x + push of robots + push of walls,   |u| <= v_max,
//! d lambda2 / d x_i = sum_j -a_ij / sigma^2 (v_i - v_j)^2 (x_i - x_j),   a_ij = exp(-d^2 / 2 sigma^2), d <= r_c
//! ```
//!
//! where `lambda2` is the second smallest eigenvalue of the weighted graph's Laplacian, `v` its unit eigenvector.
//!
//! **Idea**: `lambda2 > 0` if and only if the graph is connected. The energy `coth(lambda2 - lambda_min)` grows without
//! bound as `lambda2` falls to `lambda_min`, so that its gradient outweighs any goal before the network breaks, and
//! asks for little while it is far from breaking. Links may come and go. Robots and the nearest wall repel by the
//! gradient of `(1/d - 1/reach)^2 / 2`; towards walls `d` is what is left beyond the gap to keep.
//!
//! **Source**: L. Sabattini, N. Chopra, C. Secchi, "Decentralized connectivity maintenance for cooperative control of
//! mobile robotic systems", Int. J. Robotics Research 32(12), 2013; L. Sabattini, C. Secchi, N. Chopra, A. Gasparri,
//! "Distributed control of multirobot systems with global connectivity maintenance", IEEE Trans. Robotics 29(5), 2013;
//! a bounded goal and obstacles beside it: P. Robuffo Giordano et al., Int. J. Robotics Research 32(3), 2013.
//!
//! **Departures, all in its favour**: `lambda2` and `v` are exact and everybody's, where theirs come from a distributed
//! estimator that lags. The law is one of continuous time and the period is 1 s, so it is integrated in `parts` steps
//! over the period with everybody's motion known, and where that ends is where the robots go. When stuck it makes
//! detours (`detour.rs`). **Against it**: speed is bounded, as that of robots is; the papers' proof assumes that it is
//! not.
//!
//! **Tuned** on this bench's scenes and on random fields, about 450 settings of all that stands in `FiedlerParams`,
//! and of a swirl along walls, which did no better beside detours and went. (Without detours, a swirl always to the
//! left arrived in the 9 runs it was tried in, at the price of time.)
//!
//! **Cost**: an eigenvalue problem of n x n for each part of a period. **When it cannot solve**: it always can; it just
//! does not promise links, gaps or walls in sampled time, and is measured for them.

use super::detour::{Detour, DetourParams};
use super::{Peer, Scene, links, shortened};
use drover_contract::Vec2;
use drover_contract::math::exp;
use nalgebra::{DMatrix, DVector};

/// `lambda2` is held this far above its limit, so that the energy stays finite when it was passed.
const ABOVE_LIMIT_MIN: f64 = 1e-6;
/// A gap is taken to be no less, metres, so that a repulsion stays finite.
const GAP_M_MIN: f64 = 0.01;
/// Closer than this two places have no direction between them, metres.
const APART_M_MIN: f64 = 1e-12;

/// What can be tuned.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct FiedlerParams {
    /// How fast a link's weight falls with its length, metres.
    pub(crate) sigma_m: f64,
    /// The limit that `lambda2` is to stay above.
    pub(crate) lambda_min: f64,
    /// Of the connectivity term, m^2/s.
    pub(crate) gain: f64,
    /// Of the repulsion, m^4/s; from robots and from walls.
    pub(crate) repulsion: (f64, f64),
    /// Robots that are nearer than this repel; walls, where less than this is left beyond the gap to keep; metres.
    pub(crate) reach_m: (f64, f64),
    /// Steps of the integration over one period.
    pub(crate) parts: u32,
    /// The remedy against deadlock.
    pub(crate) detour: DetourParams,
}

/// The peer.
#[derive(Clone, Debug)]
pub(crate) struct Fiedler {
    params: FiedlerParams,
    detours: Vec<Detour>,
}

impl Default for Fiedler {
    fn default() -> Self {
        Self::new(FiedlerParams::default())
    }
}

impl Default for FiedlerParams {
    fn default() -> Self {
        Self {
            sigma_m: 1.95,
            lambda_min: 2e-4,
            gain: 0.01,
            repulsion: (0.08, 0.004),
            reach_m: (1.7, 1.15),
            parts: 10,
            detour: DetourParams::default(),
        }
    }
}

/// The graph's second smallest eigenvalue and its eigenvector of length 1.
struct Connectivity {
    lambda2: f64,
    vector: DVector<f64>,
    sigma_m: f64,
    range_m: f64,
}

impl Connectivity {
    fn of(at_w: &[Vec2], sigma_m: f64, range_m: f64) -> Self {
        let robots = at_w.len();
        let mut laplacian = DMatrix::zeros(robots, robots);
        for (i, j) in links::pairs(robots) {
            let weight = weight(at_w[i] - at_w[j], sigma_m, range_m);
            laplacian[(i, j)] = -weight;
            laplacian[(j, i)] = -weight;
            laplacian[(i, i)] += weight;
            laplacian[(j, j)] += weight;
        }
        let eigen = laplacian.symmetric_eigen();
        let mut order: Vec<usize> = (0..robots).collect();
        order.sort_by(|one, other| eigen.eigenvalues[*one].total_cmp(&eigen.eigenvalues[*other]));
        let second = order[1.min(robots - 1)];
        let vector = eigen.eigenvectors.column(second).into_owned();
        Self { lambda2: eigen.eigenvalues[second], vector, sigma_m, range_m }
    }

    /// How `lambda2` changes with everybody's position, 1/m.
    fn gradient(&self, at_w: &[Vec2]) -> Vec<Vec2> {
        let mut gradient = vec![Vec2::zeros(); at_w.len()];
        for (i, j) in links::pairs(at_w.len()) {
            let apart = at_w[i] - at_w[j];
            let difference = self.vector[i] - self.vector[j];
            let slope = weight(apart, self.sigma_m, self.range_m) / (self.sigma_m * self.sigma_m);
            let share = apart * (-slope * difference * difference);
            gradient[i] += share;
            gradient[j] -= share;
        }
        gradient
    }
}

/// What a link of two robots is worth.
fn weight(apart: Vec2, sigma_m: f64, range_m: f64) -> f64 {
    let square = apart.norm_squared();
    if square > range_m * range_m { 0.0 } else { exp(-square / (2.0 * sigma_m * sigma_m)) }
}

/// The slope of `-coth`.
fn csch2(x: f64) -> f64 {
    let sinh = (exp(x) - exp(-x)) / 2.0;
    1.0 / (sinh * sinh)
}

/// How strongly something at `gap_m` repels, m/s.
fn repulsion(gain: f64, gap_m: f64, reach_m: f64) -> f64 {
    let gap_m = gap_m.max(GAP_M_MIN);
    if gap_m >= reach_m { 0.0 } else { gain * (1.0 / gap_m - 1.0 / reach_m) / (gap_m * gap_m) }
}

impl Fiedler {
    /// One that has seen nothing yet.
    #[must_use]
    pub(crate) fn new(params: FiedlerParams) -> Self {
        Self { params, detours: Vec::new() }
    }

    fn velocities(&self, scene: &Scene<'_>, at_w: &[Vec2], goals_w: &[Vec2]) -> Vec<Vec2> {
        let FiedlerParams { sigma_m, lambda_min, gain, .. } = self.params;
        let connectivity = Connectivity::of(at_w, sigma_m, scene.range_m);
        let pull = gain * csch2((connectivity.lambda2 - lambda_min).max(ABOVE_LIMIT_MIN));
        let speed_mps_max = scene.step_m / scene.period_s;
        let gradient = connectivity.gradient(at_w);
        let one = |(robot, slope): (usize, &Vec2)| {
            let goal = shortened((goals_w[robot] - at_w[robot]) / scene.period_s, speed_mps_max);
            let away = self.push_of_robots(at_w, robot) + self.push_of_walls(scene, at_w[robot]);
            shortened(goal + slope * pull + away, speed_mps_max)
        };
        gradient.iter().enumerate().map(one).collect()
    }

    fn push_of_robots(&self, at_w: &[Vec2], robot: usize) -> Vec2 {
        let others = at_w.iter().map(|peer_w| at_w[robot] - peer_w);
        let directions = others.filter_map(|apart| Some((apart.try_normalize(APART_M_MIN)?, apart.norm())));
        directions.map(|(away, gap_m)| away * repulsion(self.params.repulsion.0, gap_m, self.params.reach_m.0)).sum()
    }

    /// Of walls the nearest alone repels.
    fn push_of_walls(&self, scene: &Scene<'_>, at_w: Vec2) -> Vec2 {
        let walls = scene.seen(at_w).map(|wall| (wall.distance_m(at_w) - scene.wall_gap_m, wall.nearest_w(at_w)));
        let nearest = walls.min_by(|one, other| one.0.total_cmp(&other.0));
        let push = nearest.and_then(|(gap_m, nearest_w)| {
            let away = (at_w - nearest_w).try_normalize(APART_M_MIN)?;
            Some(away * repulsion(self.params.repulsion.1, gap_m, self.params.reach_m.1))
        });
        push.unwrap_or_else(Vec2::zeros)
    }
}

impl Peer for Fiedler {
    fn name(&self) -> &'static str {
        if self.params.detour == DetourParams::NONE { "fiedler without detours" } else { "fiedler" }
    }

    fn round(&mut self, scene: &Scene<'_>, at_w: &[Vec2]) -> Vec<Vec2> {
        self.detours.resize(at_w.len(), Detour::new());
        let robots = self.detours.iter_mut().zip(at_w).enumerate();
        let wish = |(robot, (detour, at_w)): (usize, (&mut Detour, &Vec2))| {
            // A wish of full length goes on beyond the period's end: the goal is not to slow the last parts down.
            let wish = detour.wish(&self.params.detour, scene, (robot, *at_w));
            let whole = wish.norm() > scene.step_m * (1.0 - 1e-9);
            at_w + if whole { wish * 2.0 } else { wish }
        };
        let goals_w: Vec<Vec2> = robots.map(wish).collect();
        let mut ends_w = at_w.to_vec();
        for _ in 0..self.params.parts {
            let velocities = self.velocities(scene, &ends_w, &goals_w);
            let part_s = scene.period_s / f64::from(self.params.parts);
            ends_w.iter_mut().zip(velocities).for_each(|(end_w, velocity)| *end_w += velocity * part_s);
        }
        ends_w
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{Rng, SeedableRng};
    use rand_pcg::Pcg64Mcg;

    #[test]
    fn the_gradient_is_that_of_finite_differences() {
        const SIGMA_M: f64 = 2.0;
        const DELTA_M: f64 = 1e-5;
        let mut rng = Pcg64Mcg::seed_from_u64(11);
        for _ in 0..20 {
            // Everybody within range of everybody: no weight is cut off between the differences.
            let at_w: Vec<Vec2> =
                (0..9).map(|_| Vec2::new(rng.random_range(0.0..4.5), rng.random_range(0.0..4.5))).collect();
            let gradient = Connectivity::of(&at_w, SIGMA_M, 7.0).gradient(&at_w);
            for robot in 0..at_w.len() {
                for (axis, unit) in [Vec2::x(), Vec2::y()].into_iter().enumerate() {
                    let lambda2 = |by_m: f64| {
                        let mut moved_w = at_w.clone();
                        moved_w[robot] += unit * by_m;
                        Connectivity::of(&moved_w, SIGMA_M, 7.0).lambda2
                    };
                    let slope = (lambda2(DELTA_M) - lambda2(-DELTA_M)) / (2.0 * DELTA_M);
                    assert!((slope - gradient[robot][axis]).abs() < 1e-6, "{slope} is not {}", gradient[robot][axis]);
                }
            }
        }
    }

    #[test]
    fn a_chain_that_is_torn_has_no_connectivity() {
        let chain = |longest_m: f64| [Vec2::zeros(), Vec2::new(3.0, 0.0), Vec2::new(3.0 + longest_m, 0.0)];
        assert!(Connectivity::of(&chain(6.9), 2.0, 7.0).lambda2 > 1e-3);
        assert!(Connectivity::of(&chain(7.1), 2.0, 7.0).lambda2.abs() < 1e-12);
    }
}
