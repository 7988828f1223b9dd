//! Floquet multipliers in many digits, from the secular determinant of an orbit with all impacts at one site of any lattice.
//!
//! With ν = ½(z+1/z) and c_k = cos Ω_kT, roots are sought of det(z−M) = D(z) Π 2z(ν−c_k), which has no poles. Modes with their pole next to the root keep their two
//! coordinates in the determinant instead of being summed, so that nothing cancels there. Where M is symplectic (e = 1),
//! D depends on z through ν alone and ν is solved for: reciprocal pairs, the trivial one among them, are then simple roots.

mod roots;

use vibrochain_breather::Orbit;

use crate::complex::{Complex, shifted};
use crate::error::TruthError;
use crate::flight::Flight;
use crate::kernel::Kernel;
use crate::orbit::{TrueImpact, TrueOrbit, undamped};
use crate::real::Real;
use crate::root::difference;

/// |ν − c| below which a mode is kept out of the sums, and how many are at most.
const NEAR_POLE: f64 = 1e-6;
const MAX_EXPLICIT: usize = 6;

/// All even modes of one frequency (more than one only if they agree in all digits).
#[derive(Debug, Clone)]
pub(crate) struct Pole {
    mode: usize,
    multiplicity: usize,
    pub(crate) weight: Real,
    frequency: Real,
    /// cos ΩT
    pub(crate) cos: Real,
}

/// The secular determinant of an orbit, ready to be evaluated in O(modes · impacts²).
///
/// ```
/// use vibrochain_breather::{Family, breathers};
/// use vibrochain_lattice::{Chain, Model};
/// use vibrochain_truth::{DEFAULT_BITS, TrueOrbit, TrueSpectrum};
/// let model = Model::conservative(Chain::new(21, 0.2, 0.1)?, 0.8, 0.4)?;
/// let orbit = &breathers(&model, Family::SingleSided)?.orbits[0];
/// let spectrum = TrueSpectrum::new(&TrueOrbit::refine(orbit, DEFAULT_BITS)?)?;
/// let (leading, moved) = spectrum.refine((2.797574412183362, 0.0))?;
/// assert!((leading.re - 2.797574412183362).log10_abs() < -12.0 && moved < 1e-12);
/// // The trivial pair, which dense solvers split by 1e-8.
/// let (trivial, _) = spectrum.refine((1.0, 1e-8))?;
/// assert!((trivial.re - 1.0).log10_abs() < -57.0);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone)]
pub struct TrueSpectrum {
    bits: usize,
    pub(crate) work: usize,
    /// M is symplectic: ν is the variable.
    symplectic: bool,
    pub(crate) restitution: Real,
    pub(crate) kappas: Vec<Real>,
    pub(crate) poles: Vec<Pole>,
    /// [i][j][pole] over τ_ij, t_i − t_j brought to 0 < τ ≤ T.
    pub(crate) flights: Vec<Vec<Vec<Flight>>>,
}

/// Coefficient of restitution, and times of impacts with the entries (velocity, displacement) of their saltations.
fn saltations<'a>(orbit: &TrueOrbit, impacts: impl IntoIterator<Item = &'a TrueImpact>) -> (Real, Vec<(Real, Real)>) {
    let restitution = Real::new(orbit.model().restitution(), orbit.kernel().work_bits());
    let saltation = |impact: &TrueImpact| (&restitution + 1.0) * &impact.acceleration / &impact.velocity_before;
    let data = impacts.into_iter().map(|impact| (impact.time.clone(), saltation(impact))).collect();
    (restitution, data)
}

impl TrueSpectrum {
    /// The secular determinant of `orbit`.
    ///
    /// # Errors
    /// [`TruthError::SeveralSites`]; [`TruthError::Singular`] for an impact without speed.
    pub fn new(orbit: &TrueOrbit) -> Result<Self, TruthError> {
        let impacts = orbit.impacts();
        if impacts.windows(2).any(|pair| pair[0].site != pair[1].site) {
            return Err(TruthError::SeveralSites);
        }
        let site = impacts.first().map_or(0, |impact| impact.site);
        Self::assemble(orbit.kernel(), orbit.kernel().weights(site), saltations(orbit, impacts), orbit.bits())
    }

