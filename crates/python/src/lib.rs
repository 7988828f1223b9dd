//! The Python package vibrochain: values of the library's crates as Python values. It has no formula of its own.

// | file | holds |
// |---|---|
// | `params`, `model` | `Chain`, `Force`, `Model` |
// | `orbits`, `breathers` | `Orbit`, `Impact`; `Breathers`, and how complete they are; impact words |
// | `answers` | `Admissibility`, `Condition`, `Stability` |
// | `simulation` | event-driven runs |
// | `structures` | orbits of any linear structure |
// | `scenes` | scenes of chains and of structures |
// | `sweep`, `fates` | maps: the columns of a scene's cells; what becomes of their breathers |
// | `events`, `branches`, `curves` | what happens as parameters vary |
// | `borders` | all borders of a scene's window |
// | `call` | long calls: without the interpreter's lock, interruptible |
// | `lengths` | sequences, whose lengths are looked at first |
// | `pictures` | colours, words and drawings of pictures |
// | `pickle` | copies and pickles of all values |
// | `failure` | errors as exceptions |

// Its `ensure!` and `refuse!`.
#[macro_use]
extern crate vibrochain_maps;

mod answers;
mod borders;
mod branches;
mod breathers;
mod call;
mod curves;
mod events;
mod failure;
mod fates;
mod lengths;
mod model;
mod orbits;
mod params;
mod pickle;
mod pictures;
mod scenes;
mod simulation;
mod structures;
mod sweep;

use pyo3::prelude::*;

/// What the package vibrochain is made of.
#[pymodule]
mod _vibrochain {
    use pyo3::prelude::*;

    #[pymodule_export]
    use crate::answers::{_stability, PyAdmissibility, PyCondition, PyObstruction, PyStability, PyVerdict};
    #[pymodule_export]
    use crate::borders::{_curves, PyBorder, PyBorders};
    #[pymodule_export]
    use crate::branches::{PyBranch, PyDiagram, branch};
    #[pymodule_export]
    use crate::breathers::{_words, PyBreathers, PyCompleteness};
    #[pymodule_export]
    use crate::curves::{PyEventCurve, curve};
    #[pymodule_export]
    use crate::events::{PyBranchPoint, PyEnd, PyEvents, PyLocated, locate};
    #[pymodule_export]
    use crate::fates::_fate;
    #[pymodule_export]
    use crate::lengths::{_items, _numbers};
    #[pymodule_export]
    use crate::orbits::{PyImpact, PyOrbit};
    #[pymodule_export]
    use crate::params::{PyChain, PyForce, PyModel};
    #[pymodule_export]
    use crate::pickle::{_reduce, _restore};
    #[pymodule_export]
    use crate::pictures::{
        _branch_pane, _caption, _class_words, _curve_pane, _frequencies, _in_words, _map_svg, _modulus_axis,
        _orbit_pane, _run_pane, _structure_frequencies, _structure_pane, _style, _svg, PyPane,
    };
    #[pymodule_export]
    use crate::scenes::_scene;
    #[pymodule_export]
    use crate::simulation::{_simulate, _start};
    #[pymodule_export]
    use crate::structures::{_structure, _structure_along, _structure_motion};
    #[pymodule_export]
    use crate::sweep::_sweep;

    #[pymodule_init]
    fn init(module: &Bound<'_, PyModule>) -> PyResult<()> {
        module.add("__version__", crate::pickle::VERSION)?;
        crate::params::register(module.py())?;
        crate::pickle::register(module)
    }
}
