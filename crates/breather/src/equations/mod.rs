//! The equations of an orbit of any impact word, linearised about it.
//!
//! The unknowns (`unknowns`) are the impulses P_i, the static displacement s they hold up and, where symmetry leaves them open,
//! the times t_i but the first and the phase ψ. With K̂ the kernel between the sites n_i and n_j that are hit, less what the net
//! impulse holds up ([`ImpulseResponse::jet_between`]):
//!
//! ```text
//! position  s + Σ_j P_j K̂(t_i−t_j) + G(t_i+ψ) − (a±1) = 0          net impulse   Σ P_j − g s = 0
//! Newton    Σ_{j≠i} P_j K′(t_i−t_j) + Ġ(t_i+ψ) + qP_i/2 = 0
//! ```
//!
//! Their Jacobian J is singular at a fold or pitchfork of the family; what is left of a residual passes through its inverse (`polish`).

use smallvec::SmallVec;
use vibrochain_lattice::{ImpulseResponse, KernelJet};

use crate::equations::linear::{Matrix, Vector, zeros};
use crate::equations::slopes::Slopes;
use crate::equations::unknowns::{Unknowns, static_displacement};
use crate::orbit::{Impact, Orbit};
use crate::worse;

mod bloch;
pub(crate) mod delicate;
mod elimination;
pub mod linear;
pub(crate) mod newton;
pub(crate) mod slopes;
mod system;
pub(crate) mod unknowns;

pub use bloch::{BlochEquations, LinearImpact, ShapeErrors, Shift};
pub(crate) use system::System;

/// An orbit and what the rows of its equations are made of.
pub(crate) struct Equations<'a> {
    pub(crate) orbit: &'a Orbit,
    pub(crate) response: &'a ImpulseResponse,
    pub(crate) unknowns: Unknowns,
}

impl<'a> Equations<'a> {
    pub(crate) fn new(orbit: &'a Orbit, response: &'a ImpulseResponse) -> Self {
        Self { orbit, response, unknowns: Unknowns::of(orbit) }
    }

    fn count(&self) -> usize {
        self.unknowns.impacts
    }

    fn impact(&self, i: usize) -> &Impact {
        &self.orbit.impacts()[i]
    }

    pub(crate) fn impulse(&self, i: usize) -> f64 {
        self.impact(i).impulse
    }

    /// t_i − t_j folded into the period.
    pub(crate) fn elapsed(&self, i: usize, j: usize) -> f64 {
        let elapsed = self.impact(i).time - self.impact(j).time;
        if elapsed < 0.0 { elapsed + self.response.period() } else { elapsed }
    }

    /// K̂ at t_i − t_j between the sites of the two impacts.
    fn jet(&self, i: usize, j: usize) -> KernelJet {
        let offset = self.elapsed(i, j) - 0.5 * self.response.period();
        self.response.jet_between(self.impact(i).site, self.impact(j).site, offset)
    }

    /// Of all impacts at impact `i`, which itself has no velocity there, in the mean. (Not several at once: where a branch ends, a Jacobian that is
    /// rounded otherwise than the residuals loses half the digits of that place.)
    fn jets(&self, i: usize) -> SmallVec<[[f64; 4]; 4]> {
        let of = |j: usize| {
            let KernelJet { value, slope, curvature, third } = self.jet(i, j);
            [value, if i == j { 0.0 } else { slope }, curvature, third]
        };
        (0..self.count()).map(of).collect()
    }

    fn impulses(&self) -> SmallVec<[f64; 4]> {
        (0..self.count()).map(|i| self.impulse(i)).collect()
    }

    /// G and its first three derivatives at impact `i`.
    fn force(&self, i: usize) -> [f64; 4] {
        let impact = self.impact(i);
        self.orbit.steady().at(impact.site).jet(impact.time + self.orbit.psi_or_zero())
    }

    /// What is left of the equations.
    pub(crate) fn residuals(&self) -> Vector {
        let n = self.count();
        let mut rows = zeros(self.unknowns.size());
        for i in 0..n {
            let [(position, _), (newton, _)] = self.balance(i);
            rows[i] = position;
            if let Some(row) = self.unknowns.newton(i) {
                rows[row] = newton;
            }
        }
        let net: f64 = (0..n).map(|i| self.impulse(i)).sum();
        rows[n] = net - self.response.static_stiffness() * static_displacement(self.orbit, self.response);
        rows
    }

    /// Largest violation of position and Newton's law, where it is asked for, each over the sizes of its terms.
    pub(crate) fn worst_violation(&self) -> f64 {
        let share = |(left, size): (f64, f64)| (left / size).abs();
        (0..self.count()).fold(0.0, |worst, i| {
            let [position, newton] = self.balance(i).map(share);
            let worst = worse(worst, position);
            if self.unknowns.newton(i).is_some() { worse(worst, newton) } else { worst }
        })
    }

