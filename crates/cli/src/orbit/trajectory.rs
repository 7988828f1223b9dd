//! `mapgen orbit --trajectory`: a period of each solution as a table, from the closed form.

use crate::args::OrbitArgs;
use crate::common::error::CliError;
use vibrochain_maps::files::CsvFile;

/// The most samples of a period.
const MOST_SAMPLES: u64 = 1_000_000;

/// `solution,time,…`, one row a sample, from t = 0 on, the end of the period included.
pub(crate) struct OrbitTrajectory {
    file: CsvFile,
    samples: u64,
}

impl OrbitTrajectory {
    /// `columns` are those after the number of the solution, the time first.
    pub(crate) fn open(args: &OrbitArgs, columns: impl Iterator<Item = String>) -> Result<Option<Self>, CliError> {
        let samples = args.samples;
        if !(1..=MOST_SAMPLES).contains(&samples) {
            refuse!("--samples {samples} is out of range: give a whole number from 1 to {MOST_SAMPLES}");
        }
        let Some(path) = &args.trajectory else { return Ok(None) };
        let columns = std::iter::once("solution".to_owned()).chain(columns);
        Ok(Some(Self { file: CsvFile::create("--trajectory", path, columns)?, samples }))
    }

    /// The rows of solution `number`, of which `state` tells all columns after the time.
    pub(crate) fn period(
        &mut self,
        number: usize,
        period: f64,
        mut state: impl FnMut(f64) -> Result<Vec<f64>, CliError>,
    ) -> Result<(), CliError> {
        for k in 0..=self.samples {
            let time = k as f64 / self.samples as f64 * period;
            let state = state(time)?;
            let values = std::iter::once(&time).chain(&state).map(f64::to_string);
            self.file.row(std::iter::once(number.to_string()).chain(values))?;
        }
        Ok(())
    }

    pub(crate) fn finish(self) -> Result<(), CliError> {
        Ok(self.file.finish()?)
    }
}
