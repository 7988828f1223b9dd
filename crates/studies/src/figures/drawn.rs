//! What comes of a scene: a picture, the numbers behind it, and what is found in them.

use vibrochain_cli::common::error::CliError;
use vibrochain_maps::cell::Cell;
use vibrochain_maps::numbers::Number;
use vibrochain_maps::scene::Scene;
use vibrochain_plot::{Curves, Format, MapCells, MapPicture, Palette, PlotError, curves_picture, map_picture};

/// A figure that has been computed.
pub(super) struct Drawn {
    pub(super) picture: Picture,
    /// The numbers behind the picture.
    pub(super) table: Vec<u8>,
    /// Further tables: what is added to the file's name, and the bytes.
    pub(super) more: Vec<(&'static str, Vec<u8>)>,
    /// Markdown for the document.
    pub(super) findings: Vec<String>,
}

/// The two kinds of pictures.
pub(super) enum Picture {
    Curves(Box<Curves>),
    Map { scene: Box<Scene>, cells: MapCells },
}

impl Picture {
    pub(super) fn map(scene: &Scene, cells: &[Cell]) -> Self {
        let mut shown = MapCells::classes(scene);
        (0..).zip(cells).for_each(|(number, cell)| shown.cell(number, cell));
        Self::Map { scene: Box::new(scene.clone()), cells: shown }
    }

    pub(super) fn bytes(&self, format: Format) -> Result<Vec<u8>, PlotError> {
        match self {
            Self::Curves(curves) => curves_picture(curves, format),
            Self::Map { scene, cells } => map_picture(
                &MapPicture { scene: scene.as_ref(), cells, palette: Palette::Colour, borders: &[] },
                format,
            ),
        }
    }
}

/// A CSV table under way.
pub(super) struct Sheet(csv::Writer<Vec<u8>>);

fn failed(error: impl std::fmt::Display) -> CliError {
    CliError::Computation(format!("could not write a table: {error}"))
}

impl Sheet {
    pub(super) fn new(columns: &[&str]) -> Result<Self, CliError> {
        let mut writer = csv::Writer::from_writer(Vec::new());
        writer.write_record(columns).map_err(failed)?;
        Ok(Self(writer))
    }

    /// Words first, then numbers; a number that is not finite is an empty field.
    pub(super) fn row(&mut self, words: &[&str], numbers: &[f64]) -> Result<(), CliError> {
        let number = |value: &f64| if value.is_finite() { Number(*value).to_string() } else { String::new() };
        let fields = words.iter().map(|&word| word.to_owned()).chain(numbers.iter().map(number));
        self.0.write_record(fields).map_err(failed)
    }

    pub(super) fn bytes(self) -> Result<Vec<u8>, CliError> {
        self.0.into_inner().map_err(failed)
    }
}

/// The file of a figure: `figure-9.png`, `figure-9-branches.csv`.
pub(super) fn file_name(id: &str, suffix: &str, ending: &str) -> String {
    format!("figure-{id}{suffix}.{ending}")
}
