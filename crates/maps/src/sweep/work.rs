//! Computes the chunks that are missing.

use std::ops::Range;

use rayon::iter::{IntoParallelRefIterator, ParallelIterator};

use super::assemble::Assembly;
use super::chunk::{Fault, Writer};
use super::content::Content;
use super::engine::{Ended, Job};
use super::plan::Plan;
use super::shard::Shard;
use super::store::Store;
use crate::error::MapError;
use crate::grid::Grid;

/// What there is to do for a shard.
#[derive(Debug)]
pub struct Todo {
    /// Chunks to compute.
    pub chunks: Vec<u64>,
    /// Why those that are there must be computed again.
    pub damaged: Vec<String>,
    /// Cells of the chunks that are finished.
    pub finished_cells: u64,
}

impl Todo {
    /// Looks at every chunk of the shard that is there. Nothing if the stop flag is raised before that is done.
    ///
    /// # Errors
    /// [`MapError::Request`] for a chunk of another sweep.
    pub fn of<S: Grid, C: Content<S>>(
        content: &C,
        job: &Job<'_, S>,
        plan: &Plan<S>,
        store: &Store,
        shard: Shard,
    ) -> Result<Option<Self>, MapError> {
        let mut todo = Self { chunks: Vec::new(), damaged: Vec::new(), finished_cells: 0 };
        let there = store.present()?;
        let chunks: Vec<u64> = shard.chunks(plan).collect();
        let check = |&chunk: &u64| match there.contains(&chunk) {
            true => Store::check(content, store.folder(), plan, chunk, job.stop),
            false => Err(Fault::Missing),
        };
        let checked: Vec<_> = job.pool.install(|| chunks.par_iter().map(check).collect());
        for (chunk, checked) in chunks.into_iter().zip(checked) {
            let path = Store::path(store.folder(), chunk);
            match checked {
                Ok(_) => {
                    let Range { start, end } = plan.range(chunk);
                    todo.finished_cells += end - start;
                    continue;
                }
                Err(Fault::Foreign) => {
                    refuse!("{} is a chunk of another scene or version: name another --out", path.display());
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
pub struct Grown<'a, C: Content<S>, S: Grid> {
    /// The table.
    pub table: Assembly<'a, C, S>,
    /// The last chunk, closed and yet to be placed: once the table is in its place, nobody needs it.
    pub last: Writer,
}

/// How the work ended.
pub struct Worked<'a, C: Content<S>, S: Grid> {
    /// With all chunks, or why without.
    pub ended: Ended<MapError>,
    /// The table that has grown along, if all went well.
    pub grown: Option<Grown<'a, C, S>>,
}

/// Where a chunk cannot be written, gives up the table for it.
fn make_room<S: Grid, C: Content<S>>(
    written: Result<(), MapError>,
    along: &mut Option<Assembly<'_, C, S>>,
    chunk: &mut Writer,
) -> Result<(), MapError> {
    match written {
        Err(_) if along.take().is_some() => chunk.flush(),
        written => written,
    }
}

/// What chunks are computed of, and where they are kept.
pub struct Work<'w, C, S: Grid> {
    /// What their cells hold.
    pub content: &'w C,
    /// The scene, the threads, what stops them.
    pub job: &'w Job<'w, S>,
    /// How the scene is cut into chunks.
    pub plan: &'w Plan<S>,
    /// The folder of chunks.
    pub store: &'w Store,
}

/// Computes `chunks`, each a file that appears whole or not at all. `tick` is called with each number of steps done. The
/// rows go to the table `along`, too, if there is one: so none has to be read back.
pub fn work<'a, S: Grid, C: Content<S>>(
    work: &Work<'_, C, S>,
    chunks: &[u64],
    tick: impl Fn(u64) + Sync,
    mut along: Option<Assembly<'a, C, S>>,
) -> Worked<'a, C, S> {
    let &Work { content, job, plan, store } = work;
    // Chunks that others have put there since, where the file system has no locks, would be missing from it.
    along = along.filter(|_| chunks.len() as u64 == plan.chunks());
    let parts: Vec<_> = chunks.iter().map(|&chunk| plan.range(chunk)).collect();
    let mut writer = None;
    let mut last = None;
    let mut plan_is_safe = false;
    let wanted = along.as_ref().is_some_and(Assembly::wants_cells);
    let ended = content.compute(job, &parts, wanted, &tick, &mut |block| {
        let rows = block.made;
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
        let written = open.rows(&rows.text, &block.summary);
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
            store.sync_plan();
            plan_is_safe = true;
        }
        open.place()?;
        if along.as_mut().is_some_and(|table| table.sync().is_err()) {
            along = None;
        }
        Ok(())
    });
    let complete = matches!(ended, Ended::Complete(_));
    let grown = along.zip(last).filter(|_| complete).map(|(table, last)| Grown { table, last });
    Worked { ended, grown }
}

