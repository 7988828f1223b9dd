//! Null vectors of the bordered equations.
//!
//! One on either side comes from elimination with full pivots, several from singular vectors.

use nalgebra::{Complex, DMatrix};
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
}

impl SpectralFunction<'_> {
    /// The `count` null vectors of B(z).
    pub(super) fn null(&self, z: C, count: usize) -> Option<Null> {
        let near = self.near(z);
        let mut matrix = self.bordered(z, &near);
        let size = matrix.nrows();
        let finite = |entry: &C| entry.re.is_finite() && entry.im.is_finite();
        if count > size || !matrix.iter().all(finite) {
            return None;
        }
        let [rows, columns] = balance(&mut matrix);
        if count == 1 && size > 1 {
            // By rows, as elimination has them.
            let mut entries: Vec<C> = matrix.transpose().as_slice().to_vec();
            let largest = entries.iter().map(|entry| entry.norm_sqr()).fold(0.0, f64::max).sqrt();
            let order = eliminate(&mut entries, size, Pivots::Full)?;
            let second = modulus(entries[(size - 2) * (size + 1)]);
            let [x, y] = null_vectors(&entries, size);
            let length = |v: &[C]| v.iter().map(|z| z.norm_sqr()).sum::<f64>().sqrt();
            let scale = length(&x) * length(&y);
            let (mut left, mut right) = (DMatrix::zeros(size, 1), DMatrix::zeros(size, 1));
            for i in 0..size {
                left[order.rows[i]] = x[i] * rows[order.rows[i]];
                right[order.columns[i]] = y[i] * columns[order.columns[i]];
            }
            return Some(Null { near, left, right, norm: largest * size as f64 * scale, second: second * scale });
        }
        let Singular { left: u, values, right: v } = Singular::of(&matrix)?;
        // The largest come first.
        let place = |k: usize| size - 1 - k;
        let left = DMatrix::from_fn(size, count, |i, k| u[(i, place(k))].conj() * rows[i]);
        let right = DMatrix::from_fn(size, count, |j, k| v[(j, place(k))] * columns[j]);
        let second = if count < size { values[place(count)] } else { f64::INFINITY };
        Some(Null { near, left, right, norm: values[0], second })
    }
}

/// Rows and columns multiplied so that they are alike in size; by what they were.
fn balance(matrix: &mut DMatrix<C>) -> [Vec<f64>; 2] {
    let size = matrix.nrows();
    let (mut rows, mut columns) = (vec![1.0; size], vec![1.0; size]);
    for _ in 0..BALANCE {
        for i in 0..size {
            let largest = matrix.row(i).iter().map(|entry| modulus(*entry)).fold(0.0, f64::max);
            let by = largest.sqrt().recip();
            if by.is_normal() {
                rows[i] *= by;
                matrix.row_mut(i).iter_mut().for_each(|entry| *entry *= by);
            }
        }
        for j in 0..size {
            let largest = matrix.column(j).iter().map(|entry| modulus(*entry)).fold(0.0, f64::max);
            let by = largest.sqrt().recip();
            if by.is_normal() {
                columns[j] *= by;
                matrix.column_mut(j).iter_mut().for_each(|entry| *entry *= by);
            }
        }
    }
    [rows, columns]
}

#[cfg(test)]
mod tests {
    use nalgebra::{Complex, DMatrix};
    use vibrochain_breather::{BlochEquations, Family, breathers};
    use vibrochain_lattice::{Chain, ImpulseResponse, Model, Spectrum};

    use super::*;

    /// Two masses next to a resonance, multiplier −2782: one side's null vector led nowhere, and an error was told 40 times too small.
    #[test]
    fn both_sides_vanish_on_a_nearly_singular_matrix() {
        let chain = Chain::new(2, 0.073_966_543_980_647_89, 0.011_884_233_414_967_131).unwrap();
        let model =
            Model::forced(chain, 0.348_589_406_946_606_84, 0.0, 0.093_400_631_787_602_25, 0.563_004_254_549_515_2)
                .unwrap();
        let orbit = &breathers(&model, Family::SingleSided).unwrap().orbits[1];
        let response = ImpulseResponse::new(&Spectrum::new(chain), orbit.frequency()).unwrap();
        let (equations, _) = BlochEquations::of(orbit, &response);
        let function = SpectralFunction::new(&equations, false);
        let mut checked = 0;
        for off in [0.0, 1e-12, 1e-9, 1e-6] {
            let z = Complex::new(-2_781.929_653_123_471 + off, 0.0);
            let null = function.null(z, 1).unwrap();
            let matrix = function.bordered(z, &null.near);
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
