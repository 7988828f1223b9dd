//! Where and why a branch of a word ends.

use std::fmt;

use vibrochain_lattice::{Layout, Parameter, Resonance};

/// What ends a branch.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize), serde(rename_all = "kebab-case"))]
pub enum End {
    /// It turns back.
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

/// Where a branch that was followed from masses without coupling ended.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
#[must_use]
pub struct Ended {
    /// The coupling that was being raised: γ₂, or γ₃ where γ₂ was reached.
    pub coupling: Parameter,
    /// Its value.
    pub value: f64,
    /// The event.
    pub by: End,
}

impl Ended {
    /// In words, with its mass as words of this lattice name it.
    #[must_use]
    pub fn told(&self, layout: &Layout) -> String {
        let by = match &self.by {
            End::Fold => "a fold".to_owned(),
            End::Grazing { site } => format!("a grazing impact of site {}", layout.name(*site)),
            End::Resonance(resonance) => format!("resonance of mode {}", resonance.mode),
            End::Lost => "an event that could not be told".to_owned(),
        };
        format!("{by} at {} = {}", self.coupling, self.value)
    }
}

impl fmt::Display for Ended {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.told(&Layout::ONE_ROW))
    }
}
