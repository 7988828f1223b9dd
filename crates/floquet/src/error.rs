//! Why a stability analysis could not be completed.

use thiserror::Error;
use vibrochain_breather::BreatherError;

/// Failures of this layer; an unstable orbit is an answer, not a failure.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum FloquetError {
    /// The orbit itself could not be set up.
    #[error(transparent)]
    Breather(#[from] BreatherError),
    /// The eigenvalue iteration did not converge.
    #[error("the eigenvalue iteration did not converge (dimension {dimension})")]
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
    /// The dense matrices would not fit.
    #[error("a dense analysis of dimension {dimension} exceeds the limit of {limit}; use a smaller ring")]
    TooLarge {
        /// Size of the matrix.
        dimension: usize,
        /// The most that is done, [`crate::MAX_DIMENSION`].
        limit: usize,
    },
}
