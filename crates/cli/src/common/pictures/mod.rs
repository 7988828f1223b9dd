//! Pictures of a table that is being written, from its rows. Their files are in `files`, the flags of a page in `page_args`.

pub(crate) mod files;
pub mod page_args;

use std::path::PathBuf;

use rayon::ThreadPool;
use vibrochain_lattice::Stop;
use vibrochain_maps::borders::{Border, Borders};
use vibrochain_maps::caption::in_words;
use vibrochain_maps::cell::Cell;
use vibrochain_maps::grid::Grid;
use vibrochain_maps::scene::{Scene, Slice, Values};
use vibrochain_maps::structure::StructureScene;
use vibrochain_maps::sweep::Watcher;
use vibrochain_plot::{
    MapBorder, MapCells, MapPicture, Mapped, OneAxisPicture, Page, Palette, PlotError, Quantity, is_shown, map_picture,
    one_axis_picture,
};

use crate::args::{OF_MAPS, PictureArgs, QuantityName};
use crate::common::border_search::BorderSearch;
use crate::common::error::CliError;
use crate::common::pictures::files::PictureFiles;

/// How exact borders in a picture are, as a part of its sides: what `mapgen curves` takes. A pixel asks for less, but between
/// less exact borders stripes cannot be told apart.
const TOLERANCE: f64 = 1e-6;

/// Places that are asked whether a border is missing: a piece of a thousandth of the picture escapes all of them in one of e¹⁰
/// cases.
const PLACES: usize = 10_000;

/// Pictures to draw once all rows are known; no more is kept of them than is shown.
pub(crate) struct Pictures<S> {
    /// What is swept.
    whole: S,
    scene: DrawnScene,
    files: Vec<(Page, PathBuf)>,
    palette: Palette,
    seen: Seen,
    curves: bool,
    borders: Vec<MapBorder>,
}

/// What is drawn: a part of a chain's scene, or a structure's.
enum DrawnScene {
    Slice(Box<Slice>),
    Structure(Box<StructureScene>),
}

impl DrawnScene {
    fn mapped(&self) -> &dyn Mapped {
        match self {
            Self::Slice(slice) => slice.scene(),
            Self::Structure(scene) => &**scene,
        }
    }

    /// The fastest axis.
    fn axis(&self) -> Option<&Values> {
        match self {
            Self::Slice(slice) => slice.scene().axes.first().map(|axis| &axis.values),
            Self::Structure(scene) => scene.axes.first().map(|axis| &axis.values),
        }
    }

    /// The number in the picture of a cell of this number, if it is drawn.
    fn cell(&self, number: u64) -> Option<u64> {
        match self {
            Self::Slice(slice) => slice.cell(number),
            Self::Structure(_) => Some(number),
        }
    }
}

/// What is kept of the cells.
enum Seen {
    /// Over two axes, what the map shows.
    Map(MapCells),
    /// Over one axis, the cells themselves.
    Cells(Vec<Cell>),
}

fn refused(message: String) -> CliError {
    CliError::Request(message)
}

/// The part of the scene that is drawn.
fn slice(wanted: &PictureArgs, scene: &Scene) -> Result<Slice, CliError> {
    let given: Vec<String> =
        wanted.slice.iter().map(|(parameter, value)| format!("--slice {}={value}", parameter.name())).collect();
    let slice = Slice::of(scene, &wanted.slice).map_err(|error| refused(format!("{}: {error}", given.join(" "))))?;
    let (axes, names) = (slice.scene().axes.as_slice(), slice.scene().axis_names());
    match axes {
        [] => Err(refused("no axis is left to draw along: leave out one --slice".to_owned())),
        [_] | [_, _] => Ok(slice),
        [.., last] => {
            let (count, name) = (axes.len(), last.parameter.name());
            let middle = last.value(last.points() / 2);
            Err(refused(format!(
                "pictures have one or two axes, here are {count}, {names}: choose the cells to draw by a value of each further \
                 axis, as in --slice {name}={middle}"
            )))
        }
    }
}

impl Pictures<Scene> {
    /// Makes sure that they can be drawn and written.
    pub(crate) fn plan(wanted: &PictureArgs, show: QuantityName, scene: &Scene) -> Result<Self, CliError> {
        if wanted.files().next().is_none() {
            return Self::of(wanted, show, (scene, DrawnScene::Slice(Box::new(Slice::of(scene, &[])?))));
        }
        let slice = slice(wanted, scene)?;
        if wanted.curves {
            if let [_] = slice.scene().axes.as_slice() {
                let axis = slice.scene().axis_names();
                return Err(refused(format!(
                    "--curves draws borders over a map of two axes, here is one, {axis}: leave it out"
                )));
            }
            Borders::window(slice.scene()).map_err(|error| refused(format!("--curves: {error}")))?;
        }
        Self::of(wanted, show, (scene, DrawnScene::Slice(Box::new(slice))))
    }
}

impl Pictures<StructureScene> {
    /// The same of a structure.
    pub(crate) fn of_structure(
        wanted: &PictureArgs,
        show: QuantityName,
        scene: &StructureScene,
    ) -> Result<Self, CliError> {
        if wanted.curves || !wanted.slice.is_empty() {
            let message = "--curves and --slice are of maps of lattices: leave them away";
            return Err(refused(message.to_owned()));
        }
        Self::of(wanted, show, (scene, DrawnScene::Structure(Box::new(scene.clone()))))
    }
}

