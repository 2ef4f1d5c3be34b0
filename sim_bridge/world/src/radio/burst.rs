//! Losses in bursts: a good and a bad state of every directed pair (Gilbert 1960, Elliott 1963), in continuous time.
//!
//! The state is looked at only when a message is sent. Between two looks `dt` seconds apart the two-state chain with
//! the rates `enter` and `leave` forgets where it was: it is bad with the chance
//! `bad + (was_bad - bad) exp(-(enter + leave) dt)`, where `bad = enter / (enter + leave)` is the share of time that is
//! bad in the long run. This is exact for any `dt`, so a pair costs nothing while it is silent.

use drover_config::Burst;
use drover_contract::Stamp;

/// A pair that was silent for this long begins anew, s. It bounds the memory to pairs that met lately.
const KEPT_S_MAX: f64 = 60.0;
/// After this many relaxation times a double holds nothing of the old state: exp(-40) < 2^-53.
const RELAXATIONS_MAX: f64 = 40.0;

/// The states of all directed pairs that talked lately.
#[derive(Clone, Debug)]
pub(super) struct Bursts {
    rule: Burst,
    /// Share of time that is bad in the long run, 0..1.
    bad_share: f64,
    /// How fast the past is forgotten, per second.
    rate_per_s: f64,
    /// A silence longer than this begins anew, us.
    kept_us: u64,
    /// By sender, then by receiver, ascending: a broadcast finds all its receivers in one place.
    pairs: Vec<Vec<Pair>>,
    /// The last silence, us, and what it left of the past, 0..=1: a steady sender's are all alike.
    memory: (u64, f64),
}

/// One direction of a pair, as it was when last looked at.
#[derive(Clone, Copy, Debug)]
struct Pair {
    to: u32,
    bad: bool,
    seen: Stamp,
}

impl Bursts {
    /// Pairs of `robots` robots that have not talked yet.
    pub(super) fn new(rule: Burst, robots: usize) -> Self {
        let rate_per_s = rule.enter_per_s + rule.leave_per_s;
        let kept_s = (RELAXATIONS_MAX / rate_per_s).min(KEPT_S_MAX);
        let bad_share = rule.enter_per_s / rate_per_s;
        Self {
            rule,
            bad_share,
            rate_per_s,
            kept_us: (kept_s * 1e6) as u64,
            pairs: vec![Vec::new(); robots],
            memory: (0, 1.0),
        }
    }

    /// Share of messages lost from `from` to `to` at `now`, 0..=1, if the pair is in the bad state; `None` if it is in
    /// the good one. `draw` is the chance of this message on this pair, evenly from 0..1.
    pub(super) fn loss(&mut self, now: Stamp, from: u32, to: u32, draw: f64) -> Option<f64> {
        let found = self.pairs[from as usize].binary_search_by_key(&to, |pair| pair.to);
        let bad_chance = match found {
            Ok(place) => self.bad_chance(now, self.pairs[from as usize][place]),
            Err(_) => self.bad_share,
        };
        let bad = draw < bad_chance;
        let (seen, pairs) = (Pair { to, bad, seen: now }, &mut self.pairs[from as usize]);
        match found {
            Ok(place) => pairs[place] = seen,
            Err(place) => insert(pairs, place, seen, self.kept_us),
        }
        bad.then_some(self.rule.loss)
    }

    /// Heap bytes held.
    pub(super) fn bytes(&self) -> usize {
        let pairs: usize = self.pairs.iter().map(Vec::capacity).sum();
        pairs * size_of::<Pair>() + self.pairs.capacity() * size_of::<Vec<Pair>>()
    }

    /// The chance that a pair is in the bad state now.
    fn bad_chance(&mut self, now: Stamp, pair: Pair) -> f64 {
        let silent_us = now.as_micros().saturating_sub(pair.seen.as_micros());
        // Whether the old state still counts is a matter of its age alone, and not of when others made room.
        if silent_us > self.kept_us {
            return self.bad_share;
        }
        if self.memory.0 != silent_us {
            self.memory = (silent_us, libm::exp(-self.rate_per_s * silent_us as f64 * 1e-6));
        }
        let was_bad = if pair.bad { 1.0 } else { 0.0 };
        self.bad_share + (was_bad - self.bad_share) * self.memory.1
    }
}

