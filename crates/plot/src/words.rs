//! Headings: text in as many lines as the width of a picture asks for.

use plotters::coord::Shift;
use plotters::element::Text;
use plotters::prelude::{DrawingArea, DrawingBackend, IntoFont, RGBColor};

use crate::canvas::PlotError;

/// About the width of a text over the size of the font, on the generous side.
fn width_of(text: &str) -> f64 {
    let letter = |c: char| match c {
        ' ' | ',' | '.' | ':' | ';' | '|' | 'i' | 'j' | 'l' => 0.3,
        '=' | '+' | '−' | 'm' | 'w' | 'M' | 'W' | 'ω' => 0.85,
        _ => 0.56,
    };
    text.chars().map(letter).sum()
}

/// Lines of one size and colour, from the same place on.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Heading {
    lines: Vec<String>,
    size: u32,
}

impl Heading {
    /// Breaks a text between words where it is wider than `width` pixels.
    pub(crate) fn new(text: &str, width: u32, size: u32) -> Self {
        let most = f64::from(width) / f64::from(size);
        let mut lines: Vec<String> = Vec::new();
        // Parts between commas hold together, "γ₁ = 0.2", as far as they fit in a line.
        let fits = |line: &str, part: &str| width_of(line) + width_of(part) < most;
        for part in text.split_inclusive(", ") {
            let words = if width_of(part) < most { vec![part] } else { part.split_inclusive(' ').collect() };
            for word in words {
                match lines.last_mut() {
                    Some(line) if fits(line, word.trim_end()) => line.push_str(word),
                    _ => lines.push(word.to_owned()),
                }
            }
        }
        Self { lines, size }
    }

    /// Distance of two lines.
    fn step(&self) -> u32 {
        self.size * 4 / 3
    }

    /// Height of all lines.
    pub(crate) fn height(&self) -> u32 {
        self.step() * self.lines.len() as u32
    }

    /// Draws the lines, the upper left corner of the first one at a place.
    pub(crate) fn draw<B: DrawingBackend>(
        &self,
        area: &DrawingArea<B, Shift>,
        (x, y): (i32, i32),
        colour: RGBColor,
    ) -> Result<(), PlotError> {
        for (i, line) in self.lines.iter().enumerate() {
            let style = ("sans-serif", self.size).into_font().color(&colour);
            let place = (x, y + i as i32 * self.step() as i32);
            area.draw(&Text::new(line.trim_end().to_owned(), place, style)).map_err(PlotError::from)?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_heading_loses_no_word_and_no_line_is_too_wide() {
        let text = "double-sided breather 1: N = 20, γ₁ = 0.2790465016543734, γ₂ = 0.13606569615937517, force \
                    1:0.1:0,3:-0.03:0.5,5:0.01:0, e = 0.9";
        for (width, lines) in [(2000, 1), (600, 2), (200, 5)] {
            let heading = Heading::new(text, width, 17);
            assert_eq!(heading.lines.concat(), text, "{width}");
            assert!(heading.lines.len() >= lines && heading.height() == 22 * heading.lines.len() as u32, "{heading:?}");
            // A single word may be.
            let words = |line: &str| line.trim_end().split(' ').count();
            let fits = |line: &String| 17.0 * width_of(line.trim_end()) < f64::from(width) || words(line) == 1;
            assert!(heading.lines.iter().all(fits), "{heading:?}");
        }
        assert!(Heading::new("γ₁ = 0.2, γ₂ = 0.1", 110, 17).lines == ["γ₁ = 0.2, ", "γ₂ = 0.1"]);
        assert_eq!(Heading::new("", 100, 17).height(), 0);
    }
}
