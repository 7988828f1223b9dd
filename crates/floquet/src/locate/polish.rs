//! Multipliers to the last digits, from the matrix from impact to impact.
//!
//! Eigenvalues of a dense matrix carry the rounding of its norm; where a pair crosses the circle slowly that costs digits of
//! the parameter, and where an impact nearly grazes the norm is large enough to hide on which side of the circle a pair is.

use nalgebra::Complex;
use vibrochain_breather::{Finder, Orbit};

use crate::error::FloquetError;
use crate::map_paths::ImpactMatrix;
use crate::saltation::saltations;

type C = Complex<f64>;

/// Newton steps at most; two or three are usual.
const STEPS: usize = 8;

/// A multiplier that moves by more than this part of its distance to the next pole was not the one that was meant.
const MOST_MOVE: f64 = 1e-3;

/// Two that came this much closer to each other, relatively, are one.
const MERGED: f64 = 1e-2;

/// Step of a difference quotient, as a part of the distance to the nearest poles: error and rounding balance.
const DIFFERENCE: f64 = 1e-5;

/// The equations of an orbit that polish its multipliers.
pub(crate) struct Polisher(ImpactMatrix);

impl Polisher {
    pub(crate) fn new(orbit: &Orbit, finder: &mut Finder) -> Result<Self, FloquetError> {
        let _ = saltations(orbit)?;
        let mut matrix = ImpactMatrix::default();
        matrix.set(finder.prepared(orbit)?);
        Ok(Self(matrix))
    }

    /// The multiplier next to `start`, within `slack`; `None` where Newton's method leads elsewhere.
    pub(crate) fn polished(&mut self, start: C, slack: f64) -> Option<C> {
        let last_reach = MOST_MOVE * self.0.nearest_poles(start);
        let (mut z, mut last) = (start, f64::INFINITY);
        for _ in 0..STEPS {
            let h = DIFFERENCE * self.0.nearest_poles(z);
            let slope = (self.0.determinant(z + h)? - self.0.determinant(z - h)?) / (2.0 * h);
            let step = self.0.determinant(z)? / slope;
            let size = step.norm();
            if !size.is_finite() || (z - step - start).norm() > last_reach.max(slack) {
                return None;
            }
            if size >= 0.5 * last {
                break;
            }
            z -= step;
            last = size;
        }
        (last <= last_reach).then_some(z)
    }
}

/// Improves eigenvalues of a dense matrix that may be wrong by `slack`, and tells which. One from which Newton's method leads
/// farther, or to where another one led, stays as it is.
pub(super) fn polish(
    orbit: &Orbit,
    finder: &mut Finder,
    slack: f64,
    values: &mut [C],
) -> Result<Vec<bool>, FloquetError> {
    let mut polisher = Polisher::new(orbit, finder)?;
    let polished: Vec<Option<C>> = values.iter().map(|&value| polisher.polished(value, slack)).collect();
    let to = |i: usize| polished[i].unwrap_or(values[i]);
    let alone = |i: usize| {
        let met = |j: usize| (to(i) - to(j)).norm() <= MERGED * (values[i] - values[j]).norm();
        (0..values.len()).all(|j| j == i || !met(j))
    };
    let improved: Vec<bool> = (0..values.len()).map(|i| polished[i].is_some() && alone(i)).collect();
    for (i, value) in values.iter_mut().enumerate().filter(|(i, _)| improved[*i]) {
        *value = polished[i].unwrap_or(*value);
    }
    Ok(improved)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Analyser, Tolerance};
    use vibrochain_breather::{Family, breathers};
    use vibrochain_lattice::{Chain, Model};

    #[test]
    fn polished_multipliers_are_those_of_the_dense_matrix() {
        let cases = [
            (Family::SingleSided, 0.92, 0.7, (0.05, 0.9), 0),
            (Family::DoubleSided, 1.5, 0.4, (0.1, 0.9), 0),
            (Family::PeriodDoubled, 1.07, 0.8, (0.158, 0.25), 0),
            (Family::SingleSided, 0.95, 0.4, (0.1, 1.0), 0),
        ];
        for (family, omega, asymmetry, (amplitude, restitution), which) in cases {
            let chain = Chain::new(21, 0.2, 0.1).unwrap();
            let model = Model::forced(chain, omega, asymmetry, amplitude, restitution).unwrap();
            let orbit = &breathers(&model, family).unwrap().orbits[which];
            let mut finder = Finder::new(21);
            let mut analyser = Analyser::dense();
            analyser.stability(orbit, &mut finder, Tolerance::Rounding).unwrap();
            let mut moved = 0;
            for &value in analyser.dense.values.iter().filter(|value| value.norm() > 1e-3) {
                let mut polished = [value];
                polish(orbit, &mut finder, 0.0, &mut polished).unwrap();
                assert!((polished[0] - value).norm() < 1e-10, "{family:?} {value} {}", polished[0]);
                moved += usize::from(polished[0] != value);
            }
            assert!(moved > 15, "{moved}");
        }
    }
}
