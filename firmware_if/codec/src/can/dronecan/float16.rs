//! Half-precision floats (IEEE 754 binary16), as DSDL's `float16`.

/// Greatest finite half: DSDL's "saturated" cast stops there.
const HALF_MAX: f64 = 65_504.0;
/// Value of the lowest bit of a subnormal half: 2^-24.
const SUBNORMAL_STEP: f64 = 1.0 / 16_777_216.0;
const SMALLEST_NORMAL: f64 = 1.0 / 16_384.0;

/// The half nearest to `value`, halfway cases away from zero (as libuavcan does, and not to even); values beyond the
/// greatest half become it.
#[must_use]
pub fn float16_encode(value: f64) -> u16 {
    if value.is_nan() {
        return 0x7FFF;
    }
    let sign = if value.is_sign_negative() { 0x8000 } else { 0 };
    let size = f64::from(value.abs().min(HALF_MAX) as f32); // implementations go by way of f32
    if size < SMALLEST_NORMAL {
        return sign | (size / SUBNORMAL_STEP).round() as u16;
    }
    let exponent = (size.to_bits() >> 52) as i32 - 1023; // -14..=15: a normal f64, so this is exact
    let mantissa = (size * 2_f64.powi(10 - exponent)).round() as u16; // 1024..=2048; 2048 carries into the exponent
    sign | (((exponent + 14) as u16) << 10).wrapping_add(mantissa)
}

/// What a half says; `None` if it is infinite or not a number: absence is never NaN in here.
#[must_use]
pub fn float16_decode(half: u16) -> Option<f64> {
    let (exponent, fraction) = (i32::from(half >> 10 & 0x1F), f64::from(half & 0x3FF));
    let size = match exponent {
        0x1F => return None,
        0 => fraction * SUBNORMAL_STEP,
        _ => (1.0 + fraction / 1024.0) * 2_f64.powi(exponent - 15),
    };
    Some(if half & 0x8000 != 0 { -size } else { size })
}

#[cfg(test)]
mod tests {
    use super::{float16_decode, float16_encode};

    #[test]
    fn every_finite_half_survives_decoding_and_encoding() {
        for half in 0..=u16::MAX {
            match float16_decode(half) {
                Some(value) => assert_eq!(float16_encode(value), half, "{value}"),
                None => assert_eq!(half & 0x7C00, 0x7C00),
            }
        }
    }

    #[test]
    fn halfway_goes_away_from_zero_and_too_much_is_cut() {
        assert_eq!(float16_encode(1.0 + 1.0 / 2048.0), 0x3C01);
        assert_eq!([float16_encode(1e9), float16_encode(-1e9)], [0x7BFF, 0xFBFF]);
        assert_eq!(float16_encode(f64::NAN), 0x7FFF);
    }
}
