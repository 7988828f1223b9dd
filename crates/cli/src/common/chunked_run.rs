//! A table that is computed in chunks, whatever its content: what is finished outlives the process, and many processes may
//! share the work.

use std::path::{Path, PathBuf};
use std::time::Instant;

use rayon::ThreadPool;
use vibrochain_lattice::Stop;
use vibrochain_maps::files::{Destination, promises_folder, sync_folder};
use vibrochain_maps::grid::Grid;
use vibrochain_maps::manifest::Effort;
use vibrochain_maps::summary::Summary;
use vibrochain_maps::sweep::{
    Assembly, Claim, Content, Ended, Grown, Job, Plan, Shard, ShardFlag, Store, Todo, Unassembled, Watcher, Work,
    Worked, Writer, work,
};
use vibrochain_maps::table::TableFile;
use vibrochain_maps::text::is_obeyed;

use crate::common::console::Console;
use crate::common::error::CliError;
use crate::common::progress::counter;
use crate::sweep::report::speed;

/// A table under way.
pub(crate) struct ChunkedRun<'a, C, S: Grid> {
    /// What is computed of each cell.
    pub(crate) content: &'a C,
    pub(crate) plan: &'a Plan<S>,
    pub(crate) pool: &'a ThreadPool,
    pub(crate) stop: &'a Stop,
    /// Whether chunks that are there are to be taken up.
    pub(crate) resume: bool,
    /// Steps of a cell, and what they are called.
    pub(crate) steps: (u64, &'static str),
    /// The command that goes on with it.
    pub(crate) again: String,
}

/// A table that has every row and is yet to be put in its place.
pub(crate) struct Gathered {
    pub(crate) table: TableFile,
    pub(crate) summary: Summary,
    pub(crate) effort: Effort,
    store: Store,
    /// The last chunk, if it has not been placed.
    last: Option<Writer>,
}

/// A table of which nothing is kept beside it.
pub(crate) struct Streamed {
    pub(crate) table: TableFile,
    pub(crate) summary: Summary,
    pub(crate) effort: Effort,
}

/// What was computed.
struct Computed<'a, C: Content<S>, S: Grid> {
    effort: Effort,
    /// The counts of the cells computed.
    summary: Summary,
    grown: Option<Grown<'a, C, S>>,
}

/// The plain file that a table's name leads to; none where it is written to as it comes, and can have neither a manifest beside
/// it nor chunks.
pub(crate) fn place(table: &Path) -> Result<Option<PathBuf>, CliError> {
    Ok(match Destination::of(table)? {
        Destination::Plain(place) => Some(place),
        Destination::StandardOutput | Destination::Direct(_) => None,
    })
}

/// Where the chunks of a table are kept until it is whole.
pub(crate) fn parts_path(table: &Path) -> PathBuf {
    let mut name = table.file_name().unwrap_or_default().to_owned();
    name.push(".parts");
    table.with_file_name(name)
}

/// The shard that was asked for, and the threads that its job has been given.
pub(crate) fn shard_of(flag: Option<ShardFlag>) -> Result<(Option<Shard>, Option<usize>), CliError> {
    let environment = |name: &str| std::env::var(name).ok();
    Ok(match flag {
        None => (None, None),
        Some(ShardFlag::Of(shard)) => (Some(shard), None),
        Some(ShardFlag::Slurm) => (Some(Shard::of_slurm(environment)?), Shard::threads_of_slurm(environment)?),
    })
}

/// Refuses to go on with a table that keeps no chunks.
pub(crate) fn nothing_to_resume(flag: &str, out: &Path) -> CliError {
    let name = out.display();
    CliError::Request(format!("--resume has nothing to go on with: {flag} {name} is no plain file, no chunks are kept"))
}

