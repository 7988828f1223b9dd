//! Whether errors of an orbit could matter to its verdict, by signs that cost a sweep little; how large they are is told by [`crate::Condition`].

use vibrochain_lattice::ImpulseResponse;

/// Digits beyond which a lost one could show in a verdict.
const DELICATE: f64 = 1e-6;

/// Errors of an orbit's data that are smaller, relative to the scale of each, do not show in a verdict.
pub(crate) const UNSEEN: f64 = 1e-10;

/// Next to a resonance or to grazing, by the slowest velocity before an impact and the scale of velocities.
pub(crate) fn delicate(response: &ImpulseResponse, omega: f64, (slowest, fastest): (f64, f64)) -> bool {
    response.condition() > 1.0 / DELICATE || slowest < DELICATE * fastest || fastest > omega / DELICATE
}