    /// The secular determinant of one block of an orbit with two sites that hit alike, or opposite to each other, at the same instants:
    /// that of the sum of the two (`sign` 1) or of their difference (−1), which is that of one site with other weights.
    ///
    /// # Errors
    /// As [`TrueSpectrum::new`]; [`TruthError::SeveralSites`] for other orbits.
    pub fn of_partners(orbit: &TrueOrbit, sign: f64) -> Result<Self, TruthError> {
        let [first, second, ..] = orbit.impacts() else { return Err(TruthError::SeveralSites) };
        let of_site = |site| orbit.impacts().iter().filter(move |impact| impact.site == site);
        let same = of_site(first.site).map(|impact| &impact.time).eq(of_site(second.site).map(|impact| &impact.time));
        if !same || orbit.impacts().len() != 2 * of_site(first.site).count() {
            return Err(TruthError::SeveralSites);
        }
        let kernel = orbit.kernel();
        // (A reflection that exchanges the two sites leaves the squares of shapes as they are.)
        let pairs = kernel.weights(first.site).zip(kernel.shares(first.site, second.site));
        let weights = pairs.map(|(own, both)| own + both * sign);
        Self::assemble(kernel, weights, saltations(orbit, of_site(first.site)), orbit.bits())
    }

    /// The secular determinant for the times, accelerations and velocities of an `f64` orbit, taken as exact: what is to be
    /// had from these numbers, be the orbit as good as it may.
    ///
    /// # Errors
    /// As [`TrueSpectrum::new`]; [`TruthError::Resonance`].
    pub fn as_given(orbit: &Orbit, bits: usize) -> Result<Self, TruthError> {
        let site = orbit.impact_site().ok_or(TruthError::SeveralSites)?;
        let model = undamped(orbit)?;
        let kernel = Kernel::new(model.chain(), model.omega(), orbit.force_periods(), 2 * bits + 64)?;
        let work = kernel.work_bits();
        let restitution = Real::new(model.restitution(), work);
        let data = orbit.impacts().iter().map(|impact| {
            let kappa = (&restitution + 1.0) * impact.acceleration / impact.velocity_before;
            (Real::new(impact.time, work), kappa)
        });
        let data = data.collect();
        Self::assemble(&kernel, kernel.weights(site), (restitution, data), bits)
    }

    /// From the weights of all modes, of which those that are 0 are left out, and the saltations.
    fn assemble(
        kernel: &Kernel,
        weights: impl Iterator<Item = Real>,
        (restitution, impacts): (Real, Vec<(Real, Real)>),
        bits: usize,
    ) -> Result<Self, TruthError> {
        if impacts.windows(2).any(|pair| pair[0].0 >= pair[1].0) {
            return Err(TruthError::Singular { what: "two impacts of one mass at one time" });
        }
        if impacts.iter().any(|(_, kappa)| !kappa.is_finite()) {
            return Err(TruthError::Singular { what: "an impact without speed: its saltation is not finite" });
        }
        let work = kernel.work_bits();
        let period = kernel.period();
        let mut poles: Vec<Pole> = Vec::new();
        for (mode, (frequency, weight)) in kernel.frequencies().zip(weights).enumerate() {
            if weight.log2_abs() < -(bits as f64) {
                continue;
            }
            match poles.iter_mut().find(|pole| pole.frequency == *frequency) {
                Some(pole) => {
                    pole.weight += &weight;
                    pole.multiplicity += 1;
                }
                None => {
                    let cos = (frequency * period).sin_cos().1;
                    let frequency = frequency.clone();
                    poles.push(Pole { mode, multiplicity: 1, weight, frequency, cos });
                }
            }
        }
        let flights = (0..impacts.len()).map(|i| {
            let row = (0..impacts.len()).map(|j| {
                let mut time = &impacts[i].0 - &impacts[j].0;
                if j >= i {
                    time += period;
                }
                poles.iter().map(|pole| Flight::new(&pole.frequency, &time)).collect()
            });
            row.collect()
        });
        let flights = flights.collect();
        let symplectic = restitution == Real::one(64);
        let kappas = impacts.into_iter().map(|(_, kappa)| kappa).collect();
        Ok(Self { bits, work, symplectic, restitution, kappas, poles, flights })
    }

