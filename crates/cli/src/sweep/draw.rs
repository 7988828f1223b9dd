//! `mapgen draw`: pictures of a table that has been written, without computing it again.

use std::path::Path;

use vibrochain_fate::{Ensemble, Fates, From};
use vibrochain_lattice::Parameter;
use vibrochain_maps::grid::{Files, Grid};
use vibrochain_maps::scene::Scene;
use vibrochain_maps::structure::StructureScene;
use vibrochain_maps::sweep::{Cells, Watcher};
use vibrochain_maps::text::read_text;
use vibrochain_plot::curves_picture;

use crate::along::labels;
use crate::args::{DrawArgs, OF_BRANCHES, QuantityName, SHOWN};
use crate::branch::drawn;
use crate::branch::table::Table;
use crate::common::console::{Console, destinations, interruptible};
use crate::common::error::CliError;
use crate::common::pictures::files::{PictureFiles, of_no_map};
use crate::common::swept_scene::SweptScene;
use crate::common::table_manifest::{OfRuns, manifest_path, read};
use crate::common::table_rows::TableRows;
use crate::common::threads::threads;
use crate::fate::plot::Plot;
use crate::fate::{ENDS, SECTION};
use crate::sweep::report::{counted, size};

/// Columns of a table that are told of one that is not known.
const TOLD: usize = 6;

/// Tables that have a picture.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Kind {
    Cells,
    Ends,
    Section,
    Branch,
    Curve,
}

impl Kind {
    /// By the names of its columns.
    fn of(columns: &[&str]) -> Result<Self, String> {
        let has = |name: &str| columns.contains(&name);
        let is_diagram = || {
            columns.get(1) == Some(&"period") && columns.get(2).is_some_and(|name| name.starts_with("displacement_"))
        };
        let is_curve = || {
            let [x, y] = [2, 3].map(|i| columns.get(i).copied().and_then(Parameter::from_name));
            x.zip(y).is_some_and(|(x, y)| columns == crate::curve::table::header([x.name(), y.name()]))
        };
        if columns.join(",") == crate::branch::table::HEADER {
            Ok(Self::Branch)
        } else if is_curve() {
            Ok(Self::Curve)
        } else if has("share_breather") {
            Ok(Self::Ends)
        } else if is_diagram() {
            Ok(Self::Section)
        } else if has("class") && has("status") {
            Ok(Self::Cells)
        } else if columns.first() == Some(&"border") {
            Err("it has the borders of a window, and not what lives between them, which is what the picture of `mapgen curves` shows: \
                 draw that anew, or draw a table of sweep with --curves"
                .to_owned())
        } else {
            let mut told = columns.iter().take(TOLD).copied().collect::<Vec<_>>().join(",");
            if columns.len() > TOLD {
                told += ",…";
            }
            Err(format!(
                "no picture is known of the columns {told}: give a table of sweep, merge, fate, branch or curve"
            ))
        }
    }

    /// Its command, as messages have it.
    fn name(self) -> &'static str {
        match self {
            Self::Cells => "sweep",
            Self::Ends => ENDS,
            Self::Section => SECTION,
            Self::Branch => "branch",
            Self::Curve => "curve",
        }
    }

    /// Refuses flags that are of other tables.
    fn takes(self, args: &DrawArgs) -> Result<(), CliError> {
        let flags = [
            ("--show", !args.show.is_empty(), "of sweep or branch", matches!(self, Self::Cells | Self::Branch)),
            ("--all", args.all, "of branch", self == Self::Branch),
        ];
        if let Some((flag, _, whose, _)) = flags.iter().find(|(_, given, _, taken)| *given && !taken) {
            let name = self.name();
            refuse!("{flag} is of tables {whose}, this is one of {name}: leave it out");
        }
        if self == Self::Cells {
            Ok(())
        } else {
            of_no_map(&args.pictures, false, &format!("this is a table of {}", self.name()))
        }
    }
}

/// Runs the subcommand.
///
/// # Errors
/// [`CliError`].
pub fn run(args: &DrawArgs, console: &mut Console<'_>) -> Result<(), CliError> {
    let wanted = &args.pictures;
    let outputs = wanted.beside(&[]);
    ensure!(!outputs.is_empty(), "nothing is asked for: give --plot FILE, .png, .svg or .pdf");
    let manifest = manifest_path(&args.table);
    let source = args.scene.as_deref().unwrap_or(&manifest);
    let inputs = [("the table", Some(args.table.as_path())), ("the scene", Some(source))];
    destinations(false, &inputs, &outputs)?;
    let table = TableRows::open("table", &args.table)?;
    let kind = Kind::of(&table.columns()).map_err(|what| table.wrong(&what))?;
    kind.takes(args)?;
    if args.scene.is_none() && !manifest.exists() {
        let what = if kind == Kind::Cells { "the scene of the table" } else { "its manifest" };
        refuse!("{} is not there, which says what the table is of: give {what} by --scene", manifest.display());
    }
    let path = source.to_owned();
    let is_structure = interruptible(move || StructureScene::is_at(&path))?;
    let told = match kind {
        Kind::Cells if is_structure => cells::<StructureScene>(args, table, source, console)?,
        Kind::Cells => cells::<Scene>(args, table, source, console)?,
        Kind::Ends if is_structure => ends::<StructureScene>(PictureFiles::asked(wanted)?, table, source)?,
        Kind::Ends => ends::<Scene>(PictureFiles::asked(wanted)?, table, source)?,
        Kind::Section if is_structure => section::<StructureScene>(PictureFiles::asked(wanted)?, table, source)?,
        Kind::Section => section::<Scene>(PictureFiles::asked(wanted)?, table, source)?,
        Kind::Branch => branch(args, table, source)?,
        Kind::Curve => curve(PictureFiles::asked(wanted)?, table, source)?,
    };
    console.summary(&told);
    Ok(())
}

