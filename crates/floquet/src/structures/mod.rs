//! Orbits of any linear structure with stops: their multipliers, their branches, and where these bifurcate, all by J(z).
//!
//! | module | holds |
//! |---|---|
//! | `stability` | all multipliers, and what they say |
//! | `watcher` | who looks at orbits along a branch or a curve |
//! | `ends` | the events at which a branch comes to simpler orbits |
//! | `diagram` | a branch with its events, and the branches that leave it |
//! | `curve` | an event followed through a window of two numbers |

mod curve;
mod diagram;
mod ends;
mod stability;
mod watcher;

pub use curve::{StructureCurve, StructureWindow, structure_curve};
pub use diagram::{StructureCourse, structure_diagram};
pub use stability::{StructureMultipliers, structure_stability, structure_verdict};
