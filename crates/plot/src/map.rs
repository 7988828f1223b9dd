//! The picture of a map: classes as colours, mechanisms as textures, or a number as a scale of colours; every cell the same whole
//! number of pixels.

use plotters::coord::Shift;
use plotters::element::{BitMapElement, PathElement, Rectangle, Text};
use plotters::prelude::{BLACK, ChartBuilder, Color, DrawingArea, DrawingBackend, IntoFont, RGBColor, WHITE};
use plotters::style::text_anchor::{HPos, Pos, VPos};
use std::fmt::Write;
use std::ops::Range;
use vibrochain_floquet::Mechanism;

use crate::canvas::{Drawing, Format, PlotError, render};
use crate::coverage::Place;
pub use crate::lines::MapLine;
use crate::lines::{Frame, draw_key, draw_lines};
use crate::palette::{BORDERS, Palette, Tile, sample};
use crate::quantity::{Bar, Quantity, Shade};
use crate::strokes::{Stroke, hex, path, shares};
use crate::words::Heading;
use vibrochain_maps::cell::Class;
use vibrochain_maps::point::Parameter;
use vibrochain_maps::scene::{Axis, Scene, Values};

/// About this many pixels wide and high the map itself becomes.
pub(crate) const TARGET: usize = 900;

/// A map wider or higher than this in cells shows every second (third …) one only.
const MOST: usize = 6000;

/// Height that all classes and mechanisms take in the legend.
const MOST_LEGEND: u32 = 400;

const LEFT: u32 = 90;
/// Air between the edge of the picture and the name of the y axis.
const EDGE: u32 = 12;
const RIGHT: u32 = 300;
/// Air above the headings, and between them and the map.
const TOP: (u32, u32) = (10, 12);
/// Sizes of the two headings.
const HEADINGS: [u32; 2] = [22, 16];
const BOTTOM: u32 = 74;

/// What is drawn.
#[derive(Debug)]
pub struct MapPicture<'a> {
    /// The scene.
    pub scene: &'a Scene,
    /// The cells that are [shown](is_shown), by rows, the first row at the bottom.
    pub cells: Cells<'a>,
    /// The colours.
    pub palette: Palette,
    /// Borders over the cells.
    pub borders: &'a [MapBorder],
}

