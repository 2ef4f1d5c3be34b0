use super::*;
use drover_config::{Airtime, Burst, Partition};
use proptest::prelude::*;
use std::time::Duration;

/// Robots of the shortest tests have these ids, in this order.
const IDS: [u32; 4] = [11, 12, 13, 14];

fn params() -> Params {
    Params { range_m: 10.0, delay_ms: 0.0, jitter_ms: 0.0, ..Params::default() }
}

fn radio<M>(params: &Params) -> Radio<M> {
    Radio::new(params, &IDS, 5)
}

fn line() -> Vec<Vec2> {
    [0.0, 5.0, 10.0, 10.1].map(|x| Vec2::new(x, 0.0)).to_vec()
}

fn ms(ms: u64) -> Stamp {
    Stamp::from_millis(ms)
}

fn drain<M: Clone>(radio: &mut Radio<M>, now: Stamp) -> Vec<(usize, M)> {
    std::iter::from_fn(|| radio.poll(now)).map(|delivery| (delivery.to, delivery.message)).collect()
}

/// Send from robot 0 to robot 1, `distance_m` away, `count` times, one a `period_ms`: what happened.
fn exchange(params: &Params, distance_m: f64, count: u64, period_ms: u64) -> RadioTally {
    let mut radio = radio(params);
    let pair = [Vec2::zeros(), Vec2::new(distance_m, 0.0)];
    for n in 0..count {
        radio.broadcast(ms(n * period_ms), 0, &pair[..], n);
        radio.deliver(ms(n * period_ms), |_, _, _| {});
    }
    RadioTally { out_of_range: 0, ..radio.tally() }
}

/// That `hits` of `count` is a share of `expected`, to within four standard deviations.
fn assert_share(hits: u64, count: u64, expected: f64) {
    let sigma = (expected * (1.0 - expected) / count as f64).sqrt();
    let share = hits as f64 / count as f64;
    assert!((share - expected).abs() <= 4.0 * sigma, "{share} and not {expected} of {count}");
}

/// Robots in a field that is visited in the order of `order`, some of them twice, with a wall along x = `wall_x_m`.
struct Field {
    positions_w: Vec<Vec2>,
    order: Vec<usize>,
    wall_x_m: f64,
}

impl Scene for Field {
    fn position_w(&self, robot: usize) -> Option<Vec2> {
        self.positions_w.get(robot).copied()
    }

    fn for_each_near(&self, _centre_w: Vec2, _range_m: f64, visit: &mut dyn FnMut(usize)) {
        self.order.iter().chain(self.order.iter().take(3)).for_each(|robot| visit(*robot));
    }

    fn walls_between(&self, a_w: Vec2, b_w: Vec2) -> u32 {
        u32::from((a_w.x < self.wall_x_m) != (b_w.x < self.wall_x_m))
    }
}

#[test]
fn those_in_range_hear_it_after_the_delay_and_the_sender_does_not() {
    let mut radio = radio(&Params { delay_ms: 20.0, ..params() });
    radio.broadcast(Stamp::ZERO, 0, &line()[..], "hello");
    assert_eq!(radio.poll(ms(19)), None);
    assert_eq!(radio.poll_timeout(), Some((ms(20), "radio delivery")));
    assert_eq!(radio.in_flight(), 2);
    assert_eq!(radio.poll(ms(20)), Some(Delivery { to: 1, from: 0, message: "hello" }));
    assert_eq!(drain(&mut radio, ms(20)), vec![(2, "hello")]);
    assert_eq!(radio.tally(), RadioTally { sent: 1, carried: 2, out_of_range: 1, ..RadioTally::default() });
    assert_eq!(radio.poll_timeout(), None);
    assert!(radio.bytes() > 0);
}

