//! The Python package vibrochain: values of the library's crates as Python values. It has no formula of its own.
//!
//! | module | holds |
//! |---|---|
//! | `params`, `model` | `Chain`, `Force`, `Model` |
//! | `orbits` | `Breathers`, `Orbit`, `Impact` |
//! | `answers` | `Admissibility`, `Condition`, `Stability` |
//! | `call` | long calls: without the interpreter's lock, interruptible |
//! | `failure` | errors as exceptions |

mod answers;
mod call;
mod failure;
mod model;
mod orbits;
mod params;

use pyo3::prelude::*;

/// What the package vibrochain is made of.
#[pymodule]
mod _vibrochain {
    #[pymodule_export]
    use crate::answers::{PyAdmissibility, PyCondition, PyObstruction, PyStability, PyVerdict};
    #[pymodule_export]
    use crate::model::model;
    #[pymodule_export]
    use crate::orbits::{PyBreathers, PyCompleteness, PyImpact, PyOrbit};
    #[pymodule_export]
    use crate::params::{PyChain, PyForce, PyModel, chain};
}