impl<S: Grid> Pictures<S> {
    fn of(wanted: &PictureArgs, show: QuantityName, (whole, scene): (&S, DrawnScene)) -> Result<Self, CliError> {
        let files = PictureFiles::named(wanted)?;
        let seen = if files.is_empty() { Seen::Cells(Vec::new()) } else { kept(show, scene.mapped())? };
        let curves = wanted.curves && !files.is_empty();
        let pictures =
            Self { whole: whole.clone(), scene, files, palette: wanted.palette, seen, curves, borders: Vec::new() };
        if !pictures.files.is_empty() {
            PictureFiles::open(&pictures.files)?.fit(|page| pictures.picture(page))?;
        }
        Ok(pictures)
    }

    /// Finds the borders that are to be drawn, if any; a line on them for the summary.
    ///
    /// # Errors
    /// [`CliError::Interrupted`].
    pub(crate) fn find_borders(&mut self, pool: &ThreadPool, stop: &Stop, progress: bool) -> Result<String, CliError> {
        let DrawnScene::Slice(slice) = &self.scene else { return Ok(String::new()) };
        if !self.curves {
            return Ok(String::new());
        }
        let search = BorderSearch { tolerance: TOLERANCE, places: PLACES, special: false, stop, progress };
        let (found, regions) = search.run(slice.scene(), pool)?;
        let mut line = format!("\nborders {}", found.borders.len());
        let (changes, faces) = (found.unexplained.len(), regions.unexplained().len());
        if changes + faces > 0 {
            line += &format!("; {changes} changes and {faces} faces between them lack one, as mapgen curves tells");
        }
        // What separates nothing is no border of the map.
        let parts = found.borders.iter().enumerate().flat_map(|(number, border)| {
            let parts = regions.border(number).iter().filter(|part| part.separates);
            parts.map(|part| drawn(border, part.points.iter().map(|place| regions.window().point(*place))))
        });
        self.borders = parts.collect();
        Ok(line)
    }

    /// Draws and writes them.
    pub(crate) fn finish(self) -> Result<(), CliError> {
        PictureFiles::open(&self.files)?.draw(|page| self.picture(page))
    }

    fn picture(&self, page: Page) -> Result<Vec<u8>, PlotError> {
        let (scene, palette, borders) = (self.scene.mapped(), self.palette, self.borders.as_slice());
        match &self.seen {
            Seen::Map(cells) => map_picture(&MapPicture { scene, cells, palette, borders }, page),
            Seen::Cells(cells) => one_axis_picture(&OneAxisPicture { scene, cells }, page),
        }
    }
}

fn kept(show: QuantityName, scene: &dyn Mapped) -> Result<Seen, CliError> {
    let quantity = match show {
        QuantityName::Class => None,
        QuantityName::SpectralRadius => Some(Quantity::SpectralRadius),
        QuantityName::Margin => Some(Quantity::Margin),
        QuantityName::Impulse => Some(Quantity::Impulse),
        QuantityName::Solutions => Some(Quantity::Solutions),
        QuantityName::Phi | QuantityName::Psi => {
            let known = OF_MAPS.map(|name| name.to_string()).join(", ");
            return Err(refused(format!("--show {show} is of branches: of a map give one of {known}")));
        }
    };
    match (quantity, scene.axes().as_slice()) {
        (None, [_]) => Ok(Seen::Cells(Vec::new())),
        (None, _) => Ok(Seen::Map(MapCells::classes(scene))),
        (Some(_), [axis]) => Err(refused(format!(
            "--show is of maps over two axes, here is one, {}: leave it out, each number has a panel of its own",
            axis.name
        ))),
        (Some(quantity), _) => match scene.has(quantity) {
            Ok(()) => Ok(Seen::Map(MapCells::numbers(scene, quantity))),
            Err(key) => {
                let name = quantity.name();
                Err(refused(format!("--show {name}: the scene does not compute it; add {key} to its table [compute]")))
            }
        },
    }
}

/// A part of a border as it is drawn.
fn drawn(border: &Border, points: impl Iterator<Item = [f64; 2]>) -> MapBorder {
    let stripe = border.stripe.map_or(String::new(), |stripe| {
        let (k, l) = stripe.modes;
        format!(", stripe {k},{l},{}", stripe.harmonic)
    });
    MapBorder {
        kind: in_words(border.kind.name()),
        title: format!("{}: {}{stripe}", border.family, border.kind),
        points: points.collect(),
    }
}

impl<S: Grid> Watcher<S::Cell> for Pictures<S> {
    fn looks(&self) -> bool {
        !self.files.is_empty()
    }

    fn begin(&mut self) {
        match &mut self.seen {
            Seen::Map(shown) => shown.clear(),
            Seen::Cells(cells) => cells.clear(),
        }
    }

    fn cell(&mut self, number: u64, cell: &S::Cell) {
        if self.files.is_empty() {
            return;
        }
        let cell = self.whole.shown(cell);
        let Some(number) = self.scene.cell(number) else { return };
        match &mut self.seen {
            Seen::Map(shown) => shown.cell(number, &cell),
            Seen::Cells(cells) => {
                if self.scene.axis().is_some_and(|axis| is_shown(axis, number)) {
                    cells.push(cell);
                }
            }
        }
    }
}
