//! Curves and points in panels: one drawing for all figures that are not maps. Lines differ in colour, lightness and
//! dashes, points in shape; the legend stands above its panel, where it hides nothing.

use std::ops::Range;

use plotters::chart::{ChartBuilder, ChartContext, LabelAreaPosition};
use plotters::coord::Shift;
use plotters::coord::cartesian::Cartesian2d;
use plotters::coord::ranged1d::{Ranged, ValueFormatter};
use plotters::element::{DashedPathElement, EmptyElement, PathElement, Polygon, Text};
use plotters::prelude::{BLACK, Color, DrawingArea, DrawingBackend, IntoFont, LineSeries, RGBColor, WHITE};

use crate::axes::labelled_axes;
use crate::canvas::{Drawing, Format, PlotError, render};
use crate::decades::{Decades, power_of_ten};
use crate::markers::marker;
use crate::palette::LINES;
use crate::ticks::{Places, power_tick, tick};
use crate::words::Heading;

/// A picture of panels side by side.
#[derive(Debug, Clone, PartialEq)]
pub struct Curves {
    /// Line above the panels.
    pub title: String,
    /// The panels, row by row.
    pub panes: Vec<Pane>,
    /// Panels in a row.
    pub columns: usize,
    /// Width and height of a panel in pixels, its legend included.
    pub pane: (u32, u32),
}

/// One panel.
#[derive(Debug, Clone, PartialEq)]
pub struct Pane {
    /// Line above the legend; may be empty.
    pub caption: String,
    /// What the horizontal axis is.
    pub x: String,
    /// What the vertical axis is.
    pub y: String,
    /// Ends of the horizontal axis; from the data if absent.
    pub x_range: Option<Range<f64>>,
    /// Places along the horizontal axis are decimal logarithms; its ticks tell the numbers.
    pub x_log: bool,
    /// Scale of the vertical axis.
    pub scale: Scale,
    /// Heights of thin dashed lines across the panel, such as the barriers.
    pub levels: Vec<f64>,
    /// Both axes in the same units, so that a circle is round.
    pub round: bool,
    /// The curves.
    pub series: Vec<Series>,
}

/// A vertical axis.
#[derive(Debug, Clone, PartialEq)]
pub enum Scale {
    /// Linear, from the data.
    Linear,
    /// Linear with these ends; points beyond are left out.
    Between(Range<f64>),
    /// Logarithmic; values that are not positive are left out.
    Logarithmic,
}

impl Scale {
    /// The scale of multipliers: linear about 1, where stability changes, if most of what is unstable is not far from there. Next to a
    /// grazing impact they grow without bound; such ends leave the picture.
    pub fn about_one(series: &[Series]) -> Self {
        let points = series.iter().flat_map(|series| &series.points);
        let mut drawn: Vec<f64> = points.map(|point| point.1).filter(|value| value.is_finite()).collect();
        drawn.sort_by(f64::total_cmp);
        let unstable = &drawn[drawn.partition_point(|value| *value <= 1.0 + LEAST / 100.0)..];
        let Some(least) = drawn.first() else { return Self::Linear };
        let most = unstable.get(unstable.len() * MOST_OF_IT / 100).copied().unwrap_or(1.0);
        if most > FAR {
            return Self::Logarithmic;
        }
        let top = drawn.last().copied().unwrap_or(most).min(1.0 + ROOM * (most - 1.0)).max(1.0 + LEAST);
        let low = least.min(1.0);
        Self::Between(low - 0.07 * (top - low)..top)
    }
}

/// How the points of a series are joined.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Stroke {
    /// Not at all.
    None,
    /// By a line so many pixels wide.
    Solid(u32),
    /// By dashes so many pixels wide.
    Dashed(u32),
}

