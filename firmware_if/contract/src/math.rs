//! Functions that differ from one C library to the next, taken from one that is ours wherever we run.
//!
//! The platform's sine differs in its last bit between C libraries and even between processors of one library. Whatever
//! a seed must replay (worlds, bodies, laws) uses these instead; a `clippy.toml` in each pure crate bans the others.

/// Sine and cosine of an angle, radians.
#[must_use]
pub fn sin_cos(angle_rad: f64) -> (f64, f64) {
    libm::sincos(angle_rad)
}

/// The direction of (x, y), radians in -pi..=pi.
#[must_use]
pub fn atan2(y: f64, x: f64) -> f64 {
    libm::atan2(y, x)
}

pub use libm::{asin, cos, exp, log, sin};

/// (atan(x) - x) / x^3 for x in 0..=1 as a polynomial in x^2, the constant first: fitted here, minimax, error 7e-9.
pub const ATAN: [f32; 8] = [
    -0.333_329_86,
    0.199_903_95,
    -0.141_859_64,
    0.105_738_886,
    -0.073_666_2,
    0.041_120_894,
    -0.015_131_967,
    0.002_622_107_5,
];

/// The direction of (x, y), radians, to 4e-7: for intervals of beams, of which there are thousands a scan. (0, 0) gives
/// 0.
///
/// The arc tangent of a ratio up to 1 as a polynomial (fitted here, minimax over 0..=1, error 7e-9 before rounding),
/// and the octants by symmetry. Without a branch, so that a loop over it becomes vector instructions.
#[inline]
#[must_use]
pub fn quick_angle(y: f32, x: f32) -> f32 {
    use std::f32::consts::{FRAC_PI_2, PI};
    let (across, along) = (y.abs(), x.abs());
    let steep = across > along;
    let (small, large) = if steep { (along, across) } else { (across, along) };
    let ratio = small / if large > 0.0 { large } else { 1.0 };
    let s = ratio * ratio;
    let sum = ATAN.iter().rev().fold(0.0, |sum, c| sum * s + c);
    let octant = ratio + ratio * s * sum;
    let quarter = if steep { FRAC_PI_2 - octant } else { octant };
    let half = if x < 0.0 { PI - quarter } else { quarter };
    if y < 0.0 { -half } else { half }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_quick_angle_is_right_all_around() {
        for step in 0..100_000 {
            let true_rad = (f64::from(step) / 100_000.0 - 0.5) * std::f64::consts::TAU;
            let (sin, cos) = sin_cos(true_rad);
            let got = f64::from(quick_angle((3.0 * sin) as f32, (3.0 * cos) as f32));
            assert!(crate::wrap(got - true_rad).abs() < 4e-7, "{true_rad}: {got}");
        }
        assert!(quick_angle(0.0, 0.0) == 0.0 && (quick_angle(0.0, -1.0) - std::f32::consts::PI).abs() < 1e-6);
    }

    #[test]
    fn mirrored_points_have_mirrored_angles() {
        for step in 1..1_000 {
            let (y, x) = (step as f32 * 0.01, 3.0 - step as f32 * 0.006);
            assert!(quick_angle(-y, x).to_bits() == (-quick_angle(y, x)).to_bits());
        }
    }
}
