//! `mapgen fate`: many perturbed runs from the breathers of a scene, and what they end in.

pub(crate) mod plot;
pub(crate) mod report;

use std::path::{Path, PathBuf};

use rayon::ThreadPool;
use vibrochain_fate::{CellFates, Diagram, Ensemble, Fates, From, MAX_POINTS};
use vibrochain_lattice::Stop;
use vibrochain_maps::error::MapError;
use vibrochain_maps::files::CsvFile;
use vibrochain_maps::grid::Grid;
use vibrochain_maps::numbers::Number;
use vibrochain_maps::scene::Scene;
use vibrochain_maps::structure::StructureScene;
use vibrochain_maps::sweep::{Content, Ended, Job, Plan, Settings, Watcher};

use crate::args::FateArgs;
use crate::common::answer::printed;
use crate::common::chunked_run::{ChunkedRun, nothing_to_resume, parts_path, place, quoted, shard_of};
use crate::common::console::{Console, destinations, interruptible};
use crate::common::error::CliError;
use crate::common::pictures::files::PictureFiles;
use crate::common::progress::counter;
use crate::common::swept_scene::SweptScene;
use crate::common::table_manifest::{Manifest, OfScene, beside};
use crate::common::threads::threads;
use crate::fate::plot::Plot;
use crate::fate::report::Totals;
use crate::sweep::report::grid;

/// The most runs of one command: years of work.
const MAX_RUNS: u64 = 100_000_000;

/// What manifests call the tables.
pub(crate) const ENDS: &str = "fate";
pub(crate) const SECTION: &str = "fate --diagram";

/// Points that a diagram keeps of each run, unless more or fewer are asked for.
const POINTS: u64 = 100;

/// Runs the subcommand.
///
/// # Errors
/// [`CliError`].
pub fn run(args: &FateArgs, console: &mut Console<'_>) -> Result<(), CliError> {
    let path = args.scene.clone();
    if interruptible(move || StructureScene::is_at(&path))? {
        of_scene::<StructureScene>(args, console)
    } else {
        of_scene::<Scene>(args, console)
    }
}

fn of_scene<S: SweptScene>(args: &FateArgs, console: &mut Console<'_>) -> Result<(), CliError> {
    let fates = asked(args);
    let ensemble = &fates.ensemble;
    let (path, settings, cells) = (args.scene.clone(), fates.settings(), fates.chunk_cells());
    let plan = interruptible(move || Plan::<S>::of_ensemble(&path, settings, cells))??;
    let scene = &plan.scene;
    // (clap does not ask for --diagram where something is given that conflicts with it.)
    if args.diagram.is_none() && (args.carry || args.points.is_some()) {
        let flag = if args.carry { "--carry" } else { "--points" };
        refuse!("{flag} is of a diagram: give --diagram FILE, too, without --starts");
    }
    // Where a diagram has no orbit to start from it starts from rest.
    let takes = |from| scene.takes(ensemble, from).map_err(CliError::Request);
    match args.diagram {
        Some(_) => takes(fates.from).or_else(|error| takes(From::Rest).map_err(|_| error))?,
        None => takes(fates.from)?,
    }
    let runs = scene.cells().saturating_mul(args.starts);
    if args.diagram.is_none() && runs > MAX_RUNS {
        let cells = scene.cells();
        refuse!("{cells} cells with --starts {} are {runs} runs, the limit is {MAX_RUNS}: give fewer", args.starts);
    }
    // (That of a shard is a folder.)
    let table = args.out.as_deref().filter(|_| args.shard.is_none());
    let place = table.map(place).transpose()?.flatten();
    let parts = place.as_ref().and(table).map(parts_path);
    let manifests = [beside(table)?, beside(args.diagram.as_deref())?];
    let files = [
        ("--out", args.out.as_deref()),
        ("the manifest of --out", manifests[0].as_deref()),
        ("the folder of chunks", parts.as_deref()),
        ("--diagram", args.diagram.as_deref()),
        ("the manifest of --diagram", manifests[1].as_deref()),
        ("--plot", args.plot.as_deref()),
    ];
    let taken = destinations(args.json, &[("the scene", Some(&args.scene))], &files)?;
    match args.diagram.as_deref() {
        Some(path) => diagram(args, path, scene, ensemble, taken, console),
        None => Ends { args, plan: &plan, fates: &fates, taken }.run(place.as_deref(), console),
    }
}

/// What is asked of every cell.
fn asked(args: &FateArgs) -> Fates {
    let ensemble = Ensemble {
        starts: args.starts,
        size: args.perturb,
        seed: args.seed,
        periods: args.periods,
        transient: args.transient,
        tolerance: args.tolerance,
        leave: args.leave,
        in_sequence: args.in_sequence,
    };
    Fates { ensemble, from: args.breathers }
}

/// The command that computes chunks of an ensemble, but for its last words.
pub(crate) fn command(scene_file: &Path, out: &Path, settings: &Settings) -> Vec<String> {
    let mut words = vec![format!("mapgen fate {} --out {}", quoted(scene_file), quoted(out))];
    let usual = Fates::default().settings();
    let given = settings.iter().filter(|(name, value)| usual.get(*name) != Some(value));
    let flag = |(name, value): (&String, &String)| {
        if value == "true" { format!("--{name}") } else { format!("--{name} {value}") }
    };
    words.extend(given.map(flag));
    words
}

