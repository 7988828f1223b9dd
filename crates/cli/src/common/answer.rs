//! Answers in JSON: what those of several commands have in common.

use serde::Serialize;
use serde_json::Value;

use crate::common::error::CliError;

/// An answer as `--json` prints it.
///
/// # Errors
/// [`CliError::Computation`] of a value that JSON cannot hold.
pub(crate) fn printed(answer: &impl Serialize) -> Result<String, CliError> {
    let text = serde_json::to_string_pretty(answer).map_err(|error| CliError::Computation(error.to_string()))?;
    Ok(text + "\n")
}

/// An object with the keys of another one behind its own.
pub(crate) fn joined(mut value: Value, more: Value) -> Value {
    if let (Value::Object(keys), Value::Object(more)) = (&mut value, more) {
        keys.extend(more);
    }
    value
}
