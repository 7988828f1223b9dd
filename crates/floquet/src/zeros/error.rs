//! Why the secular function gives no answer.

use thiserror::Error;

/// What keeps the secular function from an answer that it could vouch for.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
#[non_exhaustive]
pub enum SecularError {
    /// The orbit is not its own mirror image in time, or impacts at several sites.
    #[error("the orbit is not of the kind this secular function is for")]
    NotReversible,
    /// A certificate fails: rounding has eaten the residues (next to resonance, for very soft or stiff rings).
    #[error("a certificate of the secular function fails by {} where rounding explains {}", told(*defect), told(*allowed))]
    Certificate {
        /// By how much.
        defect: f64,
        /// How much rounding explains.
        allowed: f64,
    },
    /// The residue of a mode is smaller than its error, so that its sign is not known: Ω_k ± Ω_l = jω to within rounding.
    #[error("the sign of the residue of mode {mode} is lost in rounding")]
    ResidueSign {
        /// The mode.
        mode: usize,
    },
    /// Rounding leaves few digits of the leading multiplier.
    #[error("the excess {} is uncertain by {}", told(*excess), told(*excess_error))]
    Imprecise {
        /// |μ| − 1
        excess: f64,
        /// Its error.
        excess_error: f64,
    },
    /// Not all roots were found.
    #[error("{found} of {wanted} roots were found")]
    Incomplete {
        /// Roots found.
        found: usize,
        /// Roots there are.
        wanted: usize,
    },
    /// Every root is told from the rest, but all together are not what they must be.
    #[error("the product or sum of all roots is not what it must be, by more than rounding explains")]
    Inconsistent,
}

/// A number in words; one that is none is said so.
fn told(value: f64) -> String {
    if value.is_finite() { format!("{value:.1e}") } else { "an unknown amount".to_owned() }
}
