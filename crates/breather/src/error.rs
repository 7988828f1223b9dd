//! Outcomes that are not orbits.

use std::fmt;

use thiserror::Error;
use vibrochain_lattice::{ParameterError, Resonance, Short};

/// Why a request could not be computed. "There is no such breather" is not among these: it is an answer, see
/// [`NoBreather`].
#[derive(Debug, Clone, PartialEq, Error)]
pub enum BreatherError {
    /// A parameter is outside its range.
    #[error(transparent)]
    Parameter(#[from] ParameterError),
    /// A harmonic of the motion meets a mode of the ring, or the force meets the uniform mode.
    #[error(transparent)]
    Resonance(#[from] Resonance),
    /// The fastest mode swings so often in a period that following every mass is out of reach.
    #[error(
        "too stiff to be checked: the fastest motion needs {windows:e} windows a period, the limit is {limit:e}; raise omega or lower gamma1 and gamma2"
    )]
    TooStiff {
        /// Windows needed.
        windows: f64,
        /// Windows allowed.
        limit: f64,
    },
    /// An impact of a given word is not possible.
    #[error("impact {index}: {what}")]
    Impact {
        /// Position in the list of impacts.
        index: usize,
        /// What is wrong with it.
        what: &'static str,
    },
    /// Newton's method does not lead from a given word to an orbit.
    #[error(
        "no orbit found near the given impacts: Newton's method leaves a violation of {violation:e} (relative to the terms of the conditions at the impacts); start nearer to an orbit"
    )]
    NotConverged {
        /// The largest violation left.
        violation: f64,
    },
}

/// Why a family has no orbit at a point.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(tag = "kind", rename_all = "kebab-case")
)]
pub enum NoBreather {
    /// Inelastic impacts and no force: every impact loses energy, nothing brings it back.
    LossWithoutForce,
    /// The family lives under a force only.
    NeedsForce,
    /// γ₁ = 0 and a word with net impulse: nothing would hold the ring in place.
    NetImpulse,
    /// The force is below the least one, given here, that sustains the family at this point.
    ForceTooWeak {
        /// The least amplitude.
        threshold: f64,
    },
    /// No phase of the force meets the conditions at the impacts.
    NoPhase,
    /// The conditions at the impacts are singular: the two impacts do not determine their impulses.
    Singular,
    /// Words are not searched for: they are given by their impacts ([`crate::Orbit::from_impulses`]).
    NotSearched,
}

impl fmt::Display for NoBreather {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::LossWithoutForce => {
                write!(
                    f,
                    "impacts lose energy (restitution < 1) and no force restores it: give an amplitude or restitution 1"
                )
            }
            Self::NeedsForce => write!(f, "this family exists under a force only: give amplitude and restitution"),
            Self::NetImpulse => {
                write!(
                    f,
                    "gamma1 = 0 leaves the ring free to drift and impacts on one side push it away: no periodic orbit"
                )
            }
            Self::ForceTooWeak { threshold } => {
                write!(f, "the force is too weak: this family needs an amplitude of at least {}", Short(*threshold))
            }
            Self::NoPhase => write!(f, "no phase of the force meets the conditions at the impacts"),
            Self::Singular => write!(f, "the conditions at the impacts are singular here"),
            Self::NotSearched => write!(f, "words of impacts are not searched for: give the impacts"),
        }
    }
}
