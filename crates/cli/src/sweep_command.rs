//! `mapgen sweep`: scene → plan → chunks → files → summary.

use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;
use std::time::{Duration, Instant};

use clap::ValueEnum;
use indicatif::{HumanCount, ProgressBar, ProgressDrawTarget, ProgressState, ProgressStyle};
use rayon::ThreadPool;
use vibrochain_lattice::Short;

use crate::args::{ColorName, SweepArgs};
use crate::console::{Console, nothing_else};
use crate::error::CliError;
use crate::estimate::estimate;
use crate::pictures::Pictures;
use crate::report::{report, speed};
use crate::threads::threads;
use vibrochain_maps::cell::Cell;
use vibrochain_maps::files::{Destination, distinct, promises_folder};
use vibrochain_maps::files::{Output, settle_names};
use vibrochain_maps::manifest::{Effort, Run, manifest};
use vibrochain_maps::numbers::Number;
use vibrochain_maps::summary::Summary;
use vibrochain_maps::sweep::{
    Assembly, Claim, Ended, Grown, Job, Plan, Shard, ShardFlag, Store, Todo, Unassembled, Worked, Writer, blocks, work,
};
use vibrochain_maps::table::{Form, Rows, TableFile, stem};
use vibrochain_maps::text::is_obeyed;

/// The plain file that a table's name leads to; none where it is written to as it comes, and can have neither a manifest beside
/// it nor chunks.
pub(crate) fn place(table: &Path) -> Result<Option<PathBuf>, CliError> {
    Ok(match Destination::of(table)? {
        Destination::Plain(place) => Some(place),
        Destination::StandardOutput | Destination::Direct(_) => None,
    })
}

/// Where the manifest of a table goes: map.csv, map.csv.gz and map → map.manifest.json.
pub(crate) fn manifest_path(table: &Path) -> PathBuf {
    let name = table.file_name().unwrap_or_default().to_string_lossy().into_owned();
    table.with_file_name(format!("{}.manifest.json", stem(&name)))
}

/// Where the chunks of a table are kept until it is whole.
fn parts_path(table: &Path) -> PathBuf {
    let mut name = table.file_name().unwrap_or_default().to_owned();
    name.push(".parts");
    table.with_file_name(name)
}

/// Runs the subcommand.
///
/// # Errors
/// [`CliError`].
pub fn run(args: &SweepArgs, console: &mut Console<'_>) -> Result<(), CliError> {
    let plan = Plan::read(&args.scene, args.threshold)?;
    let environment = |name: &str| std::env::var(name).ok();
    let (shard, given) = match args.shard {
        None => (None, None),
        Some(ShardFlag::Of(shard)) => (Some(shard), None),
        Some(ShardFlag::Slurm) => (Some(Shard::of_slurm(environment)?), Shard::threads_of_slurm(environment)?),
    };
    let pool = threads(console.threads.or(given))?;
    if args.dry_run {
        if let (Some(out), None) = (&args.out, shard) {
            Form::of(out)?;
        }
        let stop = (console.interrupt)()?;
        let estimate = estimate(&plan, shard.unwrap_or(Shard::WHOLE), pool.current_num_threads(), &stop)?;
        return console.print(&estimate);
    }
    let Some(out) = &args.out else {
        return Err(CliError::Request("--out is missing: name the table to write".to_owned()));
    };
    let run = SweepRun { args, threads: console.threads, plan: &plan, pool: &pool };
    match shard {
        Some(shard) => run.shard(out, shard, console),
        None => run.whole(out, console),
    }
}

/// A sweep under way.
struct SweepRun<'a> {
    args: &'a SweepArgs,
    /// As asked for.
    threads: Option<usize>,
    plan: &'a Plan,
    pool: &'a ThreadPool,
}

/// What was computed.
struct Computed<'a> {
    effort: Effort,
    /// The counts of the cells computed.
    summary: Summary,
    grown: Option<Grown<'a>>,
}