/// Insert at `place`, which keeps the order; before the list has to grow, pairs that were silent too long go.
fn insert(pairs: &mut Vec<Pair>, place: usize, new: Pair, kept_us: u64) {
    if pairs.len() < pairs.capacity() {
        pairs.insert(place, new);
        return;
    }
    pairs.retain(|pair| new.seen.since(pair.seen).as_micros() as u64 <= kept_us);
    let place = pairs.partition_point(|pair| pair.to < new.to);
    pairs.insert(place, new);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::chance::{Draws, Use};

    const RULE: Burst = Burst { enter_per_s: 0.5, leave_per_s: 2.0, loss: 1.0 };

    /// Whether each of `count` messages, one every `period_ms`, finds the pair bad.
    fn states(rule: Burst, count: u64, period_ms: u64) -> Vec<bool> {
        let (mut bursts, draws) = (Bursts::new(rule, 2), Draws::new(3, Use::Radio));
        let state = |n| bursts.loss(Stamp::from_millis(n * period_ms), 0, 1, draws.uniform(n)).is_some();
        (0..count).map(state).collect()
    }

    /// Mean and number of the runs of bad states.
    fn runs(states: &[bool]) -> (f64, f64) {
        let bad = states.iter().filter(|bad| **bad).count() as f64;
        let ends = states.windows(2).filter(|two| two[0] && !two[1]).count() as f64;
        (bad / ends, ends)
    }

    #[test]
    fn the_share_of_bad_states_and_the_length_of_bursts_are_those_of_the_chain() {
        for period_ms in [20, 100, 1000] {
            let states = states(RULE, 200_000, period_ms);
            let bad_share = states.iter().filter(|bad| **bad).count() as f64 / states.len() as f64;
            let memory = libm::exp(-2.5 * period_ms as f64 * 1e-3);
            // A sum of numbers that resemble their neighbours by `memory` varies (1 + memory) / (1 - memory) as much.
            let sigma = (0.2 * 0.8 * (1.0 + memory) / (1.0 - memory) / states.len() as f64).sqrt();
            assert!((bad_share - 0.2).abs() < 4.0 * sigma, "{period_ms} ms: {bad_share}");
            let (mean_run, count) = runs(&states);
            let stay = 0.2 + 0.8 * memory;
            let expected = 1.0 / (1.0 - stay);
            let sigma = stay.sqrt() / (1.0 - stay) / count.sqrt();
            assert!((mean_run - expected).abs() < 4.0 * sigma, "{period_ms} ms: {mean_run} not {expected}");
        }
    }

    #[test]
    fn a_burst_lasts_one_over_leave_per_s_on_average() {
        // At 1 ms the chain is looked at as good as continuously.
        let (mean_run, count) = runs(&states(RULE, 2_000_000, 1));
        assert!((mean_run * 1e-3 - 0.5).abs() < 4.0 * 0.5 / count.sqrt() + 1e-3, "{mean_run} ms");
    }

    #[test]
    fn a_rule_that_never_turns_bad_is_always_good() {
        assert!(states(Burst { enter_per_s: 0.0, ..RULE }, 1000, 100).iter().all(|bad| !bad));
    }

    #[test]
    fn pairs_that_fell_silent_make_room_and_it_changes_nothing() {
        let draws = Draws::new(3, Use::Radio);
        let slow = Burst { enter_per_s: 1e-3, leave_per_s: 1e-3, loss: 1.0 };
        let (mut crowded, mut alone) = (Bursts::new(slow, 2), Bursts::new(slow, 2));
        for n in 0..50_000_u64 {
            let now = Stamp::from_millis(n * 100);
            // To a new stranger each time, to robot 0 now and then, with silences shorter and longer than what is kept.
            let _ = crowded.loss(now, 1, 1 + n as u32, draws.of(1).uniform(n));
            if n % 1200 < 400 && n % 7 == 0 {
                let draw = draws.of(0).uniform(n);
                assert_eq!(crowded.loss(now, 1, 0, draw), alone.loss(now, 1, 0, draw));
            }
        }
        assert!(crowded.pairs[1].capacity() <= 4 * 600, "{}", crowded.pairs[1].capacity());
        assert!(crowded.pairs[1].is_sorted_by_key(|pair| pair.to));
    }
}
