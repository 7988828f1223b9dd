//! `mapgen fate` of a structure: many runs from its orbits, or from rest, and what they end in.

use std::path::Path;

use serde_json::json;
use vibrochain_fate::table::{columns, rows_at};
use vibrochain_fate::{Fates, From, StructureFates};
use vibrochain_maps::error::MapError;
use vibrochain_maps::files::{CsvFile, distinct};
use vibrochain_maps::numbers::Number;
use vibrochain_maps::structure::StructureScene;
use vibrochain_maps::structure::answer::structure;
use vibrochain_maps::sweep::Ended;

use crate::args::FateArgs;
use crate::common::answer::printed;
use crate::common::console::{Console, nothing_else};
use crate::common::error::CliError;
use crate::common::pictures::files::PictureFiles;
use crate::common::progress::counter;
use crate::common::threads::threads;
use crate::fate::plot::Plot;
use crate::fate::report::Totals;

/// Runs of one command.
const MOST_RUNS: u64 = 100_000_000;

/// Runs the subcommand for a structure.
///
/// # Errors
/// [`CliError`].
pub(crate) fn run(
    args: &FateArgs,
    scene: &StructureScene,
    fates: &Fates,
    console: &mut Console<'_>,
) -> Result<(), CliError> {
    let others = [
        ("--diagram", args.diagram.is_some()),
        ("--carry", args.carry),
        ("--points", args.points.is_some()),
        ("--resume", args.resume),
        ("--shard", args.shard.is_some()),
    ];
    if let Some((flag, _)) = others.iter().find(|(_, given)| *given) {
        let message = format!("{flag} is of chains without dashpots: a structure's runs are one table");
        return Err(CliError::Request(message));
    }
    let ensemble = &fates.ensemble;
    // A structure's lengths are its user's: any perturbation that leaves its contacts between their barriers is one.
    let checked = vibrochain_fate::Ensemble { size: ensemble.size.min(1.0), ..*ensemble };
    checked.check(1).map_err(|error| CliError::Request(error.to_string()))?;
    if scene.asked().is_empty() && fates.from != From::Rest {
        let message =
            "from which orbits? give word = \"0+\" or [compute] with families in the scene, or --breathers rest";
        return Err(CliError::Request(message.to_owned()));
    }
    let model = scene.model().map_err(CliError::Request)?;
    let runs = StructureFates::new(scene, *ensemble, fates.from);
    if runs.cells().saturating_mul(ensemble.starts) > MOST_RUNS {
        return Err(CliError::Request(format!(
            "{} points with --starts {} are more than {MOST_RUNS} runs: give fewer",
            runs.cells(),
            ensemble.starts
        )));
    }
    let inputs: [(&str, Option<&Path>); 1] = [("the scene", Some(&args.scene))];
    let taken = distinct(&inputs, &[("--out", args.out.as_deref()), ("--plot", args.plot.as_deref())])?;
    nothing_else(args.json, taken)?;
    args.page.checked(args.plot.is_some(), "--plot")?;
    let stop = (console.interrupt)()?;
    let files = PictureFiles::one("--plot", args.plot.as_deref(), &args.page)?;
    let mut plot = Plot::of_ends(files, scene, fates.from == From::Rest)?;
    let header = scene.axis_names.iter().cloned().chain(columns());
    let mut table = args.out.as_deref().map(|out| CsvFile::create("--out", out, header)).transpose()?;
    let pool = threads(console.threads)?;
    let bar = counter(runs.cells() * ensemble.starts, 0, "runs", console.progress && !taken);
    let mut totals = Totals::default();
    let ended = runs.compute(
        (&pool, &stop),
        |runs| bar.inc(runs),
        |cell| {
            totals.add(&cell);
            plot.see(&cell);
            let Some(table) = &mut table else { return Ok(()) };
            let point = cell.point.iter().map(|value| Number(*value).to_string()).collect();
            rows_at(point, &cell).into_iter().try_for_each(|row| table.row(row))
        },
    );
    bar.finish_and_clear();
    match ended {
        Ended::Complete(_) => {}
        // What was computed is kept.
        Ended::Stopped => {
            let cells = totals.cells;
            let Some(table) = table.filter(|_| cells > 0) else { return Err(CliError::Interrupted) };
            table.finish()?;
            return Err(CliError::Paused(format!("the table holds the first {cells} of {} points", runs.cells())));
        }
        Ended::Failed(error) => return Err(CliError::from(error)),
    }
    table.map_or(Ok::<(), MapError>(()), CsvFile::finish)?;
    let told = if args.json {
        let about = [("structure", structure(scene, &model)), ("axes", json!(scene.axis_names))];
        printed(&totals.answer(about.map(|(name, value)| (name.to_owned(), value)).into_iter().collect(), ensemble))?
    } else {
        let points: Vec<String> = scene.axes.iter().map(|axis| axis.points.to_string()).collect();
        totals.as_text(if points.is_empty() { "one point".to_owned() } else { points.join(" × ") }.as_str(), ensemble)
    };
    console.answer(&told, args.json, taken)?;
    plot.finish(scene, ensemble)
}
