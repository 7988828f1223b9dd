//! Complex numbers of twice the digits.

use std::ops::{Add, Mul};

use rustfft::num_complex::Complex;

use super::twofold::Twofold;

/// A complex number of two parts each way.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct ComplexTwofold {
    pub(crate) re: Twofold,
    pub(crate) im: Twofold,
}

impl ComplexTwofold {
    pub(crate) fn value(self) -> Complex<f64> {
        Complex::new(self.re.value(), self.im.value())
    }
}

impl From<Complex<f64>> for ComplexTwofold {
    fn from(z: Complex<f64>) -> Self {
        Self { re: z.re.into(), im: z.im.into() }
    }
}

impl Add for ComplexTwofold {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self { re: self.re + other.re, im: self.im + other.im }
    }
}

impl Mul for ComplexTwofold {
    type Output = Self;

    fn mul(self, other: Self) -> Self {
        Self { re: self.re * other.re - self.im * other.im, im: self.re * other.im + self.im * other.re }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn squares_keep_twice_the_digits() {
        let (one, small) = (1.0 + 2f64.powi(-40), 2f64.powi(-39));
        let i = ComplexTwofold::from(Complex::new(one, one));
        // (a + ai)² = 2a²i
        let square = i * i;
        assert_eq!((square.re.value(), (square.im - Twofold::from(2.0)).value()), (0.0, 2.0 * small + 2f64.powi(-79)));
    }
}
