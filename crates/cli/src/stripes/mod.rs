//! `mapgen stripes`: where two modes of a conservative lattice collide, over the map of a scene, and how much of the
//! instability that explains.
//!
//! | module | holds |
//! |---|---|
//! | `request` | scene and flags, checked |
//! | `cells` | classes of the map's cells, computed or read from a table |
//! | `lines` | the lines Ω̃_k ± Ω̃_l = jω |
//! | `cuts` | runs of cells along a row, carried on where no such breather is |
//! | `evidence` | shares of unstable and stable cells next to a line |
//! | `widths` | the table of stripes |

mod cells;
mod cuts;
mod evidence;
mod lines;
mod request;
mod widths;

use crate::args::StripesArgs;
use crate::console::Console;
use crate::error::CliError;
use crate::stripes::cells::cells;
use crate::stripes::evidence::evidence;
use crate::stripes::lines::{Line, joined, rows, table};
use crate::stripes::request::Request;
use crate::stripes::widths::HEADER;
use crate::threads::threads;
use vibrochain_maps::files::{CsvFile, Output, distinct, promises};
use vibrochain_plot::{Cells, MapLine, MapPicture, Palette, Tile, is_shown, map_with_lines};

/// Runs the subcommand.
///
/// # Errors
/// [`CliError`].
pub fn run(args: &StripesArgs, console: &mut Console<'_>) -> Result<(), CliError> {
    let request = Request::read(args)?;
    let taken = distinct(
        &[("the scene", Some(&args.scene)), ("--map", args.map.as_deref())],
        &[("--plot", Some(&args.plot)), ("--csv", args.csv.as_deref()), ("--widths", args.widths.as_deref())],
    )?;
    if let Some(table) = &args.csv {
        promises("--csv", table, "a table as plain CSV", &["csv"])?;
    }
    // Destinations first: an impossible one should not cost a computation.
    let picture = Output::create(&args.plot)?;
    let csv = args.csv.as_deref().map(Output::create).transpose()?;
    let widths = args.widths.as_deref().map(|path| CsvFile::create("--widths", path, HEADER)).transpose()?;
    let stop = (console.interrupt)()?;
    let pool = threads(console.threads)?;
    let tiles = cells(&request, args.map.as_deref(), &pool, &stop)?;
    let rows = rows(&request, &tiles, &pool, &stop)?;
    let mut text = evidence(&request, &tiles, &rows);
    let lines = joined(&request, &rows.crossings);
    // What takes long first: interrupted, it leaves no file behind.
    if let Some(widths) = widths {
        let bar = widths::progress(&request, console.progress);
        text += &widths::write(widths, &request, &pool, &stop, &bar)?;
    }
    if let Some(csv) = csv {
        csv.finish_with(&table(&lines)?)?;
    }
    let shown = tiles.iter().zip(0..).filter(|(_, cell)| is_shown(&request.scene, *cell));
    let shown: Vec<Tile> = shown.map(|(tile, _)| *tile).collect();
    let bytes = map_with_lines(
        &MapPicture { scene: &request.scene, cells: Cells::Classes(&shown), palette: Palette::default(), borders: &[] },
        &lines.iter().filter(|line| line.sum || args.all).map(|line| drawn(line, request.own)).collect::<Vec<_>>(),
        request.page,
    )
    .map_err(|error| CliError::Computation(error.to_string()))?;
    picture.finish_with(&bytes)?;
    console.answer(&text, taken)
}

fn drawn(line: &Line, own: usize) -> MapLine {
    let (k, l) = line.modes;
    MapLine {
        points: line.points.iter().map(|point| (point.omega, point.gamma2)).collect(),
        label: format!("{k},{l},{}", line.harmonic),
        faint: !line.sum,
        own: (l == own).then_some(own),
    }
}
