//! How a drawing becomes a file.

use std::path::Path;

use vibrochain_maps::error::MapError;
use vibrochain_maps::files::Output;

use crate::backend::drawing::Drawing;
use crate::backend::format::{Format, PlotError};
use crate::backend::page::Page;
use crate::{backend::pdf, backend::pixels, backend::svg};

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
    if page.measures {
        return Ok(Vec::new());
    }
    match page.format {
        Format::Png => pixels::png_of(drawing, page.scale()),
        Format::Svg => Ok(svg::svg(drawing)),
        Format::Pdf => Ok(pdf::pdf(drawing)),
    }
}