    /// Number of multipliers on the even subspace, 2(⌊M/2⌋+1).
    pub fn dimension(&self) -> usize {
        2 * self.poles.iter().map(|pole| pole.multiplicity).sum::<usize>()
    }

    /// Product of the multipliers on the even subspace, e^{2n} for n impacts.
    pub fn determinant(&self) -> Real {
        (0..self.kappas.len()).fold(Real::one(self.work), |product, _| product * &self.restitution * &self.restitution)
    }

    /// Sum of the multipliers on the even subspace, by another way than D(z): from its limit z → ∞,
    /// tr M = tr R(T) + tr (1−L)⁻¹U, with the blocks BᵀR(τ_ij)B D_j below the diagonal in L and the others in U.
    pub fn trace(&self) -> Real {
        let n = self.kappas.len();
        let zero = Real::zero(self.work);
        let mut trace =
            self.poles.iter().fold(zero.clone(), |sum, pole| sum + &pole.cos * (2 * pole.multiplicity) as f64);
        // Column by column of U: the rows of (1−L)⁻¹U one after the other.
        let blocks: Vec<Vec<[[Real; 2]; 2]>> =
            (0..n).map(|i| (0..n).map(|j| self.instantaneous(i, j)).collect()).collect();
        for column in 0..n {
            for side in 0..2 {
                let mut x: Vec<[Real; 2]> = Vec::with_capacity(n);
                for (i, row) in blocks.iter().enumerate() {
                    let mut entry = if column >= i {
                        [row[column][0][side].clone(), row[column][1][side].clone()]
                    } else {
                        [zero.clone(), zero.clone()]
                    };
                    for (block, x) in row.iter().zip(&x) {
                        for (entry, line) in entry.iter_mut().zip(block) {
                            *entry += &line[0] * &x[0] + &line[1] * &x[1];
                        }
                    }
                    x.push(entry);
                }
                trace += &x[column][side];
            }
        }
        trace
    }

    /// BᵀR(τ_ij)B D_j
    fn instantaneous(&self, i: usize, j: usize) -> [[Real; 2]; 2] {
        let mut sums = [Real::zero(self.work), Real::zero(self.work), Real::zero(self.work)];
        for (pole, flight) in self.poles.iter().zip(&self.flights[i][j]) {
            for (sum, part) in sums.iter_mut().zip([&flight.cos, &flight.sin_over, &flight.sin_times]) {
                *sum += &pole.weight * part;
            }
        }
        let [cos, up, down] = sums;
        let loss = &self.restitution + 1.0;
        let kappa = &self.kappas[j];
        [[&up * kappa - &cos * &loss, -(&up * &loss)], [&cos * kappa + &down * &loss, -(&cos * &loss)]]
    }

    /// D(z). `None` on a pole.
    pub fn secular(&self, z: &Complex) -> Option<Complex> {
        let (determinant, _) = self.evaluate(z, &half_sum(z), &[])?;
        Some(determinant)
    }

    /// dD/dz, by a central difference. `None` on a pole.
    pub fn secular_slope(&self, z: &Complex) -> Option<Complex> {
        let step = difference(z.log2_abs(), self.work);
        let difference = self.secular(&shifted(z, &step))? - self.secular(&shifted(z, &-&step))?;
        Some(difference.scale(&(Real::one(self.work) / (step * 2.0))))
    }

