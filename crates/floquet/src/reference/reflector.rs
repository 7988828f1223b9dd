//! Deflation of a known eigenvector: its direction becomes the first axis, the first row and column go.

use nalgebra::{DMatrix, DVector, DVectorViewMut, Dyn, Reflection, Unit, VecStorage};

/// The Householder reflection that takes the direction of a vector to ± the first axis; the identity for a vector of zeros.
pub(crate) struct Reflector(Option<Reflection<f64, Dyn, VecStorage<f64, Dyn, nalgebra::U1>>>);

impl Reflector {
    pub(crate) fn of(vector: &[f64]) -> Self {
        let vector = DVector::from_column_slice(vector);
        // No square overflows in units of the largest entry.
        let unit = Unit::try_new(&vector / vector.amax(), 0.0).map(Unit::into_inner);
        let axis = unit.and_then(|mut axis| {
            // The sign that adds: the axis never cancels.
            let first = axis.get_mut(0)?;
            *first += 1f64.copysign(*first);
            Unit::try_new(axis, 0.0)
        });
        Self(axis.map(|axis| Reflection::new(axis, 0.0)))
    }

    /// Reflects one vector.
    pub(crate) fn apply(&self, vector: &mut [f64]) {
        if let Some(reflection) = &self.0 {
            reflection.reflect(&mut DVectorViewMut::from_slice(vector, vector.len()));
        }
    }

    /// H·A·H
    pub(crate) fn reflect(&self, matrix: &mut DMatrix<f64>) {
        if let Some(reflection) = &self.0 {
            reflection.reflect(matrix);
            reflection.reflect_rows(matrix, &mut DVector::zeros(matrix.nrows()));
        }
    }

    /// H·A·H without its first row and column.
    pub(crate) fn deflated(&self, mut matrix: DMatrix<f64>) -> DMatrix<f64> {
        self.reflect(&mut matrix);
        if matrix.is_empty() { matrix } else { matrix.remove_row(0).remove_column(0) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reflection_takes_the_vector_to_the_first_axis_and_keeps_eigenvalues() {
        let v = [3e200, 0.0, 4e200];
        let reflector = Reflector::of(&v);
        let mut image = v;
        reflector.apply(&mut image);
        assert!((image[0] + 5e200).abs() < 1e186 && image[2].abs() < 1e186);
        let mut a = DMatrix::from_row_slice(3, 3, &[2.0, 1.0, 0.0, 0.0, 1.0, 0.0, 0.5, 0.0, -1.0]);
        reflector.reflect(&mut a);
        assert!((a.trace() - 2.0).abs() < 1e-15 && (a.determinant() + 2.0).abs() < 1e-14);
        Reflector::of(&[0.0; 3]).apply(&mut image);
        assert!((image[0] + 5e200).abs() < 1e186);
    }

    /// The left eigenvector (1, 1) of the eigenvalue 3, beside which −1 is left.
    #[test]
    fn a_known_eigenvalue_is_taken_out() {
        let left = Reflector::of(&[1.0, 1.0]).deflated(DMatrix::from_row_slice(2, 2, &[1.0, 2.0, 2.0, 1.0]));
        assert!(left.shape() == (1, 1) && (left[0] + 1.0).abs() < 1e-15);
        assert!(Reflector::of(&[]).deflated(DMatrix::zeros(0, 0)).is_empty());
    }
}
