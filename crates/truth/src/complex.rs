//! Complex numbers on top of [`Real`], as far as multipliers need them.

use std::ops::{Add, Div, Mul, Neg, Sub};

use crate::real::Real;

/// A complex number.
///
/// ```
/// use vibrochain_truth::{Complex, Real};
/// let i = Complex::new(0.0, 1.0, 192);
/// assert_eq!((&i * &i).re, Real::new(-1.0, 192));
/// assert_eq!((&i * &i).sqrt().to_f64(), (0.0, 1.0));
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Complex {
    /// Real part.
    pub re: Real,
    /// Imaginary part.
    pub im: Real,
}

impl Complex {
    /// `re` + i `im`, exactly.
    pub fn new(re: f64, im: f64, bits: usize) -> Self {
        Self { re: Real::new(re, bits), im: Real::new(im, bits) }
    }

    /// A real number.
    pub fn real(re: Real) -> Self {
        let im = Real::zero(re.bits());
        Self { re, im }
    }

    /// Real and imaginary part, rounded.
    pub fn to_f64(&self) -> (f64, f64) {
        (self.re.to_f64(), self.im.to_f64())
    }

    /// Squared modulus.
    pub fn norm_sqr(&self) -> Real {
        &self.re * &self.re + &self.im * &self.im
    }

    /// Modulus.
    pub fn abs(&self) -> Real {
        self.norm_sqr().sqrt()
    }

    /// log₂ of the modulus; −∞ for zero.
    pub fn log2_abs(&self) -> f64 {
        0.5 * self.norm_sqr().log2_abs()
    }

    /// The square root with a real part that is not negative. Its parts are formed from the one that does not cancel.
    pub fn sqrt(&self) -> Self {
        let large = ((self.abs() + self.re.abs()) / 2.0).sqrt();
        if large.is_zero() {
            return self.clone();
        }
        let small = self.im.abs() / (&large * 2.0);
        let (re, im) = if self.re.is_negative() { (small, large) } else { (large, small) };
        Self { re, im: if self.im.is_negative() { -im } else { im } }
    }

    /// Times a real number.
    pub fn scale(&self, factor: &Real) -> Self {
        Self { re: &self.re * factor, im: &self.im * factor }
    }

    fn times(&self, other: &Self) -> Self {
        Self { re: &self.re * &other.re - &self.im * &other.im, im: &self.re * &other.im + &self.im * &other.re }
    }

    /// 1/z.
    pub fn inverse(&self) -> Self {
        let norm = self.norm_sqr();
        Self { re: &self.re / &norm, im: -(&self.im / &norm) }
    }

    /// Neither part infinite nor not a number.
    pub fn is_finite(&self) -> bool {
        self.re.is_finite() && self.im.is_finite()
    }

    /// Exactly zero.
    pub fn is_zero(&self) -> bool {
        self.re.is_zero() && self.im.is_zero()
    }
}

macro_rules! operator {
    ($operator:ident, $method:ident, |$a:ident, $b:ident| $result:expr) => {
        impl $operator<&Complex> for &Complex {
            type Output = Complex;
            fn $method(self, other: &Complex) -> Complex {
                let ($a, $b) = (self, other);
                $result
            }
        }

        impl $operator<Complex> for &Complex {
            type Output = Complex;
            fn $method(self, other: Complex) -> Complex {
                self.$method(&other)
            }
        }

        impl $operator<&Complex> for Complex {
            type Output = Complex;
            fn $method(self, other: &Complex) -> Complex {
                (&self).$method(other)
            }
        }

        impl $operator for Complex {
            type Output = Complex;
            fn $method(self, other: Complex) -> Complex {
                (&self).$method(&other)
            }
        }
    };
}

operator!(Add, add, |a, b| Complex { re: &a.re + &b.re, im: &a.im + &b.im });
operator!(Sub, sub, |a, b| Complex { re: &a.re - &b.re, im: &a.im - &b.im });
operator!(Mul, mul, |a, b| a.times(b));
operator!(Div, div, |a, b| a.times(&b.inverse()));

impl Neg for Complex {
    type Output = Complex;
    fn neg(self) -> Complex {
        Complex { re: -self.re, im: -self.im }
    }
}

/// z + x
pub(crate) fn shifted(z: &Complex, x: &Real) -> Complex {
    Complex { re: &z.re + x, im: z.im.clone() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn roots_square_to_their_argument_and_quotients_multiply_back() {
        for (re, im) in [(2.0, 1.0), (-2.0, 1e-30), (-2.0, -1e-30), (0.0, -3.0), (1e-40, 0.0), (-4.0, 0.0), (0.0, 0.0)]
        {
            let z = Complex::new(re, im, 192);
            let root = z.sqrt();
            assert!(!root.re.is_negative());
            assert!((&root * &root - &z).log2_abs() <= z.log2_abs() - 189.0, "{re} {im}");
            let other = Complex::new(0.3, -0.7, 192);
            assert!((&z / &other * &other - &z).log2_abs() <= z.log2_abs() - 189.0);
        }
        // Next to the negative axis the small part keeps its digits: √(−4 + iε) = iε-ish/4 + 2i.
        let root = Complex::new(-4.0, 1e-30, 192).sqrt();
        assert!((root.re.to_f64() / 2.5e-31 - 1.0).abs() < 1e-15);
    }
}
