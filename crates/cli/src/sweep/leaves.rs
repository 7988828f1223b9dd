//! How many leaves the cells of a refined grid have, from some of them.

use std::ops::Range;
use std::time::{Duration, Instant};

use rayon::ThreadPool;
use vibrochain_lattice::Stop;
use vibrochain_maps::sweep::{Ended, Job, Plan, refined};

use crate::common::error::CliError;

/// The most cells computed for an estimate.
pub(crate) const SAMPLE: u64 = 400;

/// The longest it may take, if a single cell does not.
pub(crate) const PATIENCE: Duration = Duration::from_secs(3);

/// Fractional part of the golden ratio: its multiples spread evenly, and in step with no axis.
const GOLDEN: f64 = 0.618_033_988_749_894_9;

/// The place of cell number `i` of the sample, from 0 to 1.
pub(crate) fn place(i: u64) -> f64 {
    ((i as f64 + 0.5) * GOLDEN).fract()
}

/// How many rows a cell has on the average.
///
/// # Errors
/// [`CliError::Interrupted`].
pub(crate) fn rows_per_cell(plan: &Plan, pool: &ThreadPool, stop: &Stop) -> Result<f64, CliError> {
    let job = Job { scene: &plan.scene, pool, stop };
    let part = |i: u64| {
        let number = (place(i) * plan.cells() as f64) as u64;
        number.min(plan.cells() - 1)..number.min(plan.cells() - 1) + 1
    };
    let parts: Vec<Range<u64>> = (0..SAMPLE.min(plan.cells())).map(part).collect();
    let begun = Instant::now();
    let (mut cells, mut rows) = (0, 0);
    let ended = refined(
        &job,
        &parts,
        |_| {},
        |leaves| {
            cells += 1;
            rows += leaves.len();
            if begun.elapsed() < PATIENCE { Ok(()) } else { Err(()) }
        },
    );
    match ended {
        Ended::Stopped => Err(CliError::Interrupted),
        Ended::Complete(_) | Ended::Failed(()) => Ok(rows as f64 / f64::from(cells.max(1))),
    }
}
