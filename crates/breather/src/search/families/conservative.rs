//! Conservative breathers (paper, sec. II A).
//!
//! Double-sided, φ = T/2: p₁,₂ = 1/(χ₂−χ₁) ∓ a/(χ₁+χ₂). Single-sided: p = (1−a)/χ₂.
//!
//! Double-sided ones with φ ≠ T/2, which the paper does without, are in `two_instants`.

use smallvec::smallvec;
use vibrochain_lattice::{Barrier, ImpulseResponse, Model};

use crate::error::NoBreather;
use crate::orbit::{Draft, Family, Hit};

/// A double-sided orbit of site 0, with impacts at 0 and φ, from its half impulses p₂ and p₁ and its static displacement there: P = −2p₂ and 2p₁.
pub(crate) fn double_sided_draft(
    response: &ImpulseResponse,
    phi: f64,
    (p1, p2): (f64, f64),
    static_displacement: f64,
) -> Draft {
    let impacts = smallvec![Hit::new(0, Barrier::Upper, 0.0, -2.0 * p2), Hit::new(0, Barrier::Lower, phi, 2.0 * p1)];
    Draft::new(response, (Family::DoubleSided, 1), 0.0, impacts, static_displacement)
}

/// Half impulses and static displacement for impacts at 0 and φ without force, given K₀(φ)'s dynamic part.
pub(crate) fn impulses(model: &Model, response: &ImpulseResponse, kernel: f64) -> Option<((f64, f64), f64)> {
    let (at_impulse, g) = (response.dynamic_at_impulse(), response.static_stiffness());
    // m = (p₁+p₂)/2 = 1/(χ₂−χ₁); d = (p₂−p₁)/2 = a/(χ₁+χ₂), where χ₁+χ₂ = −(4 + 2g(K̂(0)+K̂(φ)))/g.
    let half_sum = 0.5 / (kernel - at_impulse);
    let a = model.asymmetry();
    let static_displacement = if a == 0.0 { 0.0 } else { 2.0 * a / (2.0 + g * (at_impulse + kernel)) };
    let half_difference = -0.25 * static_displacement * g;
    let (p1, p2) = (half_sum - half_difference, half_sum + half_difference);
    (p1.is_finite() && p2.is_finite()).then_some(((p1, p2), static_displacement))
}

/// The double-sided breather with φ = T/2.
pub(crate) fn double_sided(model: &Model, response: &ImpulseResponse) -> Result<Draft, NoBreather> {
    let (impulses, displacement) = impulses(model, response, response.dynamic_at_half()).ok_or(NoBreather::Singular)?;
    Ok(double_sided_draft(response, 0.5 * response.period(), impulses, displacement))
}

/// The single-sided breather.
pub(crate) fn single_sided(model: &Model, response: &ImpulseResponse) -> Result<Draft, NoBreather> {
    let (p, static_displacement) = impulse(model, response)?;
    let impacts = smallvec![Hit::new(0, Barrier::Lower, 0.0, 2.0 * p)];
    Ok(Draft::new(response, (Family::SingleSided, 1), 0.0, impacts, static_displacement))
}

/// Its half impulse and static displacement.
pub(crate) fn impulse(model: &Model, response: &ImpulseResponse) -> Result<(f64, f64), NoBreather> {
    let g = response.static_stiffness();
    if g == 0.0 {
        return Err(NoBreather::NetImpulse);
    }
    // 2p(S₀ + K̂(0)) = a − 1
    let static_displacement = (model.asymmetry() - 1.0) / (1.0 + g * response.dynamic_at_impulse());
    let p = 0.5 * static_displacement * g;
    if p.is_finite() { Ok((p, static_displacement)) } else { Err(NoBreather::Singular) }
}

/// Whether the mass of a single-sided breather of this net impulse goes beyond the other barrier half a period after its impact: where
/// it must turn, and often does too late. By more than rounding.
pub(crate) fn crosses(model: &Model, response: &ImpulseResponse, net_impulse: f64) -> bool {
    let static_displacement = net_impulse / response.static_stiffness();
    let swing = net_impulse * response.dynamic_at_half();
    static_displacement + swing > model.asymmetry() + 1.0 + 1e-9 * (1.0 + static_displacement.abs() + swing.abs())
}
