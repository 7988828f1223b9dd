//! Multipliers of orbits of any linear structure with stops, by J(z), and what they say.

pub(crate) mod multipliers;
mod stability;

pub use multipliers::BlochProblem;
pub(crate) use stability::{multipliers, participating_multipliers};
