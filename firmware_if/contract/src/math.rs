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
