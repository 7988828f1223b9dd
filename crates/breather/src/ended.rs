//! Where and why a branch of a word ends.

use std::fmt;

use vibrochain_lattice::Resonance;

/// What ends a branch.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize), serde(rename_all = "kebab-case"))]
pub enum End {
    /// It turns back in γ₂.
    Fold,
    /// An impact loses its velocity.
    Grazing {
        /// The mass.
        site: usize,
    },
    /// A harmonic of the orbit meets a mode.
    Resonance(Resonance),
    /// It could not be followed farther.
    Lost,
}

/// Where a branch that was followed from γ₂ = 0 ended.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
#[must_use]
pub struct Ended {
    /// The coupling.
    pub gamma2: f64,
    /// The event.
    pub by: End,
}

impl fmt::Display for Ended {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match &self.by {
            End::Fold => write!(f, "a fold")?,
            End::Grazing { site } => write!(f, "a grazing impact of site {site}")?,
            End::Resonance(resonance) => write!(f, "resonance of mode {}", resonance.mode)?,
            End::Lost => write!(f, "an event that could not be told")?,
        }
        write!(f, " at gamma2 = {}", self.gamma2)
    }
}
