//! `mapgen orbit --multipliers`: the multipliers of all solutions as CSV, each row made as it is written.

use std::io::Write as _;
use std::path::Path;

use vibrochain_breather::{BreatherError, Finder};
use vibrochain_floquet::ModeLabels;

use crate::common::error::CliError;
use crate::common::solution::Solution;
use vibrochain_maps::files::{CsvFile, Output};
use vibrochain_maps::numbers::push_row;

const HEADER: [&str; 6] = ["solution", "real", "imaginary", "modulus", "argument", "mode"];

/// Rows between two looks at the request to stop: some milliseconds.
const ROWS: usize = 4096;

/// The file under way.
pub(crate) struct MultiplierFile {
    file: Output,
}

impl MultiplierFile {
    /// Opens the file.
    ///
    /// # Errors
    /// [`CliError::Request`] if it cannot be written.
    pub(crate) fn create(path: &Path) -> Result<Self, CliError> {
        Ok(Self { file: CsvFile::create("--multipliers", path, HEADER)?.into_output()? })
    }

    /// Writes a row for each multiplier, by falling modulus; solutions are counted from 1, as in the printed list.
    ///
    /// # Errors
    /// [`CliError::Computation`] if the disk refuses.
    pub(crate) fn finish(mut self, solutions: &[Solution], finder: &mut Finder) -> Result<(), CliError> {
        // Neither numbers nor nothing need quotes.
        let mut row = Vec::new();
        for (i, solution) in solutions.iter().enumerate() {
            // What could not be computed is told elsewhere.
            let Ok(multipliers) = &solution.multipliers else { continue };
            let mut labels = ModeLabels::new(&solution.orbit, finder)?;
            finder.give_back();
            let number = format!("{},", i + 1);
            for (written, z) in multipliers.sorted().enumerate() {
                if written.is_multiple_of(ROWS) {
                    finder.stop().heard().map_err(BreatherError::from)?;
                }
                row.clear();
                row.extend_from_slice(number.as_bytes());
                push_row(&[z.re, z.im, z.norm(), z.arg()], &mut row);
                let mode = labels.mode(z);
                let written = mode.map_or(Ok(()), |mode| write!(row, "{mode}"));
                row.push(b'\n');
                let written = written.and_then(|()| self.file.write_all(&row));
                written.map_err(|error| self.file.unwritten(&error))?;
            }
        }
        Ok(self.file.commit()?)
    }
}
