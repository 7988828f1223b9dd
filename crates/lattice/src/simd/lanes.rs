//! Numbers in groups of four: a sum over them keeps four partial sums, each addition one vector instruction where the machine has it. (A
//! compiler may not reorder a plain sum of floating-point numbers by itself.) For the crates of this workspace alone.

use std::ops::{Add, Div, Mul, Neg, Sub};

use wide::f64x4;

/// Numbers in a group.
pub const LANES: usize = 4;

/// A group.
pub type Lane = [f64; LANES];

/// Groups in a row of `count` numbers: a few sizes only up to 12, for which there is code of its own.
pub fn groups(count: usize) -> usize {
    let least = count.div_ceil(LANES);
    [1, 2, 3, 4, 6, 8, 12].into_iter().find(|&groups| groups >= least).unwrap_or(least)
}

/// Sum of the products of two rows.
pub fn dot(a: &[Lane], b: &[Lane]) -> f64 {
    let products = a.iter().zip(b).map(|(a, b)| f64x4::from(*a) * f64x4::from(*b));
    total(products.fold(f64x4::ZERO, |sum, product| sum + product))
}

/// Sum of a group, in the same order on every machine.
#[inline]
#[must_use]
pub fn total(sum: f64x4) -> f64 {
    let [a, b, c, d] = sum.to_array();
    (a + c) + (b + d)
}

/// Σ factor·row over the rows of `table`, each as long as `out`; rows are added in their order.
pub fn combine(table: &[Lane], factors: impl Iterator<Item = f64> + Clone, out: &mut [Lane]) {
    combine_each(table, factors.map(|factor| [factor]), [out]);
}

/// As many sums as there are factors of a row at a time, as [`combine`] has each.
pub fn combine_each<const M: usize>(
    table: &[Lane],
    factors: impl Iterator<Item = [f64; M]> + Clone,
    mut out: [&mut [Lane]; M],
) {
    let width = out.first().map_or(0, |out| out.len());
    let mut from = 0;
    while from < width {
        // As many groups at a time as processors have registers for.
        from += match width - from {
            1 => combine_groups::<M, 1>(table, factors.clone(), from, &mut out),
            2 => combine_groups::<M, 2>(table, factors.clone(), from, &mut out),
            _ => combine_groups::<M, 3>(table, factors.clone(), from, &mut out),
        };
    }
}

fn combine_groups<const M: usize, const N: usize>(
    table: &[Lane],
    factors: impl Iterator<Item = [f64; M]>,
    from: usize,
    out: &mut [&mut [Lane]; M],
) -> usize {
    let mut sums = [[f64x4::ZERO; N]; M];
    let mut rows = table.chunks_exact(out[0].len());
    // Inside, so that factors of two lists that follow each other are two loops.
    factors.for_each(|factors| {
        let Some(groups) = rows.next().and_then(|row| row.get(from..)).and_then(|row| row.first_chunk::<N>()) else {
            return;
        };
        for (sum, factor) in sums.iter_mut().zip(factors) {
            let factor = f64x4::splat(factor);
            for i in 0..N {
                sum[i] += f64x4::from(groups[i]) * factor;
            }
        }
    });
    for (out, sum) in out.iter_mut().zip(sums) {
        for (out, sum) in out[from..from + N].iter_mut().zip(sum) {
            *out = sum.to_array();
        }
    }
    N
}

/// Replaces the content by `values`, the last group filled up with `pad`.
#[inline]
pub fn fill(lanes: &mut Vec<Lane>, values: impl ExactSizeIterator<Item = f64>, pad: f64) {
    room(lanes, values.len(), pad).iter_mut().zip(values).for_each(|(slot, value)| *slot = value);
}

/// Room for `count` numbers, to be written by the caller; the last group is filled up with `pad`.
#[inline]
pub fn room(lanes: &mut Vec<Lane>, count: usize, pad: f64) -> &mut [f64] {
    lanes.resize(count.div_ceil(LANES), [pad; LANES]);
    if let Some(last) = lanes.last_mut() {
        *last = [pad; LANES];
    }
    &mut lanes.as_flattened_mut()[..count]
}

/// 0, four times.
pub const ZERO: f64x4 = f64x4::splat(0.0);
/// ½, four times.
pub const HALF: f64x4 = f64x4::splat(0.5);
/// 1, four times.
pub const ONE: f64x4 = f64x4::splat(1.0);
/// 2, four times.
pub const TWO: f64x4 = f64x4::splat(2.0);
/// 4, four times.
pub const FOUR: f64x4 = f64x4::splat(4.0);
/// Stands for a difference of 0: below rounding, and its inverse squared is no overflow.
pub const SMALL: f64x4 = f64x4::splat(1e-16);

/// Four times the same number.
#[inline]
pub fn all(value: f64) -> f64x4 {
    f64x4::splat(value)
}

/// A group as an operand.
#[inline]
pub fn four(lane: Lane) -> f64x4 {
    f64x4::from(lane)
}

/// One number or four: formulas are written once for both.
pub trait Number:
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

    /// The one number, or the sum of the four as [`total`] has it.
    fn sum(self) -> f64;
}

impl Number for f64 {
    #[inline]
    fn of(value: f64) -> Self {
        value
    }

    #[inline]
    fn modulus(self) -> Self {
        self.abs()
    }

    #[inline]
    fn at_least(self, other: Self) -> Self {
        self.max(other)
    }

    #[inline]
    fn sum(self) -> f64 {
        self
    }
}

impl Number for f64x4 {
    #[inline]
    fn of(value: f64) -> Self {
        Self::splat(value)
    }

    #[inline]
    fn modulus(self) -> Self {
        self.abs()
    }

    #[inline]
    fn at_least(self, other: Self) -> Self {
        self.max(other)
    }

    #[inline]
    fn sum(self) -> f64 {
        total(self)
    }
}

/// Four sums at once, each as [`total`] has it.
#[inline]
pub fn totals(sums: [f64x4; 4]) -> f64x4 {
    let [a, b, c, d] = f64x4::transpose(sums);
    (a + c) + (b + d)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sums_of_rows_and_products() {
        for groups in 1..9 {
            let rows = 5;
            let number = |k: usize, i: usize| ((7 * k + 3 * i) % 11) as f64 - 4.0;
            let table: Vec<Lane> =
                (0..rows * groups).map(|r| std::array::from_fn(|i| number(r / groups, 4 * (r % groups) + i))).collect();
            let mut out = vec![[f64::NAN; LANES]; groups];
            combine(&table, (0..rows).map(|k| k as f64 - 1.0), &mut out);
            for (i, sum) in out.as_flattened().iter().enumerate() {
                assert_eq!(*sum, (0..rows).map(|k| (k as f64 - 1.0) * number(k, i)).sum::<f64>());
            }
            let direct: f64 = (0..4 * groups).map(|i| number(0, i) * number(1, i)).sum();
            assert_eq!(dot(&table[..groups], &table[groups..2 * groups]), direct);
        }
        assert_eq!([1, 4, 5, 11, 12, 17, 33, 48, 49, 60].map(groups), [1, 1, 2, 3, 3, 6, 12, 12, 13, 15]);
    }
}
