//! A hash of everything that bodies did: two runs with one digest were the same run.

use drover_world::Arena;
use std::fmt;

/// A running hash: two chains of 64 bits with different constants (the mixing step of SplitMix64, Steele et al. 2014).
///
/// It tells runs apart; it is no signature.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Digest {
    chains: [u64; 2],
}

impl Default for Digest {
    fn default() -> Self {
        Self { chains: [0x9E37_79B9_7F4A_7C15, 0xD1B5_4A32_D192_ED03] }
    }
}

impl Digest {
    /// Take in where every body is and how it moves.
    pub(crate) fn take_in(&mut self, arena: &Arena) {
        for robot in 0..arena.robot_count() {
            let state = arena.state(robot);
            let (pose, twist) = (state.pose_wb, state.twist_b);
            for number in [pose.x_m, pose.y_m, pose.yaw_rad, twist.speed_mps, twist.yaw_rate_radps] {
                self.word(number.to_bits());
            }
            self.word(u64::from(state.in_contact));
        }
    }

    fn word(&mut self, word: u64) {
        let [a, b] = &mut self.chains;
        *a = (*a ^ word).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        *a ^= *a >> 29;
        *b = (b.rotate_left(23) ^ word).wrapping_mul(0x94D0_49BB_1331_11EB);
        *b ^= *b >> 31;
    }
}

impl fmt::Display for Digest {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:016x}{:016x}", self.chains[0], self.chains[1])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_bit_or_another_order_changes_it() {
        let of = |words: &[u64]| {
            let mut digest = Digest::default();
            words.iter().for_each(|word| digest.word(*word));
            digest.to_string()
        };
        assert_eq!(of(&[1, 2]), of(&[1, 2]));
        assert_ne!(of(&[1, 2]), of(&[2, 1]));
        assert_ne!(of(&[1, 2]), of(&[1, 3]));
        assert_ne!(of(&[0]), of(&[0, 0]));
        assert_eq!(of(&[]).len(), 32);
    }
}
