//! The orbits with two impacts a period under a force of several harmonics: two equations for two unknowns.
//!
//! With one harmonic `two_impacts` eliminates the phase by X² + Y² = Ã². With several, the conditions stay linear in the
//! half sum m and half difference d of the impulses alone. About the middle of the two impacts, τ = ψ + φ/2, δ = φ − T/2,
//! h_j = jωφ/2, α_j = jωτ + θ_j:
//!
//! | letter | meaning |
//! |---|---|
//! | g_s, g_d | half sum and half difference of G at the impacts: Σ Ã_j cos α_j cos h_j, Σ Ã_j sin α_j sin h_j |
//! | v_s, v_d | the same of Ġ: −Σ jωÃ_j sin α_j cos h_j, Σ jωÃ_j cos α_j sin h_j |
//! | D = χ₂−χ₁, Σ = χ₁+χ₂, χ₃ | kernels of the paper at φ |
//!
//! ```text
//! position, and Newton's law      D X = P      Σ Y = R      χ₃X + qY = V₁      χ₃Y − qX = V₂
//! double-sided                    X = m, Y = d,   P = 1 − g_d,  R = a − g_s,      V₁ = v_s,   V₂ = −v_d
//! both on one barrier, at β       X = d, Y = m,   P = g_d,      R = g_s − β,      V₁ = −v_s,  V₂ = v_d
//! ```
//!
//! Either pair gives X and Y, the other is left; multiplied by the pair's determinants, DΣ and N = q² + χ₃²,
//!
//! ```text
//! form 0    χ₃ΣP + qDR − DΣV₁ = 0         χ₃DR − qΣP − DΣV₂ = 0             exact where DΣ ≠ 0
//! form 1    D(χ₃V₁ − qV₂) − NP = 0        Σ(qV₁ + χ₃V₂) − NR = 0            exact where N ≠ 0
//! ```
//!
//! Both hold at every solution, so that either can rule a rectangle out. As in `two_impacts` Σ enters as gΣ with the static
//! stiffness g, and everything is measured from δ = 0, where χ₃ and one of sin h_j, cos h_j (j odd) vanish together.

use smallvec::SmallVec;
use vibrochain_lattice::{ImpulseResponse, MAX_HARMONICS, Model, Wave};

use crate::roots::patch::{Patch, Piece};
use crate::roots::planar::{Planar, PlanarZeros};
use crate::search::families::pattern::Pattern;
use crate::search::families::two_impacts::TwoImpactSolution;

/// Intervals of δ, and of τ, that a search starts from at most.
const MOST_PIECES: usize = 256;

/// One parameter point.
pub(crate) struct HarmonicImpacts<'a> {
    pattern: Pattern,
    response: &'a ImpulseResponse,
    /// G
    steady: &'a Wave,
    omega: f64,
    asymmetry: f64,
    /// −β of impacts on one barrier.
    gap: f64,
    loss: f64,
    at_impulse: f64,
    stiffness: f64,
    fourth: f64,
    /// sin(jπ/2) of each harmonic.
    signs: SmallVec<[f64; MAX_HARMONICS]>,
}

/// What depends on δ alone.
#[derive(Debug, Clone)]
pub(crate) struct Strip {
    /// D, χ₃, gΣ.
    kernels: [Patch; 3],
    /// (cos h_j, sin h_j)
    halves: SmallVec<[(Patch, Patch); MAX_HARMONICS]>,
}

impl<'a> HarmonicImpacts<'a> {
    pub(crate) fn new(pattern: Pattern, model: &Model, response: &'a ImpulseResponse, steady: &'a Wave) -> Self {
        let omega = model.omega();
        // sin(jπ/2) for the odd j.
        let sign = |rate: f64| if (rate / omega).round() % 4.0 == 1.0 { 1.0 } else { -1.0 };
        Self {
            pattern,
            response,
            steady,
            omega,
            asymmetry: model.asymmetry(),
            gap: -pattern.stop(model),
            loss: model.loss(),
            at_impulse: response.dynamic_at_impulse(),
            stiffness: response.static_stiffness(),
            fourth: response.derivative_bounds()[3],
            signs: steady.terms().iter().map(|term| sign(term.rate)).collect(),
        }
    }

    /// g_s, g_d, v_s, v_d.
    fn waves(&self, strip: &Strip, tau: f64, radius: [f64; 2]) -> [Patch; 4] {
        let mut waves = [Patch::constant(0.0, radius); 4];
        for (term, (cos_h, sin_h)) in self.steady.terms().iter().zip(&strip.halves) {
            // The strip may have been made for another width of τ.
            let (cos_h, sin_h) = (cos_h.on(radius), sin_h.on(radius));
            let phase = term.rate * tau + term.phase;
            let error = f64::EPSILON * ((term.rate * tau).abs() + term.phase.abs());
            let (sin, cos) = phase.sin_cos();
            let wave = |parts: [f64; 2]| Piece::wave(parts, term.rate, 1.0).along(1, radius);
            let cos_a = wave([cos, sin]).doubted(error * sin.abs());
            let sin_a = wave([sin, -cos]).doubted(error * cos.abs());
            let (g, v) = (term.amplitude, term.rate * term.amplitude);
            waves[0] = waves[0] + (cos_a * cos_h).scaled(g);
            waves[1] = waves[1] + (sin_a * sin_h).scaled(g);
            waves[2] = waves[2] + (sin_a * cos_h).scaled(-v);
            waves[3] = waves[3] + (cos_a * sin_h).scaled(v);
        }
        waves
    }

