//! A small asynchronous network of robots that move as badly as their discs allow.

use super::{LinkParams, LinkPeer, Links, Place};
use drover_contract::{LinkEdge, LinkReport, RobotId, Stamp, Vec2, math};
use std::collections::{BTreeMap, BTreeSet};

/// Bodies move in steps of this length; messages travel in between to the microsecond.
pub(super) const STEP_US: u64 = 50_000;
pub(super) const PARAMS: LinkParams =
    LinkParams { range_m: 7.0, margin_m: 0.2, speed_mps_max: 1.0, term_s: 1.5, lost_s: 5.0 };

/// A seeded generator (splitmix64).
#[derive(Clone, Debug)]
pub(super) struct Chance(u64);

impl Chance {
    pub(super) fn new(seed: u64) -> Self {
        Self(seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) ^ 0x1234_5678)
    }

    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    }

    /// In 0..1.
    pub(super) fn unit(&mut self) -> f64 {
        (self.next() >> 11) as f64 / (1_u64 << 53) as f64
    }

    pub(super) fn below(&mut self, end: usize) -> usize {
        (self.unit() * end as f64) as usize
    }

    pub(super) fn direction(&mut self) -> Vec2 {
        let (sin, cos) = math::sin_cos(self.unit() * std::f64::consts::TAU);
        Vec2::new(cos, sin)
    }
}

/// How the radio treats a message to one receiver.
#[derive(Clone, Copy, Debug)]
pub(super) struct Radio {
    pub(super) loss: f64,
    pub(super) delay_s_max: f64,
}

/// What robots want.
#[derive(Clone, Copy, Debug)]
pub(super) enum Wish {
    Stand,
    /// A new direction now and then.
    Wander,
    /// Away from the middle of all.
    Apart,
    /// All the same way.
    Along(Vec2),
}

#[derive(Clone, Debug)]
pub(super) struct Bot {
    pub(super) id: RobotId,
    pub(super) links: Links,
    pub(super) pos_w: Vec2,
    pub(super) alive: bool,
    vel_w: Vec2,
    wish_w: Vec2,
    seen: BTreeMap<RobotId, (u64, Vec2, Vec2)>,
    epoch: u32,
    /// Its clock is that far ahead.
    clock_us: u64,
    due_us: u64,
    period_us: u64,
    pub(super) stop_m: f64,
}

#[derive(Clone, Debug)]
struct Message {
    to: usize,
    from: RobotId,
    sent_us: u64,
    /// A beacon or a report: they fare differently.
    what: What,
}

#[derive(Clone, Debug)]
enum What {
    Beacon(Vec2, Vec2),
    Report(Box<LinkReport>),
}

#[derive(Clone, Debug)]
pub(super) struct Net {
    pub(super) bots: Vec<Bot>,
    pub(super) radio: Radio,
    pub(super) wish: Wish,
    pub(super) now_us: u64,
    pub(super) chance: Chance,
    air: BTreeMap<(u64, u64), Message>,
    sent: u64,
}

impl Net {
    pub(super) fn new(seed: u64, places_w: &[Vec2], radio: Radio, wish: Wish) -> Self {
        let mut chance = Chance::new(seed);
        let mut ids: Vec<u32> = (1..=places_w.len() as u32).collect();
        (1..ids.len()).rev().for_each(|last| ids.swap(last, chance.below(last + 1)));
        let bots = places_w.iter().zip(ids).map(|(pos_w, id)| Bot::new(RobotId(id), *pos_w, &mut chance));
        let bots = bots.collect();
        Self { bots, radio, wish, now_us: 0, chance, air: BTreeMap::new(), sent: 0 }
    }

    /// Robots at random places that are connected from the start.
    pub(super) fn scattered(seed: u64, count: usize, radio: Radio, wish: Wish) -> Self {
        let mut chance = Chance::new(seed ^ 0xABCD);
        let mut places_w = vec![Vec2::zeros()];
        while places_w.len() < count {
            let beside = places_w[chance.below(places_w.len())];
            let way_m = (0.1 + 0.83 * chance.unit()) * PARAMS.propose_range_m();
            places_w.push(beside + chance.direction() * way_m);
        }
        Self::new(seed, &places_w, radio, wish)
    }

    pub(super) fn seconds(&self) -> f64 {
        self.now_us as f64 * 1e-6
    }

    pub(super) fn run(&mut self, span_s: f64, mut check: impl FnMut(&Self)) {
        let end_s = self.seconds() + span_s;
        while self.seconds() < end_s {
            self.step();
            check(self);
        }
    }

