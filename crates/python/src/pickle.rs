//! Pickles: every value as bytes (CBOR), to the last bit, so that it can be copied and sent to other processes.

use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyType};
use serde::{Deserialize, Serialize};

use crate::answers::{PyAdmissibility, PyCondition, PyObstruction, PyVerdict};
use crate::borders::{PyBorder, PyBorders};
use crate::branches::{PyBranch, PyDiagram};
use crate::breathers::{PyBreathers, PyCompleteness};
use crate::curves::PyEventCurve;
use crate::events::{PyBranchPoint, PyEnd, PyEvents, PyLocated};
use crate::failure::Failure;
use crate::orbits::{PyImpact, PyOrbit};
use crate::params::{PyChain, PyForce, PyModel};

/// Which version has written a pickle.
pub(crate) const VERSION: &str = env!("CARGO_PKG_VERSION");

/// Classes that have nothing but what serde writes.
macro_rules! pickled {
    ($($class:ident)*) => {
        #[derive(Serialize)]
        #[allow(clippy::enum_variant_names, reason = "as the classes are called")]
        enum Written<'a> {
            $($class(&'a $class)),*
        }

        #[derive(Deserialize)]
        #[allow(clippy::enum_variant_names, reason = "as the classes are called")]
        enum Read {
            $($class($class)),*
        }

        fn write(value: &Bound<'_, PyAny>) -> Option<Result<Vec<u8>, String>> {
            $(if let Ok(value) = value.cast_exact::<$class>() {
                let mut bytes = Vec::new();
                let written = ciborium::into_writer(&Written::$class(value.get()), &mut bytes);
                return Some(written.map(|()| bytes).map_err(|error| error.to_string()));
            })*
            None
        }

        fn read<'py>(py: Python<'py>, bytes: &[u8]) -> Result<PyResult<Bound<'py, PyAny>>, String> {
            Ok(match ciborium::from_reader(bytes).map_err(|error| error.to_string())? {
                $(Read::$class(value) => Bound::new(py, value).map(Bound::into_any)),*
            })
        }

        fn classes(py: Python<'_>) -> Vec<Bound<'_, PyType>> {
            vec![$(py.get_type::<$class>()),*]
        }
    };
}

pickled! {
    PyAdmissibility PyBorder PyBorders PyBranch PyBranchPoint PyBreathers PyChain PyCompleteness PyCondition PyDiagram PyEnd
    PyEventCurve PyEvents PyForce PyImpact PyLocated PyModel PyObstruction PyOrbit PyVerdict
}

/// What pickle asks for: a callable and its arguments.
#[pyfunction]
#[allow(clippy::type_complexity, reason = "that is what it asks for")]
pub(crate) fn _reduce<'py>(
    value: &Bound<'py, PyAny>,
) -> PyResult<(Bound<'py, PyAny>, (&'static str, Bound<'py, PyBytes>))> {
    let py = value.py();
    let bytes = write(value)
        .ok_or_else(|| PyTypeError::new_err("this is no value of vibrochain"))?
        .map_err(|error| Failure::Other(format!("cannot be pickled: {error}")))?;
    Ok((py.import("vibrochain._vibrochain")?.getattr("_restore")?, (VERSION, PyBytes::new(py, &bytes))))
}

/// The value of a pickle.
#[pyfunction]
pub(crate) fn _restore<'py>(py: Python<'py>, version: &str, bytes: &[u8]) -> PyResult<Bound<'py, PyAny>> {
    read(py, bytes).map_err(|error| {
        let message = format!(
            "this pickle of vibrochain {version} cannot be read by vibrochain {VERSION} ({error}): compute the value once more"
        );
        Failure::request(message)
    })?
}

/// Tells pickle, and copy, of all classes.
pub(crate) fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    let py = module.py();
    let (pickle, reduce) = (py.import("copyreg")?.getattr("pickle")?, module.getattr("_reduce")?);
    classes(py).into_iter().try_for_each(|class| pickle.call1((class, &reduce)).map(drop))
}
