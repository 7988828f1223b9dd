//! Zeros of functions whose poles are known, and what a zero says of excess.
//!
//! | module | holds |
//! |---|---|
//! | `aberth` | Ehrlich and Aberth's iteration for all zeros together |
//! | `rational` | 1 + Σ ρ/(z−p) + conj. and its slope |
//! | `excess` | |μ| − 1 from μ, or from ν = ½(μ + 1/μ) |
//! | `error` | [`SecularError`]: why there is no answer |

mod aberth;
mod error;
mod excess;
mod rational;

pub(crate) use aberth::{Aberth, Last, Meromorphic};
pub use error::SecularError;
pub(crate) use excess::{Nu, excess, modulus, outside};
pub(crate) use rational::{Rational, Value};
