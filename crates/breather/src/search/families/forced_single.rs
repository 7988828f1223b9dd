//! Forced single-sided breathers (paper, sec. II B and appendix B).
//!
//! With Y = Ã sin ωψ, X = Ã cos ωψ the two conditions −pχ₂ + X = a − 1 and ωY = qp leave, on X² + Y² = Ã²,
//!
//! ```text
//! (χ₂² + q²/ω²) p² − 2(1−a)χ₂ p + (1−a)² − Ã² = 0 ,
//! ```
//!
//! a quadratic that stays regular as q → 0, where the paper's p = ωÃ sin ωψ/q is 0/0 (`errata`).

use smallvec::{SmallVec, smallvec};
use vibrochain_lattice::{Barrier, ImpulseResponse, Model};

use crate::error::NoBreather;
use crate::orbit::{Draft, Family, Hit};
use crate::search::families::conservative::single_sided_draft;

/// Both solutions, or why there is none. `force` is Ã. Those on the upper barrier are mirror images, half a period later in the
/// force, of solutions with that barrier's distance.
pub(crate) fn single_sided(
    model: &Model,
    response: &ImpulseResponse,
    force: f64,
    barrier: Barrier,
) -> Result<SmallVec<[Draft; 2]>, NoBreather> {
    let (omega, q, g) = (model.omega(), model.loss(), response.static_stiffness());
    if g == 0.0 {
        return Err(NoBreather::NetImpulse);
    }
    let gap = model.barrier(barrier).abs();
    // In U = 2pS₀, the static displacement: −pχ₂ = U(1 + gK̂(0)), p = gU/2; regular for soft rings.
    let chi = -(1.0 + g * response.dynamic_at_impulse());
    let loss = 0.5 * q * g / omega;
    let norm = chi.hypot(loss);
    // (χ² + l²)U² − 2 gap χ U + gap² − Ã² = 0. The discriminant over (χ²+l²) is Ã² − (gap·l/norm)².
    let foot = gap * loss / norm;
    let threshold = amplitude_for(model, force, foot);
    let discriminant = (force.abs() - foot) * (force.abs() + foot);
    if !(norm > 0.0 && norm.is_finite()) {
        return Err(NoBreather::Singular);
    }
    if discriminant < 0.0 {
        return Err(NoBreather::ForceTooWeak { threshold });
    }
    let root = discriminant.sqrt();
    let mut drafts = SmallVec::new();
    for sign in [1.0, -1.0] {
        let u = (gap * chi / norm + sign * root) / norm;
        let (x, y) = (u * chi - gap, u * loss);
        let psi = (y / force).atan2(x / force).rem_euclid(std::f64::consts::TAU) / omega;
        let p = 0.5 * g * u;
        if p.is_finite() {
            drafts.push(match barrier {
                Barrier::Lower => single_sided_draft(response, psi, p, u),
                Barrier::Upper => {
                    let impacts = smallvec![Hit::new(0, Barrier::Upper, 0.0, -2.0 * p)];
                    let psi = (psi + 0.5 * model.period()).rem_euclid(model.period());
                    Draft::new(response, (Family::Word, 1), psi, impacts, -u)
                }
            });
        }
        if root == 0.0 {
            break;
        }
    }
    Ok(drafts)
}

/// The amplitude of the force that moves the mass by `swing` without impacts, where the model's own moves it by `force`.
pub(crate) fn amplitude_for(model: &Model, force: f64, swing: f64) -> f64 {
    let omega = model.omega();
    let stiffness = if model.chain().has_walls() {
        model.amplitude() / force.abs()
    } else {
        (model.chain().gamma1() - omega * omega).abs()
    };
    stiffness * swing
}
