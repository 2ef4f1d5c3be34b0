//! The paper's claims where they hold and where they do not, and the safe set's promise.

use super::{Graph, Lockstep};
use crate::avoid::Capsule;
use crate::testing::deploy_config;
use drover_config::{Deploy, DeployMode};
use drover_contract::Vec2;
use drover_contract::math::{cos, sin};
use proptest::prelude::*;

const RANGE_M: f64 = 7.0;

fn v(x: f64, y: f64) -> Vec2 {
    Vec2::new(x, y)
}

fn there(at_w: &[Vec2]) -> Vec<Option<Vec2>> {
    at_w.iter().copied().map(Some).collect()
}

fn is_connected(at_w: &[Vec2]) -> bool {
    Graph::new(&there(at_w), RANGE_M + 1e-9).all().parts(|_| true) == 1
}

/// A deployment of `count` robots whose layout is far away, so that all are in stage 1.
fn far(mode: DeployMode, count: usize) -> Deploy {
    deploy_config(mode, (0..count).map(|at| [1_000.0 + 2.5 * at as f64, 0.0]).collect())
}

fn after_one_round(deploy: &Deploy, at_w: &[Vec2]) -> Vec<Vec2> {
    Lockstep::new(deploy, at_w, Vec::new()).round(&there(at_w)).ends_w
}

/// Theorem 2, case 3(c): two robots 6.99 m apart, each held back by two more on its outer side; no triangle, so nothing
/// is pruned, and every link is "infinite".
fn two_pulled_apart() -> Vec<Vec2> {
    let (i, m) = (v(0.0, 0.0), v(6.99, 0.0));
    let arm = |degrees: f64| v(cos(degrees.to_radians()), sin(degrees.to_radians())) * 6.9;
    vec![i, m, i + arm(149.0), i + arm(-149.0), m + arm(31.0), m + arm(-31.0)]
}

#[test]
fn theorem_2_fails_in_the_literal_paper_and_holds_with_the_safe_set() {
    let at_w = two_pulled_apart();
    assert!(is_connected(&at_w));
    let graph = Graph::new(&there(&at_w), RANGE_M);
    assert_eq!(graph.rng(), graph.all(), "nothing to prune");
    let literal = after_one_round(&far(DeployMode::Literal, 6), &at_w);
    assert!((literal[0] - literal[1]).norm() > 7.9, "both step apart");
    assert!(!is_connected(&literal), "and the network is split in one step");
    let safe = after_one_round(&far(DeployMode::Safe, 6), &at_w);
    assert!(is_connected(&safe));
}

/// Robots of a square layout with spacing 5 m that start anywhere in its box, linked, each with any target.
fn shuffled(seed: u64, side: usize) -> (Vec<[f64; 2]>, Vec<Vec2>) {
    let mut draw = Draw(seed);
    let count = side * side;
    let mut targets: Vec<[f64; 2]> =
        (0..count).map(|at| [5.0 * (at % side) as f64, 5.0 * (at / side) as f64]).collect();
    for at in (1..count).rev() {
        targets.swap(at, (draw.unit() * (at + 1) as f64) as usize);
    }
    // Anywhere in the box of stage 2.
    let width_m = 5.0 * (side + 1) as f64;
    let mut at_w: Vec<Vec2> = Vec::new();
    while at_w.len() < count {
        let place = v(draw.unit() * width_m - 5.0, draw.unit() * width_m - 5.0);
        let linked = at_w.is_empty() || at_w.iter().any(|other| (other - place).norm() < 6.5);
        if linked && at_w.iter().all(|other| (other - place).norm() > 1.3) {
            at_w.push(place);
        }
    }
    (targets, at_w)
}

fn parted_runs(mode: DeployMode, runs: u64) -> usize {
    let parts = |seed: &u64| {
        let (targets, mut at_w) = shuffled(*seed, 7);
        let deploy = Deploy { interval_m: 5.0, ..deploy_config(mode, targets) };
        let mut swarm = Lockstep::new(&deploy, &at_w, Vec::new());
        (0..120).any(|_| {
            at_w = swarm.round(&there(&at_w)).ends_w;
            !is_connected(&at_w)
        })
    };
    (0..runs).filter(parts).count()
}

#[test]
fn theorem_3_fails_in_the_literal_paper_and_holds_with_the_safe_set() {
    let literal = parted_runs(DeployMode::Literal, 30);
    assert!(literal >= 3, "49 robots that keep a link to somebody each: parted in {literal} of 30 runs");
    assert_eq!(parted_runs(DeployMode::Safe, 30), 0);
}

#[test]
fn trees_and_neighbourhood_graphs_nest_and_connect() {
    for seed in 0..40 {
        let (_, at_w) = shuffled(seed, 6);
        let graph = Graph::new(&there(&at_w), RANGE_M);
        let (rng, near, far) = (graph.rng(), graph.lmst(1), graph.lmst(3));
        for kept in [&rng, &near, &far] {
            assert_eq!(kept.parts(|_| true), 1);
        }
        for robot in 0..at_w.len() {
            assert!(far.of(robot).iter().all(|other| near.of(robot).contains(other)), "more hops, fewer links");
            assert!(near.of(robot).iter().all(|other| rng.of(robot).contains(other)));
            assert!(near.of(robot).len() <= 6, "a local minimum spanning tree has at most six links at a robot");
        }
    }
}

