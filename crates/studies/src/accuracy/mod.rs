//! `studies accuracy`: error against run time, this program's methods beside those they replace.
//!
//! Each suite is a list of cases; in each case several methods compute the same quantity, every one at a few settings.
//! What comes out is one row a setting: the time of one evaluation on one thread, and its error against the truth. The
//! document with all tables and pictures is made by the command alone.
//!
//! | module | holds |
//! |---|---|
//! | `table`, `document` | rows and their files; sections and the Markdown they make |
//! | `meter` | the time of one evaluation; Ctrl-C; progress |
//! | [`extremes`] | extreme corners and random points against many digits |
//! | [`structures`] | random structures against many digits |
//! | `spectrum`, `simulation`, `map`, `kernels`, `orbits`, `shooting` | the suites |
//! | [`paper`], `series` | the paper's procedure, and its Fourier series |
//! | `steppers` | general solvers for ordinary differential equations |

mod document;
pub mod extremes;
mod kernels;
mod map;
mod meter;
mod orbits;
pub mod paper;
mod picture;
mod series;
mod shooting;
mod simulation;
mod spectrum;
mod steppers;
pub mod structures;
mod table;

use std::path::Path;
use std::time::Duration;

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

use crate::accuracy::document::{Block, Document, Section};
use crate::accuracy::extremes::report::{Report, Surroundings};
use crate::accuracy::meter::Meter;
use crate::accuracy::picture::work_precision_picture;
use crate::accuracy::table::Table;
use crate::args::{AccuracyArgs, SuiteName};
use vibrochain_cli::common::console::Console;
use vibrochain_cli::common::error::CliError;
use vibrochain_cli::common::threads::threads;
use vibrochain_maps::files::Output;
use vibrochain_maps::files::promises_folder;
use vibrochain_plot::Format;

/// One suite: what it compares, in words, and how it is run.
struct Suite {
    /// The name of its files.
    name: &'static str,
    title: &'static str,
    /// What is compared with what, and what the reader learns.
    prose: &'static str,
    /// What its errors are.
    error: &'static str,
    run: fn(&mut Meter<'_>) -> Result<Table, CliError>,
}

/// All suites, in the order of the document.
const SUITES: &[(SuiteName, &Suite)] = &[
    (SuiteName::Kernels, &kernels::SUITE),
    (SuiteName::Orbits, &orbits::SUITE),
    (SuiteName::Spectrum, &spectrum::SUITE),
    (SuiteName::Simulation, &simulation::SUITE),
    (SuiteName::Map, &map::SUITE),
    (SuiteName::Shooting, &shooting::SUITE),
];

/// The name of the document.
const DOCUMENT: &str = "accuracy.md";

/// The folder beside it, with tables and pictures.
const FILES: &str = "accuracy";

/// What `scripts/lean.sh` prints, if it has been put into that folder: the document takes it over as it stands.
const LEAN: &str = "lean.md";

/// Runs the subcommand.
///
/// # Errors
/// [`CliError`].
pub fn run(args: &AccuracyArgs, console: &mut Console<'_>) -> Result<(), CliError> {
    promises_folder("--out", &args.out)?;
    let chosen = SUITES.iter().filter(|(name, _)| args.suite.is_empty() || args.suite.contains(name));
    let chosen: Vec<&Suite> = chosen.map(|(_, suite)| *suite).collect();
    if args.redraw {
        return redraw(&args.out.join(FILES), &chosen);
    }
    // Destinations first: an impossible one should not cost a computation.
    let document_file = Output::create(&args.out.join(DOCUMENT))?;
    let folder = args.out.join(FILES);
    let files = chosen.iter().map(|suite| Files::open(&folder, suite.name)).collect::<Result<Vec<_>, _>>()?;
    let everything = args.suite.is_empty();
    let file_of = |suite: SuiteName, name: &str| {
        (everything || args.suite.contains(&suite)).then(|| Output::create(&folder.join(name))).transpose()
    };
    let extremes_file = file_of(SuiteName::Extremes, EXTREMES)?;
    let structures_file = file_of(SuiteName::Structures, STRUCTURES)?;

    let stop = (console.interrupt)()?;
    let bar = progress(
        chosen.len() + usize::from(extremes_file.is_some()) + usize::from(structures_file.is_some()),
        console.progress,
    );
    let mut meter = Meter::new(&stop, &bar, args.quick);
    let mut document = Document::new(args.quick);
    let mut written = Vec::new();
    for (suite, files) in chosen.into_iter().zip(files) {
        meter.enter(suite.name);
        let table = (suite.run)(&mut meter)?;
        document.sections.push(section(suite, &table));
        written.push((files, table, suite));
        bar.inc(1);
    }
    let mut broken = Vec::new();
    if let Some(file) = extremes_file {
        meter.enter("extremes");
        let report = Report::run(&meter, &threads(None)?, args.quick)?;
        document.sections.push(extreme_section(&report));
        broken.extend(report.broken().map(told));
        file.finish_with(&report.csv()?)?;
        bar.inc(1);
    }
    if let Some(file) = structures_file {
        meter.enter("structures");
        let report = structures::report::Report::run(&meter, &threads(None)?, args.quick)?;
        document.sections.push(structure_section(&report));
        broken.extend(report.broken().map(told));
        file.finish_with(&report.csv()?)?;
    }
    if everything {
        match std::fs::read_to_string(folder.join(LEAN)) {
            Ok(text) => document.sections.push(Section {
                title: "What is compiled, and what a cell allocates".to_owned(),
                blocks: vec![Block::Prose(text)],
            }),
            Err(_) => {
                let path = folder.join(LEAN).display().to_string();
                console
                    .remark(&format!("{path} is not there: the document goes without it (scripts/lean.sh makes it)"));
            }
        }
    }
    bar.finish_and_clear();
    // All or nothing: an interrupted run leaves an older set of files as it was.
    for (files, table, suite) in written {
        files.write(&table, suite)?;
    }
    document_file.finish_with(document.markdown().as_bytes())?;
    if broken.is_empty() { Ok(()) } else { Err(CliError::Computation(broken.join("; "))) }
}

/// Promises that are broken, in words.
fn told((count, row): (usize, &extremes::Row)) -> String {
    format!("{count} promises are broken, the first: {row:?}")
}

/// Draws the tables that are in `folder`.
fn redraw(folder: &Path, chosen: &[&Suite]) -> Result<(), CliError> {
    for suite in chosen {
        let path = folder.join(format!("{}.csv", suite.name));
        let wrong = |what: String| CliError::Request(format!("table {}: {what}", path.display()));
        let text = std::fs::read_to_string(&path).map_err(|error| wrong(format!("it cannot be read: {error}")))?;
        let table = Table::read(&text).map_err(wrong)?;
        draw(pictures(folder, suite.name)?, &table, suite)?;
    }
    Ok(())
}

/// The table of random structures.
const STRUCTURES: &str = "structures.csv";

/// The table of the extremes.
const EXTREMES: &str = "extremes.csv";

impl Surroundings for Meter<'_> {
    fn at(&self, what: &str) -> Result<(), CliError> {
        self.say(what);
        self.go_on()
    }
}

