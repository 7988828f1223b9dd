//! Deflation of a known eigenvector: a Householder reflection takes its direction to the first axis, whose row and column go.

use nalgebra::{DMatrix, DVector, Reflection, Unit};

/// A matrix without the eigenvalue of this left eigenvector; of zeros, without its first row and column.
pub(crate) fn deflated(mut matrix: DMatrix<f64>, left: &[f64]) -> DMatrix<f64> {
    let left = DVector::from_column_slice(left);
    // No square overflows in units of the largest entry.
    let unit = Unit::try_new(&left / left.amax(), 0.0).map(Unit::into_inner);
    let axis = unit.and_then(|mut axis| {
        // The sign that adds: the axis never cancels.
        let first = axis.get_mut(0)?;
        *first += 1f64.copysign(*first);
        Unit::try_new(axis, 0.0)
    });
    if let Some(axis) = axis {
        let reflection = Reflection::new(axis, 0.0);
        reflection.reflect(&mut matrix);
        reflection.reflect_rows(&mut matrix, &mut DVector::zeros(left.len()));
    }
    if matrix.is_empty() { matrix } else { matrix.remove_row(0).remove_column(0) }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Eigenvectors (3, 0, 4), (0, 1, 0) and (4, 0, −3) of 5, 1 and −1.
    #[test]
    fn a_long_eigenvector_is_taken_out_and_other_eigenvalues_stay() {
        let [w, v] = [[3.0, 0.0, 4.0], [4.0, 0.0, -3.0]].map(|x| DVector::from_column_slice(&x) / 5.0);
        let mut matrix = &w * w.transpose() * 5.0 - &v * v.transpose();
        matrix[(1, 1)] += 1.0;
        let rest = deflated(matrix, &[3e200, 0.0, 4e200]);
        assert!(rest.shape() == (2, 2) && rest.trace().abs() < 1e-14 && (rest.determinant() + 1.0).abs() < 1e-14);
    }

    /// The left eigenvector (1, 1) of the eigenvalue 3, beside which −1 is left.
    #[test]
    fn a_known_eigenvalue_is_taken_out() {
        let left = deflated(DMatrix::from_row_slice(2, 2, &[1.0, 2.0, 2.0, 1.0]), &[1.0, 1.0]);
        assert!(left.shape() == (1, 1) && (left[0] + 1.0).abs() < 1e-15);
        assert!(deflated(DMatrix::zeros(0, 0), &[]).is_empty());
    }
}
