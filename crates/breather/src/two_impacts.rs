//! The forced orbits with two impacts a period, reduced to one equation for φ.
//!
//! Double-sided (upper barrier at 0, lower at φ) and period-doubled orbits (lower barrier at 0 and at φ) are treated
//! alike. The paper takes φ as given, eliminates the phase ψ on two branches and solves a(φ) = a by extrapolation. Taken
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
//! period-doubled  D d − Y sin h = 0          Σ m − X cos h = 1 − a
//!                 χ₃ d + q m − ωY cos h = 0  χ₃ m − q d − ωX sin h = 0
//! ```
//!
//! For given φ they are linear in (m, d, X, Y); eliminating m and d leaves two linear equations for (X, Y), and
//! X² + Y² = Ã² is the one equation left. Multiplied by the determinant it is an analytic function E(φ) without
//! branches of ψ, without edges of existence and without poles, whose zeros on the period are all the solutions.
//!
//! Everything is measured from half the orbit's period, δ = φ − T/2: there χ₃ and one of sin h, cos h vanish
//! together, and keeping their relative accuracy keeps that of E down to δ → 0, where solutions crowd as q → 0, as
//! a → 0 and at bifurcations. Σ is used as Σ/S₀⁻¹ (static stiffness g = 1/S₀): regular for γ₁ → 0.

use vibrochain_lattice::ImpulseResponse;

use crate::enclosure::Dual;
use crate::roots::{Enclosed, Zeros};

/// Which of the two words.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Word {
    DoubleSided,
    PeriodDoubled,
}

/// One parameter point of a two-impact problem.
pub(crate) struct TwoImpacts<'a> {
    pub(crate) word: Word,
    pub(crate) response: &'a ImpulseResponse,
    /// Frequency ω of the force.
    pub(crate) omega: f64,
    pub(crate) asymmetry: f64,
    pub(crate) loss: f64,
    /// Ã
    pub(crate) force: f64,
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

/// The two equations a₁X + a₂Y = r.
type Rows = [[Dual; 3]; 2];

impl<'a> TwoImpacts<'a> {
    pub(crate) fn new(
        word: Word,
        response: &'a ImpulseResponse,
        omega: f64,
        asymmetry: f64,
        loss: f64,
        force: f64,
    ) -> Self {
        Self {
            word,
            response,
            omega,
            asymmetry,
            loss,
            force,
            at_impulse: response.dynamic_at_impulse(),
            stiffness: response.static_stiffness(),
            fourth: response.derivative_bounds()[3],
        }
    }

    /// D, χ₃, Σ·g, sin h and cos h about δ.
    fn pieces(&self, delta: f64, radius: f64) -> [Dual; 5] {
        let jet = self.response.jet_from_half(delta);
        let kernel = Dual::from_jet([jet.value, jet.slope, jet.curvature, jet.third], self.fourth, radius);
        let slope = Dual::from_jet([jet.slope, jet.curvature, jet.third, self.fourth], 0.0, radius);
        let difference = kernel.shifted(-self.at_impulse).scaled(2.0);
        let sum = kernel.shifted(self.at_impulse).scaled(-2.0 * self.stiffness).shifted(-4.0);
        let rate = 0.5 * self.omega;
        let (sin, cos) = (rate * delta).sin_cos();
        // h = π/2 + ωδ/2 for the double-sided word; π + ωδ/2 for the doubled one, whose period is twice the force's.
        let (sin_h, cos_h) = match self.word {
            Word::DoubleSided => (Dual::wave(cos, sin, rate, radius), Dual::wave(-sin, cos, rate, radius)),
            Word::PeriodDoubled => (Dual::wave(-sin, cos, rate, radius), Dual::wave(-cos, -sin, rate, radius)),
        };
        [difference, slope.scaled(2.0), sum, sin_h, cos_h]
    }

