//! The extreme corners of the parameters, each answer set against many digits: what is promised, what is delivered, or
//! which error is given.
//!
//! | module | holds |
//! |---|---|
//! | `checks` | one quantity at one point against the truth |
//! | [`cases`] | the corners |
//! | [`draws`] | random points |
//! | `report` | their tables |

pub mod cases;
mod checks;
pub mod draws;
pub(crate) mod report;

pub(crate) use checks::worse;
pub use checks::{Depth, Row, Spectra, check_kernels, check_orbits, check_profile, check_simulation, check_uncoupled};