    fn step(&mut self) {
        let end_us = self.now_us + STEP_US;
        self.wish();
        // Messages and turns in the order of time; bodies move at the end, within what was promised until then.
        loop {
            let message_us = self.air.first_key_value().map_or(u64::MAX, |(key, _)| key.0);
            let turn = (0..self.bots.len()).filter(|at| self.bots[*at].alive).min_by_key(|at| self.bots[*at].due_us);
            let turn_us = turn.map_or(u64::MAX, |at| self.bots[at].due_us);
            if message_us.min(turn_us) >= end_us {
                break;
            }
            self.now_us = self.now_us.max(message_us.min(turn_us));
            match turn.filter(|_| turn_us < message_us) {
                Some(at) => self.turn(at),
                None => self.deliver(),
            }
        }
        self.now_us = end_us;
        self.bots.iter_mut().filter(|bot| bot.alive).for_each(Bot::travel);
    }

    fn wish(&mut self) {
        let middle_w = self.bots.iter().map(|bot| bot.pos_w).sum::<Vec2>() / self.bots.len() as f64;
        for bot in &mut self.bots {
            let away_w = bot.pos_w - middle_w;
            bot.wish_w = match self.wish {
                Wish::Stand => Vec2::zeros(),
                Wish::Along(wish_w) => wish_w,
                Wish::Apart => away_w.try_normalize(1e-9).unwrap_or_else(Vec2::x),
                Wish::Wander if self.chance.unit() < 0.03 => self.chance.direction(),
                Wish::Wander => bot.wish_w,
            };
        }
    }

    fn turn(&mut self, at: usize) {
        let bot = &mut self.bots[at];
        bot.due_us = self.now_us + bot.period_us;
        let (now, place) = (bot.now(self.now_us), bot.place());
        let near: Vec<LinkPeer> = bot.neighbours(self.now_us).collect();
        bot.links.tick(now, &place, &near, bot.pos_w.x);
        let report = Box::new(bot.links.report(now));
        let (id, pos_w, vel_w) = (bot.id, bot.pos_w, bot.vel_w);
        for to in 0..self.bots.len() {
            if to != at && (self.bots[to].pos_w - pos_w).norm() <= PARAMS.range_m {
                self.send(Message { to, from: id, sent_us: self.now_us, what: What::Beacon(pos_w, vel_w) });
                self.send(Message { to, from: id, sent_us: self.now_us, what: What::Report(report.clone()) });
            }
        }
    }

    fn send(&mut self, message: Message) {
        if self.chance.unit() >= self.radio.loss {
            let delay_us = 1_000 + (self.chance.unit() * self.radio.delay_s_max * 1e6) as u64;
            self.sent += 1;
            self.air.insert((self.now_us + delay_us, self.sent), message);
        }
    }

    fn deliver(&mut self) {
        let Some((_, message)) = self.air.pop_first() else { return };
        let bot = &mut self.bots[message.to];
        if !bot.alive {
            return;
        }
        match message.what {
            What::Beacon(pos_w, vel_w) => {
                let newest = bot.seen.get(&message.from).is_none_or(|seen| seen.0 < message.sent_us);
                if newest {
                    bot.seen.insert(message.from, (message.sent_us, pos_w, vel_w));
                }
            }
            What::Report(report) => {
                let (now, place) = (bot.now(self.now_us), bot.place());
                bot.links.handle_report(now, &report, &place);
            }
        }
    }

    pub(super) fn alive(&self) -> impl Iterator<Item = &Bot> + Clone {
        self.bots.iter().filter(|bot| bot.alive)
    }

    pub(super) fn bot(&self, id: RobotId) -> &Bot {
        self.bots.iter().find(|bot| bot.id == id).expect("a robot of the net")
    }

    /// The links that exist: held at the end that accepts, and obeyed by the owner.
    pub(super) fn existing(&self) -> Vec<LinkEdge> {
        let mut existing = Vec::new();
        for bot in self.alive() {
            for (owner, peer) in bot.links.peers.range(..bot.id) {
                let Some(held) = peer.pair.held.filter(|_| self.bot(*owner).alive) else { continue };
                let theirs = self.bot(*owner).links.peers.get(&bot.id).map(|peer| peer.pair);
                let Some(theirs) = theirs else { continue };
                if [theirs.held, theirs.pending].contains(&Some(held)) {
                    existing.push(super::edge(*owner, bot.id, held.made, held.weight_m));
                } else {
                    assert!(theirs.held.is_none(), "{owner} and {} hold different discs", bot.id);
                }
            }
        }
        existing
    }

