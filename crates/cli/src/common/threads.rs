//! Threads to compute on: as many as are asked for, or as there are cores.

use std::thread::available_parallelism;

use rayon::{ThreadPool, ThreadPoolBuilder};
use vibrochain_maps::numbers::whole;

use crate::common::error::CliError;

/// The most threads that may be asked for.
const MAX_THREADS: usize = 1024;

/// What other programs of this kind are told how many threads to take by.
pub(crate) const VARIABLE: &str = "RAYON_NUM_THREADS";

/// Reads --threads: below the limits and beyond them the same is told.
pub(crate) fn asked(text: &str) -> Result<usize, String> {
    let threads = whole::<i128>(text)?;
    let allowed = usize::try_from(threads).ok().filter(|threads| (1..=MAX_THREADS).contains(threads));
    allowed.ok_or_else(|| format!("out of range: give a whole number from 1 to {MAX_THREADS}"))
}

/// Threads of a process of its own, within the limit. Nothing is computed on any others: what the library would start by
/// itself has no limit, and where threads cannot be had it ends the process.
///
/// # Errors
/// [`CliError::Request`] for a number out of range, [`CliError::Computation`] if the system refuses.
pub fn threads(asked: Option<usize>) -> Result<ThreadPool, CliError> {
    let count = number(asked)?;
    ThreadPoolBuilder::new()
        .num_threads(count)
        .build()
        .map_err(|error| CliError::Computation(format!("cannot start {count} threads: {error}")))
}

/// How many threads those are.
///
/// # Errors
/// [`CliError::Request`] for a number out of range.
pub(crate) fn number(asked: Option<usize>) -> Result<usize, CliError> {
    count(asked, std::env::var(VARIABLE).ok().as_deref())
}

/// The number of cores that this process may use.
pub fn cores() -> usize {
    available_parallelism().map_or(1, usize::from)
}

/// How many threads: those asked for, those the environment says, or one a core.
fn count(asked: Option<usize>, variable: Option<&str>) -> Result<usize, CliError> {
    let refused = |name: &str, value: &str| {
        let range = format!("give a whole number from 1 to {MAX_THREADS}");
        CliError::Request(format!("{name} {value} is out of range: {range}"))
    };
    let allowed = |threads: &usize| (1..=MAX_THREADS).contains(threads);
    match (asked, variable.filter(|text| !matches!(*text, "" | "0"))) {
        (Some(threads), _) => Some(threads).filter(allowed).ok_or_else(|| refused("--threads", &threads.to_string())),
        (None, Some(text)) => text.trim().parse().ok().filter(allowed).ok_or_else(|| refused(VARIABLE, text)),
        (None, None) => Ok(cores().min(MAX_THREADS)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn threads_are_limited_whoever_asks() {
        assert_eq!(count(Some(3), Some("100000")).unwrap(), 3);
        assert_eq!(count(None, Some("5")).unwrap(), 5);
        for variable in [None, Some(""), Some("0")] {
            assert_eq!(count(None, variable).unwrap(), cores().min(MAX_THREADS));
        }
        for (asked, variable, told) in [
            (Some(0), None, "--threads 0 is out of range: give a whole number from 1 to 1024"),
            (Some(1025), Some("1"), "--threads 1025 is out of range"),
            (None, Some("100000"), "RAYON_NUM_THREADS 100000 is out of range"),
            (None, Some("-1"), "RAYON_NUM_THREADS -1 is out of range"),
            (None, Some("many"), "RAYON_NUM_THREADS many is out of range"),
        ] {
            let error = count(asked, variable).unwrap_err();
            assert!(error.exit_code() == 2 && error.to_string().contains(told), "{error}");
        }
    }
}
