//! First-order Taylor models of functions of N variables on a box: v + Σ s_i x_i ± rest for |x_i| ≤ r_i about the centre, closed under sums and
//! products.
//!
//! They answer, for a whole box at once, whether a function can vanish there. The excess shrinks with the square of the radius, so that
//! halving soon decides; rounding is carried in `rest`, too, so that a "no" is a proof to working precision.
//!
//! Of one variable the derivative has a model of its own ([`Dual`](super::dual::Dual)), as near double zeros only its slope with its sign tells
//! anything. Of two, bounds of what the slopes change by are enough ([`Patch`](super::patch::Patch)).

use std::ops::{Add, Mul, Neg, Sub};

use vibrochain_lattice::simd::lanes::Number;

/// A model on one box, or on four.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Taylor<const N: usize, T = f64> {
    pub(crate) value: T,
    pub(crate) slope: [T; N],
    pub(crate) rest: T,
    pub(crate) radius: [T; N],
}

/// 8 units in the last place: what the kernels' sums are good for, relative to themselves.
pub(crate) const SUMS: f64 = 8.0 * f64::EPSILON;

/// Ends are as far from the centre as the radius says but for this part of it: no interval is shorter than 64 units in the last place of
/// its centre.
const ROUNDED: f64 = 1.0 / 32.0;

impl<const N: usize, T: Number> Taylor<N, T> {
    pub(crate) fn constant(value: f64, radius: [T; N]) -> Self {
        Self { value: T::of(value), slope: [T::of(0.0); N], rest: T::of(0.0), radius }
    }

    /// A function of the sum of some of the variables: value, first and second derivative at the centre, and a bound of the third.
    pub(crate) fn of_sum(axes: [bool; N], [value, first, second]: [T; 3], third: T, radius: [T; N]) -> Self {
        let reach = reach(axes, radius);
        let rest = reach * reach * (second.modulus() * 0.5 + reach * third * (1.0 / 6.0)) + value.modulus() * SUMS;
        Self { value, slope: axes.map(|on| if on { first } else { T::of(0.0) }), rest, radius }
    }

    /// Largest change of the linear part.
    pub(crate) fn tilt(&self) -> T {
        let mut sum = self.slope[0].modulus() * self.radius[0];
        for i in 1..N {
            sum = sum + self.slope[i].modulus() * self.radius[i];
        }
        sum
    }

    /// By how much the function stays away from 0 on the box: it has no zero there where this is positive.
    pub(crate) fn clearance(&self) -> T {
        self.value.modulus() - (self.tilt() + self.rest)
    }

    /// No more than this is the function on the box, by its size.
    pub(crate) fn most(&self) -> T {
        self.value.modulus() + self.tilt() + self.rest
    }

    /// The same with as much more doubt.
    pub(crate) fn widened(self, doubt: f64) -> Self {
        Self { rest: self.rest + T::of(doubt), ..self }
    }

    pub(crate) fn scaled(self, factor: f64) -> Self {
        let slope = self.slope.map(|slope| slope * factor);
        Self { value: self.value * factor, slope, rest: self.rest * factor.abs(), ..self }
    }

    pub(crate) fn shifted(self, constant: f64) -> Self {
        self + Self::constant(constant, self.radius)
    }
}

/// How far the sum of some of the variables is from its value at the centre at most.
pub(crate) fn reach<const N: usize, T: Number>(axes: [bool; N], radius: [T; N]) -> T {
    (0..N).filter(|i| axes[*i]).map(|i| radius[i]).reduce(|a, b| a + b).unwrap_or_default()
}

impl<T: Number> Taylor<1, T> {
    /// What the function is at both ends, and by how much that can be wrong.
    pub(crate) fn ends(&self) -> ([T; 2], T) {
        let rise = self.slope[0] * self.radius[0];
        ([self.value - rise, self.value + rise], self.rest + rise.modulus() * ROUNDED)
    }
}

impl<const N: usize, T: Number> Add for Taylor<N, T> {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        let rounding = (self.value.modulus() + other.value.modulus()) * f64::EPSILON;
        let slope = std::array::from_fn(|i| self.slope[i] + other.slope[i]);
        let rest = self.rest + other.rest + rounding;
        Self { value: self.value + other.value, slope, rest, radius: self.radius }
    }
}

impl<const N: usize, T: Number> Neg for Taylor<N, T> {
    type Output = Self;
    fn neg(self) -> Self {
        Self { value: -self.value, slope: self.slope.map(|slope| -slope), ..self }
    }
}

impl<const N: usize, T: Number> Sub for Taylor<N, T> {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        self + -other
    }
}

impl<const N: usize, T: Number> Mul for Taylor<N, T> {
    type Output = Self;
    fn mul(self, other: Self) -> Self {
        let (tilt, other_tilt) = (self.tilt(), other.tilt());
        let value = self.value * other.value;
        let (a, b) = (self.value.modulus() + tilt, other.value.modulus() + other_tilt);
        let rest = tilt * other_tilt
            + a * other.rest
            + b * self.rest
            + self.rest * other.rest
            + value.modulus() * f64::EPSILON;
        let slope = std::array::from_fn(|i| self.value * other.slope[i] + self.slope[i] * other.value);
        Self { value, slope, rest, radius: self.radius }
    }
}

#[cfg(test)]
mod tests;