    /// det(z−M) on the even subspace, poles or not; `None` for z = 0.
    pub fn characteristic(&self, z: &Complex) -> Option<Complex> {
        if z.is_zero() {
            return Some(Complex::real(self.determinant()));
        }
        let nu = half_sum(z);
        let double = z + z;
        let mut product = self.regular(z, &nu, &self.near(&nu))?;
        for pole in &self.poles {
            product = product * &double;
            for _ in 1..pole.multiplicity {
                product = product * &double * shifted(&nu, &-&pole.cos);
            }
        }
        Some(product)
    }

    /// D(z) Π (ν−c): det(z−M) less a factor 2z a pole and less what modes of equal frequency share.
    fn regular(&self, z: &Complex, nu: &Complex, explicit: &[usize]) -> Option<Complex> {
        let (mut value, factor) = self.evaluate(z, nu, explicit)?;
        let inverse = (z + z).inverse();
        for _ in explicit {
            value = value * &inverse;
        }
        Some(value * factor)
    }

    /// The poles next to ν, nearest first.
    fn near(&self, nu: &Complex) -> Vec<usize> {
        let distance = |p: usize| shifted(nu, &-&self.poles[p].cos).log2_abs();
        let mut near: Vec<usize> = (0..self.poles.len()).filter(|&p| distance(p) < NEAR_POLE.log2()).collect();
        near.sort_by(|&p, &q| distance(p).total_cmp(&distance(q)));
        near.truncate(MAX_EXPLICIT);
        near
    }
}

