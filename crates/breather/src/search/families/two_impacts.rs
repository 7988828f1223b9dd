//! The forced orbits with two impacts a period, reduced to one equation for φ.
//!
//! Double-sided orbits (upper barrier at 0, lower at φ) and those with both impacts on one barrier, in one period of the force or in
//! two (period-doubled), are treated alike. The paper takes φ as given, eliminates the phase ψ on two branches and solves a(φ) = a by extrapolation. Taken
//! about the middle of the two impacts the same four conditions become symmetric:
//!
//! | letter | meaning |
//! |---|---|
//! | m, d | half sum and half difference of the impulses, p₁ = m − d, p₂ = m + d |
//! | θ = ω(ψ+φ/2), h = ωφ/2 | phase of the force at the middle, half the phase between the impacts |
//! | X, Y | Ã cos θ, Ã sin θ |
//! | D = χ₂−χ₁, Σ = χ₁+χ₂, χ₃ | kernels of the paper at φ |
//!
//! ```text
//! double-sided    D m + Y sin h = 1          Σ d + X cos h = a
//!                 χ₃ m + q d + ωY cos h = 0  χ₃ d − q m + ωX sin h = 0
//! one barrier     D d − Y sin h = 0          Σ m − X cos h = −β              β = a − 1, or a + 1 with p₁, p₂ < 0
//!                 χ₃ d + q m − ωY cos h = 0  χ₃ m − q d − ωX sin h = 0
//! ```
//!
//! For given φ they are linear in (m, d, X, Y). Cramer's rule gives X = x/Δ, Y = y/Δ with S = q² + χ₃²,
//!
//! ```text
//! Δ = ωχ₃(D cos²h + Σ sin²h) − sin h cos h (S + ω²DΣ)
//! double-sided    x = aω χ₃ D cos h − a S sin h − ωq Σ cos h      y = ω sin h (χ₃Σ + aqD) − S cos h
//! one barrier     x = −β(S sin h − ωχ₃ D cos h)                   y = βωq D sin h
//! ```
//!
//! and the one condition left, X² + Y² = Ã², becomes E(φ) = x² + y² − Ã²Δ² = 0: an analytic function without branches of
//! ψ, without edges of existence and without poles, whose zeros on the period are all the solutions.
//!
//! Everything is measured from half the orbit's period, nπ/ω for one of n periods of the force: δ = φ − nπ/ω and h = nπ/2 + ωδ/2.
//! At δ = 0 χ₃ and one of sin h, cos h vanish together, and keeping their relative accuracy keeps that of E down to δ → 0, where solutions crowd as q → 0, as
//! a → 0 and at bifurcations. Σ enters as gΣ with the static stiffness g = 1/S₀ (all three above times g): regular
//! for γ₁ → 0.

use vibrochain_lattice::simd::lanes::{LANES, Lane};
use vibrochain_lattice::{ImpulseResponse, Model};
use wide::f64x4;

use crate::orbit::Draft;
use crate::roots::dual::{Algebra, Dual};
use crate::roots::interval::{Clearance, Enclosed, Zeros};
use crate::roots::taylor::Taylor;
use crate::search::families::conservative::two_impact_draft;
use crate::search::families::pattern::Pattern;

/// Where δ = 0 solves by itself (a = 0, e = 1 or γ₁ = 0, and always for a doubled orbit), E has a double zero there that
/// is not a pair of orbits; the search stays this fraction of the half period away from it. Asymmetric orbits closer
/// than that to their bifurcation are not told from the symmetric one.
pub(crate) const SYMMETRIC_GUARD: f64 = 1e-7;

/// What breaks the symmetry is q a gD, which puts the two orbits next to δ = 0 at δ/T of that order: below this, they
/// are at δ = 0 to rounding.
pub(crate) const SYMMETRIC: f64 = 1e-18;

/// One parameter point of a two-impact problem.
pub(crate) struct TwoImpacts<'a> {
    pub(crate) pattern: Pattern,
    pub(crate) response: &'a ImpulseResponse,
    /// Frequency ω of the force.
    pub(crate) omega: f64,
    asymmetry: f64,
    /// −β of impacts on one barrier.
    gap: f64,
    loss: f64,
    /// Ã
    force: f64,
    at_impulse: f64,
    stiffness: f64,
    fourth: f64,
}

