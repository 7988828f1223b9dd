//! `mapgen orbit --multipliers`: the multipliers of all solutions as CSV, each row made as it is written.

use std::io::Write as _;
use std::path::Path;

use vibrochain_breather::{BreatherError, Finder};
use vibrochain_floquet::{Complex, ModeLabels};
use vibrochain_lattice::Stop;

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

    /// A row for each multiplier of solution `number`, counted from 1 as in the printed list; `mode` names the mode that is nearest.
    ///
    /// # Errors
    /// [`CliError::Computation`] if the disk refuses, [`CliError::Interrupted`].
    pub(crate) fn rows<M: std::fmt::Display>(
        &mut self,
        number: usize,
        multipliers: impl Iterator<Item = Complex<f64>>,
        stop: &Stop,
        mut mode: impl FnMut(Complex<f64>) -> Option<M>,
    ) -> Result<(), CliError> {
        // Neither numbers nor nothing need quotes.
        let (mut row, number) = (Vec::new(), format!("{number},"));
        for (written, z) in multipliers.enumerate() {
            if written.is_multiple_of(ROWS) {
                stop.heard().map_err(BreatherError::from)?;
            }
            row.clear();
            row.extend_from_slice(number.as_bytes());
            push_row(&[z.re, z.im, z.norm(), z.arg()], &mut row);
            let written = mode(z).map_or(Ok(()), |mode| write!(row, "{mode}"));
            row.push(b'\n');
            let written = written.and_then(|()| self.file.write_all(&row));
            written.map_err(|error| self.file.unwritten(&error))?;
        }
        Ok(())
    }

    /// The multipliers of all solutions by falling modulus.
    ///
    /// # Errors
    /// As [`MultiplierFile::rows`].
    pub(crate) fn of_solutions(mut self, solutions: &[Solution], finder: &mut Finder) -> Result<(), CliError> {
        for (solution, number) in solutions.iter().zip(1..) {
            // What could not be computed is told elsewhere.
            let Ok(multipliers) = &solution.multipliers else { continue };
            let mut labels = ModeLabels::new(&solution.orbit, finder)?;
            finder.give_back();
            self.rows(number, multipliers.sorted(), finder.stop(), |z| labels.mode(z))?;
        }
        self.finish()
    }

    /// # Errors
    /// [`CliError::Computation`] if the disk refuses.
    pub(crate) fn finish(self) -> Result<(), CliError> {
        Ok(self.file.commit()?)
    }
}
