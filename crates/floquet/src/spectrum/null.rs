//! Null vectors of the bordered equations.
//!
//! One on either side comes from elimination with full pivots, several from singular vectors.

use nalgebra::{Complex, DMatrix};
use smallvec::{SmallVec, smallvec};
use vibrochain_breather::linear::{Pivots, eliminate, null_vectors};

use super::function::{Pole, SpectralFunction};
use crate::singular::Singular;
use crate::zeros::modulus;

type C = Complex<f64>;

/// Sweeps that make rows and columns alike in size.
const BALANCE: usize = 3;

/// Null vectors of B(z) on both sides, columns of `left` and `right`, and how singular B is.
pub(super) struct Null {
    pub(super) near: Vec<Pole>,
    pub(super) left: DMatrix<C>,
    pub(super) right: DMatrix<C>,
    /// Norm of |x||B||y| with B balanced.
    pub(super) norm: f64,
    /// The least singular value or pivot that is not taken for 0, on the same scale.
    pub(super) second: f64,
    /// The largest one that is taken for 0, as a part of the largest entry or value.
    pub(super) defect: f64,
}

impl SpectralFunction<'_> {
    /// The `count` null vectors of B(z).
    pub(super) fn null(&self, z: C, count: usize) -> Option<Null> {
        let near = self.near(z);
        let mut matrix = self.bordered(z, &near);
        let size = matrix.len().isqrt();
        let finite = |entry: &C| entry.re.is_finite() && entry.im.is_finite();
        if count > size || !matrix.iter().all(finite) {
            return None;
        }
        let [rows, columns] = balance(&mut matrix, size);
        if count == 1 && size > 1 {
            let mut entries = matrix;
            let largest = entries.iter().map(|entry| entry.norm_sqr()).fold(0.0, f64::max).sqrt();
            let order = eliminate(&mut entries, size, Pivots::Full)?;
            let pivot = |i: usize| modulus(entries[i * (size + 1)]);
            let (second, defect) = (pivot(size - 2), pivot(size - 1) / largest);
            let [x, y] = null_vectors(&entries, size);
            let length = |v: &[C]| v.iter().map(|z| z.norm_sqr()).sum::<f64>().sqrt();
            let scale = length(&x) * length(&y);
            let (mut left, mut right) = (DMatrix::zeros(size, 1), DMatrix::zeros(size, 1));
            for i in 0..size {
                left[order.rows[i]] = x[i] * rows[order.rows[i]];
                right[order.columns[i]] = y[i] * columns[order.columns[i]];
            }
            let norm = largest * size as f64 * scale;
            return Some(Null { near, left, right, norm, second: second * scale, defect });
        }
        let Singular { left: u, values, right: v } = Singular::of(&DMatrix::from_row_slice(size, size, &matrix))?;
        // The largest come first.
        let place = |k: usize| size - 1 - k;
        let left = DMatrix::from_fn(size, count, |i, k| u[(i, place(k))].conj() * rows[i]);
        let right = DMatrix::from_fn(size, count, |j, k| v[(j, place(k))] * columns[j]);
        let second = if count < size { values[place(count)] } else { f64::INFINITY };
        Some(Null { near, left, right, norm: values[0], second, defect: values[place(count - 1)] / values[0] })
    }
}

/// Rows and columns multiplied so that they are alike in size; by what they were.
fn balance(matrix: &mut [C], size: usize) -> [SmallVec<[f64; 8]>; 2] {
    let mut by: [SmallVec<[f64; 8]>; 2] = [(); 2].map(|()| smallvec![1.0; size]);
    let [rows, columns] = &mut by;
    // Within a factor of √2 the modulus.
    let length = |entry: &C| entry.re.abs() + entry.im.abs();
    for _ in 0..BALANCE {
        for (row, scale) in matrix.chunks_exact_mut(size).zip(&mut *rows) {
            let by = row.iter().map(length).fold(0.0, f64::max).sqrt().recip();
            if by.is_normal() {
                *scale *= by;
                row.iter_mut().for_each(|entry| *entry *= by);
            }
        }
        for (j, scale) in columns.iter_mut().enumerate() {
            let column = || (j..size * size).step_by(size);
            let by = column().map(|at| length(&matrix[at])).fold(0.0, f64::max).sqrt().recip();
            if by.is_normal() {
                *scale *= by;
                column().for_each(|at| matrix[at] *= by);
            }
        }
    }
    by
}

#[cfg(test)]
mod tests {
    use nalgebra::{Complex, DMatrix};
    use vibrochain_breather::{Hit, Orbit};
    use vibrochain_lattice::{Barrier, Chain};

    use super::*;

    /// Two masses next to a resonance, multiplier −2782: one side's null vector led nowhere, and an error was told 40 times too small.
    #[test]
    fn both_sides_vanish_on_a_nearly_singular_matrix() {
        let chain = Chain::new(2, 0.073_966_543_980_647_89, 0.011_884_233_414_967_131).unwrap();
        let point = chain.point().omega(0.348_589_406_946_606_84);
        let model = point.amplitude(0.093_400_631_787_602_25).restitution(0.563_004_254_549_515_2).model().unwrap();
        let hit = Hit::new(0, Barrier::Lower, 0.0, -0.000_192_839_487_016_877_96);
        let orbit = &Orbit::from_impulses(&model, 1, 0.000_112_937_291_896_440_4, &[hit]).unwrap();
        let equations = vibrochain_testkit::equations_as_given(orbit);
        let function = SpectralFunction::new(&equations, false);
        let mut checked = 0;
        for off in [0.0, 1e-12, 1e-9, 1e-6] {
            let z = Complex::new(-2_781.929_653_123_471 + off, 0.0);
            let null = function.null(z, 1).unwrap();
            let entries = function.bordered(z, &null.near);
            let matrix = DMatrix::from_row_slice(null.left.nrows(), null.left.nrows(), &entries);
            let size = |x: &DMatrix<C>| x.map(modulus);
            let (left, right) = (null.left.transpose() * &matrix, &matrix * &null.right);
            let (most_left, most_right) =
                (size(&null.left).transpose() * size(&matrix), size(&matrix) * size(&null.right));
            for (off_side, most) in left.iter().zip(&most_left).chain(right.iter().zip(&most_right)) {
                assert!(modulus(*off_side) < (1e-14 + off) * most, "{off} {} {left}", null.left);
                checked += 1;
            }
        }
        assert_eq!(checked, 16);
    }
}
