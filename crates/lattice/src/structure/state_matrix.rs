//! Eigenvalues and eigenvectors of the state matrix of modes that dashpots couple.

use nalgebra::{DMatrix, DVector, Schur};
use rustfft::num_complex::Complex;

use super::error::StructureError;

type C = Complex<f64>;

/// Steps of QR for an eigenvalue; a handful is usual.
pub(super) const SWEEPS: usize = 60;

/// Eigenvalues λ of [[0, Ω], [−Ω, −D]] and y of their vectors (Ωy, λy); complex ones in exact pairs, real ones exactly real.
pub(super) fn eigen(squares: &[f64], damping: &DMatrix<f64>) -> Result<(Vec<C>, Vec<DVector<C>>), StructureError> {
    let m = squares.len();
    let state = DMatrix::from_fn(2 * m, 2 * m, |i, j| match (i < m, j < m) {
        (true, _) if j == i + m => squares[i].sqrt(),
        (false, true) if i == j + m => -squares[j].sqrt(),
        (false, false) => -damping[(i - m, j - m)],
        _ => 0.0,
    });
    let schur = Schur::try_new(state.map(|x| C::new(x, 0.0)), f64::EPSILON, SWEEPS * 2 * m);
    let (unitary, triangle) = schur.ok_or(StructureError::NotConverged)?.unpack();
    let norm = triangle.iter().map(|x| x.norm()).fold(0.0, f64::max);
    let (mut values, mut vectors) = (Vec::new(), Vec::new());
    for k in 0..2 * m {
        let value = triangle[(k, k)];
        let mut vector = DVector::from_element(2 * m, C::default());
        vector[k] = C::new(1.0, 0.0);
        for i in (0..k).rev() {
            let sum: C = (i + 1..=k).map(|j| triangle[(i, j)] * vector[j]).sum();
            let mut distance = triangle[(i, i)] - value;
            if distance.norm() < f64::EPSILON * norm {
                // Of one value twice any combination serves, if there are two shapes at all.
                distance = C::new(f64::EPSILON * norm, 0.0);
            }
            vector[i] = -sum / distance;
        }
        let whole = &unitary * vector;
        // Of real matrices: what is as good as real is.
        let is_real = value.im.abs() <= 1e-9 * norm * f64::EPSILON.sqrt();
        values.push(if is_real { C::new(value.re, 0.0) } else { value });
        let half = DVector::from_fn(m, |i, _| whole[i] / squares[i].sqrt());
        let length = half.iter().map(|x| x.norm_sqr()).sum::<f64>().sqrt();
        vectors.push(half / C::new(length, 0.0));
    }
    Ok((values, vectors))
}