/// How the points of a series are marked.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Mark {
    /// Not at all.
    None,
    /// By a filled shape.
    Filled(usize),
    /// By a filled shape of about half the size, where many points are close.
    Small(usize),
    /// By a dot of two pixels, where there are thousands.
    Dot,
    /// By the outline of a shape, larger, so that a filled one shows inside.
    Hollow(usize),
}

/// A curve.
#[derive(Debug, Clone, PartialEq)]
pub struct Series {
    /// Its name in the legend; without one it has no entry.
    pub name: String,
    /// Which of the colours of lines.
    pub colour: usize,
    /// The line.
    pub stroke: Stroke,
    /// The points.
    pub mark: Mark,
    /// Its points. One that is not finite breaks the line.
    pub points: Vec<(f64, f64)>,
}

/// Multipliers are drawn linearly where of those beyond 1 this many in a hundred are below `FAR`, up to so many times as far from
/// 1 as these are, and at least so far; otherwise by logarithms.
const MOST_OF_IT: usize = 80;
const FAR: f64 = 5.0;
const ROOM: f64 = 2.0;
const LEAST: f64 = 0.01;

/// Height and width of what is about the lines of the title, and their size.
const HEADING: (u32, u32) = (16, 32);
const TITLE: u32 = 18;
const CAPTION: u32 = 16;
const LEGEND_ROW: u32 = 24;
const LEFT: u32 = 76;
const RIGHT: u32 = 22;
const BOTTOM: u32 = 54;

/// Width of a letter in a legend, in pixels, on the generous side.
const LETTER: f64 = 8.3;
/// Width of the sample of a line and the space about it.
const SAMPLE: u32 = 58;

/// The bytes of the picture.
///
/// # Errors
/// [`PlotError`].
pub fn curves_picture(picture: &Curves, format: Format) -> Result<Vec<u8>, PlotError> {
    let columns = picture.columns.clamp(1, picture.panes.len().max(1));
    let rows = picture.panes.len().div_ceil(columns).max(1);
    let width = picture.pane.0 * columns as u32;
    let title = Heading::new(&picture.title, width - HEADING.1, TITLE);
    let size = (width, HEADING.0 + title.height() + picture.pane.1 * rows as u32);
    render(&Sheet { picture, title, grid: (rows, columns) }, format, size)
}

struct Sheet<'a> {
    picture: &'a Curves,
    title: Heading,
    grid: (usize, usize),
}

fn colour(index: usize) -> RGBColor {
    let [r, g, b] = LINES[index % LINES.len()];
    RGBColor(r, g, b)
}

/// Where the entries of a legend go: row and x of each, and the number of rows.
fn legend_places(series: &[Series], width: u32) -> (Vec<(u32, u32)>, u32) {
    let (mut x, mut row) = (LEFT, 0);
    let mut places = Vec::new();
    for entry in series.iter().filter(|entry| !entry.name.is_empty()) {
        let wide = SAMPLE + (LETTER * entry.name.chars().count() as f64) as u32;
        if x > LEFT && x + wide > width {
            (x, row) = (LEFT, row + 1);
        }
        places.push((row, x));
        x += wide;
    }
    let rows = if places.is_empty() { 0 } else { row + 1 };
    (places, rows)
}

impl Drawing for Sheet<'_> {
    fn draw<B: DrawingBackend>(&self, area: &DrawingArea<B, Shift>) -> Result<(), PlotError> {
        area.fill(&WHITE).map_err(PlotError::from)?;
        let (heading, below) = area.split_vertically(HEADING.0 + self.title.height());
        self.title.draw(&heading, (HEADING.1 as i32 / 2, 10), BLACK)?;
        let panes = below.split_evenly(self.grid);
        for (row, places) in self.picture.panes.chunks(self.grid.1).zip(panes.chunks(self.grid.1)) {
            draw_row(places, row)?;
        }
        Ok(())
    }
}

