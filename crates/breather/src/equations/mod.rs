//! Equations of impacts: how they move with an orbit's unknowns, and how perturbations pass through them.
//!
//! | module | holds |
//! |---|---|
//! | `bloch` | J(z): the linearised equations with a Bloch factor |
//! | `slopes` | how a contact at an impact moves with impulses, times and the phase |
//! | `system` | a Jacobian and its inverse, scaled |
//! | `linear`, `elimination` | small dense matrices |

mod bloch;
mod elimination;
pub mod linear;
pub(crate) mod slopes;
mod system;

pub use bloch::{BlochEquations, LinearImpact, ShapeErrors, Shift};
pub(crate) use system::System;
