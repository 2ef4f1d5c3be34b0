//! Points, poses and velocities in the plane.

use crate::math::{sin, sin_cos};
use serde::{Deserialize, Serialize};
use std::f64::consts::{PI, TAU};

/// A point or vector in the plane, metres (or metres per second); its name says the frame.
pub type Vec2 = nalgebra::Vector2<f64>;

/// The same angle in (-pi, pi]. The one `wrap` there is.
#[must_use]
pub fn wrap(angle_rad: f64) -> f64 {
    if angle_rad > -PI && angle_rad <= PI {
        return angle_rad;
    }
    let turned = angle_rad.rem_euclid(TAU);
    if turned > PI { turned - TAU } else { turned }
}

/// A frame's position and heading in another frame: `pose_wb` is the body in the world.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Pose {
    /// East (or forward), metres.
    pub x_m: f64,
    /// North (or left), metres.
    pub y_m: f64,
    /// Heading, radians, counter-clockwise from x, in (-pi, pi].
    pub yaw_rad: f64,
}

impl Pose {
    /// A pose; the heading is wrapped.
    #[must_use]
    pub fn new(x_m: f64, y_m: f64, yaw_rad: f64) -> Self {
        Self { x_m, y_m, yaw_rad: wrap(yaw_rad) }
    }

    /// The origin of the inner frame, in the outer one.
    #[must_use]
    pub fn position(&self) -> Vec2 {
        Vec2::new(self.x_m, self.y_m)
    }

    /// The direction of the inner x axis, in the outer frame: a unit vector.
    #[must_use]
    pub fn heading(&self) -> Vec2 {
        let (sin, cos) = sin_cos(self.yaw_rad);
        Vec2::new(cos, sin)
    }

    /// The same as a map from the inner frame to the outer one: for many points, its sine is asked for once.
    #[must_use]
    pub fn isometry(&self) -> nalgebra::Isometry2<f64> {
        let (sin, cos) = sin_cos(self.yaw_rad);
        let turn = nalgebra::UnitComplex::from_cos_sin_unchecked(cos, sin);
        nalgebra::Isometry2::from_parts(nalgebra::Translation2::new(self.x_m, self.y_m), turn)
    }

    /// A vector of the inner frame, turned into the outer one.
    #[must_use]
    pub fn rotate(&self, inner: Vec2) -> Vec2 {
        let h = self.heading();
        Vec2::new(h.x * inner.x - h.y * inner.y, h.y * inner.x + h.x * inner.y)
    }

    /// A point of the inner frame, seen in the outer one: `pose_wb.transform(pos_b)` is `pos_w`.
    #[must_use]
    pub fn transform(&self, inner: Vec2) -> Vec2 {
        self.position() + self.rotate(inner)
    }

    /// A point of the outer frame, seen in the inner one: `pose_wb.inverse_transform(pos_w)` is `pos_b`.
    #[must_use]
    pub fn inverse_transform(&self, outer: Vec2) -> Vec2 {
        let d = outer - self.position();
        let h = self.heading();
        Vec2::new(h.x * d.x + h.y * d.y, -h.y * d.x + h.x * d.y)
    }

    /// The pose after driving `twist_b` for `dt_s` seconds: exact along the arc.
    #[must_use]
    pub fn advance(&self, twist_b: Twist, dt_s: f64) -> Self {
        if dt_s == 0.0 || twist_b == Twist::ZERO {
            return *self;
        }
        let turn = twist_b.yaw_rate_radps * dt_s;
        let chord = if turn.abs() < 1e-9 { dt_s } else { sin(turn / 2.0) * 2.0 / twist_b.yaw_rate_radps };
        let (sin, cos) = sin_cos(self.yaw_rad + turn / 2.0);
        let step = twist_b.speed_mps * chord;
        Self::new(self.x_m + step * cos, self.y_m + step * sin, self.yaw_rad + turn)
    }

    /// Whether every number is finite.
    #[must_use]
    pub fn is_finite(&self) -> bool {
        self.x_m.is_finite() && self.y_m.is_finite() && self.yaw_rad.is_finite()
    }
}

/// How a differential-drive body moves, in its own frame.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Twist {
    /// Forward, metres per second; negative is backwards.
    pub speed_mps: f64,
    /// Counter-clockwise, radians per second.
    pub yaw_rate_radps: f64,
}

impl Twist {
    /// Standing still.
    pub const ZERO: Self = Self { speed_mps: 0.0, yaw_rate_radps: 0.0 };

    /// A twist.
    #[must_use]
    pub const fn new(speed_mps: f64, yaw_rate_radps: f64) -> Self {
        Self { speed_mps, yaw_rate_radps }
    }

    /// Whether both numbers are finite.
    #[must_use]
    pub fn is_finite(&self) -> bool {
        self.speed_mps.is_finite() && self.yaw_rate_radps.is_finite()
    }
}
