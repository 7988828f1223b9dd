//! The tables of the corners and of the random points, for the document and as CSV.

use std::fmt::Write as _;

use rayon::ThreadPool;

use super::cases::{CORNERS, Effort, rows};
use super::checks::Row;
use super::draws::{Tally, check_draws};
use vibrochain_cli::common::error::CliError;

/// Columns of the CSV file.
const COLUMNS: [&str; 7] = ["corner", "case", "quantity", "promised", "delivered", "outcome", "kept"];

/// Random points of a full run.
const DRAWS: u64 = 100_000;

/// First of the sequence of random points.
const SEED: u64 = 1;

/// What the report needs of its surroundings: to say what is under way, and to hear Ctrl-C.
pub(crate) trait Surroundings {
    /// Says what is under way, or fails if the run is to end.
    fn at(&self, what: &str) -> Result<(), CliError>;
}

/// All corners and the random points.
#[derive(Debug, Clone, Default)]
pub(crate) struct Report {
    corners: Vec<(&'static str, Vec<Row>)>,
    tally: Tally,
}

impl Report {
    /// Checks everything; `quick` for a look.
    pub(crate) fn run(surroundings: &impl Surroundings, pool: &ThreadPool, quick: bool) -> Result<Self, CliError> {
        let effort = if quick { Effort::QUICK } else { Effort::FULL };
        let mut report = Self::default();
        for corner in &CORNERS {
            surroundings.at(corner.0)?;
            report.corners.push((corner.0, rows(corner, effort)?));
        }
        let draws = if quick { DRAWS / 1000 } else { DRAWS };
        let parts = 100;
        for part in 0..parts {
            surroundings.at(&format!("random points, {part} %"))?;
            let tally = pool.install(|| check_draws(SEED + part * draws / parts, draws / parts))?;
            report.tally = std::mem::take(&mut report.tally).join(tally);
        }
        Ok(report)
    }

    /// How many promises were broken, and the first of them.
    pub(crate) fn broken(&self) -> Option<(usize, &Row)> {
        let rows = self.corners.iter().flat_map(|(_, rows)| rows).filter(|row| !row.holds());
        let mut broken = rows.chain(&self.tally.broken);
        let first = broken.next()?;
        Some((1 + broken.count(), first))
    }

    /// The rows of the corners as CSV, and those random points that broke their promise.
    pub(crate) fn csv(&self) -> Result<Vec<u8>, CliError> {
        let broken = ("random points", self.tally.broken.as_slice());
        csv(self.corners.iter().map(|(corner, rows)| (*corner, rows.as_slice())).chain([broken]))
    }

    /// A Markdown table of the corners, and that of the random points.
    pub(crate) fn markdown(&self) -> Vec<String> {
        let mut text =
            "| corner | numbers compared | largest share of the error promised | without a number | broken |\n\
            |---|---|---|---|---|\n"
                .to_owned();
        for (corner, rows) in &self.corners {
            let shares =
                rows.iter().filter_map(|row| Some(row.delivered? / row.promised.filter(|error| *error > 0.0)?));
            let largest = shares.fold(0.0_f64, f64::max);
            let compared = rows.iter().filter(|row| row.delivered.is_some()).count();
            let broken = rows.iter().filter(|row| !row.holds()).count();
            // Writing to a String cannot fail.
            let _ = writeln!(text, "| {corner} | {compared} | {largest:.2} | {} | {broken} |", rows.len() - compared);
        }
        let mut parts = vec![text];
        let tally = &self.tally;
        parts.push(format!(
            "**random points**\n\n{} points, {} numbers compared with the truth; the largest error is {:.2} of the one \
             promised, {} promises are broken.\n",
            tally.draws,
            tally.compared,
            tally.worst,
            tally.broken.len()
        ));
        parts
    }
}

/// Rows under the names of their groups, as CSV.
pub(crate) fn csv<'a>(groups: impl Iterator<Item = (&'a str, &'a [Row])>) -> Result<Vec<u8>, CliError> {
    let failed = |error: &dyn std::fmt::Display| CliError::Computation(format!("could not write a table: {error}"));
    let mut writer = csv::Writer::from_writer(Vec::new());
    writer.write_record(COLUMNS).map_err(|error| failed(&error))?;
    for (group, rows) in groups {
        for row in rows {
            let kept = if row.holds() { "yes" } else { "no" };
            let (promised, delivered) = (number(row.promised), number(row.delivered));
            let record: [&str; 7] = [group, &row.case, &row.quantity, &promised, &delivered, &row.outcome, kept];
            writer.write_record(record).map_err(|error| failed(&error))?;
        }
    }
    writer.into_inner().map_err(|error| failed(&error))
}

fn number(value: Option<f64>) -> String {
    match value {
        None => String::new(),
        Some(0.0) => "0".to_owned(),
        Some(value) => format!("{value:.1e}"),
    }
}

/// What the section is about.
pub(crate) const PROSE: &str = "Corners where formulas lose digits, against 57 digits (the far field 360). The error promised is the \
    program's own: for kernels four units in the last place times the condition number, for orbits `condition`, for spectral radii \
    `resolution`; for the far field, the long simulation and the single oscillator a bound by hand. A kernel must keep its promise; \
    estimates may be exceeded tenfold. Where there is no number, there is no orbit, or no truth.\n\nThe random points spread \
    logarithmically: stiffnesses over 16 decades and none, frequencies from 1/30 of the band's top to 1000 times it, forces over nine \
    decades, restitution up to 1 − 1e-15, asymmetry up to 1 − 1e-12.";