/// ν = ½(z + 1/z)
fn half_sum(z: &Complex) -> Complex {
    let sum = z + z.inverse();
    Complex { re: sum.re / 2.0, im: sum.im / 2.0 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::linear::determinant;
    use vibrochain_breather::{Family, breathers};
    use vibrochain_lattice::Point;

    /// det(z−M) of the dense monodromy matrix, product of flights and saltations in even coordinates (x_k, ẋ_k).
    fn dense(orbit: &TrueOrbit, z: &Complex) -> Complex {
        let kernel = orbit.kernel();
        let (m, work) = (kernel.modes(), kernel.work_bits());
        let b: Vec<Real> = kernel.weights(0).map(|weight| weight.sqrt()).collect();
        let mut columns: Vec<Vec<Real>> =
            (0..2 * m).map(|i| (0..2 * m).map(|j| Real::new(f64::from(u8::from(i == j)), work)).collect()).collect();
        let e = Real::new(orbit.model().restitution(), work);
        for (i, impact) in orbit.impacts().iter().enumerate() {
            let until = orbit.impacts().get(i + 1).map_or(orbit.period().clone(), |next| next.time.clone());
            let flight = &until - &impact.time;
            let kappa = (&e + 1.0) * &impact.acceleration / &impact.velocity_before;
            for x in &mut columns {
                let site =
                    |half: usize, x: &[Real]| (0..m).fold(Real::zero(work), |sum, k| sum + &b[k] * &x[k + half * m]);
                let (u, v) = (site(0, x), site(1, x));
                let (du, dv) = (-(&u * (&e + 1.0)), &u * &kappa - &v * (&e + 1.0));
                for (k, frequency) in kernel.frequencies().enumerate() {
                    x[k] += &b[k] * &du;
                    x[k + m] += &b[k] * &dv;
                    let (q, p) = (x[k].clone(), x[k + m].clone());
                    if frequency.is_zero() {
                        x[k] = q + &p * &flight;
                    } else {
                        let (sin, cos) = (frequency * &flight).sin_cos();
                        x[k] = &q * &cos + &p * &sin / frequency;
                        x[k + m] = &p * &cos - &q * &sin * frequency;
                    }
                }
            }
        }
        let entry = |i: usize, j: usize| {
            let entry = Complex::real(-&columns[j][i]);
            if i == j { entry + z } else { entry }
        };
        determinant((0..2 * m).map(|i| (0..2 * m).map(|j| entry(i, j)).collect()).collect(), work)
    }

    fn orbit(sites: usize, gamma: (f64, f64), omega: f64, force: (f64, f64), family: Family) -> TrueOrbit {
        let ring = Point::ring(sites).gamma1(gamma.0).gamma2(gamma.1);
        let model = ring.omega(omega).asymmetry(0.4).amplitude(force.0).restitution(force.1).model().unwrap();
        let orbits = breathers(&model, family).unwrap().orbits;
        TrueOrbit::refine(orbits.last().unwrap(), 128).unwrap()
    }

    fn assert_close(a: &Complex, b: &Complex) {
        assert!((a - b).log2_abs() < b.log2_abs() - 180.0, "{a:?} {b:?}");
    }

    #[test]
    fn the_determinant_is_that_of_the_monodromy_matrix() {
        let cases = [
            orbit(5, (0.2, 0.1), 1.5, (0.0, 1.0), Family::DoubleSided),
            orbit(4, (0.2, 0.1), 0.85, (0.0, 1.0), Family::SingleSided),
            orbit(6, (0.2, 0.1), 1.5, (0.1, 0.9), Family::DoubleSided),
            orbit(3, (0.2, 0.1), 1.5, (0.1, 1.0), Family::DoubleSided),
            orbit(5, (0.0, 0.1), 1.5, (0.4, 0.8), Family::DoubleSided),
            orbit(5, (0.2, 0.0), 1.5, (0.1, 0.9), Family::DoubleSided),
            orbit(1, (0.2, 0.0), 1.1, (0.5, 0.7), Family::SingleSided),
        ];
        for orbit in &cases {
            let spectrum = TrueSpectrum::new(orbit).unwrap();
            assert_eq!(spectrum.dimension(), 2 * orbit.kernel().modes());
            for (re, im) in [(0.3, 0.7), (-1.2, 0.1), (2.5, 0.0), (0.02, -0.01)] {
                let z = Complex::new(re, im, 320);
                let characteristic = spectrum.characteristic(&z).unwrap();
                assert_close(&characteristic, &dense(orbit, &z));
                // D is the quotient, and its slope is one.
                let mut free = Complex::new(1.0, 0.0, 320);
                for frequency in orbit.kernel().frequencies() {
                    let cos = (frequency * orbit.period()).sin_cos().1;
                    free = free * (&z * &z - z.scale(&(cos * 2.0)) + Complex::new(1.0, 0.0, 64));
                }
                assert_close(&(spectrum.secular(&z).unwrap() * free), &characteristic);
                let h = Real::one(320).times_power_of_two(-60);
                let [plus, minus] = [h.clone(), -&h].map(|h| spectrum.secular(&shifted(&z, &h)).unwrap());
                let slope = (plus - minus).scale(&(Real::one(320) / (h * 2.0)));
                let found = spectrum.secular_slope(&z).unwrap();
                assert!((&slope - &found).log2_abs() < found.log2_abs() - 80.0);
            }
            // On and next to a pole, where sums would lose everything.
            let pole = spectrum.poles.last().unwrap();
            let sin = (-(&pole.cos * &pole.cos) + 1.0).sqrt();
            for distance in [0.0, 1e-60, 1e-20] {
                let z = Complex { re: pole.cos.clone(), im: &sin + distance };
                let (a, b) = (spectrum.characteristic(&z).unwrap(), dense(orbit, &z));
                assert!((a - &b).log2_abs() < -180.0, "{distance} {b:?}");
            }
            assert_close(
                &spectrum.characteristic(&Complex::new(0.0, 0.0, 64)).unwrap(),
                &dense(orbit, &Complex::new(0.0, 0.0, 64)),
            );
        }
    }
}
