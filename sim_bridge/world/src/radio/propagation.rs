//! Which directed pairs hear each other, and how well: range, distance, walls, shadowing.
//!
//! What a pair differs by (the factor on its range, its shadowing) is a function of the seed and the two ids, so it is
//! drawn anew each time and nothing is kept.

use crate::chance::Draws;
use drover_config::Propagation;

/// Which number of a pair's draws is what.
const ASYMMETRY: u64 = 0;
const SHADOW: u64 = 1;

/// How far one direction of a pair hears, metres: `range_m` times a factor drawn evenly from `1 - asymmetry ..= 1`.
pub(super) fn pair_range_m(range_m: f64, asymmetry: f64, pair: Draws) -> f64 {
    range_m * (1.0 - asymmetry * pair.uniform(ASYMMETRY))
}

/// Share of messages that survive the way, 0..=1, over `distance_m` metres and through `walls` walls: log-distance path
/// loss with log-normal shadowing (Rappaport 2002, section 4.9; the normal value is cut off at 4.9 deviations),
/// softened by a logistic function.
pub(super) fn share_received(rule: &Propagation, distance_m: f64, walls: u32, pair: Draws) -> f64 {
    // Nearer than a millimetre is on the antenna: the logarithm stays finite.
    let path_db = 10.0 * rule.exponent * libm::log10(rule.half_range_m / distance_m.max(1e-3));
    let shadow_db = if rule.shadow_db > 0.0 { rule.shadow_db * pair.roughly_normal(SHADOW) } else { 0.0 };
    let margin_db = path_db - rule.wall_db * f64::from(walls) + shadow_db;
    1.0 / (1.0 + libm::exp(-margin_db / rule.soft_db))
}
