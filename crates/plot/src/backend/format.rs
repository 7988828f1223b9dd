//! Kinds of picture files.

use std::path::Path;

use thiserror::Error;
use vibrochain_maps::error::MapError;
use vibrochain_maps::files::{Destination, promises};

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

impl Format {
    /// By the file's ending, `.png`, `.svg` or `.pdf`.
    pub fn of(path: &Path) -> Option<Self> {
        match path.extension()?.to_str()?.to_ascii_lowercase().as_str() {
            "png" => Some(Self::Png),
            "svg" => Some(Self::Svg),
            "pdf" => Some(Self::Pdf),
            _ => None,
        }
    }

    /// How names of such files end.
    pub fn ending(self) -> &'static str {
        match self {
            Self::Png => "png",
            Self::Svg => "svg",
            Self::Pdf => "pdf",
        }
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
        let name = path.display();
        let advice = "the kind of picture is not known; end the name in .png, .svg or .pdf";
        Err(MapError::Request(format!("{flag} {name}: {advice}")))
    }

    /// Makes sure that a name given to the flag of this format, --png, --svg or --pdf, promises nothing else.
    ///
    /// # Errors
    /// [`MapError::Request`].
    pub fn promised(self, path: &Path) -> Result<(), MapError> {
        match self {
            Self::Png => promises("--png", path, "a picture of pixels", &["png"])?,
            Self::Svg => promises("--svg", path, "a picture of vectors", &["svg"])?,
            Self::Pdf => promises("--pdf", path, "a picture for print", &["pdf"])?,
        }
        Ok(())
    }
}
