//! Pictures of a table that is being written, from its rows. Their files are in `files`, the flags of a page in `page_args`.

pub(crate) mod files;
pub mod page_args;

#[cfg(feature = "plot")]
pub(crate) use with_pictures::{MapDrawing, Pictures};
#[cfg(not(feature = "plot"))]
pub(crate) use without_pictures::{MapDrawing, Pictures};

#[cfg(feature = "plot")]
mod with_pictures {
    use std::path::PathBuf;

    use rayon::ThreadPool;
    use vibrochain_lattice::Stop;
    use vibrochain_maps::borders::{Border, Borders};
    use vibrochain_maps::cell::Cell;
    use vibrochain_maps::scene::{Scene, Slice, Values};
    use vibrochain_maps::sweep::Watcher;
    use vibrochain_plot::{
        MapBorder, MapPicture, Mapped, OneAxisPicture, Page, Palette, PlotError, Quantity, Shown, is_shown,
        map_picture, one_axis_picture,
    };

    use crate::args::{OF_MAPS, PaletteName, PictureArgs, QuantityName};
    use crate::common::border_search::BorderSearch;
    use crate::common::caption::in_words;
    use crate::common::error::CliError;
    use crate::common::pictures::files::PictureFiles;

    /// How exact borders in a picture are, as a part of its sides: what `mapgen curves` takes. A pixel asks for less, but between
    /// less exact borders stripes cannot be told apart.
    const TOLERANCE: f64 = 1e-6;

    /// Places that are asked whether a border is missing: a piece of a thousandth of the picture escapes all of them in one of e¹⁰
    /// cases.
    const PLACES: usize = 10_000;

    /// Pictures to draw once all rows are known; no more is kept of them than is shown.
    pub(crate) struct Pictures {
        slice: Slice,
        drawing: MapDrawing,
        curves: bool,
    }

    /// The files of pictures of a map, and what is kept of its cells for them.
    pub(crate) struct MapDrawing {
        files: Vec<(Page, PathBuf)>,
        palette: Palette,
        seen: Seen,
        borders: Vec<MapBorder>,
    }

    /// What is kept of the cells.
    enum Seen {
        /// Over two axes, what the map shows.
        Map(Shown),
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
        let slice =
            Slice::of(scene, &wanted.slice).map_err(|error| refused(format!("{}: {error}", given.join(" "))))?;
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

    impl Pictures {
        /// Makes sure that they can be drawn and written.
        pub(crate) fn plan(wanted: &PictureArgs, show: QuantityName, scene: &Scene) -> Result<Self, CliError> {
            if wanted.files().next().is_none() {
                let slice = Slice::of(scene, &[])?;
                return Ok(Self { drawing: MapDrawing::plan(wanted, show, scene)?, slice, curves: false });
            }
            if scene.refine.is_some() && !wanted.slice.is_empty() {
                return Err(refused(
                    "--slice is of grids, a map that is refined is drawn whole: leave it out".to_owned(),
                ));
            }
            let slice = slice(wanted, &scene.finest())?;
            let drawing = MapDrawing::plan(wanted, show, slice.scene())?;
            if wanted.curves {
                if let Seen::Cells(_) = drawing.seen {
                    let axis = slice.scene().axis_names();
                    return Err(refused(format!(
                        "--curves draws borders over a map of two axes, here is one, {axis}: leave it out"
                    )));
                }
                Borders::window(slice.scene()).map_err(|error| refused(format!("--curves: {error}")))?;
            }
            Ok(Self { slice, drawing, curves: wanted.curves })
        }

        /// Finds the borders that are to be drawn, if any; a line on them for the summary.
        ///
        /// # Errors
        /// [`CliError::Interrupted`].
        pub(crate) fn find_borders(
            &mut self,
            pool: &ThreadPool,
            stop: &Stop,
            progress: bool,
        ) -> Result<String, CliError> {
            if !self.curves {
                return Ok(String::new());
            }
            let search = BorderSearch { tolerance: TOLERANCE, places: PLACES, special: false, stop, progress };
            let (found, regions) = search.run(self.slice.scene(), pool)?;
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
            self.drawing.borders = parts.collect();
            Ok(line)
        }

        /// Draws and writes them.
        pub(crate) fn finish(self) -> Result<(), CliError> {
            let Self { slice, drawing, .. } = self;
            drawing.finish(slice.scene())
        }
    }