    /// P, gR, V₁, V₂.
    fn right_sides(&self, strip: &Strip, tau: f64, radius: [f64; 2]) -> [Patch; 4] {
        let [g_sum, g_difference, v_sum, v_difference] = self.waves(strip, tau, radius);
        let (a, g) = (self.asymmetry, self.stiffness);
        if self.pattern.is_alike() {
            [g_difference, g_sum.shifted(self.gap).scaled(g), -v_sum, v_difference]
        } else {
            [(-g_difference).shifted(1.0), (-g_sum).shifted(a).scaled(g), v_sum, -v_difference]
        }
    }

    /// All zeros with δ on `from` … `to` and τ on one period `repeat` of the force.
    pub(crate) fn zeros(&self, zeros: &mut PlanarZeros, from: f64, to: f64, repeat: f64) {
        let half = 0.5 * self.response.period();
        let fastest = self.steady.top_rate();
        let top = self.response.frequencies().last().copied().unwrap_or_default().max(fastest);
        let pieces = [8 + ((to - from) * top) as usize, 4 + (repeat * fastest) as usize];
        // A start that no symmetry puts a solution on.
        let start = -0.1234 * repeat;
        // Halving does the rest.
        let pieces = pieces.map(|count| count.min(MOST_PIECES));
        zeros.find(self, [from, to], [start, start + repeat], pieces, 1e-20 * half);
    }

    /// Impulses for given δ and τ, from the conditions of position, or from Newton's law where those fail. `None` where
    /// neither determines them.
    pub(crate) fn solution(&self, [delta, tau]: [f64; 2]) -> Option<TwoImpactSolution> {
        let strip = self.strip(delta, 0.0);
        let [p, r, v1, v2] = self.right_sides(&strip, tau, [0.0; 2]);
        let [d, chi3, sum] = strip.kernels;
        let norm = chi3.value() * chi3.value() + self.loss * self.loss;
        let x = if !d.excludes_zero() && norm > 0.0 {
            (chi3.value() * v1.value() - self.loss * v2.value()) / norm
        } else {
            p.value() / d.value()
        };
        let (y, displacement) = if sum.excludes_zero() || self.stiffness == 0.0 {
            // gΣ (Y/g) = R: finite for γ₁ = 0, where Y itself is 0.
            let mean = self.waves(&strip, tau, [0.0; 2])[0].value();
            let rest = if self.pattern.is_alike() { self.gap + mean } else { self.asymmetry - mean };
            (r.value() / sum.value(), 4.0 * rest / sum.value())
        } else {
            let y = (self.loss * v1.value() + chi3.value() * v2.value()) / norm;
            (y, 4.0 * y / self.stiffness)
        };
        let (half_sum, half_difference, static_displacement) =
            if self.pattern.is_alike() { (y, x, displacement) } else { (x, y, -displacement) };
        let (p1, p2) = (half_sum - half_difference, half_sum + half_difference);
        let finite = p1.is_finite() && p2.is_finite() && tau.is_finite() && static_displacement.is_finite();
        finite.then_some(TwoImpactSolution { delta, p1, p2, theta: self.omega * tau, static_displacement })
    }
}

impl Planar for HarmonicImpacts<'_> {
    type Strip = Strip;

    fn strip(&self, delta: f64, width: f64) -> Strip {
        let radius = [width, 0.0];
        let jet = self.response.jet_from_half(delta);
        let along = |jet: [f64; 3], third: f64| Piece { jet, third, doubt: 0.0 }.along(0, radius);
        let kernel = along([jet.value, jet.slope, jet.curvature], jet.third.abs() + self.fourth * width);
        let chi3 = along([jet.slope, jet.curvature, jet.third], self.fourth).scaled(2.0);
        let difference = kernel.shifted(-self.at_impulse).scaled(2.0);
        let sum = kernel.shifted(self.at_impulse).scaled(-2.0 * self.stiffness).shifted(-4.0);
        let halves = |(term, &sign): (&vibrochain_lattice::WaveTerm, &f64)| {
            let rate = 0.5 * term.rate;
            let (sin, cos) = (rate * delta).sin_cos();
            let wave = |parts: [f64; 2]| Piece::wave(parts, rate, 1.0).along(0, radius);
            let (cosine, sine) = (wave([cos, sin]), wave([sin, -cos]));
            // h_j = jnπ/2 + jωδ/2, of n periods of the force
            if self.pattern.turns_round() { (sine.scaled(-sign), cosine.scaled(sign)) } else { (-cosine, -sine) }
        };
        Strip {
            kernels: [difference, chi3, sum],
            halves: self.steady.terms().iter().zip(&self.signs).map(halves).collect(),
        }
    }

    fn enclose(&self, strip: &Strip, [_, tau]: [f64; 2], radius: [f64; 2], form: usize) -> Option<([Patch; 2], bool)> {
        if form > 1 {
            return None;
        }
        let [d, chi3, sum] = strip.kernels.map(|kernel| kernel.on(radius));
        let [p, r, v1, v2] = self.right_sides(strip, tau, radius);
        let q = self.loss;
        if form == 0 {
            let (sum_p, d_r, d_sum) = (sum * p, d * r, d * sum);
            let first = chi3 * sum_p + d_r.scaled(q) - d_sum * v1;
            let second = chi3 * d_r - sum_p.scaled(q) - d_sum * v2;
            return Some(([first, second], d.excludes_zero() && sum.excludes_zero()));
        }
        let norm = (chi3 * chi3).shifted(q * q);
        let first = d * (chi3 * v1 - v2.scaled(q)) - norm * p;
        let second = sum * (v1.scaled(q) + chi3 * v2) - norm * r;
        Some(([first, second], norm.excludes_zero()))
    }
}
