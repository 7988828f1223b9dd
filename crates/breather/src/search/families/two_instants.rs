//! Orbits of two instants without force and losses, at 0 and φ = T/2 + δ, with δ ≠ 0.
//!
//! The positions give the impulses P(φ) (`positions`). Without losses Newton's law is
//!
//! ```text
//! Σ_{j at φ} P_j K′_ij(φ) = 0   for each i at 0,          Σ_{i at 0} P_i K′_ij(φ) = 0   for each j at φ.
//! ```
//!
//! All K′ are odd in δ: φ = T/2 always solves, and −δ is the mirror image in time of δ. Of one impact each, at whatever sites and
//! barriers, K′_ij(φ) = 0 is left (`errata`: "orthogonality, hence φ = π/ω"). So it is with impacts that symmetries turn into each other
//! ([`crate::Word`]'s `is_alike`): their impulses are alike but for signs σ, and the zeros are those of
//!
//! ```text
//! s(δ) = −Σ_j σ_j K′_0j(φ) = Σ_k a_k sin(Ω_kδ)/Ω_k ,      a_k = b_k² Ω_k / (2 sin(Ω_kT/2)) on a ring, for one site,
//! ```
//!
//! an odd function, so that δ > 0 is enough. Of other groups there are more equations than unknowns (`overdetermined`).
//!
//! Where both instants hit the same masses and every mode is slower than the orbit, Ω_kT/2 < π, there are none: −K′ between those masses
//! is positive definite for 0 < δ < T/2, each mode's sin Ω_kδ/sin Ω_kT/2 being positive, and it takes no impulses to 0.
//!
//! [`all`] finds every zero. A map of rings asks only for those that can be physical, and has few of them: [`candidates`] searches the
//! places that `kernel_grid` leaves.

use smallvec::{SmallVec, smallvec};
use vibrochain_lattice::simd::lanes::{LANES, Lane};
use vibrochain_lattice::{ImpulseResponse, Model};
use wide::f64x4;

use crate::orbit::Draft;
use crate::roots::dual::Dual;
use crate::roots::interval::{Clearance, Enclosed, Zeros};
use crate::roots::taylor::SUMS;
use crate::search::families::conservative::{double_sided_draft, impulses};
use crate::search::screens::kernel_grid::{KernelGrid, MOST, top};

/// Orbits closer than this part of half a period to the symmetric one, which they branch from, are not told from it; nor are two instants
/// from one.
pub(crate) const APART: f64 = 1e-6;

/// Of the sum of its terms' sizes, below which a kernel is rounding.
pub(crate) const UNFELT: f64 = 1e-14;

/// s(δ), enclosed; of one site of a ring, or home on other lattices, without shapes ([`ImpulseResponse::jet_of`]).
struct Balance<'a> {
    response: &'a ImpulseResponse,
    shapes: &'a [f64],
    /// Of |K′|, |K″|, |K‴| and |K⁗|. The first two are sizes of the terms of s and s′, too, far larger than their sums where masses are far
    /// from each other.
    bounds: [f64; 4],
    /// The same masses hit at both instants: s does not vanish where these are one.
    same_masses: bool,
}

impl<'a> Balance<'a> {
    fn new(response: &'a ImpulseResponse, shapes: &'a [f64], same_masses: bool) -> Self {
        Self { response, shapes, bounds: response.derivative_bounds_of(shapes), same_masses }
    }
}

