//! What every answer must be like, whatever was asked.

use std::fmt::Write as _;
use std::path::Path;

use serde_json::Value;

/// One run's result.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Outcome {
    pub(crate) code: u8,
    pub(crate) out: String,
    /// The error, or what clap prints instead of an answer.
    pub(crate) message: String,
}

/// Keys of JSON answers whose value may be missing; errors are where no bound is known, and the amplitude where the force
/// is a list.
const OPTIONAL: [&str; 25] = [
    "bare_signature",
    "amplitude",
    "residual",
    "phi",
    "psi",
    "margin",
    "obstruction",
    "mechanism",
    "reason",
    "stability",
    "title",
    "revision",
    "threshold",
    "resolution",
    "impulse_error",
    "time_error",
    // Of located events that nothing branches off from.
    "branching",
    // How a list is complete, if it is.
    "by",
    // Of conservative orbits alone, and where rounding leaves them.
    "modes",
    "collision",
    "own_mode",
    "signature",
    "residue",
    "dressed",
    "detuning",
];

/// No word of it is a number that is none.
fn unfit_number(text: &str) -> Option<&str> {
    let words = text.split(|c: char| !c.is_alphanumeric() && c != '-' && c != '_');
    words
        .map(|word| word.trim_start_matches('-'))
        .find(|word| ["nan", "inf", "infinity"].contains(&word.to_lowercase().as_str()))
}

fn missing(value: &Value, path: &str, complaints: &mut String) {
    match value {
        Value::Object(map) => {
            for (key, value) in map {
                if value.is_null() && !OPTIONAL.contains(&key.as_str()) {
                    let _ = writeln!(complaints, "{path}.{key} is null");
                }
                if key == "stability" && value.is_null() && !map.contains_key("stability_error") {
                    let _ = writeln!(complaints, "{path}.stability is null without a reason");
                }
                missing(value, &format!("{path}.{key}"), complaints);
            }
        }
        Value::Array(list) => {
            for (i, value) in list.iter().enumerate() {
                if value.is_null() {
                    let _ = writeln!(complaints, "{path}[{i}] is null");
                }
                missing(value, &format!("{path}[{i}]"), complaints);
            }
        }
        _ => {}
    }
}

/// What is wrong with an outcome; empty if nothing is. `stopped` tells whether the run was told to stop.
pub(crate) fn complaints(outcome: &Outcome, stopped: bool) -> String {
    let mut complaints = String::new();
    let mut complain = |text: &str| complaints.push_str(&format!("{text}\n"));
    match outcome.code {
        0 => {}
        1..=3 => {
            let message = outcome.message.trim();
            if message.trim_start_matches("error:").trim().len() < 8 {
                complain("an exit code without a message");
            }
            // A wrong value of the request is quoted as it was given; a computation quotes numbers.
            if outcome.code != 2
                && let Some(word) = unfit_number(message)
            {
                complain(&format!("`{word}` in a message"));
            }
        }
        130 if stopped => {}
        code => complain(&format!("exit code {code}")),
    }
    if outcome.code == 2 && !outcome.out.is_empty() {
        complain("an answer to a wrong request");
    }
    if let Some(word) = unfit_number(&outcome.out) {
        complain(&format!("`{word}` in an answer"));
    }
    if outcome.out.starts_with('{') {
        match serde_json::from_str(&outcome.out) {
            Ok(value) => missing(&value, "", &mut complaints),
            Err(error) => complaints.push_str(&format!("not JSON: {error}\n")),
        }
    }
    complaints
}

/// What is wrong with a file a run has left.
pub(crate) fn file_complaints(path: &Path) -> String {
    let Ok(text) = std::fs::read_to_string(path) else { return String::new() };
    let mut complaints = String::new();
    if path.extension().is_some_and(|extension| extension == "json") {
        match serde_json::from_str(&text) {
            Ok(value) => missing(&value, "", &mut complaints),
            Err(error) => complaints.push_str(&format!("{}: not JSON: {error}\n", path.display())),
        }
    } else if let Some(word) = unfit_number(&text) {
        complaints.push_str(&format!("`{word}` in {}\n", path.display()));
    }
    complaints
}
