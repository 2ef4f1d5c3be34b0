//! The radio between robots of one process: range, loss, delay, and nothing else of a real one.
//!
//! Each receiver within range loses each message on its own and hears it after a delay of its own, so messages can
//! overtake each other.

use crate::chance::{Use, generator};
use drover_config::Radio as RadioParams;
use drover_contract::{Stamp, Vec2};
use rand::Rng;
use rand_pcg::Pcg32;
use std::collections::BTreeMap;
use std::sync::Arc;
use std::time::Duration;

/// Messages on their way at most; when there are more, the one due first is dropped.
const IN_FLIGHT_MAX: usize = 65_536;

/// What has happened on the air so far, counted by receiver: one broadcast to four robots in range counts four times.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct RadioTally {
    /// Sent on their way.
    pub carried: u64,
    /// Lost by chance.
    pub lost: u64,
    /// Not heard because the receiver was too far away.
    pub out_of_range: u64,
    /// Dropped because too many were on their way.
    pub dropped: u64,
}

/// A modelled radio.
#[derive(Clone, Debug)]
pub struct Radio {
    params: RadioParams,
    rng: Pcg32,
    /// By the moment of arrival, then in the order of sending.
    in_flight: BTreeMap<(Stamp, u64), Delivery>,
    sent: u64,
    tally: RadioTally,
}

/// A message to one receiver. The bytes are shared among all of them.
#[derive(Clone, Debug)]
struct Delivery {
    to: usize,
    bytes: Arc<[u8]>,
}

impl Radio {
    /// A quiet radio.
    #[must_use]
    pub fn new(params: RadioParams, seed: u64) -> Self {
        let rng = generator(seed, 0, Use::Radio);
        Self { params, rng, in_flight: BTreeMap::new(), sent: 0, tally: RadioTally::default() }
    }

    /// Robot `from` sends `bytes` to whoever hears it. `positions_w` are the true positions of all robots; a sender
    /// without a position is not heard.
    pub fn broadcast(&mut self, now: Stamp, from: usize, positions_w: &[Vec2], bytes: &[u8]) {
        let Some(from_w) = positions_w.get(from) else { return };
        let shared: Arc<[u8]> = bytes.into();
        for (to, to_w) in positions_w.iter().enumerate().filter(|(to, _)| *to != from) {
            if (to_w - from_w).norm() > self.params.range_m {
                self.tally.out_of_range += 1;
            } else if self.rng.random::<f64>() < self.params.loss {
                self.tally.lost += 1;
            } else {
                self.carry(now, to, Arc::clone(&shared));
            }
        }
    }

    /// The next message that has arrived by `now`, and at whom.
    pub fn poll(&mut self, now: Stamp) -> Option<(usize, Vec<u8>)> {
        let entry = self.in_flight.first_entry()?;
        if entry.key().0 > now {
            return None;
        }
        let Delivery { to, bytes } = entry.remove();
        Some((to, bytes.to_vec()))
    }

    /// When the next message arrives.
    #[must_use]
    pub fn poll_timeout(&self) -> Option<(Stamp, &'static str)> {
        self.in_flight.first_key_value().map(|((due, _), _)| (*due, "radio delivery"))
    }

    /// What has happened so far.
    #[must_use]
    pub fn tally(&self) -> RadioTally {
        self.tally
    }

