//! From eigenvalues to a verdict that knows its own error.
//!
//! Eigenvalues are zeros as `spectrum` has them, and judged alike. Next to others, to where multipliers leave the circle or to the tolerance
//! they have errors by their condition; elsewhere that of the matrix is as good.

use nalgebra::Complex;
use vibrochain_breather::Finder;

use crate::error::FloquetError;
use crate::reference::certainty::{eigenvalue_condition, relative_uncertainty};
use crate::reference::dense::{Dense, uncoupled};
use crate::spectrum::{Zero, judged};
use crate::verdict::{Question, Verdict};
use crate::zeros::{Nu, excess};

/// Multiplications that doubtful eigenvalues of one orbit may cost, each the cube of the dimension; what is beyond them is
/// judged by the bound that needs no eigenvector. A second: the two decompositions for an eigenvalue of a matrix of 1000 took 1.0 s, and
/// ten times the budget is ten such eigenvalues for an orbit, where a map has thousands of orbits.
const BUDGET: f64 = 1e9;

impl Dense {
    /// The verdict.
    pub(crate) fn judge(&mut self, question: Question<'_>, finder: &mut Finder) -> Result<Verdict, FloquetError> {
        let Question { orbit, tolerance, thorough } = question;
        let norm = self.solve(orbit, finder)?;
        let dimension = self.values.len();
        let mut error = dimension as f64 * f64::EPSILON * norm;
        let careful = thorough || finder.is_delicate(&orbit)?;
        if careful {
            let condition = finder.condition(&orbit)?;
            let response = finder.prepared(orbit.orbit())?.response();
            let top = response.frequencies().last().copied().unwrap_or_default().max(orbit.model().omega());
            // Of a mass alone, 5e-9 from its resonance, an error was found to be 3 % larger than the sum that claims it.
            let margin = if uncoupled(orbit) { 2.0 } else { 1.0 };
            let orbital = margin * norm * relative_uncertainty(orbit, &condition, dimension, top);
            error = if orbital.is_nan() { f64::INFINITY } else { error.max(orbital) };
        }
        let (half_sums, reciprocal) = (orbit.is_reversible(), orbit.model().loss() == 0.0);
        // How far errors carry two eigenvalues that meet, and the same with room.
        let split = (norm * error).sqrt();
        let window = 4.0 * split;
        let excess = |value: Complex<f64>| if half_sums { Nu::of(value).excess() } else { excess(value) };
        let most = self.values.iter().map(|value| excess(*value)).fold(f64::NEG_INFINITY, f64::max);
        // How far an eigenvalue is from another, and that of ν from where its multipliers leave the circle.
        let room = |i: usize| {
            let value = self.values[i];
            let others = self.values.iter().enumerate().filter(|(j, _)| *j != i);
            let half_gap =
                0.5 * others.map(|(_, other)| (other - value).norm_sqr()).fold(f64::INFINITY, f64::min).sqrt();
            let to_ends = if value.im == 0.0 { (1.0 - value.re.abs()).max(0.0) } else { 0.0 };
            if half_sums { half_gap.min(to_ends) } else { half_gap }
        };
        let (mut asked, mut zeros) = (0, Vec::with_capacity(dimension));
        for (i, &value) in self.values.iter().enumerate() {
            let z = if half_sums { Nu::of(value).multipliers()[0] } else { value };
            // Of a pair of multipliers one is enough.
            if reciprocal && !half_sums && (z.im < 0.0 || z.im == 0.0 && z.re.abs() < 1.0) {
                continue;
            }
            let excess = excess(value);
            // Where one is surely outside, those next to the circle decide nothing.
            let may_have_left = reciprocal && most <= window && (half_sums || excess.abs() < window);
            let room = if may_have_left { room(i) } else { f64::INFINITY };
            let doubtful = room < window;
            let decides = (excess - tolerance.allowed()).abs() <= window || careful && excess == most;
            let reach = if doubtful || decides && (excess > window || !reciprocal) {
                asked += 1;
                let cost = (dimension as f64).powi(3) * f64::from(asked);
                let condition = if cost <= BUDGET { eigenvalue_condition(&self.matrix, value) } else { f64::INFINITY };
                split.min(error * condition)
            } else {
                error
            };
            let settled = !doubtful || reach < room;
            // Two that may have met.
            let outside = if half_sums { value.im.abs().max(value.re.abs() - 1.0) } else { excess };
            let reach = if settled || outside > reach { reach } else { split };
            zeros.push(match (reciprocal, half_sums) {
                (true, true) => Zero { nu: Nu::of(value), error: reach, ..Zero::new(z, settled) },
                (true, false) => Zero::of_pair(z, [reach; 2], settled),
                (false, _) => Zero { error: reach, ..Zero::new(z, settled) },
            });
        }
        Ok(judged(&zeros, reciprocal, tolerance, &mut Vec::new()))
    }
}
