//! Floquet multipliers: eigenvalues of the monodromy matrix.

use super::orbit::TrueStructureOrbit;
use crate::complex::Complex;
use crate::error::TruthError;
use crate::linear::{determinant, product};
use crate::real::Real;
use crate::root::newton;

/// Second starts are turned by this angle.
const OFF_AXIS: f64 = 1e-4;

impl TrueStructureOrbit {
    /// The largest modulus of a multiplier: the limit of ‖M^{2^k}‖^{1/2^k}, which no multiplier escapes, be it defective or one of many.
    pub fn spectral_radius(&self) -> Real {
        let mut power = self.monodromy().to_vec();
        let mut norms = Vec::with_capacity(self.bits());
        for _ in 0..self.bits() {
            let norm = power.iter().flatten().map(Real::abs).fold(Real::zero(64), |a, b| if b > a { b } else { a });
            if norm.is_zero() {
                return norm;
            }
            power.iter_mut().flatten().for_each(|entry| *entry = &*entry / &norm);
            norms.push(norm);
            power = product(&power, &power);
        }
        // ρ = n₀ · n₁^{1/2} · n₂^{1/4} …
        norms.iter().rev().fold(Real::one(64), |inner, norm| norm * inner.sqrt())
    }

    /// det(M − z)
    pub fn characteristic(&self, z: &Complex) -> Complex {
        let matrix = self.monodromy();
        let entry = |i: usize, j: usize| {
            let entry = Complex::real(matrix[i][j].clone());
            if i == j { entry - z } else { entry }
        };
        let rows = (0..matrix.len()).map(|i| (0..matrix.len()).map(|j| entry(i, j)).collect()).collect();
        determinant(rows, matrix[0][0].bits())
    }

    /// The multiplier next to `multiplier` (real and imaginary part), and how far from there it is.
    ///
    /// # Errors
    /// [`TruthError::NotConverged`]; [`TruthError::Parameter`] for a start that is zero or not finite.
    pub fn multiplier(&self, multiplier: (f64, f64)) -> Result<(Complex, f64), TruthError> {
        let modulus = multiplier.0.hypot(multiplier.1);
        if !(modulus > 0.0 && modulus.is_finite()) {
            let requirement = "a finite number that is not zero";
            return Err(TruthError::Parameter { name: "|multiplier|", value: modulus, requirement });
        }
        let work = self.monodromy()[0][0].bits();
        let start = Complex::new(multiplier.0, multiplier.1, work);
        let from = |start: &Complex| newton(start, self.bits(), work, |z| Some(self.characteristic(z)));
        let (root, ..) = match from(&start) {
            // From the real axis Newton's method never leaves it, be the roots where they may.
            Err(TruthError::NotConverged { .. }) => from(&(&start * Complex::new(1.0, OFF_AXIS, work)))?,
            outcome => outcome?,
        };
        let moved = (&root - &start).abs().to_f64();
        Ok((root, moved))
    }
}
