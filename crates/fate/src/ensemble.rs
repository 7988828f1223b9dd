//! What is asked of an ensemble of runs, checked.

use serde::{Deserialize, Serialize};
use thiserror::Error;
use vibrochain_lattice::Short;

/// The most runs from a breather.
const MAX_STARTS: u64 = 10_000;

/// The most periods of a run: a day of work for a hot ring of some twenty masses.
const MAX_PERIODS: u64 = 1_000_000_000;

/// The largest perturbation: half the gap. More is no perturbation.
const MAX_SIZE: f64 = 1.0;

/// Masses beyond which a run is no matter of an ensemble.
const MAX_SITES: usize = 10_000;

/// A number out of range: its name, its value, what is allowed.
#[derive(Debug, Clone, PartialEq, Error)]
#[error("{name} {value} is out of range: give {range}")]
pub struct OutOfRange {
    /// What it is called on the command line.
    pub name: &'static str,
    /// As it was given.
    pub value: String,
    /// What is allowed.
    pub range: String,
}

/// Periods that are looked at, at least: two of the longest breather's, whose first and last instants may be cut, and one more each.
const LEAST: u64 = 8;

/// Many runs from each breather.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Ensemble {
    /// Runs from each breather.
    pub starts: u64,
    /// Largest change of a displacement, or of a velocity over ω, at the start.
    #[serde(rename = "perturb")]
    pub size: f64,
    /// What all perturbations are drawn from.
    pub seed: u64,
    /// Periods of the force of each run.
    pub periods: u64,
    /// Share of them that is left out before the end is looked at.
    pub transient: f64,
    /// By how much impacts may differ and still repeat: times in periods, velocities in the fastest.
    pub tolerance: f64,
    /// By how much impacts must differ from the breather's before a run has left it, likewise.
    pub leave: f64,
    /// Whether contacts of a structure that share coordinates and hit at one instant do so in sequence, where a run cannot be completed otherwise.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub in_sequence: bool,
}

impl Default for Ensemble {
    fn default() -> Self {
        let (tolerance, leave) = (0.02, 0.1);
        Self { starts: 16, size: 1e-3, seed: 1, periods: 2000, transient: 0.5, tolerance, leave, in_sequence: false }
    }
}

impl Ensemble {
    /// Checks all of it, for lattices of so many masses.
    ///
    /// # Errors
    /// [`OutOfRange`].
    pub fn check(&self, sites: usize) -> Result<(), OutOfRange> {
        let wrong = |name, value: String, range: String| Err(OutOfRange { name, value, range });
        let Self { starts, size, periods, transient, tolerance, leave, .. } = *self;
        if !(1..=MAX_STARTS).contains(&starts) {
            return wrong("--starts", starts.to_string(), format!("a whole number from 1 to {MAX_STARTS}"));
        }
        if !(10..=MAX_PERIODS).contains(&periods) {
            return wrong("--periods", periods.to_string(), format!("a whole number from 10 to {MAX_PERIODS}"));
        }
        if !(0.0..=MAX_SIZE).contains(&size) {
            return wrong("--perturb", Short(size).to_string(), format!("a size from 0 to {MAX_SIZE}"));
        }
        if !(0.0..=0.95).contains(&transient) {
            return wrong("--transient", Short(transient).to_string(), "a share from 0 to 0.95".to_owned());
        }
        if periods - self.skipped() < LEAST {
            let least = (LEAST as f64 / (1.0 - transient)).ceil();
            let told = format!("at least {least}, or a smaller --transient than {}", Short(transient));
            return wrong("--periods", periods.to_string(), told);
        }
        for (name, value) in [("--tolerance", tolerance), ("--leave", leave)] {
            if !(value > 0.0 && value <= 0.5) {
                return wrong(name, Short(value).to_string(), "a part above 0 up to 0.5".to_owned());
            }
        }
        if sites > MAX_SITES {
            return wrong("sites", sites.to_string(), format!("at most {MAX_SITES} masses"));
        }
        Ok(())
    }

    /// Periods that are left out.
    #[must_use]
    pub fn skipped(&self) -> u64 {
        (self.transient * self.periods as f64) as u64
    }

    /// The seed of one start: a mixture of its place, so that no two of a map are related and none depends on another having been
    /// computed.
    #[must_use]
    pub fn seed_of(&self, cell: u64, breather: u64, start: u64) -> u64 {
        // Twice at the beginning, or the seed would cancel the cell of its own number.
        let seed = mixed(mixed(self.seed));
        [cell, breather, start].into_iter().fold(seed, |seed, number| mixed(seed ^ mixed(number)))
    }
}

/// The finaliser of SplitMix64 (Steele, Lea, Flood), of the next number.
fn mixed(number: u64) -> u64 {
    let mut z = number.wrapping_add(0x9e37_79b9_7f4a_7c15);
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

#[cfg(test)]
mod tests {
    use std::collections::HashSet;

    use super::*;

    #[test]
    fn every_start_has_a_seed_of_its_own() {
        let (one, two) = (Ensemble::default(), Ensemble { seed: 2, ..Ensemble::default() });
        let mut seen = HashSet::new();
        for ensemble in [one, two] {
            for cell in 0..40 {
                for breather in 0..3 {
                    seen.extend((0..30).map(|start| ensemble.seed_of(cell, breather, start)));
                }
            }
        }
        assert_eq!(seen.len(), 2 * 40 * 3 * 30);
    }

    #[test]
    fn what_is_out_of_range_is_told_with_what_is_not() {
        let fine = Ensemble::default();
        assert_eq!(fine.check(21), Ok(()));
        let bad = [
            (Ensemble { starts: 0, ..fine }, "--starts 0 is out of range: give a whole number from 1 to 10000"),
            (Ensemble { periods: 9, ..fine }, "--periods 9 is out of range: give a whole number from 10 to 1000000000"),
            (
                Ensemble { periods: 10, ..fine },
                "--periods 10 is out of range: give at least 16, or a smaller --transient than 0.5",
            ),
            (Ensemble { size: -1e-3, ..fine }, "--perturb -0.001 is out of range: give a size from 0 to 1"),
            (Ensemble { size: f64::NAN, ..fine }, "--perturb NaN is out of range: give a size from 0 to 1"),
            (Ensemble { transient: 1.0, ..fine }, "--transient 1 is out of range: give a share from 0 to 0.95"),
            (Ensemble { tolerance: 0.0, ..fine }, "--tolerance 0 is out of range: give a part above 0 up to 0.5"),
            (Ensemble { leave: 0.6, ..fine }, "--leave 0.6 is out of range: give a part above 0 up to 0.5"),
        ];
        for (ensemble, told) in bad {
            assert_eq!(ensemble.check(21).unwrap_err().to_string(), told);
        }
        assert_eq!(
            fine.check(10_001).unwrap_err().to_string(),
            "sites 10001 is out of range: give at most 10000 masses"
        );
    }
}
