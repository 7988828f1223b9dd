//! Why a stability analysis could not be completed.

use thiserror::Error;
use vibrochain_breather::BreatherError;

use crate::zeros::SecularError;

/// Failures of this layer; an unstable orbit is an answer, not a failure.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum FloquetError {
    /// The orbit itself could not be set up.
    #[error(transparent)]
    Breather(#[from] BreatherError),
    /// The eigenvalue iteration did not converge, or would have overflowed.
    #[error(
        "the eigenvalues could not be computed (dimension {dimension}): the iteration did not converge, or the monodromy \
         matrix is beyond the range of numbers, as next to a grazing impact"
    )]
    NotConverged {
        /// Size of the matrix.
        dimension: usize,
    },
    /// An impact is so close to grazing that its saltation matrix is beyond the range of numbers.
    #[error(
        "ill-conditioned: impact {impact} grazes its barrier (velocity {velocity:e}), its saltation matrix is not finite"
    )]
    Grazing {
        /// Index of the impact.
        impact: usize,
        /// Velocity before it.
        velocity: f64,
    },
    /// Impacts on a lattice with more modes than all multipliers are worked out of.
    #[error(
        "the multipliers of {impacts} impacts a period are worked out on such lattices of up to {limit} masses, and this one has {masses}; use \
         fewer masses: those far from the impacts hardly matter"
    )]
    TooManyModes {
        /// Masses of the lattice.
        masses: usize,
        /// Impacts a period.
        impacts: usize,
        /// The most masses for as many impacts.
        limit: usize,
    },
    /// The multipliers could not be told apart and counted.
    #[error("the multipliers are in doubt: {0}")]
    Uncounted(#[from] SecularError),
    /// The dense matrices would not fit.
    #[error("a dense analysis of dimension {dimension} exceeds the limit of {limit}; use fewer masses")]
    TooLarge {
        /// Size of the matrix.
        dimension: usize,
        /// The most that is done, [`crate::MAX_DIMENSION`].
        limit: usize,
    },
}
