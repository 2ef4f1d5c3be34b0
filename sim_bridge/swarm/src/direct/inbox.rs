//! What is said and what has arrived: beacons are kept once, and who hears one gets its number.
//!
//! Handing out a hundred thousand messages a step must not touch every robot's memory, nor count references: it sorts
//! numbers by receiver in one compact list.

use drover_config::Radio;
use drover_contract::{Beacon, LinkReport, MapReport, Stamp};
use std::collections::VecDeque;
use std::ops::Range;
use std::time::Duration;

/// A beacon's number: how many were said before it, modulo 2^32.
pub(super) type Number = u32;

/// What a robot says at once.
#[derive(Clone, Debug)]
pub(super) struct Words {
    pub(super) beacon: Beacon,
    /// Of its links, if its behaviour keeps any.
    pub(super) links: Option<Box<LinkReport>>,
    /// Of the map, if its behaviour makes one.
    pub(super) maps: Vec<MapReport>,
}

/// Beacons on their way, and those that have arrived since the last turn.
pub(super) struct Inbox {
    said: VecDeque<Words>,
    /// Number of the oldest that is kept.
    oldest: Number,
    /// No message is on its way for longer than this.
    lifetime: Duration,
    /// In the order of arrival: receiver and number.
    arrived: Vec<(u32, Number)>,
    /// Numbers by receiver, each receiver's in the order of arrival.
    order: Vec<Number>,
    /// `starts[robot]..starts[robot + 1]` of `order` is a robot's.
    starts: Vec<u32>,
}

impl Inbox {
    /// Nothing has been said. `step` is how often it is sorted.
    pub(super) fn new(radio: &Radio, step: Duration) -> Self {
        let on_air_ms = radio.airtime.map_or(0.0, |airtime| airtime.message_ms + airtime.wait_ms_max);
        // Twice over: rounding, and a copy with a delay of its own.
        let longest_ms = 2.0 * (radio.delay_ms + radio.jitter_ms + on_air_ms);
        Self {
            said: VecDeque::new(),
            oldest: 0,
            lifetime: Duration::from_secs_f64(longest_ms / 1e3) + step * 2,
            arrived: Vec::new(),
            order: Vec::new(),
            starts: Vec::new(),
        }
    }

    /// A beacon is said; the number that those who hear it get.
    pub(super) fn say(&mut self, words: Words) -> Number {
        self.said.push_back(words);
        self.oldest.wrapping_add(self.said.len() as u32 - 1)
    }

    /// A turn begins: forget what had arrived before it, and what nobody can hear any more.
    pub(super) fn clear(&mut self, now: Stamp) {
        self.arrived.clear();
        self.starts.clear();
        while self.said.front().is_some_and(|words| words.beacon.sent + self.lifetime < now) {
            self.said.pop_front();
            self.oldest = self.oldest.wrapping_add(1);
        }
    }

    pub(super) fn put(&mut self, to: usize, number: Number) {
        self.arrived.push((to as u32, number));
    }

    /// All that arrives has been put in: sort it by receiver, of which there are `robots`. A counting sort.
    pub(super) fn sort(&mut self, robots: usize) {
        self.starts.resize(robots + 1, 0);
        for (to, _) in &self.arrived {
            self.starts[*to as usize] += 1;
        }
        let mut end = 0;
        for start in &mut self.starts {
            end += *start;
            *start = end;
        }
        // Filled from behind, so that every start ends where its run begins.
        self.order.resize(self.arrived.len(), 0);
        for (to, number) in self.arrived.iter().rev() {
            let start = &mut self.starts[*to as usize];
            *start -= 1;
            self.order[*start as usize] = *number;
        }
    }

    /// What has arrived for `robot`, in the order of arrival.
    pub(super) fn of(&self, robot: usize) -> impl Iterator<Item = &Words> + '_ {
        let at = |robot: usize| self.starts.get(robot).map_or(0, |start| *start as usize);
        let run: Range<usize> = at(robot)..at(robot + 1);
        self.order[run].iter().filter_map(|number| self.said.get(number.wrapping_sub(self.oldest) as usize))
    }

    /// Heap bytes held.
    pub(super) fn bytes(&self) -> usize {
        self.said.capacity() * size_of::<Words>()
            + self.arrived.capacity() * size_of::<(u32, Number)>()
            + (self.order.capacity() + self.starts.capacity()) * size_of::<u32>()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use drover_contract::{BehaviourState, Pose, RobotId, Twist};

    fn beacon(seq: u32, sent: Stamp) -> Words {
        let beacon = Beacon {
            robot: RobotId(1),
            epoch: 1,
            seq,
            sent,
            pose_wb: Pose::default(),
            twist_b: Twist::ZERO,
            accel_mps2: 0.0,
            pos_bound_m: 0.0,
            radius_m: 0.3,
            state: BehaviourState::Active,
            progress: 0.0,
            leader: None,
        };
        Words { beacon, links: None, maps: Vec::new() }
    }

    fn inbox() -> Inbox {
        Inbox::new(&Radio::default(), Duration::from_millis(5))
    }

    fn heard(inbox: &Inbox, robot: usize) -> Vec<u32> {
        inbox.of(robot).map(|words| words.beacon.seq).collect()
    }

    #[test]
    fn everybody_gets_what_is_his_in_the_order_of_arrival() {
        let mut inbox = inbox();
        assert_eq!(inbox.of(0).count(), 0, "nothing before the first sort");
        let numbers: Vec<Number> = (0..6).map(|seq| inbox.say(beacon(seq, Stamp::ZERO))).collect();
        for (number, to) in numbers.into_iter().zip([2, 0, 2, 3, 0, 2]) {
            inbox.put(to, number);
        }
        inbox.sort(5);
        let all: Vec<Vec<u32>> = (0..5).map(|robot| heard(&inbox, robot)).collect();
        assert_eq!(all, [vec![1, 4], vec![], vec![0, 2, 5], vec![3], vec![]]);
        inbox.clear(Stamp::ZERO);
        inbox.sort(5);
        assert_eq!(inbox.of(2).count(), 0);
    }

    #[test]
    fn what_is_on_its_way_is_kept_as_long_as_it_may_be_and_no_longer() {
        let mut inbox = inbox();
        let early = inbox.say(beacon(1, Stamp::ZERO));
        let late = inbox.say(beacon(2, Stamp::from_millis(100)));
        inbox.clear(Stamp::from_millis(10));
        inbox.put(0, early);
        inbox.sort(1);
        assert_eq!(heard(&inbox, 0), [1], "delay and jitter of 5 ms, twice, and two steps");
        inbox.clear(Stamp::from_millis(100));
        assert_eq!(inbox.said.len(), 1, "the first is gone");
        inbox.put(0, late);
        inbox.sort(1);
        assert_eq!(heard(&inbox, 0), [2]);
    }
}
