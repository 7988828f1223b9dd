//! Where and why a branch of a word ends.

use std::fmt;

use vibrochain_lattice::{Layout, Parameter, Resonance};

/// What ends a branch.
#[derive(Debug, Clone, PartialEq)]
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
    /// Impulses grow beyond any bound: the barrier is out of reach of what they drive, as where χ₂ of the masses that hit vanishes.
    Unbounded,
    /// It could not be followed farther.
    Lost,
    /// The search had no more work to spend on it.
    Unfinished,
}

impl End {
    /// Whether this is what ends the branch, and not the search: beyond it there is none.
    pub(crate) fn is_known(&self) -> bool {
        !matches!(self, Self::Lost | Self::Unfinished)
    }
}

/// Where a branch that was followed from masses without coupling ended.
#[derive(Debug, Clone, PartialEq)]
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
            End::Unbounded => "impulses that grow without bound".to_owned(),
            End::Lost => "an event that could not be told".to_owned(),
            End::Unfinished => "the limit on the work of one search, before any event".to_owned(),
        };
        format!("{by} at {} = {}", self.coupling, self.value)
    }
}

impl fmt::Display for Ended {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.told(&Layout::ONE_ROW))
    }
}
