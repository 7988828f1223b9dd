//! A drawing as a PDF: the same vectors, letters as outlines, rasters unchanged.

use std::io::Write;

use flate2::Compression;
use flate2::write::ZlibEncoder;
use pdf_writer::types::{LineJoinStyle, PaintType, TilingType};
use pdf_writer::{Content, Dict, Filter, Finish, Name, Pdf, Rect, Ref, TextStr};

use crate::backend::drawing::{Drawing, Element, Fill, Image, Line, Pattern, Place, Rgb, Shape, Words};
use crate::backend::page::POINT;
use crate::text::font::{Step, outline, set};
use crate::text::typeset::corner;

/// A circle is drawn by four curves; their control points are so many radii from their ends.
const ROUND: f64 = 0.552_284_749_830_793_4;

/// The bytes of the file.
pub(crate) fn pdf(drawing: &Drawing) -> Vec<u8> {
    let mut writer = Writer { content: Content::new(), images: Vec::new(), opacities: Vec::new() };
    let [width, height] = drawing.size.map(|side| (side / POINT) as f32);
    // Downwards, in units of a screen.
    let unit = (1.0 / POINT) as f32;
    writer.content.transform([unit, 0.0, 0.0, -unit, 0.0, height]);
    writer.elements(&drawing.elements);
    let Writer { content, images, opacities } = writer;

    let mut next = 1..;
    let mut fresh = || Ref::new(next.next().unwrap_or(i32::MAX));
    let (catalog, pages, page, stream, info) = (fresh(), fresh(), fresh(), fresh(), fresh());
    let image_refs: Vec<Ref> = images.iter().map(|_| fresh()).collect();
    let pattern_refs: Vec<Ref> = drawing.patterns.iter().map(|_| fresh()).collect();
    let opacity_refs: Vec<Ref> = opacities.iter().map(|_| fresh()).collect();
    let mut file = Pdf::new();
    file.catalog(catalog).pages(pages);
    file.pages(pages).kids([page]).count(1);
    file.document_info(info).title(TextStr(&drawing.title)).producer(TextStr("vibrochain"));
    let mut leaf = file.page(page);
    leaf.parent(pages).media_box(Rect::new(0.0, 0.0, width, height)).contents(stream);
    let mut resources = leaf.resources();
    named(resources.x_objects(), 'I', &image_refs);
    named(resources.patterns(), 'P', &pattern_refs);
    named(resources.ext_g_states(), 'G', &opacity_refs);
    resources.finish();
    leaf.finish();
    file.stream(stream, &packed(&content.finish())).filter(Filter::FlateDecode);
    for (id, image) in image_refs.iter().zip(images) {
        let bytes = packed(&image.rgb);
        let mut object = file.image_xobject(*id, &bytes);
        object.filter(Filter::FlateDecode);
        object.width(image.pixels[0] as i32).height(image.pixels[1] as i32);
        object.color_space().device_rgb();
        object.bits_per_component(8).interpolate(false);
    }
    for (id, pattern) in pattern_refs.iter().zip(&drawing.patterns) {
        texture(&mut file, *id, pattern, [unit, height]);
    }
    for (id, opacity) in opacity_refs.iter().zip(opacities) {
        file.ext_graphics(*id).stroking_alpha(opacity as f32);
    }
    file.finish()
}

/// Names objects by a letter and their number.
fn named(mut names: Dict<'_>, letter: char, objects: &[Ref]) {
    for (i, id) in objects.iter().enumerate() {
        names.pair(Name(format!("{letter}{i}").as_bytes()), *id);
    }
}

fn packed(bytes: &[u8]) -> Vec<u8> {
    let mut encoder = ZlibEncoder::new(Vec::new(), Compression::default());
    // A vector takes all bytes.
    let _ = encoder.write_all(bytes);
    encoder.finish().unwrap_or_default()
}

fn parts(rgb: Rgb) -> [f32; 3] {
    rgb.map(|part| f32::from(part) / 255.0)
}

fn texture(file: &mut Pdf, id: Ref, pattern: &Pattern, [unit, height]: [f32; 2]) {
    let period = pattern.period as f32;
    let mut content = Content::new();
    let [r, g, b] = parts(pattern.ground);
    content.set_fill_rgb(r, g, b).rect(0.0, 0.0, period, period).fill_nonzero();
    let [r, g, b] = parts(pattern.marks);
    content.set_fill_rgb(r, g, b);
    for [x, y] in &pattern.squares {
        content.rect(*x as f32, *y as f32, 1.0, 1.0);
    }
    content.fill_nonzero();
    let bytes = content.finish();
    let mut object = file.tiling_pattern(id, &bytes);
    object
        .paint_type(PaintType::Colored)
        .tiling_type(TilingType::ConstantSpacing)
        .bbox(Rect::new(0.0, 0.0, period, period))
        .x_step(period)
        .y_step(period)
        .matrix([unit, 0.0, 0.0, -unit, 0.0, height]);
    object.resources();
}

struct Writer<'a> {
    content: Content,
    images: Vec<&'a Image>,
    opacities: Vec<f64>,
}

