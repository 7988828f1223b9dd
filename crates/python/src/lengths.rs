//! Sequences from Python. Their lengths are looked at before their items: a range of any length is a sequence, too.

use numpy::PyArrayDyn;
use pyo3::conversion::FromPyObjectOwned;
use pyo3::exceptions::{PyOverflowError, PyTypeError};
use pyo3::prelude::*;
use pyo3::types::{PyList, PyString, PyTuple};

use vibrochain_maps::text::clipped;

use crate::failure::{Failure, named_error};

/// The most numbers of one array: 8 GB.
const MOST_NUMBERS: usize = 1_000_000_000;

/// The most items of a sequence that is no array. A list of so many numbers takes 400 MB, and NumPy makes one of any sequence.
const MOST_ITEMS: usize = 10_000_000;

/// Lists in lists: NumPy has no more dimensions.
const DEEPEST: usize = 64;

/// The items of a sequence of at most `most`.
pub(crate) fn items<'py>(name: &str, value: &Bound<'py, PyAny>, most: usize) -> PyResult<Vec<Bound<'py, PyAny>>> {
    let length = length(value)
        .filter(|_| !value.is_instance_of::<PyString>())
        .ok_or_else(|| PyTypeError::new_err(format!("{name} is {}: give a sequence{}", kind(value), as_one(value))))?;
    ensure!(
        length <= most,
        Failure::request(format!("{name}: {} items are too many: give at most {most}", told(length))).into()
    );
    // No more than it says it has.
    value.try_iter()?.take(length).collect()
}

/// The items of a sequence that one function of the package hands to another. As a `Vec` pyo3 would make room for as many as the sequence says to
/// have before it asks for the first, and a range of any length ends the process.
pub(crate) struct Items<T>(pub(crate) Vec<T>);

impl<'py, T: FromPyObjectOwned<'py>> FromPyObject<'_, 'py> for Items<T> {
    type Error = PyErr;

    fn extract(value: Borrowed<'_, 'py, PyAny>) -> PyResult<Self> {
        let items = items("a list", &value, MOST_ITEMS)?;
        Ok(Self(items.iter().map(|item| item.extract().map_err(Into::into)).collect::<PyResult<_>>()?))
    }
}

/// Numbers in an array of any shape.
pub(crate) fn numbers<'py>(name: &str, value: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
    Ok(_numbers(name, value, "float64")?.cast_into()?)
}

/// The same for Python, of any type of numbers.
#[pyfunction]
#[pyo3(signature = (name, value, dtype = "float64"))]
pub(crate) fn _numbers<'py>(name: &str, value: &Bound<'py, PyAny>, dtype: &str) -> PyResult<Bound<'py, PyAny>> {
    let count = count(value, 0);
    let most = if is_array(value) { MOST_NUMBERS } else { MOST_ITEMS };
    if count > most {
        let count = told(count);
        let more = if is_array(value) { "" } else { ", more in a NumPy array" };
        return Err(Failure::request(format!("{name}: {count} numbers are too many: give at most {most}{more}")).into());
    }
    let py = value.py();
    let array = py.import("numpy")?.call_method1("asarray", (value, dtype));
    array.map_err(|error| named_error(name, error, py))
}

/// The items of a sequence for Python.
#[pyfunction]
pub(crate) fn _items<'py>(name: &str, value: &Bound<'py, PyAny>) -> PyResult<Vec<Bound<'py, PyAny>>> {
    items(name, value, MOST_ITEMS)
}

/// Room for so many numbers.
pub(crate) fn room<T>(count: Option<usize>) -> Result<Vec<T>, Failure> {
    let mut values = Vec::new();
    match count {
        Some(count) if count <= MOST_NUMBERS && values.try_reserve_exact(count).is_ok() => Ok(values),
        _ => Err(Failure::TooLarge(format!(
            "an array of {} numbers does not fit: give fewer times or sites, at most {MOST_NUMBERS} numbers in all",
            count.map_or_else(|| "too many".to_owned(), |count| count.to_string())
        ))),
    }
}

/// How long a sequence is; `usize::MAX` if Python cannot say it, none if it is no sequence.
fn length(value: &Bound<'_, PyAny>) -> Option<usize> {
    match value.len() {
        Ok(length) => Some(length),
        Err(error) => error.is_instance_of::<PyOverflowError>(value.py()).then_some(usize::MAX),
    }
}

fn told(length: usize) -> String {
    if length == usize::MAX { "endless".to_owned() } else { length.to_string() }
}

fn kind(value: &Bound<'_, PyAny>) -> String {
    value.get_type().name().map_or_else(|_| "something else".to_owned(), |name| format!("of type {name}"))
}

/// A text as the one item of a list, which it was meant to be.
fn as_one(value: &Bound<'_, PyAny>) -> String {
    let text = value.cast::<PyString>().ok().and_then(|text| text.extract::<String>().ok());
    text.map_or(String::new(), |text| format!(", as in [{:?}]", clipped(&text, 40)))
}

/// How many numbers there are in an array, and whether it is one.
fn size(value: &Bound<'_, PyAny>) -> Option<usize> {
    let is_array = value.hasattr("ndim").unwrap_or(false);
    is_array.then(|| value.getattr("size").ok()?.extract().ok()).flatten()
}

fn is_array(value: &Bound<'_, PyAny>) -> bool {
    size(value).is_some()
}

/// How many numbers NumPy would make of it, or more than may be.
fn count(value: &Bound<'_, PyAny>, depth: usize) -> usize {
    if let Some(size) = size(value) {
        return size;
    }
    let Some(length) = length(value).filter(|_| !value.is_instance_of::<PyString>()) else { return 1 };
    let is_nested = value.is_instance_of::<PyList>() || value.is_instance_of::<PyTuple>();
    if !is_nested || length > MOST_ITEMS || depth == DEEPEST {
        return length;
    }
    let Ok(all) = value.try_iter() else { return length };
    let mut sum: usize = 0;
    for item in all.flatten() {
        sum = sum.saturating_add(count(&item, depth + 1));
        if sum > MOST_ITEMS {
            break;
        }
    }
    sum
}
