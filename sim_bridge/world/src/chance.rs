//! Chance from seeds: the same seed gives the same numbers, and no robot's numbers depend on another's.
//!
//! Two forms: a generator, for a stream that one owner draws in order; and [`Draws`], for events of which nobody keeps
//! an order (a message between two robots), where each number is a function of what the event is.

use rand::Rng;
use rand_pcg::Pcg32;
use std::f64::consts::TAU;

/// What chance is for: each use of each robot has its own.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Use {
    Slip,
    Lidar,
    Radio,
    Firmware,
    Phase,
}

impl Use {
    fn stream(self) -> u64 {
        match self {
            Self::Slip => 1,
            Self::Lidar => 2,
            Self::Radio => 3,
            Self::Firmware => 4,
            Self::Phase => 5,
        }
    }
}

/// The generator of one use of the robot with this key (its id, not its place in a list).
pub(crate) fn generator(seed: u64, key: u64, purpose: Use) -> Pcg32 {
    Pcg32::new(mix(seed ^ mix(key)), mix(purpose.stream() ^ key.rotate_left(32)))
}

/// When in its periods the robot with this key does what it does now and then: two shares of a period, 0..1.
#[must_use]
pub fn phases(seed: u64, key: u64) -> [f64; 2] {
    let mut rng = generator(seed, key, Use::Phase);
    [rng.random(), rng.random()]
}

/// A value of the standard normal distribution (Box and Muller 1958).
pub(crate) fn normal(rng: &mut Pcg32) -> f64 {
    let first = rng.random::<f64>();
    gaussian(first, rng.random::<f64>())
}

/// The numbers of one event, each a hash of the event's name and of which number it is (a counter-based generator,
/// after Salmon et al. 2011): who asks, when and in which order changes nothing.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Draws {
    name: u64,
}

impl Draws {
    /// All events of one use.
    pub(crate) fn new(seed: u64, purpose: Use) -> Self {
        Self { name: mix(seed ^ mix(purpose.stream())) }
    }

    /// Those of them that `key` sets apart. The order of keys matters: `of(a).of(b)` is not `of(b).of(a)`.
    pub(crate) fn of(self, key: u64) -> Self {
        // Turned by half, so that a narrower event's name is never one of this event's numbers.
        Self { name: mix(self.name.rotate_left(32) ^ key) }
    }

    /// Number `nth` of the event, evenly from 0 to just below 1.
    pub(crate) fn uniform(self, nth: u64) -> f64 {
        // The upper 53 bits are as many as a double holds.
        (mix(self.name ^ nth) >> 11) as f64 * (1.0 / (1_u64 << 53) as f64)
    }

    /// Number `nth` of the event, a whole one evenly from 0 to just below `end` (Lemire 2019; with an `end` that is
    /// tiny beside 2^64 it is as good as even).
    pub(crate) fn below(self, nth: u64, end: u64) -> u64 {
        ((u128::from(mix(self.name ^ nth)) * u128::from(end)) >> 64) as u64
    }

    /// Number `nth` of the event's nearly normal values: mean 0, deviation 1, never beyond 4.9 (the sum of eight even
    /// bytes, after Irwin 1927 and Hall 1927). A tenth of the price of [`normal`], for sensors with many beams and
    /// radios with many pairs.
    pub(crate) fn roughly_normal(self, nth: u64) -> f64 {
        const PAIRS: u64 = 0x00FF_00FF_00FF_00FF;
        // The mean and deviation of the sum of eight bytes: 8 * 127.5 and sqrt(8 * (256^2 - 1) / 12).
        const MEAN: f64 = 1_020.0;
        const PER_DEVIATION: f64 = 1.0 / 209.021_529_0;
        let bytes = mix(self.name ^ nth);
        let pairs = (bytes & PAIRS) + ((bytes >> 8) & PAIRS);
        let sum = pairs.wrapping_mul(0x0001_0001_0001_0001) >> 48;
        (sum as f64 - MEAN) * PER_DEVIATION
    }
}

/// A normal value out of two even ones in 0..1. The functions are libm's, the same on every machine.
fn gaussian(first: f64, second: f64) -> f64 {
    // 1 - u lies in (0, 1], where the logarithm is finite.
    (-2.0 * libm::log(1.0 - first)).sqrt() * libm::cos(TAU * second)
}

/// Spreads neighbouring numbers over all 64 bits (the finaliser of SplitMix64, Steele et al. 2014).
fn mix(value: u64) -> u64 {
    let z = value.wrapping_add(0x9E37_79B9_7F4A_7C15);
    let z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    let z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    z ^ (z >> 31)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn assert_standard_normal(values: &[f64]) {
        let mean = values.iter().sum::<f64>() / values.len() as f64;
        let variance = values.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / values.len() as f64;
        assert!(mean.abs() < 0.03, "mean {mean}");
        assert!((variance - 1.0).abs() < 0.05, "variance {variance}");
    }

    #[test]
    fn normal_values_have_mean_zero_and_deviation_one() {
        let mut rng = generator(1, 2, Use::Lidar);
        assert_standard_normal(&(0..20_000).map(|_| normal(&mut rng)).collect::<Vec<_>>());
        let draws = Draws::new(1, Use::Radio);
        assert_standard_normal(&(0..20_000).map(|nth| draws.roughly_normal(nth)).collect::<Vec<_>>());
    }

    #[test]
    fn seeds_robots_and_uses_have_numbers_of_their_own() {
        let first = |seed, key, purpose| generator(seed, key, purpose).random::<u64>();
        let base = first(1, 1, Use::Slip);
        assert_eq!(base, first(1, 1, Use::Slip));
        for other in [first(2, 1, Use::Slip), first(1, 2, Use::Slip), first(1, 1, Use::Lidar)] {
            assert_ne!(base, other);
        }
    }

    #[test]
    fn draws_are_even_and_neighbouring_events_have_nothing_in_common() {
        let radio = Draws::new(9, Use::Radio);
        for step in [|n: u64| (n, 0, 0), |n| (0, n, 0), |n| (0, 0, n)] {
            let event = |n| {
                let (a, b, nth) = step(n);
                radio.of(a).of(b).uniform(nth)
            };
            let values: Vec<f64> = (0..20_000).map(event).collect();
            let mean = values.iter().sum::<f64>() / values.len() as f64;
            let product = values.windows(2).map(|two| (two[0] - 0.5) * (two[1] - 0.5)).sum::<f64>();
            let correlation = 12.0 * product / values.len() as f64;
            assert!(values.iter().all(|value| (0.0..1.0).contains(value)));
            assert!((mean - 0.5).abs() < 4.0 * (1.0 / 12.0_f64 / 20_000.0).sqrt(), "mean {mean}");
            assert!(correlation.abs() < 4.0 / 20_000_f64.sqrt(), "correlation {correlation}");
        }
        assert!((radio.of(1).of(2).uniform(0) - radio.of(2).of(1).uniform(0)).abs() > 1e-9);
    }
}