/// Impulses and phase that belong to a zero δ of E.
#[derive(Debug, Clone, Copy)]
pub(crate) struct TwoImpactSolution {
    /// φ − T/2
    pub(crate) delta: f64,
    /// Half impulses, positive for a right-signed orbit.
    pub(crate) p1: f64,
    pub(crate) p2: f64,
    /// θ
    pub(crate) theta: f64,
    /// Static displacement of site 0, net impulse × S₀.
    pub(crate) static_displacement: f64,
}

impl TwoImpactSolution {
    /// The orbit with it, ψ told.
    pub(crate) fn draft(&self, response: &ImpulseResponse, pattern: Pattern, psi: f64) -> Draft {
        let phi = 0.5 * response.period() + self.delta;
        two_impact_draft(response, pattern, psi, phi, (self.p1, self.p2), self.static_displacement)
    }
}

impl<'a> TwoImpacts<'a> {
    pub(crate) fn new(pattern: Pattern, model: &Model, response: &'a ImpulseResponse, force: f64) -> Self {
        Self {
            pattern,
            response,
            omega: model.omega(),
            asymmetry: model.asymmetry(),
            gap: -pattern.stop(model),
            loss: model.loss(),
            force,
            at_impulse: response.dynamic_at_impulse(),
            stiffness: response.static_stiffness(),
            fourth: response.derivative_bounds()[3],
        }
    }

    /// D, χ₃, Σ·g, sin h and cos h about four δ.
    fn pieces(&self, deltas: Lane, radii: Lane) -> [Dual<Taylor<1, f64x4>>; 5] {
        let [value, slope, curvature, third] = self.response.jets_from_half(deltas).map(f64x4::from);
        let (radius, fourth) = (f64x4::from(radii), f64x4::splat(self.fourth));
        let kernel = Dual::from_jet([value, slope, curvature, third], fourth, radius);
        let slope = Dual::from_jet([slope, curvature, third, fourth], f64x4::ZERO, radius);
        let difference = kernel.shifted(-self.at_impulse).scaled(2.0);
        let sum = kernel.shifted(self.at_impulse).scaled(-2.0 * self.stiffness).shifted(-4.0);
        let rate = 0.5 * self.omega;
        let phases = deltas.map(|delta| (rate * delta).sin_cos());
        let (sin, cos) = (f64x4::from(phases.map(|(sin, _)| sin)), f64x4::from(phases.map(|(_, cos)| cos)));
        let [sin_h, cos_h] = self.pattern.waves(cos, sin).map(|(cos, sin)| Dual::wave(cos, sin, rate, 1.0, radius));
        [difference, slope.scaled(2.0), sum, sin_h, cos_h]
    }

    /// The same at δ.
    fn pieces_at(&self, delta: f64) -> [Dual<f64>; 5] {
        let jet = self.response.jet_from_half(delta);
        let kernel = Dual { function: jet.value, derivative: jet.slope };
        let slope = Dual { function: jet.slope, derivative: jet.curvature };
        let difference = kernel.shifted(-self.at_impulse).scaled(2.0);
        let sum = kernel.shifted(self.at_impulse).scaled(-2.0 * self.stiffness).shifted(-4.0);
        let rate = 0.5 * self.omega;
        let (sin, cos) = (rate * delta).sin_cos();
        let [sin_h, cos_h] =
            self.pattern.waves(cos, sin).map(|(cos, sin)| Dual { function: cos, derivative: -rate * sin });
        [difference, slope.scaled(2.0), sum, sin_h, cos_h]
    }

    /// (x, y, Δ) from these.
    fn cramer<T: Algebra>(&self, [d, chi3, sum, sin, cos]: [T; 5]) -> [T; 3] {
        let (q, g, w, a) = (self.loss, self.stiffness, self.omega, self.asymmetry);
        let s = (chi3 * chi3).shifted(q * q);
        let (d_cos, sum_sin) = (d * cos, sum * sin);
        let determinant = (chi3 * ((d_cos * cos).scaled(g) + sum_sin * sin)).scaled(w)
            - sin * cos * (s.scaled(g) + (d * sum).scaled(w * w));
        if self.pattern.is_alike() {
            let gap = self.gap * g;
            let x = (s * sin - (chi3 * d_cos).scaled(w)).scaled(gap);
            [x, (d * sin).scaled(-gap * w * q), determinant]
        } else {
            let x = (chi3 * d_cos).scaled(a * w * g) - (s * sin).scaled(a * g) - (sum * cos).scaled(w * q);
            let y = (chi3 * sum_sin + (d * sin).scaled(a * q * g)).scaled(w) - (s * cos).scaled(g);
            [x, y, determinant]
        }
    }

