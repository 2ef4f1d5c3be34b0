//! The radio between robots of one process: who hears which message, and when.
//!
//! A broadcast is decided when it is sent, receiver by receiver: out of range, on the other side of a partition
//! (`partition`), no free air (`airtime`), lost (`burst`, `propagation` and plain chance), or on its way (`queue`) with
//! a delay of its own, so that messages can overtake each other, and now and then twice.
//!
//! Chance is a function of the seed, the two ids and the number of the message at its sender. No result depends on the
//! order in which receivers are visited, and none but airtime's and the bound's on what other robots do.
//!
//! Cost with 10,000 robots, 30 neighbours each, range and plain loss: 35 to 45 ns a delivery from sending to handing
//! out, beside the scene's own search for neighbours; 12 bytes while it is on its way.

mod airtime;
mod burst;
mod partition;
mod propagation;
mod queue;
mod scene;

pub use scene::Scene;

use crate::chance::{Draws, Use};
use airtime::Air;
use burst::Bursts;
use drover_config::{Propagation, Radio as Params};
use drover_contract::{Stamp, Vec2};
use partition::Partitions;
use queue::{Calendar, Messages};

/// Deliveries on their way at most, in a small swarm and for each robot of a large one; when there are more, the new
/// ones are dropped.
const IN_FLIGHT_MAX: usize = 1 << 20;
const IN_FLIGHT_MAX_PER_ROBOT: usize = 256;

/// Whether draws are of a pair, the same for the whole run, or of one message on its way between the two.
const OF_PAIR: u64 = 0;
const OF_MESSAGE: u64 = 1;
/// Which number of a message's draws is what.
const LOSS: u64 = 0;
const BURST: u64 = 1;
const JITTER: u64 = 2;
const DUPLICATE: u64 = 3;
const JITTER_OF_COPY: u64 = 4;

/// What has happened on the air so far. All but `sent` and `duplicated` are counted by receiver: one broadcast to four
/// robots in range counts four times, once in one of these fields.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct RadioTally {
    /// Messages sent.
    pub sent: u64,
    /// Sent on their way.
    pub carried: u64,
    /// Lost by chance.
    pub lost: u64,
    /// Not heard because the receiver was too far away, or has no position.
    pub out_of_range: u64,
    /// Lost because the air around the receiver was busy for too long.
    pub crowded: u64,
    /// Not heard because the receiver was on the other side of a partition.
    pub partitioned: u64,
    /// Second copies sent on their way.
    pub duplicated: u64,
    /// Dropped because too many were on their way, or due more than a minute after the oldest that nobody fetched;
    /// second copies too.
    pub dropped: u64,
}

/// A message that has arrived.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Delivery<M> {
    /// Index of the robot that hears it.
    pub to: usize,
    /// Index of the robot that sent it.
    pub from: usize,
    /// The message.
    pub message: M,
}

/// A modelled radio for messages of one kind: bytes as on the wire, or values. Robots are named by their index in the
/// list of ids that it was made with.
#[derive(Clone, Debug)]
pub struct Radio<M> {
    params: Params,
    /// Shortest delay, us.
    delay_us: u64,
    /// What is added to it is less than this, us.
    jitter_us_end: u64,
    ids: Vec<u32>,
    draws: Draws,
    partitions: Partitions,
    air: Option<Air>,
    bursts: Option<Bursts>,
    /// Messages sent so far, by sender.
    sent_by: Vec<u64>,
    calendar: Calendar,
    messages: Messages<M>,
    /// Receivers of the present broadcast; kept for its memory.
    near: Vec<u32>,
    tally: RadioTally,
}

/// A broadcast that is being decided.
#[derive(Clone, Copy)]
struct Sending {
    now: Stamp,
    from: u32,
    from_w: Vec2,
    /// What this sender's pairs differ by; still without the receiver.
    pair: Draws,
    /// The chance of this message; still without the receiver.
    message: Draws,
    slot: u32,
}

