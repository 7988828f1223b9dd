//! Numbers of two parts: a sum of two that is not added up, of twice the digits (Dekker; Ogita, Rump and Oishi for products of vectors).

use std::ops::{Add, Mul, Neg, Sub};

/// high + low, |low| at most half a unit of the last digit of high.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct Twofold {
    pub(crate) high: f64,
    pub(crate) low: f64,
}

/// The square of the unit: what one operation of two parts loses.
pub(crate) const FINE: f64 = f64::EPSILON * f64::EPSILON;

/// a + b and its rounding error, exactly (Knuth).
pub(crate) fn two_sum(a: f64, b: f64) -> (f64, f64) {
    let sum = a + b;
    let part = sum - a;
    (sum, (a - (sum - part)) + (b - part))
}

impl Twofold {
    pub(crate) fn of_sum(a: f64, b: f64) -> Self {
        let (high, low) = two_sum(a, b);
        Self { high, low }
    }

    /// a·b, exactly.
    pub(crate) fn of_product(a: f64, b: f64) -> Self {
        let high = a * b;
        Self { high, low: a.mul_add(b, -high) }
    }

    /// Divided by a number.
    pub(crate) fn over(self, by: f64) -> Self {
        let high = self.high / by;
        Self::of_sum(high, (high.mul_add(-by, self.high) + self.low) / by)
    }

    /// The root of a number above 0.
    pub(crate) fn root(self) -> Self {
        let high = self.high.sqrt();
        Self::of_sum(high, (high.mul_add(-high, self.high) + self.low) / (2.0 * high))
    }

    /// Rounded to one number.
    pub(crate) fn value(self) -> f64 {
        self.high + self.low
    }

    /// Σ a b, off by at most n² [`FINE`] of the sum of moduli.
    pub(crate) fn dot(pairs: impl Iterator<Item = (f64, f64)>) -> Self {
        let (mut sum, mut rest) = (0.0, 0.0);
        for (a, b) in pairs {
            let product = Self::of_product(a, b);
            let (next, lost) = two_sum(sum, product.high);
            sum = next;
            rest += lost + product.low;
        }
        Self::of_sum(sum, rest)
    }
}

impl From<f64> for Twofold {
    fn from(high: f64) -> Self {
        Self { high, low: 0.0 }
    }
}

impl Neg for Twofold {
    type Output = Self;

    fn neg(self) -> Self {
        Self { high: -self.high, low: -self.low }
    }
}

impl Add for Twofold {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        let (high, low) = two_sum(self.high, other.high);
        let (rest, lost) = two_sum(self.low, other.low);
        let (high, low) = two_sum(high, low + rest);
        Self::of_sum(high, low + lost)
    }
}

impl Sub for Twofold {
    type Output = Self;

    fn sub(self, other: Self) -> Self {
        self + -other
    }
}

impl Mul for Twofold {
    type Output = Self;

    fn mul(self, other: Self) -> Self {
        let Self { high, low } = Self::of_product(self.high, other.high);
        Self::of_sum(high, low + (self.high * other.low + self.low * other.high))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// (1 + 2⁻⁴⁰)² − 1 − 2⁻³⁹ = 2⁻⁸⁰, of which a plain sum leaves nothing.
    #[test]
    fn products_and_sums_keep_twice_the_digits() {
        let (one, small) = (1.0 + 2f64.powi(-40), 2f64.powi(-39));
        let dot = Twofold::dot([(one, one), (-1.0, 1.0), (small, -1.0)].into_iter());
        assert_eq!(dot.value(), 2f64.powi(-80));
        let square = Twofold::from(one) * Twofold::from(one) - Twofold::from(1.0) - Twofold::from(small);
        assert_eq!(square.value(), 2f64.powi(-80));
    }
}
