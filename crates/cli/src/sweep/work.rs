//! Computes the chunks that are missing.

use std::ops::Range;

use rayon::iter::{IntoParallelRefIterator, ParallelIterator};

use crate::cell::Cell;
use crate::error::CliError;
use crate::scene::Scene;
use crate::sweep::chunk::{Fault, Writer};
use crate::sweep::{Assembly, Ended, Job, Plan, Shard, Store, blocks};
use crate::table::Table;

/// Room for a row: more than most have.
const ROW: usize = 112;

/// The rows of some cells.
///
/// # Errors
/// What could not be made a row of.
pub(crate) fn rows(scene: &Scene, range: Range<u64>, cells: &[Cell]) -> Result<Vec<u8>, String> {
    let mut table = Table::new(scene, Vec::with_capacity(ROW * cells.len()));
    let written = table.write_all(scene, range, cells).map_err(|error| error.to_string());
    written.and_then(|()| table.finish().map_err(|error| error.to_string()))
}

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
    /// Looks at every chunk of the shard that is there. Nothing if the stop flag is raised before that is done.
    ///
    /// # Errors
    /// [`CliError::Request`] for a chunk of another sweep.
    pub(crate) fn of(job: &Job<'_>, plan: &Plan, store: &Store, shard: Shard) -> Result<Option<Self>, CliError> {
        let mut todo = Self { chunks: Vec::new(), damaged: Vec::new(), finished_cells: 0 };
        let there = store.present()?;
        let chunks: Vec<u64> = shard.chunks(plan).collect();
        let check = |&chunk: &u64| match there.contains(&chunk) {
            true => Store::check(store.folder(), plan, chunk, job.stop),
            false => Err(Fault::Missing),
        };
        let checked: Vec<_> = job.pool.install(|| chunks.par_iter().map(check).collect());
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
                Err(Fault::Stopped) => return Ok(None),
                Err(Fault::Missing) => {}
                Err(fault) => todo.damaged.push(format!("{}: {fault}; computing it again", path.display())),
            }
            todo.chunks.push(chunk);
        }
        Ok(Some(todo))
    }
}

/// A table that has got every row.
pub(crate) struct Grown<'a, 'b> {
    pub(crate) table: Assembly<'a, 'b>,
    /// The last chunk, closed and yet to be placed: once the table is in its place, nobody needs it.
    pub(crate) last: Writer,
}

/// How the work ended.
pub(crate) struct Worked<'a, 'b> {
    pub(crate) ended: Ended<CliError>,
    /// The table that has grown along, if all went well.
    pub(crate) grown: Option<Grown<'a, 'b>>,
}

/// Where a chunk cannot be written, gives up the table for it.
fn make_room(
    written: Result<(), CliError>,
    along: &mut Option<Assembly<'_, '_>>,
    chunk: &mut Writer,
) -> Result<(), CliError> {
    match written {
        Err(_) if along.take().is_some() => chunk.flush(),
        written => written,
    }
}

