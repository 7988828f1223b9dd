//! What an ensemble has come to, in a few lines for people, and as JSON.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use serde_json::{Map, Value, json};
use vibrochain_breather::Word;
use vibrochain_fate::{CellFates, End, Ensemble, From};
use vibrochain_lattice::Short;

use crate::common::schemas::FATE;
use crate::sweep::report::counted;
use vibrochain_maps::manifest::object;

/// Words of other breathers that people are told.
const SHOWN: usize = 8;

/// An exponent that is not known better than this is not compared.
const KNOWN: f64 = 1e-6;

/// Counts of all cells.
#[derive(Debug, Default)]
pub(crate) struct Totals {
    pub(crate) cells: u64,
    /// Cells with a breather to start from, and breathers.
    with: u64,
    breathers: u64,
    /// Of these, those that are none: runs from rest.
    at_rest: u64,
    ends: [u64; End::NAMES.len()],
    words: BTreeMap<Word, u64>,
    left: u64,
    /// Sum of the times to leave.
    leave: f64,
    /// Breathers whose exponent is measured to [`KNOWN`], and the largest difference from the one predicted.
    compared: u64,
    difference: f64,
}

impl Totals {
    pub(crate) fn add(&mut self, cell: &CellFates) {
        self.cells += 1;
        self.with += u64::from(!cell.breathers.is_empty());
        for breather in &cell.breathers {
            self.breathers += 1;
            self.at_rest += u64::from(breather.name == From::Rest.name());
            self.ends.iter_mut().zip(breather.ends).for_each(|(sum, count)| *sum += u64::from(count));
            for (word, count) in &breather.words {
                *self.words.entry(word.clone()).or_default() += u64::from(*count);
            }
            self.left += u64::from(breather.left);
            self.leave += breather.leave_time.map_or(0.0, |(mean, _)| mean * f64::from(breather.left));
            if let (Some(predicted), Some((measured, error))) = (breather.predicted, breather.measured)
                && error < KNOWN
            {
                self.compared += 1;
                self.difference = self.difference.max((measured - predicted).abs());
            }
        }
    }

    fn runs(&self) -> u64 {
        self.ends.iter().sum()
    }

    fn leave_time(&self) -> Option<f64> {
        (self.left > 0).then(|| self.leave / self.left as f64)
    }

    /// The words, the most frequent first.
    fn words(&self) -> Vec<(&Word, u64)> {
        let mut words: Vec<_> = self.words.iter().map(|(word, count)| (word, *count)).collect();
        words.sort_by_key(|(_, count)| std::cmp::Reverse(*count));
        words
    }

    /// For people. Writing to a String cannot fail.
    pub(crate) fn as_text(&self, grid: &str, ensemble: &Ensemble) -> String {
        let runs = self.runs();
        let mut out = String::new();
        let Ensemble { size, periods, seed, .. } = *ensemble;
        let start = match self.at_rest {
            0 => format!("{} with a breather to start from; {}", self.with, counted(self.breathers, "breather")),
            _ => "from rest".to_owned(),
        };
        let _ = writeln!(
            out,
            "{} ({grid}), {start}, {} of {periods} periods, perturbed by {} from seed {seed}",
            counted(self.cells, "cell"),
            counted(runs, "run"),
            Short(size)
        );
        for (name, &count) in End::NAMES.iter().zip(&self.ends).filter(|(_, count)| **count > 0) {
            let _ = writeln!(out, "  {name:<16} {count:>9}  {:5.1} %", 100.0 * count as f64 / runs as f64);
        }
        let words = self.words();
        if !words.is_empty() {
            let _ = writeln!(out, "  impact words of `periodic`, by runs");
        }
        for (word, count) in words.iter().take(SHOWN) {
            let _ = writeln!(out, "    {count:>9}  {word}");
        }
        if words.len() > SHOWN {
            let _ = writeln!(out, "    and {} other words", words.len() - SHOWN);
        }
        if let Some(time) = self.leave_time() {
            let _ = writeln!(out, "{} runs have left their breather, after {time:.1} periods in the mean", self.left);
        }
        if self.compared > 0 {
            let _ = writeln!(
                out,
                "exponents measured along {} of {} breathers differ from ln|μ|/T by at most {:.1e}",
                self.compared, self.breathers, self.difference
            );
        }
        out
    }

    /// As JSON, with `about`, which says what it is of.
    pub(crate) fn answer(&self, about: Map<String, Value>, ensemble: &Ensemble) -> Map<String, Value> {
        let ends = End::NAMES.iter().zip(self.ends).map(|(name, runs)| ((*name).to_owned(), json!(runs)));
        let words = self.words().into_iter().map(|(word, runs)| (word.to_string(), json!(runs)));
        let mut told = object([("schema", json!(FATE))]);
        told.extend(about);
        told.extend(object([
            ("ensemble", json!(ensemble)),
            ("cells", json!(self.cells)),
            ("cells_with_breather", json!(self.with)),
            ("breathers", json!(self.breathers)),
            ("runs", json!(self.runs())),
            ("ends", ends.collect()),
            ("words", words.collect()),
            ("left", json!(self.left)),
            ("leave_time", json!(self.leave_time())),
            ("exponents_compared", json!(self.compared)),
            ("exponent_difference", json!((self.compared > 0).then_some(self.difference))),
        ]));
        told
    }
}
