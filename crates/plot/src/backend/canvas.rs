//! How a drawing becomes a file.

use std::path::Path;

use vibrochain_maps::error::MapError;
use vibrochain_maps::files::Output;

use crate::backend::drawing::Drawing;
use crate::backend::format::{Format, PlotError};
use crate::backend::page::Page;
use crate::backend::svg;
#[cfg(feature = "files")]
use crate::backend::{pdf, pixels};

/// Opens the file of a picture that was asked for with `flag`; its ending says what kind it is.
///
/// # Errors
/// [`MapError::Request`] for another ending, or a place that cannot be written.
pub fn open(flag: &str, path: Option<&Path>) -> Result<Option<(Format, Output)>, MapError> {
    let Some(path) = path else { return Ok(None) };
    Ok(Some((Format::asked(flag, path)?, Output::create(path)?)))
}

/// The bytes of a picture.
///
/// # Errors
/// [`PlotError`] of a picture that has no size, or more pixels than any viewer shows.
pub fn render(drawing: &Drawing, page: &Page) -> Result<Vec<u8>, PlotError> {
    page.holds(drawing.size)?;
    match page.format {
        #[cfg(not(feature = "files"))]
        Format::Png | Format::Pdf => Err(PlotError::not_built()),
        _ if page.measures => Ok(Vec::new()),
        Format::Svg => Ok(svg::svg(drawing)),
        #[cfg(feature = "files")]
        Format::Png => pixels::png_of(drawing, page.scale()),
        #[cfg(feature = "files")]
        Format::Pdf => Ok(pdf::pdf(drawing)),
    }
}
