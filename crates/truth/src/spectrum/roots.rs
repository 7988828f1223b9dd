//! Multipliers as roots of the determinant, by Newton's method: in z, or in ν where they come in reciprocal pairs.

use super::{TrueSpectrum, half_sum};
use crate::complex::{Complex, shifted};
use crate::error::TruthError;
use crate::real::Real;
use crate::root::newton;

/// Second starts are turned by this angle.
const OFF_AXIS: f64 = 1e-4;

impl TrueSpectrum {
    /// The multiplier on the even subspace next to `multiplier` (real and imaginary part), to all digits asked for; and how
    /// far from the start it is. A far root is an answer too: the caller knows how good the start was.
    ///
    /// # Errors
    /// [`TruthError::OnPole`] for e^{±iΩT} of several modes of one frequency (γ₂ = 0); [`TruthError::NotConverged`];
    /// [`TruthError::Parameter`] for a start that is zero or not finite.
    pub fn refine(&self, multiplier: (f64, f64)) -> Result<(Complex, f64), TruthError> {
        let modulus = multiplier.0.hypot(multiplier.1);
        if !(modulus > 0.0 && modulus.is_finite()) {
            let requirement = "a finite number that is not zero";
            return Err(TruthError::Parameter { name: "|multiplier|", value: modulus, requirement });
        }
        let start = Complex::new(multiplier.0, multiplier.1, self.work);
        let from = |start: &Complex| if self.symplectic { self.reciprocal_root(start) } else { self.root(start) };
        let outcome = match from(&start) {
            // From the real axis Newton's method never leaves it, be the roots where they may.
            Err(TruthError::NotConverged { .. }) => {
                let aside = Complex::new(1.0, OFF_AXIS, self.work);
                from(&(&start * aside))
            }
            outcome => outcome,
        };
        // How far Newton's method went tells whether the shared pole itself was meant.
        let moved = match &outcome {
            Ok(root) => (root - &start).abs(),
            Err(_) => Real::new(f64::INFINITY, 64),
        };
        for pole in self.poles.iter().filter(|pole| pole.multiplicity > 1) {
            let sin = (-(&pole.cos * &pole.cos) + 1.0).abs().sqrt();
            let on_circle = Complex { re: pole.cos.clone(), im: if multiplier.1 < 0.0 { -sin } else { sin } };
            let distance = (on_circle - &start).abs();
            if distance < 1e-6 && moved > distance * 16.0 {
                return Err(TruthError::OnPole { mode: pole.mode, multiplicity: pole.multiplicity });
            }
        }
        outcome.map(|root| (root, moved.to_f64()))
    }

    /// In z.
    fn root(&self, start: &Complex) -> Result<Complex, TruthError> {
        let explicit = self.near(&half_sum(start));
        let value = |z: &Complex| self.regular(z, &half_sum(z), &explicit);
        let (z, step, iterations) = newton(start, self.bits, self.work, value)?;
        self.accept(step - z.log2_abs(), iterations, z, start)
    }

    /// In ν = ½(z+1/z), back to that of z and 1/z which is nearer to the start.
    fn reciprocal_root(&self, start: &Complex) -> Result<Complex, TruthError> {
        let nu = half_sum(start);
        let explicit = self.near(&nu);
        let value = |nu: &Complex| self.regular(&pair_of(nu).0, nu, &explicit);
        let (nu, step, iterations) = newton(&nu, self.bits, self.work, value)?;
        let (plus, minus) = pair_of(&nu);
        let distance = |z: &Complex| (z - start).norm_sqr();
        let z = if distance(&plus) <= distance(&minus) { plus } else { minus };
        // dz/z = dν/√(ν²−1), and next to ν = ±1 a square root of the error of ν.
        let error =
            step - 0.5 * step.max((shifted(&nu, &Real::new(-1.0, 64)) * shifted(&nu, &Real::one(64))).log2_abs());
        self.accept(error, iterations, z, start)
    }

    fn accept(&self, error: f64, iterations: usize, z: Complex, start: &Complex) -> Result<Complex, TruthError> {
        if error <= -(self.bits as f64) && z.is_finite() {
            return Ok(z);
        }
        let moved = (&z - start).abs().to_f64();
        Err(TruthError::NotConverged { iterations, last_step: error * 2f64.log10(), moved })
    }
}

/// z and 1/z from ν, the larger one first.
fn pair_of(nu: &Complex) -> (Complex, Complex) {
    let one = Real::one(64);
    let root = (shifted(nu, &-&one) * shifted(nu, &one)).sqrt();
    let (plus, minus) = (nu + &root, nu - &root);
    let large = if plus.norm_sqr() >= minus.norm_sqr() { plus } else { minus };
    let small = large.inverse();
    (large, small)
}