#[test]
fn losses_come_as_often_as_asked_and_each_receiver_has_its_own() {
    let mut radio = radio(&Params { loss: 0.3, ..params() });
    (0..20_000).for_each(|n| radio.broadcast(Stamp::ZERO, 0, &line()[..3], n));
    let heard = drain(&mut radio, Stamp::ZERO);
    let at = |robot| heard.iter().filter(|(to, _)| *to == robot).map(|(_, n)| *n).collect::<Vec<u32>>();
    assert_share(at(1).len() as u64, 20_000, 0.7);
    assert_share(at(2).len() as u64, 20_000, 0.7);
    let both = at(1).iter().filter(|n| at(2).binary_search(n).is_ok()).count();
    assert_share(both as u64, 20_000, 0.49);
    assert_eq!(heard.len() as u64, radio.tally().carried);
    assert_eq!(radio.tally().carried + radio.tally().lost, 40_000);
}

#[test]
fn jitter_stays_in_its_bounds_and_lets_messages_overtake() {
    let mut radio = radio(&Params { delay_ms: 5.0, jitter_ms: 10.0, ..params() });
    (0..100).for_each(|n| radio.broadcast(ms(n), 0, &line()[..2], n));
    let mut order = Vec::new();
    for us in 0..200_000 {
        for (_, sent_ms) in drain(&mut radio, Stamp::from_micros(us)) {
            let age_us = us - sent_ms * 1000;
            assert!((5_000..=15_000).contains(&age_us), "{age_us}");
            order.push(sent_ms);
        }
    }
    assert_eq!(order.len(), 100);
    assert!(!order.is_sorted(), "some message overtakes another");
}

#[test]
fn the_longest_delays_arrive() {
    let mut radio = radio(&Params { delay_ms: 10_000.0, jitter_ms: 10_000.0, ..params() });
    (0..100).for_each(|n| radio.broadcast(ms(n * 100), 0, &line()[..2], n));
    assert_eq!(radio.poll(ms(9_999)), None);
    assert_eq!(drain(&mut radio, ms(29_900)).len(), 100);
    assert_eq!(radio.tally().dropped, 0);
}

#[test]
fn copies_come_as_often_as_asked_with_a_delay_of_their_own() {
    let mut radio = radio(&Params { duplicate: 0.1, jitter_ms: 50.0, ..params() });
    (0..20_000).for_each(|n| radio.broadcast(ms(n), 0, &line()[..2], n));
    assert_share(radio.tally().duplicated, 20_000, 0.1);
    assert_eq!(radio.tally().carried, 20_000);
    let mut arrivals = vec![0; 20_000];
    let mut together = 0;
    for now_ms in 0..20_100 {
        let heard = drain(&mut radio, ms(now_ms));
        together += heard.windows(2).filter(|two| two[0].1 == two[1].1).count();
        heard.iter().for_each(|(_, n)| arrivals[*n as usize] += 1);
    }
    assert!(arrivals.iter().all(|count| (1..=2).contains(count)));
    assert!(together < 200, "{together} of some 2000 copies come with the first");
}

#[test]
fn the_air_holds_a_bounded_number_and_refuses_more() {
    let mut radio = radio(&Params { delay_ms: 1.0, ..params() });
    (0..=IN_FLIGHT_MAX).for_each(|n| radio.broadcast(Stamp::ZERO, 0, &line()[..2], n));
    assert_eq!((radio.tally().dropped, radio.in_flight()), (1, IN_FLIGHT_MAX));
    let heard = drain(&mut radio, ms(1));
    assert!(heard.iter().map(|(_, n)| *n).eq(0..IN_FLIGHT_MAX));
}

#[test]
fn a_sender_without_a_position_is_not_heard_and_a_receiver_without_one_hears_nothing() {
    let mut radio = radio(&params());
    radio.broadcast(Stamp::ZERO, 9, &line()[..], "ghost");
    radio.broadcast(Stamp::ZERO, 2, &line()[..2], "ghost");
    assert_eq!(radio.poll(ms(1)), None);
    radio.broadcast(Stamp::ZERO, 0, &line()[..1], "alone");
    assert_eq!(radio.tally(), RadioTally { sent: 1, out_of_range: 3, ..RadioTally::default() });
    Radio::new(&params(), &[], 1).broadcast(Stamp::ZERO, 0, &line()[..], "nobody");
}