/// Draws panels side by side. They share the height of captions and legends, so that their axes stand level.
pub(crate) fn draw_row<B: DrawingBackend>(places: &[DrawingArea<B, Shift>], row: &[Pane]) -> Result<(), PlotError> {
    let width = places.iter().map(|place| place.dim_in_pixel().0).min().unwrap_or(0);
    let legend = row.iter().map(|pane| legend_places(&pane.series, width).1).max().unwrap_or(0);
    let captions: Vec<_> = row.iter().map(|pane| Heading::new(&pane.caption, width - LEFT - RIGHT, CAPTION)).collect();
    let caption =
        captions.iter().map(Heading::height).max().filter(|height| *height > 0).map_or(0, |height| height + 6);
    for ((pane, heading), place) in row.iter().zip(&captions).zip(places) {
        heading.draw(place, (LEFT as i32, 4), BLACK)?;
        draw_pane(place, pane, caption, caption + LEGEND_ROW * legend)?;
    }
    Ok(())
}

fn text<B: DrawingBackend>(
    area: &DrawingArea<B, Shift>,
    words: &str,
    place: (i32, i32),
    size: u32,
) -> Result<(), PlotError> {
    let style = ("sans-serif", size).into_font().color(&BLACK);
    area.draw(&Text::new(words.to_owned(), place, style)).map_err(PlotError::from)
}

/// A range with some air about it.
fn padded(values: impl Iterator<Item = f64>) -> Range<f64> {
    let finite = values.filter(|value| value.is_finite());
    let (low, high) = finite.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(v), h.max(v)));
    if low > high {
        return -1.0..1.0;
    }
    // What is constant but for rounding is drawn as constant.
    let constant = high - low <= 1e-9 * high.abs().max(low.abs());
    let air = if constant { 0.05 * high.abs().max(1e-9) } else { 0.07 * (high - low) };
    low - air..high + air
}

/// The same middle, `factor` times as long.
fn stretched(range: &Range<f64>, factor: f64) -> Range<f64> {
    let (middle, half) = (0.5 * (range.start + range.end), 0.5 * factor * (range.end - range.start));
    middle - half..middle + half
}

fn draw_pane<B: DrawingBackend>(
    area: &DrawingArea<B, Shift>,
    pane: &Pane,
    caption: u32,
    header: u32,
) -> Result<(), PlotError> {
    let (width, height) = area.dim_in_pixel();
    let (head, body) = area.split_vertically(header);
    let named = pane.series.iter().filter(|series| !series.name.is_empty());
    for (series, (row, x)) in named.zip(legend_places(&pane.series, width).0) {
        let (x, y) = (x as i32, (caption + LEGEND_ROW * row) as i32 + 10);
        let line = [(x, y), (x + 34, y)];
        draw_line(&head, series, &line)?;
        draw_marks(&head, series, &[(x + 17, y)])?;
        text(&head, &series.name, (x + 41, y - 8), 15)?;
    }
    let points = || pane.series.iter().flat_map(|series| series.points.iter().copied());
    let mut x = pane.x_range.clone().unwrap_or_else(|| padded(points().map(|point| point.0)));
    let mut builder = ChartBuilder::on(&body);
    builder
        .margin_right(RIGHT)
        .margin_left(8)
        .margin_top(4)
        .margin_bottom(6)
        .set_label_area_size(LabelAreaPosition::Left, LEFT - 8)
        .set_label_area_size(LabelAreaPosition::Bottom, BOTTOM);
    let visible = |x: &Range<f64>| {
        let x = x.clone();
        points().filter(move |point| x.contains(&point.0)).map(|point| point.1)
    };
    match &pane.scale {
        Scale::Logarithmic => {
            let y = Decades::holding(visible(&x).filter(|y| *y > 0.0 && y.is_finite()).map(f64::log10));
            let chart = builder.build_cartesian_2d(Places::new(x.clone(), pane.x_log), y).map_err(PlotError::from)?;
            let place = |(px, py): (f64, f64)| (py > 0.0 && py.is_finite()).then(|| (px, py.log10()));
            fill(chart, pane, &x, &place, &|value| power_of_ten(*value))
        }
        scale => {
            let mut y = match scale {
                Scale::Between(range) => range.clone(),
                _ => padded(visible(&x).chain(pane.levels.iter().copied())),
            };
            if pane.round {
                let pixels =
                    f64::from(width - LEFT - RIGHT) / f64::from((height - header).max(BOTTOM + 20) - BOTTOM - 10);
                let ratio = pixels * (y.end - y.start) / (x.end - x.start);
                if ratio > 1.0 {
                    x = stretched(&x, ratio);
                } else {
                    y = stretched(&y, 1.0 / ratio);
                }
            }
            let places = Places::new(x.clone(), pane.x_log);
            let chart = builder.build_cartesian_2d(places, y.clone()).map_err(PlotError::from)?;
            let inside = stretched(&y, 1.0 + 1e-9);
            let place = |(px, py): (f64, f64)| inside.contains(&py).then_some((px, py));
            fill(chart, pane, &x, &place, &|value| tick(*value))
        }
    }
}

