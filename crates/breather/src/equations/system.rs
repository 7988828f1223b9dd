//! A Jacobian and its inverse, scaled by the natural sizes of the unknowns.

use smallvec::smallvec;

use crate::equations::linear::{Factors, Matrix, Vector, dot};

/// The Jacobian and its inverse.
#[derive(Debug, Clone)]
pub(crate) struct System {
    pub(crate) matrix: Matrix,
    inverse: Matrix,
    /// Reciprocal condition number of J, rows and columns scaled.
    pub(crate) reciprocal_condition: f64,
}

impl System {
    /// `units` are natural sizes of the unknowns.
    pub(crate) fn new(matrix: Matrix, units: &[f64]) -> Self {
        let n = matrix.size();
        let mut scaled = Matrix::from_fn(n, |i, j| matrix[(i, j)] * units[j]);
        let mut sizes: Vector = smallvec![1.0; n];
        for (i, size) in sizes.iter_mut().enumerate() {
            let largest = scaled.row(i).iter().fold(0.0_f64, |size, x| size.max(x.abs()));
            if largest > 0.0 {
                *size = largest;
                scaled.row_mut(i).iter_mut().for_each(|x| *x /= largest);
            }
        }
        let norm =
            |matrix: &Matrix| (0..n).map(|i| matrix.row(i).iter().map(|x| x.abs()).sum::<f64>()).fold(0.0, f64::max);
        let forward = norm(&scaled);
        let Some(factors) = Factors::new(scaled) else {
            let inverse = Matrix::from_fn(n, |_, _| f64::INFINITY);
            return Self { matrix, inverse, reciprocal_condition: 0.0 };
        };
        let scaled = factors.inverse();
        let condition = forward * norm(&scaled);
        // One that is no number is that of a matrix without inverse.
        let reciprocal_condition =
            if condition >= 1.0 { 1.0 / condition } else { f64::from(u8::from(condition > 0.0)) };
        let inverse = Matrix::from_fn(n, |i, j| units[i] * scaled[(i, j)] / sizes[j]);
        Self { matrix, inverse, reciprocal_condition }
    }

    /// J⁻¹ r
    pub(crate) fn solve(&self, rows: &[f64]) -> Vector {
        (0..rows.len()).map(|i| dot(self.inverse.row(i), rows)).collect()
    }

    /// |J⁻¹| r for r ≥ 0; an error of 0 stays 0 next to a singular J.
    pub(crate) fn spread(&self, rows: &[f64]) -> Vector {
        let carried = |i: usize| self.inverse.row(i).iter().zip(rows).filter(|(_, row)| **row != 0.0);
        (0..rows.len()).map(|i| carried(i).map(|(entry, row)| entry.abs() * row).sum()).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::equations::linear::zeros;

    /// Row by row and column by column as the definitions have it.
    #[test]
    fn systems_are_scaled_inverted_and_conditioned_as_they_say() {
        let mut random = fastrand::Rng::with_seed(9);
        for round in 0..100 {
            let n = 1 + round % 7;
            let matrix: Vec<f64> = (0..n * n).map(|_| random.f64() - 0.5).collect();
            let units: Vector = (0..n).map(|_| 10f64.powf(4.0 * random.f64() - 2.0)).collect();
            let system = System::new(Matrix::from_fn(n, |i, j| matrix[i * n + j]), &units);
            let scaled: Vec<Vec<f64>> = (0..n)
                .map(|i| {
                    let row: Vec<f64> = (0..n).map(|j| matrix[i * n + j] * units[j]).collect();
                    let size = row.iter().fold(0.0_f64, |size, x| size.max(x.abs()));
                    row.iter().map(|x| x / size).collect()
                })
                .collect();
            let sizes: Vec<f64> = (0..n).map(|i| matrix[i * n] * units[0] / scaled[i][0]).collect();
            // The columns of the inverse of what is scaled, from solutions.
            let columns: Vec<Vector> = (0..n)
                .map(|j| {
                    let mut rows = zeros(n);
                    rows[j] = sizes[j];
                    system.solve(&rows)
                })
                .collect();
            let norm = |entry: &dyn Fn(usize, usize) -> f64| {
                (0..n).map(|i| (0..n).map(|j| entry(i, j).abs()).sum::<f64>()).fold(0.0, f64::max)
            };
            let inverse = |i: usize, j: usize| columns[j][i] / units[i];
            let product = |i: usize, j: usize| (0..n).map(|k| scaled[i][k] * inverse(k, j)).sum::<f64>();
            let condition = norm(&|i, j| scaled[i][j]) * norm(&inverse);
            for i in 0..n {
                for j in 0..n {
                    let unit = if i == j { 1.0 } else { 0.0 };
                    assert!((product(i, j) - unit).abs() < 1e-14 * condition, "{i} {j}: {}", product(i, j));
                }
            }
            assert!((system.reciprocal_condition * condition - 1.0).abs() < 1e-12, "{condition}");
        }
    }
}
