use super::testing::{Chance, Net, PARAMS, Radio, Wish, reached};
use super::*;
use drover_contract::math;
use std::cmp::Ordering;

const GOOD: Radio = Radio { loss: 0.0, delay_s_max: 0.02 };
const BAD: Radio = Radio { loss: 0.3, delay_s_max: 0.2 };
const AWFUL: Radio = Radio { loss: 0.5, delay_s_max: 0.5 };

/// Once all are ready: what must hold at every moment while nobody dies.
fn check(net: &Net) {
    let existing = net.existing();
    assert!(net.joined(&existing), "the links fall apart at {:.2} s: {existing:?}", net.seconds());
    assert!(net.joined(&net.in_range()), "the swarm falls apart at {:.2} s", net.seconds());
    let outside = net.alive().find(|bot| !bot.inside(bot.pos_w)).map(|bot| bot.id);
    assert!(outside.is_none(), "{outside:?} is asked to be where it is not, at {:.2} s", net.seconds());
    check_parents(net);
}

/// Whoever follows parents of one root comes to no robot twice.
fn check_parents(net: &Net) {
    for bot in net.alive() {
        let (mut at, mut hops) = (bot, 0);
        while let Some(parent) = at.links.parent().map(|id| net.bot(id)) {
            if !parent.alive || parent.links.root() != bot.links.root() {
                break;
            }
            (at, hops) = (parent, hops + 1);
            assert!(hops <= net.bots.len(), "a loop at {:.2} s from {}", net.seconds(), bot.id);
        }
    }
}

/// The claim of the proof: the ends of every link that anybody knows to have existed are joined by existing links that
/// come no later in the order.
fn check_claim(net: &Net) {
    let existing = net.existing();
    let mut known: Vec<LinkEdge> = net.alive().flat_map(|bot| bot.links.gossip.edges()).collect();
    known.sort_by(order);
    known.dedup();
    for edge in known {
        let no_later = existing.iter().filter(|link| order(link, &edge) != Ordering::Greater);
        assert!(reached(edge.low, no_later).contains(&edge.high), "{edge:?} at {:.2} s: {existing:?}", net.seconds());
    }
}

fn order(a: &LinkEdge, b: &LinkEdge) -> Ordering {
    let length = a.weight_m.total_cmp(&b.weight_m);
    b.made.cmp(&a.made).then(length).then((a.low, a.high).cmp(&(b.low, b.high)))
}

fn start(net: &mut Net) {
    while !net.all_ready() {
        assert!(net.seconds() < 12.0, "not ready");
        net.run(0.05, |_| {});
    }
    check(net);
}

fn chain(count: usize, gap_m: f64) -> Vec<Vec2> {
    (0..count).map(|at| Vec2::new(at as f64 * gap_m, 0.0)).collect()
}

fn ring(count: usize, gap_m: f64) -> Vec<Vec2> {
    let turn_rad = std::f64::consts::TAU / count as f64;
    let radius_m = gap_m / 2.0 / math::sin(turn_rad / 2.0);
    let place = |at: usize| math::sin_cos(at as f64 * turn_rad);
    (0..count).map(place).map(|(sin, cos)| Vec2::new(cos, sin) * radius_m).collect()
}

/// A swarm of any size in any place with any radio.
fn anyhow(seed: u64, wish: Wish) -> Net {
    let mut chance = Chance::new(seed);
    let radio = Radio { loss: 0.5 * chance.unit(), delay_s_max: 0.5 * chance.unit() };
    let mut net = Net::scattered(seed, 5 + chance.below(16), radio, wish);
    let stop_m = if seed.is_multiple_of(2) { 0.0 } else { 0.3 };
    net.bots.iter_mut().for_each(|bot| bot.stop_m = stop_m);
    net
}

#[test]
fn no_wandering_breaks_a_swarm_whatever_the_radio_does() {
    for seed in 0..120 {
        let mut net = anyhow(seed, Wish::Wander);
        start(&mut net);
        net.run(12.0, check);
        assert!(net.alive().all(|bot| bot.links.lost.is_empty()), "nobody is given up who lives");
    }
}

#[test]
fn no_pulling_apart_breaks_a_swarm_whatever_the_radio_does() {
    for seed in 1_000..1_080 {
        let mut net = anyhow(seed, Wish::Apart);
        start(&mut net);
        net.run(10.0, check);
        net.wish = Wish::Wander;
        net.run(4.0, check);
    }
}

#[test]
fn no_known_link_ever_lies_about_who_is_joined() {
    for seed in 2_000..2_060 {
        let mut net = anyhow(seed, Wish::Wander);
        net.run(12.0, check_claim);
    }
}

