//! The table of all kinds of structures.

use std::fmt::Write as _;

use fastrand::Rng;
use rayon::ThreadPool;
use rayon::iter::{IntoParallelIterator, ParallelIterator};

use super::checks::check_structure;
use super::draws::{Kind, draw};
use crate::accuracy::extremes::Row;
use crate::accuracy::extremes::draws::Tally;
use crate::accuracy::extremes::report::{Surroundings, csv};
use vibrochain_cli::common::error::CliError;

/// Random structures of a full run, of all kinds together.
const DRAWS: u64 = 10_000;

/// The same of a look.
const QUICK: u64 = 320;

/// First of the sequence of random structures.
const SEED: u64 = 1;

/// Draws of a kind between two looks at whether the run is to end.
const PART: u64 = 50;

/// What the draws of one kind came to, with their worst row of each quantity.
#[derive(Debug, Clone)]
pub struct KindTally {
    /// The kind.
    pub kind: Kind,
    /// Its draws.
    pub tally: Tally,
    /// Draws with an orbit that was compared.
    pub answered: u64,
}

/// Checks draws `from` to `to` of a kind, on all threads of the pool it is called in.
#[must_use]
pub fn check_structures(kind: Kind, from: u64, to: u64) -> KindTally {
    let one = |number: u64| {
        let mut random = Rng::with_seed((SEED + number) * Kind::ALL.len() as u64 + kind as u64);
        let drawn = draw(&mut random, kind);
        let rows = check_structure(&drawn.scene(), &drawn);
        let answered = u64::from(rows.iter().any(|row| row.delivered.is_some()));
        let tally = Tally { draws: 1, ..Tally::default() };
        KindTally { kind, tally: rows.into_iter().fold(tally, Tally::count), answered }
    };
    let none = || KindTally { kind, tally: Tally::default(), answered: 0 };
    (from..to).into_par_iter().map(one).reduce(none, KindTally::join)
}

impl KindTally {
    fn join(self, other: Self) -> Self {
        let answered = self.answered + other.answered;
        Self { kind: self.kind, tally: self.tally.join(other.tally), answered }
    }
}

/// All kinds.
#[derive(Debug, Clone, Default)]
pub(crate) struct Report(Vec<KindTally>);

impl Report {
    /// Checks everything; `quick` for a look.
    pub(crate) fn run(surroundings: &impl Surroundings, pool: &ThreadPool, quick: bool) -> Result<Self, CliError> {
        let draws = if quick { QUICK } else { DRAWS } / Kind::ALL.len() as u64;
        let mut report = Self::default();
        for kind in Kind::ALL {
            let mut tally = KindTally { kind, tally: Tally::default(), answered: 0 };
            for from in (0..draws).step_by(PART as usize) {
                surroundings.at(&format!("{}, {from} of {draws}", kind.name()))?;
                let part = pool.install(|| check_structures(kind, from, draws.min(from + PART)));
                tally = tally.join(part);
            }
            report.0.push(tally);
        }
        Ok(report)
    }

    /// How many promises were broken, and the first of them.
    pub(crate) fn broken(&self) -> Option<(usize, &Row)> {
        let mut broken = self.0.iter().flat_map(|kind| &kind.tally.broken);
        let first = broken.next()?;
        Some((1 + broken.count(), first))
    }

    /// Those that broke their promise, as CSV: the case of each is a scene.
    pub(crate) fn csv(&self) -> Result<Vec<u8>, CliError> {
        csv(self.0.iter().map(|kind| (kind.kind.name(), kind.tally.broken.as_slice())))
    }

    /// A Markdown table of the kinds.
    pub(crate) fn markdown(&self) -> String {
        let mut text = "| kind | structures | with orbits | numbers compared | largest share of the bound | no bound told | broken |\n\
             |---|---|---|---|---|---|---|\n"
            .to_owned();
        for KindTally { kind, tally, answered } in &self.0 {
            let unknown = tally.outcomes.get("no bound is told").copied().unwrap_or(0);
            // Writing to a String cannot fail.
            let _ = writeln!(
                text,
                "| {} | {} | {answered} | {} | {:.2} | {unknown} | {} |",
                kind.name(),
                tally.draws,
                tally.compared,
                tally.worst,
                tally.broken.len()
            );
        }
        text
    }
}

/// What the section is about.
pub(crate) const PROSE: &str = "Random structures of one to three coordinates and one or two contacts, with damping of any form, loads with \
    phases, and words of one to three impacts. Impulses, times, accelerations and spectral radii are compared with 38 digits or more: no \
    bound may be exceeded, no verdict wrong. That no bound is known may be told.";
