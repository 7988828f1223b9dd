//! Half-sums ν = ½(μ + 1/μ) of an orbit without loads and losses that is its own mirror image in time, with impacts at several contacts.
//!
//! Impacts are at 0 and half a period later. The reversal of time Q = R·S₀, S₀ the saltations at 0 and R the sign of all velocities, turns the
//! monodromy M, begun just before 0, into M⁻¹. N = ½(M + M⁻¹) keeps the space Qx = x, on which N x = ½(1 + Q)M x. Of modes q with φᵀMφ = 1 its
//! coordinates are the velocities along the shapes of the contacts that are hit at 0, which are orthogonal where these contacts feel nothing of each
//! other at once, and displacements across them. Each pair of multipliers is one eigenvalue of N; the orbit's own flow f is a left eigenvector of
//! ν = 1 as ω(f, x), ω the canonical form that M keeps.

use nalgebra::{Complex, DMatrix, DVector};
use vibrochain_breather::{BlochEquations, ContactOrbit, LinearImpact};
use vibrochain_lattice::BlochMode;

use super::by_matrix::{State, fly, strike};
use crate::reference::eigen::eigenvalues;
use crate::reference::reflector::Reflector;

/// Instants are 0 or half a period where they miss it by no more than this part of the period.
const HALF: f64 = 1e-13;

/// What two contacts feel of each other at once, squared and relative, is rounding of the modes below this.
const APART: f64 = 1e-24;

/// An orbit's linearised equations, with its impacts at 0 and half a period later.
struct Mirrored<'a> {
    equations: &'a BlochEquations,
    first: Vec<LinearImpact>,
    second: Vec<LinearImpact>,
}

/// The ν of the modes that an orbit's impacts feel, without that of its own shift in time; `None` where it is no mirror image of itself in time, or
/// contacts that are hit at one instant feel each other then.
pub(crate) fn half_sums(orbit: &ContactOrbit) -> Option<Vec<Complex<f64>>> {
    if !orbit.is_conservative() || orbit.impacts().len() < 2 {
        return None;
    }
    let (equations, _) = orbit.bloch_equations();
    let mirrored = Mirrored::of(&equations)?;
    let left = mirrored.flow()?;
    let matrix = Reflector::of(left.as_slice()).deflated(mirrored.matrix());
    let mut values = Vec::with_capacity(matrix.nrows());
    eigenvalues(&matrix, &mut values).ok()?;
    Some(values)
}

impl<'a> Mirrored<'a> {
    fn of(equations: &'a BlochEquations) -> Option<Self> {
        let (kernel, impacts) = (equations.kernel(), equations.impacts());
        let near = |time: f64, place: f64| (time - place).abs() <= HALF * kernel.period();
        let at = |place: f64| impacts.iter().filter(|one| near(one.time, place)).cloned().collect::<Vec<_>>();
        let (first, second) = (at(0.0), at(0.5 * kernel.period()));
        let apart = |one: &LinearImpact, other: &LinearImpact| {
            let mobility = |a: &LinearImpact, b: &LinearImpact| kernel.mobility(a.contact, b.contact);
            mobility(one, other).powi(2) <= APART * mobility(one, one) * mobility(other, other)
        };
        let are_apart = |list: &[LinearImpact]| (0..list.len()).all(|i| (0..i).all(|j| apart(&list[i], &list[j])));
        let swings = |mode: &BlochMode| mode.coordinates.are_circular() || mode.coordinates.are_parabolic();
        let is_real = |k: usize| {
            let mut contacts = impacts.iter().map(|impact| impact.contact);
            contacts.all(|contact| kernel.row(k, contact)[1] == 0.0 && kernel.column(k, contact)[0] == 0.0)
        };
        let modes = || kernel.modes().iter().enumerate();
        let real = modes().all(|(k, mode)| mode.decay == 0.0 && swings(mode) && is_real(k));
        let all = first.len() + second.len() == impacts.len() && !first.is_empty();
        (all && real && are_apart(&first) && are_apart(&second)).then_some(Self { equations, first, second })
    }

