//! The flow of a linear structure with its loads: the exponential of one matrix.
//!
//! ```text
//! x = (q, q′/σ),  u = (cos jω(t+ψ), sin jω(t+ψ) of each harmonic, 1)
//! x′ = A x + B u,  u′ = R u,       A = [[0, σ], [−M⁻¹K/σ, −M⁻¹C]],  B = M⁻¹(Re f, −Im f, s)/σ
//! ```
//!
//! σ is a power of two next to the root of the largest entry of M⁻¹K: without it the norm of A would be the square of a frequency.

use vibrochain_lattice::Structure;

use crate::error::TruthError;
use crate::linear::{Matrix, product, solve, times};
use crate::real::Real;

/// Taylor's series is summed for times below 2^−this over the norm: each term has as many digits fewer, and each costs one product.
const SHORT: i32 = 8;

/// Terms of the series at most: for 10⁵ digits.
const MAX_TERMS: usize = 40_000;

/// The generator of (x, u), and what exponentials are made of.
#[derive(Debug, Clone)]
pub(crate) struct Flow {
    bits: usize,
    coordinates: usize,
    /// σ = 2^this
    scale: i32,
    /// jω of each harmonic.
    rates: Vec<Real>,
    generator: Matrix,
    /// Â^k τ^k/k! for the time τ = 2^`unit`.
    powers: Vec<Matrix>,
    unit: i32,
    inverse_mass: Matrix,
}

impl Flow {
    /// That of a structure whose loads have the frequency `omega`, in `bits` binary digits.
    ///
    /// # Errors
    /// [`TruthError::Mismatch`] for matrices of different sizes; [`TruthError::Singular`] for a mass matrix without inverse;
    /// [`TruthError::Parameter`] for entries that are not finite.
    pub(crate) fn new(structure: &Structure, omega: f64, bits: usize) -> Result<Self, TruthError> {
        let n = structure.mass.nrows();
        check(structure, omega)?;
        let zero = || Real::zero(bits);
        let entry = |x: f64| Real::new(x, bits);
        let mass: Matrix = (0..n).map(|i| (0..n).map(|j| entry(structure.mass[(i, j)])).collect()).collect();
        let over_mass = |column: Vec<Real>| {
            solve(mass.clone(), column).ok_or(TruthError::Singular { what: "the mass matrix has no inverse" })
        };
        let columns = |of: &dyn Fn(usize, usize) -> f64| {
            (0..n).map(|j| over_mass((0..n).map(|i| entry(of(i, j))).collect())).collect::<Result<Vec<_>, _>>()
        };
        let stiffness = columns(&|i, j| structure.stiffness[(i, j)])?;
        let damped = !structure.damping.is_empty();
        let damping = columns(&|i, j| if damped { structure.damping[(i, j)] } else { 0.0 })?;
        let inverse = columns(&|i, j| f64::from(u8::from(i == j)))?;
        let largest = stiffness.iter().flatten().map(Real::log2_abs).fold(f64::NEG_INFINITY, f64::max);
        let scale = if largest.is_finite() { (0.5 * largest).round() as i32 } else { 0 };

        let harmonics = structure.loads.len();
        let size = 2 * n + 2 * harmonics + 1;
        let mut generator: Matrix = (0..size).map(|_| vec![zero(); size]).collect();
        for i in 0..n {
            generator[i][n + i] = Real::one(bits).times_power_of_two(scale);
            for j in 0..n {
                generator[n + i][j] = -stiffness[j][i].times_power_of_two(-scale);
                generator[n + i][n + j] = -&damping[j][i];
            }
        }
        let rates: Vec<Real> = structure.loads.iter().map(|(j, _)| entry(omega) * f64::from(*j)).collect();
        let mut loads: Vec<Vec<Real>> = Vec::new();
        for ((_, load), rate) in structure.loads.iter().zip(&rates) {
            let at = 2 * n + loads.len();
            generator[at][at + 1] = -rate;
            generator[at + 1][at] = rate.clone();
            loads.push(load.iter().map(|f| entry(f.re)).collect());
            loads.push(load.iter().map(|f| -entry(f.im)).collect());
        }
        let still = |i: usize| if structure.static_load.is_empty() { 0.0 } else { structure.static_load[i] };
        loads.push((0..n).map(|i| entry(still(i))).collect());
        for (place, load) in loads.into_iter().enumerate() {
            for (i, push) in over_mass(load)?.into_iter().enumerate() {
                generator[n + i][2 * n + place] = push.times_power_of_two(-scale);
            }
        }
        // Loads stand beside the diagonal blocks and do not make exponentials grow.
        let rows = generator.iter().enumerate().map(|(i, row)| {
            let block = if i < 2 * n { &row[..2 * n] } else { &row[2 * n..] };
            block.iter().map(Real::log2_abs).fold(f64::NEG_INFINITY, f64::max)
        });
        let norm = rows.fold(f64::NEG_INFINITY, f64::max).max(-1e6) + (2.0 * n as f64).log2();
        let unit = -norm.ceil() as i32 - SHORT;
        let inverse_mass = (0..n).map(|i| (0..n).map(|j| inverse[j][i].clone()).collect()).collect();
        let powers = powers(&generator, unit, bits);
        Ok(Self { bits, coordinates: n, scale, rates, generator, powers, unit, inverse_mass })
    }

