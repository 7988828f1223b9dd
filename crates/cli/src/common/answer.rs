//! Answers in JSON: what those of several commands have in common.

use serde::Serialize;
use serde_json::{Map, Value};

use crate::common::error::CliError;

/// An answer as `--json` prints it.
///
/// # Errors
/// [`CliError::Computation`] of a value that JSON cannot hold.
pub(crate) fn printed(answer: &impl Serialize) -> Result<String, CliError> {
    let text = serde_json::to_string_pretty(answer).map_err(|error| CliError::Computation(error.to_string()))?;
    Ok(text + "\n")
}

/// Keys with values, in this order.
pub(crate) fn object<const N: usize>(keys: [(&str, Value); N]) -> Map<String, Value> {
    keys.map(|(key, value)| (key.to_owned(), value)).into_iter().collect()
}
