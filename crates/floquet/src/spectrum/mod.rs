//! All multipliers of one orbit of any word on any lattice, as the zeros of one function.
//!
//! f(z) = det(z−M)/det(z−R) = Π(m(1+e))²·det J(z) with the orbit's own linearised equations ([`vibrochain_breather::BlochEquations`]).
//! Its poles are the modes, so are as many zeros: Ehrlich and Aberth's iteration finds them all together from starts beside the poles,
//! each is refined by its null vector, and no two refined ones may be the same.
//!
//! | module | holds |
//! |---|---|
//! | `function` | f′/f, and J(z) with near poles kept apart |
//! | `starts` | where the zeros are to first order |
//! | `null` | null vectors of J(z) |
//! | `refine` | one zero, or several close ones, with errors |
//! | `solve` | all of them, counted |
//! | `leading` | those that lead alone, for a verdict |
//! | `beyond` | whether one is surely beyond some modulus, by a sign |
//! | `multipliers` | [`ImpactSpectrum`]: the multipliers of impacts on any linear structure |
//! | `verdict` | stable or not |

mod beyond;
mod function;
mod leading;
mod multipliers;
mod null;
mod refine;
mod solve;
mod starts;
mod verdict;

pub(crate) use beyond::{SURE, is_surely_beyond};
pub(crate) use function::SpectralFunction;
pub use multipliers::ImpactSpectrum;
pub(crate) use refine::Origin;
pub(crate) use verdict::{origins, spectrum, told, verdict};