fn fill<B: DrawingBackend, Y>(
    mut chart: ChartContext<'_, B, Cartesian2d<Places, Y>>,
    pane: &Pane,
    x: &Range<f64>,
    place: &dyn Fn((f64, f64)) -> Option<(f64, f64)>,
    label: &dyn Fn(&f64) -> String,
) -> Result<(), PlotError>
where
    Y: Ranged<ValueType = f64> + ValueFormatter<f64>,
{
    let number = |place: &f64| if pane.x_log { power_tick(*place) } else { tick(*place) };
    labelled_axes(&mut chart, &pane.x, &pane.y, true, [&number, label])?;
    let thin = RGBColor(110, 110, 110).stroke_width(1);
    let levels = pane.levels.iter().filter_map(|&level| Some(place((x.start, level))?.1));
    let levels = levels.map(|y| DashedPathElement::new(vec![(x.start, y), (x.end, y)], 6, 4, thin));
    chart.draw_series(levels).map_err(PlotError::from)?;
    let inside = stretched(x, 1.0 + 1e-9);
    for series in &pane.series {
        let shade = colour(series.colour);
        let placed = series.points.iter().map(|&point| if inside.contains(&point.0) { place(point) } else { None });
        let placed: Vec<Option<(f64, f64)>> = placed.collect();
        for piece in placed.split(Option::is_none).filter(|piece| piece.len() > 1) {
            let piece = piece.iter().flatten().copied();
            match series.stroke {
                Stroke::None => {}
                Stroke::Solid(width) => {
                    let line = LineSeries::new(piece, shade.stroke_width(width));
                    chart.draw_series(line).map_err(PlotError::from)?;
                }
                Stroke::Dashed(width) => {
                    let line = DashedPathElement::new(piece.collect::<Vec<_>>(), 8, 5, shade.stroke_width(width));
                    chart.draw_series([line]).map_err(PlotError::from)?;
                }
            }
        }
        let points = placed.iter().flatten().copied();
        match series.mark {
            Mark::None => {}
            Mark::Filled(_) | Mark::Small(_) | Mark::Dot => {
                let marks = points.map(|point| EmptyElement::at(point) + Polygon::new(filled(series.mark), shade));
                chart.draw_series(marks).map_err(PlotError::from)?;
            }
            Mark::Hollow(shape) => {
                let marks = points
                    .map(|point| EmptyElement::at(point) + PathElement::new(outline(shape), shade.stroke_width(2)));
                chart.draw_series(marks).map_err(PlotError::from)?;
            }
        }
    }
    Ok(())
}

/// The corners of a filled shape.
fn filled(mark: Mark) -> Vec<(i32, i32)> {
    match mark {
        Mark::None => Vec::new(),
        Mark::Dot => vec![(0, 0), (1, 0), (1, 1), (0, 1)],
        Mark::Filled(shape) | Mark::Hollow(shape) => marker(shape),
        Mark::Small(shape) => marker(shape).into_iter().map(|(x, y)| (x * 3 / 5, y * 3 / 5)).collect(),
    }
}