impl Enclosed for Balance<'_> {
    fn clearances(&self, deltas: Lane, radii: Lane) -> [Clearance; LANES] {
        let [_, slope, curvature, third] = self.response.jets_of(self.shapes, deltas).map(f64x4::from);
        let [first, second, _, fourth] = self.bounds.map(f64x4::splat);
        let (deltas, radii) = (f64x4::from(deltas), f64x4::from(radii));
        let mut enclosed = Dual::from_jet([slope, curvature, third, fourth], f64x4::ZERO, radii);
        // Every term of s is odd in δ.
        let size = first.fast_min(second * (deltas.abs() + radii));
        enclosed.function.rest += size * f64x4::splat(SUMS);
        enclosed.derivative.rest += second * f64x4::splat(SUMS);
        Clearance::of(&enclosed)
    }

    fn known_zeros(&self) -> SmallVec<[f64; 2]> {
        let half = 0.5 * self.response.period();
        if self.same_masses { smallvec![0.0] } else { smallvec![0.0, half] }
    }

    fn at(&self, delta: f64) -> (f64, f64) {
        let jet = self.response.jet_of(self.shapes, delta);
        (jet.slope, jet.curvature)
    }
}

/// Every mode is slower than the orbit.
pub(crate) fn all_slower(response: &ImpulseResponse) -> bool {
    top(response) < response.omega()
}

/// How many pieces a search of 0 < δ < T/2 begins with: a few a wave of the fastest mode; halving does the rest.
pub(crate) fn pieces(response: &ImpulseResponse) -> usize {
    (8 + (0.5 * response.period() * top(response)) as usize).min(MOST)
}

/// All double-sided orbits of one site of a ring.
pub(crate) fn all(model: &Model, response: &ImpulseResponse, zeros: &mut Zeros, found: impl FnMut(Draft)) {
    if all_slower(response) {
        return;
    }
    let half = 0.5 * response.period();
    search(&Balance::new(response, &[], true), zeros, &[(0.0, half)], pieces(response));
    drafts(model, response, zeros, found);
}

/// Those that can be physical, in the places that `kernel_grid` has found.
pub(crate) fn candidates(
    model: &Model,
    response: &ImpulseResponse,
    grid: &KernelGrid,
    zeros: &mut Zeros,
    found: impl FnMut(Draft),
) {
    if grid.places().is_empty() {
        return;
    }
    search(&Balance::new(response, &[], true), zeros, grid.places(), 1);
    drafts(model, response, zeros, found);
}

/// The zeros δ > 0 of s, of impacts whose kernels have these shapes in sum, into `zeros`. Between different masses s vanishes for φ = 0,
/// too, which is one instant and left out.
pub(crate) fn times(response: &ImpulseResponse, shapes: &[f64], same_masses: bool, zeros: &mut Zeros) {
    let half = 0.5 * response.period();
    // Masses that feel nothing of each other hit whenever they like.
    let [most, ..] = response.derivative_bounds_of(shapes);
    let felt = (1..8).any(|i| response.jet_of(shapes, half * f64::from(i) / 8.0).slope.abs() > UNFELT * most);
    if !felt {
        zeros.exhausted += 1;
        return;
    }
    search(&Balance::new(response, shapes, same_masses), zeros, &[(0.0, half)], pieces(response));
    // Two instants this close are not told from one.
    zeros.unresolved.retain(|delta| same_masses || *delta < half * (1.0 - APART));
}

/// Adds the zeros of s in intervals of δ > 0 to `zeros`, each of them in so many `pieces` to begin with.
fn search(balance: &Balance<'_>, zeros: &mut Zeros, places: &[(f64, f64)], pieces: usize) {
    let shortest = APART * 0.5 * balance.response.period();
    let resolution = |delta: f64| 64.0 * f64::EPSILON * delta.max(shortest);
    for &(from, to) in places {
        zeros.find(balance, from.max(shortest), to, pieces, resolution);
    }
}

/// The double-sided orbits at the zeros of s and their mirror images.
fn drafts(model: &Model, response: &ImpulseResponse, zeros: &Zeros, mut found: impl FnMut(Draft)) {
    let half = 0.5 * response.period();
    for delta in zeros.simple.iter().flat_map(|&zero| [-zero, zero]) {
        let kernel = response.jet_from_half(delta).value;
        if let Some((impulses, displacement)) = impulses(model, response, kernel) {
            found(double_sided_draft(response, half + delta, impulses, displacement));
        }
    }
}
