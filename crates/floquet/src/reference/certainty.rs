//! How certain a computed eigenvalue is.
//!
//! A perturbation of a matrix of norm η moves a simple eigenvalue λ by up to κ(λ)η, with κ = ‖x‖‖y‖/|yᴴx| of its right
//! and left eigenvectors. Two that meet have κ → ∞; two that merely pass keep it.

use nalgebra::{Complex, DMatrix, DVector};
use vibrochain_breather::{Condition, LatticeOrbit};

use crate::saltation::Saltation;

/// Steps of inverse iteration: the first already has the eigenvector to the digits that a condition number needs.
const STEPS: usize = 2;

/// Condition number of the eigenvalue of `matrix` next to `value`, by inverse iteration; ∞ for one that cannot be told
/// from a defective one.
pub(crate) fn eigenvalue_condition(matrix: &DMatrix<f64>, value: Complex<f64>) -> f64 {
    let n = matrix.nrows();
    let scale = matrix.norm().max(f64::MIN_POSITIVE);
    if n <= 1 {
        return 1.0;
    }
    // A shift off the eigenvalue by rounding keeps the factors finite.
    let shift = value + f64::EPSILON * scale;
    let shifted = matrix.map(|entry| Complex::new(entry, 0.0)) - DMatrix::from_diagonal_element(n, n, shift);
    let sides = [shifted.adjoint(), shifted].map(|side| {
        let factors = side.lu();
        // A start without symmetry has a part along every eigenvector.
        let mut vector = DVector::from_fn(n, |i, _| Complex::new(1.0, (1.7 * i as f64).sin()));
        for _ in 0..STEPS {
            if !factors.solve_mut(&mut vector) {
                return None;
            }
            let length = vector.norm();
            if !(length.is_finite() && length > 0.0) {
                return None;
            }
            vector.unscale_mut(length);
        }
        Some(vector)
    });
    let [Some(left), Some(right)] = sides else { return f64::INFINITY };
    let overlap = left.dotc(&right);
    let condition = 1.0 / overlap.re.hypot(overlap.im);
    if condition.is_finite() { condition.max(1.0) } else { f64::INFINITY }
}

/// How far, relative to its norm, the monodromy matrix of an orbit may be off: rounding of the eigenvalue iteration, of
/// the phases Ω_kT, and the orbit's own errors in κ = (1+e)v̈/v⁻ and in the times between impacts.
pub(crate) fn relative_uncertainty(orbit: LatticeOrbit<'_>, condition: &Condition, dimension: usize, top: f64) -> f64 {
    let e = orbit.model().restitution();
    let mut uncertainty = f64::EPSILON * (dimension as f64 + top * orbit.period());
    for (impact, error) in orbit.impacts().iter().zip(&condition.impacts) {
        let kappa = Saltation::of(impact, e).kappa;
        let velocity = impact.velocity_before.abs();
        let off = ((1.0 + e) * error.acceleration + kappa.abs() * error.impulse / (1.0 + e)) / velocity;
        // Against the size of the saltation: of nearly inelastic impacts little else is in the matrix.
        uncertainty += off / (kappa.abs() + e * orbit.frequency()) + top * error.time;
    }
    uncertainty
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn condition_of_known_matrices() {
        let zero = Complex::new(0.0, 0.0);
        // Symmetric: 1.
        let symmetric = DMatrix::from_row_slice(2, 2, &[2.0, 1.0, 1.0, 2.0]);
        assert!((eigenvalue_condition(&symmetric, Complex::new(3.0, 0.0)) - 1.0).abs() < 1e-9);
        // [[0, 1], [δ², 0]]: eigenvectors (1, ±δ) and (±δ, 1): κ = (1 + δ²)/(2δ).
        for delta in [1.0, 1e-2, 1e-5] {
            let matrix = DMatrix::from_row_slice(2, 2, &[0.0, 1.0, delta * delta, 0.0]);
            let expected = (1.0 + delta * delta) / (2.0 * delta);
            let condition = eigenvalue_condition(&matrix, Complex::new(delta, 0.0));
            assert!((condition / expected - 1.0).abs() < 1e-3, "{delta}: {condition} {expected}");
        }
        // Defective, and a multiple of the unit matrix.
        let jordan = DMatrix::from_row_slice(2, 2, &[0.0, 1.0, 0.0, 0.0]);
        assert!(eigenvalue_condition(&jordan, zero) > 1e7);
        assert!(eigenvalue_condition(&DMatrix::identity(1, 1), Complex::new(1.0, 0.0)) == 1.0);
    }
}
