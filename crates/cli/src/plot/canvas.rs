//! From drawing commands to the bytes of a PNG or SVG file.

use std::path::Path;
use std::sync::Once;

use image::ImageEncoder;
use image::codecs::png::PngEncoder;
use plotters::coord::Shift;
use plotters::prelude::{BitMapBackend, DrawingArea, DrawingBackend, IntoDrawingArea, SVGBackend};
use plotters::style::{FontStyle, register_font};
use thiserror::Error;

use crate::error::CliError;
use crate::output::Output;

/// A picture that could not be drawn.
#[derive(Debug, Clone, Error)]
#[error("could not draw the picture: {0}")]
pub struct PlotError(pub(crate) String);

impl PlotError {
    pub(crate) fn from(error: impl std::fmt::Display) -> Self {
        Self(error.to_string())
    }
}

/// The two kinds of picture files.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Format {
    /// Pixels.
    Png,
    /// Vectors.
    Svg,
}

impl Format {
    /// By the file's ending, `.png` or `.svg`.
    pub fn of(path: &Path) -> Option<Self> {
        match path.extension()?.to_str()?.to_ascii_lowercase().as_str() {
            "png" => Some(Self::Png),
            "svg" => Some(Self::Svg),
            _ => None,
        }
    }
}

/// Opens the file of a picture that was asked for with --plot; its ending says what kind it is.
///
/// # Errors
/// [`CliError::Request`] for another ending, or a place that cannot be written.
pub(crate) fn open(path: Option<&Path>) -> Result<Option<(Format, Output)>, CliError> {
    let Some(path) = path else { return Ok(None) };
    let format = Format::of(path).ok_or_else(|| {
        let name = path.display();
        CliError::Request(format!("--plot {name}: the kind of picture is not known; end the name in .png or .svg"))
    })?;
    Ok(Some((format, Output::create(path)?)))
}

/// A drawing that does not care which kind of file it ends up in.
pub(crate) trait Drawing {
    /// Draws on an area of the size that was asked for.
    fn draw<B: DrawingBackend>(&self, area: &DrawingArea<B, Shift>) -> Result<(), PlotError>;
}

/// DejaVu Sans, which has the Greek letters and subscripts of the model's symbols; its licence lies beside it.
fn font() {
    static REGISTERED: Once = Once::new();
    REGISTERED.call_once(|| {
        // The font is part of the program: that it can be read is checked by the tests.
        let _ = register_font("sans-serif", FontStyle::Normal, include_bytes!("../../assets/DejaVuSans.ttf"));
    });
}

/// The bytes of a picture.
pub(crate) fn render(
    drawing: &impl Drawing,
    format: Format,
    (width, height): (u32, u32),
) -> Result<Vec<u8>, PlotError> {
    font();
    match format {
        Format::Png => {
            let mut pixels = vec![255; 3 * width as usize * height as usize];
            {
                let area = BitMapBackend::with_buffer(&mut pixels, (width, height)).into_drawing_area();
                drawing.draw(&area)?;
                area.present().map_err(PlotError::from)?;
            }
            let mut file = Vec::new();
            PngEncoder::new(&mut file)
                .write_image(&pixels, width, height, image::ColorType::Rgb8)
                .map_err(PlotError::from)?;
            Ok(file)
        }
        Format::Svg => {
            let mut text = String::new();
            {
                let area = SVGBackend::with_string(&mut text, (width, height)).into_drawing_area();
                drawing.draw(&area)?;
                area.present().map_err(PlotError::from)?;
            }
            // Cells keep their edges at any magnification.
            Ok(text.replace("<image ", "<image image-rendering=\"pixelated\" ").into_bytes())
        }
    }
}
