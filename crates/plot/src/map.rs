//! The picture of a map: classes as colours, mechanisms as textures, every cell the same whole number of pixels.

use plotters::coord::Shift;
use plotters::element::{BitMapElement, PathElement, Rectangle, Text};
use plotters::prelude::{BLACK, ChartBuilder, Color, DrawingArea, DrawingBackend, IntoFont, RGBColor, WHITE};
use plotters::style::text_anchor::{HPos, Pos, VPos};
use std::ops::Range;
use vibrochain_floquet::Mechanism;

use crate::canvas::{Drawing, Format, PlotError, render};
pub use crate::lines::MapLine;
use crate::lines::{Frame, draw_key, draw_lines};
use crate::palette::{Palette, Tile, sample};
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
    /// Tiles of the cells that are [shown](is_shown), by rows, the first row at the bottom.
    pub tiles: &'a [Tile],
    /// The colours.
    pub palette: Palette,
}

/// Whether the picture of a sweep over two axes shows cell number `cell`: all do, unless there are thousands along an axis.
pub fn is_shown(scene: &Scene, cell: u64) -> bool {
    scene.plane().is_some_and(|[x, y]| {
        let columns = x.points() as u64;
        let (column, row) = (cell % columns, cell / columns);
        column.is_multiple_of(stride(x.points()) as u64) && row.is_multiple_of(stride(y.points()) as u64)
    })
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
    let mut tiles: Vec<Tile> = Vec::new();
    for tile in picture.tiles {
        if !tiles.contains(tile) {
            tiles.push(*tile);
        }
    }
    let ground = Ground::Raster(raster(picture, grids));
    let size = grids.map(|grid| grid.pixels());
    let sheet = Sheet {
        scene: picture.scene,
        palette: picture.palette,
        axes: [x, y],
        tiles,
        lines,
        key: &[],
        spans,
        size,
        ground,
    };
    sheet.bytes(format)
}

/// The pixels of a map's cells.
fn raster(picture: &MapPicture<'_>, [columns, rows]: [Grid; 2]) -> Vec<u8> {
    let (width, height) = (columns.pixels(), rows.pixels());
    let mut pixels = Vec::with_capacity(3 * (width * height) as usize);
    for py in 0..height {
        let row = (rows.shown as u32 - 1 - py / rows.cell) as usize;
        for px in 0..width {
            let column = (px / columns.cell) as usize;
            let unknown = Tile { class: None, mechanism: None };
            let tile = picture.tiles.get(row * columns.shown + column).copied().unwrap_or(unknown);
            pixels.extend(picture.palette.pixel(tile, px, py));
        }
    }
    pixels
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
    /// What occurs on it.
    pub(crate) tiles: Vec<Tile>,
    pub(crate) lines: &'a [MapLine],
    /// Kinds of borders that are drawn, and their colours.
    pub(crate) key: &'a [(&'a str, [u8; 3])],
    /// What the map spans of each axis.
    pub(crate) spans: [Range<f64>; 2],
    /// Its pixels.
    pub(crate) size: [u32; 2],
    pub(crate) ground: Ground,
}

fn label(axis: &Axis) -> String {
    format!("{} {}", axis.parameter.meaning(), axis.parameter.symbol())
}

/// "N = 20 (21 masses), γ₁ = 0.2, …": what is fixed.
fn fixed(scene: &Scene) -> String {
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
        let words = [Class::StableWord, Class::UnstableWord, Class::Word];
        let only_words =
            self.tiles.iter().filter_map(|tile| tile.class).all(|c| c == Class::None || words.contains(&c));
        let Some(class) = class else { return "not computed (see status)" };
        match class {
            Class::None => "no physical breather",
            Class::StableDouble => "stable double-sided",
            Class::StableSingle => "stable single-sided",
            Class::UnstableDouble => "unstable double-sided",
            Class::UnstableSingle => "unstable single-sided",
            Class::Double => "double-sided",
            Class::Single => "single-sided",
            // The title names the words.
            Class::StableWord if only_words => "stable breather",
            Class::UnstableWord if only_words => "unstable breather",
            Class::Word if only_words => "breather",
            Class::StableWord => "stable, other words",
            Class::UnstableWord => "unstable, other words",
            Class::Word => "other words",
        }
    }

    /// Textures that occur.
    fn textures(&self) -> Vec<(Mechanism, &'static str)> {
        let all = [Mechanism::NeimarkSacker, Mechanism::PeriodDoubling, Mechanism::PlusOne, Mechanism::Pitchfork];
        let occurs = |mechanism: &Mechanism| self.tiles.iter().any(|tile| tile.mechanism == Some(*mechanism));
        all.into_iter().filter(occurs).map(|mechanism| (mechanism, loss(mechanism))).collect()
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

impl Drawing for Headed<'_> {
    fn shapes(&self) -> Option<String> {
        let Ground::Shapes(shapes) = &self.sheet.ground else { return None };
        Some(format!("<g transform=\"translate({LEFT} {})\">\n{shapes}</g>\n", self.top))
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

/// The sample of a legend's entry.
fn swatch<B: DrawingBackend>(
    area: &DrawingArea<B, Shift>,
    pixel: impl Fn(u32, u32) -> [u8; 3],
    (x, y): (i32, i32),
) -> Result<(), PlotError> {
    let (width, height) = (32, 24);
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
        Values::Logarithmic { .. } => {
            // Three digits: between decades no more is of use.
            let value = 10f64.powf(place);
            tick(format!("{value:.2e}").parse().unwrap_or(value))
        }
        Values::List(values) => {
            let whole = place.fract().abs() < 1e-9 && place >= 0.0;
            values.get(place as usize).filter(|_| whole).map_or_else(String::new, |value| tick(*value))
        }
    }
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