#[test]
fn losses_in_bursts_are_as_frequent_as_the_share_of_bad_time_says() {
    let burst = Burst { enter_per_s: 1.0, leave_per_s: 3.0, loss: 0.9 };
    let params = Params { loss: 0.1, burst: Some(burst), ..params() };
    let tally = exchange(&params, 5.0, 20_000, 5_000);
    // At 5 s between messages the state has forgotten itself: exp(-20).
    assert_share(tally.lost, 20_000, 0.25 * 0.9 + 0.75 * 0.1);
}

#[test]
fn half_of_the_messages_are_lost_at_half_range_and_fewer_nearer() {
    let rule = Propagation { exponent: 3.0, half_range_m: 20.0, wall_db: 0.0, shadow_db: 0.0, soft_db: 2.0 };
    let params = Params { range_m: 1e3, propagation: Some(rule), ..params() };
    assert_share(exchange(&params, 20.0, 20_000, 1).lost, 20_000, 0.5);
    // At half the distance, 30 log10(2) = 9.03 dB more.
    assert_share(exchange(&params, 10.0, 20_000, 1).carried, 20_000, 1.0 / (1.0 + libm::exp(-9.0309 / 2.0)));
    assert_eq!(exchange(&params, 0.0, 1000, 1).carried, 1000);
    let lossy = Params { loss: 0.2, ..params };
    assert_share(exchange(&lossy, 20.0, 20_000, 1).carried, 20_000, 0.5 * 0.8);
}

#[test]
fn a_wall_costs_as_much_as_the_distance_that_takes_as_many_decibels() {
    let rule = Propagation { exponent: 2.0, half_range_m: 20.0, wall_db: 6.0, shadow_db: 0.0, soft_db: 3.0 };
    let params = Params { range_m: 1e3, propagation: Some(rule), ..params() };
    let carried = |wall_x_m: f64| {
        let positions_w = vec![Vec2::zeros(), Vec2::new(20.0, 0.0)];
        let field = Field { positions_w, order: vec![0, 1], wall_x_m };
        let mut radio = radio(&params);
        (0..20_000).for_each(|_| radio.broadcast(Stamp::ZERO, 0, &field, ()));
        radio.tally().carried
    };
    assert_share(carried(50.0), 20_000, 0.5);
    assert_share(carried(10.0), 20_000, 1.0 / (1.0 + libm::exp(2.0)));
    let wall_as_distance_m = 20.0 * libm::pow(10.0, 6.0 / 20.0);
    let share = propagation::share_received(&rule, wall_as_distance_m, 0, Draws::new(0, Use::Radio));
    assert!((share - 1.0 / (1.0 + libm::exp(2.0))).abs() < 1e-12);
}

#[test]
fn shadowing_is_fixed_for_a_pair_and_differs_between_the_directions() {
    let rule = Propagation { exponent: 2.0, half_range_m: 20.0, wall_db: 0.0, shadow_db: 8.0, soft_db: 1e-3 };
    let ids: Vec<u32> = (0..400).collect();
    let params = Params { range_m: 1e3, propagation: Some(rule), ..params() };
    let mut radio = Radio::new(&params, &ids, 1);
    // All at half range from robot 0 and on one spot: with next to no softness, shadowing alone decides.
    let positions_w: Vec<Vec2> = ids.iter().map(|id| Vec2::new(if *id == 0 { 0.0 } else { 20.0 }, 0.0)).collect();
    let mut heard = |from: usize, to: usize| {
        radio.broadcast(Stamp::ZERO, from, &positions_w[..], ());
        drain(&mut radio, Stamp::ZERO).iter().any(|(at, ())| *at == to)
    };
    let there: Vec<bool> = (1..400).map(|other| heard(0, other)).collect();
    let again: Vec<bool> = (1..400).map(|other| heard(0, other)).collect();
    let back: Vec<bool> = (1..400).map(|other| heard(other, 0)).collect();
    assert_eq!(there, again);
    assert_share(there.iter().filter(|heard| **heard).count() as u64, 399, 0.5);
    assert_share(there.iter().zip(&back).filter(|(there, back)| there == back).count() as u64, 399, 0.5);
}