/// What the cells of a map show.
#[derive(Debug, Clone, Copy)]
pub enum Cells<'a> {
    /// Their classes.
    Classes(&'a [Tile]),
    /// A number.
    Numbers(Quantity, &'a [Shade]),
}

/// A border over a map.
#[derive(Debug, Clone, PartialEq)]
pub struct MapBorder {
    /// What happens on it; borders of one kind have one colour and one entry in the legend.
    pub kind: String,
    /// What an SVG says of it when one hovers over it.
    pub title: String,
    /// Its points, in units of the axes.
    pub points: Vec<[f64; 2]>,
}

/// Whether the picture of a sweep over one or two axes shows cell number `cell`: all do, unless there are thousands along an axis.
pub fn is_shown(scene: &Scene, cell: u64) -> bool {
    let among = |number: u64, axis: &Axis| number.is_multiple_of(stride(axis.points()) as u64);
    match scene.axes.as_slice() {
        [x] => among(cell, x),
        [x, y] => {
            let columns = x.points() as u64;
            among(cell % columns, x) && among(cell / columns, y)
        }
        _ => false,
    }
}

fn stride(points: usize) -> usize {
    points.div_ceil(MOST).max(1)
}

/// The bytes of a map's picture.
///
/// # Errors
/// [`PlotError`].
pub fn map_picture(picture: &MapPicture<'_>, format: Format) -> Result<Vec<u8>, PlotError> {
    map_with_lines(picture, &[], format)
}

/// The same with lines over the cells.
///
/// # Errors
/// [`PlotError`].
pub fn map_with_lines(picture: &MapPicture<'_>, lines: &[MapLine], format: Format) -> Result<Vec<u8>, PlotError> {
    let Some([x, y]) = picture.scene.plane() else {
        return Err(PlotError("a map has two axes".to_owned()));
    };
    let grids = [Grid::new(x.points()), Grid::new(y.points())];
    // A cell covers half a step on either side of its value.
    let span = |axis: &Axis, grid: Grid| {
        let (from, step) = places(axis);
        from - 0.5 * step..from - 0.5 * step + step * (grid.shown * grid.stride) as f64
    };
    let spans = [span(x, grids[0]), span(y, grids[1])];
    let size = grids.map(|grid| grid.pixels());
    let palette = picture.palette;
    let (mut tiles, mut bar): (Vec<Tile>, _) = (Vec::new(), None);
    let mut pixels = match picture.cells {
        Cells::Classes(cells) => {
            for tile in cells {
                if !tiles.contains(tile) {
                    tiles.push(*tile);
                }
            }
            let unknown = Tile { class: None, mechanism: None };
            let tile = |cell: usize| cells.get(cell).copied().unwrap_or(unknown);
            raster(grids, |cell, x, y| palette.pixel(tile(cell), x, y))
        }
        Cells::Numbers(quantity, cells) => {
            let Bar { colours, .. } = *bar.insert(Bar::of(quantity, cells));
            let shade = |cell: usize| cells.get(cell).copied().unwrap_or(Shade::Unknown);
            raster(grids, |cell, x, y| colours.pixel(palette, shade(cell), x, y))
        }
    };
    let strokes = strokes(picture.borders, &spans, size);
    let mut overlay = String::new();
    match format {
        Format::Png => strokes.iter().for_each(|stroke| paint(&mut pixels, stroke, size)),
        Format::Svg => overlay = paths(picture.borders, &strokes),
    }
    let key: Vec<(&str, [u8; 3])> = strokes.iter().map(|stroke| (stroke.kind, stroke.colour)).collect();
    let ground = Ground::Raster(pixels);
    let (scene, axes, key) = (picture.scene, [x, y], key.as_slice());
    Sheet { scene, palette, axes, tiles, bar, lines, key, spans, size, ground, overlay }.bytes(format)
}

/// The pixels of a map's cells, of each by its number and the place of the pixel.
fn raster([columns, rows]: [Grid; 2], colour: impl Fn(usize, u32, u32) -> [u8; 3]) -> Vec<u8> {
    let (width, height) = (columns.pixels(), rows.pixels());
    let mut pixels = Vec::with_capacity(3 * (width * height) as usize);
    for py in 0..height {
        let row = (rows.shown as u32 - 1 - py / rows.cell) as usize;
        for px in 0..width {
            let column = (px / columns.cell) as usize;
            pixels.extend(colour(row * columns.shown + column, px, py));
        }
    }
    pixels
}

/// Width of a border, and of the light line under it that sets it off from dark cells, in pixels; and how much of that is seen.
const BORDER: f64 = 0.9;
const HALO: f64 = 2.2;
const FAINT: f64 = 0.5;

/// The borders of each kind, in pixels.
fn strokes<'a>(borders: &'a [MapBorder], [x, y]: &[Range<f64>; 2], size: [u32; 2]) -> Vec<Stroke<'a>> {
    let part = |value: f64, span: &Range<f64>| (value - span.start) / (span.end - span.start);
    let pixel = |point: &[f64; 2]| -> Place {
        [part(point[0], x) * f64::from(size[0]), (1.0 - part(point[1], y)) * f64::from(size[1])]
    };
    let mut strokes: Vec<Stroke<'a>> = Vec::new();
    for border in borders {
        let line: Vec<Place> = border.points.iter().map(pixel).collect();
        match strokes.iter_mut().find(|stroke| stroke.kind == border.kind) {
            Some(stroke) => stroke.lines.push(line),
            None => {
                let colour = BORDERS[strokes.len() % BORDERS.len()];
                strokes.push(Stroke { kind: &border.kind, colour, lines: vec![line] });
            }
        }
    }
    strokes
}

