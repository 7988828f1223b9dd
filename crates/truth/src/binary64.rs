//! Numbers of any precision from `f64` and back, exact or rounded correctly, below the normal range and beyond it, too.

use astro_float_num::BigFloat;

/// Exact powers of two: values below the normal range of `f64` go in and out through them.
const SUBNORMAL_SHIFT: i32 = 128;

/// `x` in so many bits, at least 64.
pub(crate) fn exact(x: f64, bits: usize) -> BigFloat {
    if x.is_subnormal() {
        // The library's own conversion halves these.
        scaled(&BigFloat::from_f64(x * 2f64.powi(SUBNORMAL_SHIFT), bits), -SUBNORMAL_SHIFT)
    } else {
        BigFloat::from_f64(x, bits)
    }
}

/// The nearest `f64` (ties to even): subnormal, zero or infinite where the number is beyond the normal range.
pub(crate) fn nearest(value: &BigFloat) -> f64 {
    let sign = if value.is_negative() { -1.0 } else { 1.0 };
    if value.is_nan() {
        return f64::NAN;
    }
    let Some((mantissa, _, _, exponent, _)) = value.as_raw_parts() else {
        return sign * f64::INFINITY;
    };
    // The value is 0.mantissa · 2^exponent, the last word first in rank.
    let Some((&high, low)) = mantissa.split_last() else { return 0.0 };
    if high == 0 || exponent < -1074 {
        return sign * 0.0;
    }
    if exponent > 1024 {
        return sign * f64::INFINITY;
    }
    // 53 digits, fewer below the normal range; none at all between a quarter and half of the least number.
    let keep = (exponent + 1074).clamp(0, 53);
    let (whole, rest) = if keep == 0 { (0, high) } else { (high >> (64 - keep), high << keep) };
    let half = 1_u64 << 63;
    let sticky = low.iter().any(|&word| word != 0);
    let up = rest > half || (rest == half && (sticky || whole % 2 == 1));
    sign * (whole + u64::from(up)) as f64 * power_of_two(exponent - keep)
}

/// log₂|x|, also far beyond the range of `f64`; −∞ of zero.
pub(crate) fn log2_abs(value: &BigFloat) -> f64 {
    if value.is_nan() {
        return f64::NAN;
    }
    match value.exponent() {
        _ if value.is_zero() => f64::NEG_INFINITY,
        Some(exponent) => f64::from(exponent) + nearest(&scaled(value, -exponent)).abs().log2(),
        None => f64::INFINITY,
    }
}

/// Times 2^`power`.
pub(crate) fn scaled(value: &BigFloat, power: i32) -> BigFloat {
    let mut value = value.clone();
    if let (Some(exponent), false) = (value.exponent(), value.is_zero()) {
        value.set_exponent(exponent.saturating_add(power));
    }
    value
}

/// 2^`power` for −1074 ≤ `power` ≤ 1023, subnormal ones exact too.
fn power_of_two(power: i32) -> f64 {
    if power >= -1022 { f64::from_bits(((power + 1023) as u64) << 52) } else { f64::from_bits(1 << (power + 1074)) }
}