#[test]
fn asymmetry_makes_some_pairs_one_way_and_never_widens_the_range() {
    let ids: Vec<u32> = (0..400).collect();
    let mut radio = Radio::new(&Params { asymmetry: 0.5, ..params() }, &ids, 1);
    let positions_w: Vec<Vec2> = ids.iter().map(|id| Vec2::new(if *id == 0 { 0.0 } else { 7.5 }, 0.0)).collect();
    let mut listeners = |from: usize, positions_w: &[Vec2]| {
        radio.broadcast(Stamp::ZERO, from, positions_w, ());
        drain(&mut radio, Stamp::ZERO).iter().map(|(to, ())| *to).collect::<Vec<usize>>()
    };
    let there = listeners(0, &positions_w);
    assert_share(there.len() as u64, 399, 0.5);
    let back: Vec<usize> = (1..400).filter(|other| listeners(*other, &positions_w).contains(&0)).collect();
    assert_share(there.iter().filter(|other| back.contains(other)).count() as u64, 399, 0.25);
    // Within the shortest range everybody hears, beyond the longest nobody.
    assert_eq!(listeners(0, &positions_w.iter().map(|at| at * 0.66).collect::<Vec<_>>()).len(), 399);
    assert_eq!(listeners(0, &positions_w.iter().map(|at| at * 1.34).collect::<Vec<_>>()).len(), 0);
}

#[test]
fn a_partition_parts_both_ways_and_is_healed_after() {
    let partition = Partition { from_s: 1.0, until_s: 2.0, ids: vec![12, 99] };
    let mut radio = radio(&Params { partitions: vec![partition], ..params() });
    let mut heard = |at_ms: u64, from: usize| {
        radio.broadcast(ms(at_ms), from, &line()[..3], ());
        drain(&mut radio, ms(at_ms)).iter().map(|(to, ())| *to).collect::<Vec<_>>()
    };
    for at_ms in [0, 999, 2000, 5000] {
        assert_eq!((heard(at_ms, 0), heard(at_ms, 1), heard(at_ms, 2)), (vec![1, 2], vec![0, 2], vec![0, 1]));
        if at_ms == 999 {
            for at_ms in [1000, 1999] {
                assert_eq!((heard(at_ms, 0), heard(at_ms, 1), heard(at_ms, 2)), (vec![2], vec![], vec![0]));
            }
        }
    }
    assert_eq!(radio.tally().partitioned, 8);
}

#[test]
fn a_channel_carries_one_message_at_a_time_and_the_rest_is_crowded_out() {
    let airtime = Airtime { message_ms: 1.0, wait_ms_max: 20.0 };
    let ids: Vec<u32> = (0..50).collect();
    let mut radio = Radio::new(&Params { airtime: Some(airtime), ..params() }, &ids, 1);
    let positions_w = vec![Vec2::zeros(); 50];
    // 49 senders at 50 Hz: 2450 messages a second for a channel of 1000.
    let mut heard = Vec::new();
    for n in 0..500_u64 {
        (1..50).for_each(|from| radio.broadcast(ms(n * 20), from, &positions_w[..], n));
        for us in (0..20_000).step_by(500) {
            let now = Stamp::from_micros(n * 20_000 + us);
            radio.deliver(now, |to, _, sent| heard.extend((to == 0).then_some((now.since(ms(sent * 20)), now))));
        }
    }
    assert!((9_980..=10_000).contains(&heard.len()), "{}", heard.len());
    let gap = heard.windows(2).map(|two| two[1].1.since(two[0].1)).min();
    assert_eq!(gap, Some(Duration::from_millis(1)));
    assert!(heard.iter().all(|(age, _)| (1..=21).contains(&age.as_millis())));
    let tally = radio.tally();
    assert_eq!(tally.carried + tally.crowded, 500 * 49 * 49);
}

