//! Stripes of instability: the lines on which two modes collide over a map, with how much of the instability they explain
//! (`studies lines`), and the law that widths follow (`studies stripes`).
//!
//! | module | holds |
//! |---|---|
//! | `widths`, `law` | tables of widths and growth; the law beside them |
//! | `lines` | the lines Ω̃_k ± Ω̃_l = jω |
//! | `cuts` | runs of cells along a row, carried on where no such breather is |
//! | `evidence` | shares of unstable and stable cells next to a line |

mod cuts;
mod evidence;
mod law;
mod lines;
mod widths;

use std::convert::Infallible;
use std::ops::Range;

use vibrochain_cli::common::console::Console;
use vibrochain_cli::common::error::CliError;
use vibrochain_cli::common::threads::threads;
use vibrochain_cli::stripes::StripeRows;
use vibrochain_floquet::participating_modes;
use vibrochain_maps::cell::Cell;
use vibrochain_maps::files::{CsvFile, Output, distinct};
use vibrochain_maps::numbers::Number;
use vibrochain_maps::sweep::{Ended, sweep};
use vibrochain_plot::{Format, MapBorder, MapCells, MapPicture, Palette, Tile, map_picture};

pub use law::{growth_at_meeting, weak_growth};
pub use widths::run;

use crate::args::LinesArgs;
use evidence::evidence;
use lines::{Line, joined, rows};

/// The columns of the table of lines.
const COLUMNS: [&str; 8] = ["family", "mode1", "mode2", "harmonic", "sum", "gamma2", "omega", "line"];

/// Rows of a map that a dash of a line spans, and the gap after it: the cells under a line show.
const DASH: usize = 3;

/// Runs `studies lines`.
///
/// # Errors
/// [`CliError`].
pub fn run_lines(args: &LinesArgs, console: &mut Console<'_>) -> Result<(), CliError> {
    let map = StripeRows::read(&args.scene)?;
    if !map.scene.task.stability {
        let what = "the map must tell stable from unstable cells: set stability = true in [compute]";
        return Err(CliError::Request(format!("{}: {what}", args.scene.display())));
    }
    let taken = distinct(
        &[("the scene", Some(&args.scene))],
        &[("--out", args.out.as_deref()), ("--plot", args.plot.as_deref())],
    )?;
    let format = args.plot.as_deref().map(|path| Format::asked("--plot", path)).transpose()?;
    let picture = args.plot.as_deref().map(Output::create).transpose()?;
    let table = args.out.as_deref().map(|path| CsvFile::create("--out", path, COLUMNS)).transpose()?;
    let (stop, pool) = ((console.interrupt)()?, threads(console.threads)?);
    let mut tiles = Vec::new();
    let take = |_: Range<u64>, cells: &[Cell]| {
        tiles.extend(cells.iter().map(Tile::from));
        Ok::<_, Infallible>(())
    };
    let Ended::Complete(_) = sweep(&map.scene, &pool, &stop, |_| {}, take) else { return Err(CliError::Interrupted) };
    let found = rows(&map, &tiles, &pool, &stop)?;
    let lines = joined(&map, &found.crossings);
    if let Some(table) = table {
        write(table, &lines)?;
    }
    if let (Some(picture), Some(format)) = (picture, format) {
        picture.finish_with(&drawn(&map, &tiles, &lines, format)?)?;
    }
    console.answer(&evidence(&map, &tiles, &found), false, taken)
}

fn write(mut table: CsvFile, lines: &[Line]) -> Result<(), CliError> {
    for (line, number) in lines.iter().zip(1..) {
        let (k, l) = line.modes;
        for point in &line.points {
            let [gamma2, omega] = [point.gamma2, point.omega].map(|value| Number(value).to_string());
            table.record(&(line.family.name(), k, l, line.harmonic, line.sum, gamma2, omega, number))?;
        }
    }
    Ok(table.finish()?)
}

/// The map, with the lines of sums over it.
fn drawn(map: &StripeRows, tiles: &[Tile], lines: &[Line], format: Format) -> Result<Vec<u8>, CliError> {
    let failed = |error: &dyn std::fmt::Display| CliError::Computation(error.to_string());
    let mut cells = MapCells::classes(&map.scene);
    (0..).zip(tiles).for_each(|(number, tile)| cells.tile(number, *tile));
    let model = map.scene.point(0).model().map_err(|error| failed(&error))?;
    // Families of scenes are at site 0.
    let internal = participating_modes(model.chain(), 0).len().saturating_sub(1);
    let mut borders = Vec::new();
    for Line { modes: (k, l), harmonic, points, .. } in lines.iter().filter(|line| line.sum) {
        let kind = if *l == internal { "Ωₖ + Ω internal = jω" } else { "Ωₖ + Ωₗ = jω" };
        for dash in points.chunks(2 * DASH) {
            let points = dash.iter().take(DASH + 1).map(|point| [point.omega, point.gamma2]).collect();
            borders.push(MapBorder { kind: kind.to_owned(), title: format!("{k},{l},{harmonic}"), points });
        }
    }
    let picture = MapPicture { scene: &map.scene, cells: &cells, palette: Palette::default(), borders: &borders };
    map_picture(&picture, format).map_err(|error| failed(&error))
}