impl<M> Radio<M> {
    /// A quiet radio between robots with these ids, each once. `seed` and the ids decide all chance.
    #[must_use]
    pub fn new(params: &Params, ids: &[u32], seed: u64) -> Self {
        let robots = ids.len();
        Self {
            draws: Draws::new(seed, Use::Radio),
            partitions: Partitions::new(&params.partitions, ids),
            air: params.airtime.as_ref().map(|rule| Air::new(rule, robots)),
            bursts: params.burst.map(|rule| Bursts::new(rule, robots)),
            sent_by: vec![0; robots],
            calendar: Calendar::new(IN_FLIGHT_MAX.max(IN_FLIGHT_MAX_PER_ROBOT * robots)),
            messages: Messages::new(),
            near: Vec::new(),
            tally: RadioTally::default(),
            delay_us: micros(params.delay_ms),
            jitter_us_end: micros(params.jitter_ms).saturating_add(1),
            params: params.clone(),
            ids: ids.to_vec(),
        }
    }

    /// Robot `from` sends a message at `now` to whoever hears it. A sender that does not exist or has no position is
    /// not heard. Time never goes back from call to call.
    pub fn broadcast<S: Scene + ?Sized>(&mut self, now: Stamp, from: usize, scene: &S, message: M) {
        let Some(id) = self.ids.get(from).copied().map(u64::from) else { return };
        let Some(from_w) = scene.position_w(from) else { return };
        self.tally.sent += 1;
        self.sent_by[from] += 1;
        self.calendar.begin(now.as_micros());
        self.find_near(from, from_w, scene);
        let sending = Sending {
            now,
            from: from as u32,
            from_w,
            pair: self.draws.of(OF_PAIR).of(id),
            message: self.draws.of(OF_MESSAGE).of(id).of(self.sent_by[from]),
            slot: self.messages.put(from as u32, message),
        };
        let near = std::mem::take(&mut self.near);
        let on_their_way = near.iter().map(|to| self.send(&sending, *to, scene)).sum();
        self.tally.out_of_range += (self.ids.len() - 1 - near.len()) as u64;
        self.near = near;
        self.messages.expect(sending.slot, on_their_way);
    }

    /// Hand out everything that has arrived by `now`: to whom (index), from whom (index), and the message. In the order
    /// of arrival; what arrives in the same microsecond, in the order of sending and then of the receivers' indices.
    pub fn deliver(&mut self, now: Stamp, mut hand_out: impl FnMut(usize, usize, &M)) {
        loop {
            let arrived = self.calendar.take(now.as_micros(), usize::MAX);
            if arrived.is_empty() {
                return;
            }
            for due in arrived {
                self.messages.show(due.slot, |from, message| hand_out(due.to as usize, from, message));
            }
        }
    }

    /// The next message that has arrived by `now`, in the order of [`Radio::deliver`].
    pub fn poll(&mut self, now: Stamp) -> Option<Delivery<M>>
    where
        M: Clone,
    {
        let due = *self.calendar.take(now.as_micros(), 1).first()?;
        let mut arrived = None;
        self.messages.show(due.slot, |from, message| {
            arrived = Some(Delivery { to: due.to as usize, from, message: message.clone() });
        });
        arrived
    }

    /// When the next message arrives.
    #[must_use]
    pub fn poll_timeout(&self) -> Option<(Stamp, &'static str)> {
        self.calendar.next_due_us().map(|due_us| (Stamp::from_micros(due_us), "radio delivery"))
    }

    /// What has happened so far.
    #[must_use]
    pub fn tally(&self) -> RadioTally {
        self.tally
    }

    /// Deliveries on their way now.
    #[must_use]
    pub fn in_flight(&self) -> usize {
        self.calendar.len()
    }

    /// Heap memory held, bytes, without what the messages themselves point to.
    #[must_use]
    pub fn bytes(&self) -> usize {
        let lists = (self.ids.capacity() + self.near.capacity()) * size_of::<u32>();
        let optional = self.air.as_ref().map_or(0, Air::bytes) + self.bursts.as_ref().map_or(0, Bursts::bytes);
        let counters = self.sent_by.capacity() * size_of::<u64>();
        lists + counters + optional + self.partitions.bytes() + self.calendar.bytes() + self.messages.bytes()
    }