/// Draws borders into pixels.
fn paint(pixels: &mut [u8], stroke: &Stroke<'_>, size: [u32; 2]) {
    for (width, colour, seen) in [(HALO, [255; 3], FAINT), (BORDER, stroke.colour, 1.0)] {
        for (share, pixel) in shares(&stroke.lines, width, size).zip(pixels.chunks_exact_mut(3)) {
            for (part, colour) in pixel.iter_mut().zip(colour) {
                let mixed = f64::from(*part) + seen * share * (f64::from(colour) - f64::from(*part));
                *part = mixed.round() as u8;
            }
        }
    }
}

/// The same as elements of an SVG, from the upper left corner of the map.
fn paths(borders: &[MapBorder], strokes: &[Stroke<'_>]) -> String {
    let mut text = String::new();
    for stroke in strokes {
        let lines = || stroke.lines.iter().map(|line| path(line.iter().copied(), false));
        let style = "fill=\"none\" stroke-linejoin=\"round\"";
        let (under, colour) = (lines().collect::<String>(), hex(stroke.colour));
        let _ = writeln!(
            text,
            "<path {style} stroke=\"#ffffff\" stroke-opacity=\"{FAINT}\" stroke-width=\"{HALO}\" d=\"{under}\"/>"
        );
        let of_kind = borders.iter().filter(|border| border.kind == stroke.kind);
        for (border, d) in of_kind.zip(lines()).filter(|(_, d)| !d.is_empty()) {
            let title = escaped(&border.title);
            let _ = writeln!(
                text,
                "<path {style} stroke=\"{colour}\" stroke-width=\"{BORDER}\" d=\"{d}\"><title>{title}</title></path>"
            );
        }
    }
    text
}

/// A text within XML.
fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;")
}

/// Cells along one axis.
#[derive(Debug, Clone, Copy)]
struct Grid {
    shown: usize,
    stride: usize,
    cell: u32,
}

impl Grid {
    fn new(points: usize) -> Self {
        let stride = stride(points);
        let shown = points.div_ceil(stride);
        Self { shown, stride, cell: (TARGET / shown.max(1)).clamp(1, 60) as u32 }
    }

    fn pixels(&self) -> u32 {
        self.shown as u32 * self.cell
    }
}

/// What lies under lines and frame.
pub(crate) enum Ground {
    /// Pixels, three bytes each.
    Raster(Vec<u8>),
    /// Elements of an SVG, from the upper left corner of the map.
    Shapes(String),
}

/// A map with all that stands about it.
pub(crate) struct Sheet<'a> {
    pub(crate) scene: &'a Scene,
    pub(crate) axes: [&'a Axis; 2],
    pub(crate) palette: Palette,
    /// What occurs on it, and the scale of its numbers.
    pub(crate) tiles: Vec<Tile>,
    pub(crate) bar: Option<Bar>,
    pub(crate) lines: &'a [MapLine],
    /// Kinds of borders that are drawn, and their colours.
    pub(crate) key: &'a [(&'a str, [u8; 3])],
    /// What the map spans of each axis.
    pub(crate) spans: [Range<f64>; 2],
    /// Its pixels.
    pub(crate) size: [u32; 2],
    pub(crate) ground: Ground,
    /// Elements of an SVG over all that is drawn, from the upper left corner of the map.
    pub(crate) overlay: String,
}

pub(crate) fn label(axis: &Axis) -> String {
    format!("{} {}", axis.parameter.meaning(), axis.parameter.symbol())
}

/// "N = 20 (21 masses), γ₁ = 0.2, …": what is fixed.
pub(crate) fn fixed(scene: &Scene) -> String {
    let layout = scene.base.layout;
    let mut text = if layout.is_ring() { format!("N = {} ({layout})", layout.length - 1) } else { layout.to_string() };
    for &parameter in Parameter::of(scene.base.layout.layers) {
        let swept = scene.sweeps(parameter);
        let forced = matches!(parameter, Parameter::Amplitude | Parameter::Restitution);
        if let (Parameter::Amplitude, Some(force)) = (parameter, &scene.base.force) {
            text += &format!(", force {force}");
        } else if !(swept || forced && scene.is_conservative()) {
            text += &format!(", {} = {}", parameter.symbol(), scene.base.get(parameter));
        }
    }
    text
}

