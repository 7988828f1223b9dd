//! From eigenvalues to a verdict that knows its own error.
//!
//! Where impacts are elastic, structure says more than moduli do: a multiplier comes with 1/μ̄, so that a simple one next
//! to the circle lies on it exactly. Only two that are closer than their errors reach, or one next to ±1, leave a doubt.
//! For reversible orbits the same holds of the real ν = ½(μ + 1/μ) in [−1, 1].

use nalgebra::Complex;
use vibrochain_breather::{Finder, Orbit};

use crate::error::FloquetError;
use crate::reference::certainty::{eigenvalue_condition, relative_uncertainty};
use crate::reference::dense::{Dense, uncoupled};
use crate::verdict::{Question, Tolerance, Verdict};
use crate::zeros::Nu;

/// Multiplications that doubtful eigenvalues of one orbit may cost, each the cube of the dimension; what is beyond them is
/// judged by the bound that needs no eigenvector. A second: the two decompositions for an eigenvalue of a matrix of 1000 took 1.0 s, and
/// ten times the budget is ten such eigenvalues for an orbit, where a map has thousands of orbits.
const BUDGET: f64 = 1e9;

/// What keeps multipliers on the circle.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Structure {
    /// Eigenvalues are ν, real in [−1, 1] for the circle.
    Reversible,
    /// Eigenvalues are μ, in pairs μ, 1/μ̄.
    Symplectic,
    /// Eigenvalues are μ, impacts dissipate.
    Dissipative,
}

impl Structure {
    fn of(orbit: &Orbit) -> Self {
        if orbit.is_reversible() {
            Self::Reversible
        } else if orbit.model().loss() == 0.0 {
            Self::Symplectic
        } else {
            Self::Dissipative
        }
    }

    /// The multiplier of larger modulus that belongs to an eigenvalue.
    fn multiplier(self, value: Complex<f64>) -> Complex<f64> {
        if self == Self::Reversible { Nu::of(value).multipliers()[0] } else { value }
    }

    /// How far the modulus of the multiplier moves when the eigenvalue moves by `reach`.
    fn excess_error(self, value: Complex<f64>, reach: f64) -> f64 {
        if self != Self::Reversible {
            return reach;
        }
        let nu = Nu::of(value);
        nu.excess_error(nu.excess(), reach)
    }

    /// How far an eigenvalue that looks stable is from becoming unstable, in its own plane.
    fn distance(self, values: &[Complex<f64>], i: usize) -> f64 {
        let value = values[i];
        let gap = values.iter().enumerate().filter(|(j, _)| *j != i).map(|(_, other)| (other - value).norm());
        let half_gap = 0.5 * gap.fold(f64::INFINITY, f64::min);
        match self {
            Self::Reversible if value.im == 0.0 => half_gap.min(1.0 - value.re.abs()).max(0.0),
            Self::Reversible => 0.0,
            _ => half_gap,
        }
    }

    /// How far an eigenvalue that looks unstable is from the circle, in its own plane.
    fn excess(self, value: Complex<f64>) -> f64 {
        match self {
            Self::Reversible => value.im.abs().max(value.re.abs() - 1.0),
            _ => (value.norm() - 1.0).abs(),
        }
    }

    /// Next to the circle, and next to another eigenvalue or to where multipliers leave it.
    fn is_doubtful(self, values: &[Complex<f64>], i: usize, window: f64) -> bool {
        let near = self == Self::Reversible || (values[i].norm() - 1.0).abs() < window;
        near && self.distance(values, i) < window
    }
}

/// The spectrum of one orbit and how well it is known.
struct Judge<'a> {
    dense: &'a Dense,
    structure: Structure,
    /// Norm of the matrix.
    norm: f64,
    /// By how much, in norm, the matrix may be off.
    error: f64,
}

impl Dense {
    /// The verdict.
    pub(crate) fn judge(&mut self, question: Question<'_>, finder: &mut Finder) -> Result<Verdict, FloquetError> {
        let Question { orbit, tolerance, thorough } = question;
        let norm = self.solve(orbit, finder)?;
        let dimension = self.values.len();
        let mut error = dimension as f64 * f64::EPSILON * norm;
        let careful = thorough || finder.is_delicate(orbit)?;
        if careful {
            let condition = finder.condition(orbit)?;
            let response = finder.prepared(orbit)?.response();
            let top = response.frequencies().last().copied().unwrap_or_default().max(orbit.model().omega());
            // Of a mass alone, 5e-9 from its resonance, an error was found to be 3 % larger than the sum that claims it.
            let margin = if uncoupled(orbit) { 2.0 } else { 1.0 };
            let orbital = margin * norm * relative_uncertainty(orbit, &condition, dimension, top);
            error = if orbital.is_nan() { f64::INFINITY } else { error.max(orbital) };
        }
        let judge = Judge { dense: self, structure: Structure::of(orbit), norm, error };
        Ok(judge.verdict(tolerance, careful))
    }
}

