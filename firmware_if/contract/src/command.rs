//! The only thing that reaches a wheel.

use crate::Twist;
use serde::{Deserialize, Serialize};
use thiserror::Error;

/// What a body may be asked to do at most.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Limits {
    /// Fastest forward, m/s, > 0.
    pub speed_mps_max: f64,
    /// Fastest backwards, m/s, >= 0 (0: the robot never reverses).
    pub reverse_mps_max: f64,
    /// Fastest turn either way, rad/s, > 0.
    pub yaw_rate_radps_max: f64,
    /// Strongest speeding up, m/s^2, > 0.
    pub accel_mps2_max: f64,
    /// Braking that the body is sure to reach, m/s^2, > 0: stopping distances are computed with it.
    pub brake_mps2: f64,
    /// Strongest change of turn, rad/s^2, > 0.
    pub yaw_accel_radps2_max: f64,
}

/// A request held a NaN or an infinity.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
#[error("a command must be finite, not ({} m/s, {} rad/s)", .0.speed_mps, .0.yaw_rate_radps)]
pub struct NotFinite(pub Twist);

/// A twist that may be sent to a drive: finite and within the limits of its body (invariant 1).
///
/// The fields are private and there are two ways to get one; the supervisor is the only caller of
/// [`SafeCommand::bounded`] (a test reads the sources for it).
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct SafeCommand {
    twist_b: Twist,
}

impl SafeCommand {
    /// Stand still. Always feasible, always allowed.
    pub const STOP: Self = Self { twist_b: Twist::ZERO };

    /// `request`, clamped into `limits`.
    ///
    /// # Errors
    /// [`NotFinite`] if any number is a NaN or infinite: such a request is refused, not repaired.
    pub fn bounded(request: Twist, limits: &Limits) -> Result<Self, NotFinite> {
        let bounds = [limits.speed_mps_max, limits.reverse_mps_max, limits.yaw_rate_radps_max];
        if !request.is_finite() || bounds.iter().any(|bound| !bound.is_finite() || *bound < 0.0) {
            return Err(NotFinite(request));
        }
        let speed_mps = request.speed_mps.clamp(-limits.reverse_mps_max, limits.speed_mps_max);
        let yaw_rate_radps = request.yaw_rate_radps.clamp(-limits.yaw_rate_radps_max, limits.yaw_rate_radps_max);
        Ok(Self { twist_b: Twist { speed_mps, yaw_rate_radps } })
    }

    /// The twist, in the body frame.
    #[must_use]
    pub const fn twist_b(&self) -> Twist {
        self.twist_b
    }

    /// Whether this asks the body to stand still.
    #[must_use]
    pub fn is_stop(&self) -> bool {
        self.twist_b == Twist::ZERO
    }
}
