//! `mapgen sweep --dry-run`: what a sweep will cost, from a few of its cells.

use std::fmt::Write as _;
use std::time::{Duration, Instant};

use rayon::ThreadPool;
use vibrochain_lattice::Stop;

use crate::common::error::CliError;
use crate::common::swept_scene::SweptScene;
use crate::common::threads::cores;
use crate::sweep::report::grid;
use vibrochain_maps::sweep::{Plan, Shard};
use vibrochain_maps::table::{Table, header};
use vibrochain_maps::text::duration;

/// The most cells computed for an estimate.
const SAMPLE: u64 = 400;

/// The longest it may take, if a single cell does not.
const PATIENCE: Duration = Duration::from_secs(3);

/// Fractional part of the golden ratio: its multiples spread evenly, and in step with no axis.
const GOLDEN: f64 = 0.618_033_988_749_894_9;

/// The place of cell number `i` of the sample, from 0 to 1.
fn place(i: u64) -> f64 {
    ((i as f64 + 0.5) * GOLDEN).fract()
}

/// Time and size of a few cells.
struct Sample {
    cells: u64,
    seconds: f64,
    bytes: usize,
}

fn sample<S: SweptScene>(plan: &Plan<S>, stop: &Stop) -> Result<Sample, CliError> {
    let scene = &plan.scene;
    let (mut worker, mut table, mut found) = (scene.worker(stop), Table::new(scene), Vec::new());
    let wanted = SAMPLE.min(plan.cells());
    let mut compute = |number: u64, found: &mut Vec<S::Cell>| {
        scene.compute(&mut worker, number..number + 1, stop, found).ok_or(CliError::Interrupted)
    };
    let begun = Instant::now();
    let (mut seconds, mut cells) = (0.0, 0);
    while cells < wanted && (cells == 0 || begun.elapsed() < PATIENCE) {
        let number = (place(cells) * plan.cells() as f64) as u64;
        let number = number.min(plan.cells() - 1);
        // The first cell fills the work space: it is computed once more.
        if cells == 0 {
            compute(number, &mut found)?;
        }
        let started = Instant::now();
        compute(number, &mut found)?;
        seconds += started.elapsed().as_secs_f64();
        found.iter().for_each(|cell| table.write(&scene.point(number), cell));
        cells += 1;
    }
    Ok(Sample { cells, seconds, bytes: table.text.len() })
}

/// The answer.
///
/// # Errors
/// [`CliError::Interrupted`].
pub(crate) fn estimate<S: SweptScene>(
    plan: &Plan<S>,
    shard: Shard,
    pool: &ThreadPool,
    stop: &Stop,
) -> Result<String, CliError> {
    let threads = pool.current_num_threads();
    let sample = sample(plan, stop)?;
    let (cells, chunks) = (plan.cells(), plan.chunks());
    let (per_cell, per_row) = (sample.seconds / sample.cells as f64, sample.bytes as f64 / sample.cells as f64);
    let mut text = String::new();
    let mut line = |name: &str, value: String| {
        // Writing to a String cannot fail.
        let _ = writeln!(text, "{name:<8} {value}");
    };
    line("cells", format!("{cells} ({})", grid(&plan.scene)));
    line("chunks", format!("{chunks} of {} cells", plan.chunk_cells.min(cells)));
    line("columns", header(&plan.scene).trim_end().replace(',', ", "));
    let of_shard: u64 = shard.chunks(plan).map(|chunk| plan.range(chunk).count() as u64).sum();
    if shard != Shard::WHOLE {
        let Shard { index, count } = shard;
        line("shard", format!("{index}/{count}: {} chunks, {of_shard} cells", shard.chunks(plan).count()));
    }
    let wall = per_cell * of_shard as f64 / threads.min(cores()) as f64;
    line(
        "time",
        format!(
            "about {} on {threads} thread{}, {:.3e} s per cell and core",
            duration(wall),
            if threads == 1 { "" } else { "s" },
            per_cell
        ),
    );
    let bytes = per_row * cells as f64;
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