impl Judge<'_> {
    fn values(&self) -> &[Complex<f64>] {
        &self.dense.values
    }

    fn verdict(&self, tolerance: Tolerance, careful: bool) -> Verdict {
        let moduli = self.values().iter().map(|&value| (value, self.structure.multiplier(value)));
        let Some((value, leading)) = moduli.max_by(|a, b| a.1.norm_sqr().total_cmp(&b.1.norm_sqr())) else {
            return Verdict::on_circle(None);
        };
        let excess = leading.norm() - 1.0;
        // How far errors carry two eigenvalues that meet, with room.
        let window = 4.0 * self.split();
        if self.structure != Structure::Dissipative && excess <= window {
            return self.on_circle_or(tolerance, window, leading);
        }
        if !careful && (excess - tolerance.allowed()).abs() > window {
            return Verdict::of(leading, self.structure.excess_error(value, self.error), tolerance);
        }
        // Every multiplier that could decide, the leading one first.
        let mut verdict = Verdict::of(leading, self.excess_error(value, 0), tolerance);
        let border = tolerance.allowed() - window;
        let mut number = 1;
        for &other in self.values() {
            let multiplier = self.structure.multiplier(other);
            if other != value && verdict.stable && multiplier.norm() - 1.0 > border {
                let resolution = self.excess_error(other, number);
                if Verdict::of(multiplier, resolution, tolerance).undecided {
                    (verdict.stable, verdict.undecided) = (false, true);
                    verdict.resolution = verdict.resolution.max(resolution);
                }
                number += 1;
            }
        }
        verdict
    }

    /// How far a perturbation of the matrix can carry two eigenvalues that meet: the root of it, in units of the matrix.
    fn split(&self) -> f64 {
        (self.norm * self.error).sqrt()
    }

    /// How far errors carry an eigenvalue: by its condition, and no farther than two that meet. `number` counts those asked
    /// for.
    fn reach(&self, value: Complex<f64>, number: usize) -> f64 {
        let cost = (self.values().len() as f64).powi(3) * (number + 1) as f64;
        let condition = if cost <= BUDGET { eigenvalue_condition(&self.dense.matrix, value) } else { f64::INFINITY };
        let linear = self.error * condition;
        if linear < self.split() { linear } else { self.split() }
    }

    fn excess_error(&self, value: Complex<f64>, number: usize) -> f64 {
        self.structure.excess_error(value, self.reach(value, number))
    }

    /// Elastic, and no multiplier is farther from the circle than errors carry: on it by structure, unless one next to
    /// another or to ±1 may have left it.
    fn on_circle_or(&self, tolerance: Tolerance, window: f64, leading: Complex<f64>) -> Verdict {
        let values = self.values();
        let doubts = (0..values.len()).filter(|&i| self.structure.is_doubtful(values, i, window));
        let mut unsettled: Option<(Complex<f64>, f64)> = None;
        let mut unstable: Option<(Complex<f64>, f64)> = None;
        let larger = |old: &Option<(Complex<f64>, f64)>, new: Complex<f64>| {
            old.is_none_or(|(old, _)| new.norm_sqr() > old.norm_sqr())
        };
        for (number, i) in doubts.enumerate() {
            let value = values[i];
            let reach = self.reach(value, number);
            let multiplier = self.structure.multiplier(value);
            let off = multiplier.norm() - 1.0 > 4.0 * f64::EPSILON;
            if off && self.structure.excess(value) > reach {
                if larger(&unstable, multiplier) {
                    unstable = Some((multiplier, self.structure.excess_error(value, reach)));
                }
            } else if reach.is_nan() || reach >= self.structure.distance(values, i) {
                // A pair that may have met.
                let error = self.structure.excess_error(value, self.split()).max((multiplier.norm() - 1.0).abs());
                let error = unsettled.map_or(error, |(_, old)| error.max(old));
                let multiplier =
                    unsettled.map_or(
                        multiplier,
                        |(old, _)| {
                            if multiplier.norm_sqr() > old.norm_sqr() { multiplier } else { old }
                        },
                    );
                unsettled = Some((multiplier, error));
            }
        }
        match (unstable, unsettled) {
            (Some((leading, resolution)), _) => Verdict::of(leading, resolution, tolerance),
            (None, Some((leading, resolution))) => {
                Verdict::unsettled(leading, leading.norm() - 1.0, resolution, tolerance)
            }
            (None, None) => Verdict::on_circle(Some(leading)),
        }
    }
}
