//! Whether a perturbation breaks the symmetry of an orbit that is its own mirror image after half a period.
//!
//! Without asymmetry u(t) → −u(t + T/2) turns solutions into solutions: the force has odd harmonics alone. An orbit that this
//! leaves as it is has equal saltations S at both impacts, and its monodromy is a square, (LS)², of half a period's flight L
//! after one impact. A real μ > 1 is then σ², σ = ±√μ of LS:
//!
//! - σ > 0: what is added to the orbit comes back after half a period with its sign, the orbit with the opposite one. The
//!   symmetry is lost. Where σ = 1 the mirrored map −LS doubles its period, a pitchfork of the orbit.
//! - σ < 0: the perturbed motion is as symmetric as the orbit. Nothing that lacks the symmetry branches off.
//!
//! ```text
//! det(σ − LS)/det(σ − L) = det(1 − GD),     D = S − 1 = [[−(1+e), 0], [κ, −(1+e)]],
//! G = Σ_k b_k² (σL_k − 1)/(σ² − 2c_kσ + 1),     L_k = [[c, s/Ω], [−sΩ, c]],  c = cos Ω_kT/2,  s = sin Ω_kT/2.
//! ```
//!
//! (That is the determinant of J(z) for half the period and one impact; at real z the sums are real.)
//! All denominators are positive, and so is the determinant far to the right: it is negative just below √μ if √μ, and not −√μ,
//! is the leading σ.

use vibrochain_breather::{Orbit, Prepared};

use crate::saltation::Saltation;
use crate::verdict::Verdict;

/// How far, relatively, an orbit may be from its mirror image: rounding next to a resonance is below that, and asymmetric orbits
/// as near as that lie within its square of the pitchfork where they begin.
const NEAR: f64 = 1e-10;

/// By what part of μ the determinant is looked at below it, at least: its rounding matters less there.
const BELOW: f64 = 1e-8;

/// The orbit is its own mirror image after half a period.
pub(crate) fn is_symmetric(orbit: &Orbit) -> bool {
    let [first, second] = orbit.impacts() else { return false };
    let apart = second.time - first.time;
    orbit.is_centred()
        && orbit.force_periods() == 1
        && first.site == second.site
        && first.barrier != second.barrier
        && (apart / orbit.period() - 0.5).abs() < NEAR
        && (first.impulse + second.impulse).abs() < NEAR * first.impulse.abs()
}

/// The leading multiplier of a symmetric orbit, real and above 1, belongs to a perturbation that breaks its symmetry. `false`
/// also where errors leave that open.
pub(crate) fn breaks_symmetry(prepared: Prepared<'_>, verdict: &Verdict) -> bool {
    let (orbit, response) = (prepared.orbit(), prepared.response());
    let Some(impact) = orbit.impacts().first() else { return false };
    let excess = verdict.excess();
    let below = (2.0 * verdict.resolution).max(BELOW * (1.0 + excess));
    if below >= 0.5 * excess {
        return false;
    }
    let sigma = (1.0 + excess - below).sqrt();
    let (mut diagonal, mut upper, mut lower) = (0.0, 0.0, 0.0);
    // b_k² of the site that is hit.
    let weights = response.weights().iter().zip(response.shapes().evens(impact.site, impact.site));
    let modes = response.frequencies().iter().zip(weights.map(|(weight, shape)| weight * shape));
    for ((&frequency, weight), (&c, &s)) in modes.zip(response.cos_half().iter().zip(response.sin_half())) {
        // (σ − c)² + s², without the cancellation of σ² − 2cσ + 1.
        let share = weight / ((sigma - c) * (sigma - c) + s * s);
        diagonal += share * (sigma * c - 1.0);
        upper += share * sigma * if frequency > 0.0 { s / frequency } else { 0.5 * response.period() };
        lower -= share * sigma * s * frequency;
    }
    let restitution = orbit.model().restitution();
    let (loss, kappa) = (1.0 + restitution, Saltation::of(impact, restitution).kappa);
    // 1 − GD, rows (u, v).
    let [[a, b], [c, d]] = [
        [1.0 + loss * diagonal - kappa * upper, loss * upper],
        [loss * lower - kappa * diagonal, 1.0 + loss * diagonal],
    ];
    let size = (1.0 + loss * diagonal.abs() + (kappa * upper).abs()) * d.abs()
        + b.abs() * ((loss * lower).abs() + (kappa * diagonal).abs());
    let rounding = 16.0 * response.modes() as f64 * f64::EPSILON * size;
    a * d - b * c < -rounding
}
