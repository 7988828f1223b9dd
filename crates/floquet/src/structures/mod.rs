//! Orbits of any linear structure with stops: their multipliers, their branches, and where these bifurcate, all by J(z).
//!
//! | module | holds |
//! |---|---|
//! | `stability` | all multipliers, and what they say |
//! | `ends` | the event at which a branch comes to simpler orbits |
//! | `seen` | what is seen at a point, and what that tells of a step |
//! | `diagram` | a branch with its events, and the branches that leave it |
//! | `switch` | at which events they do |
//! | `curve` | an event followed through a window of two numbers |

mod curve;
mod diagram;
mod ends;
mod seen;
mod stability;
mod switch;

pub use curve::{StructureCurve, StructureWindow, structure_curve};
pub use diagram::{StructureCourse, structure_branch, structure_diagram};
pub use stability::{structure_stability, structure_verdict, structure_verdict_within};
