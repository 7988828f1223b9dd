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
//! | `table` | the table of lines |
//! | `widths` | the table of stripes |

mod cells;
mod cuts;
mod evidence;
mod lines;
mod request;
mod table;
mod widths;

use std::path::Path;

use crate::args::StripesArgs;
use crate::common::console::Console;
use crate::common::error::CliError;
use crate::common::pictures::files::PictureFiles;
use crate::common::table_manifest::{Manifest, OfScene, beside};
use crate::common::table_rows::TableRows;
use crate::common::threads::threads;
use crate::stripes::cells::cells;
use crate::stripes::evidence::evidence;
use crate::stripes::lines::{Line, joined, rows};
use crate::stripes::request::Request;
use crate::stripes::table::write;
use crate::stripes::widths::HEADER;
use crate::structures;
use vibrochain_maps::files::{CsvFile, distinct};
use vibrochain_plot::{Format, MapCells, MapLine, MapPicture, Palette, Tile, map_with_lines};

pub(crate) use crate::stripes::table::COLUMNS;

/// What the manifest of the lines calls their table.
pub(crate) const LINES: &str = "stripes";

/// Runs the subcommand.
///
/// # Errors
/// [`CliError`].
pub fn run(args: &StripesArgs, console: &mut Console<'_>) -> Result<(), CliError> {
    let (plot, out) = args.files();
    args.page.checked(plot.is_some(), "--plot")?;
    structures::refuse_scene(&args.scene)?;
    let request = Request::read(&args.scene)?;
    let manifest = beside(out)?;
    let taken = distinct(
        &[("the scene", Some(&args.scene)), ("--map", args.map.as_deref())],
        &[
            ("--plot", plot),
            ("--out", out),
            ("the manifest of --out", manifest.as_deref()),
            ("--widths", args.widths.as_deref()),
        ],
    )?;
    let stop = (console.interrupt)()?;
    // Destinations first: an impossible one should not cost a computation.
    let picture = PictureFiles::one("--plot", plot, &args.page)?;
    fits(&picture, &request)?;
    let table = out.map(|path| CsvFile::create("--out", path, COLUMNS)).transpose()?;
    let manifest = Manifest::create(manifest.as_deref())?;
    let widths = args.widths.as_deref().map(|path| CsvFile::create("--widths", path, HEADER.split(','))).transpose()?;
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
    if let Some(table) = table {
        manifest.finish(LINES, write(table, &lines)?, &OfScene::new(&request.scene, None))?;
    }
    draw(picture, &request, &tiles, &lines, args.all)?;
    console.answer(&text, false, taken)
}

impl StripesArgs {
    /// The picture and the table that are asked for. (Once --out was the name of --plot: a picture that it names is drawn.)
    fn files(&self) -> (Option<&Path>, Option<&Path>) {
        let (plot, out, table) = (self.plot.as_deref(), self.out.as_deref(), self.csv.as_deref());
        let picture = out.filter(|path| plot.is_none() && Format::of(path).is_some());
        (plot.or(picture), table.or(out.filter(|_| picture.is_none())))
    }
}

/// Draws the lines of a table over the map of another, `told` of them as the manifest at `scene` says; how many they are.
///
/// # Errors
/// [`CliError::Request`] for tables that are not of this scene.
pub(crate) fn redraw(
    files: PictureFiles,
    (table, told): (TableRows, u64),
    scene: &Path,
    map: &Path,
    all: bool,
) -> Result<usize, CliError> {
    let request = Request::read(scene)?;
    let mut lines = Vec::new();
    table.rows(told, |fields| table::take(&mut lines, fields))?;
    let tiles = cells::read(&request, map)?;
    draw(files, &request, &tiles, &lines, all)?;
    Ok(lines.len())
}

/// Makes sure that the picture can be made.
fn fits(files: &PictureFiles, request: &Request) -> Result<(), CliError> {
    let (scene, cells) = (&request.scene, &MapCells::classes(&request.scene));
    files.fit(|page| map_with_lines(&MapPicture { scene, cells, palette: Palette::default(), borders: &[] }, &[], page))
}

/// The picture of the map and its lines, with `all` also those of differences.
fn draw(files: PictureFiles, request: &Request, tiles: &[Tile], lines: &[Line], all: bool) -> Result<(), CliError> {
    if files.is_empty() {
        return Ok(());
    }
    let mut shown = MapCells::classes(&request.scene);
    (0..).zip(tiles).for_each(|(number, tile)| shown.tile(number, *tile));
    let map = MapPicture { scene: &request.scene, cells: &shown, palette: Palette::default(), borders: &[] };
    let lines: Vec<MapLine> =
        lines.iter().filter(|line| line.sum || all).map(|line| drawn(line, request.internal)).collect();
    files.draw(|page| map_with_lines(&map, &lines, page))
}

fn drawn(line: &Line, internal: usize) -> MapLine {
    let (k, l) = line.modes;
    MapLine {
        points: line.points.iter().map(|point| (point.omega, point.gamma2)).collect(),
        label: format!("{k},{l},{}", line.harmonic),
        faint: !line.sum,
        internal: (l == internal).then_some(internal),
    }
}