impl Sheet<'_> {
    pub(crate) fn bytes(self, format: Format) -> Result<Vec<u8>, PlotError> {
        let width = self.size[0] + LEFT + RIGHT;
        let headings = [(self.scene.heading(), HEADINGS[0]), (fixed(self.scene), HEADINGS[1])];
        let headings = headings.map(|(text, size)| Heading::new(&text, width - LEFT - EDGE, size));
        let top = TOP.0 + headings.iter().map(Heading::height).sum::<u32>() + TOP.1;
        let size = (width, self.size[1].max(MOST_LEGEND) + top + BOTTOM);
        render(&Headed { sheet: self, headings, top }, format, size)
    }

    /// Legend entries that occur on this map.
    fn legend(&self) -> Vec<(Tile, &'static str)> {
        let classes = Class::ALL.into_iter().map(Some).chain([None]);
        let occurs = |class: &Option<Class>| self.tiles.iter().any(|tile| tile.class == *class);
        classes.filter(occurs).map(|class| (Tile { class, mechanism: None }, self.words(class))).collect()
    }

    /// A class as a legend has it.
    pub(crate) fn words(&self, class: Option<Class>) -> &'static str {
        class_words(class, || self.tiles.iter().filter_map(|tile| tile.class))
    }

    /// Textures that occur.
    fn textures(&self) -> Vec<(Mechanism, &'static str)> {
        let all = [Mechanism::NeimarkSacker, Mechanism::PeriodDoubling, Mechanism::PlusOne, Mechanism::Pitchfork];
        let occurs = |mechanism: &Mechanism| self.tiles.iter().any(|tile| tile.mechanism == Some(*mechanism));
        all.into_iter().filter(occurs).map(|mechanism| (mechanism, loss(mechanism))).collect()
    }
}

const NOTHING: &str = "no physical breather";
pub(crate) const UNKNOWN: &str = "not computed (see status)";

/// A class as the legend of a picture with these classes has it.
pub(crate) fn class_words<I: Iterator<Item = Class>>(class: Option<Class>, all: impl Fn() -> I) -> &'static str {
    let words = [Class::StableWord, Class::UnstableWord, Class::Word];
    let only_words = || all().all(|class| class == Class::None || words.contains(&class));
    let Some(class) = class else { return UNKNOWN };
    match class {
        Class::None => NOTHING,
        Class::StableDouble => "stable double-sided",
        Class::StableSingle => "stable single-sided",
        Class::UnstableDouble => "unstable double-sided",
        Class::UnstableSingle => "unstable single-sided",
        Class::Double => "double-sided",
        Class::Single => "single-sided",
        // The title names the words.
        Class::StableWord if only_words() => "stable breather",
        Class::UnstableWord if only_words() => "unstable breather",
        Class::Word if only_words() => "breather",
        Class::StableWord => "stable, other words",
        Class::UnstableWord => "unstable, other words",
        Class::Word => "other words",
    }
}

/// A mechanism as a legend has it.
pub(crate) fn loss(mechanism: Mechanism) -> &'static str {
    match mechanism {
        Mechanism::NeimarkSacker => "Neimark–Sacker",
        Mechanism::PeriodDoubling => "period doubling",
        Mechanism::PlusOne => "through +1",
        Mechanism::Pitchfork => "pitchfork",
    }
}

/// A sheet and its headings in lines.
struct Headed<'a> {
    sheet: Sheet<'a>,
    headings: [Heading; 2],
    /// Where the map begins.
    top: u32,
}

impl Headed<'_> {
    /// Elements of an SVG, moved to the upper left corner of the map.
    fn from_the_corner(&self, elements: &str) -> String {
        format!("<g transform=\"translate({LEFT} {})\">\n{elements}</g>\n", self.top)
    }
}

