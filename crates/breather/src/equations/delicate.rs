//! Whether errors of an orbit could matter to its verdict, by signs that cost a sweep little; how large they are is told by [`crate::Condition`].

use vibrochain_lattice::ImpulseResponse;

use crate::equations::Equations;
use crate::orbit::Orbit;

/// Digits beyond which a lost one could show in a verdict.
const DELICATE: f64 = 1e-6;

/// Next to a resonance, to grazing or to a fold, by signs that cost little.
pub(crate) fn is_delicate(orbit: &Orbit, response: &ImpulseResponse) -> bool {
    let slowest = orbit.impacts().iter().map(|impact| impact.velocity_before.abs()).fold(f64::INFINITY, f64::min);
    delicate(response, orbit.model().omega(), (slowest, orbit.velocity_scale()))
        || !orbit.is_reversible() && Equations::new(orbit, response).system().reciprocal_condition < DELICATE
}

/// Next to a resonance or to grazing, by the slowest velocity before an impact and the scale of velocities.
pub(crate) fn delicate(response: &ImpulseResponse, omega: f64, (slowest, fastest): (f64, f64)) -> bool {
    response.condition() > 1.0 / DELICATE || slowest < DELICATE * fastest || fastest > omega / DELICATE
}
