//! `mapgen orbit --multipliers`: the multipliers of all solutions as CSV.

use std::path::Path;

use vibrochain_breather::Finder;
use vibrochain_floquet::multiplier_modes;

use crate::error::CliError;
use crate::solution::Solution;
use vibrochain_maps::files::CsvFile;

const HEADER: [&str; 6] = ["solution", "real", "imaginary", "modulus", "argument", "mode"];

/// The file under way.
pub(crate) struct MultiplierFile {
    file: CsvFile,
}

impl MultiplierFile {
    /// Opens the file.
    ///
    /// # Errors
    /// [`CliError::Request`] if it cannot be written.
    pub(crate) fn create(path: &Path) -> Result<Self, CliError> {
        Ok(Self { file: CsvFile::create("--multipliers", path, HEADER)? })
    }

    /// Writes a row for each multiplier, by falling modulus; solutions are counted from 1, as in the printed list.
    ///
    /// # Errors
    /// [`CliError::Computation`] if the disk refuses.
    pub(crate) fn finish(mut self, solutions: &[Solution], finder: &mut Finder) -> Result<(), CliError> {
        for (i, solution) in solutions.iter().enumerate() {
            // What could not be computed is told elsewhere.
            let Ok(stability) = &solution.stability else { continue };
            let modes = multiplier_modes(&solution.orbit, finder, &stability.multipliers)?;
            for (z, mode) in stability.multipliers.iter().zip(modes) {
                let record = [
                    (i + 1).to_string(),
                    z.re.to_string(),
                    z.im.to_string(),
                    z.norm().to_string(),
                    z.im.atan2(z.re).to_string(),
                    mode.map_or(String::new(), |mode| mode.to_string()),
                ];
                self.file.row(record)?;
            }
        }
        Ok(self.file.finish()?)
    }
}
