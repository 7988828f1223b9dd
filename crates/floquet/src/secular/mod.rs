//! Floquet spectra without matrices of the ring's size: the multipliers are the zeros of the determinant of a matrix from impact to impact
//! (`impact_matrix`, for any word), which costs one pass over the modes.
//!
//! | module | holds |
//! |---|---|
//! | `single_sided`, `double_sided` | derivation and residues of F for reversible orbits |
//! | `residues` | [`Residues`]: poles, residues, certificates |
//! | `verdict` | [`Secular`], [`SecularVerdict`]: stable or not by counting |
//! | `foreign`, `partners` | two sites that a reflection exchanges: F of their sum and of their difference |
//! | `roots` | all ν |
//! | `modes` | the modes that the impacts feel, on any lattice |
//! | `forced`, `aberth` | [`SecularMultipliers`]: all multipliers for any impacts at one site |
//! | `beyond` | whether a real multiplier is surely beyond some modulus |
//! | `impact_matrix` | K̂: what all of them are the determinant of |
//! | `other_modes`, `four_poles` | K̂ at the poles, and its residues there |
//! | `settle` | a multiplier settled by the impacts' own equations, and its error |
//! | `settled` | a leading multiplier of two instants settled by the secular function itself |
//! | `forced_verdict` | [`ForcedSecular`]: verdicts from these |
//! | `shapes` | [`ModalShape`]: the perturbation that belongs to a multiplier |
//! | `labels` | the mode that a multiplier is next to |
//! | `large`, `cauchy`, `leaf`, `missing` | the same for large rings in O(M) |
//! | `by_roots` | the verdict from all ν |
//! | `forced_large`, `circle`, `forced_roots` | all multipliers of large rings with force or losses in O(M) |
//! | `search` | zeros of a large ring next to poles and anywhere else, for both |
//! | `gap`, `pair`, `evaluate`, `lanes`, `growth` | what they need |
//! | `error` | [`SecularError`]: when to ask a dense solver instead |

mod aberth;
mod beyond;
mod by_roots;
mod cauchy;
mod circle;
mod double_sided;
mod error;
mod evaluate;
mod forced;
mod forced_large;
mod forced_roots;
mod forced_verdict;
mod foreign;
mod four_poles;
mod gap;
mod growth;
mod impact_matrix;
mod labels;
mod large;
mod leaf;
mod linear;
mod missing;
mod modes;
mod other_modes;
mod pair;
mod partners;
mod pole;
mod quick;
mod rational;
mod residues;
mod root;
mod roots;
mod search;
mod settle;
mod settled;
mod shapes;
mod single_sided;
mod verdict;

pub(crate) use aberth::{Aberth, Last, Meromorphic};
pub use error::SecularError;
pub(crate) use forced::MOST_IMPACTS;
pub use forced::SecularMultipliers;
pub(crate) use forced_large::LARGE;
pub use forced_verdict::ForcedSecular;
pub(crate) use forced_verdict::Leading;
pub(crate) use growth::{Nu, excess, modulus};
pub(crate) use impact_matrix::ImpactMatrix;
pub use labels::{ModeLabels, multiplier_modes};
pub(crate) use modes::{Mode, Modes, by_frequency, sort_felt};
pub(crate) use partners::{Pair, Partners};
pub(crate) use rational::Value;
pub use residues::Residues;
pub use shapes::ModalShape;
pub use verdict::{Reason, Secular, SecularVerdict, Standing};

#[cfg(test)]
mod tests;