/// What has been seen of the cells: their counts, and what pictures need.
pub(crate) struct Seen<'a, S> {
    scene: &'a S,
    ensemble: &'a Ensemble,
    plot: Plot,
    totals: Totals,
    rows: u64,
}

impl<'a, S: SweptScene> Seen<'a, S> {
    /// # Errors
    /// [`CliError::Request`] for pictures that cannot be.
    pub(crate) fn new(scene: &'a S, ensemble: &'a Ensemble, files: PictureFiles) -> Result<Self, CliError> {
        let plot = Plot::of_ends(files, scene)?;
        Ok(Self { scene, ensemble, plot, totals: Totals::default(), rows: 0 })
    }

    /// What it all has come to.
    pub(crate) fn answer(&self, json: bool) -> Result<String, CliError> {
        let Self { scene, ensemble, totals, .. } = self;
        if json {
            printed(&totals.answer(scene.about()?, ensemble))
        } else {
            Ok(totals.as_text(&grid(*scene), ensemble))
        }
    }

    /// Writes what the table is of, and draws the pictures.
    pub(crate) fn finish(self, manifest: Manifest) -> Result<(), CliError> {
        manifest.finish(ENDS, self.rows, &OfScene::new(self.scene, Some(self.ensemble)))?;
        self.plot.finish(self.scene, self.ensemble)
    }
}

impl<S> Watcher<CellFates> for Seen<'_, S> {
    fn looks(&self) -> bool {
        true
    }

    fn begin(&mut self) {
        self.totals = Totals::default();
        self.rows = 0;
        self.plot.begin();
    }

    fn cell(&mut self, _: u64, cell: &CellFates) {
        self.totals.add(cell);
        // A cell without any has a row, too.
        self.rows += cell.breathers.len().max(1) as u64;
        self.plot.see(cell);
    }
}

/// Many runs from the breathers of every cell.
struct Ends<'a, S: Grid> {
    args: &'a FateArgs,
    plan: &'a Plan<S>,
    fates: &'a Fates,
    /// Whether a file goes to standard output.
    taken: bool,
}

impl<S: SweptScene> Ends<'_, S> {
    /// `place` is the plain file that --out leads to, if that is one.
    fn run(&self, place: Option<&Path>, console: &mut Console<'_>) -> Result<(), CliError> {
        let Self { args, plan, fates, taken } = *self;
        args.page.checked(args.plot.is_some(), "--plot")?;
        let (shard, given) = shard_of(args.shard)?;
        if let (Some(shard), Some(folder)) = (shard, &args.out) {
            let stop = (console.interrupt)()?;
            let pool = threads(console.threads.or(given))?;
            return self.chunked(&pool, &stop, console.threads).shard("--out", folder, shard, console);
        }
        let stop = (console.interrupt)()?;
        let files = PictureFiles::one("--plot", args.plot.as_deref(), &args.page)?;
        let mut seen = Seen::new(&plan.scene, &fates.ensemble, files)?;
        // Destinations first: an impossible one should not cost a computation.
        if let (Some(_), Some(out)) = (place, &args.out) {
            drop(fates.create(out, &plan.scene, 1)?);
        }
        let manifest = Manifest::create(beside(args.out.as_deref())?.as_deref())?;
        let pool = threads(console.threads)?;
        let run = self.chunked(&pool, &stop, console.threads);
        // Two kinds of lines on one terminal are none.
        let progress = console.progress && !taken;
        match (&args.out, place) {
            (None, _) => {
                self.alone(&run, &mut seen, progress)?;
                console.answer(&seen.answer(args.json)?, args.json, taken)?;
                seen.finish(manifest)
            }
            (Some(out), None) if args.resume => Err(nothing_to_resume("--out", out)),
            (Some(out), None) => {
                run.stream(out, &mut seen, progress)?.table.commit()?;
                console.answer(&seen.answer(args.json)?, args.json, taken)?;
                seen.finish(manifest)
            }
            (Some(out), Some(place)) => {
                let gathered = run.gather(out, &parts_path(out), &mut seen, console)?;
                let answer = seen.answer(args.json)?;
                run.publish(gathered, place, console, |table| {
                    table.commit()?;
                    seen.finish(manifest)
                })?;
                console.answer(&answer, args.json, taken)
            }
        }
    }

    /// Without a table.
    fn alone(&self, run: &ChunkedRun<'_, Fates, S>, seen: &mut Seen<'_, S>, progress: bool) -> Result<(), CliError> {
        let (scene, (steps, things)) = (&self.plan.scene, run.steps);
        let bar = counter(scene.cells() * steps, 0, things, progress);
        let job = Job { scene, pool: run.pool, stop: run.stop };
        let whole = 0..scene.cells();
        let ended = self.fates.compute(&job, &[whole], true, &|runs| bar.inc(runs), &mut |block| {
            block.made.cells.iter().for_each(|(number, cell)| seen.cell(*number, cell));
            Ok(())
        });
        bar.finish_and_clear();
        if is_stopped(ended)? { Err(CliError::Interrupted) } else { Ok(()) }
    }

    /// `threads` as asked for.
    fn chunked<'a>(&'a self, pool: &'a ThreadPool, stop: &'a Stop, threads: Option<usize>) -> ChunkedRun<'a, Fates, S> {
        let Self { args, plan, fates, .. } = *self;
        let again = self.again(threads);
        let steps = (args.starts, "runs");
        ChunkedRun { content: fates, plan, pool, stop, resume: args.resume, steps, again }
    }

    /// The command that goes on with this one.
    fn again(&self, threads: Option<usize>) -> String {
        let Self { args, fates, .. } = *self;
        let Some(out) = &args.out else { return String::new() };
        let mut words = command(&args.scene, out, &fates.settings());
        words.extend(args.plot.iter().map(|path| format!("--plot {}", quoted(path))));
        words.extend(args.page.words());
        words.extend(args.json.then(|| "--json".to_owned()));
        words.extend(threads.map(|threads| format!("--threads {threads}")));
        words.extend(args.shard.map(|shard| format!("--shard {shard}")));
        words.push("--resume".to_owned());
        words.join(" ")
    }
}

