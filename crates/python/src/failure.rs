//! What cannot be answered, as an exception of its kind.

use std::io::ErrorKind;
use std::path::{Path, PathBuf};

use pyo3::exceptions::{PyFileNotFoundError, PyTypeError, PyValueError};
use pyo3::prelude::*;
use vibrochain_breather::{BranchError, BreatherError, WordError};
use vibrochain_eventsim::StateError;
use vibrochain_floquet::{CurveError, FloquetError, LocateError};
use vibrochain_lattice::{ParameterError, Resonance, StructureError};
use vibrochain_maps::error::MapError;
use vibrochain_plot::PlotError;

mod raised {
    use pyo3::import_exception;

    import_exception!(vibrochain._errors, IllConditionedError);
    import_exception!(vibrochain._errors, NoBreatherError);
    import_exception!(vibrochain._errors, NotConvergedError);
    import_exception!(vibrochain._errors, RequestError);
    import_exception!(vibrochain._errors, ResonanceError);
    import_exception!(vibrochain._errors, TooLargeError);
    import_exception!(vibrochain._errors, VibrochainError);
}

/// A failure, away from Python until it is raised.
#[derive(Debug)]
pub(crate) enum Failure {
    Request(String),
    Resonance(Resonance),
    NoBreather(String),
    NotConverged(String),
    IllConditioned(String),
    TooLarge(String),
    /// There is no such file.
    NoFile(PathBuf),
    Other(String),
}

/// ENOENT, the same on all systems.
const NO_FILE: i32 = 2;

impl Failure {
    /// Refuses the path of a file that is not there.
    pub(crate) fn unless_there(path: &Path) -> Result<(), Self> {
        match path.metadata() {
            Err(error) if error.kind() == ErrorKind::NotFound => Err(Self::NoFile(path.to_owned())),
            _ => Ok(()),
        }
    }

    pub(crate) fn request(message: impl Into<String>) -> Self {
        Self::Request(message.into())
    }
}

impl From<Failure> for PyErr {
    fn from(failure: Failure) -> Self {
        match failure {
            Failure::Request(message) => raised::RequestError::new_err(message),
            Failure::Resonance(resonance) => raised::ResonanceError::new_err((
                resonance.to_string(),
                resonance.harmonic,
                resonance.mode,
                resonance.frequency,
                resonance.distance,
            )),
            Failure::NoBreather(message) => raised::NoBreatherError::new_err(message),
            Failure::NotConverged(message) => raised::NotConvergedError::new_err(message),
            Failure::IllConditioned(message) => raised::IllConditionedError::new_err(message),
            Failure::TooLarge(message) => raised::TooLargeError::new_err(message),
            // As `open` has it: number, words, name.
            Failure::NoFile(path) => {
                PyFileNotFoundError::new_err((NO_FILE, "there is no such file", path.into_os_string()))
            }
            Failure::Other(message) => raised::VibrochainError::new_err(message),
        }
    }
}

/// A message alone is about a request.
impl From<String> for Failure {
    fn from(message: String) -> Self {
        Self::Request(message)
    }
}

/// What is wrong with a request, whatever it is.
macro_rules! requests {
    ($($error:ty),*) => {
        $(impl From<$error> for Failure {
            fn from(error: $error) -> Self {
                Self::Request(error.to_string())
            }
        })*
    };
}

requests!(ParameterError, WordError, StateError, PlotError);

impl From<Resonance> for Failure {
    fn from(error: Resonance) -> Self {
        Self::Resonance(error)
    }
}

impl From<BreatherError> for Failure {
    fn from(error: BreatherError) -> Self {
        let message = error.to_string();
        match error {
            BreatherError::Resonance(resonance) => resonance.into(),
            BreatherError::Structure(StructureError::Resonance { .. }) => Self::IllConditioned(message),
            BreatherError::LossWithoutLoad
            | BreatherError::Unbalanced
            | BreatherError::Unfelt
            | BreatherError::Singular => Self::NoBreather(message),
            BreatherError::TooStiff { .. } | BreatherError::LongFlight { .. } => Self::TooLarge(message),
            BreatherError::Undecided { .. }
            | BreatherError::NotConverged { .. }
            | BreatherError::OtherUnknowns
            | BreatherError::Structure(StructureError::NotConverged) => Self::NotConverged(message),
            BreatherError::Stopped(_) => Self::Other(message),
            _ => Self::Request(message),
        }
    }
}