    impl MapDrawing {
        /// Makes sure that they can be drawn and written.
        pub(crate) fn plan(wanted: &PictureArgs, show: QuantityName, scene: &dyn Mapped) -> Result<Self, CliError> {
            let palette = match wanted.palette {
                PaletteName::Colour => Palette::Colour,
                PaletteName::Paper => Palette::Paper,
            };
            let files = PictureFiles::named(wanted)?;
            let seen = if files.is_empty() { Seen::Cells(Vec::new()) } else { kept(show, scene)? };
            let drawing = Self { files, palette, seen, borders: Vec::new() };
            if !drawing.files.is_empty() {
                PictureFiles::open(&drawing.files)?.fit(|page| drawing.picture(scene, page))?;
            }
            Ok(drawing)
        }

        /// Takes cell number `number`, one of a map that is drawn along these axes.
        pub(crate) fn cell(&mut self, axes: &[&Values], number: u64, cell: &Cell) {
            match &mut self.seen {
                Seen::Map(shown) => shown.cell(number, cell),
                Seen::Cells(cells) => {
                    if axes.first().is_some_and(|axis| is_shown(axis, number)) {
                        cells.push(*cell);
                    }
                }
            }
        }

        /// Draws and writes them.
        pub(crate) fn finish(self, scene: &dyn Mapped) -> Result<(), CliError> {
            PictureFiles::open(&self.files)?.draw(|page| self.picture(scene, page))
        }

        fn picture(&self, scene: &dyn Mapped, page: Page) -> Result<Vec<u8>, PlotError> {
            let (palette, borders) = (self.palette, self.borders.as_slice());
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
            (None, _) => Ok(Seen::Map(Shown::classes(scene))),
            (Some(_), [axis]) => Err(refused(format!(
                "--show is of maps over two axes, here is one, {}: leave it out, each number has a panel of its own",
                axis.name
            ))),
            (Some(quantity), _) => match scene.has(quantity) {
                Ok(()) => Ok(Seen::Map(Shown::numbers(scene, quantity))),
                Err(key) => {
                    let name = quantity.name();
                    Err(refused(format!(
                        "--show {name}: the scene does not compute it; add {key} to its table [compute]"
                    )))
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

    impl Watcher for Pictures {
        fn looks(&self) -> bool {
            !self.drawing.files.is_empty()
        }

        fn begin(&mut self) {
            match &mut self.drawing.seen {
                Seen::Map(shown) => shown.clear(),
                Seen::Cells(cells) => cells.clear(),
            }
        }

        fn cell(&mut self, number: u64, cell: &Cell) {
            if !self.looks() {
                return;
            }
            match (&mut self.drawing.seen, cell.extent, self.slice.cell(number)) {
                // A map that is refined is drawn whole.
                (Seen::Map(shown), Some(extent), _) => shown.square_of(extent, cell),
                (_, _, Some(number)) => {
                    let axes: Vec<&Values> = self.slice.scene().axes.iter().map(|axis| &axis.values).collect();
                    self.drawing.cell(&axes, number, cell);
                }
                (_, _, None) => {}
            }
        }
    }
}

#[cfg(not(feature = "plot"))]
mod without_pictures {
    use rayon::ThreadPool;
    use vibrochain_lattice::Stop;
    use vibrochain_maps::cell::Cell;
    use vibrochain_maps::scene::{Scene, Values};
    use vibrochain_maps::sweep::Watcher;

    use crate::args::{PictureArgs, QuantityName};
    use crate::common::error::CliError;
    use crate::common::pictures::files::PictureFiles;

    /// This build draws nothing.
    pub(crate) struct Pictures;

    /// This build draws nothing.
    pub(crate) struct MapDrawing;

    impl MapDrawing {
        pub(crate) fn plan<T>(wanted: &PictureArgs, _: QuantityName, _: &T) -> Result<Self, CliError> {
            PictureFiles::asked(wanted).map(|_| Self)
        }

        pub(crate) fn cell(&mut self, _: &[&Values], _: u64, _: &Cell) {}

        pub(crate) fn finish<T>(self, _: &T) -> Result<(), CliError> {
            Ok(())
        }
    }

    impl Pictures {
        pub(crate) fn plan(wanted: &PictureArgs, _: QuantityName, _: &Scene) -> Result<Self, CliError> {
            PictureFiles::asked(wanted).map(|_| Self)
        }

        pub(crate) fn find_borders(&mut self, _: &ThreadPool, _: &Stop, _: bool) -> Result<String, CliError> {
            Ok(String::new())
        }

        pub(crate) fn finish(self) -> Result<(), CliError> {
            Ok(())
        }
    }

    impl Watcher for Pictures {
        fn looks(&self) -> bool {
            false
        }

        fn begin(&mut self) {}

        fn cell(&mut self, _: u64, _: &Cell) {}
    }
}
