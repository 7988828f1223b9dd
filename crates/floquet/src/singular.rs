//! Singular values and vectors of small complex matrices, the largest first, by faer: nalgebra's vectors have both sides orthogonal, yet of a
//! nearly singular matrix the wrong ones now and then (its issue 1172).

use faer::MatRef;
use nalgebra::{Complex, DMatrix};

type C = Complex<f64>;

/// A = U diag(values) Vᴴ.
pub(crate) struct Singular {
    pub(crate) left: DMatrix<C>,
    pub(crate) values: Vec<f64>,
    pub(crate) right: DMatrix<C>,
}

impl Singular {
    /// `None` of a matrix that is not finite.
    pub(crate) fn of(matrix: &DMatrix<C>) -> Option<Self> {
        if !matrix.iter().all(|entry| entry.re.is_finite() && entry.im.is_finite()) {
            return None;
        }
        let svd = MatRef::from_column_major_slice(matrix.as_slice(), matrix.nrows(), matrix.ncols()).svd().ok()?;
        let (u, v) = (svd.U(), svd.V());
        Some(Self {
            left: DMatrix::from_fn(u.nrows(), u.ncols(), |i, j| u[(i, j)]),
            values: svd.S().column_vector().iter().map(|value| value.re).collect(),
            right: DMatrix::from_fn(v.nrows(), v.ncols(), |i, j| v[(i, j)]),
        })
    }

    /// The least value.
    pub(crate) fn least(&self) -> f64 {
        self.values.iter().copied().fold(f64::INFINITY, f64::min)
    }
}
