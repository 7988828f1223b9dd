//! Eigenvalues of a small dense matrix, by the library that is fastest at its size.

use faer::MatRef;
use nalgebra::{Complex, DMatrix, Schur};
use vibrochain_breather::BreatherError;
use vibrochain_lattice::{Stop, aside};

use crate::error::FloquetError;
use crate::sizes::LARGE;

/// Up to this dimension nalgebra's unblocked QR is the faster one, beyond it faer's blocked one (measured by
/// `cargo bench --bench spectrum`).
const SMALL: usize = 42;

/// QR sweeps per eigenvalue after which nalgebra is told to give up; a handful is usual.
const SWEEPS: usize = 60;

/// All eigenvalues of a square matrix, unordered, appended to `values`.
///
/// # Errors
/// [`FloquetError::NotConverged`], also for a matrix that is not square or not finite, on which the iterations would never end, or
/// whose norm is beyond 1e154, on which they overflow.
///
/// ```
/// use vibrochain_floquet::{DMatrix, eigenvalues};
/// let mut values = Vec::new();
/// eigenvalues(&DMatrix::from_row_slice(2, 2, &[0.0, -1.0, 1.0, 0.0]), &mut values)?;
/// assert!(values.iter().all(|value| value.re.abs() < 1e-15 && (value.im.abs() - 1.0).abs() < 1e-15));
/// # Ok::<(), vibrochain_floquet::FloquetError>(())
/// ```
pub fn eigenvalues(matrix: &DMatrix<f64>, values: &mut Vec<Complex<f64>>) -> Result<(), FloquetError> {
    eigenvalues_until(matrix, values, &Stop::default())
}

/// The same, until `stop` is raised; libraries do not look at it, so that large matrices go to a thread that can be left.
///
/// # Errors
/// As [`eigenvalues`]; [`FloquetError::Breather`] if it was stopped.
pub(crate) fn eigenvalues_until(
    matrix: &DMatrix<f64>,
    values: &mut Vec<Complex<f64>>,
    stop: &Stop,
) -> Result<(), FloquetError> {
    if matrix.nrows() <= LARGE {
        return eigenvalues_here(matrix, values);
    }
    let matrix = matrix.clone();
    let work = move || {
        let mut values = Vec::new();
        eigenvalues_here(&matrix, &mut values).map(|()| values)
    };
    values.extend(aside(stop, work).map_err(BreatherError::from)??);
    Ok(())
}

fn eigenvalues_here(matrix: &DMatrix<f64>, values: &mut Vec<Complex<f64>>) -> Result<(), FloquetError> {
    let dimension = matrix.nrows();
    let failed = FloquetError::NotConverged { dimension };
    if !(matrix.is_square() && matrix.norm().is_finite()) {
        return Err(failed);
    }
    if dimension <= SMALL {
        if dimension == 0 {
            return Ok(());
        }
        // Of the transpose, which has the same eigenvalues: the other way rounding leaves 1.7e-12 of a pair that nearly coincides, where a test
        // against many digits asks for 1e-12 (crates/truth/tests/secular.rs).
        if let Some(schur) = Schur::try_new(matrix.transpose(), f64::EPSILON, SWEEPS * dimension) {
            let before = values.len();
            diagonal_blocks(&schur.unpack().1, values);
            let finite = |value: &Complex<f64>| value.re.is_finite() && value.im.is_finite();
            return if values[before..].iter().all(finite) { Ok(()) } else { Err(failed) };
        }
        // Stagnation is known on multiples of the unit matrix plus rounding (uncoupled masses); faer takes those.
    }
    let dense = MatRef::from_column_major_slice(matrix.as_slice(), dimension, dimension);
    let found = dense.eigenvalues().map_err(|_| failed.clone())?;
    // faer may stop without having converged; a lost eigenvalue shows in the trace.
    let sum: f64 = found.iter().map(|value| value.re).sum();
    let slack = 1e3 * f64::EPSILON * dimension as f64 * (matrix.norm() + 1.0);
    if found.iter().any(|value| !value.re.is_finite() || !value.im.is_finite()) || (matrix.trace() - sum).abs() > slack
    {
        return Err(failed);
    }
    values.extend(found.iter().map(|value| Complex::new(value.re, value.im)));
    Ok(())
}

