//! The Python package vibrochain: values of the library's crates as Python values. It has no formula of its own.
//!
//! | module | holds |
//! |---|---|
//! | `params`, `model` | `Chain`, `Force`, `Model` |
//! | `orbits`, `breathers` | `Orbit`, `Impact`; `Breathers`, and how complete they are |
//! | `answers` | `Admissibility`, `Condition`, `Stability` |
//! | `simulation` | event-driven runs |
//! | `sweep`, `fates` | maps: the columns of a scene's cells; what becomes of their breathers |
//! | `events`, `branches`, `curves` | what happens as parameters vary |
//! | `borders` | all borders of a scene's window |
//! | `call` | long calls: without the interpreter's lock, interruptible |
//! | `failure` | errors as exceptions |

mod answers;
mod borders;
mod branches;
mod breathers;
mod call;
mod curves;
mod events;
mod failure;
mod fates;
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
    use crate::answers::{PyAdmissibility, PyCondition, PyObstruction, PyStability, PyVerdict};
    #[pymodule_export]
    use crate::borders::{_curves, PyBorder, PyBorders};
    #[pymodule_export]
    use crate::branches::{PyBranch, PyDiagram, branch};
    #[pymodule_export]
    use crate::breathers::{PyBreathers, PyCompleteness};
    #[pymodule_export]
    use crate::curves::{PyEventCurve, curve};
    #[pymodule_export]
    use crate::events::{PyBranchPoint, PyEnd, PyEvents, PyLocated, locate};
    #[pymodule_export]
    use crate::fates::_fate;
    #[pymodule_export]
    use crate::model::model;
    #[pymodule_export]
    use crate::orbits::{PyImpact, PyOrbit};
    #[pymodule_export]
    use crate::params::{PyChain, PyForce, PyModel, chain};
    #[pymodule_export]
    use crate::simulation::{_simulate, _start};
    #[pymodule_export]
    use crate::sweep::{_scene, _sweep};
}
