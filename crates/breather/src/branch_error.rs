//! Why a branch ends where it should not.

use thiserror::Error;

use crate::error::BreatherError;
use crate::structures::error::StructureOrbitError;

/// Why a branch cannot be followed.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum BranchError {
    /// No orbit there: a parameter out of range, a resonance.
    #[error(transparent)]
    Breather(#[from] BreatherError),
    /// No orbit of a structure there.
    #[error(transparent)]
    Structure(StructureOrbitError),
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

impl From<StructureOrbitError> for BranchError {
    fn from(error: StructureOrbitError) -> Self {
        match error {
            StructureOrbitError::Stopped(stopped) => Self::Breather(stopped.into()),
            error => Self::Structure(error),
        }
    }
}
