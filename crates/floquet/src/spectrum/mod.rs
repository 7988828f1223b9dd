//! All multipliers of one orbit of any word on any lattice, as the zeros of one function.
//!
//! f(z) = det(z−M)/det(z−R) = Π(m(1+e))²·det J(z) with the orbit's own linearised equations ([`vibrochain_breather::BlochEquations`]).
//! Its poles are the modes, so are as many zeros: Ehrlich and Aberth's iteration finds them all together from starts beside the poles,
//! each is refined by its null vector, and no two refined ones may be the same.
//!
//! | module | holds |
//! |---|---|
//! | `function` | f′/f, and J(z) with near poles kept apart |
//! | `zero` | [`Zero`]: one of them, as it is known |
//! | `starts` | where the zeros are to first order |
//! | `null` | null vectors of J(z) |
//! | `refine` | one zero, or several close ones, with errors |
//! | `drift` | how one moves along a branch |
//! | `solve` | all of them, counted |
//! | `clusters` | the same where poles nearly coincide |
//! | `krein`, `parts` | Krein's form on an eigenvector, and which symmetry that has |
//! | `leading` | f as a sum over its poles, and the zeros that lead alone, for a verdict |
//! | `beyond` | whether one is surely beyond some modulus, by a sign |
//! | `shape` | [`ModalShape`]: the perturbation that belongs to a multiplier |
//! | `multipliers` | [`ImpactSpectrum`]: the multipliers of impacts on any linear structure |
//! | `verdict` | stable or not |

mod beyond;
mod clusters;
mod drift;
mod function;
mod krein;
mod leading;
mod multipliers;
mod null;
mod parts;
mod refine;
mod shape;
mod solve;
mod starts;
#[cfg(test)]
mod tests;
mod verdict;
mod zero;

pub(crate) use beyond::{BEYOND, is_surely_beyond};
pub(crate) use function::SpectralFunction;
pub(crate) use krein::KreinForms;
pub use multipliers::ImpactSpectrum;
pub(crate) use refine::Origin;
pub use shape::ModalShape;
pub(crate) use verdict::{judged, origins, told, told_of_cycle, verdict};
pub(crate) use zero::Zero;

/// Equations of one impact to three at one contact or two, over modes damped up to `most` times critically; some die within a period.
#[cfg(test)]
pub(crate) fn random_equations(
    random: &mut vibrochain_testkit::Random,
    most: f64,
) -> vibrochain_breather::BlochEquations {
    let (modes, contacts, period) = (1 + random.below(9), 1 + random.below(2), random.between(1.0, 8.0));
    let mut kernel = vibrochain_lattice::BlochKernel::new(period, contacts);
    for _ in 0..modes {
        let shapes: Vec<f64> = (0..contacts).map(|_| random.between(-1.0, 1.0)).collect();
        kernel.push_oscillator(random.log(0.3, 30.0), random.log(1e-4, most), &shapes);
    }
    let impacts = (0..1 + random.below(3))
        .map(|i| vibrochain_breather::LinearImpact {
            contact: random.below(contacts),
            time: period * (i as f64 + random.between(0.0, 0.9)) / 3.0,
            impulse: random.between(0.2, 2.0),
            restitution: random.between(0.3, 1.0),
            acceleration_before: random.between(-1.0, 1.0),
        })
        .collect();
    vibrochain_breather::BlochEquations::new(kernel, impacts)
}
