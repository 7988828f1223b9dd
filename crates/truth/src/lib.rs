//! The quantities of the layers above in 57 digits or more: slow, separate, for checks.
//!
//! What `vibrochain-lattice`, `-breather` and `-floquet` compute in `f64` is computed here once more in multiprecision, by
//! the plainest formulas there are and without sharing code with them: only parameters come in (taken as exact), and an
//! `f64` orbit or multiplier as a starting point. No layer that computes depends on this crate.
//!
//! | name | what it is |
//! |---|---|
//! | [`Real`], [`Complex`] | numbers that carry their precision |
//! | [`Kernel`] | the periodic impulse response between any two masses, plain modal sum |
//! | [`TrueOrbit`] | the conditions at the impacts by Newton's method |
//! | [`TrueSpectrum`] | multipliers from the secular determinant |
//! | [`TrueStructureOrbit`] | the same of any structure with stops: orbit and multipliers by the exponential of its state matrix |
//!
//! Chains are dimensionless, see `vibrochain-lattice`; a structure has the units of its matrices.

mod binary64;
mod complex;
mod conditions;
mod direction;
mod error;
mod flight;
mod kernel;
mod linear;
mod operators;
mod orbit;
mod real;
mod root;
mod secular;
mod spectrum;
mod structure;

pub use complex::Complex;
pub use error::TruthError;
pub use kernel::{Jet, Kernel};
pub use orbit::{OrbitError, TrueImpact, TrueOrbit};
pub use real::Real;
pub use spectrum::TrueSpectrum;
pub use structure::{StructureErrors, StructureStart, TrueStructureImpact, TrueStructureOrbit};

/// Binary digits that serve most checks: 57 decimal digits.
pub const DEFAULT_BITS: usize = 192;
