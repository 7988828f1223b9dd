//! A drawing as pixels: shapes and letters anti-aliased, lines along the axes and rasters on whole pixels.

use tiny_skia::{
    FillRule, FilterQuality, LineCap, LineJoin, Mask, Paint, Path, PathBuilder, Pixmap, PixmapPaint, Rect, Stroke,
    StrokeDash, Transform,
};

use crate::backend::coverage::parts;
use crate::backend::drawing::{Drawing, Element, Fill, Image, Line, Pattern, Place, Rgb, Shape, Words};
use crate::backend::format::PlotError;
use crate::backend::png::png;
use crate::text::font::{Step, outline, set};
use crate::text::typeset::corner;

/// The bytes of a PNG with so many pixels for each unit.
///
/// # Errors
/// [`PlotError`] of a picture without a size.
pub(crate) fn png_of(drawing: &Drawing, scale: f64) -> Result<Vec<u8>, PlotError> {
    let pixmap = raster(drawing, scale)?;
    let rgb: Vec<u8> = pixmap.data().chunks_exact(4).flat_map(|pixel| [pixel[0], pixel[1], pixel[2]]).collect();
    png([pixmap.width(), pixmap.height()], &rgb, Some(96.0 * scale))
        .ok_or_else(|| PlotError("no PNG came out".to_owned()))
}

/// The pixels of a drawing, on white.
pub(crate) fn raster(drawing: &Drawing, scale: f64) -> Result<Pixmap, PlotError> {
    let [width, height] = drawing.size.map(|side| (side * scale).round().max(1.0) as u32);
    let pixmap =
        Pixmap::new(width, height).ok_or_else(|| PlotError(format!("{width} x {height} pixels are too many")))?;
    let mut painter = Painter { pixmap, scale, mask: None, patterns: &drawing.patterns };
    painter.pixmap.fill(tiny_skia::Color::WHITE);
    painter.elements(&drawing.elements);
    Ok(painter.pixmap)
}

/// A drawing over pixels.
pub(crate) fn over(ground: &Pixmap, drawing: &Drawing, scale: f64) -> Pixmap {
    let mut painter = Painter { pixmap: ground.clone(), scale, mask: None, patterns: &drawing.patterns };
    painter.elements(&drawing.elements);
    painter.pixmap
}

struct Painter<'a> {
    pixmap: Pixmap,
    scale: f64,
    mask: Option<Mask>,
    patterns: &'a [Pattern],
}

fn paint([r, g, b]: Rgb, opacity: f64) -> Paint<'static> {
    let mut paint = Paint::default();
    paint.set_color_rgba8(r, g, b, (255.0 * opacity).round() as u8);
    paint.anti_alias = true;
    paint
}