    /// Position and Newton's law at impact `i`: what is left, and the sum of the terms' sizes.
    fn balance(&self, i: usize) -> [(f64, f64); 2] {
        let (impact, steady, loss) = (self.impact(i), self.orbit.steady(), self.orbit.model().loss());
        let force = self.force(i);
        let still = static_displacement(self.orbit, self.response);
        let mut position = still + force[0] - self.orbit.model().barrier(impact.barrier);
        let mut newton = force[1] + 0.5 * loss * impact.impulse;
        let (mut length, mut velocity) = (steady.bound(0).max(1.0), steady.bound(1));
        let forced = velocity > 0.0;
        for j in 0..self.count() {
            let (jet, impulse) = (self.jet(i, j), self.impulse(j));
            position += impulse * jet.value;
            length += (impulse * jet.value).abs();
            if j == i {
                velocity += (0.5 * loss * impulse).abs();
            } else {
                newton += impulse * jet.slope;
                // Between sites K′ is a sum of parts as large as at one site, ½ in all, however small; without a force it may vanish at
                // one site, too, and leave no other term.
                let size = if forced && self.impact(j).site == impact.site {
                    jet.slope.abs()
                } else {
                    jet.slope.abs().max(0.5)
                };
                velocity += impulse.abs() * size;
            }
        }
        [(position, length), (newton, velocity.max(f64::MIN_POSITIVE))]
    }

    /// The Jacobian.
    pub(crate) fn jacobian(&self) -> Matrix {
        let (n, unknowns, impulses) = (self.count(), self.unknowns, self.impulses());
        let mut matrix = Matrix::zeros(unknowns.size());
        for i in 0..n {
            let (jets, load) = (self.jets(i), self.force(i));
            let slopes = Slopes { impact: i, impulses: &impulses, jets: &jets, load: &load };
            let mut add = |order, row| slopes.add(order, |j| unknowns.time(j), unknowns.psi(), matrix.row_mut(row));
            add(0, i);
            if let Some(row) = unknowns.newton(i) {
                add(1, row);
                matrix[(row, i)] = 0.5 * self.orbit.model().loss();
            }
            matrix[(i, n)] = 1.0;
        }
        matrix.row_mut(n)[..n].fill(1.0);
        matrix[(n, n)] = -self.response.static_stiffness();
        matrix
    }

    /// The linearised equations.
    pub(crate) fn system(&self) -> System {
        let largest = (0..self.count()).map(|j| self.impulse(j).abs()).fold(f64::MIN_POSITIVE, f64::max);
        System::new(self.jacobian(), &self.unknowns.units(self.orbit, self.response, largest))
    }
}

#[cfg(test)]
mod tests {
    use vibrochain_lattice::{Barrier, Chain, Spectrum};

    use super::*;
    use crate::orbit::Hit;

    /// Words of one to five impacts at any sites, not orbits at all: the Jacobian is what differences of the residuals say.
    #[test]
    fn the_jacobian_is_the_derivative_of_the_residuals() {
        let mut random = fastrand::Rng::with_seed(5);
        let mut checked = [0; 5];
        for round in 0..200 {
            let (sites, conservative) = (1 + random.usize(0..7), random.bool());
            let chain = Chain::new(sites, 0.1 + random.f64(), 0.3 * random.f64()).unwrap();
            let (omega, a) = (0.4 + 2.0 * random.f64(), 0.5 * random.f64());
            let point = chain.point().omega(omega).asymmetry(a);
            let point = match conservative {
                true => point,
                false => point.amplitude(0.1 + random.f64()).restitution(0.3 + 0.7 * random.f64()),
            };
            let (model, count) = (point.model().unwrap(), 1 + round % 5);
            let mut times: Vec<f64> = (0..count).map(|_| model.period() * random.f64()).collect();
            times[0] = 0.0;
            times.sort_by(f64::total_cmp);
            let psi = if conservative { 0.0 } else { 0.3 };
            let hits: Vec<_> = (times.iter().enumerate())
                .map(|(i, &time)| {
                    let barrier = if random.bool() { Barrier::Upper } else { Barrier::Lower };
                    Hit::new((i * 3 + round) % sites, barrier, time, random.f64() - 0.5)
                })
                .collect();
            let Ok(response) = ImpulseResponse::new(&Spectrum::new(chain), model.omega()) else { continue };
            let Ok(orbit) = Orbit::from_impulses(&model, 1, psi, &hits) else { continue };
            let equations = Equations::new(&orbit, &response);
            let (unknowns, jacobian) = (equations.unknowns, equations.jacobian());
            let (x, word) = (unknowns.read(&orbit, &response), crate::equations::unknowns::Template::of(&orbit));
            let residuals = |x: &[f64]| {
                let draft = word.draft(&unknowns, x, &model, &response).unwrap();
                let mut motion = crate::motion::Motion::vacant(&chain, response.shapes().clone());
                let moved = Orbit::assemble(&model, &response, &mut motion, draft).unwrap();
                Equations { unknowns, ..Equations::new(&moved, &response) }.residuals()
            };
            let h = 1e-6;
            let size = 1.0 + response.derivative_bounds()[2];
            for j in 0..unknowns.size() {
                let moved = |step: f64| {
                    let mut x = x.clone();
                    x[j] += step;
                    residuals(&x)
                };
                let (plus, minus) = (moved(h), moved(-h));
                for i in 0..unknowns.size() {
                    let slope = (plus[i] - minus[i]) / (2.0 * h);
                    assert!((slope - jacobian[(i, j)]).abs() < 1e-6 * size, "{i} {j}: {slope} {}", jacobian[(i, j)]);
                }
            }
            checked[count - 1] += 1;
        }
        assert!(checked.iter().all(|count| *count > 20), "{checked:?}");
    }
}
