//! Multipliers to the last digits, from the secular determinant.
//!
//! Eigenvalues of a dense matrix carry the rounding of its norm; where a pair crosses the circle slowly that costs digits of
//! the parameter, and where an impact nearly grazes the norm is large enough to hide on which side of the circle a pair is.
//! With n impacts of one mass, z is a multiplier iff
//!
//! ```text
//! D(z) = det(1 − [G_ij D_j]) = 0,     D_j = [[−(1+e), 0], [κ_j, −(1+e)]],
//! G_ij = Σ_k b_k² (R_k(τ) − R_k(τ−T)/z) / (1 − 2cos(Ω_kT)/z + 1/z²)     τ = t_i − t_j > 0, otherwise (…)/z at τ + T
//! ```
//!
//! with the flights R_k of the modes (design, sec. 4). Newton's method from the dense eigenvalue; sums over modes only.

use nalgebra::Complex;
use smallvec::SmallVec;
use vibrochain_breather::{Finder, Orbit};
use vibrochain_lattice::sine_over;

use crate::error::FloquetError;
use crate::saltation::saltations;

type C = Complex<f64>;

/// Newton steps at most; two or three are usual.
const STEPS: usize = 8;

/// A multiplier that moves by more than this part of its distance to the next pole was not the one that was meant.
const LEASH: f64 = 1e-3;

/// Two that came this much closer to each other, relatively, are one.
const MERGED: f64 = 1e-2;

/// Step of a difference quotient, as a part of the distance to the nearest pole: error and rounding balance.
const DIFFERENCE: f64 = 1e-5;

/// A mode: frequency, weight, cos ΩT.
type Mode = (f64, f64, f64);

pub(crate) struct Secular {
    modes: Vec<Mode>,
    /// Time, κ and e of the impacts.
    hits: SmallVec<[(f64, f64, f64); 2]>,
    period: f64,
}

impl Secular {
    pub(crate) fn new(orbit: &Orbit, finder: &mut Finder) -> Result<Self, FloquetError> {
        finder.motion(orbit)?;
        let response = finder.response();
        let period = orbit.period();
        let pairs = response.frequencies().iter().zip(response.weights());
        let modes = pairs.map(|(&frequency, &weight)| (frequency, weight, (frequency * period).cos())).collect();
        let hits = saltations(orbit)?.map(|hit| (hit.time, hit.kappa, hit.restitution)).collect();
        Ok(Self { modes, hits, period })
    }

    /// |1 − 2cos(ΩT)/z + 1/z²| of the nearest pair of poles: about twice the distance to a pole on the circle.
    fn distance(&self, z: C) -> f64 {
        let inverse = z.inv();
        let distances = self.modes.iter().map(|mode| (1.0 - inverse * (2.0 * mode.2) + inverse * inverse).norm());
        distances.fold(f64::INFINITY, f64::min)
    }

    /// The multiplier next to `start`, within `slack`; `None` where Newton's method leads elsewhere.
    pub(crate) fn polished(&self, start: C, slack: f64) -> Option<C> {
        let reach = self.distance(start);
        let leash = (LEASH * reach).max(slack);
        let (mut z, mut last) = (start, f64::INFINITY);
        for _ in 0..STEPS {
            let h = DIFFERENCE * self.distance(z);
            let slope = (self.determinant(z + h) - self.determinant(z - h)) / (2.0 * h);
            let step = self.determinant(z) / slope;
            let size = step.norm();
            if !size.is_finite() || (z - step - start).norm() > leash {
                return None;
            }
            if size >= 0.5 * last {
                return (last <= LEASH * reach).then_some(z);
            }
            z -= step;
            last = size;
        }
        (last <= LEASH * reach).then_some(z)
    }

    /// D(z)
    fn determinant(&self, z: C) -> C {
        let n = 2 * self.hits.len();
        let inverse = z.inv();
        let mut matrix: SmallVec<[C; 16]> = SmallVec::from_elem(C::new(0.0, 0.0), n * n);
        for (i, (time, ..)) in self.hits.iter().enumerate() {
            for (j, (other, kappa, e)) in self.hits.iter().enumerate() {
                let (tau, factor) =
                    if i > j { (time - other, C::new(1.0, 0.0)) } else { (time - other + self.period, inverse) };
                let back = tau - self.period;
                let mut g = [C::new(0.0, 0.0); 4];
                for &(f, weight, cos) in &self.modes {
                    let scale = factor * weight / (1.0 - inverse * (2.0 * cos) + inverse * inverse);
                    let flight = |t: f64| {
                        let (c, s) = ((f * t).cos(), sine_over(f, t));
                        [c, s, -f * f * s, c]
                    };
                    for (g, (there, here)) in g.iter_mut().zip(flight(tau).into_iter().zip(flight(back))) {
                        *g += scale * (there - inverse * here);
                    }
                }
                let loss = 1.0 + e;
                for (entry, g) in g.into_iter().enumerate() {
                    matrix[(2 * i + entry / 2) * n + 2 * j + entry % 2] = g * loss;
                }
                // The second column, times κ/(1+e), added to the first: there κ would multiply what cancels.
                if i == j {
                    matrix[(2 * i + 1) * n + 2 * i] += kappa / loss;
                }
            }
        }
        for i in 0..n {
            matrix[i * n + i] += 1.0;
        }
        determinant(&mut matrix, n)
    }
}

/// Gaussian elimination with exchange of rows.
fn determinant(matrix: &mut [C], n: usize) -> C {
    let mut product = C::new(1.0, 0.0);
    for column in 0..n {
        let size = |i: usize| matrix[i * n + column].norm_sqr();
        let pivot = (column..n).max_by(|&i, &j| size(i).total_cmp(&size(j))).unwrap_or(column);
        if pivot != column {
            (0..n).for_each(|j| matrix.swap(pivot * n + j, column * n + j));
            product = -product;
        }
        let head = matrix[column * n + column];
        product *= head;
        if head.norm_sqr() == 0.0 {
            return product;
        }
        for i in column + 1..n {
            let factor = matrix[i * n + column] / head;
            for j in column..n {
                let above = matrix[column * n + j];
                matrix[i * n + j] -= factor * above;
            }
        }
    }
    product
}

/// Improves eigenvalues of a dense matrix that may be wrong by `slack`, and tells which. One from which Newton's method leads
/// farther, or to where another one led, stays as it is.
pub(crate) fn polish(
    orbit: &Orbit,
    finder: &mut Finder,
    slack: f64,
    values: &mut [C],
) -> Result<Vec<bool>, FloquetError> {
    let secular = Secular::new(orbit, finder)?;
    let polished: Vec<Option<C>> = values.iter().map(|&value| secular.polished(value, slack)).collect();
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
    fn determinants_by_hand() {
        // i, 2; 3, 1 + i
        let mut matrix = [C::new(0.0, 1.0), C::new(2.0, 0.0), C::new(3.0, 0.0), C::new(1.0, 1.0)];
        assert!((determinant(&mut matrix, 2) - C::new(-7.0, 1.0)).norm() < 1e-15);
    }

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
