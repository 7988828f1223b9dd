//! The Python package vibrochain: values of the library's crates as Python values. It has no formula of its own.
//!
//! | module | holds |
//! |---|---|
//! | `params`, `model` | `Chain`, `Force`, `Model` |
//! | `orbits` | `Breathers`, `Orbit`, `Impact` |
//! | `answers` | `Admissibility`, `Condition`, `Stability` |
//! | `sweep` | maps: the columns of a scene's cells |
//! | `along` | events, branches and curves as parameters vary |
//! | `simulation` | event-driven runs |
//! | `call` | long calls: without the interpreter's lock, interruptible |
//! | `failure` | errors as exceptions |

mod along;
mod answers;
mod call;
mod failure;
mod model;
mod orbits;
mod params;
mod simulation;
mod sweep;

use pyo3::prelude::*;

/// What the package vibrochain is made of.
#[pymodule]
mod _vibrochain {
    #[pymodule_export]
    use crate::along::{
        PyBranch, PyBranchPoint, PyDiagram, PyEnd, PyEventCurve, PyEvents, PyLocated, branch, curve, locate,
    };
    #[pymodule_export]
    use crate::answers::{PyAdmissibility, PyCondition, PyObstruction, PyStability, PyVerdict};
    #[pymodule_export]
    use crate::model::model;
    #[pymodule_export]
    use crate::orbits::{PyBreathers, PyCompleteness, PyImpact, PyOrbit};
    #[pymodule_export]
    use crate::params::{PyChain, PyForce, PyModel, chain};
    #[pymodule_export]
    use crate::simulation::{_simulate, _start};
    #[pymodule_export]
    use crate::sweep::{_scene, _sweep};
}
