//! Orbits of two sites i, j that a reflection exchanges, at the same instants: neighbours in phase, or out of phase where the barriers
//! are centred.
//!
//! Sums and differences of the two sites do not mix: each block is a chain with one site that is hit, its modes the ring's with the
//! weights
//!
//! ```text
//! b² (1 ± C),     C = φ_k(i)φ_k(j)/b²  (cos 2πk(i−j)/M on a ring)
//! ```
//!
//! (of each doublet one mode is even about the middle between the two, one is odd), and its impacts have the saltations of the orbit.
//! The orbit swings in one block, which has its trivial pair and is in all what an orbit of one site is. Of the other block, below
//! with weights w, against w₊ of the orbit's, nothing makes ν = 1 a zero of f: with f as in [`crate::map_paths::reversible::single_sided`] and
//! [`crate::map_paths::reversible::double_sided`], x, c, s, K, Λ, χ as there and
//!
//! ```text
//! α = Σ (w−w₊)/x,   β = Σ (w−w₊)c/x,   A = Σ w/x,   w − w₊ = ∓2b²C:
//!
//! one instant:    f = f₀ + βg,    f(1) = β Σ wxc/s²,            f₀ what it would be with saltations of its own
//! two instants:   f(1) = −Σ wx/(1−c) · Σ wx/(1+c) · [β² − 2χβA₊ − α(A+A₊)],    residues of f by K, Λ as ever.
//! ```
//!
//! α and β are what one site feels of the other: nothing cancels as they become small, two breathers far apart.
//!
//! F = f/(ν−1) has then one pole more, at ν = 1 with residue f(1), and one zero more. All that is said of F elsewhere holds as it is:
//! ΣR = 1, the trace, as many zeros as poles but one, a zero in each gap between equal signs, and one beyond +1 if its outermost pole,
//! ν = 1 itself, has a negative residue. That zero, next to 1 for breathers far apart, is the pair of their phases.

use crate::map_paths::modes::{Mode, Modes};
use crate::map_paths::reversible::pole::Pole;

/// A number and its error.
#[derive(Debug, Clone, Copy, Default)]
struct Known {
    value: f64,
    error: f64,
}

impl Known {
    /// Adds a term with its error in units of ε.
    fn add(&mut self, term: f64, error: f64) {
        self.value += term;
        self.error += f64::EPSILON * (error + 4.0 * term.abs());
    }
}

/// The block that the orbit is not in, seen from the one that it is in.
#[derive(Debug)]
pub(crate) struct Foreign<'a> {
    /// Modes of the orbit's block.
    pub(crate) orbit: &'a Modes,
    period: f64,
    /// α, β
    alpha: Known,
    beta: Known,
}

impl<'a> Foreign<'a> {
    pub(crate) fn new(all: &Modes, signed: &[f64], orbit: &'a Modes, period: f64) -> Self {
        let (mut alpha, mut beta) = (Known::default(), Known::default());
        for (mode, cosine) in all.list().iter().zip(signed) {
            let stiffness = -2.0 * mode.weight * mode.inverse;
            let error = stiffness.abs() * (cosine.abs() * mode.relative + 2.0);
            alpha.add(stiffness * cosine, error);
            let phase = mode.frequency * period;
            let turned = (stiffness * cosine * mode.sin).abs() * phase;
            beta.add(stiffness * cosine * mode.cos, error * mode.cos.abs() + turned);
        }
        Self { orbit, period, alpha, beta }
    }

    /// β.
    pub(crate) fn offset(&self) -> f64 {
        self.beta.value
    }

    /// Error of a term with x/s² or less and a factor of order c, relative and in units of ε.
    fn relative(&self, mode: &Mode) -> f64 {
        3.0 * mode.relative + mode.frequency * self.period
    }

    /// One instant: βg/(ν−1) is added to F, whose poles are known; its own pole is returned.
    pub(crate) fn single_sided(&self, modes: &Modes, poles: &mut [Pole]) -> Pole {
        let mut sum = Known::default();
        for pole in poles {
            let mode = modes.mode(pole.mode as usize);
            let size = mode.weight * mode.sin_over / (mode.sin * mode.sin);
            let mut share = Known::default();
            share.add(size * mode.cos, size.abs() * self.relative(&mode));
            pole.residue -= self.beta.value * share.value;
            pole.error += self.beta.error * share.value.abs() + self.beta.value.abs() * share.error;
            sum.value += share.value;
            sum.error += share.error;
        }
        let (residue, beta) = (self.beta.value * sum.value, self.beta);
        Pole::at_one(residue, beta.error * sum.value.abs() + beta.value.abs() * sum.error)
    }

    /// Two instants, with this ratio of impulses: the pole at 1.
    pub(crate) fn double_sided(&self, modes: &Modes, ratio: f64, ratio_error: f64) -> Pole {
        let (mut below, mut above) = (Known::default(), Known::default());
        let stiffness = |modes: &Modes| {
            modes.list().iter().fold(Known::default(), |mut sum, mode| {
                let term = mode.weight * mode.inverse;
                sum.add(term, term.abs() * mode.relative);
                sum
            })
        };
        let (own, orbit) = (stiffness(modes), stiffness(self.orbit));
        for mode in modes.list() {
            // x/(1 ∓ c): of both denominators, the product of which is s², the larger one is known.
            let large = 1.0 + mode.cos.abs();
            let (near, far) =
                (mode.weight * mode.sin_over * large / (mode.sin * mode.sin), mode.weight * mode.sin_over / large);
            let (left, right) = if mode.cos > 0.0 { (near, far) } else { (far, near) };
            below.add(left, left.abs() * self.relative(mode));
            above.add(right, right.abs() * self.relative(mode));
        }
        let (alpha, beta) = (self.alpha, self.beta);
        let chi = 0.5 * (ratio + 1.0 / ratio);
        let both = own.value + orbit.value;
        let terms = [beta.value * beta.value, -2.0 * chi * beta.value * orbit.value, -alpha.value * both];
        let bracket: f64 = terms.iter().sum();
        let error = 2.0 * (beta.value.abs() + (chi * orbit.value).abs()) * beta.error
            + 2.0 * beta.value.abs() * (chi.abs() * orbit.error + ratio_error * chi.abs() * orbit.value.abs())
            + alpha.value.abs() * (own.error + orbit.error)
            + both.abs() * alpha.error
            + 8.0 * f64::EPSILON * terms.map(f64::abs).iter().sum::<f64>();
        let product = below.value * above.value;
        let product_error = below.value.abs() * above.error + above.value.abs() * below.error;
        Pole::at_one(-product * bracket, product.abs() * error + product_error * bracket.abs())
    }
}
