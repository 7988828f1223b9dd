//! `mapgen sweep --dry-run`: what a sweep will cost, from a few of its cells.

use std::fmt::Write as _;
use std::ops::Range;
use std::time::{Duration, Instant};

use rayon::ThreadPool;
use vibrochain_lattice::Stop;

use crate::common::error::CliError;
use crate::common::threads::cores;
use crate::sweep::report::grid;
use vibrochain_maps::cell::Worker;
use vibrochain_maps::sweep::{Ended, Job, Plan, Shard, refined};
use vibrochain_maps::table::{Table, names};
use vibrochain_maps::text::duration;

/// The most cells computed.
const SAMPLE: u64 = 400;

/// The longest the sample may take, if a single cell does not.
const PATIENCE: Duration = Duration::from_secs(3);

/// Fractional part of the golden ratio: its multiples spread evenly, and in step with no axis.
const GOLDEN: f64 = 0.618_033_988_749_894_9;

/// Time and size of a few cells.
struct Sample {
    cells: u64,
    seconds: f64,
    bytes: usize,
}

/// The place of cell number `i` of the sample, from 0 to 1.
fn place(i: u64) -> f64 {
    ((i as f64 + 0.5) * GOLDEN).fract()
}

fn sample(plan: &Plan, stop: &Stop) -> Result<Sample, CliError> {
    let scene = &plan.scene;
    let failed = |error: &dyn std::fmt::Display| CliError::Computation(format!("could not estimate: {error}"));
    let mut worker = Worker::new(scene.base.sites()).until(stop);
    let mut table = Table::new(scene);
    let wanted = SAMPLE.min(plan.cells());
    // The first cell fills the work space: it is computed once more.
    let mut compute = |number: u64| {
        let model = scene.point(number).model().map_err(|error| failed(&error))?;
        Ok::<_, CliError>(worker.cell(&model, &scene.task))
    };
    let begun = Instant::now();
    let (mut seconds, mut cells) = (0.0, 0);
    while cells < wanted && (cells == 0 || begun.elapsed() < PATIENCE) {
        if stop.is_raised() {
            return Err(CliError::Interrupted);
        }
        let number = (place(cells) * plan.cells() as f64) as u64;
        let number = number.min(plan.cells() - 1);
        if cells == 0 {
            compute(number)?;
        }
        let started = Instant::now();
        let cell = compute(number)?;
        seconds += started.elapsed().as_secs_f64();
        table.write(&scene.point(number), &cell);
        cells += 1;
    }
    Ok(Sample { cells, seconds, bytes: table.text.len() })
}

/// How many rows a cell has on the average, from some of them.
fn rows_per_cell(plan: &Plan, pool: &ThreadPool, stop: &Stop) -> Result<f64, CliError> {
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

/// The answer.
///
/// # Errors
/// [`CliError::Interrupted`].
pub(crate) fn estimate(plan: &Plan, shard: Shard, pool: &ThreadPool, stop: &Stop) -> Result<String, CliError> {
    let threads = pool.current_num_threads();
    let sample = sample(plan, stop)?;
    let rows = match plan.scene.refine {
        Some(_) => rows_per_cell(plan, pool, stop)?,
        None => 1.0,
    };
    let (cells, chunks) = (plan.cells(), plan.chunks());
    let (per_cell, per_row) = (sample.seconds / sample.cells as f64, sample.bytes as f64 / sample.cells as f64);
    let mut text = String::new();
    let mut line = |name: &str, value: String| {
        // Writing to a String cannot fail.
        let _ = writeln!(text, "{name:<8} {value}");
    };
    line("cells", format!("{cells} ({})", grid(&plan.scene)));
    if plan.scene.refine.is_some() {
        let (leaves, finest) = ((rows * cells as f64).round(), grid(&plan.scene.finest()));
        line("leaves", format!("about {leaves:.1e}, {rows:.1} a cell, for {finest} cells"));
    }
    line("chunks", format!("{chunks} of {} cells", plan.chunk_cells.min(cells)));
    line("columns", names(&plan.scene).join(", "));
    let of_shard: u64 = shard.chunks(plan).map(|chunk| plan.range(chunk).count() as u64).sum();
    if shard != Shard::WHOLE {
        let Shard { index, count } = shard;
        line("shard", format!("{index}/{count}: {} chunks, {of_shard} cells", shard.chunks(plan).count()));
    }
    let wall = per_cell * rows * of_shard as f64 / threads.min(cores()) as f64;
    line(
        "time",
        format!(
            "about {} on {threads} thread{}, {:.3e} s per cell and core",
            duration(wall),
            if threads == 1 { "" } else { "s" },
            per_cell
        ),
    );
    let bytes = per_row * rows * cells as f64;
    line("disk", format!("about {} for the table, as much again for the chunks until it is whole", size(bytes)));
    line("sample", format!("{} cells in {:.3} s", sample.cells, sample.seconds));
    Ok(text)
}

/// A number of bytes, in decimal units.
fn size(bytes: f64) -> String {
    let units = [(1e12, "TB"), (1e9, "GB"), (1e6, "MB"), (1e3, "kB")];
    match units.iter().find(|(unit, _)| bytes >= *unit) {
        Some((unit, name)) => format!("{:.1} {name}", bytes / unit),
        None => format!("{bytes:.0} bytes"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn units() {
        assert_eq!([12.0, 1500.0, 7.04e10].map(size), ["12 bytes", "1.5 kB", "70.4 GB"]);
    }
}
