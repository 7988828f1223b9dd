//! Multipliers of orbits of any linear structure with stops, by J(z), and what they say.

mod stability;

pub(crate) use stability::participating_multipliers;
pub use stability::{StructureMultipliers, structure_stability, structure_verdict};