    /// Whether the ends of links can all be reached from one another, and are all robots alive.
    pub(super) fn joined(&self, links: &[LinkEdge]) -> bool {
        let first = self.alive().next().map(|bot| bot.id);
        first.is_none_or(|first| reached(first, links.iter()).len() == self.alive().count())
    }

    /// Pairs in range of each other, as links.
    pub(super) fn in_range(&self) -> Vec<LinkEdge> {
        let alive: Vec<&Bot> = self.alive().collect();
        let pairs = alive.iter().flat_map(|a| alive.iter().map(move |b| (a, b)));
        let near = pairs.filter(|(a, b)| a.id < b.id && (a.pos_w - b.pos_w).norm() <= PARAMS.range_m);
        near.map(|(a, b)| super::edge(a.id, b.id, 0, 0.0)).collect()
    }

    pub(super) fn all_ready(&self) -> bool {
        self.alive().all(|bot| bot.links.ready())
    }

    /// The robot starts anew where it stands.
    pub(super) fn restart(&mut self, at: usize) {
        let (now_us, bot) = (self.now_us, &mut self.bots[at]);
        bot.epoch += 1;
        bot.alive = true;
        bot.clock_us = 0;
        bot.due_us = now_us;
        bot.links = Links::new(bot.id, bot.epoch, PARAMS, bot.now(now_us));
        bot.seen.clear();
    }
}

/// Who is reached from a robot over links.
pub(super) fn reached<'a>(from: RobotId, links: impl Iterator<Item = &'a LinkEdge> + Clone) -> BTreeSet<RobotId> {
    let (mut open, mut reached) = (vec![from], BTreeSet::from([from]));
    while let Some(at) = open.pop() {
        let other =
            |link: &LinkEdge| if link.low == at { Some(link.high) } else { (link.high == at).then_some(link.low) };
        open.extend(links.clone().filter_map(other).filter(|to| reached.insert(*to)));
    }
    reached
}

impl Bot {
    fn new(id: RobotId, pos_w: Vec2, chance: &mut Chance) -> Self {
        let clock_us = (chance.unit() * 1e9) as u64;
        let period_us = (100_000.0 + chance.unit() * 100_000.0) as u64;
        let due_us = (chance.unit() * 300_000.0) as u64;
        Self {
            id,
            links: Links::new(id, 1, PARAMS, Stamp::from_micros(clock_us)),
            pos_w,
            alive: true,
            vel_w: Vec2::zeros(),
            wish_w: chance.direction(),
            seen: BTreeMap::new(),
            epoch: 1,
            clock_us,
            due_us,
            period_us,
            stop_m: 0.0,
        }
    }

    fn now(&self, true_us: u64) -> Stamp {
        Stamp::from_micros(true_us + self.clock_us)
    }

    fn place(&self) -> Place {
        Place { pos_w: self.pos_w, wish_w: self.wish_w, stop_m: self.stop_m }
    }

    fn neighbours(&self, now_us: u64) -> impl Iterator<Item = LinkPeer> + '_ {
        let aged = self.seen.iter().map(move |(id, (sent_us, pos_w, vel_w))| {
            let age_s = (now_us - sent_us) as f64 * 1e-6;
            LinkPeer { id: *id, pos_w: *pos_w, vel_w: *vel_w, age_s }
        });
        aged.filter(|peer| peer.age_s <= 1.0)
    }

    pub(super) fn inside(&self, pos_w: Vec2) -> bool {
        self.links.discs().all(|disc| (disc.centre_w - pos_w).norm() <= disc.radius_m - self.stop_m + 1e-9)
    }

    /// Moves as fast as it can to where it wants, or along the edge of its discs.
    fn travel(&mut self) {
        let dt_s = STEP_US as f64 * 1e-6;
        let way_m = PARAMS.speed_mps_max * dt_s;
        let wish_w = if self.links.ready() { self.wish_w } else { Vec2::zeros() };
        let mut goal_w = self.pos_w + wish_w * way_m;
        for _ in 0..8 {
            for disc in self.links.discs() {
                let (off_w, room_m) = (goal_w - disc.centre_w, disc.radius_m - self.stop_m - 1e-6);
                if off_w.norm() > room_m {
                    goal_w = disc.centre_w + off_w.normalize() * room_m;
                }
            }
        }
        let step_w = goal_w - self.pos_w;
        let step_w = if step_w.norm() > way_m { step_w.normalize() * way_m } else { step_w };
        let tries = [1.0, 0.5, 0.25, 0.1].map(|share| self.pos_w + step_w * share);
        let next_w = tries.into_iter().find(|next_w| self.inside(*next_w)).unwrap_or(self.pos_w);
        self.vel_w = (next_w - self.pos_w) / dt_s;
        self.pos_w = next_w;
    }
}
