//! Computes the chunks that are missing.

use rayon::iter::{IntoParallelRefIterator, ParallelIterator};

use crate::error::CliError;
use crate::sweep::chunk::Fault;
use crate::sweep::{Ended, Job, Plan, Shard, Store, blocks};
use crate::table::Table;

/// What there is to do for a shard.
#[derive(Debug)]
pub(crate) struct Todo {
    /// Chunks to compute.
    pub(crate) chunks: Vec<u64>,
    /// Why those that are there must be computed again.
    pub(crate) damaged: Vec<String>,
    /// Cells of the chunks that are finished.
    pub(crate) finished_cells: u64,
}

impl Todo {
    /// Looks at every chunk of the shard that is there.
    ///
    /// # Errors
    /// [`CliError::Request`] for a chunk of another sweep.
    pub(crate) fn of(job: &Job<'_>, plan: &Plan, store: &Store, shard: Shard) -> Result<Self, CliError> {
        let mut todo = Self { chunks: Vec::new(), damaged: Vec::new(), finished_cells: 0 };
        let chunks: Vec<u64> = shard.chunks(plan).collect();
        let checked: Vec<_> =
            job.pool.install(|| chunks.par_iter().map(|&chunk| Store::check(store.folder(), plan, chunk)).collect());
        for (chunk, checked) in chunks.into_iter().zip(checked) {
            let path = Store::path(store.folder(), chunk);
            match checked {
                Ok(summary) => {
                    todo.finished_cells += summary.cells();
                    continue;
                }
                Err(Fault::Foreign) => {
                    let message = format!(
                        "{} is a chunk of another scene or version: remove it, or name another --out",
                        path.display()
                    );
                    return Err(CliError::Request(message));
                }
                Err(Fault::Missing) => {}
                Err(fault) => todo.damaged.push(format!("{}: {fault}; computing it again", path.display())),
            }
            todo.chunks.push(chunk);
        }
        Ok(todo)
    }
}

/// Computes `chunks`, each a file that appears whole or not at all. `tick` is called with each number of cells done.
pub(crate) fn work(
    job: &Job<'_>,
    plan: &Plan,
    store: &Store,
    chunks: &[u64],
    tick: impl Fn(u64) + Sync,
) -> Ended<CliError> {
    let parts: Vec<_> = chunks.iter().map(|&chunk| plan.range(chunk)).collect();
    let mut writer = None;
    blocks(
        job,
        &parts,
        |range, cells| {
            let mut table = Table::new(job.scene, Vec::new());
            tick(range.end - range.start);
            let written = table.write_all(job.scene, range, cells).map_err(|error| error.to_string());
            written.and_then(|()| table.finish().map_err(|error| error.to_string()))
        },
        |block| {
            let rows = block.made.map_err(CliError::Computation)?;
            let mut open = match writer.take() {
                Some(open) => open,
                None => store.writer(plan, chunks[block.part])?,
            };
            open.rows(&rows, &block.summary)?;
            if block.last {
                open.finish()?;
            } else {
                writer = Some(open);
            }
            Ok(())
        },
    )
}
