//! Orbits and multipliers of any linear structure with stops, M q″ + C q′ + K q = s + Re Σ_j f_j e^{ijω(t+ψ)}, by its state alone.
//!
//! No modes, no impulse response: between impacts the state (q, q′) flies by the exponential of its matrix, so that any damping will do,
//! rigid modes, resonances and coinciding poles too. Entries of matrices and loads are taken as exact.
//!
//! | module | holds |
//! |---|---|
//! | `flow` | the exponential, with the loads' own rotation in the same matrix |
//! | `shooting` | the state that returns after a period with all impacts on their stops, by Newton's method |
//! | `orbit` | [`TrueStructureOrbit`] |
//! | `saltation` | the monodromy matrix |
//! | `multipliers` | spectral radius; single multipliers |

mod flow;
mod multipliers;
mod orbit;
mod saltation;
mod shooting;

pub use orbit::{StructureErrors, TrueStructureImpact, TrueStructureOrbit};
pub use shooting::StructureStart;
