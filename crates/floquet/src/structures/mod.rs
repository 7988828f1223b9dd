//! Orbits of any linear structure with stops: their multipliers, their branches, and where these bifurcate, all by J(z).
//!
//! | module | holds |
//! |---|---|
//! | `stability` | all multipliers, and what they say |
//! | `by_matrix` | multipliers where determinants do not count them |
//! | `watcher` | who looks at orbits along a branch or a curve |
//! | `ends`, `vanishing` | the events at which a branch comes to simpler orbits, and where all impulses vanish |
//! | `diagram` | a branch with its events, and the branches that leave it |
//! | `curve` | an event followed through a window of two numbers |

mod by_matrix;
mod curve;
mod diagram;
mod ends;
mod stability;
mod vanishing;
mod watcher;

pub use curve::{StructureCurve, StructureWindow, structure_curve};
pub use diagram::{StructureCourse, structure_diagram};
pub use stability::{StructureMultipliers, structure_stability, structure_verdict};
