//! `mapgen orbit --trajectory`: a period of each solution as a table, from the closed form.

use vibrochain_breather::Motion;
use vibrochain_lattice::Model;

use crate::args::OrbitArgs;
use crate::common::error::CliError;
use crate::common::solution::Solution;
use crate::simulate::recording::trajectory_columns;
use vibrochain_maps::files::CsvFile;

/// The most samples of a period.
const MOST_SAMPLES: u64 = 1_000_000;

/// `solution,time,displacement_0,…,velocity_0,…`, one row a sample, from t = 0 on, the end of the period included.
pub(crate) struct OrbitTrajectory {
    file: CsvFile,
    samples: u64,
}

impl OrbitTrajectory {
    pub(crate) fn open(args: &OrbitArgs, model: &Model) -> Result<Option<Self>, CliError> {
        let samples = args.samples;
        if !(1..=MOST_SAMPLES).contains(&samples) {
            let message = format!("--samples {samples} is out of range: give a whole number from 1 to {MOST_SAMPLES}");
            return Err(CliError::Request(message));
        }
        let Some(path) = &args.trajectory else { return Ok(None) };
        let columns = std::iter::once("solution".to_owned()).chain(trajectory_columns(model.chain().sites()));
        Ok(Some(Self { file: CsvFile::create("--trajectory", path, columns)?, samples }))
    }

    pub(crate) fn finish(mut self, solutions: &[Solution]) -> Result<(), CliError> {
        for (solution, number) in solutions.iter().zip(1..) {
            let (mut motion, period) = (Motion::of(&solution.orbit)?, solution.orbit.period());
            for k in 0..=self.samples {
                let time = k as f64 / self.samples as f64 * period;
                let (displacement, velocity) = motion.state(time);
                let values = std::iter::once(&time).chain(&displacement).chain(&velocity).map(f64::to_string);
                self.file.row(std::iter::once(number.to_string()).chain(values))?;
            }
        }
        Ok(self.file.finish()?)
    }
}
