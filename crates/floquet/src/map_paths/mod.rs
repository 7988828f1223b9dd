//! What conservative maps and large rings need faster than [`crate::spectrum`] is, for impacts at one site: the same determinant from the
//! modes' own poles and residues, a pass over the modes or a few for a verdict. `tests/map_paths.rs` holds it against the spectrum;
//! `cargo bench --bench map_throughput` and `--bench spectrum` time it.
//!
//! | module | holds |
//! |---|---|
//! | `by_secular` | the door: from an orbit to its verdict |
//! | `reversible` | conservative orbits that are their own mirror image in time |
//! | `fast_sums` | sums in O(M) for rings of up to 10⁶ masses |
//! | `modes` | the modes that impacts feel |
//! | `labels` | the mode that a multiplier is next to |

mod by_secular;
pub(crate) mod fast_sums;
mod labels;
mod modes;
pub(crate) mod reversible;

pub use labels::ModeLabels;
pub(crate) use modes::{Modes, by_frequency, sort_felt};
pub use reversible::residues::Residues;
pub use reversible::verdict::{Reason, Secular, SecularVerdict, Standing};

#[cfg(test)]
mod tests;
