//! Chance from seeds: the same seed gives the same numbers, and no robot's numbers depend on another's.

use rand::Rng;
use rand_pcg::Pcg32;
use std::f64::consts::TAU;

/// What a generator is for: each use of each robot has its own.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Use {
    Slip,
    Lidar,
    Radio,
    Firmware,
}

/// The generator of one use of the robot with this key (its id, not its place in a list).
pub(crate) fn generator(seed: u64, key: u64, purpose: Use) -> Pcg32 {
    let stream = match purpose {
        Use::Slip => 1,
        Use::Lidar => 2,
        Use::Radio => 3,
        Use::Firmware => 4,
    };
    Pcg32::new(mix(seed ^ mix(key)), mix(stream ^ key.rotate_left(32)))
}

/// A value of the standard normal distribution (Box and Muller 1958).
pub(crate) fn normal(rng: &mut Pcg32) -> f64 {
    // 1 - u lies in (0, 1], where the logarithm is finite.
    let radius = (-2.0 * (1.0 - rng.random::<f64>()).ln()).sqrt();
    radius * (TAU * rng.random::<f64>()).cos()
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

    #[test]
    fn normal_values_have_mean_zero_and_deviation_one() {
        let mut rng = generator(1, 2, Use::Lidar);
        let values: Vec<f64> = (0..20_000).map(|_| normal(&mut rng)).collect();
        let mean = values.iter().sum::<f64>() / values.len() as f64;
        let variance = values.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / values.len() as f64;
        assert!(mean.abs() < 0.03, "mean {mean}");
        assert!((variance - 1.0).abs() < 0.05, "variance {variance}");
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
}
