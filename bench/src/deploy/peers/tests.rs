//! Both peers on scenes that are small enough for a test.

use super::{Cbf, Fiedler, Peer, Scene, run};
use drover_contract::Vec2;
use drover_core::avoid::Capsule;
use rand::{Rng, SeedableRng};
use rand_pcg::Pcg64Mcg;

fn scene<'a>(walls: &'a [Capsule], targets_w: &'a [Vec2]) -> Scene<'a> {
    Scene { walls, targets_w, range_m: 7.0, step_m: 0.5, period_s: 1.0, robot_gap_m: 0.3, wall_gap_m: 0.3 }
}

fn both() -> [Box<dyn Peer>; 2] {
    [Box::new(Cbf::default()), Box::new(Fiedler::default())]
}

#[test]
fn ten_robots_in_the_open_arrive_connected() {
    let starts_w: Vec<Vec2> = (0..10).map(|k| Vec2::new(2.5 * f64::from(k), 5.0)).collect();
    let targets_w: Vec<Vec2> = (0..10).map(|k| Vec2::new(40.0, 42.5 - 2.5 * f64::from(k))).collect();
    for mut peer in both() {
        let got = run(&mut *peer, &scene(&[], &targets_w), &starts_w, 300.0);
        assert!(got.connected_always && got.arrived_fraction >= 1.0, "{}: {got:?}", peer.name());
        assert!(got.min_gap_robot_m > 0.29, "{}: {got:?}", peer.name());
    }
}

#[test]
fn both_pass_a_flat_wall_that_stands_across_their_way() {
    let wall = [Capsule::edge(Vec2::new(10.0, -4.0), Vec2::new(10.0, 4.0))];
    let starts_w: Vec<Vec2> = (0..5).map(|k| Vec2::new(1.0, 2.0 * f64::from(k) - 4.0)).collect();
    let targets_w: Vec<Vec2> = (0..5).map(|k| Vec2::new(20.0, 2.0 * f64::from(k) - 4.0)).collect();
    for mut peer in both() {
        let got = run(&mut *peer, &scene(&wall, &targets_w), &starts_w, 400.0);
        assert!(got.connected_always && got.arrived_fraction >= 1.0, "{}: {got:?}", peer.name());
        assert!(!got.tunnelled, "{}: {got:?}", peer.name());
    }
}

#[test]
fn barriers_hold_whatever_is_wished() {
    let mut rng = Pcg64Mcg::seed_from_u64(3);
    let mut anywhere =
        |from_m: f64, to_m: f64| Vec2::new(rng.random_range(from_m..to_m), rng.random_range(from_m..to_m));
    let walls = [Capsule::disc(Vec2::new(20.0, 20.0), 4.0), Capsule::edge(Vec2::new(30.0, 0.0), Vec2::new(30.0, 30.0))];
    for _ in 0..10 {
        let mut starts_w: Vec<Vec2> = Vec::new();
        while starts_w.len() < 25 {
            let at_w = anywhere(0.0, 14.0);
            if starts_w.iter().all(|other_w| (at_w - other_w).norm() > 0.35) {
                starts_w.push(at_w);
            }
        }
        let targets_w: Vec<Vec2> = starts_w.iter().map(|_| anywhere(-40.0, 60.0)).collect();
        let got = run(&mut Cbf::default(), &scene(&walls, &targets_w), &starts_w, 150.0);
        assert!(got.connected_always, "{got:?}");
        assert!(got.min_gap_robot_m > 0.3 - 1e-9 && got.min_gap_wall_m > 0.3 - 1e-9, "{got:?}");
    }
}