    /// All zeros of E on `from` … `to`, in δ, begun with `least` intervals at least.
    pub(crate) fn zeros(&self, zeros: &mut Zeros, from: f64, to: f64, least: usize) {
        let half = 0.5 * self.response.period();
        let top = self.response.frequencies().last().copied().unwrap_or_default().max(self.omega);
        // A few intervals a wave of the fastest mode to begin with; halving does the rest.
        let pieces = least + ((to - from) * top) as usize;
        // Resolution relative to δ: towards δ = 0 solutions crowd on ever smaller scales, and E keeps its digits.
        zeros.find(self, from, to, pieces.min(4096), |delta| 64.0 * f64::EPSILON * delta.abs().max(1e-20 * half));
    }

    /// Impulses and phase at a zero δ. `None` where the conditions do not determine them.
    pub(crate) fn solution(&self, delta: f64) -> Option<TwoImpactSolution> {
        let [x, y, determinant] = self.cramer(self.pieces_at(delta)).map(|point| point.function);
        let scale = determinant * self.force;
        self.with_phase(delta, (y / scale).atan2(x / scale))
    }

    /// Impulses for given δ and θ.
    pub(crate) fn with_phase(&self, delta: f64, theta: f64) -> Option<TwoImpactSolution> {
        let [d, _, sum, sin_h, cos_h] = self.pieces_at(delta).map(|point| point.function);
        let (x, y) = (self.force * theta.cos(), self.force * theta.sin());
        let (half_sum, half_difference, static_displacement) = if self.pattern.is_alike() {
            let rest = x * cos_h + self.gap;
            (rest * self.stiffness / sum, y * sin_h / d, 4.0 * rest / sum)
        } else {
            let rest = self.asymmetry - x * cos_h;
            ((1.0 - y * sin_h) / d, rest * self.stiffness / sum, -4.0 * rest / sum)
        };
        let (p1, p2) = (half_sum - half_difference, half_sum + half_difference);
        let finite = p1.is_finite() && p2.is_finite() && theta.is_finite() && static_displacement.is_finite();
        finite.then_some(TwoImpactSolution { delta, p1, p2, theta, static_displacement })
    }
}

impl Enclosed for TwoImpacts<'_> {
    fn clearances(&self, deltas: Lane, radii: Lane) -> [Clearance; LANES] {
        let pieces = self.pieces(deltas, radii);
        // Where the function itself has no zero nobody asks for its slope.
        let function = self.condition(pieces.map(|piece| piece.function)).clearance().to_array();
        if function.iter().all(|clearance| *clearance > 0.0) {
            return function.map(Clearance::away);
        }
        Clearance::of(&self.condition(pieces))
    }

    fn at(&self, delta: f64) -> (f64, f64) {
        let point = self.condition(self.pieces_at(delta));
        (point.function, point.derivative)
    }
}

impl TwoImpacts<'_> {
    /// E = x² + y² − Ã²Δ².
    fn condition<T: Algebra>(&self, pieces: [T; 5]) -> T {
        let [x, y, determinant] = self.cramer(pieces);
        let scaled = determinant.scaled(self.force);
        x * x + y * y - scaled * scaled
    }
}

/// A time shorter than any flight between the two barriers. From the conditions,
/// (m²+d²)(χ₃²+q²) ≤ ω²Ã² and Dm = 1 − Y sin h; with |χ₃| ≤ V, |χ₃′| ≤ W and χ₃(0⁺) = 1 one has χ₃ ≥ ½ and D ≤ Vφ for
/// φ ≤ 1/(2W), hence 2Vφω|Ã| ≥ 1 − ½ω|Ã|φ. `driven` is ω|Ã|, or whatever else bounds |Ġ|.
pub(crate) fn shortest_flight(response: &ImpulseResponse, driven: f64) -> f64 {
    let [slope, curvature, ..] = response.derivative_bounds();
    let (v, w) = (2.0 * slope, 2.0 * curvature);
    (0.5 / w).min(1.0 / (driven * (2.0 * v + 0.5))).min(0.5 * response.period())
}