impl<S: Grid, C: Content<S>> ChunkedRun<'_, C, S> {
    /// Computes what is missing of a table, chunk by chunk, into the folder `parts`, and makes the table of all chunks.
    pub(crate) fn gather(
        &self,
        out: &Path,
        parts: &Path,
        watcher: &mut dyn Watcher<C::Item>,
        console: &mut Console<'_>,
    ) -> Result<Gathered, CliError> {
        let claim = if self.resume { Claim::Resume } else { Claim::Fresh };
        let store = Store::open(parts, self.plan, claim, self.stop)?;
        let along = if store.present()?.is_empty() {
            // Where nothing is finished nothing is lost by an early end.
            match Assembly::begin(self.content, self.plan, out, self.threads(), &mut *watcher) {
                Ok(assembly) => Some(assembly),
                Err(error) => {
                    store.remove(self.plan);
                    return Err(error.into());
                }
            }
        } else {
            None
        };
        let Computed { effort, summary, grown } = self.compute(&store, Shard::WHOLE, console, along)?;
        let (table, summary, last) = match grown {
            Some(Grown { table, last }) => (table.into_table(), summary, Some(last)),
            None => {
                let (table, summary) = self.read_back(out, &store, watcher)?;
                (table, summary, None)
            }
        };
        Ok(Gathered { table, summary, effort, store, last })
    }

    /// Puts the table and what belongs to it in their places, by `finish`, and removes the chunks.
    pub(crate) fn publish(
        &self,
        gathered: Gathered,
        place: &Path,
        console: &mut Console<'_>,
        finish: impl FnOnce(TableFile) -> Result<(), CliError>,
    ) -> Result<(), CliError> {
        let Gathered { table, store, last, .. } = gathered;
        if let Err(error) = finish(table) {
            // If it does not fit either, it is not among those that are told to be finished.
            let _ = last.map(Writer::place);
            return Err(match error {
                CliError::Interrupted => CliError::Paused(self.kept(&store, Shard::WHOLE)),
                CliError::Halted(path) => {
                    let (name, kept) = (path.display(), self.kept(&store, Shard::WHOLE));
                    CliError::Paused(format!("{name} was not read; {kept}"))
                }
                error => self.failed(&error, &store, Shard::WHOLE),
            });
        }
        drop(last);
        // The table's name must be on the disk before the chunks are not.
        sync_folder(place);
        let folder = store.folder().to_owned();
        if !store.remove(self.plan) {
            console.remark(&format!("{} holds other files and was left, without its chunks", folder.display()));
        }
        Ok(())
    }

    /// A table that goes to standard output, a pipe or a device: nothing is kept of it.
    pub(crate) fn stream(
        &self,
        out: &Path,
        watcher: &mut dyn Watcher<C::Item>,
        progress: bool,
    ) -> Result<Streamed, CliError> {
        let mut table = Assembly::begin(self.content, self.plan, out, self.threads(), watcher)?;
        let (steps, things) = self.steps;
        let bar = counter(self.plan.cells() * steps, 0, things, progress);
        let started = Instant::now();
        let whole = 0..self.plan.cells();
        let wanted = table.wants_cells();
        let ended = self
            .content
            .compute(&self.job(), &[whole], wanted, &|steps| bar.inc(steps), &mut |block| table.rows(&block.made));
        bar.finish_and_clear();
        let summary = match ended {
            Ended::Complete(summary) => summary,
            Ended::Stopped => {
                let name = out.display();
                return Err(CliError::Paused(format!("{name} has got a part of the table, nothing else was kept")));
            }
            Ended::Failed(error) => return Err(error.into()),
        };
        let effort = self.effort(&summary, started);
        Ok(Streamed { table: table.into_table(), summary, effort })
    }

    /// Computes the chunks of a shard, into the folder that `flag` names.
    pub(crate) fn shard(
        &self,
        flag: &str,
        folder: &Path,
        shard: Shard,
        console: &mut Console<'_>,
    ) -> Result<(), CliError> {
        if !folder.exists() {
            promises_folder(flag, folder)?;
        }
        let store = Store::open(folder, self.plan, Claim::Share, self.stop)?;
        let there = store.present()?;
        ensure!(
            self.resume || !shard.chunks(self.plan).any(|chunk| there.contains(&chunk)),
            "{} holds chunks of shard {}/{} already: go on with them by --resume, or name another folder to compute them again",
            folder.display(),
            shard.index,
            shard.count
        );
        let effort = self.compute(&store, shard, console, None)?.effort;
        let Shard { index, count } = shard;
        let (chunks, all) = (shard.chunks(self.plan).count(), self.plan.chunks());
        let (place, took) = (quoted(folder), speed(&effort));
        let then = format!("with all shards done: mapgen merge {place} --out map.csv");
        console.summary(&format!("shard {index}/{count}: {chunks} of {all} chunks in {place}; {took}\n{then}"));
        Ok(())
    }

    fn threads(&self) -> usize {
        self.pool.current_num_threads()
    }

    fn job(&self) -> Job<'_, S> {
        Job { scene: &self.plan.scene, pool: self.pool, stop: self.stop }
    }

    fn effort(&self, summary: &Summary, started: Instant) -> Effort {
        Effort {
            threads: self.threads(),
            computed_cells: summary.computed,
            wall_seconds: started.elapsed().as_secs_f64(),
        }
    }

    /// Makes the table of all chunks.
    fn read_back(
        &self,
        out: &Path,
        store: &Store,
        watcher: &mut dyn Watcher<C::Item>,
    ) -> Result<(TableFile, Summary), CliError> {
        let failed = |error: &dyn std::fmt::Display| self.failed(error, store, Shard::WHOLE);
        let begun = Assembly::begin(self.content, self.plan, out, self.threads(), watcher);
        let mut assembly = begun.map_err(|error| failed(&error))?;
        match assembly.chunks(store.folder(), self.stop) {
            Ok(summary) => Ok((assembly.into_table(), summary)),
            Err(Unassembled::Stopped) => Err(CliError::Paused(self.kept(store, Shard::WHOLE))),
            Err(Unassembled::Table(error)) => Err(failed(&error)),
            Err(Unassembled::Chunk(chunk, fault)) => {
                let place = Store::path(store.folder(), chunk);
                Err(failed(&format!("could not read {}: {fault}", place.display())))
            }
        }
    }

    /// Computes the chunks of a shard that are missing, and what can be had of the table on the way.
    fn compute<'a>(
        &self,
        store: &Store,
        shard: Shard,
        console: &mut Console<'_>,
        along: Option<Assembly<'a, C, S>>,
    ) -> Result<Computed<'a, C, S>, CliError> {
        let job = self.job();
        let Some(todo) = Todo::of(self.content, &job, self.plan, store, shard)? else {
            return Err(CliError::Paused(self.kept(store, shard)));
        };
        todo.damaged.iter().for_each(|remark| console.remark(remark));
        let cells = |chunk: &u64| self.plan.range(*chunk).count() as u64;
        let left: u64 = todo.chunks.iter().map(cells).sum();
        let (steps, things) = self.steps;
        let finished = todo.finished_cells;
        let bar = counter((left + finished) * steps, finished * steps, things, console.progress);
        let started = Instant::now();
        let tick = |steps| bar.inc(steps);
        let given = Work { content: self.content, job: &job, plan: self.plan, store };
        let Worked { ended, grown } = work(&given, &todo.chunks, tick, along);
        bar.finish_and_clear();
        match ended {
            Ended::Complete(summary) => Ok(Computed { effort: self.effort(&summary, started), summary, grown }),
            Ended::Stopped => Err(CliError::Paused(self.kept(store, shard))),
            Ended::Failed(error) => Err(self.failed(&error, store, shard)),
        }
    }

    fn failed(&self, error: &dyn std::fmt::Display, store: &Store, shard: Shard) -> CliError {
        if !store.folder().is_dir() {
            let (place, again) = (store.folder().display(), &self.again);
            return CliError::Computation(format!(
                "{error}: the folder {place} has vanished; start again with: {again}"
            ));
        }
        CliError::Computation(format!("{error}\n{}", self.kept(store, shard)))
    }

    /// What an early end leaves, and how to go on.
    fn kept(&self, store: &Store, shard: Shard) -> String {
        // Of a folder that cannot be read nothing is known to be finished.
        let there = store.present().unwrap_or_default();
        let finished = shard.chunks(self.plan).filter(|chunk| there.contains(chunk)).count();
        let (all, place) = (shard.chunks(self.plan).count(), store.folder().display());
        format!("{finished} of {all} chunks are finished, in {place}; go on with: {}", self.again)
    }
}

/// A path as a shell reads it, without a character that a terminal would obey.
pub(crate) fn quoted(path: &Path) -> String {
    let text = path.display().to_string();
    let plain = |c: char| c.is_alphanumeric() || "/._-+=:,@".contains(c);
    let quoted = |text: &str| format!("'{}'", text.replace('\'', r"'\''"));
    if !text.is_empty() && text.chars().all(plain) {
        return text;
    }
    if !text.chars().any(is_obeyed) {
        return quoted(&text);
    }
    // Each byte of such a character in octal, which every shell of today knows.
    let word = |c: char| match c {
        c if is_obeyed(c) => c.to_string().bytes().map(|byte| format!("\\{byte:03o}")).collect(),
        '\\' | '\'' => format!("\\{c}"),
        c => c.to_string(),
    };
    format!("$'{}'", text.chars().map(word).collect::<String>())
}
