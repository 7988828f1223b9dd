//! Answers in JSON: what those of several commands have in common.

use serde::Serialize;
use vibrochain_breather::Family;
use vibrochain_floquet::End;
use vibrochain_lattice::Model;

use crate::common::error::CliError;

/// An answer as `--json` prints it.
///
/// # Errors
/// [`CliError::Computation`] of a value that JSON cannot hold.
pub(crate) fn printed(answer: &impl Serialize) -> Result<String, CliError> {
    let text = serde_json::to_string_pretty(answer).map_err(|error| CliError::Computation(error.to_string()))?;
    Ok(text + "\n")
}

/// The orbit from which a branch or a curve is followed.
#[derive(Serialize)]
pub(crate) struct StartAnswer<'a> {
    pub(crate) parameters: &'a Model,
    pub(crate) family: Family,
    /// Its number in the list of `mapgen orbit`, from 1.
    pub(crate) solution: usize,
}

/// Where and how the way along a parameter ended.
#[derive(Serialize)]
pub(crate) struct EndAnswer {
    value: f64,
    reason: &'static str,
    message: String,
}

impl EndAnswer {
    /// Of several ways; `message` tells in words how one ended.
    pub(crate) fn of<'a>(
        ends: impl IntoIterator<Item = &'a (f64, End)>,
        message: impl Fn(f64, &End) -> String,
    ) -> Vec<Self> {
        let answer = |&(value, ref end): &(f64, End)| Self { value, reason: end.name(), message: message(value, end) };
        ends.into_iter().map(answer).collect()
    }
}
