//! Eigenvectors, on request: what the leading perturbation looks like along the ring. From the secular form, a few passes over the
//! modes each, where that has an answer; from a dense matrix otherwise.

use faer::MatRef;
use nalgebra::Complex;
use vibrochain_breather::{BreatherError, Finder, LatticeOrbit, Orbit};
use vibrochain_lattice::{Shapes, Spectrum, Stop, aside};

use crate::analyser::Analyser;
use crate::error::FloquetError;
use crate::multipliers::sort_multipliers;
use crate::reference::dense::uncoupled;
use crate::reference::monodromy::{even_monodromy, full_monodromy};
use crate::spectrum::ModalShape;
use crate::verdict::{Question, Tolerance};
use crate::zeros::SecularError;

/// A multiplier and its perturbation just before the first impact.
#[derive(Debug, Clone, PartialEq)]
pub struct FloquetMode {
    /// μ
    pub multiplier: Complex<f64>,
    /// Displacements of the M masses, scaled so that the largest of all entries is 1.
    pub displacement: Vec<Complex<f64>>,
    /// Velocities of the M masses, on the same scale.
    pub velocity: Vec<Complex<f64>>,
}

impl FloquetMode {
    /// The mode of a multiplier that is known, as [`crate::Analyser::stability`] tells them: of the space that feels impacts, which are
    /// all at one site. O(M log M).
    ///
    /// # Errors
    /// [`FloquetError`]; [`FloquetError::Uncounted`] for impacts at several sites, and for a number that is no multiplier of the orbit.
    pub fn of(orbit: &Orbit, finder: &mut Finder, multiplier: Complex<f64>) -> Result<Self, FloquetError> {
        let orbit = orbit.lattice()?;
        let home = orbit
            .centre()
            .filter(|_| orbit.model().chain().sites() == 1 || !uncoupled(orbit))
            .ok_or(SecularError::NotReversible)?;
        let shape = ModalShape::new(&*finder.at_contacts(&orbit)?, multiplier)?;
        let (displacement, velocity) = shape.at_sites(orbit.model().chain().sites(), home);
        let mut mode = Self { multiplier, displacement, velocity };
        mode.normalise();
        Ok(mode)
    }

    /// The entry of largest modulus becomes 1, and real what can be.
    fn normalise(&mut self) {
        let Self { multiplier, displacement, velocity } = self;
        let all = displacement.iter().chain(&*velocity);
        let largest = all.copied().max_by(|a, b| a.norm_sqr().total_cmp(&b.norm_sqr()));
        let scale = largest.filter(|z| z.norm_sqr() > 0.0).map_or(Complex::new(1.0, 0.0), |z| z.inv());
        for entry in displacement.iter_mut().chain(velocity) {
            *entry *= scale;
            if multiplier.im == 0.0 {
                entry.im = 0.0;
            }
        }
    }
}

/// The `count` modes of largest modulus of the space that feels impacts, with their eigenvectors. (A conservative orbit's
/// trivial pair is left out, as long as there are others and no dense matrix has to tell, where rounding splits it.)
///
/// # Errors
/// [`FloquetError`].
///
/// ```
/// use vibrochain_breather::{Family, breathers};
/// use vibrochain_floquet::leading_modes;
/// use vibrochain_lattice::{Chain, Model};
/// let model = Model::conservative(Chain::new(21, 0.2, 0.1)?, 0.8, 0.4)?;
/// let orbit = &breathers(&model, Family::SingleSided)?.orbits[0];
/// let mode = &leading_modes(orbit, 1)?[0];
/// assert!((mode.multiplier.re - 2.797574412183362).abs() < 1e-12);
/// // The instability sits on the breather.
/// assert!(mode.displacement[0].norm() > mode.displacement[10].norm());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn leading_modes(orbit: &Orbit, count: usize) -> Result<Vec<FloquetMode>, FloquetError> {
    let mut finder = Finder::default();
    match by_determinant(orbit.lattice()?, &mut finder, count)? {
        Some(modes) => Ok(modes),
        None => by_matrix(orbit, count),
    }
}

/// The same, until `stop` is raised.
///
/// # Errors
/// As [`leading_modes`]; [`FloquetError::Breather`] if it was stopped.
pub fn leading_modes_until(orbit: &Orbit, count: usize, stop: &Stop) -> Result<Vec<FloquetMode>, FloquetError> {
    let orbit = orbit.clone();
    aside(stop, move || leading_modes(&orbit, count)).map_err(BreatherError::from)?
}

/// From the determinant of the impacts' equations; `None` where that does not tell so many.
fn by_determinant(
    orbit: LatticeOrbit<'_>,
    finder: &mut Finder,
    count: usize,
) -> Result<Option<Vec<FloquetMode>>, FloquetError> {
    // Of masses without coupling the equations know one alone; and they follow modes without dashpots.
    if orbit.centre().is_none() || orbit.model().is_damped() || uncoupled(orbit) && orbit.model().chain().sites() > 1 {
        return Ok(None);
    }
    let question = Question { orbit, tolerance: Tolerance::Rounding, thorough: true };
    let (_, mut multipliers) = Analyser::default().decide(question, finder)?;
    if multipliers.len() < count {
        return Ok(None);
    }
    sort_multipliers(&mut multipliers);
    let modes = multipliers.into_iter().take(count).map(|multiplier| FloquetMode::of(&orbit, finder, multiplier));
    // A number that has no eigenvector of its own stands for two.
    Ok(modes.collect::<Result<_, _>>().ok())
}

