//! `mapgen sweep` of a structure: a table of what lives at each point.

use std::path::Path;

use vibrochain_maps::files::{Output, distinct, promises};
use vibrochain_maps::numbers::Number;
use vibrochain_maps::scene::Values;
use vibrochain_maps::structure::StructureMap;
use vibrochain_maps::structure::map::StructureCell;
use vibrochain_maps::structure::scene::{StructureAxis, StructureScene};

use crate::args::SweepArgs;
use crate::common::console::Console;
use crate::common::error::CliError;
use crate::common::pictures::MapDrawing;
use crate::common::threads::threads;

/// Runs the subcommand for a structure.
///
/// # Errors
/// [`CliError`].
pub(crate) fn run(args: &SweepArgs, scene: &StructureScene, console: &mut Console<'_>) -> Result<(), CliError> {
    let map = StructureMap::new(scene).map_err(|why| CliError::Request(format!("{}: {why}", args.scene.display())))?;
    if args.dry_run {
        return console.print(&format!("{} points of a structure\n", map.points()));
    }
    let Some(out) = &args.out else {
        return Err(CliError::Request("--out is missing: name the table to write".to_owned()));
    };
    if args.shard.is_some() || args.resume || args.json {
        let message = "maps of structures are written as one table: leave --shard, --resume and --json away";
        return Err(CliError::Request(message.to_owned()));
    }
    if args.pictures.curves || !args.pictures.slice.is_empty() {
        let message = "--curves and --slice are of maps of chains without dashpots: leave them away";
        return Err(CliError::Request(message.to_owned()));
    }
    promises("--out", out, "a table", &["csv"])?;
    distinct(&[("the scene", Some(&args.scene))], &args.pictures.beside(&[("--out", Some(out))]))?;
    let stop = (console.interrupt)()?;
    let mut pictures = MapDrawing::plan(&args.pictures, args.show, scene)?;
    let axes: Vec<Values> = scene.axes.iter().map(StructureAxis::values).collect();
    let axes: Vec<&Values> = axes.iter().collect();
    let pool = threads(console.threads)?;
    let mut file = Output::create(out)?;
    let mut table = csv::Writer::from_writer(&mut file);
    let names = scene.axis_names.iter().cloned();
    let columns = ["class", "word", "mechanism", "spectral_radius", "margin", "solutions", "trouble"];
    let failed = |error: csv::Error| CliError::Computation(error.to_string());
    table.write_record(names.chain(columns.map(str::to_owned))).map_err(failed)?;
    let (mut physical, mut troubled, mut number) = (0, 0, 0);
    let mut stopped = false;
    for row in 0..map.rows() {
        let Some(cells) = pool.install(|| map.row(row, &stop)) else {
            stopped = true;
            break;
        };
        for cell in cells {
            physical += usize::from(cell.best.is_some());
            troubled += usize::from(cell.trouble.is_some());
            table.write_record(record(&cell)).map_err(failed)?;
            pictures.cell(&axes, number, &cell.cell(&scene.words));
            number += 1;
        }
    }
    table.flush().map_err(|error| CliError::Computation(error.to_string()))?;
    drop(table);
    if stopped && number == 0 {
        return Err(CliError::Interrupted);
    }
    file.commit()?;
    if stopped {
        // What was computed is kept.
        return Err(CliError::Paused(format!("the table holds the first {number} of {} points", map.points())));
    }
    pictures.finish(scene)?;
    if out != Path::new("-") {
        console.summary(&format!(
            "{} points, {physical} with physical orbits, {troubled} with something that could not be worked out",
            map.points()
        ));
    }
    Ok(())
}

fn record(cell: &StructureCell) -> Vec<String> {
    let number = |x: Option<f64>| x.map_or(String::new(), |x| Number(x).to_string());
    let (word, verdict, margin) = match &cell.best {
        Some((word, verdict, margin)) => (word.clone(), *verdict, *margin),
        None => (String::new(), None, None),
    };
    let class = cell.class();
    let mut row: Vec<String> = cell.at.iter().flatten().map(|x| Number(*x).to_string()).collect();
    row.extend([
        class.split(' ').next().unwrap_or_default().to_owned(),
        word,
        verdict.and_then(|verdict| verdict.mechanism).map_or(String::new(), |mechanism| mechanism.name().to_owned()),
        number(verdict.map(|verdict| verdict.spectral_radius)),
        number(margin),
        cell.solutions.to_string(),
        cell.trouble.clone().unwrap_or_default(),
    ]);
    row
}