    /// Number of coordinates q.
    pub(crate) fn coordinates(&self) -> usize {
        self.coordinates
    }

    /// Of (x, u).
    pub(crate) fn size(&self) -> usize {
        self.generator.len()
    }

    /// Binary digits it is calculated with.
    pub(crate) fn bits(&self) -> usize {
        self.bits
    }

    /// Digits that doubling a flight of this length may lose: log₂ of how often it is doubled.
    pub(crate) fn doublings(&self, log2_time: f64) -> usize {
        (log2_time - f64::from(self.unit)).ceil().max(0.0) as usize
    }

    /// The exponential over a time, which may be negative.
    pub(crate) fn after(&self, time: &Real) -> Matrix {
        let doublings = self.doublings(time.log2_abs()) as i32;
        let part = time.times_power_of_two(-doublings - self.unit);
        let size = self.size();
        let mut sum: Matrix = (0..size).map(|_| vec![Real::zero(self.bits); size]).collect();
        let mut factor = Real::one(self.bits);
        for power in &self.powers {
            for (line, row) in sum.iter_mut().zip(power) {
                for (entry, term) in line.iter_mut().zip(row).filter(|(_, term)| !term.is_zero()) {
                    *entry += term * &factor;
                }
            }
            factor *= &part;
        }
        for _ in 0..doublings {
            sum = product(&sum, &sum);
        }
        sum
    }

    /// The time derivative of (x, u).
    pub(crate) fn slope(&self, state: &[Real]) -> Vec<Real> {
        times(&self.generator, state)
    }

    /// u at the phase ψ.
    pub(crate) fn phase(&self, psi: &Real) -> Vec<Real> {
        let mut turned = Vec::with_capacity(2 * self.rates.len() + 1);
        for rate in &self.rates {
            let (sin, cos) = (rate * psi).sin_cos();
            turned.push(cos);
            turned.push(sin);
        }
        turned.push(Real::one(self.bits));
        turned
    }

    /// M⁻¹w
    pub(crate) fn over_mass(&self, weights: &[Real]) -> Vec<Real> {
        times(&self.inverse_mass, weights)
    }

    /// A velocity in units of the state.
    pub(crate) fn scaled(&self, velocity: &Real) -> Real {
        velocity.times_power_of_two(-self.scale)
    }

    /// A velocity of the state in the user's units.
    pub(crate) fn unscaled(&self, velocity: &Real) -> Real {
        velocity.times_power_of_two(self.scale)
    }
}

/// Sizes and numbers.
fn check(structure: &Structure, omega: f64) -> Result<(), TruthError> {
    let n = structure.mass.nrows();
    let square = |rows: usize, columns: usize| rows == n && columns == n;
    let damping = &structure.damping;
    let fits = n > 0
        && square(n, structure.mass.ncols())
        && square(structure.stiffness.nrows(), structure.stiffness.ncols())
        && (damping.is_empty() || square(damping.nrows(), damping.ncols()))
        && structure.contacts.iter().all(|(weights, _)| weights.len() == n)
        && structure.loads.iter().all(|(_, load)| load.len() == n)
        && (structure.static_load.is_empty() || structure.static_load.len() == n);
    if !fits {
        return Err(TruthError::Mismatch { what: "matrices, contacts and loads of a structure: one row a coordinate" });
    }
    if structure.modes.is_some() {
        return Err(TruthError::Mismatch {
            what: "a structure of which some modes alone count: its state has all of them",
        });
    }
    let matrices = [&structure.mass, &structure.stiffness, damping];
    let entries = matrices.into_iter().flatten().chain(&structure.static_load);
    let weights = structure.contacts.iter().flat_map(|(weights, _)| weights);
    let loads = structure.loads.iter().flat_map(|(_, load)| load).flat_map(|f| [&f.re, &f.im]);
    if let Some(&value) = entries.chain(weights).chain(loads).find(|x| !x.is_finite()) {
        return Err(TruthError::Parameter { name: "an entry of a structure", value, requirement: "a finite number" });
    }
    if omega > 0.0 && omega.is_finite() {
        Ok(())
    } else {
        Err(TruthError::Parameter { name: "omega", value: omega, requirement: "a positive number" })
    }
}