fn by_matrix(orbit: &Orbit, count: usize) -> Result<Vec<FloquetMode>, FloquetError> {
    let lattice = orbit.lattice()?;
    let (chain, home) = (lattice.model().chain(), lattice.centre());
    let matrix = if home.is_some() { even_monodromy(orbit)? } else { full_monodromy(orbit)? };
    let size = matrix.nrows();
    let failed = || FloquetError::NotConverged { dimension: size };
    if !matrix.norm().is_finite() {
        return Err(failed());
    }
    let dense = MatRef::from_column_major_slice(matrix.as_slice(), size, size);
    let eigen = dense.eigen().map_err(|_| failed())?;
    let (values, vectors) = (eigen.S().column_vector(), eigen.U());
    let mut order: Vec<usize> = (0..size).collect();
    let modulus = |i: usize| values[i].re.hypot(values[i].im);
    order.sort_by(|&i, &j| modulus(j).total_cmp(&modulus(i)).then(values[i].im.total_cmp(&values[j].im)));
    let spectrum = Spectrum::new(*chain);
    let shapes = Shapes::new(chain);
    let (sites, half) = (chain.sites(), size / 2);
    let modes = order.into_iter().take(count).map(|i| {
        let entry = |row: usize| {
            let z = vectors[(row, i)];
            Complex::new(z.re, z.im)
        };
        let zero = Complex::new(0.0, 0.0);
        let (mut displacement, mut velocity) = (vec![zero; sites], vec![zero; sites]);
        for n in 0..sites {
            if let Some(home) = home {
                let evens = shapes.evens(n, home);
                let modes = spectrum.frequencies().iter().zip(spectrum.weights()).zip(evens).enumerate();
                for (k, ((f, w), shape)) in modes {
                    displacement[n] += entry(k) * (w.sqrt() * shape / f.max(orbit.frequency()));
                    velocity[n] += entry(k + half) * (w.sqrt() * shape);
                }
            } else {
                displacement[n] = entry(n);
                velocity[n] = entry(n + half);
            }
        }
        let mut mode = FloquetMode { multiplier: Complex::new(values[i].re, values[i].im), displacement, velocity };
        mode.normalise();
        mode
    });
    Ok(modes.collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use vibrochain_breather::{Family, breathers};
    use vibrochain_lattice::{Chain, Model, Point};

    /// Both ways, against each other and against the matrix of the whole ring.
    #[test]
    fn modes_are_those_of_the_dense_matrix() {
        let cases = [
            (21, Family::SingleSided, 0.8, 0.0, 1.0),
            (20, Family::DoubleSided, 0.9, 0.0, 1.0),
            (21, Family::DoubleSided, 1.5, 0.1, 0.9),
            (31, Family::SingleSided, 0.92, 0.1, 0.9),
            (12, Family::SingleSided, 0.92, 0.1, 1.0),
        ];
        let mut compared = 0;
        for (sites, family, omega, amplitude, e) in cases {
            let ring = Point::ring(sites).gamma1(0.2).gamma2(0.1);
            let model = ring.omega(omega).asymmetry(0.4).amplitude(amplitude).restitution(e).model().unwrap();
            for orbit in &breathers(&model, family).unwrap().orbits {
                let mut finder = Finder::new(sites);
                let matrix = full_monodromy(orbit).unwrap();
                let dense = by_matrix(orbit, 3).unwrap();
                for mode in by_determinant(orbit.lattice().unwrap(), &mut finder, 3).unwrap().unwrap() {
                    let mut state = mode.displacement.clone();
                    state.extend(&mode.velocity);
                    let largest = state.iter().map(|z| z.norm()).fold(0.0, f64::max);
                    assert!((largest - 1.0).abs() < 1e-12);
                    for row in 0..2 * sites {
                        let image: Complex<f64> = matrix.row(row).iter().zip(&state).map(|(m, z)| z * *m).sum();
                        let defect = (image - mode.multiplier * state[row]).norm();
                        assert!(defect < 1e-10 * matrix.norm().powi(2), "{family:?} {omega}: {defect:e}");
                    }
                    // Where one is simple, they are the same on the same scale.
                    if let Some(other) = dense.iter().find(|other| (other.multiplier - mode.multiplier).norm() < 1e-9)
                        && mode.multiplier.norm() > 1.0001
                    {
                        let entries = mode.displacement.iter().zip(&other.displacement);
                        let off = entries.map(|(a, b)| (a - b).norm()).fold(0.0, f64::max);
                        assert!(off < 1e-7, "{family:?} {omega}: {off:e}");
                        compared += 1;
                    }
                }
            }
        }
        assert!(compared > 4, "{compared}");
    }

    #[test]
    fn the_leading_mode_of_a_long_ring_needs_no_matrix() {
        // The isolated mode of the infinite chain: no longer does a longer ring change it.
        let at = |sites: usize| {
            let model = Model::conservative(Chain::new(sites, 0.2, 0.1).unwrap(), 0.8, 0.4).unwrap();
            let orbit = &breathers(&model, Family::SingleSided).unwrap().orbits[0];
            leading_modes(orbit, 1).unwrap().remove(0)
        };
        let (short, long) = (at(81), at(20_001));
        assert!((short.multiplier - long.multiplier).norm() < 1e-10);
        for n in 0..30 {
            assert!((short.displacement[n] - long.displacement[n]).norm() < 1e-9, "{n}");
        }
    }
}