impl Painter<'_> {
    fn elements(&mut self, elements: &[Element]) {
        for element in elements {
            match element {
                Element::Shape(shape) => self.shape(shape),
                Element::Circle(circle) => {
                    let [x, y, radius] =
                        [circle.centre[0], circle.centre[1], circle.radius].map(|place| (place * self.scale) as f32);
                    let Some(path) = PathBuilder::from_circle(x, y, radius) else { continue };
                    if let Some(colour) = circle.fill {
                        self.fill(&path, colour, Transform::identity());
                    }
                    if let Some(line) = circle.line {
                        self.stroke(&path, line);
                    }
                }
                Element::Words(words) => self.words(words),
                Element::Image(image) => self.image(image),
                Element::Clipped(corners, inside) => self.clipped(*corners, inside),
            }
        }
    }

    fn clipped(&mut self, corners: [Place; 2], inside: &[Element]) {
        let before = self.mask.take();
        let [[left, top], [right, bottom]] = corners.map(|corner| corner.map(|place| (place * self.scale) as f32));
        if let (Some(mut mask), Some(rect)) =
            (Mask::new(self.pixmap.width(), self.pixmap.height()), Rect::from_ltrb(left, top, right, bottom))
        {
            mask.fill_path(&PathBuilder::from_rect(rect), FillRule::Winding, true, Transform::identity());
            self.mask = Some(mask);
            self.elements(inside);
        }
        self.mask = before;
    }

    fn fill(&mut self, path: &Path, colour: Rgb, transform: Transform) {
        self.pixmap.fill_path(path, &paint(colour, 1.0), FillRule::Winding, transform, self.mask.as_ref());
    }

    fn stroke(&mut self, path: &Path, line: Line) {
        let dash =
            line.dash.and_then(|dash| StrokeDash::new(dash.map(|part| (part * self.scale) as f32).to_vec(), 0.0));
        let width = self.line_width(line) as f32;
        // On whole pixels a line ends with the last of them.
        let line_cap = if line.crisp && dash.is_none() { LineCap::Square } else { LineCap::Butt };
        let line_join = if line.crisp { LineJoin::Miter } else { LineJoin::Round };
        let stroke = Stroke { width, dash, line_join, line_cap, ..Stroke::default() };
        let mut paint = paint(line.colour, line.opacity);
        // Its edges lie between pixels.
        paint.anti_alias = !line.crisp;
        self.pixmap.stroke_path(path, &paint, &stroke, Transform::identity(), self.mask.as_ref());
    }

    /// In pixels: whole ones for lines along the axes.
    fn line_width(&self, line: Line) -> f64 {
        let width = line.width * self.scale;
        if line.crisp { width.round().max(1.0) } else { width }
    }

    fn shape(&mut self, shape: &Shape) {
        // The edges of a line along an axis lie between pixels.
        let shift = shape.line.filter(|line| line.crisp).map(|line| 0.5 * (self.line_width(line) % 2.0));
        let place = |at: f64| match shift {
            Some(shift) => ((at * self.scale - shift).round() + shift) as f32,
            None => (at * self.scale) as f32,
        };
        let mut builder = PathBuilder::new();
        for outline in &shape.outlines {
            for (i, [x, y]) in outline.iter().enumerate() {
                if i == 0 {
                    builder.move_to(place(*x), place(*y));
                } else {
                    builder.line_to(place(*x), place(*y));
                }
            }
            if shape.closed {
                builder.close();
            }
        }
        let Some(path) = builder.finish() else { return };
        match shape.fill {
            Some(Fill::Colour(colour)) => self.fill(&path, colour, Transform::identity()),
            Some(Fill::Pattern(number)) => self.texture(&path, number),
            None => {}
        }
        if let Some(line) = shape.line {
            self.stroke(&path, line);
        }
    }

    /// Fills with a pattern that keeps to whole pixels.
    fn texture(&mut self, path: &Path, number: usize) {
        let Some(pattern) = self.patterns.get(number) else { return };
        let unit = self.scale.round().max(1.0) as u32;
        let period = pattern.period as u32 * unit;
        let Some(mut tile) = Pixmap::new(period, period) else { return };
        let [r, g, b] = pattern.ground;
        tile.fill(tiny_skia::Color::from_rgba8(r, g, b, 255));
        for [x, y] in &pattern.squares {
            let side = unit as f32;
            let Some(square) = Rect::from_xywh(*x as f32 * side, *y as f32 * side, side, side) else { continue };
            tile.fill_rect(square, &paint(pattern.marks, 1.0), Transform::identity(), None);
        }
        let shader = tiny_skia::Pattern::new(
            tile.as_ref(),
            tiny_skia::SpreadMode::Repeat,
            FilterQuality::Nearest,
            1.0,
            Transform::identity(),
        );
        let paint = Paint { shader, anti_alias: true, ..Paint::default() };
        self.pixmap.fill_path(path, &paint, FillRule::Winding, Transform::identity(), self.mask.as_ref());
    }

    fn words(&mut self, words: &Words) {
        let setting = set(&words.text);
        let [x, y] = corner(words, setting.width).map(|place| (place * self.scale) as f32);
        let (mut path, size) = (PathBuilder::new(), words.size * self.scale);
        for letter in setting.letters {
            let at = |[x, y]: Place| [((letter.at[0] + x) * size) as f32, (-(letter.at[1] + y) * size) as f32];
            for step in outline(letter.glyph) {
                match step {
                    Step::Start(to) => path.move_to(at(to)[0], at(to)[1]),
                    Step::Line(to) => path.line_to(at(to)[0], at(to)[1]),
                    Step::Curve(places) => {
                        let [[a, b], [c, d], [x, y]] = places.map(at);
                        path.cubic_to(a, b, c, d, x, y);
                    }
                    Step::Close => path.close(),
                }
            }
        }
        let Some(path) = path.finish() else { return };
        let turn = if words.upwards {
            Transform::from_row(0.0, -1.0, 1.0, 0.0, x, y)
        } else {
            Transform::from_translate(x, y)
        };
        self.fill(&path, words.colour, turn);
    }

    fn image(&mut self, image: &Image) {
        let wanted = image.size.map(|side| (side * self.scale).round().max(1.0) as u32);
        let (pixels, rgb) = (image.pixels, &image.rgb);
        let fitted;
        let rgb = if wanted == pixels {
            rgb
        } else {
            fitted = fitted_to(pixels, rgb, wanted);
            &fitted
        };
        let Some(mut patch) = Pixmap::new(wanted[0], wanted[1]) else { return };
        for (to, from) in patch.data_mut().chunks_exact_mut(4).zip(rgb.chunks_exact(3)) {
            to[..3].copy_from_slice(from);
            to[3] = 255;
        }
        let [x, y] = image.at.map(|place| (place * self.scale).round() as i32);
        let plain = PixmapPaint::default();
        self.pixmap.draw_pixmap(x, y, patch.as_ref(), &plain, Transform::identity(), self.mask.as_ref());
    }
}