#[test]
fn lost_messages_take_the_air_and_those_out_of_range_do_not() {
    let airtime = Airtime { message_ms: 1.0, wait_ms_max: 0.5 };
    let mut radio = radio(&Params { airtime: Some(airtime), loss: 1.0, ..params() });
    radio.broadcast(Stamp::ZERO, 0, &line()[..], ());
    radio.broadcast(Stamp::ZERO, 1, &line()[..], ());
    // Robot 2 hears both, robots 0 and 1 each other, robot 3 only 1.
    assert_eq!((radio.tally().lost, radio.tally().crowded), (2 + 2, 1));
}

#[test]
fn bytes_and_values_alike() {
    let mut radio: Radio<std::sync::Arc<[u8]>> = radio(&params());
    radio.broadcast(Stamp::ZERO, 0, &line()[..], b"wire"[..].into());
    let mut heard = Vec::new();
    radio.deliver(Stamp::ZERO, |to, from, bytes| heard.push((to, from, bytes.to_vec())));
    assert_eq!(heard, vec![(1, 0, b"wire".to_vec()), (2, 0, b"wire".to_vec())]);
}

/// Everything at once.
fn rich() -> Params {
    let burst = Burst { enter_per_s: 1.0, leave_per_s: 3.0, loss: 0.9 };
    let rule = Propagation { exponent: 2.0, half_range_m: 20.0, wall_db: 5.0, shadow_db: 4.0, soft_db: 2.0 };
    let partition = Partition { from_s: 0.3, until_s: 0.5, ids: (0..10).map(|id| id * 3).collect() };
    Params {
        range_m: 25.0,
        loss: 0.1,
        delay_ms: 1.0,
        jitter_ms: 30.0,
        duplicate: 0.1,
        asymmetry: 0.3,
        burst: Some(burst),
        propagation: Some(rule),
        airtime: None,
        partitions: vec![partition],
    }
}

/// One delivery: in which ms it was handed out, to which id, from which id, and the number of the message.
type Heard = (u64, u32, u32, u64);

/// All robots of `ids` send every 50 ms for a second, one after the other.
fn everything_heard(params: &Params, ids: &[u32], field: &Field) -> (Vec<Heard>, RadioTally) {
    let mut radio = Radio::new(params, ids, 77);
    let mut heard = Vec::new();
    for now_ms in 0..1200 {
        if now_ms % 50 == 0 && now_ms < 1000 {
            (0..ids.len()).for_each(|from| radio.broadcast(ms(now_ms), from, field, now_ms));
        }
        radio.deliver(ms(now_ms), |to, from, sent| heard.push((now_ms, ids[to], ids[from], *sent)));
    }
    (heard, radio.tally())
}

/// A place for each id, whatever its index.
fn place(id: u32) -> Vec2 {
    Vec2::new(f64::from(id * 7 % 31), f64::from(id * 13 % 29))
}

fn field(ids: &[u32], order: Vec<usize>) -> Field {
    Field { positions_w: ids.iter().map(|id| place(*id)).collect(), order, wall_x_m: 12.0 }
}