fn diagram<S: SweptScene>(
    args: &FateArgs,
    path: &Path,
    scene: &S,
    ensemble: &Ensemble,
    taken: bool,
    console: &mut Console<'_>,
) -> Result<(), CliError> {
    let [axis] = Grid::axes(scene) else {
        let axes = Grid::axes(scene).len();
        refuse!("--diagram needs a scene with one axis, this one has {axes}");
    };
    let most = args.periods.min(MAX_POINTS);
    let points = args.points.unwrap_or(POINTS.min(most));
    ensure!((1..=most).contains(&points), "--points {points} is out of range: give a whole number from 1 to {most}");
    if args.carry {
        scene.carries()?;
    }
    let diagram = Diagram { scene, ensemble, points, carry: args.carry };
    let sites = scene.watched();
    let columns = |name: &'static str| sites.iter().map(move |site| format!("{name}_{site}"));
    let header = [scene.name_of(axis.parameter), "period".to_owned()];
    let header = header.into_iter().chain(columns("displacement")).chain(columns("velocity"));
    let stop = (console.interrupt)()?;
    let mut file = CsvFile::create("--diagram", path, header)?;
    let manifest = Manifest::create(beside(Some(path))?.as_deref())?;
    let mut plot = Plot::of_diagram(PictureFiles::one("--plot", args.plot.as_deref(), &args.page)?, scene)?;
    let pool = threads(console.threads)?;
    let bar = counter(scene.cells(), 0, "cells", console.progress && !taken);
    let job = Job { scene, pool: &pool, stop: &stop };
    let (mut cells, mut incomplete, mut rows) = (0_u64, 0_u64, 0_u64);
    let ended = diagram.compute(
        &job,
        |cells| bar.inc(cells),
        |column| {
            cells += 1;
            incomplete += u64::from(!column.complete);
            let value = axis.value(column.number as usize);
            rows += column.points.len() as u64;
            for point in &column.points {
                if let Some((displacement, _)) = point.states.first() {
                    plot.see_point(value, *displacement);
                }
                let states = point.states.iter().map(|state| state.0).chain(point.states.iter().map(|state| state.1));
                let row = [Number(value).to_string(), point.period.to_string()];
                file.row(row.into_iter().chain(states.map(|x| Number(x).to_string())))?;
            }
            Ok::<(), MapError>(())
        },
    );
    bar.finish_and_clear();
    let stopped = is_stopped(ended)?;
    if !stopped || cells > 0 {
        file.finish()?;
        manifest.finish(SECTION, rows, &OfScene::new(scene, Some(ensemble)))?;
    }
    ensure!(!stopped, kept(&args.diagram, args.plot.is_some(), cells, scene.cells()));
    let carried = if args.carry { ", each from the end of the one before" } else { "" };
    let mut text = format!("{cells} runs of {} periods{carried}, {points} points each\n", args.periods);
    if incomplete > 0 {
        text += &format!("{incomplete} of them could not be completed\n");
    }
    console.answer(&text, false, taken)?;
    plot.finish(scene, ensemble)
}

fn is_stopped<T>(ended: Ended<MapError, T>) -> Result<bool, CliError> {
    match ended {
        Ended::Complete(_) => Ok(false),
        Ended::Stopped => Ok(true),
        Ended::Failed(error) => Err(error.into()),
    }
}

/// What an early end leaves.
fn kept(file: &Option<PathBuf>, plot: bool, done: u64, cells: u64) -> CliError {
    let picture = if plot { "; no picture was drawn" } else { "" };
    match file {
        Some(path) if done > 0 => {
            CliError::Paused(format!("{} holds the first {done} of {cells} cells, whole{picture}", path.display()))
        }
        _ => CliError::Interrupted,
    }
}