/// Taylor's terms for a time of 2^`unit`, as many as count: each is 2^−`SHORT`/k of the one before.
fn powers(generator: &Matrix, unit: i32, bits: usize) -> Vec<Matrix> {
    let size = generator.len();
    let step: Matrix =
        generator.iter().map(|row| row.iter().map(|entry| entry.times_power_of_two(unit)).collect()).collect();
    let one = |i: usize, j: usize| if i == j { Real::one(bits) } else { Real::zero(bits) };
    let mut terms: Vec<Matrix> = vec![(0..size).map(|i| (0..size).map(|j| one(i, j)).collect()).collect()];
    let mut left = bits as f64 + f64::from(SHORT);
    for k in 1..MAX_TERMS {
        let mut next = product(&terms[k - 1], &step);
        next.iter_mut().flatten().filter(|entry| !entry.is_zero()).for_each(|entry| *entry = &*entry / k as f64);
        terms.push(next);
        left -= f64::from(SHORT) + (k as f64).log2();
        if left < 0.0 {
            break;
        }
    }
    terms
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{Complex, DMatrix, DVector};

    /// One oscillator under a load at resonance, one overdamped, one critically: closed forms, none of which the flow knows.
    #[test]
    fn the_flow_is_that_of_oscillators_known_by_hand() {
        let bits = 256;
        let time = Real::new(2.75, bits);
        let structure = |damping: f64, load: f64| Structure {
            mass: DMatrix::from_element(1, 1, 1.0),
            damping: DMatrix::from_element(1, 1, damping),
            stiffness: DMatrix::from_element(1, 1, 1.0),
            loads: vec![(1, DVector::from_vec(vec![Complex::new(load, 0.0)]))],
            ..Structure::default()
        };
        let close = |a: &Real, b: &Real| assert!((a - b).log2_abs() < -232.0, "{} {a} {b}", (a - b).log2_abs());
        // x″ + x = cos t from rest: x = ½ t sin t.
        let flow = Flow::new(&structure(0.0, 1.0), 1.0, bits).unwrap();
        let turn = flow.after(&time);
        let (sin, cos) = time.sin_cos();
        close(&turn[0][0], &cos);
        close(&turn[0][1], &sin);
        close(&turn[0][2], &(&time * &sin / 2.0));
        close(&turn[2][3], &-&sin);
        // x″ + 2x′ + x = 0: e^{−t}(1 + t) and t e^{−t}; the inverse of a flight is that backwards.
        let flow = Flow::new(&structure(2.0, 0.0), 1.0, bits).unwrap();
        let (forth, back) = (flow.after(&time), flow.after(&-&time));
        close(&(&forth[0][0] / &forth[0][1]), &((&time + 1.0) / &time));
        close(&(&forth[0][1] * &back[0][1]), &-(&time * &time));
        // x″ + 2.5x′ + x = 0 has the rates −½ and −2: e^{−t/2} to the fourth power is the other.
        let flow = Flow::new(&structure(2.5, 0.0), 1.0, bits).unwrap();
        let turn = flow.after(&time);
        let (slow, fast) = (&turn[0][0] - &turn[0][1] / 2.0, &turn[0][0] - &turn[0][1] * 2.0);
        close(&fast, &slow.powi(4));
    }

    #[test]
    fn what_is_no_structure_is_refused() {
        let sound =
            Structure { mass: DMatrix::identity(2, 2), stiffness: DMatrix::identity(2, 2), ..Structure::default() };
        assert!(Flow::new(&sound, 1.0, 128).is_ok());
        let with = |change: &dyn Fn(&mut Structure)| {
            let mut structure = sound.clone();
            change(&mut structure);
            Flow::new(&structure, 1.0, 128).unwrap_err()
        };
        assert!(matches!(with(&|one| one.mass = DMatrix::zeros(2, 2)), TruthError::Singular { .. }));
        assert!(matches!(with(&|one| one.damping = DMatrix::identity(3, 3)), TruthError::Mismatch { .. }));
        assert!(matches!(with(&|one| one.modes = Some(1)), TruthError::Mismatch { .. }));
        assert!(matches!(with(&|one| one.stiffness[(0, 1)] = f64::NAN), TruthError::Parameter { .. }));
        assert!(matches!(Flow::new(&sound, 0.0, 128), Err(TruthError::Parameter { .. })));
    }
}
