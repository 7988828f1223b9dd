//! Letters of the font that is shipped: how wide a text is, where each of its letters stands, kerned, and their outlines.

use std::sync::OnceLock;

use harfrust::font::glyph::outline::{DrawMemory, DrawOptions, PathSink};
use harfrust::{Buffer, Font, GlyphId, ShapeOptions, ShaperFont, shape};

/// DejaVu Sans has the Greek letters, subscripts and dots of the model's symbols; its licence lies beside it.
const FONT: &[u8] = include_bytes!("../../assets/DejaVuSans.ttf");

fn font() -> Option<&'static Font> {
    static READ: OnceLock<Option<Font>> = OnceLock::new();
    // The font is part of the program: that it can be read is checked by the tests.
    READ.get_or_init(|| Font::new(FONT, 0)).as_ref()
}

/// A letter of a text.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Letter {
    /// Its number in the font.
    pub(crate) glyph: u16,
    /// Where it stands from the beginning of the text, in em: to the right, and upwards.
    pub(crate) at: [f64; 2],
}

/// A line that is set.
#[derive(Debug, Clone, PartialEq, Default)]
pub(crate) struct Setting {
    /// In em.
    pub(crate) width: f64,
    pub(crate) letters: Vec<Letter>,
}

/// Sets a text in one line.
pub(crate) fn set(text: &str) -> Setting {
    let Some(font) = font() else { return Setting::default() };
    let em = f64::from(font.units_per_em());
    let mut buffer = Buffer::new();
    // A control character has no letter.
    buffer.push_str(&text.replace(char::is_control, " "));
    buffer.guess_segment_properties();
    if shape(&ShaperFont::new(font), &mut buffer, ShapeOptions::new()).is_err() {
        return Setting::default();
    }
    let mut setting = Setting::default();
    for (info, place) in buffer.glyph_infos().iter().zip(buffer.glyph_positions()) {
        let at = [setting.width + f64::from(place.x_offset) / em, f64::from(place.y_offset) / em];
        // Numbers of letters have sixteen bits in every font of this kind.
        setting.letters.push(Letter { glyph: info.glyph_id as u16, at });
        setting.width += f64::from(place.x_advance) / em;
    }
    setting
}

/// The width of a text in em.
pub(crate) fn width(text: &str) -> f64 {
    set(text).width
}

/// A step of an outline.
pub(crate) enum Step {
    Start([f64; 2]),
    Line([f64; 2]),
    /// Two control points, and the end.
    Curve([[f64; 2]; 3]),
    Close,
}

/// The outline of a letter in em, upwards from where it stands.
pub(crate) fn outline(glyph: u16) -> Vec<Step> {
    let Some(font) = font() else { return Vec::new() };
    let Some(found) = font.outline_glyphs().get(GlyphId::from(glyph)) else { return Vec::new() };
    let mut scaled = Scaled { steps: Vec::new(), em: 1.0 / f64::from(font.units_per_em()), last: [0.0; 2] };
    // It fails for broken outlines alone: those of this font are drawn by a test.
    let _ = found.draw(&DrawOptions::new(), DrawMemory::Scratch, &mut scaled);
    scaled.steps
}

struct Scaled {
    steps: Vec<Step>,
    em: f64,
    last: [f64; 2],
}

impl Scaled {
    fn at(&self, x: f32, y: f32) -> [f64; 2] {
        [f64::from(x) * self.em, f64::from(y) * self.em]
    }
}

impl PathSink for Scaled {
    fn move_to(&mut self, x: f32, y: f32) {
        self.last = self.at(x, y);
        self.steps.push(Step::Start(self.last));
    }

    fn line_to(&mut self, x: f32, y: f32) {
        self.last = self.at(x, y);
        self.steps.push(Step::Line(self.last));
    }

    fn quad_to(&mut self, x1: f32, y1: f32, x: f32, y: f32) {
        let (from, by, to) = (self.last, self.at(x1, y1), self.at(x, y));
        // The same curve by two control points.
        let toward = |end: [f64; 2]| [0, 1].map(|i| end[i] + 2.0 / 3.0 * (by[i] - end[i]));
        self.steps.push(Step::Curve([toward(from), toward(to), to]));
        self.last = to;
    }

    fn curve_to(&mut self, x1: f32, y1: f32, x2: f32, y2: f32, x: f32, y: f32) {
        self.last = self.at(x, y);
        self.steps.push(Step::Curve([self.at(x1, y1), self.at(x2, y2), self.last]));
    }

    fn close(&mut self) {
        self.steps.push(Step::Close);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_font_has_every_letter_of_the_symbols() {
        let all = "γ₁γ₂γ₃ωΩₖₗₙφψχμδεθκλ≤≥≈−–…×·|½²³⁻⁰¹⁴⁵⁶⁷⁸⁹₀₁ÄäÖöÜüßéè°′″→←⌊⌋√∞";
        for c in all.chars() {
            let setting = set(&c.to_string());
            assert!(setting.letters.len() == 1 && setting.letters[0].glyph != 0, "{c}");
            assert!(setting.width > 0.1 && setting.width < 1.3, "{c} {}", setting.width);
        }
    }

    /// Pairs come closer where their shapes leave a gap, and the dot of a velocity stands over its letter.
    #[test]
    fn pairs_are_kerned_and_dots_stand_over_their_letters() {
        assert!(width("AV") < width("A") + width("V") - 0.03);
        assert!(width("VA.") < width("V") + width("A") + width("."));
        let dotted = set("u\u{307}");
        let letters: Vec<(f64, f64, f64)> = dotted
            .letters
            .iter()
            .map(|letter| {
                let places = outline(letter.glyph).into_iter().flat_map(|step| match step {
                    Step::Start(to) | Step::Line(to) => vec![to],
                    Step::Curve(places) => places.to_vec(),
                    Step::Close => Vec::new(),
                });
                let places: Vec<_> = places.collect();
                let xs = places.iter().map(|place| place[0] + letter.at[0]);
                let ys = places.iter().map(|place| place[1] + letter.at[1]);
                let (low, high) = xs.fold((f64::MAX, f64::MIN), |(l, h), x| (l.min(x), h.max(x)));
                (0.5 * (low + high), high - low, ys.fold(f64::MIN, f64::max))
            })
            .collect();
        match letters.as_slice() {
            // One letter with its dot, or two of which the narrow one is over the middle of the other.
            [(.., top)] => assert!(*top > 0.65),
            [(middle, wide, _), (dot, narrow, top)] => {
                assert!((middle - dot).abs() < 0.05 && narrow < wide && *top > 0.6, "{letters:?}");
            }
            _ => panic!("{letters:?}"),
        }
        assert!((width("u\u{307}") - width("u")).abs() < 1e-9);
        assert_eq!(width(""), 0.0);
        assert!(set("a\u{7}\u{0}b").letters.len() == 4);
    }
}
