//! From drawing commands to the bytes of a PNG or SVG file.

use std::path::Path;
use std::sync::Once;

use image::ImageEncoder;
use image::codecs::png::PngEncoder;
use plotters::coord::Shift;
use plotters::prelude::{BitMapBackend, DrawingArea, DrawingBackend, IntoDrawingArea, SVGBackend};
use plotters::style::{FontStyle, register_font};
use thiserror::Error;

use vibrochain_maps::error::MapError;
use vibrochain_maps::files::Output;
use vibrochain_maps::files::{Destination, promises};

/// A picture that could not be drawn.
#[derive(Debug, Clone, Error)]
#[error("could not draw the picture: {0}")]
pub struct PlotError(pub String);

impl PlotError {
    /// In the words of what failed.
    pub fn from(error: impl std::fmt::Display) -> Self {
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
        let advice = "the kind of picture is not known; end the name in .png or .svg";
        Err(MapError::Request(format!("{flag} {name}: {advice}")))
    }

    /// Makes sure that a name given to the flag of this format, --png or --svg, promises nothing else.
    ///
    /// # Errors
    /// [`MapError::Request`].
    pub fn promised(self, path: &Path) -> Result<(), MapError> {
        match self {
            Self::Png => promises("--png", path, "a picture of pixels", &["png"])?,
            Self::Svg => promises("--svg", path, "a picture of vectors", &["svg"])?,
        }
        Ok(())
    }
}

/// Opens the file of a picture that was asked for with `flag`; its ending says what kind it is.
///
/// # Errors
/// [`MapError::Request`] for another ending, or a place that cannot be written.
pub fn open(flag: &str, path: Option<&Path>) -> Result<Option<(Format, Output)>, MapError> {
    let Some(path) = path else { return Ok(None) };
    Ok(Some((Format::asked(flag, path)?, Output::create(path)?)))
}

/// A drawing that does not care which kind of file it ends up in.
pub trait Drawing {
    /// Draws on an area of the size that was asked for.
    fn draw<B: DrawingBackend>(&self, area: &DrawingArea<B, Shift>) -> Result<(), PlotError>;

    /// Elements of an SVG that lie over all that is drawn.
    fn overlay(&self) -> Option<String> {
        None
    }

    /// Elements of an SVG that lie under all that is drawn, on the ground that is filled first.
    fn shapes(&self) -> Option<String> {
        None
    }
}

/// DejaVu Sans, which has the Greek letters and subscripts of the model's symbols; its licence lies beside it.
fn font() {
    static REGISTERED: Once = Once::new();
    REGISTERED.call_once(|| {
        // The font is part of the program: that it can be read is checked by the tests.
        let _ = register_font("sans-serif", FontStyle::Normal, include_bytes!("../assets/DejaVuSans.ttf"));
    });
}

/// Whether XML 1.0 knows a character, however it is written; a title from a scene may hold any.
fn is_of_xml(c: char) -> bool {
    matches!(c, '\t' | '\n' | '\r' | ' '..='\u{fffd}' | '\u{10000}'..)
}

/// The bytes of a picture.
pub fn render(drawing: &impl Drawing, format: Format, (width, height): (u32, u32)) -> Result<Vec<u8>, PlotError> {
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
            if let Some(shapes) = drawing.shapes() {
                let ground = text.find("/>").map_or(0, |end| end + 2);
                text.insert_str(ground, &format!("\n{shapes}"));
            }
            if let Some(overlay) = drawing.overlay() {
                let end = text.rfind("</svg>").unwrap_or(text.len());
                text.insert_str(end, &overlay);
            }
            // Cells keep their edges at any magnification.
            let text = text.replace("<image ", "<image image-rendering=\"pixelated\" ");
            Ok(text.replace(|c| !is_of_xml(c), "\u{fffd}").into_bytes())
        }
    }
}

#[cfg(test)]
mod tests {
    use plotters::element::Text;
    use plotters::prelude::IntoFont;

    use super::*;

    struct Words(String);

    impl Drawing for Words {
        fn draw<B: DrawingBackend>(&self, area: &DrawingArea<B, Shift>) -> Result<(), PlotError> {
            area.draw(&Text::new(self.0.clone(), (20, 20), ("sans-serif", 20).into_font())).map_err(PlotError::from)
        }
    }

    #[test]
    fn whatever_a_title_holds_its_picture_is_xml() {
        // All characters below the surrogates, with those that mean something to XML, and a few beyond.
        let most: String =
            (0..0xd800_u32).chain([0xe000, 0xfffd, 0xfffe, 0xffff, 0x1_f600]).filter_map(char::from_u32).collect();
        let svg = String::from_utf8(render(&Words(most), Format::Svg, (100, 100)).unwrap()).unwrap();
        let forbidden = |c: char| (c < ' ' && !"\t\n\r".contains(c)) || c == '\u{fffe}' || c == '\u{ffff}';
        assert!(svg.contains("γ") && svg.contains("&lt;") && !svg.contains(forbidden));
        // All of the first 32 but three, and two more.
        assert!(svg.matches('\u{fffd}').count() >= 29 + 2);
        assert_eq!(svg.matches("<text").count(), 1);
        assert!(!render(&Words("\u{7}\u{0}\u{1b}[31m".to_owned()), Format::Png, (100, 100)).unwrap().is_empty());
    }
}