impl Drawing for Headed<'_> {
    fn shapes(&self) -> Option<String> {
        let Ground::Shapes(shapes) = &self.sheet.ground else { return None };
        Some(self.from_the_corner(shapes))
    }

    fn overlay(&self) -> Option<String> {
        let overlay = &self.sheet.overlay;
        (!overlay.is_empty()).then(|| self.from_the_corner(overlay))
    }

    fn draw<B: DrawingBackend>(&self, area: &DrawingArea<B, Shift>) -> Result<(), PlotError> {
        area.fill(&WHITE).map_err(PlotError::from)?;
        let Sheet { palette, lines, axes: [x_axis, y_axis], spans, size: [width, height], .. } = &self.sheet;
        let (width, height) = (*width, *height);
        let (left, top) = (LEFT as i32, self.top as i32);
        let grey = RGBColor(60, 60, 60);
        let [title, parameters] = &self.headings;
        title.draw(area, (left, TOP.0 as i32), BLACK)?;
        parameters.draw(area, (left, (TOP.0 + title.height()) as i32), grey)?;

        let (total_width, total_height) = area.dim_in_pixel();
        let mut chart = ChartBuilder::on(area)
            .margin_top(self.top)
            .margin_right(total_width - LEFT - width)
            .margin_bottom(total_height - self.top - BOTTOM - height)
            .x_label_area_size(BOTTOM)
            .margin_left(EDGE)
            .y_label_area_size(LEFT - EDGE)
            .build_cartesian_2d(spans[0].clone(), spans[1].clone())
            .map_err(PlotError::from)?;
        chart
            .configure_mesh()
            .disable_mesh()
            .x_desc(label(x_axis))
            .y_desc(label(y_axis))
            .axis_desc_style(("sans-serif", 20))
            .label_style(("sans-serif", 16))
            .x_labels(8)
            .y_labels(8)
            .x_label_formatter(&|place| tick_at(x_axis, *place))
            .y_label_formatter(&|place| tick_at(y_axis, *place))
            .draw()
            .map_err(PlotError::from)?;
        if let Ground::Raster(pixels) = &self.sheet.ground {
            let raster = BitMapElement::with_ref((left, top), (width, height), pixels.as_slice())
                .ok_or_else(|| PlotError("the raster does not fit its frame".to_owned()))?;
            area.draw(&raster).map_err(PlotError::from)?;
        }
        let frame = [(left - 1, top - 1), (left + width as i32, top + height as i32)];
        area.draw(&Rectangle::new(frame, BLACK)).map_err(PlotError::from)?;

        let x = left + width as i32 + 24;
        let mut y = top;
        let text = ("sans-serif", 17).into_font().color(&BLACK).pos(Pos::new(HPos::Left, VPos::Center));
        if let Some(bar) = &self.sheet.bar {
            y = draw_bar(area, bar, *palette, (x, y))?;
        }
        for (tile, entry) in self.sheet.legend() {
            swatch(area, |px, py| palette.pixel(tile, px, py), (x, y))?;
            area.draw(&Text::new(entry, (x + 44, y + 12), text.clone())).map_err(PlotError::from)?;
            y += 34;
        }
        let textures = self.sheet.textures();
        if !textures.is_empty() {
            y += 16;
            let small = ("sans-serif", 16).into_font().color(&grey);
            area.draw(&Text::new("stability is lost by", (x, y), small)).map_err(PlotError::from)?;
            y += 28;
        }
        for (mechanism, entry) in textures {
            swatch(area, |px, py| sample(mechanism, px, py), (x, y))?;
            area.draw(&Text::new(entry, (x + 44, y + 12), text.clone())).map_err(PlotError::from)?;
            y += 34;
        }
        if !self.sheet.key.is_empty() {
            y += 16;
            let small = ("sans-serif", 16).into_font().color(&grey);
            area.draw(&Text::new("borders", (x, y), small)).map_err(PlotError::from)?;
            y += 28;
        }
        for &(kind, [r, g, b]) in self.sheet.key {
            let sample = PathElement::new(vec![(x, y + 12), (x + 34, y + 12)], RGBColor(r, g, b).stroke_width(2));
            area.draw(&sample).map_err(PlotError::from)?;
            area.draw(&Text::new(kind.to_owned(), (x + 44, y + 12), text.clone())).map_err(PlotError::from)?;
            y += 26;
        }
        if let (false, Ground::Raster(raster)) = (lines.is_empty(), &self.sheet.ground) {
            let [x_span, y_span] = spans.clone();
            let frame = Frame { left, top, width, height, x: x_span, y: y_span, raster };
            draw_lines(area, &frame, lines)?;
            draw_key(area, lines, (x, y + 16))?;
        }
        Ok(())
    }
}

