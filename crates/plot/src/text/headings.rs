//! Headings: text in as many lines as the width of a picture asks for.

use crate::backend::drawing::{Across, BLACK, Drawing, Place, Rgb, Upright};
use crate::text::font::width;

/// Distance of two lines in em.
pub(crate) const STEP: f64 = 1.36;

/// Sizes of headings against the letters of legends: what stands above a whole picture is the largest, what stands above a row or a
/// panel, or names an axis, is between; legends themselves are the body.
pub(crate) const TITLE: f64 = 1.2;
pub(crate) const HEADING: f64 = 1.13;
pub(crate) const CAPTION: f64 = 1.07;

/// Air between the edge of a picture and its words, in em: less than a letter looks cut off.
pub(crate) const EDGE: f64 = 0.8;

/// What stands above a picture, over its whole width.
pub(crate) struct Title {
    heading: Heading,
    em: f64,
}

impl Title {
    /// In letters so many times as large as those of legends, above a picture so wide.
    pub(crate) fn new(text: &str, times: f64, wide: f64, em: f64) -> Self {
        Self { heading: Heading::new(&capital(text), wide - 2.0 * EDGE * em, times * em), em }
    }

    /// Where what it stands above begins.
    pub(crate) fn foot(&self) -> f64 {
        let height = self.heading.height();
        // Without a title some air is left.
        if height > 0.0 { 1.5 * EDGE * self.em + height } else { 0.5 * EDGE * self.em }
    }

    pub(crate) fn draw(&self, drawing: &mut Drawing) {
        self.heading.draw(drawing, [EDGE * self.em; 2], BLACK);
    }
}

/// The text with a capital, if it begins with a word: a single letter is a number's name, "a = 0.4".
pub(crate) fn capital(text: &str) -> String {
    match text.as_bytes() {
        [first @ b'a'..=b'z', b'a'..=b'z' | b'-', ..] => {
            format!("{}{}", char::from(first.to_ascii_uppercase()), &text[1..])
        }
        _ => text.to_owned(),
    }
}

/// Lines of one size, from the same place on.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Heading {
    lines: Vec<String>,
    size: f64,
}

impl Heading {
    /// Breaks a text between words where it is wider than `room`.
    pub(crate) fn new(text: &str, room: f64, size: f64) -> Self {
        let most = room / size;
        let mut lines: Vec<String> = Vec::new();
        // Parts between commas hold together, "γ₁ = 0.2", as far as they fit in a line.
        let fits = |line: &str, part: &str| width(&format!("{line}{part}")) < most;
        for part in text.split_inclusive(", ") {
            let words = if width(part.trim_end()) < most { vec![part] } else { part.split_inclusive(' ').collect() };
            for word in words {
                match lines.last_mut() {
                    Some(line) if fits(line, word.trim_end()) => line.push_str(word),
                    _ => lines.push(word.to_owned()),
                }
            }
        }
        Self { lines, size }
    }

    /// Height of all lines.
    pub(crate) fn height(&self) -> f64 {
        STEP * self.size * self.lines.len() as f64
    }

    /// Draws the lines, the upper left corner of the first one at a place.
    pub(crate) fn draw(&self, drawing: &mut Drawing, [x, y]: Place, colour: Rgb) {
        for (i, line) in self.lines.iter().enumerate() {
            let at = [x, y + i as f64 * STEP * self.size];
            drawing.anchored(line.trim_end(), at, self.size, colour, (Across::Left, Upright::Top));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_heading_begins_with_a_capital_unless_it_is_a_number() {
        let told = ["branches of breathers", "a = 0.4, e = 0.9", "γ₁ = 0.2", "0+ of a beam", "", "é"].map(capital);
        assert_eq!(told, ["Branches of breathers", "a = 0.4, e = 0.9", "γ₁ = 0.2", "0+ of a beam", "", "é"]);
    }

    #[test]
    fn a_heading_loses_no_word_and_no_line_is_too_wide() {
        let text = "double-sided breather 1: N = 20, γ₁ = 0.2790465016543734, γ₂ = 0.13606569615937517, force \
                    1:0.1:0,3:-0.03:0.5,5:0.01:0, e = 0.9";
        for (room, lines) in [(2000.0, 1), (600.0, 2), (200.0, 5)] {
            let heading = Heading::new(text, room, 17.0);
            assert_eq!(heading.lines.concat(), text, "{room}");
            let height = 17.0 * STEP * heading.lines.len() as f64;
            assert!(heading.lines.len() >= lines && heading.height() == height, "{heading:?}");
            // A single word may be.
            let words = |line: &str| line.trim_end().split(' ').count();
            let fits = |line: &String| 17.0 * width(line.trim_end()) < room || words(line) == 1;
            assert!(heading.lines.iter().all(fits), "{heading:?}");
        }
        assert!(Heading::new("γ₁ = 0.2, γ₂ = 0.1", 110.0, 17.0).lines == ["γ₁ = 0.2, ", "γ₂ = 0.1"]);
        assert_eq!(Heading::new("", 100.0, 17.0).height(), 0.0);
    }
}
