//! Residues of one impact a period.
//!
//! Half a period away from the impact, in normalised modes (u_site = bᵀx) with C, S = cos, sin(ΩT/2), what ½(M + M⁻¹) does to
//! displacements is diag(d) and two dyads,
//!
//! ```text
//! A = diag(d) − 2(Cb)(Cb)ᵀ + (Sb/Ω)(2ΩSb + κCb)ᵀ,
//! ```
//!
//! so that det(ν−A)/Π(ν−d) is a 2×2 determinant of sums over modes; C² = (1+d)/2 and S² = (1−d)/2 turn it into
//!
//! ```text
//! f = (ν²−1)σ² + g(h − 2κ'),   σ = Σ b²/(ν−d),  g = Σ 2b²xc/(ν−d),  h = Σ 2b²Ω²xc/(ν−d),  x = s/Ω.
//! ```
//!
//! v̈/v⁻ of the orbit itself makes 2κ' = Σ b²c/x = h(1), and h(ν) − h(1) = −(ν−1)H with H = Σ (b²c/x)/(ν−d), hence
//! f = (ν−1)F, F = (1+ν)σ² − gH. The double poles cancel ((1+d)b⁴ = 2b²xc·b²c/x) and leave
//!
//! ```text
//! R_k = 2b_k²c_k Σ_l b_l² [ u_kl − c_l (x_k−x_l)²/(x_k x_l (d_k−d_l)) ],     u_kl = 2(c_k−c_l)/(d_k−d_l) = 1/(c_k+c_l);
//! ```
//!
//! l = k gives the term b_k⁴ of (1+ν)σ² by the second form of u, which is taken whenever c_k and c_l agree in sign:
//! nothing is lost as modes come together, γ₂ → 0, and coincident ones need no care at all.

use vibrochain_lattice::simd::lanes::{Number, ONE, SMALL, TWO, ZERO, all, total};

use crate::map_paths::modes::{Mode, Modes};
use crate::map_paths::reversible::pole::Pole;

/// What the residue of one mode needs of others.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct ResidueSums {
    /// c_k Σ b²u, Σ b²c(x_k−x)²/(x_k x(d_k−d)), and errors of both in units of ε.
    straight: f64,
    bent: f64,
    straight_error: f64,
    bent_error: f64,
}

/// The sums over `modes`.
#[inline(always)]
pub(crate) fn sums(modes: &Modes, mode: &Mode) -> ResidueSums {
    let (mut straight, mut bent, mut straight_error, mut bent_error) = (ZERO, ZERO, ZERO, ZERO);
    let (ck, sk, xk) = (all(mode.cos), all(mode.sin), all(mode.sin_over));
    let opposite = sk * sk - ck * ck;
    let (ik, rk, hk) = (all(mode.inverse), all(mode.relative), all(mode.shift));
    for group in modes.groups() {
        let Mode { weight: w, cos: c, sin: s, sin_over: x, inverse, relative, shift, doubt: own, .. } = group.four();
        // The smaller of sine and cosine carries the difference of the poles.
        let by_sine = (s - sk) * (s + sk);
        let by_cosine = (ck - c) * (ck + c);
        let difference = TWO * (c * c - s * s).simd_gt(opposite).select(by_sine, by_cosine);
        // Coincident modes have t = 0, or nearly so; others that coincide are to stand out in the error.
        let difference = difference.simd_eq(ZERO).select(SMALL, difference);
        let same = (ck * c).simd_gt(ZERO);
        let sum = same.select(ck + c, ONE);
        // Two inverses from one division.
        let inverse_of_both = ONE / (difference * sum);
        let (quotient, of_sum) = (inverse_of_both * sum, inverse_of_both * difference);
        // c_k u_kl
        let u = same.select(ck * of_sum, TWO * ck * (ck - c) * quotient);
        let spread = xk - x;
        let t = w * c * spread * spread * ik * inverse * quotient;
        straight += w * u;
        bent += t;
        let doubt = (hk + shift) * quotient.abs();
        straight_error += w * (same.select(ONE, doubt) + u.abs() * own);
        bent_error += t.abs() * (rk + relative + doubt + own);
    }
    ResidueSums {
        straight: total(straight),
        bent: total(bent),
        straight_error: total(straight_error),
        bent_error: total(bent_error),
    }
}

/// The residue from the sums; `far` is what modes left out of them add to c_k Σ b²(u − …).
#[inline(always)]
pub(crate) fn residue(k: usize, mode: &Mode, sums: &ResidueSums, far: f64) -> Pole {
    let Mode { weight, cos, sin, shift, doubt, .. } = *mode;
    let whole = sums.straight - cos * sums.bent + far;
    let residue = 2.0 * weight * whole;
    let phase = shift / sin.abs().max(f64::MIN_POSITIVE);
    let error = sums.straight_error + cos.abs() * sums.bent_error + (phase + 4.0) * (sums.bent.abs() + far.abs());
    let error = error + doubt * whole.abs();
    Pole::new(k, cos, sin, shift, residue, 4.0 * f64::EPSILON * weight * (error + 1.0))
}

/// Residues into `poles`, one a mode.
pub(crate) fn residues(modes: &Modes, poles: &mut Vec<Pole>) {
    poles.clear();
    for (k, mode) in modes.list().iter().enumerate() {
        poles.push(residue(k, mode, &sums(modes, mode), 0.0));
    }
}

/// Σ R_k d_k as the trace of A − 1 wants it: 2Σb²d − 2κ'Σ2b²xc + 1, of all modes, one or four at a time.
#[inline(always)]
pub(crate) fn trace<T: Number>(modes: impl Iterator<Item = Mode<T>>) -> f64 {
    let mut sums = [T::default(); 3];
    for Mode { weight: w, cos: c, sin: s, sin_over: x, .. } in modes {
        let terms = [w * (c * c - s * s), w * x * c * 2.0, w * c / x];
        (0..3).for_each(|i| sums[i] = sums[i] + terms[i]);
    }
    let [mean, coupling, stiffness] = sums.map(T::sum);
    1.0 + 2.0 * mean - stiffness * coupling
}
