//! Eigenvectors, on request: what the leading perturbation looks like along the ring.

use faer::MatRef;
use nalgebra::Complex;
use vibrochain_breather::Orbit;
use vibrochain_lattice::{RingCosines, Spectrum};

use crate::error::FloquetError;
use crate::monodromy::{even_monodromy, full_monodromy};

/// A multiplier and its perturbation just before the first impact.
#[derive(Debug, Clone, PartialEq)]
pub struct FloquetMode {
    /// μ
    pub multiplier: Complex<f64>,
    /// Displacements of the M masses, scaled so that the largest of all entries has modulus 1.
    pub displacement: Vec<Complex<f64>>,
    /// Velocities of the M masses, on the same scale.
    pub velocity: Vec<Complex<f64>>,
}

/// The `count` modes of largest modulus of the space that feels impacts, with their eigenvectors. (A conservative orbit's
/// trivial pair is among them, split by rounding, where nothing larger precedes it.)
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
/// assert!((mode.multiplier.re - 2.797574412183362).abs() < 1e-8);
/// // The instability sits on the breather.
/// assert!(mode.displacement[0].norm() > mode.displacement[10].norm());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn leading_modes(orbit: &Orbit, count: usize) -> Result<Vec<FloquetMode>, FloquetError> {
    let chain = orbit.model().chain();
    let home = orbit.impact_site();
    let matrix = if home.is_some() { even_monodromy(orbit)? } else { full_monodromy(orbit)? };
    let size = matrix.size();
    let failed = || FloquetError::NotConverged { dimension: size };
    if !matrix.is_finite() {
        return Err(failed());
    }
    let dense = MatRef::from_row_major_slice(matrix.entries(), size, size);
    let eigen = dense.eigen().map_err(|_| failed())?;
    let (values, vectors) = (eigen.S().column_vector(), eigen.U());
    let mut order: Vec<usize> = (0..size).collect();
    let modulus = |i: usize| values[i].re.hypot(values[i].im);
    order.sort_by(|&i, &j| modulus(j).total_cmp(&modulus(i)).then(values[i].im.total_cmp(&values[j].im)));
    let spectrum = Spectrum::new(*chain);
    let cosines = RingCosines::new(chain.sites());
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
                let shapes = cosines.shapes(n.abs_diff(home));
                let modes = spectrum.frequencies().iter().zip(spectrum.weights()).zip(shapes).enumerate();
                for (k, ((f, w), shape)) in modes {
                    displacement[n] += entry(k) * (w.sqrt() * shape / f.max(orbit.frequency()));
                    velocity[n] += entry(k + half) * (w.sqrt() * shape);
                }
            } else {
                displacement[n] = entry(n);
                velocity[n] = entry(n + half);
            }
        }
        let largest = displacement.iter().chain(&velocity).map(|z| z.norm()).fold(0.0, f64::max);
        let scale = if largest > 0.0 { 1.0 / largest } else { 1.0 };
        displacement.iter_mut().chain(&mut velocity).for_each(|z| *z *= scale);
        FloquetMode { multiplier: Complex::new(values[i].re, values[i].im), displacement, velocity }
    });
    Ok(modes.collect())
}