/// Width and height of a bar of colours.
const BAR: (u32, u32) = (26, 230);

/// Draws the legend of numbers from a place down; answers how far it reaches.
fn draw_bar<B: DrawingBackend>(
    area: &DrawingArea<B, Shift>,
    bar: &Bar,
    palette: Palette,
    (x, y): (i32, i32),
) -> Result<i32, PlotError> {
    let text = |size: i32, grey: u8| {
        ("sans-serif", size).into_font().color(&RGBColor(grey, grey, grey)).pos(Pos::new(HPos::Left, VPos::Center))
    };
    area.draw(&Text::new(bar.heading(), (x, y + 8), text(16, 60))).map_err(PlotError::from)?;
    let mut y = y + 30;
    let patch = |shade: Shade, words: String, y: &mut i32| -> Result<(), PlotError> {
        swatch(area, |px, py| bar.colours.pixel(palette, shade, px, py), (x, *y))?;
        area.draw(&Text::new(words, (x + 44, *y + 12), text(17, 0))).map_err(PlotError::from)?;
        *y += 34;
        Ok(())
    };
    if let Some(most) = bar.patches() {
        for number in 1..=most {
            patch(Shade::Number(number as f32), number.to_string(), &mut y)?;
        }
    } else {
        let (width, height) = BAR;
        let part = |py: u32| 1.0 - (f64::from(py) + 0.5) / f64::from(height);
        coloured(area, |_, py| palette.scale(part(py)), (x, y), BAR)?;
        let right = x + width as i32;
        for (part, words) in bar.ticks() {
            let at = y + ((1.0 - part) * f64::from(height)).round() as i32;
            let tick = PathElement::new(vec![(right, at), (right + 5, at)], BLACK.stroke_width(1));
            area.draw(&tick).map_err(PlotError::from)?;
            area.draw(&Text::new(words, (right + 10, at), text(15, 0))).map_err(PlotError::from)?;
        }
        y += height as i32 + 20;
    }
    if bar.below {
        // Any number that is below.
        patch(Shade::Number(f32::NEG_INFINITY), bar.below_words(), &mut y)?;
    }
    if bar.nothing {
        patch(Shade::Nothing, NOTHING.to_owned(), &mut y)?;
    }
    if bar.unknown {
        patch(Shade::Unknown, UNKNOWN.to_owned(), &mut y)?;
    }
    Ok(y)
}

/// The sample of a legend's entry.
fn swatch<B: DrawingBackend>(
    area: &DrawingArea<B, Shift>,
    pixel: impl Fn(u32, u32) -> [u8; 3],
    (x, y): (i32, i32),
) -> Result<(), PlotError> {
    coloured(area, pixel, (x, y), (32, 24))
}

