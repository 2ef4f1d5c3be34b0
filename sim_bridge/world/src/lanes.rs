//! Numbers that are worked on side by side. The only file that names `wide`.
//!
//! `wide` spells out the vector instructions that every machine of an architecture has (SSE2 on x86-64, NEON on ARM),
//! and more where the build asks for it. Only operations that IEEE 754 fixes to the last bit are used, so that the
//! numbers are the same on all machines: no fused multiply-add, no estimates of reciprocals. Plain loops over arrays
//! take half as long again: the compiler gives up on them as soon as they choose between two values.

use std::ops::{Add, Div, Mul, Neg, Sub};
use wide::f32x8;

/// Numbers side by side.
pub(crate) const LANES: usize = 8;

/// [`LANES`] numbers.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Lanes(f32x8);

impl Lanes {
    /// 0, 1, 2 and so on.
    pub(crate) const COUNT: Self = Self(f32x8::new([0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0]));

    /// The same number in all lanes.
    #[inline(always)]
    pub(crate) fn all(value: f32) -> Self {
        Self(f32x8::splat(value))
    }

    /// The numbers.
    #[inline(always)]
    pub(crate) fn each(&self) -> &[f32; LANES] {
        self.0.as_array()
    }

    /// The numbers, to be changed.
    #[inline(always)]
    pub(crate) fn each_mut(&mut self) -> &mut [f32; LANES] {
        self.0.as_mut_array()
    }

    /// The larger of two; of 0 and -0 either.
    #[inline(always)]
    pub(crate) fn max(self, other: Self) -> Self {
        Self(self.0.fast_max(other.0))
    }

    /// The smaller of two; of 0 and -0 either.
    #[inline(always)]
    pub(crate) fn min(self, other: Self) -> Self {
        Self(self.0.fast_min(other.0))
    }

    /// Without its sign.
    #[inline(always)]
    pub(crate) fn abs(self) -> Self {
        Self(self.0.abs())
    }

    /// Square root.
    #[inline(always)]
    pub(crate) fn sqrt(self) -> Self {
        Self(self.0.sqrt())
    }

    /// `yes` where this is less than `limit`, else `no`.
    #[inline(always)]
    pub(crate) fn if_less(self, limit: Self, yes: Self, no: Self) -> Self {
        Self(self.0.simd_lt(limit.0).select(yes.0, no.0))
    }

    /// This where `nth` is in `from..=to`, else 0.
    #[inline(always)]
    pub(crate) fn within(self, nth: Self, from: Self, to: Self) -> Self {
        Self(self.0 & nth.0.simd_ge(from.0) & nth.0.simd_le(to.0))
    }

    /// Where this is less than `limit`: a bit a lane, the first lane's lowest.
    #[inline(always)]
    pub(crate) fn less_bits(self, limit: Self) -> u32 {
        self.0.simd_lt(limit.0).to_bitmask()
    }

    /// Cut to whole numbers.
    #[inline(always)]
    pub(crate) fn whole(self) -> [i32; LANES] {
        self.0.trunc_int().to_array()
    }
}

impl Add for Lanes {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        Self(self.0 + other.0)
    }
}

impl Sub for Lanes {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        Self(self.0 - other.0)
    }
}

impl Mul for Lanes {
    type Output = Self;
    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        Self(self.0 * other.0)
    }
}

impl Mul<f32> for Lanes {
    type Output = Self;
    #[inline(always)]
    fn mul(self, factor: f32) -> Self {
        Self(self.0 * f32x8::splat(factor))
    }
}

impl Div for Lanes {
    type Output = Self;
    #[inline(always)]
    fn div(self, other: Self) -> Self {
        Self(self.0 / other.0)
    }
}

impl Neg for Lanes {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Self(-self.0)
    }
}
