//! Weights of a series: what turns derivatives at its origin into the motion at s.

use crate::units::MAX_ORDER;

/// s^k/k!, the weights that turn derivatives at the origin into the motion at s.
#[derive(Debug, Clone)]
pub(crate) struct Weights {
    pub(crate) high: [f64; MAX_ORDER + 1],
    /// What rounding took from the weights 2 … `TWO_WORDS`−1. A periodic orbit uses the same s again and again, and
    /// then these errors do not average out.
    pub(crate) low: [f64; TWO_WORDS],
}

/// Weights below this order are held in two words.
pub(crate) const TWO_WORDS: usize = 9;

/// Splits a number into halves whose products are exact (Veltkamp).
fn split(a: f64) -> (f64, f64) {
    const FACTOR: f64 = 134_217_729.0; // 2²⁷ + 1
    let t = FACTOR * a;
    let high = t - (t - a);
    (high, a - high)
}

impl Weights {
    /// Those of no time at all: a displacement stays what it is.
    pub(crate) fn zero() -> Self {
        let mut high = [0.0; MAX_ORDER + 1];
        high[0] = 1.0;
        Self { high, low: [0.0; TWO_WORDS] }
    }

    /// The weights up to `order`, to working precision.
    pub(crate) fn plain(&mut self, s: f64, order: usize, inverse_factorial: &[f64; MAX_ORDER + 1]) {
        let mut power = 1.0;
        for (weight, inverse) in self.high[..=order].iter_mut().zip(inverse_factorial) {
            *weight = power * inverse;
            power *= s;
        }
        self.low = [0.0; TWO_WORDS];
    }

    /// The same with the leading ones in two words.
    pub(crate) fn precise(&mut self, s: f64, order: usize, inverse_factorial: &[f64; MAX_ORDER + 1]) {
        self.plain(s, order, inverse_factorial);
        let (s_high, s_low) = split(s);
        let (mut high, mut low) = (s, 0.0);
        for k in 2..TWO_WORDS {
            // p + e = high · s exactly (Dekker), then divided by k with its remainder.
            let p = high * s;
            let (h, l) = split(high);
            let e = ((h * s_high - p) + h * s_low + l * s_high) + l * s_low;
            let divisor = k as f64;
            let quotient = p / divisor;
            let (q_high, q_low) = split(quotient);
            let remainder = (p - q_high * divisor) - q_low * divisor;
            let rest = (remainder + e + low * s) / divisor;
            high = quotient + rest;
            low = (quotient - high) + rest;
            self.high[k] = high;
            self.low[k] = low;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_word_weights_hold_the_exact_quotients() {
        let inverse = crate::units::inverse_factorials();
        let mut weights = Weights::zero();
        weights.precise(1.234_567_890_123_456_7, MAX_ORDER, &inverse);
        // k · w_k = s · w_{k−1} in integers: check with 128-bit fixed point, 100 bits after the point.
        let fixed = |x: f64| -> i128 {
            if x == 0.0 {
                return 0;
            }
            let bits = x.to_bits();
            let (mantissa, exponent) = ((bits & ((1 << 52) - 1) | 1 << 52) as i128, (bits >> 52 & 0x7ff) as i32);
            let shift = exponent - 1075 + 100;
            let value =
                if shift >= 0 { mantissa << shift } else { mantissa.checked_shr(shift.unsigned_abs()).unwrap_or(0) };
            if x < 0.0 { -value } else { value }
        };
        for k in 2..TWO_WORDS {
            let (h, l) = (weights.high[k], weights.low[k]);
            assert!(l.abs() <= h * f64::EPSILON);
            let previous = fixed(weights.high[k - 1]) + fixed(weights.low[k - 1]);
            // s in 52 fractional bits: previous · s without overflow, in two parts.
            let s = (1.234_567_890_123_456_7_f64 * 2f64.powi(52)) as i128;
            let (top, rest) = (previous >> 50, previous & ((1 << 50) - 1));
            let product = ((top * s) >> 2) + ((rest * s) >> 52);
            let expected = product / k as i128;
            let found = fixed(h) + fixed(l);
            assert!((found - expected).abs() < 1 << 10, "{k}: {}", found - expected);
        }
    }
}