/// A patch of pixels in a frame.
fn coloured<B: DrawingBackend>(
    area: &DrawingArea<B, Shift>,
    pixel: impl Fn(u32, u32) -> [u8; 3],
    (x, y): (i32, i32),
    (width, height): (u32, u32),
) -> Result<(), PlotError> {
    let places = (0..height).flat_map(|py| (0..width).map(move |px| (px, py)));
    let pixels = places.flat_map(|(px, py)| pixel(px, py)).collect();
    if let Some(patch) = BitMapElement::with_owned_buffer((x, y), (width, height), pixels) {
        area.draw(&patch).map_err(PlotError::from)?;
    }
    let (right, bottom) = (x + width as i32, y + height as i32);
    let outline = vec![(x, y), (right, y), (right, bottom), (x, bottom), (x, y)];
    area.draw(&PathElement::new(outline, BLACK.stroke_width(1))).map_err(PlotError::from)
}

/// Where the first value of an axis lies on the picture, and the distance of neighbours: their logarithms where the ratio is
/// constant, their numbers in a list.
pub(crate) fn places(axis: &Axis) -> (f64, f64) {
    let part = |from: f64, to: f64, points: usize| (from, (to - from) / (points - 1) as f64);
    match &axis.values {
        Values::Linear { from, to, points } => part(*from, *to, *points),
        Values::Logarithmic { from, to, points } => part(from.log10(), to.log10(), *points),
        Values::List(_) => (0.0, 1.0),
    }
}

/// The tick at a place on the picture.
fn tick_at(axis: &Axis, place: f64) -> String {
    match &axis.values {
        Values::Linear { .. } => tick(place),
        Values::Logarithmic { .. } => power_tick(place),
        Values::List(values) => {
            let whole = place.fract().abs() < 1e-9 && place >= 0.0;
            values.get(place as usize).filter(|_| whole).map_or_else(String::new, |value| tick(*value))
        }
    }
}

/// The tick at a decimal logarithm: three digits, between decades no more is of use.
pub(crate) fn power_tick(place: f64) -> String {
    let value = 10f64.powf(place);
    tick(format!("{value:.2e}").parse().unwrap_or(value))
}

/// A tick in as few digits as it needs; values that are 0 up to rounding are 0.
pub(crate) fn tick(value: f64) -> String {
    let rounded = format!("{value:.6}");
    let trimmed = rounded.trim_end_matches('0').trim_end_matches('.');
    if value != 0.0 && value.abs() < 1e-3 && trimmed.trim_start_matches('-') != "0" || value.abs() >= 1e6 {
        format!("{value:e}")
    } else if trimmed == "-0" {
        "0".to_owned()
    } else {
        trimmed.to_owned()
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;

    fn scene(x: &str, y: &str) -> Scene {
        let text = format!(
            "[model]\nsites = 3\ngamma1 = 0.2\nasymmetry = 0.4\n[sweep]\nx = {{ parameter = \"omega\", {x} }}\n\
             y = {{ parameter = \"gamma2\", {y} }}\n[compute]\nfamilies = [\"double-sided\"]\n"
        );
        Scene::parse(Path::new("scene.toml"), &text).unwrap()
    }

    #[test]
    fn a_map_with_thousands_of_columns_shows_as_many_as_it_can() {
        let scene = scene("from = 0.4, to = 3.0, points = 12001", "values = [0.1, 0.2]");
        let shown: Vec<u64> = (0..scene.cells()).filter(|&cell| is_shown(&scene, cell)).collect();
        let expected: Vec<u64> = (0..2).flat_map(|row| (0..4001).map(move |i| 12_001 * row + 3 * i)).collect();
        assert_eq!(shown, expected);
        assert_eq!(Grid::new(12_001).shown, 4001);
    }

    #[test]
    fn ticks_stand_where_the_values_are() {
        let scene = scene("from = 0.01, to = 100, points = 5, spacing = \"log\"", "values = [0.3, 0, 0.125]");
        let [x, y] = scene.plane().unwrap();
        assert_eq!(places(x), (-2.0, 1.0));
        assert_eq!([-2.0, -0.5, 0.0, 2.0].map(|place| tick_at(x, place)), ["0.01", "0.316", "1", "100"]);
        assert_eq!([-1.0, 0.0, 0.5, 1.0, 2.0, 3.0].map(|place| tick_at(y, place)), ["", "0.3", "", "0", "0.125", ""]);
    }
}