    fn rows(&self, delta: f64, radius: f64) -> Rows {
        let [d, chi3, sum, sin, cos] = self.pieces(delta, radius);
        let (q, g, w) = (self.loss, self.stiffness, self.omega);
        match self.word {
            Word::DoubleSided => {
                let a = self.asymmetry;
                [
                    [
                        (d * cos).scaled(-q * g),
                        ((d * cos).scaled(w) - chi3 * sin) * sum,
                        (chi3 * sum).scaled(-1.0) - d.scaled(q * a * g),
                    ],
                    [
                        ((sin * sum).scaled(w) - (chi3 * cos).scaled(g)) * d,
                        (sin * sum).scaled(q),
                        sum.scaled(q) - (chi3 * d).scaled(a * g),
                    ],
                ]
            }
            Word::PeriodDoubled => {
                let gap = 1.0 - self.asymmetry;
                [
                    [(d * cos).scaled(q * g), (chi3 * sin - (d * cos).scaled(w)) * sum, d.scaled(-q * gap * g)],
                    [
                        ((chi3 * cos).scaled(g) - (sin * sum).scaled(w)) * d,
                        (sin * sum).scaled(-q),
                        (chi3 * d).scaled(-gap * g),
                    ],
                ]
            }
        }
    }

    /// All zeros of E on `from` … `to`, in δ.
    pub(crate) fn zeros(&self, zeros: &mut Zeros, from: f64, to: f64) {
        let half = 0.5 * self.response.period();
        let top = self.response.frequencies().last().copied().unwrap_or_default().max(self.omega);
        // A few intervals a wave of the fastest mode to begin with; halving does the rest.
        let pieces = 8 + ((to - from) * top) as usize;
        // Resolution relative to δ: towards δ = 0 solutions crowd on ever smaller scales, and E keeps its digits.
        zeros.find(self, from, to, pieces.min(4096), |delta| 64.0 * f64::EPSILON * delta.abs().max(1e-20 * half));
    }

    /// Impulses and phase at a zero δ. `None` where the two equations do not determine them.
    pub(crate) fn solution(&self, delta: f64) -> Option<TwoImpactSolution> {
        let value = |dual: &Dual| dual.function.value();
        let rows = self.rows(delta, 0.0);
        let [[a11, a12, r1], [a21, a22, r2]] = [rows[0].each_ref().map(value), rows[1].each_ref().map(value)];
        let det = a11 * a22 - a12 * a21;
        let (x, y) = (r1 * a22 - a12 * r2, a11 * r2 - r1 * a21);
        let theta = (y / det / self.force).atan2(x / det / self.force);
        self.with_phase(delta, theta)
    }

    /// Impulses for given δ and θ.
    pub(crate) fn with_phase(&self, delta: f64, theta: f64) -> Option<TwoImpactSolution> {
        let [d, _, sum, sin_h, cos_h] = self.pieces(delta, 0.0).map(|dual| dual.function.value());
        let (x, y) = (self.force * theta.cos(), self.force * theta.sin());
        let (half_sum, half_difference, static_displacement) = match self.word {
            Word::DoubleSided => {
                let rest = self.asymmetry - x * cos_h;
                ((1.0 - y * sin_h) / d, rest * self.stiffness / sum, -4.0 * rest / sum)
            }
            Word::PeriodDoubled => {
                let rest = x * cos_h + 1.0 - self.asymmetry;
                (rest * self.stiffness / sum, y * sin_h / d, 4.0 * rest / sum)
            }
        };
        let (p1, p2) = (half_sum - half_difference, half_sum + half_difference);
        let finite = p1.is_finite() && p2.is_finite() && theta.is_finite() && static_displacement.is_finite();
        finite.then_some(TwoImpactSolution { delta, p1, p2, theta, static_displacement })
    }
}

impl Enclosed for TwoImpacts<'_> {
    /// E = x² + y² − Ã²Δ², by Cramer's rule on the two rows.
    fn enclose(&self, delta: f64, radius: f64) -> Dual {
        let [[a11, a12, r1], [a21, a22, r2]] = self.rows(delta, radius);
        let det = (a11 * a22 - a12 * a21).scaled(self.force);
        let (x, y) = (r1 * a22 - a12 * r2, a11 * r2 - r1 * a21);
        x * x + y * y - det * det
    }
}
