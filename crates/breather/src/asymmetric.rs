//! Conservative double-sided breathers with φ ≠ T/2.
//!
//! Energy balance at the impacts asks for χ₃(φ) = 0. φ = T/2 always solves it, and alone if every mode is slower than the
//! breather; otherwise there can be more (`errata`: "orthogonality, hence φ = π/ω"). With δ = φ − T/2 they are the zeros
//! of
//!
//! ```text
//! s(δ) = −K₀′(φ) = Σ_k a_k sin(Ω_kδ)/Ω_k ,      a_k = b_k² Ω_k / (2 sin(Ω_kT/2)) ,
//! ```
//!
//! an odd function, so that δ > 0 is enough: −δ gives the mirror image in time.
//!
//! [`all`] finds every zero. A map asks only for those that can be physical, and has few of them: [`candidates`] searches the places
//! that `rises` leaves.

use vibrochain_lattice::{ImpulseResponse, Model};
use wide::f64x4;

use crate::conservative::{impulses, two_impact_draft};
use crate::enclosure::Dual;
use crate::lanes::{LANES, Lane};
use crate::orbit::{Draft, Family};
use crate::rises::{MOST, Rises, top};
use crate::roots::{Clearance, Enclosed, Zeros};

/// Orbits closer than this part of half a period to the symmetric one, which they branch from, are not told from it.
const APART: f64 = 1e-6;

/// s(δ), enclosed.
struct Balance<'a> {
    response: &'a ImpulseResponse,
    fourth: f64,
}

impl Enclosed for Balance<'_> {
    fn clearances(&self, deltas: Lane, radii: Lane) -> [Clearance; LANES] {
        let [_, slope, curvature, third] = self.response.jets_from_half(deltas).map(f64x4::from);
        let fourth = f64x4::splat(self.fourth);
        Clearance::of(&Dual::from_jet([slope, curvature, third, fourth], 0.0, f64x4::from(radii)))
    }

    fn at(&self, delta: f64) -> (f64, f64) {
        let jet = self.response.jet_from_half(delta);
        (jet.slope, jet.curvature)
    }
}

/// All of them.
pub(crate) fn all(model: &Model, response: &ImpulseResponse, zeros: &mut Zeros, found: impl FnMut(Draft)) {
    if top(response) < response.omega() {
        // Then Ω_kT/2 < π and every mode's sin Ω_kδ/sin Ω_kT/2 has the sign of δ: s ≠ 0 for δ ≠ 0.
        return;
    }
    let half = 0.5 * response.period();
    let pieces = 8 + (half * top(response)) as usize;
    search(response, zeros, &[(0.0, half)], pieces.min(MOST));
    drafts(model, response, zeros, found);
}

/// Those that can be physical, in the places that `rises` has found.
pub(crate) fn candidates(
    model: &Model,
    response: &ImpulseResponse,
    rises: &Rises,
    zeros: &mut Zeros,
    found: impl FnMut(Draft),
) {
    if rises.places().is_empty() {
        return;
    }
    search(response, zeros, rises.places(), 1);
    drafts(model, response, zeros, found);
}

/// Adds the zeros of s in intervals of δ > 0 to `zeros`, each of them in so many `pieces` to begin with.
fn search(response: &ImpulseResponse, zeros: &mut Zeros, places: &[(f64, f64)], pieces: usize) {
    let balance = Balance { response, fourth: response.derivative_bounds()[3] };
    let shortest = APART * 0.5 * response.period();
    let resolution = |delta: f64| 64.0 * f64::EPSILON * delta.max(shortest);
    for &(from, to) in places {
        zeros.find(&balance, from.max(shortest), to, pieces, resolution);
    }
}

/// The orbits at the zeros of s and their mirror images.
fn drafts(model: &Model, response: &ImpulseResponse, zeros: &Zeros, mut found: impl FnMut(Draft)) {
    let half = 0.5 * response.period();
    for delta in zeros.simple.iter().flat_map(|&zero| [-zero, zero]) {
        let kernel = response.jet_from_half(delta).value;
        if let Some((impulses, displacement)) = impulses(model, response, kernel) {
            found(two_impact_draft(response, Family::DoubleSided, 0.0, half + delta, impulses, displacement));
        }
    }
}