    /// What contact `c` sees of the displacement of each mode.
    fn shape(&self, contact: usize) -> DVector<f64> {
        let kernel = self.equations.kernel();
        DVector::from_fn(kernel.modes().len(), |k, _| kernel.row(k, contact)[0])
    }

    /// Orthonormal directions of displacements: along the contacts that are hit at 0 first.
    fn directions(&self) -> DMatrix<f64> {
        let (count, modes) = (self.first.len(), self.equations.kernel().modes().len());
        let mut all = DMatrix::from_fn(modes, count + modes, |k, place| f64::from(u8::from(count + k == place)));
        for (place, impact) in self.first.iter().enumerate() {
            all.set_column(place, &self.shape(impact.contact));
        }
        all.qr().q()
    }

    /// The rate of each mode, by which its second coordinate is its velocity.
    fn rates(&self) -> Vec<f64> {
        self.equations.kernel().modes().iter().map(|mode| mode.rate).collect()
    }

    /// What M makes of a state.
    fn after_a_period(&self, state: &mut State) {
        for instant in [&self.first, &self.second] {
            instant.iter().for_each(|impact| strike(self.equations, impact, state));
            fly(self.equations, state, 0.5 * self.equations.kernel().period());
        }
    }

    /// N on its space, velocities in units of the orbit's frequency.
    fn matrix(&self) -> DMatrix<f64> {
        let (directions, rates) = (self.directions(), self.rates());
        let (size, hit, omega) = (rates.len(), self.first.len(), self.omega());
        let place = |direction: usize, k: usize| directions[(k, direction)];
        // Of a displacement along a contact's shape its impact makes velocity.
        let kick = |c: usize| {
            let mut state: State = (0..size).map(|k| [place(c, k), 0.0]).collect();
            strike(self.equations, &self.first[c], &mut state);
            (0..size).map(|k| state[k][1] * rates[k] * place(c, k)).sum::<f64>()
        };
        let kicks: Vec<f64> = (0..hit).map(kick).collect();
        let mut matrix = DMatrix::zeros(size, size);
        for j in 0..size {
            let start = |k: usize| if j < hit { [0.0, omega * place(j, k) / rates[k]] } else { [place(j, k), 0.0] };
            let mut state: State = (0..size).map(start).collect();
            self.after_a_period(&mut state);
            for i in 0..size {
                let [along, speed] = state
                    .iter()
                    .enumerate()
                    .fold([0.0; 2], |[q, v], (k, own)| [q + place(i, k) * own[0], v + place(i, k) * own[1] * rates[k]]);
                matrix[(i, j)] = if i < hit { (speed - 0.5 * kicks[i] * along) / omega } else { along };
            }
        }
        matrix
    }

    fn omega(&self) -> f64 {
        std::f64::consts::TAU / self.equations.kernel().period()
    }

    /// ω(f, x) for each direction, f the orbit's flow just before 0; `None` at a resonance.
    fn flow(&self) -> Option<DVector<f64>> {
        let (kernel, directions, omega) = (self.equations.kernel(), self.directions(), self.omega());
        let period = kernel.period();
        let (mut velocities, mut accelerations) = (Vec::new(), Vec::new());
        for (k, mode) in kernel.modes().iter().enumerate() {
            // Impacts at 0 act a period before.
            let own = self.equations.impacts().iter().fold([0.0; 2], |[x, y], impact| {
                let column = kernel.column(k, impact.contact).map(|entry| entry * impact.impulse);
                let [dx, dy] = mode.coordinates.given(mode.flight(period - impact.time), column);
                [x + dx, y + dy]
            });
            let state = repeating(mode, own)?;
            let [_, pulled] = mode.coordinates.given(mode.generator(), state);
            velocities.push(state[1] * mode.rate);
            accelerations.push(pulled * mode.rate);
        }
        let along = |list: &[f64], i: usize| list.iter().enumerate().map(|(k, x)| directions[(k, i)] * x).sum::<f64>();
        let of = |i: usize| {
            if i < self.first.len() { omega * along(&velocities, i) } else { -along(&accelerations, i) }
        };
        Some(DVector::from_fn(velocities.len(), |i, _| of(i)))
    }
}

