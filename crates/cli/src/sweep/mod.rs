//! `mapgen sweep`: scene → plan → chunks → files → summary.

pub mod draw;
pub(crate) mod estimate;
pub mod merge;
pub(crate) mod report;

use std::path::Path;

use rayon::ThreadPool;
use vibrochain_lattice::{Short, Stop};

use crate::args::{QuantityName, SweepArgs};
use crate::common::chunked_run::{ChunkedRun, Streamed, nothing_to_resume, parts_path, place, quoted, shard_of};
use crate::common::console::{Console, destinations, interruptible};
use crate::common::error::CliError;
use crate::common::swept_scene::SweptScene;
use crate::common::table_manifest::manifest_path;
use crate::common::threads::threads;
use crate::sweep::estimate::estimate;
use crate::sweep::report::report;
use vibrochain_maps::files::{Output, distinct};
use vibrochain_maps::grid::Grid;
use vibrochain_maps::manifest::{Effort, Run, manifest};
use vibrochain_maps::numbers::Number;
use vibrochain_maps::scene::Scene;
use vibrochain_maps::structure::StructureScene;
use vibrochain_maps::summary::Summary;
use vibrochain_maps::sweep::{Cells, Content, Plan, Shard};
use vibrochain_maps::table::Form;

/// Runs the subcommand.
///
/// # Errors
/// [`CliError`].
pub fn run(args: &SweepArgs, console: &mut Console<'_>) -> Result<(), CliError> {
    let path = args.scene.clone();
    if interruptible(move || StructureScene::is_at(&path))? {
        swept::<StructureScene>(args, console)
    } else {
        swept::<Scene>(args, console)
    }
}

fn swept<S: SweptScene>(args: &SweepArgs, console: &mut Console<'_>) -> Result<(), CliError> {
    let (path, threshold) = (args.scene.clone(), args.threshold);
    let plan = interruptible(move || Plan::<S>::read(&path, threshold))??;
    let (shard, given) = shard_of(args.shard)?;
    plan.scene.remark().iter().for_each(|remark| console.summary(remark));
    let pool = threads(console.threads.or(given))?;
    if args.dry_run {
        if let (Some(out), None) = (&args.out, shard) {
            Form::of(out)?;
        }
        let stop = (console.interrupt)()?;
        let estimate = estimate(&plan, shard.unwrap_or(Shard::WHOLE), &pool, &stop)?;
        return console.print(&estimate);
    }
    let Some(out) = &args.out else {
        refuse!("--out is missing: name the table to write");
    };
    let sweep = Sweep { args, out, plan: &plan, pool: &pool };
    match shard {
        Some(shard) => {
            distinct(&[("the scene", Some(&args.scene))], &[("--out", Some(out))])?;
            let stop = (console.interrupt)()?;
            sweep.run(&stop, console.threads).shard("--out", out, shard, console)
        }
        None => sweep.whole(console),
    }
}

/// What was asked of a sweep.
struct Sweep<'a, S: Grid> {
    args: &'a SweepArgs,
    out: &'a Path,
    plan: &'a Plan<S>,
    pool: &'a ThreadPool,
}

impl<S: SweptScene> Sweep<'_, S> {
    /// `threads` as asked for.
    fn run<'a>(&'a self, stop: &'a Stop, threads: Option<usize>) -> ChunkedRun<'a, Cells, S> {
        let (plan, pool, resume) = (self.plan, self.pool, self.args.resume);
        ChunkedRun { content: &Cells, plan, pool, stop, resume, steps: (1, "cells"), again: self.command(threads) }
    }

    fn whole(&self, console: &mut Console<'_>) -> Result<(), CliError> {
        let (out, scene) = (self.out, &self.plan.scene);
        let Some(place) = place(out)? else { return self.streamed(console) };
        let (manifest_file, parts) = (manifest_path(out), parts_path(out));
        let wanted = &self.args.pictures;
        let (chunks, manifest) =
            (("the folder of chunks", Some(&*parts)), ("the manifest of --out", Some(&*manifest_file)));
        let outputs = wanted.beside(&[("--out", Some(out)), manifest, chunks]);
        destinations(self.args.json, &[("the scene", Some(&self.args.scene))], &outputs)?;
        Form::of(out)?;
        let stop = (console.interrupt)()?;
        // Destinations first: an impossible one should not cost a computation.
        drop(Cells.create(out, scene, 1)?);
        Output::create(&manifest_file)?;
        let mut pictures = scene.pictures(wanted, self.args.show)?;
        let run = self.run(&stop, console.threads);
        let gathered = run.gather(out, &parts, &mut pictures, console)?;
        let (summary, effort) = (gathered.summary.clone(), gathered.effort);
        let manifest = manifest_text(self.plan, &summary, Some(effort));
        let (bar, mut told) = (console.progress, String::new());
        run.publish(gathered, &place, console, |table| {
            told = pictures.find_borders(self.pool, &stop, bar)?;
            table.commit()?;
            Output::create(&manifest_file)?.finish_with(manifest.as_bytes())?;
            pictures.finish()
        })?;
        tell(self.args.json, &manifest, || report(scene, &summary, Some(&effort)) + &told, console)
    }

    /// A table that goes to standard output, a pipe or a device: nothing is kept of it.
    fn streamed(&self, console: &mut Console<'_>) -> Result<(), CliError> {
        let (out, scene) = (self.out, &self.plan.scene);
        let name = out.display();
        ensure!(!self.args.resume, nothing_to_resume("--out", out));
        let wanted = &self.args.pictures;
        let taken = destinations(
            self.args.json,
            &[("the scene", Some(&self.args.scene))],
            &wanted.beside(&[("--out", Some(out))]),
        )?;
        let stop = (console.interrupt)()?;
        let mut pictures = scene.pictures(wanted, self.args.show)?;
        // Two kinds of lines on one terminal are none.
        let bar = console.progress && !taken;
        let Streamed { table, summary, effort } = self.run(&stop, console.threads).stream(out, &mut pictures, bar)?;
        table.commit()?;
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

    /// The command that goes on with this sweep.
    fn command(&self, threads: Option<usize>) -> String {
        let mut words = vec!["mapgen sweep".to_owned(), quoted(&self.args.scene)];
        let pictures = &self.args.pictures;
        let files = self.args.out.iter().map(|out| ("--out", out.as_path())).chain(pictures.files());
        words.extend(files.map(|(flag, path)| format!("{flag} {}", quoted(path))));
        words.extend(
            pictures.slice.iter().map(|(parameter, value)| format!("--slice {}={}", parameter.name(), Number(*value))),
        );
        if self.args.show != QuantityName::default() {
            words.push(format!("--show {}", self.args.show));
        }
        if pictures.curves {
            words.push("--curves".to_owned());
        }
        if pictures.palette != Default::default() {
            words.push("--palette paper".to_owned());
        }
        words.extend(pictures.page.words());
        words.extend(self.args.threshold.map(|threshold| format!("--threshold {}", Short(threshold))));
        words.extend(threads.map(|threads| format!("--threads {threads}")));
        words.extend(self.args.shard.map(|shard| format!("--shard {shard}")));
        words.push("--resume".to_owned());
        words.join(" ")
    }
}

/// The manifest of a table, as text.
pub(crate) fn manifest_text<S: Grid>(plan: &Plan<S>, summary: &Summary, effort: Option<Effort>) -> String {
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
