//! How strong a stripe is without looking for it: what a wave gains at the breather.
//!
//! A wave e^{iΩt} that reaches the breather is turned in part into its partner at jω − Ω, which has the other signature: what the two
//! carry, each counted with its sign, stays what it is. So the wave comes back cosh η times as strong, beside sinh η of the partner, and
//! cosh η = 1/|R|, R the coefficient of reflection with waves of the partner that come in and none that run off ([`DressedModes::reflection`]). On a ring of
//! M masses both are back after M over their group velocities v, and where the two fit on the ring they gain e^η each time:
//!
//! ```text
//! ln|μ| = T √(v_k v_l) η/M per period,    v = dΩ/dq = D/2Ω,    D² = (Ω²−γ₁)(γ₁+4γ₂−Ω²).
//! ```
//!
//! Over half the width of the stripe the sum of both frequencies moves by as much as they grow: half the width is ln|μ| ω/(jπ), as long as
//! frequencies of modes do not move themselves. M enters by 1/M alone; all else is the infinite ring's.
//!
//! Hardly coupled masses, γ₂ ≪ γ₁, have η in closed form. Modes that do not move the mass that is hit, q = π(2k+1)/M, pull at it with
//! γ₂ √(8/M) sin q. Its answer at jω − Ω to a force e^{iΩt}, both next to √γ₁, follows from N of `reversal` for one mass, where all that
//! is of order γ₂ in numerator and denominator cancels: 1/2γ₁ for one impact a period, δ/Tγ₁² for two, δ = ½|X − 1/X|√γ₁ and X the
//! ratio of both impulses, −(1+a)/(1−a) at jω = 2√γ₁. Two oscillators of frequencies Ω and jω − Ω with such a coupling grow by
//!
//! ```text
//! ln|μ| = C (γ₂/γ₁)² sin q_k sin q_l/M,    C = 2πj with one impact, 8a/(1−a²) with two,    j odd.
//! ```
//!
//! For even j a harmonic of ω is at √γ₁ itself: resonance.

use std::f64::consts::{PI, TAU};

use vibrochain_breather::Family;
use vibrochain_floquet::{DressedModes, StripeLine};
use vibrochain_lattice::Model;

/// The largest ln|μ| per period in the stripe where two modes of a ring meet, told from the modes of an orbit in it or next to it, and its
/// model. The longer the ring and the thinner the stripe the better (docs/stripes.md).
///
/// `None` off a ring, for the internal mode, where a wave has several partners in the band, and where the two modes pass.
pub fn growth_at_meeting(modes: &DressedModes, model: &Model, (k, l): (usize, usize)) -> Option<f64> {
    let chain = model.chain();
    if !chain.is_ring() || k.max(l) + 1 >= modes.count() {
        return None;
    }
    let (one, other) = (modes.frequency(k)?, modes.frequency(l)?);
    let [low, high] = [chain.gamma1(), chain.gamma1() + 4.0 * chain.gamma2()];
    let carries = |w: f64| w * w > low && w * w < high;
    let most = ((high.sqrt() + one) / model.omega()).ceil() as i32;
    let partners = (-most..=most).filter(|j| *j != 0 && carries(one + f64::from(*j) * model.omega())).count();
    if partners != 1 {
        return None;
    }
    let gain = modes.reflection(one).norm().recip().acosh();
    let speed = |w: f64| ((w * w - low) * (high - w * w)).max(0.0).sqrt() / (2.0 * w);
    let growth = TAU / model.omega() * (speed(one) * speed(other)).sqrt() * gain / chain.sites() as f64;
    growth.is_finite().then_some(growth)
}

/// The same where γ₂ ≪ γ₁, in closed form: half the width of the stripe is ω/(πj) of it.
///
/// `None` for even harmonics, off a ring, and for families other than the two.
pub fn weak_growth(line: &StripeLine, (k, l): (usize, usize), harmonic: usize) -> Option<f64> {
    let (chain, a) = (line.model.chain(), line.model.asymmetry());
    if !chain.is_ring() || harmonic.is_multiple_of(2) || chain.gamma1() == 0.0 {
        return None;
    }
    let strength = match line.family {
        Family::SingleSided => TAU * harmonic as f64,
        Family::DoubleSided => 8.0 * a / ((1.0 - a) * (1.0 + a)),
        _ => return None,
    };
    let sites = chain.sites() as f64;
    let [one, other] = [k, l].map(|k| (PI * (2 * k + 1) as f64 / sites).sin());
    Some(strength * (chain.gamma2() / chain.gamma1()).powi(2) * one * other / sites)
}