    /// List who is in range, in the order of their indices, whatever the order of visits.
    fn find_near<S: Scene + ?Sized>(&mut self, from: usize, from_w: Vec2, scene: &S) {
        let (robots, range_m, near) = (self.ids.len(), self.params.range_m, &mut self.near);
        near.clear();
        scene.for_each_near(from_w, range_m, &mut |to| {
            let to_w = scene.position_w(to).filter(|_| to != from && to < robots);
            let within = to_w.is_some_and(|to_w| (to_w - from_w).norm_squared() <= range_m * range_m);
            // Listed and struck off again: a branch here would be guessed wrong every other time.
            near.push(to as u32);
            near.truncate(near.len() - usize::from(!within));
        });
        near.sort_unstable();
        near.dedup();
        if self.params.asymmetry > 0.0 {
            let (ids, pairs) = (&self.ids, self.draws.of(OF_PAIR).of(u64::from(self.ids[from])));
            near.retain(|to| {
                let pair = pairs.of(u64::from(ids[*to as usize]));
                let pair_range_m = propagation::pair_range_m(range_m, self.params.asymmetry, pair);
                scene.position_w(*to as usize).is_some_and(|to_w| (to_w - from_w).norm() <= pair_range_m)
            });
        }
    }

    /// Decide about one receiver in range; how many deliveries are on their way to it.
    fn send<S: Scene + ?Sized>(&mut self, sending: &Sending, to: u32, scene: &S) -> u32 {
        if self.partitions.part(sending.now, sending.from, to) {
            self.tally.partitioned += 1;
            return 0;
        }
        let heard = match &mut self.air {
            Some(air) => air.take(sending.now, to),
            None => Some(sending.now),
        };
        // What is lost by chance has been on the air all the same.
        let Some(heard) = heard else {
            self.tally.crowded += 1;
            return 0;
        };
        let draws = sending.message.of(u64::from(self.ids[to as usize]));
        if draws.uniform(LOSS) < self.loss(sending, to, scene, draws) {
            self.tally.lost += 1;
            return 0;
        }
        let first = self.carry(heard, draws.below(JITTER, self.jitter_us_end), to, sending.slot);
        self.tally.carried += u64::from(first);
        if self.params.duplicate <= 0.0 || self.params.duplicate <= draws.uniform(DUPLICATE) {
            return first;
        }
        let second = self.carry(heard, draws.below(JITTER_OF_COPY, self.jitter_us_end), to, sending.slot);
        self.tally.duplicated += u64::from(second);
        first + second
    }

    /// Share of messages lost by chance on this way, 0..=1.
    fn loss<S: Scene + ?Sized>(&mut self, sending: &Sending, to: u32, scene: &S, draws: Draws) -> f64 {
        let in_burst =
            self.bursts.as_mut().and_then(|bursts| bursts.loss(sending.now, sending.from, to, draws.uniform(BURST)));
        let loss = in_burst.unwrap_or(self.params.loss);
        match self.params.propagation {
            Some(rule) => 1.0 - (1.0 - loss) * self.share_received(&rule, sending, to, scene),
            None => loss,
        }
    }

    fn share_received<S: Scene + ?Sized>(&self, rule: &Propagation, sending: &Sending, to: u32, scene: &S) -> f64 {
        let Some(to_w) = scene.position_w(to as usize) else { return 0.0 };
        let walls = if rule.wall_db > 0.0 { scene.walls_between(sending.from_w, to_w) } else { 0 };
        let pair = sending.pair.of(u64::from(self.ids[to as usize]));
        propagation::share_received(rule, (to_w - sending.from_w).norm(), walls, pair)
    }

    /// Send a delivery on its way; 1 if there was room for it.
    fn carry(&mut self, heard: Stamp, jitter_us: u64, to: u32, slot: u32) -> u32 {
        let due_us = heard.as_micros().saturating_add(self.delay_us.saturating_add(jitter_us));
        let room = self.calendar.push(due_us, to, slot);
        self.tally.dropped += u64::from(!room);
        u32::from(room)
    }
}

/// Whole microseconds, 0 if negative.
fn micros(ms: f64) -> u64 {
    (ms * 1e3) as u64
}

#[cfg(test)]
mod tests;
