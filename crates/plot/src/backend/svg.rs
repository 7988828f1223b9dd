//! A drawing as an SVG: the same places, to a thousandth of a unit; letters as outlines that each stand in the file once, so that it
//! looks the same without any font.

use std::collections::BTreeSet;
use std::fmt::Write;

use crate::backend::drawing::{Drawing, Element, Fill, Image, Line, Place, Rgb, Shape, Words};
use crate::backend::png::png;
use crate::text::font::{Step, outline, set};
use crate::text::typeset::corner;

/// Units of an em in outlines of letters.
const EM: f64 = 1000.0;

/// The bytes of the file.
pub(crate) fn svg(drawing: &Drawing) -> Vec<u8> {
    with_elements(drawing, "")
}

/// The same with further elements over all that is drawn.
pub(crate) fn with_elements(drawing: &Drawing, over: &str) -> Vec<u8> {
    let mut body = Writer { text: String::new(), letters: BTreeSet::new(), clips: 0 };
    body.elements(&drawing.elements);
    let [width, height] = drawing.size.map(number);
    let title = escaped(&drawing.title);
    let mut text = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}\" height=\"{height}\" viewBox=\"0 0 {width} {height}\" role=\"img\" \
         aria-label=\"{title}\">\n<title>{title}</title>\n<defs>\n"
    );
    for (number, pattern) in drawing.patterns.iter().enumerate() {
        let size = format!("width=\"{0}\" height=\"{0}\"", pattern.period);
        let marks: String = pattern.squares.iter().map(|[x, y]| format!("M{x} {y}h1v1h-1z")).collect();
        let (ground, colour) = (hex(pattern.ground), hex(pattern.marks));
        let _ = writeln!(
            text,
            "<pattern id=\"texture{number}\" patternUnits=\"userSpaceOnUse\" {size}><rect {size} fill=\"{ground}\"/>\
             <path shape-rendering=\"crispEdges\" fill=\"{colour}\" d=\"{marks}\"/></pattern>"
        );
    }
    for &letter in &body.letters {
        let _ = writeln!(text, "<path id=\"g{letter}\" d=\"{}\"/>", drawn(letter));
    }
    let _ = write!(
        text,
        "</defs>\n<rect width=\"{width}\" height=\"{height}\" fill=\"#ffffff\"/>\n{}{over}</svg>\n",
        body.text
    );
    text.replace(|c| !is_of_xml(c), "\u{fffd}").into_bytes()
}

/// Whether XML 1.0 knows a character, however it is written; a title from a scene may hold any.
fn is_of_xml(c: char) -> bool {
    matches!(c, '\t' | '\n' | '\r' | ' '..='\u{fffd}' | '\u{10000}'..)
}

/// A text within XML.
fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

/// A number to a thousandth, in as few digits as that takes.
pub(crate) fn number(value: f64) -> String {
    let text = format!("{value:.3}");
    let text = text.trim_end_matches('0').trim_end_matches('.');
    if text == "-0" { "0".to_owned() } else { text.to_owned() }
}

/// A colour as an SVG has it.
pub(crate) fn hex([r, g, b]: Rgb) -> String {
    format!("#{r:02x}{g:02x}{b:02x}")
}

/// The commands of a line; none if it does not leave its first place.
fn path(line: &[Place], closed: bool) -> String {
    let mut places: Vec<String> = line.iter().map(|[x, y]| format!("{} {}", number(*x), number(*y))).collect();
    places.dedup();
    if places.len() < if closed { 3 } else { 2 } {
        return String::new();
    }
    format!("M{}{}", places.join("L"), if closed { "Z" } else { "" })
}

struct Writer {
    text: String,
    letters: BTreeSet<u16>,
    clips: usize,
}

impl Writer {
    fn elements(&mut self, elements: &[Element]) {
        for element in elements {
            match element {
                Element::Shape(shape) => self.shape(shape),
                Element::Circle(circle) => {
                    let [x, y] = circle.centre.map(number);
                    let style = style(circle.fill.map(Fill::Colour), circle.line);
                    let _ =
                        writeln!(self.text, "<circle cx=\"{x}\" cy=\"{y}\" r=\"{}\"{style}/>", number(circle.radius));
                }
                Element::Words(words) => self.words(words),
                Element::Image(image) => self.image(image),
                Element::Clipped([[left, top], [right, bottom]], inside) => {
                    self.clips += 1;
                    let id = self.clips;
                    let [x, y, w, h] = [*left, *top, right - left, bottom - top].map(number);
                    let _ = writeln!(
                        self.text,
                        "<clipPath id=\"c{id}\"><rect x=\"{x}\" y=\"{y}\" width=\"{w}\" height=\"{h}\"/></clipPath>\n\
                         <g clip-path=\"url(#c{id})\">"
                    );
                    self.elements(inside);
                    self.text += "</g>\n";
                }
            }
        }
    }

    fn shape(&mut self, shape: &Shape) {
        let d: String = shape.outlines.iter().map(|line| path(line, shape.closed)).collect();
        if d.is_empty() {
            return;
        }
        let style = style(shape.fill, shape.line);
        if shape.title.is_empty() {
            let _ = writeln!(self.text, "<path{style} d=\"{d}\"/>");
        } else {
            let title = escaped(&shape.title);
            let _ = writeln!(self.text, "<path{style} d=\"{d}\"><title>{title}</title></path>");
        }
    }

