//! Eigenvalues of a monodromy matrix with Krein's form.

use std::f64::consts::TAU;

use vibrochain_floquet::Complex;

/// An eigenvalue of a monodromy matrix and Krein's form ½i(ẋ̄·x − x̄·ẋ) on its eigenvector.
pub(crate) type Krein = (Complex<f64>, f64);

/// |μ| − 1 of the largest, the trivial pair's rounding aside.
pub(crate) fn excess(values: &[Krein]) -> f64 {
    values.iter().map(|(z, _)| z.norm() - 1.0).fold(0.0, f64::max)
}

/// Distance of two phases on the circle.
pub(crate) fn apart(a: f64, b: f64) -> f64 {
    let d = (a - b).rem_euclid(TAU);
    d.min(TAU - d)
}
