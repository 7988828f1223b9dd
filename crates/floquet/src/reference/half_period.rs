//! Conservative orbits that are their own mirror image in time: half the dimension, and the trivial pair removed exactly.
//!
//! If M⁻¹ = Q M Q with an involution Q (QQ = 1), then ½(M + M⁻¹) commutes with Q: on the space Qx = x it is an m×m
//! matrix whose eigenvalues are ν = ½(μ + 1/μ), each pair of multipliers once. μ lies on the unit circle iff
//! −1 ≤ ν ≤ 1 is real. The trivial pair μ = 1, a defective double eigenvalue of M that dense solvers split by 1e-7, is
//! the simple eigenvalue ν = 1 here, with a left eigenvector known from the orbit's own flow: reflecting it to the first
//! axis removes it.
//!
//! In normalised modes (u_site = bᵀx), with C, S = cos, sin(Ω_kT/2), the flight–impact–flight about an impact is
//!
//! ```text
//! W = L(T/2) S L(T/2):   x←x  A = cos ΩT − 2(Cb)(Cb)ᵀ + (Sb/Ω)(2ΩSb + κCb)ᵀ
//!                        x←ẋ  B = 2CS/Ω − 2(Cb)(Sb/Ω)ᵀ − 2(Sb/Ω)(Cb)ᵀ + κ(Sb/Ω)(Sb/Ω)ᵀ
//!                        ẋ←x  C = −2ΩSC + 2(ΩSb)(Cb)ᵀ + 2(Cb)(ΩSb)ᵀ + κ(Cb)(Cb)ᵀ
//! ```
//!
//! Single-sided: section half-way, M = W, Q = diag(1, −1), block A; left eigenvector ẍ(T/2) ∝ b Ω/S.
//! Double-sided: section before the impact at 0, M = W S₀, Q = diag(1, −1)·S₀; Qx = x means bᵀx = 0, ẋ = βb.

use nalgebra::DMatrix;
use vibrochain_breather::{Finder, Orbit};

use crate::error::FloquetError;
use crate::map_paths::{Mode, Modes};
use crate::reference::reflector::Reflector;
use crate::saltation::saltations;

/// Work space.
#[derive(Debug, Clone, Default)]
pub(crate) struct Reversible {
    pub(crate) block: DMatrix<f64>,
    modes: Modes,
    b: Vec<f64>,
    cb: Vec<f64>,
    sb: Vec<f64>,
    wsb: Vec<f64>,
    left: Vec<f64>,
    column: Vec<f64>,
    row: Vec<f64>,
}

impl Reversible {
    /// Builds the block of dimension ⌊M/2⌋ whose eigenvalues are the ν of all non-trivial even pairs.
    pub(crate) fn build(&mut self, orbit: &Orbit, finder: &mut Finder) -> Result<(), FloquetError> {
        let mut kappas = [0.0; 2];
        for (kappa, hit) in kappas.iter_mut().zip(saltations(orbit)?) {
            *kappa = hit.kappa;
        }
        let double = orbit.impacts().len() == 2;
        let impulse = orbit.impacts().first().map_or(0.0, |impact| impact.impulse);
        // Displacements of the modes at the section's side of the first impact.
        self.left.clear();
        let motion = finder.motion(orbit)?;
        motion.seek(0, 0.0);
        self.left.extend(motion.modes().iter().map(|mode| mode[2]));
        let response = finder.prepared(orbit)?.response();
        self.modes.set(response);
        for vector in [&mut self.b, &mut self.cb, &mut self.sb, &mut self.wsb] {
            vector.clear();
        }
        for mode in self.modes.list() {
            let b = mode.weight.sqrt();
            self.b.push(b);
            self.cb.push(mode.cos * b);
            self.sb.push(mode.sin_over * b);
            self.wsb.push(mode.sin_times * b);
        }
        let modes = self.modes.count();
        let kappa = if double { kappas[1] } else { kappas[0] };
        self.block = DMatrix::zeros(modes, modes);
        for k in 0..modes {
            let (cb, sb) = (self.cb[k], self.sb[k]);
            for (l, entry) in self.block.row_mut(k).iter_mut().enumerate() {
                *entry = -2.0 * cb * self.cb[l] + sb * (2.0 * self.wsb[l] + kappa * self.cb[l]);
                if l == k {
                    let Mode { cos, sin, .. } = self.modes.mode(k);
                    *entry += cos * cos - sin * sin;
                }
            }
        }
        if double {
            self.double_sided((kappas[0], kappa), -0.5 * impulse, response.omega());
        } else {
            // ẍ(T/2) ∝ bΩ/S; multiplied through by the smallest S it could not overflow, but rings off resonance do not.
            self.left.clear();
            self.left.extend(self.modes.list().iter().zip(&self.b).map(|(mode, b)| b * mode.frequency / mode.sin));
        }
        self.block = Reflector::of(&self.left).deflated(std::mem::take(&mut self.block));
        Ok(())
    }

    /// Turns A into the block of M = W S₀ on Qx = x, coordinates (β/ω, x⊥), and `left` into its left eigenvector.
    fn double_sided(&mut self, (kappa0, kappa1): (f64, f64), velocity: f64, omega: f64) {
        let dot = |x: &[f64], y: &[f64]| -> f64 { x.iter().zip(y).map(|(x, y)| x * y).sum() };
        let (bcb, bsb, bwsb) = (dot(&self.b, &self.cb), dot(&self.b, &self.sb), dot(&self.b, &self.wsb));
        self.column.clear();
        self.row.clear();
        for (k, mode) in self.modes.list().iter().enumerate() {
            let Mode { cos, sin_over, sin_times, .. } = *mode;
            let (b, cb, sb, wsb) = (self.b[k], self.cb[k], self.sb[k], self.wsb[k]);
            // B·b and C·b
            self.column.push(2.0 * cos * sin_over * b - 2.0 * cb * bsb - 2.0 * sb * bcb + kappa1 * sb * bsb);
            self.row.push(-2.0 * sin_times * cos * b + 2.0 * wsb * bcb + 2.0 * cb * bwsb + kappa1 * cb * bcb);
        }
        // The reflection that takes b to the first axis, up to a sign that cancels in pairs below.
        let reflector = Reflector::of(&self.b);
        reflector.reflect(&mut self.block);
        reflector.apply(&mut self.column);
        reflector.apply(&mut self.row);
        // The modes' accelerations, from weighted (b x) to normalised (x) modes.
        self.left.iter_mut().zip(&self.b).for_each(|(a, b)| *a /= b);
        reflector.apply(&mut self.left);
        let modes = self.b.len();
        // H takes b to −e₁ (b₀ > 0), so that the coordinate along b changes sign while x⊥ does not.
        let sign = -1.0;
        let (a00, b00) = (self.block[(0, 0)], sign * self.column[0]);
        for j in 1..modes {
            let entry = self.row[j] - 0.5 * kappa0 * sign * self.block[(0, j)];
            self.block[(0, j)] = entry / omega;
            self.block[(j, 0)] = -self.column[j] * omega;
        }
        self.block[(0, 0)] = -a00 + 0.5 * kappa0 * b00;
        // ω(f, x) = v₀⁻β − ẍ·x⊥
        self.left[0] = velocity * omega;
        for a in self.left.iter_mut().skip(1) {
            *a = -*a;
        }
    }
}