    fn words(&mut self, words: &Words) {
        let setting = set(&words.text);
        let [x, y] = corner(words, setting.width).map(number);
        let turned = if words.upwards { " rotate(-90)" } else { "" };
        let (label, colour) = (escaped(&words.text), hex(words.colour));
        let scale = format!("{:.6}", words.size / EM);
        let _ = write!(
            self.text,
            "<g aria-label=\"{label}\" fill=\"{colour}\" transform=\"translate({x} {y}){turned} scale({scale})\">"
        );
        for letter in setting.letters {
            self.letters.insert(letter.glyph);
            let _ = write!(self.text, "<use href=\"#g{}\" x=\"{:.0}\"", letter.glyph, letter.at[0] * EM);
            if letter.at[1] != 0.0 {
                let _ = write!(self.text, " y=\"{:.0}\"", -letter.at[1] * EM);
            }
            self.text += "/>";
        }
        self.text += "</g>\n";
    }

    fn image(&mut self, image: &Image) {
        let Some(file) = png(image.pixels, &image.rgb, None) else { return };
        let ([x, y], [w, h]) = (image.at.map(number), image.size.map(number));
        // Cells keep their edges at any magnification.
        let _ = writeln!(
            self.text,
            "<image image-rendering=\"pixelated\" preserveAspectRatio=\"none\" x=\"{x}\" y=\"{y}\" width=\"{w}\" height=\"{h}\" \
             href=\"data:image/png;base64,{}\"/>",
            base64(&file)
        );
    }
}

fn style(fill: Option<Fill>, line: Option<Line>) -> String {
    let mut text = match fill {
        None => " fill=\"none\"".to_owned(),
        Some(Fill::Colour(colour)) => format!(" fill=\"{}\"", hex(colour)),
        Some(Fill::Pattern(number)) => format!(" fill=\"url(#texture{number})\""),
    };
    if let Some(line) = line {
        let _ = write!(
            text,
            " stroke=\"{}\" stroke-width=\"{}\" stroke-linejoin=\"round\"",
            hex(line.colour),
            number(line.width)
        );
        if let Some([dash, gap]) = line.dash {
            let _ = write!(text, " stroke-dasharray=\"{} {}\"", number(dash), number(gap));
        }
        if line.opacity < 1.0 {
            let _ = write!(text, " stroke-opacity=\"{}\"", number(line.opacity));
        }
        if fill.is_none() && line.dash.is_some() || line.opacity < 1.0 {
            // What has a title below is still found.
            text += " pointer-events=\"none\"";
        }
    }
    text
}

/// The outline of a letter in thousandths of an em, downwards.
fn drawn(letter: u16) -> String {
    let mut text = String::new();
    for step in outline(letter) {
        let (command, places) = match &step {
            Step::Start(to) => ('M', std::slice::from_ref(to)),
            Step::Line(to) => ('L', std::slice::from_ref(to)),
            Step::Curve(places) => ('C', &places[..]),
            Step::Close => ('Z', &[][..]),
        };
        let places = places.iter().map(|[x, y]| format!("{} {}", (x * EM).round(), (-y * EM).round() + 0.0));
        text.push(command);
        text += &places.collect::<Vec<_>>().join(" ");
    }
    text
}

/// Bytes as letters, three as four.
fn base64(bytes: &[u8]) -> String {
    const LETTERS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let mut text = String::with_capacity(bytes.len().div_ceil(3) * 4);
    for three in bytes.chunks(3) {
        let all = (0..3).fold(0_u32, |all, i| all << 8 | u32::from(three.get(i).copied().unwrap_or(0)));
        for i in 0..4 {
            let letter = LETTERS[(all >> (18 - 6 * i) & 63) as usize] as char;
            text.push(if i <= three.len() { letter } else { '=' });
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::backend::drawing::BLACK;

    #[test]
    fn whatever_a_title_holds_its_picture_is_xml() {
        // All characters below the surrogates, with those that mean something to XML, and a few beyond.
        let most: String =
            (0..0xd800_u32).chain([0xe000, 0xfffd, 0xfffe, 0xffff, 0x1_f600]).filter_map(char::from_u32).collect();
        let mut drawing = Drawing::new([100.0, 100.0], &most);
        drawing.words(&most, [10.0, 20.0], 15.0, BLACK);
        let text = String::from_utf8(svg(&drawing)).unwrap();
        let forbidden = |c: char| (c < ' ' && !"\t\n\r".contains(c)) || c == '\u{fffe}' || c == '\u{ffff}';
        assert!(text.contains("γ") && text.contains("&lt;") && !text.contains(forbidden));
        // All of the first 32 but three, and two more; in the title, its name and the words.
        assert!(text.matches('\u{fffd}').count() >= 3 * (29 + 2));
    }

    #[test]
    fn bytes_become_letters_by_the_book() {
        // RFC 4648, section 10.
        for (bytes, letters) in
            [("", ""), ("f", "Zg=="), ("fo", "Zm8="), ("foo", "Zm9v"), ("foob", "Zm9vYg=="), ("foobar", "Zm9vYmFy")]
        {
            assert_eq!(base64(bytes.as_bytes()), letters);
        }
    }

    #[test]
    fn places_keep_three_digits() {
        assert_eq!([0.1234567, -0.0001, 12.0, 1e5 + 0.25].map(number), ["0.123", "0", "12", "100000.25"]);
        assert_eq!(path(&[[0.0, 0.0], [0.0, 1e-5], [1.5, 2.0]], false), "M0 0L1.5 2");
        assert_eq!(path(&[[1.0, 1.0], [1.0, 1.0]], false), "");
    }
}