/// The eigenvalues of a quasi-triangular matrix. nalgebra's own reading takes the pair of a 2×2 block for complex and gets
/// NaN from one whose discriminant is not negative, by rounding.
fn diagonal_blocks(t: &DMatrix<f64>, values: &mut Vec<Complex<f64>>) {
    let mut i = 0;
    while i < t.nrows() {
        if i + 1 == t.nrows() || t[(i + 1, i)] == 0.0 {
            values.push(Complex::new(t[(i, i)], 0.0));
            i += 1;
            continue;
        }
        let (mean, half) = (0.5 * (t[(i, i)] + t[(i + 1, i + 1)]), 0.5 * (t[(i, i)] - t[(i + 1, i + 1)]));
        let discriminant = half.mul_add(half, t[(i, i + 1)] * t[(i + 1, i)]);
        let root = discriminant.abs().sqrt();
        let (re, im) = if discriminant < 0.0 { (0.0, root) } else { (root, 0.0) };
        values.extend([Complex::new(mean + re, im), Complex::new(mean - re, -im)]);
        i += 2;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A triangular matrix: its eigenvalues are its diagonal.
    fn with_known_spectrum(size: usize) -> DMatrix<f64> {
        let mut matrix = DMatrix::identity(size, size);
        for i in 0..size {
            for j in i..size {
                matrix[(i, j)] = if i == j { (i % 7) as f64 } else { 0.3 };
            }
        }
        matrix
    }

    #[test]
    fn both_libraries_find_a_triangular_matrix_diagonal() {
        for size in [1, 2, 30, 42, 43, 60] {
            let mut values = Vec::new();
            eigenvalues(&with_known_spectrum(size), &mut values).unwrap();
            assert_eq!(values.len(), size);
            let sum: f64 = values.iter().map(|v| v.re).sum();
            let expected: f64 = (0..size).map(|i| (i % 7) as f64).sum();
            assert!((sum - expected).abs() < 1e-9);
        }
    }

    #[test]
    fn uncoupled_masses_multiple_of_the_unit_matrix_with_rounding() {
        let mut matrix = DMatrix::identity(10, 10);
        for i in 0..10 {
            for j in 0..10 {
                let noise = 1e-16 * ((i * 31 + j * 17) % 7) as f64;
                matrix[(i, j)] = noise + if i == j { -0.83 } else { 0.0 };
            }
        }
        let mut values = Vec::new();
        eigenvalues(&matrix, &mut values).unwrap();
        assert!(values.len() == 10 && values.iter().all(|v| (v.re + 0.83).abs() < 1e-14 && v.im.abs() < 1e-14));
    }

    #[test]
    fn a_block_with_a_real_pair_is_not_read_as_a_complex_one() {
        let mut values = Vec::new();
        // (λ − 1)² = 4e-4, (λ − 2)² = −4e-4, and 3 alone.
        let mut t = DMatrix::zeros(5, 5);
        for (i, diagonal) in [1.0, 1.0, 2.0, 2.0, 3.0].into_iter().enumerate() {
            t[(i, i)] = diagonal;
        }
        (t[(0, 1)], t[(1, 0)], t[(2, 3)], t[(3, 2)]) = (4.0, 1e-4, 4.0, -1e-4);
        diagonal_blocks(&t, &mut values);
        let expected = [(1.02, 0.0), (0.98, 0.0), (2.0, 0.02), (2.0, -0.02), (3.0, 0.0)];
        for (value, (re, im)) in values.iter().zip(expected) {
            assert!((value.re - re).abs() < 1e-14 && (value.im - im).abs() < 1e-14, "{value}");
        }
        assert_eq!(values.len(), 5);
    }

    #[test]
    fn a_matrix_that_is_not_finite_is_refused() {
        let mut matrix = DMatrix::identity(4, 4);
        matrix[(1, 2)] = f64::NAN;
        assert!(eigenvalues(&matrix, &mut Vec::new()).is_err());
        matrix[(1, 2)] = 1e200;
        assert!(eigenvalues(&matrix, &mut Vec::new()).is_err());
    }
}