    fn carry(&mut self, now: Stamp, to: usize, bytes: Arc<[u8]>) {
        let jitter_ms = self.params.jitter_ms * self.rng.random::<f64>();
        let delay = Duration::from_micros(((self.params.delay_ms + jitter_ms).max(0.0) * 1e3) as u64);
        if self.in_flight.len() >= IN_FLIGHT_MAX {
            self.in_flight.pop_first();
            self.tally.dropped += 1;
        }
        self.in_flight.insert((now + delay, self.sent), Delivery { to, bytes });
        self.sent += 1;
        self.tally.carried += 1;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn radio(loss: f64, delay_ms: f64, jitter_ms: f64) -> Radio {
        Radio::new(RadioParams { range_m: 10.0, loss, delay_ms, jitter_ms, ..RadioParams::default() }, 5)
    }

    fn line() -> Vec<Vec2> {
        [0.0, 5.0, 10.0, 10.1].map(|x| Vec2::new(x, 0.0)).to_vec()
    }

    fn drain(radio: &mut Radio, now: Stamp) -> Vec<(usize, Vec<u8>)> {
        std::iter::from_fn(|| radio.poll(now)).collect()
    }

    #[test]
    fn those_in_range_hear_it_after_the_delay_and_the_sender_does_not() {
        let mut radio = radio(0.0, 20.0, 0.0);
        radio.broadcast(Stamp::ZERO, 0, &line(), b"hello");
        assert_eq!(radio.poll(Stamp::from_millis(19)), None);
        assert_eq!(radio.poll_timeout(), Some((Stamp::from_millis(20), "radio delivery")));
        let heard = drain(&mut radio, Stamp::from_millis(20));
        assert_eq!(heard, vec![(1, b"hello".to_vec()), (2, b"hello".to_vec())]);
        assert_eq!(radio.tally().out_of_range, 1);
        assert_eq!(radio.poll_timeout(), None);
    }

    #[test]
    fn losses_come_as_often_as_asked_and_each_receiver_has_its_own() {
        let mut radio = radio(0.3, 0.0, 0.0);
        (0..2000).for_each(|_| radio.broadcast(Stamp::ZERO, 0, &line()[..3], b"x"));
        let heard = drain(&mut radio, Stamp::ZERO);
        let at = |robot| heard.iter().filter(|(to, _)| *to == robot).count() as f64 / 2000.0;
        assert!((at(1) - 0.7).abs() < 0.04 && (at(2) - 0.7).abs() < 0.04, "{} {}", at(1), at(2));
        assert_eq!(heard.len() as u64, radio.tally().carried);
        assert_eq!(radio.tally().carried + radio.tally().lost, 4000);
    }

    #[test]
    fn jitter_stays_in_its_bounds_and_lets_messages_overtake() {
        let mut radio = radio(0.0, 5.0, 10.0);
        for ms in 0..100u8 {
            radio.broadcast(Stamp::from_millis(u64::from(ms)), 0, &line()[..2], &[ms]);
        }
        let mut order = Vec::new();
        for us in 0..200_000 {
            let now = Stamp::from_micros(us);
            for (_, bytes) in drain(&mut radio, now) {
                let age_us = us - u64::from(bytes[0]) * 1000;
                assert!((5_000..=15_000).contains(&age_us), "{age_us}");
                order.push(bytes[0]);
            }
        }
        assert_eq!(order.len(), 100);
        assert!(!order.is_sorted(), "some message overtakes another");
    }

    #[test]
    fn the_air_holds_a_bounded_number_and_drops_the_first() {
        let mut radio = radio(0.0, 1.0, 0.0);
        let pair = &line()[..2];
        (0..=IN_FLIGHT_MAX).for_each(|n| radio.broadcast(Stamp::ZERO, 0, pair, &[u8::from(n == 0)]));
        assert_eq!(radio.tally().dropped, 1);
        let heard = drain(&mut radio, Stamp::from_millis(1));
        assert_eq!(heard.len(), IN_FLIGHT_MAX);
        assert!(heard.iter().all(|(_, bytes)| bytes == &[0]));
    }

    #[test]
    fn a_sender_without_a_position_is_not_heard() {
        let mut radio = radio(0.0, 0.0, 0.0);
        radio.broadcast(Stamp::ZERO, 9, &line(), b"ghost");
        assert_eq!(radio.poll(Stamp::from_millis(1)), None);
    }

    #[test]
    fn one_seed_gives_the_same_air_twice() {
        let run = || {
            let mut radio = radio(0.2, 1.0, 5.0);
            (0..50).for_each(|n| radio.broadcast(Stamp::from_millis(n), (n % 3) as usize, &line(), &[n as u8]));
            drain(&mut radio, Stamp::from_millis(1000))
        };
        assert_eq!(run(), run());
    }
}