impl SweepRun<'_> {
    fn whole(&self, out: &Path, console: &mut Console<'_>) -> Result<(), CliError> {
        let Some(place) = place(out)? else { return self.streamed(out, console) };
        let (manifest_file, parts) = (manifest_path(out), parts_path(out));
        let wanted = &self.args.pictures;
        let taken = distinct(
            &[("the scene", Some(&self.args.scene))],
            &[
                ("--out", Some(out)),
                ("the manifest of --out", Some(&manifest_file)),
                ("the folder of chunks", Some(&parts)),
                ("--png", wanted.png.as_deref()),
                ("--svg", wanted.svg.as_deref()),
                ("--pdf", wanted.pdf.as_deref()),
            ],
        )?;
        nothing_else(self.args.json, taken)?;
        Form::of(out)?;
        // Destinations first: an impossible one should not cost a computation.
        drop(TableFile::create(out, &self.plan.scene)?);
        Output::create(&manifest_file)?;
        let mut pictures = Pictures::plan(wanted, &self.plan.scene)?;
        let stop = (console.interrupt)()?;
        let claim = if self.args.resume { Claim::Resume } else { Claim::Fresh };
        let store = Store::open(&parts, self.plan, claim)?;
        let along = if store.present()?.is_empty() {
            // Where nothing is finished nothing is lost by an early end.
            match Assembly::begin(self.plan, out, &mut pictures) {
                Ok(assembly) => Some(assembly),
                Err(error) => {
                    store.remove(self.plan);
                    return Err(error.into());
                }
            }
        } else {
            None
        };
        let Computed { effort, summary, grown } = self.compute(&store, Shard::WHOLE, &stop, console, along)?;

        let (table, summary, last) = match grown {
            Some(Grown { table, last }) => (table.into_table(), summary, Some(last)),
            None => {
                let (table, summary) = self.read_back(out, &store, &mut pictures, &stop)?;
                (table, summary, None)
            }
        };
        let manifest = manifest_text(self.plan, &summary, Some(effort));
        let (bar, mut told) = (console.progress, String::new());
        let finish = || {
            told = pictures.find_borders(self.pool, &stop, bar)?;
            table.commit()?;
            Output::create(&manifest_file)?.finish_with(manifest.as_bytes())?;
            pictures.finish()
        };
        if let Err(error) = finish() {
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
        settle_names(&place);
        let folder = store.folder().to_owned();
        if !store.remove(self.plan) {
            console.remark(&format!("{} holds other files and was left, without its chunks", folder.display()));
        }
        tell(self.args.json, &manifest, || report(&self.plan.scene, &summary, Some(&effort)) + &told, console)
    }

    /// A table that goes to standard output, a pipe or a device: nothing is kept of it.
    fn streamed(&self, out: &Path, console: &mut Console<'_>) -> Result<(), CliError> {
        let name = out.display();
        if self.args.resume {
            let message =
                format!("--resume has nothing to go on with: --out {name} is no plain file, no chunks are kept");
            return Err(CliError::Request(message));
        }
        let wanted = &self.args.pictures;
        let taken = distinct(
            &[("the scene", Some(&self.args.scene))],
            &[
                ("--out", Some(out)),
                ("--png", wanted.png.as_deref()),
                ("--svg", wanted.svg.as_deref()),
                ("--pdf", wanted.pdf.as_deref()),
            ],
        )?;
        nothing_else(self.args.json, taken)?;
        let scene = &self.plan.scene;
        let mut pictures = Pictures::plan(wanted, scene)?;
        let stop = (console.interrupt)()?;
        let mut table = Assembly::begin(self.plan, out, &mut pictures)?;
        // Two kinds of lines on one terminal are none.
        let bar = progress(self.plan.cells(), 0, console.progress && !taken);
        let started = Instant::now();
        let made = |range: Range<u64>, cells: &[Cell]| {
            bar.inc(range.end - range.start);
            Rows::of(scene, range, cells)
        };
        let job = Job { scene, pool: self.pool, stop: &stop };
        let whole = 0..self.plan.cells();
        let ended = blocks(&job, &[whole], made, |block| table.rows(&block.made));
        bar.finish_and_clear();
        let summary = match ended {
            Ended::Complete(summary) => summary,
            Ended::Stopped => {
                return Err(CliError::Paused(format!("{name} has got a part of the table, nothing else was kept")));
            }
            Ended::Failed(error) => return Err(error.into()),
        };
        let effort = self.effort(&summary, started);
        table.into_table().commit()?;
        let bar = console.progress && !taken;
        let told = pictures.find_borders(self.pool, &stop, bar).map_err(|error| match error {
            CliError::Interrupted => {
                CliError::Paused(format!("{name} has got the whole table, there are no pictures of it"))
            }
            error => error,
        })?;
        pictures.finish()?;
        let manifest = manifest_text(self.plan, &summary, Some(effort));
        tell(self.args.json, &manifest, || report(scene, &summary, Some(&effort)) + &told, console)
    }

    fn effort(&self, summary: &Summary, started: Instant) -> Effort {
        Effort {
            threads: self.pool.current_num_threads(),
            computed_cells: summary.cells(),
            wall_seconds: started.elapsed().as_secs_f64(),
        }
    }

    /// Makes the table of all chunks.
    fn read_back(
        &self,
        out: &Path,
        store: &Store,
        pictures: &mut Pictures,
        stop: &AtomicBool,
    ) -> Result<(TableFile, Summary), CliError> {
        let failed = |error: &dyn std::fmt::Display| self.failed(error, store, Shard::WHOLE);
        let mut assembly = Assembly::begin(self.plan, out, pictures).map_err(|error| failed(&error))?;
        match assembly.chunks(self.plan, store.folder(), stop) {
            Ok(summary) => Ok((assembly.into_table(), summary)),
            Err(Unassembled::Stopped) => Err(CliError::Paused(self.kept(store, Shard::WHOLE))),
            Err(Unassembled::Table(error)) => Err(failed(&error)),
            Err(Unassembled::Chunk(chunk, fault)) => {
                let place = Store::path(store.folder(), chunk);
                Err(failed(&format!("could not read {}: {fault}", place.display())))
            }
        }
    }

    fn shard(&self, folder: &Path, shard: Shard, console: &mut Console<'_>) -> Result<(), CliError> {
        if !folder.exists() {
            promises_folder("--out", folder)?;
        }
        distinct(&[("the scene", Some(&self.args.scene))], &[("--out", Some(folder))])?;
        let stop = (console.interrupt)()?;
        let store = Store::open(folder, self.plan, Claim::Share)?;
        let there = store.present()?;
        if !self.args.resume && shard.chunks(self.plan).any(|chunk| there.contains(&chunk)) {
            let message = format!(
                "{} holds chunks of shard {}/{} already: go on with them by --resume, or remove them to compute them again",
                folder.display(),
                shard.index,
                shard.count
            );
            return Err(CliError::Request(message));
        }
        let effort = self.compute(&store, shard, &stop, console, None)?.effort;
        let Shard { index, count } = shard;
        let (chunks, all) = (shard.chunks(self.plan).count(), self.plan.chunks());
        let (place, took) = (quoted(folder), speed(&effort));
        let then = format!("with all shards done: mapgen merge {place} --out map.csv");
        console.summary(&format!("shard {index}/{count}: {chunks} of {all} chunks in {place}; {took}\n{then}"));
        Ok(())
    }

    /// Computes the chunks of a shard that are missing, and what can be had of the table on the way.
    fn compute<'a>(
        &self,
        store: &Store,
        shard: Shard,
        stop: &AtomicBool,
        console: &mut Console<'_>,
        along: Option<Assembly<'a>>,
    ) -> Result<Computed<'a>, CliError> {
        let job = Job { scene: &self.plan.scene, pool: self.pool, stop };
        let Some(todo) = Todo::of(&job, self.plan, store, shard)? else {
            return Err(CliError::Paused(self.kept(store, shard)));
        };
        todo.damaged.iter().for_each(|remark| console.remark(remark));
        let cells = |chunk: &u64| self.plan.range(*chunk).count() as u64;
        let left: u64 = todo.chunks.iter().map(cells).sum();
        let bar = progress(left + todo.finished_cells, todo.finished_cells, console.progress);
        let started = Instant::now();
        let Worked { ended, grown } = work(&job, self.plan, store, &todo.chunks, |cells| bar.inc(cells), along);
        bar.finish_and_clear();
        match ended {
            Ended::Complete(summary) => Ok(Computed { effort: self.effort(&summary, started), summary, grown }),
            Ended::Stopped => Err(CliError::Paused(self.kept(store, shard))),
            Ended::Failed(error) => Err(self.failed(&error, store, shard)),
        }
    }

    fn failed(&self, error: &dyn std::fmt::Display, store: &Store, shard: Shard) -> CliError {
        if !store.folder().is_dir() {
            let (place, again) = (store.folder().display(), self.command());
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
        format!("{finished} of {all} chunks are finished, in {place}; go on with: {}", self.command())
    }

    /// The command that goes on with this sweep.
    fn command(&self) -> String {
        let mut words = vec!["mapgen sweep".to_owned(), quoted(&self.args.scene)];
        let pictures = &self.args.pictures;
        for (flag, path) in
            [("--out", &self.args.out), ("--png", &pictures.png), ("--svg", &pictures.svg), ("--pdf", &pictures.pdf)]
        {
            words.extend(path.iter().map(|path| format!("{flag} {}", quoted(path))));
        }
        words.extend(
            pictures.slice.iter().map(|(parameter, value)| format!("--slice {}={}", parameter.name(), Number(*value))),
        );
        if let Some(color) = pictures.color.to_possible_value().filter(|_| pictures.color != ColorName::default()) {
            words.push(format!("--color {}", color.get_name()));
        }
        if pictures.curves {
            words.push("--curves".to_owned());
        }
        if pictures.palette != Default::default() {
            words.push("--palette paper".to_owned());
        }
        words.extend(self.args.threshold.map(|threshold| format!("--threshold {}", Short(threshold))));
        words.extend(self.threads.map(|threads| format!("--threads {threads}")));
        words.extend(self.args.shard.map(|shard| format!("--shard {shard}")));
        words.push("--resume".to_owned());
        words.join(" ")
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

/// The manifest of a table, as text.
pub(crate) fn manifest_text(plan: &Plan, summary: &Summary, effort: Option<Effort>) -> String {
    let scene_file = plan.scene_file.display().to_string();
    let about = Run {
        scene_file: &scene_file,
        scene: &plan.scene,
        version: &plan.maker.version,
        revision: plan.maker.revision.as_deref(),
        summary,
        effort,
    };
    format!("{:#}\n", manifest(&about))
}

/// What is told at the end: the manifest, if it was asked for, or a summary.
pub(crate) fn tell(
    json: bool,
    manifest: &str,
    summary: impl FnOnce() -> String,
    console: &mut Console<'_>,
) -> Result<(), CliError> {
    if json {
        return console.print(manifest);
    }
    console.summary(&summary());
    Ok(())
}

fn progress(cells: u64, finished: u64, wanted: bool) -> ProgressBar {
    if !wanted {
        return ProgressBar::hidden();
    }
    let bar = ProgressBar::with_draw_target(Some(cells), ProgressDrawTarget::stderr()).with_position(finished);
    // What earlier runs have done tells nothing of this one's speed.
    bar.reset_eta();
    let template = "{bar:32} {percent:>3}%  {human_pos}/{human_len} cells  {rate} cells/s  {eta} left";
    if let Ok(style) = ProgressStyle::with_template(template) {
        // A broken line of progress is no reason to stop: the result of writing it is left alone.
        bar.set_style(style.with_key("rate", |state: &ProgressState, line: &mut dyn std::fmt::Write| {
            let _ = write!(line, "{}", HumanCount(state.per_sec() as u64));
        }));
    }
    bar.enable_steady_tick(Duration::from_millis(200));
    bar
}
