//! Numbers in groups of four: sums over them keep four partial sums, one vector instruction each. (A compiler may not
//! reorder a plain sum of floating-point numbers by itself.)

use std::ops::{Add, Div, Mul, Neg, Sub};

use wide::f64x4;

/// Four numbers at a time.
pub(crate) type Lane = [f64; 4];

/// Replaces the content by `values`, the last group filled up with `pad`.
pub(crate) fn fill(lanes: &mut Vec<Lane>, values: impl ExactSizeIterator<Item = f64>, pad: f64) {
    let groups = values.len().div_ceil(4);
    lanes.resize(groups, [pad; 4]);
    if let Some(last) = lanes.last_mut() {
        *last = [pad; 4];
    }
    for (slot, value) in lanes.as_flattened_mut().iter_mut().zip(values) {
        *slot = value;
    }
}

pub(crate) const ZERO: f64x4 = f64x4::splat(0.0);
pub(crate) const HALF: f64x4 = f64x4::splat(0.5);
pub(crate) const ONE: f64x4 = f64x4::splat(1.0);
pub(crate) const TWO: f64x4 = f64x4::splat(2.0);
pub(crate) const FOUR: f64x4 = f64x4::splat(4.0);
/// Stands for a difference of 0: below rounding, and its inverse squared is no overflow.
pub(crate) const SMALL: f64x4 = f64x4::splat(1e-16);

/// Four times the same number.
#[inline]
pub(crate) fn all(value: f64) -> f64x4 {
    f64x4::splat(value)
}

/// A group as an operand.
#[inline]
pub(crate) fn four(lane: Lane) -> f64x4 {
    f64x4::from(lane)
}

/// Sum of the four partial sums, in the same order on every machine.
#[inline]
pub(crate) fn total(sum: f64x4) -> f64 {
    let [a, b, c, d] = sum.to_array();
    (a + c) + (b + d)
}

/// One number or four: formulas are written once for both.
pub(crate) trait Number:
    Copy
    + Default
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
    + Mul<f64, Output = Self>
{
    /// This number, four times if there are four.
    fn of(value: f64) -> Self;

    /// The modulus.
    fn modulus(self) -> Self;

    /// The larger one.
    fn at_least(self, other: Self) -> Self;
}

impl Number for f64 {
    fn of(value: f64) -> Self {
        value
    }

    fn modulus(self) -> Self {
        self.abs()
    }

    fn at_least(self, other: Self) -> Self {
        self.max(other)
    }
}

impl Number for f64x4 {
    fn of(value: f64) -> Self {
        Self::splat(value)
    }

    fn modulus(self) -> Self {
        self.abs()
    }

    fn at_least(self, other: Self) -> Self {
        self.max(other)
    }
}

/// Four sums at once, each as [`total`] has it.
#[inline]
pub(crate) fn totals(sums: [f64x4; 4]) -> f64x4 {
    let [a, b, c, d] = f64x4::transpose(sums);
    (a + c) + (b + d)
}