/// The scene in a file, or in a manifest.
fn scene<S: Grid + 'static>(source: &Path) -> Result<S, CliError> {
    let path = source.to_owned();
    let parsed = interruptible(move || S::parse(&path, &read_text("scene", &path, S::MOST_BYTES)?, &Files::new()));
    Ok(parsed??)
}

fn cells<S: SweptScene>(
    args: &DrawArgs,
    table: TableRows,
    source: &Path,
    console: &mut Console<'_>,
) -> Result<String, CliError> {
    let scene: S = scene(source)?;
    let pool = threads(console.threads)?;
    let show = match args.show.as_slice() {
        [] => QuantityName::default(),
        [one] => *one,
        [..] => {
            refuse!("--show: the cells of a map have one colour: give one of these");
        }
    };
    let stop = (console.interrupt)()?;
    let mut pictures = scene.pictures(&args.pictures, show)?;
    pictures.begin();
    let summary = table.cells(&Cells, &scene, &mut |number, cell| pictures.cell(number, cell))?;
    let told = pictures.find_borders(&pool, &stop, console.progress)?;
    pictures.finish()?;
    Ok(size(&scene, &summary) + &told)
}

/// What a table of an ensemble is of.
struct Runs<S> {
    rows: u64,
    scene: S,
    ensemble: Ensemble,
}

fn of_runs<S: SweptScene>(source: &Path, command: &str) -> Result<Runs<S>, CliError> {
    let (rows, OfRuns { ensemble }) = read(source, command)?;
    let scene: S = scene(source)?;
    scene
        .takes(&ensemble, From::Every)
        .or_else(|error| scene.takes(&ensemble, From::Rest).map_err(|_| error))
        .map_err(|error| CliError::Request(format!("manifest {}: {error}", source.display())))?;
    Ok(Runs { rows, scene, ensemble })
}

fn ends<S: SweptScene>(files: PictureFiles, table: TableRows, source: &Path) -> Result<String, CliError> {
    let Runs { scene, ensemble, .. } = of_runs::<S>(source, ENDS)?;
    let mut plot = Plot::of_ends(files, &scene)?;
    let fates = Fates { ensemble, ..Fates::default() };
    table.cells(&fates, &scene, &mut |_, cell| plot.see(cell))?;
    plot.finish(&scene, &ensemble)?;
    Ok(counted(scene.cells(), "cell"))
}

fn section<S: SweptScene>(files: PictureFiles, table: TableRows, source: &Path) -> Result<String, CliError> {
    let Runs { rows, scene, ensemble } = of_runs::<S>(source, SECTION)?;
    let names: Vec<String> = Grid::axes(&scene).iter().map(|axis| scene.name_of(axis.parameter)).collect();
    if names.len() != 1 || table.columns()[0] != names[0] {
        return Err(table.wrong(&format!("it is not over the axis of its scene, {}", names.join(", "))));
    }
    let mut plot = Plot::of_diagram(files, &scene)?;
    table.rows(rows, |fields| {
        let value = fields.finite()?;
        let _period: u64 = fields.value()?;
        plot.see_point(value, fields.finite()?);
        Ok(())
    })?;
    plot.finish(&scene, &ensemble)?;
    Ok(counted(rows, "point"))
}

fn branch(args: &DrawArgs, table: TableRows, source: &Path) -> Result<String, CliError> {
    let (rows, about): (_, crate::branch::table::About) = read(source, "branch")?;
    let branches = about.branches.iter().map(|_| Vec::new()).collect();
    let mut diagram = Table { about, branches };
    table.rows(rows, |fields| diagram.take(fields))?;
    if let Some(other) = args.show.iter().find(|name| !OF_BRANCHES.contains(name)) {
        let known = OF_BRANCHES.map(|name| name.to_string()).join(", ");
        refuse!("--show {other} is of maps: of a branch give some of {known}");
    }
    let shown = if args.show.is_empty() { &SHOWN[..] } else { &args.show };
    let Table { about, branches } = &diagram;
    let [label, _] = labels([about.free; 2]);
    let picture = drawn((about.heading.clone(), label), (&about.branches, branches), shown, args.all);
    PictureFiles::asked(&args.pictures)?.draw(|page| curves_picture(&picture, page))?;
    Ok(format!("{} branches of {rows} points and events", diagram.branches.len()))
}

fn curve(files: PictureFiles, table: TableRows, source: &Path) -> Result<String, CliError> {
    let (rows, about): (_, crate::curve::table::About) = read(source, "curve")?;
    let crate::curve::table::Plane { parameters, window } = about.window;
    let is_range = (0..2).all(|i| window.from[i] < window.to[i]);
    if !is_range || table.columns()[2..4] != parameters.map(Parameter::name) {
        return Err(table.wrong(&format!("its columns are not those of the window in {}", source.display())));
    }
    let mut curves = Vec::new();
    table.rows(rows, |fields| crate::curve::table::take(&mut curves, fields))?;
    let picture = vibrochain_plot::event_curves(
        &about.heading,
        labels(parameters),
        (window.from, window.to),
        (&curves, &about.touches),
    );
    files.draw(|page| curves_picture(&picture, page))?;
    Ok(format!("{} of {}", counted(curves.len(), "curve"), counted(rows, "point")))
}