#[test]
fn a_swarm_without_a_radio_stands_still_in_the_end_and_goes_on_when_it_is_back() {
    for seed in 3_000..3_020 {
        let mut net = Net::scattered(seed, 10, GOOD, Wish::Wander);
        start(&mut net);
        net.run(2.0, check);
        net.radio.loss = 1.0;
        net.wish = Wish::Apart;
        net.run(PARAMS.lost_s - 0.8, check);
        net.radio.loss = 0.0;
        net.run(5.0, check);
    }
}

#[test]
fn a_crowd_keeps_hardly_more_links_than_a_tree() {
    for (seed, radio) in [(1, GOOD), (2, BAD), (3, AWFUL)] {
        let mut chance = Chance::new(seed);
        let places_w: Vec<Vec2> = (0..20).map(|_| chance.direction() * (5.0 * chance.unit())).collect();
        let mut net = Net::new(seed, &places_w, radio, Wish::Stand);
        start(&mut net);
        net.run(10.0, check);
        let mut most = 0;
        net.run(20.0, |net| most = most.max(net.existing().len()));
        assert_eq!(most, 19, "standing, {radio:?}");
        net.wish = Wish::Wander;
        let (mut sum, mut steps) = (0, 0);
        net.run(20.0, |net| (sum, steps) = (sum + net.existing().len(), steps + 1));
        let mean = f64::from(sum as u32) / f64::from(steps);
        assert!(mean < 23.0, "wandering, {radio:?}: {mean}");
    }
}

#[test]
fn a_ring_opens_and_stays_open() {
    for (seed, count, radio) in [(1, 12, GOOD), (2, 12, BAD), (3, 12, AWFUL), (4, 30, BAD)] {
        let mut net = Net::new(seed, &ring(count, 4.0), radio, Wish::Stand);
        start(&mut net);
        while net.existing().len() >= count {
            assert!(net.seconds() < 60.0, "closed, {radio:?}");
            net.run(0.05, check);
        }
        let mut again = 0;
        net.run(30.0, |net| again += usize::from(net.existing().len() == count));
        assert_eq!(again, 0, "closed again, {radio:?}");
    }
}

/// How fast the front of a travelling chain of eight gets 50 m ahead, of 1 m/s.
fn front_speed_mps(gap_m: f64, radio: Radio) -> f64 {
    let mut net = Net::new(1, &chain(8, gap_m), radio, Wish::Along(Vec2::x()));
    start(&mut net);
    let (from_m, from_s) = (net.bots[7].pos_w.x, net.seconds());
    while net.bots[7].pos_w.x - from_m < 50.0 && net.seconds() < 300.0 {
        net.run(0.05, check);
    }
    (net.bots[7].pos_w.x - from_m) / (net.seconds() - from_s)
}

#[test]
fn a_chain_travels_nearly_as_fast_as_if_nothing_bound_it() {
    for (radio, gap_m, least_mps) in [(GOOD, 5.0, 0.99), (BAD, 4.0, 0.97), (BAD, 5.5, 0.8), (AWFUL, 4.0, 0.8)] {
        let speed_mps = front_speed_mps(gap_m, radio);
        assert!(speed_mps >= least_mps, "{gap_m} m apart, {radio:?}: {speed_mps} m/s");
    }
}

#[test]
fn links_of_a_dead_robot_end_after_its_silence_and_everybody_hears_of_it() {
    let mut net = Net::new(5, &chain(7, 3.0), BAD, Wish::Stand);
    start(&mut net);
    let (dead, before, behind) = (net.bots[3].id, net.bots[2].id, net.bots[4].id);
    net.bots[3].alive = false;
    let died_s = net.seconds();
    while net.alive().any(|bot| bot.links.relies_on(dead)) {
        net.run(0.05, |_| {});
    }
    let lost_after_s = net.seconds() - died_s;
    assert!((PARAMS.lost_s - 2.0..PARAMS.lost_s + 1.0).contains(&lost_after_s), "after {lost_after_s} s");
    let lost = net.bots[2].links.take_lost();
    assert!(lost.len() == 1 && lost[0].peer == dead && !lost[0].restarted, "{lost:?}");
    assert!(lost[0].linked.contains(&Some(behind)) && lost[0].linked.contains(&Some(before)), "whom to look for");
    assert!(lost[0].pos_w.is_some_and(|at_w| (at_w - Vec2::new(9.0, 0.0)).norm() < 1e-9));
    // The two next to it are 6 m apart: in range of each other, so the chain heals, and the news goes around.
    net.run(5.0, |_| {});
    assert!(net.joined(&net.existing()) && net.alive().all(|bot| bot.links.gone().eq([dead])));
    net.run(5.0, check);
}