/// A raster in other numbers of pixels: each the mean of what lies in it.
fn fitted_to([columns, rows]: [u32; 2], rgb: &[u8], [width, height]: [u32; 2]) -> Vec<u8> {
    let (across, down) = (parts(columns, width), parts(rows, height));
    let mut wide = vec![[0.0_f32; 3]; (width * rows) as usize];
    for row in 0..rows as usize {
        for (x, parts) in across.iter().enumerate() {
            for &(column, share) in parts {
                let from = 3 * (row * columns as usize + column);
                for (sum, part) in wide[row * width as usize + x].iter_mut().zip(&rgb[from..from + 3]) {
                    *sum += share * f32::from(*part);
                }
            }
        }
    }
    let mut all = Vec::with_capacity(3 * (width * height) as usize);
    for parts in &down {
        for x in 0..width as usize {
            let mut sum = [0.0_f32; 3];
            for &(row, share) in parts {
                for (sum, part) in sum.iter_mut().zip(wide[row * width as usize + x]) {
                    *sum += share * part;
                }
            }
            all.extend(sum.map(|part| part.round() as u8));
        }
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::backend::drawing::BLACK;

    /// How dark a picture is, in pixels.
    fn ink(pixmap: &Pixmap) -> f64 {
        pixmap.data().chunks_exact(4).map(|pixel| 1.0 - f64::from(pixel[0]) / 255.0).sum()
    }

    #[test]
    fn a_circle_covers_its_area_at_any_size() {
        for scale in [1.0, 2.5, 10.0] {
            let mut drawing = Drawing::new([40.0, 40.0], "");
            drawing.circle([20.3, 19.6], 12.0, Some(BLACK), None);
            let area = std::f64::consts::PI * 144.0 * scale * scale;
            let found = ink(&raster(&drawing, scale).unwrap()) / area;
            // Sixteen steps of grey on its edge.
            assert!((found - 1.0).abs() < 0.03 / scale, "{scale} {found}");
        }
    }

    #[test]
    fn a_slanted_line_is_as_wide_as_a_level_one() {
        for angle in [0.0_f64, 7.0, 30.0, 45.0, 80.0] {
            let (sin, cos) = angle.to_radians().sin_cos();
            let mut drawing = Drawing::new([200.0, 200.0], "");
            drawing.line(vec![[30.0, 20.0], [30.0 + 120.0 * cos, 20.0 + 120.0 * sin]], Line::new(BLACK, 1.5));
            let found = ink(&raster(&drawing, 2.0).unwrap()) / (4.0 * 120.0 * 1.5);
            assert!((found - 1.0).abs() < 0.02, "{angle} {found}");
        }
    }

    #[test]
    fn lines_along_axes_and_rasters_lie_on_whole_pixels() {
        let mut drawing = Drawing::new([20.0, 20.0], "");
        drawing.line(vec![[2.0, 7.3], [18.0, 7.3]], Line::new(BLACK, 1.0).crisp());
        let pixmap = raster(&drawing, 1.0).unwrap();
        assert!(pixmap.data().chunks_exact(4).all(|pixel| pixel[0] == 0 || pixel[0] == 255));
        assert!(ink(&pixmap) >= 15.0);
        let mut drawing = Drawing::new([4.0, 4.0], "");
        let rgb: Vec<u8> = (0..12).map(|i| i * 20).collect();
        drawing.image([[1.2, 0.8], [3.2, 2.8]], [2, 2], rgb.clone());
        let pixmap = raster(&drawing, 1.0).unwrap();
        let pixel = |x: u32, y: u32| pixmap.data()[(4 * (y * 4 + x)) as usize..][..3].to_vec();
        assert_eq!([pixel(1, 1), pixel(2, 1), pixel(1, 2), pixel(2, 2)].concat(), rgb);
        // Smaller, it is the mean; larger, the same again.
        assert_eq!(fitted_to([2, 2], &rgb, [1, 1]), [90, 110, 130]);
        let large = fitted_to([2, 2], &rgb, [6, 4]);
        assert_eq!((large.len(), &large[6..9], &large[9..12]), (72, &rgb[..3], &rgb[3..6]));
    }

    #[test]
    fn words_are_dark_where_they_stand_and_nowhere_else() {
        let mut drawing = Drawing::new([200.0, 40.0], "");
        drawing.words("γ₂ = 0.1", [50.0, 20.0], 20.0, BLACK);
        let pixmap = raster(&drawing, 1.0).unwrap();
        let columns: Vec<usize> =
            pixmap.pixels().iter().enumerate().filter(|(_, p)| p.red() < 128).map(|(i, _)| i % 200).collect();
        let end = 50.0 + 20.0 * crate::text::font::width("γ₂ = 0.1");
        assert!(columns.iter().min().is_some_and(|x| (50..55).contains(x)));
        assert!(columns.iter().max().is_some_and(|x| (*x as f64) < end && *x as f64 > end - 5.0));
    }

    #[test]
    fn what_is_clipped_does_not_leave_its_box() {
        let mut drawing = Drawing::new([50.0, 50.0], "");
        drawing.clipped([[10.0, 10.0], [20.0, 30.0]], |inside| {
            inside.line(vec![[0.0, 20.0], [50.0, 20.0]], Line::new(BLACK, 4.0));
        });
        assert!((ink(&raster(&drawing, 1.0).unwrap()) - 40.0).abs() < 0.5);
        let png = png_of(&drawing, 2.0).unwrap();
        assert!(png.starts_with(b"\x89PNG") && png.windows(4).any(|name| name == b"pHYs"));
    }
}
