//! Why a branch ends where it should not.

use thiserror::Error;

use crate::error::BreatherError;

/// Why a branch cannot be followed.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum BranchError {
    /// No orbit there: a parameter out of range, a resonance.
    #[error(transparent)]
    Breather(#[from] BreatherError),
    /// The structure has no such value.
    #[error("{0}")]
    Model(String),
    /// Newton's method found no orbit near enough.
    #[error("Newton's method found no orbit of the branch")]
    NoConvergence,
    /// No way is known by which orbits leave one of this family.
    #[error("no orbit is known to branch off one of this family")]
    Family,
}