#[test]
fn one_seed_gives_the_same_air_twice_whatever_the_order_of_visits() {
    let ids: Vec<u32> = (0..30).collect();
    let airtime = Airtime { message_ms: 0.3, wait_ms_max: 5.0 };
    for params in [rich(), Params { airtime: Some(airtime), ..rich() }] {
        let forwards = everything_heard(&params, &ids, &field(&ids, (0..30).collect()));
        let again = everything_heard(&params, &ids, &field(&ids, (0..30).collect()));
        let shuffled = everything_heard(&params, &ids, &field(&ids, (0..30).map(|n| n * 7 % 30).collect()));
        assert!(forwards.0.len() > 3000, "{}", forwards.0.len());
        assert!(forwards == again && forwards == shuffled);
    }
    let tally = everything_heard(&rich(), &ids, &field(&ids, (0..30).collect())).1;
    let RadioTally { sent, carried, lost, out_of_range, partitioned, .. } = tally;
    assert_eq!(carried + lost + out_of_range + partitioned, sent * 29);
    assert!(lost > 0 && out_of_range > 0 && partitioned > 0 && tally.duplicated > 0);
}

#[test]
fn what_two_robots_hear_of_each_other_does_not_depend_on_who_else_is_there() {
    let all: Vec<u32> = (0..30).collect();
    let (everything, _) = everything_heard(&rich(), &all, &field(&all, (0..30).collect()));
    for pair in [[4_u32, 8], [21, 3], [25, 3]] {
        let (alone, _) = everything_heard(&rich(), &pair, &field(&pair, vec![0, 1]));
        let of_the_pair = |heard: &&Heard| pair.contains(&heard.1) && pair.contains(&heard.2);
        let mut among_all: Vec<Heard> = everything.iter().filter(of_the_pair).copied().collect();
        let mut alone = alone;
        // Within one ms the order is that of sending, and that differs.
        among_all.sort_unstable();
        alone.sort_unstable();
        assert!(!alone.is_empty());
        assert_eq!(among_all, alone);
    }
}

#[test]
fn arrivals_of_one_moment_come_in_the_order_of_sending_and_then_of_receivers() {
    let mut radio = radio(&Params { range_m: 100.0, delay_ms: 3.0, ..params() });
    let field = Field { positions_w: line(), order: vec![3, 1, 0, 2], wall_x_m: 0.0 };
    [2, 0].into_iter().for_each(|from| radio.broadcast(Stamp::ZERO, from, &field, ()));
    let mut heard = Vec::new();
    radio.deliver(ms(3), |to, from, ()| heard.push((from, to)));
    assert_eq!(heard, vec![(2, 0), (2, 1), (2, 3), (0, 1), (0, 2), (0, 3)]);
}

proptest! {
    #[test]
    fn farther_and_behind_more_walls_is_never_heard_better(
        (near_m, more_m) in (0.0..200.0_f64, 0.0..200.0_f64),
        (exponent, shadow_db, soft_db) in (1.0..6.0_f64, 0.0..20.0_f64, 0.1..10.0_f64),
        (walls, id) in (0..5_u32, any::<u64>()),
    ) {
        let rule = Propagation { exponent, half_range_m: 30.0, wall_db: 4.0, shadow_db, soft_db };
        let pair = Draws::new(1, Use::Radio).of(id);
        let share = |distance_m, walls| propagation::share_received(&rule, distance_m, walls, pair);
        prop_assert!((0.0..=1.0).contains(&share(near_m, walls)));
        prop_assert!(share(near_m + more_m, walls) <= share(near_m, walls));
        prop_assert!(share(near_m, walls + 1) <= share(near_m, walls));
    }

    #[test]
    fn delays_stay_in_their_bounds(delay_ms in 0.0..10_000.0_f64, jitter_ms in 0.0..10_000.0_f64, seed: u64) {
        let mut radio = Radio::new(&Params { delay_ms, jitter_ms, duplicate: 0.5, ..params() }, &IDS, seed);
        (0..20).for_each(|_| radio.broadcast(ms(7), 0, &line()[..], ()));
        let count = radio.in_flight();
        let first = Stamp::from_micros(7_000 + (delay_ms * 1e3) as u64);
        let last = Stamp::from_micros(7_000 + ((delay_ms + jitter_ms) * 1e3) as u64);
        prop_assert!(radio.poll_timeout().is_none_or(|(due, _)| due >= first));
        prop_assert_eq!(drain(&mut radio, last).len(), count);
    }
}