/// The extremes' part of the document.
fn extreme_section(report: &Report) -> Section {
    let mut blocks = vec![Block::Prose(extremes::report::PROSE.to_owned())];
    blocks.push(Block::Prose(format!("Every case: [{EXTREMES}]({FILES}/{EXTREMES}).")));
    blocks.extend(report.markdown().into_iter().map(Block::Prose));
    Section { title: "Extremes".to_owned(), blocks }
}

/// The random structures' part of the document.
fn structure_section(report: &structures::report::Report) -> Section {
    let broken = format!("Bounds that are broken, each with its scene: [{STRUCTURES}]({FILES}/{STRUCTURES}).");
    let blocks = [structures::report::PROSE.to_owned(), broken, report.markdown()];
    Section { title: "Random structures".to_owned(), blocks: blocks.into_iter().map(Block::Prose).collect() }
}

/// The suite's part of the document.
fn section(suite: &Suite, table: &Table) -> Section {
    let mut blocks = vec![Block::Prose(suite.prose.to_owned())];
    blocks.push(Block::Picture { file: format!("{FILES}/{}.png", suite.name), caption: suite.title.to_owned() });
    blocks.push(Block::Prose(format!(
        "*error*: {}. All rows: [{name}.csv]({FILES}/{name}.csv).",
        suite.error,
        name = suite.name
    )));
    blocks.push(Block::Prose(table.markdown()));
    Section { title: suite.title.to_owned(), blocks }
}

fn progress(suites: usize, shown: bool) -> ProgressBar {
    if !shown {
        return ProgressBar::hidden();
    }
    let bar = ProgressBar::with_draw_target(Some(suites as u64), ProgressDrawTarget::stderr());
    if let Ok(style) = ProgressStyle::with_template("{bar:32} {pos}/{len} suites  {elapsed}  {wide_msg}") {
        bar.set_style(style);
    }
    bar.enable_steady_tick(Duration::from_millis(200));
    bar
}

/// The files of one suite.
struct Files {
    csv: Output,
    pictures: Pictures,
}

/// Those of its pictures.
type Pictures = [(Format, Output); 2];

fn pictures(folder: &Path, name: &str) -> Result<Pictures, CliError> {
    let open = |format: Format| Output::create(&folder.join(format!("{name}.{format}")));
    Ok([(Format::Png, open(Format::Png)?), (Format::Svg, open(Format::Svg)?)])
}

fn draw(pictures: Pictures, table: &Table, suite: &Suite) -> Result<(), CliError> {
    let picture = table.picture(suite.title, suite.error);
    for (format, file) in pictures {
        file.finish_with(&work_precision_picture(&picture, format).map_err(computation)?)?;
    }
    Ok(())
}

impl Files {
    fn open(folder: &Path, name: &str) -> Result<Self, CliError> {
        Ok(Self { csv: Output::create(&folder.join(format!("{name}.csv")))?, pictures: pictures(folder, name)? })
    }

    fn write(self, table: &Table, suite: &Suite) -> Result<(), CliError> {
        self.csv.finish_with(&table.csv()?)?;
        draw(self.pictures, table, suite)
    }
}

/// A failure of the mathematics, in this command's words.
fn computation(error: impl std::fmt::Display) -> CliError {
    CliError::Computation(error.to_string())
}
