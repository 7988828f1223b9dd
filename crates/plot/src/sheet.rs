//! A map with all that stands about it: headings, frame, axes, legend.

use std::ops::Range;

use plotters::coord::Shift;
use plotters::element::{BitMapElement, PathElement, Rectangle, Text};
use plotters::prelude::{BLACK, ChartBuilder, Color, DrawingArea, DrawingBackend, IntoFont, RGBColor, WHITE};
use plotters::style::text_anchor::{HPos, Pos, VPos};
use vibrochain_floquet::Mechanism;
use vibrochain_maps::cell::Class;
use vibrochain_maps::point::Parameter;
use vibrochain_maps::scene::{Axis, Scene, Values};

use crate::canvas::{Drawing, Format, PlotError, render};
use crate::lines::{Frame, MapLine, draw_key, draw_lines};
use crate::palette::{Palette, Tile, sample};
use crate::quantity::{Bar, Shade};
use crate::ticks::{Places, tick_at};
use crate::words::Heading;

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

/// "21 masses (N = 20), γ₁ = 0.2, …": what is fixed.
pub(crate) fn fixed(scene: &Scene) -> String {
    let layout = scene.base.layout;
    let mut text = layout.to_string();
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
    fn moved(&self, elements: &str) -> String {
        format!("<g transform=\"translate({LEFT} {})\">\n{elements}</g>\n", self.top)
    }
}

impl Drawing for Headed<'_> {
    fn shapes(&self) -> Option<String> {
        let Ground::Shapes(shapes) = &self.sheet.ground else { return None };
        Some(self.moved(shapes))
    }

    fn overlay(&self) -> Option<String> {
        let overlay = &self.sheet.overlay;
        (!overlay.is_empty()).then(|| self.moved(overlay))
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
            .build_cartesian_2d(coordinate(x_axis, &spans[0]), coordinate(y_axis, &spans[1]))
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

/// An axis as the picture has it.
fn coordinate(axis: &Axis, span: &Range<f64>) -> Places {
    Places::new(span.clone(), matches!(axis.values, Values::Logarithmic { .. }))
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
pub(crate) fn swatch<B: DrawingBackend>(
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
