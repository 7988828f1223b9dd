//! Kinds of picture files.

use std::path::Path;

use thiserror::Error;
use vibrochain_maps::error::MapError;
use vibrochain_maps::files::Destination;

/// A picture that could not be drawn.
#[derive(Debug, Clone, Error)]
#[error("could not draw the picture: {0}")]
pub struct PlotError(pub String);

#[cfg(not(feature = "files"))]
impl PlotError {
    pub(crate) fn not_built() -> Self {
        Self("this build draws SVG alone: end the name in .svg, or build with the feature `pictures`".to_owned())
    }
}

/// The kinds of picture files.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Format {
    /// Pixels.
    Png,
    /// Vectors.
    Svg,
    /// Vectors, as printers and journals take them.
    Pdf,
}

// As names of such files end.
vibrochain_lattice::names!(Format { Png "png", Svg "svg", Pdf "pdf" });

impl Format {
    /// By the file's ending, `.png`, `.svg` or `.pdf`.
    pub fn of(path: &Path) -> Option<Self> {
        Self::from_name(&path.extension()?.to_str()?.to_ascii_lowercase())
    }

    /// As the end of the name that `flag` gives says; what has no ending and is no plain file gets a PNG.
    ///
    /// # Errors
    /// [`MapError::Request`] for another ending, or a plain file without one.
    pub fn asked(flag: &str, path: &Path) -> Result<Self, MapError> {
        if let Some(format) = Self::of(path) {
            return Ok(format);
        }
        if path.extension().is_none() && !matches!(Destination::of(path)?, Destination::Plain(_)) {
            return Ok(Self::Png);
        }
        vibrochain_maps::refuse!(
            "{flag} {}: the kind of picture is not known; end the name in .png, .svg or .pdf",
            path.display()
        )
    }
}