#[test]
fn a_ring_that_one_hop_cannot_open_is_opened_by_three() {
    let at_w: Vec<Vec2> = (0..8)
        .map(|at| f64::from(at) * std::f64::consts::TAU / 8.0)
        .map(|angle| v(cos(angle), sin(angle) * 1.01) * 7.5)
        .collect();
    let graph = Graph::new(&there(&at_w), RANGE_M);
    let links = |hops| (0..8).map(|robot| graph.lmst(hops).of(robot).len()).sum::<usize>() / 2;
    assert_eq!([links(1), links(4)], [8, 7]);
}

#[test]
fn a_robot_walks_through_a_wall_in_the_literal_paper_and_not_with_the_safe_set() {
    let wall = vec![Capsule::edge(v(3.0, -0.4), v(3.0, 0.4))];
    let run = |mode| {
        let mut swarm = Lockstep::new(&deploy_config(mode, vec![[60.0, 0.0]]), &[v(-9.9, 0.0)], wall.clone());
        let mut at_w = v(-9.9, 0.0);
        let mut clear_m = f64::INFINITY;
        for _ in 0..250 {
            let end_w = swarm.round(&[Some(at_w)]).ends_w[0];
            clear_m = clear_m.min(wall[0].clearance_m(at_w, end_w));
            at_w = end_w;
        }
        (clear_m, at_w)
    };
    let (clear_m, _) = run(DeployMode::Literal);
    assert!(clear_m < 0.05, "a step is longer than d_a^min: {clear_m}");
    let (clear_m, end_w) = run(DeployMode::Safe);
    assert!(clear_m >= 0.3 - 1e-9 && (end_w - v(60.0, 0.0)).norm() < 0.25, "{clear_m} {end_w}");
}

/// A small generator of its own: the same numbers on every machine.
struct Draw(u64);

impl Draw {
    fn unit(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }
}

/// Points that are linked and apart, and some walls that none of them is near to.
fn cloud(seed: u64, count: usize) -> (Vec<Vec2>, Vec<Capsule>) {
    let mut draw = Draw(seed);
    let mut at_w = vec![v(0.0, 0.0)];
    while at_w.len() < count {
        let from = at_w[(draw.unit() * at_w.len() as f64) as usize];
        let place = from + v(draw.unit() - 0.5, draw.unit() - 0.5) * 9.0;
        if (place - from).norm() < RANGE_M && at_w.iter().all(|other| (other - place).norm() > 0.31) {
            at_w.push(place);
        }
    }
    let mut walls = Vec::new();
    while walls.len() < 8 {
        let a = v(draw.unit() - 0.5, draw.unit() - 0.5) * 30.0;
        let b = a + v(draw.unit() - 0.5, draw.unit() - 0.5) * 8.0;
        let wall = Capsule { a_w: a, b_w: b, radius_m: draw.unit() };
        if at_w.iter().all(|at_w| wall.distance_m(*at_w) > 0.31) {
            walls.push(wall);
        }
    }
    (at_w, walls)
}

proptest! {
    /// Whatever the law: links, gaps and walls hold at every moment, whenever within the period each robot moves.
    #[test]
    fn no_law_can_break_what_the_safe_set_keeps(seed in 0_u64..1_000_000, count in 2_usize..14, project: bool) {
        let (mut at_w, walls) = cloud(seed, count);
        let mut draw = Draw(seed ^ 0x5eed);
        let mut guard = super::testing::Guarded::new(count, project);
        for _ in 0..25 {
            let wishes: Vec<Vec2> = (0..count).map(|_| v(draw.unit() - 0.5, draw.unit() - 0.5) * 3.0).collect();
            let ends_w = guard.round(&at_w, &wishes, &walls);
            let kept = Graph::new(&there(&at_w), RANGE_M).lmst(2);
            // Each starts when it likes and moves as fast as it likes within the period.
            let starts: Vec<(f64, f64)> = (0..count).map(|_| (draw.unit() * 0.9, 0.1 + draw.unit())).collect();
            for moment in 0..=20 {
                let time = f64::from(moment) / 20.0;
                let share = |(start, span): (f64, f64)| ((time - start) / span.min(1.0 - start)).clamp(0.0, 1.0);
                let now_w: Vec<Vec2> = (0..count).map(|n| at_w[n] + (ends_w[n] - at_w[n]) * share(starts[n])).collect();
                for n in 0..count {
                    for m in 0..n {
                        prop_assert!((now_w[n] - now_w[m]).norm() >= 0.3 - 1e-6);
                    }
                    for m in kept.of(n) {
                        prop_assert!((now_w[n] - now_w[*m]).norm() <= RANGE_M + 1e-6);
                    }
                    for wall in &walls {
                        prop_assert!(wall.distance_m(now_w[n]) >= 0.3 - 1e-6);
                    }
                }
            }
            at_w = ends_w;
        }
    }
}