#[test]
fn a_robot_that_starts_anew_is_linked_anew() {
    for seed in 0..20 {
        let mut net = Net::new(seed, &chain(6, 3.0), BAD, Wish::Stand);
        start(&mut net);
        net.run(3.0, check);
        let id = net.bots[2].id;
        net.restart(2);
        net.run(6.0, |_| {});
        let lost = net.bots[1].links.take_lost();
        assert!(lost.len() == 1 && lost[0].peer == id && lost[0].restarted, "{lost:?}");
        assert!(net.all_ready() && net.alive().all(|bot| bot.links.gone().next().is_none()));
        net.wish = Wish::Wander;
        net.run(6.0, check);
    }
}

#[test]
fn everybody_finds_the_best_root_and_a_new_one_when_it_dies() {
    // The metric is the place from west to east.
    let mut net = Net::new(3, &chain(10, 4.0), BAD, Wish::Stand);
    start(&mut net);
    net.run(4.0, check);
    let root = net.bots[0].id;
    assert!(net.alive().all(|bot| bot.links.root() == root));
    let parents: Vec<_> = net.alive().map(|bot| bot.links.parent()).collect();
    assert!(parents[0].is_none() && (1..10).all(|at| parents[at] == Some(net.bots[at - 1].id)), "{parents:?}");
    net.bots[0].alive = false;
    net.run(9.0, check_parents);
    assert!(net.alive().all(|bot| bot.links.root() == net.bots[1].id));
}

#[test]
fn who_hears_nobody_is_ready_soon_and_who_is_never_answered_gives_up() {
    let place = Place { pos_w: Vec2::zeros(), wish_w: Vec2::zeros(), stop_m: 0.0 };
    let mut links = Links::new(RobotId(1), 1, PARAMS, Stamp::ZERO);
    let deaf = LinkPeer { id: RobotId(2), pos_w: Vec2::new(3.0, 0.0), vel_w: Vec2::zeros(), age_s: 0.1 };
    let mut lone = links.clone();
    for ms in (0..=8_000).step_by(100) {
        links.tick(Stamp::from_millis(ms), &place, &[deaf], 0.0);
        lone.tick(Stamp::from_millis(ms), &place, &[], 0.0);
        assert_eq!(lone.ready(), ms >= 2_000, "at {ms} ms");
        assert_eq!(links.ready(), ms > 5_000, "at {ms} ms");
    }
    assert!(links.discs().next().is_none() && links.root() == RobotId(1) && links.parent().is_none());
}

#[test]
fn a_proposal_is_taken_only_by_who_stands_in_its_disc_with_room_to_stop() {
    let propose = |stop_m: f64, x_m: f64, epoch: u32| {
        let mut links = Links::new(RobotId(2), epoch, PARAMS, Stamp::ZERO);
        let mut report = Links::new(RobotId(1), 1, PARAMS, Stamp::ZERO).report(Stamp::ZERO);
        report.links[0] =
            Some(LinkEntry { version: 1, proposes: true, made: 1, ..pact::Pair::new().entry(RobotId(2), 1) });
        let place = Place { pos_w: Vec2::new(x_m, 0.0), wish_w: Vec2::zeros(), stop_m };
        links.handle_report(Stamp::ZERO, &report, &place);
        links.holds(RobotId(1))
    };
    assert!(propose(0.0, 3.29, 1) && !propose(0.0, 3.31, 1) && !propose(0.1, 3.29, 1) && propose(0.1, 3.19, 1));
    assert!(!propose(0.0, 0.0, 2) && !propose(0.0, f64::NAN, 1), "meant for an earlier life; nowhere");
}

#[test]
fn tables_are_bounded_and_strangers_do_not_drive_out_those_that_count() {
    let place = Place { pos_w: Vec2::zeros(), wish_w: Vec2::zeros(), stop_m: 0.0 };
    let mut links = Links::new(RobotId(5_000), 1, PARAMS, Stamp::ZERO);
    for robot in 1..2_000 {
        let now = Stamp::from_millis(u64::from(robot));
        let mut report = Links::new(RobotId(robot), 1, PARAMS, Stamp::ZERO).report(now);
        let ask = LinkEntry { version: 1, proposes: true, made: 1, ..pact::Pair::new().entry(RobotId(5_000), 1) };
        report.links[0] = Some(ask);
        links.handle_report(now, &report, &place);
    }
    assert_eq!(links.peers.len(), peer::PEERS_MAX);
    assert!(links.kept().map(|id| id.0).eq(1..=LINKS_TOLD_MAX as u32), "the first ones, and no more than can be told");
    assert_eq!(links.report(Stamp::from_millis(2_000)).links.iter().flatten().count(), LINKS_TOLD_MAX);
}