impl<'a> Writer<'a> {
    fn elements(&mut self, elements: &'a [Element]) {
        for element in elements {
            match element {
                Element::Shape(shape) => self.shape(shape),
                Element::Circle(circle) => {
                    let fill = circle.fill.map(Fill::Colour);
                    self.style(fill, circle.line);
                    self.round(circle.centre, circle.radius);
                    self.paint(fill, circle.line);
                }
                Element::Words(words) => self.words(words),
                Element::Image(image) => {
                    let ([x, y], [w, h]) = (image.at.map(|v| v as f32), image.size.map(|v| v as f32));
                    let name = format!("I{}", self.images.len());
                    self.images.push(image);
                    self.content.save_state().transform([w, 0.0, 0.0, -h, x, y + h]);
                    self.content.x_object(Name(name.as_bytes())).restore_state();
                }
                Element::Clipped([[left, top], [right, bottom]], inside) => {
                    let [x, y, w, h] = [*left, *top, right - left, bottom - top].map(|v| v as f32);
                    self.content.save_state().rect(x, y, w, h).clip_nonzero().end_path();
                    self.elements(inside);
                    self.content.restore_state();
                }
            }
        }
    }

    fn shape(&mut self, shape: &Shape) {
        self.style(shape.fill, shape.line);
        for outline in &shape.outlines {
            for (i, [x, y]) in outline.iter().map(|place| place.map(|v| v as f32)).enumerate() {
                if i == 0 {
                    self.content.move_to(x, y);
                } else {
                    self.content.line_to(x, y);
                }
            }
            if shape.closed {
                self.content.close_path();
            }
        }
        self.paint(shape.fill, shape.line);
    }

    /// A circle by four curves.
    fn round(&mut self, [x, y]: Place, radius: f64) {
        let k = ROUND;
        let at = |dx: f64, dy: f64| [(x + radius * dx) as f32, (y + radius * dy) as f32];
        let [fx, fy] = at(1.0, 0.0);
        self.content.move_to(fx, fy);
        let quarters = [
            [at(1.0, k), at(k, 1.0), at(0.0, 1.0)],
            [at(-k, 1.0), at(-1.0, k), at(-1.0, 0.0)],
            [at(-1.0, -k), at(-k, -1.0), at(0.0, -1.0)],
            [at(k, -1.0), at(1.0, -k), at(1.0, 0.0)],
        ];
        for [[a, b], [c, d], [e, f]] in quarters {
            self.content.cubic_to(a, b, c, d, e, f);
        }
        self.content.close_path();
    }

    fn style(&mut self, fill: Option<Fill>, line: Option<Line>) {
        self.content.save_state();
        match fill {
            Some(Fill::Colour(colour)) => {
                let [r, g, b] = parts(colour);
                self.content.set_fill_rgb(r, g, b);
            }
            Some(Fill::Pattern(number)) => {
                self.content.set_fill_color_space(pdf_writer::types::ColorSpaceOperand::Pattern);
                self.content.set_fill_pattern(None, Name(format!("P{number}").as_bytes()));
            }
            None => {}
        }
        if let Some(line) = line {
            let [r, g, b] = parts(line.colour);
            self.content
                .set_stroke_rgb(r, g, b)
                .set_line_width(line.width as f32)
                .set_line_join(LineJoinStyle::RoundJoin);
            if let Some(dash) = line.dash {
                self.content.set_dash_pattern(dash.map(|part| part as f32), 0.0);
            }
            if line.opacity < 1.0 {
                let known = self.opacities.iter().position(|opacity| *opacity == line.opacity);
                let number = known.unwrap_or_else(|| {
                    self.opacities.push(line.opacity);
                    self.opacities.len() - 1
                });
                self.content.set_parameters(Name(format!("G{number}").as_bytes()));
            }
        }
    }

    fn paint(&mut self, fill: Option<Fill>, line: Option<Line>) {
        match (fill, line) {
            (Some(_), Some(_)) => self.content.fill_nonzero_and_stroke(),
            (Some(_), None) => self.content.fill_nonzero(),
            (None, Some(_)) => self.content.stroke(),
            (None, None) => self.content.end_path(),
        };
        self.content.restore_state();
    }

    fn words(&mut self, words: &Words) {
        let setting = set(&words.text);
        let [x, y] = corner(words, setting.width).map(|v| v as f32);
        let [r, g, b] = parts(words.colour);
        let size = words.size as f32;
        let turned = if words.upwards { [0.0, -size, -size, 0.0, x, y] } else { [size, 0.0, 0.0, -size, x, y] };
        self.content.save_state().set_fill_rgb(r, g, b).transform(turned);
        for letter in setting.letters {
            let at = |to: [f64; 2]| [0, 1].map(|i| (letter.at[i] + to[i]) as f32);
            for step in outline(letter.glyph) {
                match step {
                    Step::Start(to) => self.content.move_to(at(to)[0], at(to)[1]),
                    Step::Line(to) => self.content.line_to(at(to)[0], at(to)[1]),
                    Step::Curve(places) => {
                        let [[a, b], [c, d], [x, y]] = places.map(at);
                        self.content.cubic_to(a, b, c, d, x, y)
                    }
                    Step::Close => self.content.close_path(),
                };
            }
        }
        self.content.fill_nonzero().restore_state();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::backend::drawing::BLACK;

    #[test]
    fn a_pdf_has_its_size_in_points_and_its_title() {
        let mut drawing = Drawing::new([96.0, 192.0], "γ₂ (a)");
        drawing.words("γ₂", [10.0, 20.0], 15.0, BLACK);
        drawing.circle([50.0, 50.0], 10.0, Some(BLACK), Some(Line { opacity: 0.5, ..Line::new(BLACK, 1.0) }));
        drawing.image([[1.0, 2.0], [11.0, 12.0]], [1, 1], vec![1, 2, 3]);
        let file = pdf(&drawing);
        let text = String::from_utf8_lossy(&file);
        assert!(text.starts_with("%PDF-") && text.trim_end().ends_with("%%EOF"));
        assert!(text.contains("/MediaBox [0 0 72 144]"), "{text}");
        assert!(text.contains("/Interpolate false") && text.contains("/CA 0.5"));
    }
}
