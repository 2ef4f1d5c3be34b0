//! One run of a peer, measured in continuous time.
//!
//! Everybody moves along straight lines at constant speed and arrives at the period's end. Gaps between two robots are
//! those of relative motion, which is straight as well: a closed form. Gaps to walls are those between segments and
//! capsules. Whether the swarm hangs together is asked at every instant, not only at the ends of periods.

use super::links::{connected_throughout, lambda2, pairs};
use super::{ARRIVED_M, Peer, Scene};
use drover_contract::Vec2;
use drover_core::avoid::Capsule;

/// How a run went.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct PeerRun {
    /// At every instant.
    pub(crate) connected_always: bool,
    /// Share of the robots within [`ARRIVED_M`] of their targets at the end.
    pub(crate) arrived_fraction: f64,
    /// Until all had arrived, or how long it was given, seconds.
    pub(crate) time_s: f64,
    /// Mean length of the robots' ways, metres.
    pub(crate) path_m_mean: f64,
    /// The least distance between two centres, metres.
    pub(crate) min_gap_robot_m: f64,
    /// The least distance of a centre to a wall, metres; infinite where there is none.
    pub(crate) min_gap_wall_m: f64,
    /// Whether anybody's way touched or crossed a wall.
    pub(crate) tunnelled: bool,
    /// The smallest algebraic connectivity at the ends of periods, links of weight 1.
    pub(crate) lambda2_min: f64,
    /// How often a robot had to stay because its problem had no solution.
    pub(crate) cannot_solve: u64,
}

/// Run `peer` from `starts_w` until all have arrived, for at most `duration_s`.
pub(crate) fn run(peer: &mut dyn Peer, scene: &Scene<'_>, starts_w: &[Vec2], duration_s: f64) -> PeerRun {
    let unsolved = peer.cannot_solve();
    let mut at_w = starts_w.to_vec();
    let mut result = PeerRun {
        connected_always: connected_throughout(&at_w, &at_w, scene.range_m),
        arrived_fraction: arrived(scene, &at_w),
        time_s: 0.0,
        path_m_mean: 0.0,
        min_gap_robot_m: f64::INFINITY,
        min_gap_wall_m: f64::INFINITY,
        tunnelled: false,
        lambda2_min: lambda2(&at_w, scene.range_m),
        cannot_solve: 0,
    };
    while result.arrived_fraction < 1.0 && result.time_s + scene.period_s <= duration_s + 1e-9 {
        let to_w = peer.round(scene, &at_w);
        measure(&mut result, scene, (&at_w, &to_w));
        at_w = to_w;
        result.time_s += scene.period_s;
        result.lambda2_min = result.lambda2_min.min(lambda2(&at_w, scene.range_m));
        result.arrived_fraction = arrived(scene, &at_w);
    }
    result.tunnelled = result.min_gap_wall_m <= 0.0;
    result.cannot_solve = peer.cannot_solve() - unsolved;
    result
}

fn arrived(scene: &Scene<'_>, at_w: &[Vec2]) -> f64 {
    let there = at_w.iter().zip(scene.targets_w).filter(|(at_w, target_w)| (*at_w - *target_w).norm() <= ARRIVED_M);
    there.count() as f64 / at_w.len() as f64
}

fn measure(result: &mut PeerRun, scene: &Scene<'_>, (from_w, to_w): (&[Vec2], &[Vec2])) {
    let ways_m = from_w.iter().zip(to_w).map(|(from_w, to_w)| (to_w - from_w).norm());
    result.path_m_mean += ways_m.sum::<f64>() / from_w.len() as f64;
    result.connected_always = result.connected_always && connected_throughout(from_w, to_w, scene.range_m);
    for (i, j) in pairs(from_w.len()) {
        let gap_m = least_m(from_w[i] - from_w[j], to_w[i] - to_w[j]);
        result.min_gap_robot_m = result.min_gap_robot_m.min(gap_m);
    }
    for (from_w, to_w) in from_w.iter().zip(to_w) {
        let gaps_m = scene.walls.iter().map(|wall| wall.clearance_m(*from_w, *to_w));
        result.min_gap_wall_m = gaps_m.fold(result.min_gap_wall_m, f64::min);
    }
}

/// The least length of a vector that goes straight from `from` to `to`.
fn least_m(from: Vec2, to: Vec2) -> f64 {
    Capsule::edge(from, to).distance_m(Vec2::zeros())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Goes straight through everything.
    struct Blind;

    impl Peer for Blind {
        fn name(&self) -> &'static str {
            "blind"
        }

        fn round(&mut self, scene: &Scene<'_>, at_w: &[Vec2]) -> Vec<Vec2> {
            at_w.iter().enumerate().map(|(robot, at_w)| at_w + scene.wish(robot, *at_w)).collect()
        }
    }

    #[test]
    fn two_that_swap_through_a_wall_are_caught_between_the_periods() {
        let wall = [Capsule::edge(Vec2::new(2.1, -0.1), Vec2::new(2.1, 1.0))];
        let targets_w = [Vec2::new(4.0, 0.0), Vec2::new(0.25, 0.2)];
        let starts_w = [Vec2::new(0.0, 0.0), Vec2::new(4.25, 0.2)];
        let scene = Scene {
            walls: &wall,
            targets_w: &targets_w,
            range_m: 7.0,
            step_m: 0.5,
            period_s: 1.0,
            robot_gap_m: 0.3,
            wall_gap_m: 0.3,
        };
        let got = run(&mut Blind, &scene, &starts_w, 20.0);
        assert!(got.tunnelled && got.min_gap_wall_m.abs() < 1e-12);
        assert!((got.min_gap_robot_m - 0.2).abs() < 1e-9, "{}", got.min_gap_robot_m);
        assert!((got.time_s - 8.0).abs() < 1e-9 && (got.path_m_mean - 4.0).abs() < 1e-9);
        assert!(got.connected_always && got.cannot_solve == 0 && got.arrived_fraction >= 1.0);
    }
}
