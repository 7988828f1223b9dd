//! The multipliers of impacts between the contacts of any linear structure.

use nalgebra::Complex;
use vibrochain_breather::BlochEquations;

use super::clusters::zeros;
use super::solve::Zeros;

/// All multipliers of the modes that feel the impacts of an orbit, with their errors.
///
/// ```
/// use vibrochain_breather::{BlochEquations, LinearImpact};
/// use vibrochain_floquet::ImpactSpectrum;
/// use vibrochain_lattice::BlochKernel;
/// // One mass on a spring with a dashpot, that hits a stop once a period: Πμ = e²·e^{−2ζΩT}.
/// let (frequency, damping, period) = (1.3, 0.1, 4.0);
/// let mut kernel = BlochKernel::new(period, 1);
/// kernel.push_oscillator(frequency, damping, &[1.0]);
/// let impact = LinearImpact { contact: 0, time: 0.0, impulse: -1.0, restitution: 0.8, acceleration_before: 0.3 };
/// let spectrum = ImpactSpectrum::new(&BlochEquations::new(kernel, vec![impact]));
/// assert!(spectrum.is_certified && spectrum.multipliers.len() == 2);
/// let product = spectrum.multipliers[0] * spectrum.multipliers[1];
/// assert!((product - 0.64 * (-2.0 * damping * frequency * period as f64).exp()).norm() < 1e-14);
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct ImpactSpectrum {
    /// μ, in no order.
    pub multipliers: Vec<Complex<f64>>,
    /// Estimated errors of each, for equations that are exact.
    pub errors: Vec<f64>,
    /// As many different ones have been refined as there must be, and their sum and product are what they must be.
    pub is_certified: bool,
}

impl ImpactSpectrum {
    /// The multipliers of an orbit that no symmetry in time keeps at 1: under a force or with losses.
    pub fn new(equations: &BlochEquations) -> Self {
        Self::of(zeros(equations, false, &[]))
    }

    /// Those of an orbit without force or losses, its trivial pair 1, 1 left out.
    pub fn conservative(equations: &BlochEquations) -> Self {
        Self::of(zeros(equations, true, &[]))
    }

    fn of(zeros: Zeros) -> Self {
        let (mut multipliers, mut errors) = (Vec::new(), Vec::new());
        for zero in &zeros.list {
            if zeros.reciprocal {
                multipliers.extend(zero.nu.multipliers());
                errors.extend([zero.nu.excess_error(zero.nu.excess(), zero.error); 2]);
            } else {
                multipliers.push(zero.z);
                errors.push(zero.error);
            }
        }
        Self { multipliers, errors, is_certified: zeros.certified }
    }
}