impl From<FloquetError> for Failure {
    fn from(error: FloquetError) -> Self {
        let message = error.to_string();
        match error {
            FloquetError::Breather(breather) => breather.into(),
            FloquetError::Grazing { .. } => Self::IllConditioned(message),
            FloquetError::NotConverged { .. } | FloquetError::Uncounted(_) => Self::NotConverged(message),
            FloquetError::TooManyModes { .. } | FloquetError::TooLarge { .. } => Self::TooLarge(message),
        }
    }
}

impl From<BranchError> for Failure {
    fn from(error: BranchError) -> Self {
        match error {
            BranchError::Breather(breather) => breather.into(),
            BranchError::NoConvergence | BranchError::Family => Self::NotConverged(error.to_string()),
            BranchError::Model(message) => Self::Request(message),
        }
    }
}

impl From<LocateError> for Failure {
    fn from(error: LocateError) -> Self {
        match error {
            LocateError::Floquet(floquet) => floquet.into(),
            LocateError::Branch(branch) => branch.into(),
            LocateError::Stopped => Self::Other(error.to_string()),
            LocateError::Range { .. }
            | LocateError::Short { .. }
            | LocateError::NoForce { .. }
            | LocateError::NoMultiplier => Self::Request(error.to_string()),
        }
    }
}

impl From<CurveError> for Failure {
    fn from(error: CurveError) -> Self {
        match error {
            CurveError::Branch(branch) => branch.into(),
            CurveError::NotThere(_) => Self::NotConverged(error.to_string()),
            CurveError::Outside { .. }
            | CurveError::Same(_)
            | CurveError::NoLoad(_)
            | CurveError::Numbers(_)
            | CurveError::Tolerance(_) => Self::Request(error.to_string()),
        }
    }
}

impl From<MapError> for Failure {
    fn from(error: MapError) -> Self {
        match error {
            MapError::Request(message) => Self::Request(message),
            other => Self::Other(other.to_string()),
        }
    }
}

/// A whole number that fits none of ours is out of range like any other; what is no number at all is for Python to say.
pub(crate) fn whole(name: &str, value: &Bound<'_, PyAny>, least: i64, most: i64) -> PyResult<i64> {
    // Within the range, so that it fits.
    within(name, value, least.into(), most.into()).map(|number| number as i64)
}

/// The same from 0 to 2⁶⁴ − 1.
pub(crate) fn natural(name: &str, value: &Bound<'_, PyAny>) -> PyResult<u64> {
    within(name, value, 0, u64::MAX.into()).map(|number| number as u64)
}

fn within(name: &str, value: &Bound<'_, PyAny>, least: i128, most: i128) -> PyResult<i128> {
    let number = match value.extract::<i128>() {
        Ok(number) => Some(number),
        Err(error) if error.is_instance_of::<PyTypeError>(value.py()) => {
            let value = value.repr().map_or_else(|_| "it".to_owned(), |text| text.to_string());
            let message = format!("{name} = {value} is no whole number: give one from {least} to {most}");
            return Err(PyTypeError::new_err(message));
        }
        Err(_) => None,
    };
    number.filter(|number| (least..=most).contains(number)).ok_or_else(|| {
        let value = value.str().map_or_else(|_| "it".to_owned(), |text| text.to_string());
        Failure::request(format!("{name} = {value} is out of range: give a whole number from {least} to {most}")).into()
    })
}

/// What Python says of an argument, with the argument's name.
pub(crate) fn named_error(name: &str, error: PyErr, py: Python<'_>) -> PyErr {
    let said = format!("{name}: {}", error.value(py));
    if error.is_instance_of::<PyTypeError>(py) {
        PyTypeError::new_err(said)
    } else if error.is_instance_of::<PyValueError>(py) {
        Failure::request(said).into()
    } else {
        error
    }
}

/// The thing of that name among `known`.
pub(crate) fn named<T: Copy>(
    what: &str,
    text: &str,
    known: impl IntoIterator<Item = (&'static str, T)>,
) -> Result<T, Failure> {
    let known: Vec<_> = known.into_iter().collect();
    known.iter().find(|(name, _)| *name == text).map(|(_, value)| *value).ok_or_else(|| {
        let names: Vec<String> = known.iter().map(|(name, _)| format!("{name:?}")).collect();
        Failure::request(format!("{what} = {text:?} is unknown: give one of {}", names.join(", ")))
    })
}