/// Computes `chunks`, each a file that appears whole or not at all. `tick` is called with each number of cells done. The
/// rows go to the table `along`, too, if there is one: so none has to be read back.
pub(crate) fn work<'a, 'b>(
    job: &Job<'_>,
    plan: &Plan,
    store: &Store,
    chunks: &[u64],
    tick: impl Fn(u64) + Sync,
    mut along: Option<Assembly<'a, 'b>>,
) -> Worked<'a, 'b> {
    // Chunks that others have put there since, where the file system has no locks, would be missing from it.
    along = along.filter(|_| chunks.len() as u64 == plan.chunks());
    let parts: Vec<_> = chunks.iter().map(|&chunk| plan.range(chunk)).collect();
    let mut writer = None;
    let mut last = None;
    let mut plan_is_safe = false;
    let ended = blocks(
        job,
        &parts,
        |range, cells| {
            tick(range.end - range.start);
            rows(job.scene, range, cells)
        },
        |block| {
            let rows = block.made.map_err(CliError::Computation)?;
            // What room there is, is the chunks'. When they are whole the table is tried again, and its error told.
            if along.as_mut().is_some_and(|table| table.rows(&rows).is_err()) {
                along = None;
            }
            let mut open = match writer.take() {
                Some(open) => open,
                None => match store.writer(plan, chunks[block.part]) {
                    Err(_) if along.take().is_some() => store.writer(plan, chunks[block.part])?,
                    open => open?,
                },
            };
            let written = open.rows(&rows, &block.summary);
            make_room(written, &mut along, &mut open)?;
            if !block.last {
                writer = Some(open);
                return Ok(());
            }
            let closed = open.close();
            make_room(closed, &mut along, &mut open)?;
            if along.is_some() && block.part + 1 == chunks.len() {
                last = Some(open);
                return Ok(());
            }
            if !plan_is_safe {
                store.settle_plan();
                plan_is_safe = true;
            }
            open.place()
        },
    );
    let complete = matches!(ended, Ended::Complete(_));
    let grown = along.zip(last).filter(|_| complete).map(|(table, last)| Grown { table, last });
    Worked { ended, grown }
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::AtomicBool;

    use super::*;
    use crate::args::{PaletteName, PictureArgs};
    use crate::pictures::Pictures;
    use crate::sweep::Claim;

    #[test]
    fn a_flag_that_is_raised_while_chunks_are_checked_is_heard() {
        let desk = tempfile::tempdir().unwrap();
        let scene = desk.path().join("scene.toml");
        let text = "[model]\nsites = 1\ngamma1 = 0.2\nasymmetry = 0.4\n[sweep]\n\
            x = { parameter = \"omega\", from = 0.5, to = 3.0, points = 100 }\n\
            y = { parameter = \"gamma2\", values = [0.1] }\n[compute]\nfamilies = [\"double-sided\"]\n";
        std::fs::write(&scene, text).unwrap();
        let plan = Plan::read(&scene, None).unwrap();
        let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
        let store = Store::open(&desk.path().join("parts"), &plan, Claim::Fresh).unwrap();
        let todo = |stop| {
            Todo::of(
                &Job { scene: &plan.scene, pool: &pool, stop: &AtomicBool::new(stop) },
                &plan,
                &store,
                Shard::WHOLE,
            )
        };
        assert_eq!(todo(true).unwrap().unwrap().chunks, [0]);
        std::fs::write(Store::path(store.folder(), 0), "a chunk that is long enough to be one, but for its checksum")
            .unwrap();
        assert_eq!(todo(false).unwrap().unwrap().damaged.len(), 1);
        store.writer(&plan, 0).unwrap().finish().unwrap();
        assert!(todo(true).unwrap().is_none());
    }

    #[test]
    fn a_table_grows_along_only_with_every_chunk() {
        let desk = tempfile::tempdir().unwrap();
        let (scene, out) = (desk.path().join("scene.toml"), desk.path().join("map.csv"));
        let text = "[model]\nsites = 1\ngamma1 = 0.2\nasymmetry = 0.4\n[sweep]\n\
            x = { parameter = \"omega\", from = 0.5, to = 3.0, points = 36000 }\n\
            y = { parameter = \"gamma2\", values = [0.1, 0.2] }\n[compute]\nfamilies = [\"double-sided\"]\n";
        std::fs::write(&scene, text).unwrap();
        let plan = Plan::read(&scene, None).unwrap();
        let (stop, pool) = (AtomicBool::new(false), rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap());
        let job = Job { scene: &plan.scene, pool: &pool, stop: &stop };
        let wanted = PictureArgs { png: None, svg: None, palette: PaletteName::default() };
        let chunks: Vec<u64> = (0..plan.chunks()).collect();
        assert!(chunks.len() > 2);
        // The first one has come from elsewhere since.
        for (some, grows) in [(&chunks[1..], false), (&chunks[..], true)] {
            let store = Store::open(&desk.path().join("parts"), &plan, Claim::Fresh).unwrap();
            let mut pictures = Pictures::plan(&wanted, &plan.scene).unwrap();
            let along = Assembly::begin(&plan, &out, &mut pictures).unwrap();
            let worked = work(&job, &plan, &store, some, |_| {}, Some(along));
            assert!(matches!(worked.ended, Ended::Complete(_)) && worked.grown.is_some() == grows);
            // The last chunk waits for the table it might not be needed after.
            assert_eq!(store.present().unwrap().len(), some.len() - usize::from(grows));
            drop(worked.grown);
            assert!(store.remove(&plan));
        }
    }
}