/// The state of a mode that is the same a period later, after this has been added; `None` at a resonance. Where nothing holds a mode it may stand
/// anywhere.
fn repeating(mode: &BlochMode, [x, y]: [f64; 2]) -> Option<[f64; 2]> {
    let moved = |state: [f64; 2]| mode.coordinates.given(mode.period, state);
    let ([a, c], [b, d]) = (moved([1.0, 0.0]), moved([0.0, 1.0]));
    if mode.coordinates.are_parabolic() {
        return Some([0.0, -x / b]);
    }
    let (a, d) = (1.0 - a, 1.0 - d);
    let determinant = a.mul_add(d, -(b * c));
    (determinant != 0.0).then(|| [(d * x + b * y) / determinant, (c * x + a * y) / determinant])
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use vibrochain_breather::LoadedStructure;
    use vibrochain_lattice::{Contact, Structure};
    use vibrochain_testkit::Random;

    use super::*;
    use crate::events::half_sums::half_sums as of_multipliers;
    use crate::structures::participating_multipliers;
    use crate::verdict::Tolerance;

    /// Springs between all of some masses, with contacts at two of them.
    fn structure(random: &mut Random) -> Structure {
        let n = 2 + random.below(6);
        let root = DMatrix::from_fn(n, n, |_, _| random.between(-1.0, 1.0));
        let masses = DVector::from_fn(n, |_, _| random.log(0.3, 3.0));
        let contact = |site: usize, random: &mut Random| {
            let stops = [random.log(0.3, 3.0), random.log(0.3, 3.0)];
            let contact = Contact { lower: Some(-stops[0]), upper: Some(stops[1]), restitution: 1.0 };
            (DVector::from_fn(n, |i, _| f64::from(u8::from(i == site))), contact)
        };
        let contacts = vec![contact(0, random), contact(1, random)];
        let stiffness = &root * root.transpose() + DMatrix::identity(n, n) * 0.05;
        Structure { mass: DMatrix::from_diagonal(&masses), stiffness, contacts, ..Structure::default() }
    }

    /// What a matrix of half the size says is what the equations say, whose zeros are found by another way.
    #[test]
    fn a_matrix_of_half_the_size_says_what_the_equations_say() {
        let mut random = Random(47);
        let (mut orbits, mut all, mut off_circle) = (0, 0, 0);
        for _ in 0..150 {
            let modal = structure(&mut random).modal().unwrap();
            let model = LoadedStructure::new(Arc::new(modal), random.log(0.3, 3.0)).unwrap();
            for word in ["0+1+", "0+1-,0-1+", "0+,1+", "0+1+,0-", "0+,0-"] {
                let Ok(found) = model.orbits(&word.parse().unwrap(), 1) else { continue };
                for orbit in found.orbits.iter().filter_map(vibrochain_breather::Orbit::contacts) {
                    let Some(values) = half_sums(orbit) else { continue };
                    let Ok((multipliers, _)) = participating_multipliers(orbit, Tolerance::Rounding) else { continue };
                    let mut right = of_multipliers(&multipliers);
                    assert_eq!(values.len(), right.len(), "{word}");
                    orbits += 1;
                    for nu in values {
                        let off = |other: &Complex<f64>| (other - nu).norm();
                        let nearest = (0..right.len()).min_by(|&i, &j| off(&right[i]).total_cmp(&off(&right[j])));
                        let apart = off(&right.swap_remove(nearest.unwrap()));
                        // Pairs that nearly meet are known to the root of rounding.
                        assert!(apart < 1e-6 * (1.0 + nu.norm()), "{word}: {nu} {apart:e}");
                        all += usize::from(apart < 1e-10 * (1.0 + nu.norm()));
                        off_circle += usize::from(nu.im != 0.0 || nu.re.abs() > 1.0);
                    }
                }
            }
        }
        assert!(orbits > 100 && all > 400 && off_circle > 50, "{orbits} {all} {off_circle}");
    }
}
