//! Answers in JSON: what those of several commands have in common.

use serde::Serialize;
use serde_json::Value;
use vibrochain_breather::Completeness;
use vibrochain_floquet::Verdict;
use vibrochain_lattice::Short;

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

/// An estimated error for people: from 1 on, or without bound, nothing is known.
pub(crate) fn estimate(error: f64) -> String {
    if error < 1.0 { format!("{error:.0e}") } else { "unknown".to_owned() }
}

/// A verdict for people.
pub(crate) fn told_verdict(verdict: &Verdict) -> String {
    let how = match verdict.mechanism {
        Some(mechanism) => format!("unstable ({})", mechanism.name()),
        None if verdict.undecided && !verdict.resolution.is_finite() => {
            return format!("undecided (no bound of its error is known): spectral radius {}", verdict.spectral_radius);
        }
        None if verdict.undecided => "undecided (closer to the border than its own error)".to_owned(),
        None => "stable".to_owned(),
    };
    // Structure puts it on the circle exactly, or the eigenvalue has an error.
    let error = match verdict.resolution {
        0.0 => String::new(),
        resolution => format!(" ± {}", estimate(resolution)),
    };
    format!("{how}: spectral radius {}{error}", verdict.spectral_radius)
}

/// Writes for people what is known of a list of orbits: how many it holds, or why it holds none; whether these are all; which places the search
/// has left open.
pub(crate) fn told_list(known: Completeness, periods: Option<[f64; 2]>, [count, physical]: [usize; 2]) -> String {
    let plural = |count: usize| if count == 1 { "" } else { "s" };
    // Where nothing shows that there is none, none was found.
    let none = if known.is_established() { "none" } else { "none was found" };
    let of_periods = periods.map_or_else(String::new, |[from, to]| {
        format!("; periods are unknown here, and searched from {} to {}", Short(from), Short(to))
    });
    let mut lines = vec![
        match known.reason() {
            Some(reason) => format!("{none}: {reason}"),
            None => format!("{count} solution{}, {physical} physical", plural(count)),
        },
        format!("the list is {known}{of_periods}"),
    ];
    let (unresolved, exhausted) = known.open();
    if unresolved > 0 {
        lines.push(format!("{unresolved} place{} where two more may have merged: next to a fold", plural(unresolved)));
    }
    if exhausted > 0 {
        lines.push(match known {
            Completeness::Followed { .. } => {
                format!("{exhausted} combinations of the masses' orbits and phases were not tried, or not followed to an end")
            }
            _ => format!("the search for solutions was cut short ({exhausted} intervals left): the list may be incomplete"),
        });
    }
    lines.iter().map(|line| format!("{line}\n")).collect()
}