#[cfg(test)]
mod tests {
    use vibrochain_lattice::Stop;

    use super::*;
    use crate::cell::Cell;
    use crate::sweep::assemble::Watcher;
    use crate::sweep::content::Cells;
    use crate::sweep::store::Claim;

    struct Nobody;

    impl Watcher for Nobody {
        fn looks(&self) -> bool {
            false
        }

        fn begin(&mut self) {}

        fn cell(&mut self, _: u64, _: &Cell) {}
    }

    #[test]
    fn a_flag_that_is_raised_while_chunks_are_checked_is_heard() {
        let dir = tempfile::tempdir().unwrap();
        let scene = dir.path().join("scene.toml");
        let text = "[model]\nsites = 1\ngamma1 = 0.2\nasymmetry = 0.4\n[sweep]\n\
            x = { parameter = \"omega\", from = 0.5, to = 3.0, points = 100 }\n\
            y = { parameter = \"gamma2\", values = [0.1] }\n[compute]\nfamilies = [\"double-sided\"]\n";
        std::fs::write(&scene, text).unwrap();
        let plan: Plan = Plan::read(&scene, None).unwrap();
        let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
        let store = Store::open(&dir.path().join("parts"), &plan, Claim::Fresh, &Stop::default()).unwrap();
        let todo = |stop| {
            Todo::of(
                &Cells,
                &Job { scene: &plan.scene, pool: &pool, stop: &Stop::when(move || stop) },
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
        let dir = tempfile::tempdir().unwrap();
        let (scene, out) = (dir.path().join("scene.toml"), dir.path().join("map.csv"));
        let text = "[model]\nsites = 1\ngamma1 = 0.2\nasymmetry = 0.4\n[sweep]\n\
            x = { parameter = \"omega\", from = 0.5, to = 3.0, points = 36000 }\n\
            y = { parameter = \"gamma2\", values = [0.1, 0.2] }\n[compute]\nfamilies = [\"double-sided\"]\n";
        std::fs::write(&scene, text).unwrap();
        let plan: Plan = Plan::read(&scene, None).unwrap();
        let (stop, pool) = (Stop::default(), rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap());
        let job = Job { scene: &plan.scene, pool: &pool, stop: &stop };
        let chunks: Vec<u64> = (0..plan.chunks()).collect();
        assert!(chunks.len() > 2);
        // The first one has come from elsewhere since.
        for (some, grows) in [(&chunks[1..], false), (&chunks[..], true)] {
            let store = Store::open(&dir.path().join("parts"), &plan, Claim::Fresh, &Stop::default()).unwrap();
            let given = Work { content: &Cells, job: &job, plan: &plan, store: &store };
            let mut nobody = Nobody;
            let along = Assembly::begin(&Cells, &plan, &out, 1, &mut nobody).unwrap();
            let worked = work(&given, some, |_| {}, Some(along));
            assert!(matches!(worked.ended, Ended::Complete(_)) && worked.grown.is_some() == grows);
            // The last chunk waits for the table it might not be needed after.
            assert_eq!(store.present().unwrap().len(), some.len() - usize::from(grows));
            drop(worked.grown);
            assert!(store.remove(&plan));
        }
    }
}
