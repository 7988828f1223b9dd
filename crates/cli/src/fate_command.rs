//! `mapgen fate`: many perturbed runs from the breathers of a scene, and what they end in.

use std::path::PathBuf;
use std::time::Duration;

use indicatif::{ProgressBar, ProgressStyle};
use vibrochain_fate::{Diagram, Ended, Ensemble, From, MAX_POINTS, fates, table};
use vibrochain_maps::error::MapError;
use vibrochain_maps::files::{CsvFile, distinct};
use vibrochain_maps::numbers::Number;
use vibrochain_maps::scene::Scene;
use vibrochain_maps::sweep::Job;

use crate::args::{FateArgs, StartFrom};
use crate::console::{Console, nothing_else};
use crate::error::CliError;
use crate::fate_plot::Plot;
use crate::fate_report::Totals;
use crate::threads::threads;

/// The most runs of one command: years of work.
const MAX_RUNS: u64 = 100_000_000;

/// Points that a diagram keeps of each run, unless more or fewer are asked for.
const POINTS: u64 = 100;

/// Runs the subcommand.
///
/// # Errors
/// [`CliError`].
pub fn run(args: &FateArgs, console: &mut Console<'_>) -> Result<(), CliError> {
    let scene = Scene::read(&args.scene)?;
    let ensemble = Ensemble {
        starts: args.starts,
        size: args.perturb,
        seed: args.seed,
        periods: args.periods,
        transient: args.transient,
        tolerance: args.tolerance,
        leave: args.leave,
    };
    // (clap does not ask for --diagram where something is given that conflicts with it.)
    if args.diagram.is_none() && (args.carry || args.points.is_some()) {
        let flag = if args.carry { "--carry" } else { "--points" };
        return Err(CliError::Request(format!("{flag} is of a diagram: give --diagram FILE, too, without --starts")));
    }
    ensemble.check(scene.base.sites()).map_err(|error| CliError::Request(error.to_string()))?;
    let runs = scene.cells().saturating_mul(args.starts);
    if args.diagram.is_none() && runs > MAX_RUNS {
        let cells = scene.cells();
        let message =
            format!("{cells} cells with --starts {} are {runs} runs, the limit is {MAX_RUNS}: give fewer", args.starts);
        return Err(CliError::Request(message));
    }
    let files =
        [("--csv", args.csv.as_deref()), ("--diagram", args.diagram.as_deref()), ("--plot", args.plot.as_deref())];
    let taken = distinct(&[("the scene", Some(&args.scene))], &files)?;
    nothing_else(args.json, taken)?;
    match &args.diagram {
        Some(path) => diagram(args, path, &scene, &ensemble, taken, console),
        None => ends(args, &scene, &ensemble, taken, console),
    }
}

fn ends(
    args: &FateArgs,
    scene: &Scene,
    ensemble: &Ensemble,
    taken: bool,
    console: &mut Console<'_>,
) -> Result<(), CliError> {
    // Destinations first: an impossible one should not cost a computation.
    let mut file = args.csv.as_deref().map(|path| CsvFile::create("--csv", path, table::header(scene))).transpose()?;
    let mut plot = Plot::of_ends(args.plot.as_deref(), &args.page, scene)?;
    let stop = (console.interrupt)()?;
    let pool = threads(console.threads)?;
    let bar = bar(scene.cells() * args.starts, "runs", console.progress && !taken);
    let from = match args.breathers {
        StartFrom::Class => From::Class,
        StartFrom::Every => From::Every,
        StartFrom::Unstable => From::Unstable,
    };
    let job = Job { scene, pool: &pool, stop: &stop };
    let mut totals = Totals::default();
    let ended = fates(
        &job,
        ensemble,
        from,
        |runs| bar.inc(runs),
        |cell| {
            totals.add(&cell);
            plot.see(&cell);
            for row in table::rows(scene, &cell) {
                file.as_mut().map_or(Ok(()), |file| file.row(row))?;
            }
            Ok::<(), MapError>(())
        },
    );
    bar.finish_and_clear();
    let stopped = is_stopped(ended)?;
    if let Some(file) = file.filter(|_| !stopped || totals.cells > 0) {
        file.finish()?;
    }
    if stopped {
        return Err(kept(&args.csv, args.plot.is_some(), totals.cells, scene.cells()));
    }
    let text =
        if args.json { format!("{:#}\n", totals.as_json(scene, ensemble)) } else { totals.as_text(scene, ensemble) };
    console.answer(&text, taken)?;
    plot.finish(scene, ensemble)
}

fn diagram(
    args: &FateArgs,
    path: &std::path::Path,
    scene: &Scene,
    ensemble: &Ensemble,
    taken: bool,
    console: &mut Console<'_>,
) -> Result<(), CliError> {
    let [axis] = scene.axes.as_slice() else {
        let axes = scene.axes.len();
        return Err(CliError::Request(format!("--diagram needs a scene with one axis, this one has {axes}")));
    };
    let most = args.periods.min(MAX_POINTS);
    let points = args.points.unwrap_or(POINTS.min(most));
    if !(1..=most).contains(&points) {
        let message = format!("--points {points} is out of range: give a whole number from 1 to {most}");
        return Err(CliError::Request(message));
    }
    let diagram = Diagram { scene, ensemble, points, carry: args.carry };
    let sites = diagram.sites();
    let columns = |name: &'static str| sites.iter().map(move |site| format!("{name}_{site}"));
    let header = [axis.parameter.name().to_owned(), "period".to_owned()];
    let header = header.into_iter().chain(columns("displacement")).chain(columns("velocity"));
    let mut file = CsvFile::create("--diagram", path, header)?;
    let mut plot = Plot::of_diagram(args.plot.as_deref(), &args.page, scene)?;
    let stop = (console.interrupt)()?;
    let pool = threads(console.threads)?;
    let bar = bar(scene.cells(), "cells", console.progress && !taken);
    let job = Job { scene, pool: &pool, stop: &stop };
    let (mut cells, mut incomplete) = (0_u64, 0_u64);
    let ended = diagram.compute(
        &job,
        |cells| bar.inc(cells),
        |column| {
            cells += 1;
            incomplete += u64::from(!column.complete);
            let value = axis.value(column.number as usize);
            plot.see_column(value, &column);
            for point in &column.points {
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
    }
    if stopped {
        return Err(kept(&args.diagram, args.plot.is_some(), cells, scene.cells()));
    }
    let carried = if args.carry { ", each from the end of the one before" } else { "" };
    let mut text = format!("{cells} runs of {} periods{carried}, {points} points each\n", args.periods);
    if incomplete > 0 {
        text += &format!("{incomplete} of them could not be completed\n");
    }
    console.answer(&text, taken)?;
    plot.finish(scene, ensemble)
}

fn is_stopped(ended: Ended<MapError>) -> Result<bool, CliError> {
    match ended {
        Ended::Complete => Ok(false),
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

fn bar(length: u64, what: &str, wanted: bool) -> ProgressBar {
    if !wanted {
        return ProgressBar::hidden();
    }
    let bar = ProgressBar::new(length);
    if let Ok(style) = ProgressStyle::with_template("{bar:32} {percent:>3}%  {human_pos}/{human_len} {msg}  {eta} left")
    {
        bar.set_style(style);
    }
    bar.set_message(what.to_owned());
    bar.enable_steady_tick(Duration::from_millis(200));
    bar
}
