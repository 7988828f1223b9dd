//! What every answer must be like, whatever was asked.

use std::path::Path;

use vibrochain_testkit::checked;

/// One run's result.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Outcome {
    pub(crate) code: u8,
    pub(crate) out: String,
    /// The error, or what clap prints instead of an answer.
    pub(crate) message: String,
}

/// No word of it is a number that is none.
fn unfit_number(text: &str) -> Option<&str> {
    let words = text.split(|c: char| !c.is_alphanumeric() && c != '-' && c != '_');
    words
        .map(|word| word.trim_start_matches('-'))
        .find(|word| ["nan", "inf", "infinity"].contains(&word.to_lowercase().as_str()))
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
    // A schema is an answer in JSON that names none.
    if outcome.out.starts_with('{')
        && !outcome.out.contains("json-schema.org")
        && let Err(error) = checked(&outcome.out)
    {
        complaints.push_str(&format!("{error}\n"));
    }
    complaints
}

/// What is wrong with a file a run has left.
pub(crate) fn file_complaints(path: &Path) -> String {
    let Ok(text) = std::fs::read_to_string(path) else { return String::new() };
    let mut complaints = String::new();
    if path.extension().is_some_and(|extension| extension == "json") {
        if let Err(error) = checked(&text) {
            complaints.push_str(&format!("{}: {error}\n", path.display()));
        }
    } else if let Some(word) = unfit_number(&text) {
        complaints.push_str(&format!("`{word}` in {}\n", path.display()));
    }
    complaints
}