/// The outline of a shape, closed and larger than the shape.
fn outline(shape: usize) -> Vec<(i32, i32)> {
    let mut corners: Vec<_> = marker(shape).into_iter().map(|(x, y)| (x * 3 / 2, y * 3 / 2)).collect();
    corners.extend(corners.first().copied());
    corners
}

/// The sample of a line in a legend.
fn draw_line<B: DrawingBackend>(
    area: &DrawingArea<B, Shift>,
    series: &Series,
    points: &[(i32, i32)],
) -> Result<(), PlotError> {
    let shade = colour(series.colour);
    match series.stroke {
        Stroke::None => Ok(()),
        Stroke::Solid(width) => area.draw(&PathElement::new(points.to_vec(), shade.stroke_width(width))),
        Stroke::Dashed(width) => area.draw(&DashedPathElement::new(points.to_vec(), 8, 5, shade.stroke_width(width))),
    }
    .map_err(PlotError::from)
}

/// The samples of a marker in a legend.
fn draw_marks<B: DrawingBackend>(
    area: &DrawingArea<B, Shift>,
    series: &Series,
    points: &[(i32, i32)],
) -> Result<(), PlotError> {
    let shade = colour(series.colour);
    for (x, y) in points {
        let at = |corners: Vec<(i32, i32)>| corners.into_iter().map(|(dx, dy)| (x + dx, y + dy)).collect::<Vec<_>>();
        match series.mark {
            Mark::None => {}
            Mark::Filled(_) | Mark::Small(_) | Mark::Dot => {
                area.draw(&Polygon::new(at(filled(series.mark)), shade)).map_err(PlotError::from)?;
            }
            Mark::Hollow(shape) => {
                area.draw(&PathElement::new(at(outline(shape)), shade.stroke_width(2))).map_err(PlotError::from)?;
            }
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn series(name: &str, points: Vec<(f64, f64)>) -> Series {
        Series { name: name.to_owned(), colour: 1, stroke: Stroke::Dashed(2), mark: Mark::Hollow(3), points }
    }

    fn pane(scale: Scale, series: Vec<Series>) -> Pane {
        let (caption, x, y) = ("caption".to_owned(), "ω".to_owned(), "v₀".to_owned());
        Pane { caption, x, y, x_range: None, x_log: false, scale, levels: vec![0.5], round: false, series }
    }

    #[test]
    fn every_scale_is_drawn_and_values_without_a_place_are_left_out() {
        let points = vec![(0.0, 1e-9), (1.0, 0.0), (2.0, 1.0), (3.0, f64::NAN), (4.0, 2.0)];
        for scale in [Scale::Linear, Scale::Logarithmic, Scale::Between(0.0..1.5)] {
            let panes = vec![pane(scale, vec![series("growth", points.clone())]), pane(Scale::Linear, Vec::new())];
            let picture = Curves { title: "γ₂".to_owned(), panes, columns: 2, pane: (500, 360) };
            let svg = String::from_utf8(curves_picture(&picture, Format::Svg).unwrap()).unwrap();
            assert!(svg.contains("γ₂") && svg.contains("growth") && !svg.contains("NaN"));
            assert!(curves_picture(&picture, Format::Png).unwrap().starts_with(b"\x89PNG"));
        }
    }

    #[test]
    fn a_legend_breaks_into_rows_where_the_panel_ends() {
        let entries: Vec<_> = (0..5).map(|i| series(&format!("a name of some length {i}"), Vec::new())).collect();
        let (places, rows) = legend_places(&entries, 600);
        assert_eq!((places.len(), rows), (5, 3));
        assert!(places.iter().all(|(_, x)| *x < 600) && legend_places(&[], 600).1 == 0);
    }
}
