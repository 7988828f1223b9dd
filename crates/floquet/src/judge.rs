//! From eigenvalues to a verdict that knows its own error.
//!
//! Where impacts are elastic, structure says more than moduli do: a multiplier comes with 1/μ̄, so that a simple one next
//! to the circle lies on it exactly. Only two that are closer than their errors reach, or one next to ±1, leave a doubt.
//! For reversible orbits the same holds of the real ν = ½(μ + 1/μ) in [−1, 1].

use nalgebra::Complex;
use vibrochain_breather::{Finder, Orbit};

use crate::analyser::Analyser;
use crate::certainty::{eigenvalue_condition, relative_uncertainty};
use crate::error::FloquetError;
use crate::multipliers::pair;
use crate::verdict::{Tolerance, Verdict};

/// More doubtful eigenvalues than this are not looked at one by one: the verdict is marginal.
const MOST_DOUBTS: usize = 12;

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
        if self == Self::Reversible { pair(value)[0] } else { value }
    }

    /// How far the modulus of the multiplier moves when the eigenvalue moves by `reach`.
    fn growth_error(self, value: Complex<f64>, reach: f64) -> f64 {
        if self != Self::Reversible {
            return reach;
        }
        // dμ/dν = μ/√(ν²−1), and the square root itself where ν comes within reach of ±1.
        let root = ((value - 1.0) * (value + 1.0)).norm().sqrt();
        self.multiplier(value).norm() * if root * root > 2.0 * reach { reach / root } else { (2.0 * reach).sqrt() }
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
}

impl Analyser {
    /// The verdict; `thorough` asks for the error of the leading multiplier even where the verdict does not hang on it.
    pub(crate) fn judge(
        &mut self,
        orbit: &Orbit,
        finder: &mut Finder,
        tolerance: Tolerance,
        thorough: bool,
    ) -> Result<Verdict, FloquetError> {
        let norm = self.solve(orbit, finder)?;
        let structure = Structure::of(orbit);
        let moduli = self.values.iter().map(|&value| (value, structure.multiplier(value)));
        let Some((value, leading)) = moduli.max_by(|a, b| a.1.norm_sqr().total_cmp(&b.1.norm_sqr())) else {
            return Ok(Verdict::on_circle(None));
        };
        let rounding = self.values.len() as f64 * f64::EPSILON * norm;
        let excess = leading.norm() - 1.0 - tolerance.allowed();
        let window = 4.0 * rounding.sqrt();
        let elastic = structure != Structure::Dissipative;
        let doubtful = excess.abs() <= window;
        if elastic && doubtful && !(0..self.values.len()).any(|i| self.is_doubtful(structure, i, window)) {
            return Ok(Verdict::on_circle(Some(leading)));
        }
        if !thorough && !doubtful {
            return Ok(Verdict::of(leading, structure.growth_error(value, rounding), tolerance));
        }
        let condition = finder.condition(orbit)?;
        let response = finder.response();
        let top = response.frequencies().last().copied().unwrap_or_default().max(orbit.model().omega());
        let error = norm * relative_uncertainty(orbit, &condition, self.values.len(), top);
        let reach = |analyser: &Self, value| error * eigenvalue_condition(analyser.matrix_of(orbit), value);
        if !(elastic && doubtful) {
            return Ok(Verdict::of(leading, structure.growth_error(value, reach(self, value)), tolerance));
        }
        self.settle(structure, window, error, tolerance, orbit)
    }

    /// Elastic, and some eigenvalue is next to another or to ±1: each such one by its own condition.
    fn settle(
        &self,
        structure: Structure,
        window: f64,
        error: f64,
        tolerance: Tolerance,
        orbit: &Orbit,
    ) -> Result<Verdict, FloquetError> {
        let doubts: Vec<usize> = (0..self.values.len()).filter(|&i| self.is_doubtful(structure, i, window)).collect();
        let mut worst: Option<Complex<f64>> = None;
        let mut unsettled = 0.0_f64;
        let mut unstable: Option<(Complex<f64>, f64)> = None;
        for (number, &i) in doubts.iter().enumerate() {
            let value = self.values[i];
            let condition =
                if number < MOST_DOUBTS { eigenvalue_condition(self.matrix_of(orbit), value) } else { f64::INFINITY };
            let reach = error * condition;
            let multiplier = structure.multiplier(value);
            let on_circle = multiplier.norm() - 1.0 <= 4.0 * f64::EPSILON;
            if !on_circle && structure.excess(value) > reach {
                let larger = unstable.is_none_or(|(old, _)| multiplier.norm_sqr() > old.norm_sqr());
                if larger {
                    unstable = Some((multiplier, structure.growth_error(value, reach)));
                }
            } else if reach.is_nan() || reach >= structure.distance(&self.values, i) {
                // A pair that may have met is off the circle by at most the root of what rounding can do.
                unsettled = unsettled.max(error.sqrt()).max(structure.growth_error(value, error));
                if worst.is_none_or(|old| multiplier.norm_sqr() > old.norm_sqr()) {
                    worst = Some(multiplier);
                }
            }
        }
        Ok(match (unstable, worst) {
            (Some((leading, resolution)), _) => Verdict::of(leading, resolution, tolerance),
            (None, Some(leading)) => {
                let spectral_radius = leading.norm();
                let resolution = unsettled.max((spectral_radius - 1.0).abs());
                let stable = spectral_radius - 1.0 + resolution < tolerance.allowed();
                Verdict { stable, marginal: !stable, mechanism: None, spectral_radius, leading, resolution }
            }
            (None, None) => {
                let leading = self.values.iter().map(|&value| structure.multiplier(value));
                Verdict::on_circle(leading.max_by(|a, b| a.norm_sqr().total_cmp(&b.norm_sqr())))
            }
        })
    }

    /// Next to the circle, and next to another eigenvalue or to where multipliers leave it.
    fn is_doubtful(&self, structure: Structure, i: usize, window: f64) -> bool {
        let value = self.values[i];
        match structure {
            Structure::Reversible => structure.distance(&self.values, i) < window,
            _ => (value.norm() - 1.0).abs() < window && structure.distance(&self.values, i) < window,
        }
    }
}
