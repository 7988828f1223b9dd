//! Lines with labels over the raster of a map: white on dark cells and black on light ones, and broken, so that the cells
//! under them show.

use std::ops::Range;

use plotters::coord::Shift;
use plotters::element::{PathElement, Rectangle, Text};
use plotters::prelude::{BLACK, Color, DrawingArea, DrawingBackend, IntoFont, RGBColor, WHITE};
use plotters::style::text_anchor::{HPos, Pos, VPos};

use crate::canvas::PlotError;

/// A line over a map.
#[derive(Debug, Clone, PartialEq)]
pub struct MapLine {
    /// Its points, in units of the axes.
    pub points: Vec<(f64, f64)>,
    /// What is written on it, where there is room.
    pub label: String,
    /// Drawn thin, without a label.
    pub faint: bool,
    /// The number of the breather's own mode, if it is one of the two.
    pub own: Option<usize>,
}

/// Where the raster lies, in pixels and in units of the axes.
#[derive(Debug, Clone)]
pub(crate) struct Frame<'a> {
    pub(crate) left: i32,
    pub(crate) top: i32,
    pub(crate) width: u32,
    pub(crate) height: u32,
    pub(crate) x: Range<f64>,
    pub(crate) y: Range<f64>,
    /// Its pixels, three bytes each.
    pub(crate) raster: &'a [u8],
}

impl Frame<'_> {
    /// Whether the raster is dark at a pixel.
    fn is_dark(&self, (x, y): (i32, i32)) -> bool {
        let column = (x - self.left).clamp(0, self.width as i32 - 1) as usize;
        let row = (y - self.top).clamp(0, self.height as i32 - 1) as usize;
        let first = 3 * (row * self.width as usize + column);
        let grey =
            |rgb: &[u8]| rgb.iter().zip([0.3, 0.59, 0.11]).map(|(c, weight)| f64::from(*c) * weight).sum::<f64>();
        self.raster.get(first..first + 3).is_some_and(|rgb| grey(rgb) < 110.0)
    }

    fn pixel(&self, (x, y): (f64, f64)) -> (f64, f64) {
        let part = |value: f64, range: &Range<f64>| (value - range.start) / (range.end - range.start);
        (
            f64::from(self.left) + part(x, &self.x) * f64::from(self.width),
            f64::from(self.top) + (1.0 - part(y, &self.y)) * f64::from(self.height),
        )
    }

    fn holds(&self, (left, top, right, bottom): Box) -> bool {
        left > self.left
            && top > self.top
            && right < self.left + self.width as i32
            && bottom < self.top + self.height as i32
    }
}

/// Left, top, right, bottom.
type Box = (i32, i32, i32, i32);

/// Dash and gap, in pixels.
const DASH: (f64, f64) = (7.0, 9.0);

/// Shorter lines have no label.
const LABELLED: f64 = 60.0;

const SIZE: i32 = 13;

/// The dashes of line number `number`, pixel by pixel. Lines begin their dashes at different places, or those side by side
/// would make a pattern of their own.
fn dashes(points: &[(f64, f64)], number: usize) -> Vec<Vec<(i32, i32)>> {
    let (on, off) = DASH;
    let (mut all, mut dash) = (Vec::new(), Vec::new());
    let golden = 0.5 * (5f64.sqrt() - 1.0);
    let mut along = (number as f64 * golden).fract() * (on + off);
    let pixel = |(x, y): (f64, f64)| (x.round() as i32, y.round() as i32);
    for pair in points.windows(2) {
        let (from, to) = (pair[0], pair[1]);
        let length = (to.0 - from.0).hypot(to.1 - from.1);
        // Steps of a pixel: enough for the eye, and no case is special.
        let steps = length.ceil().max(1.0) as usize;
        for step in 0..steps {
            let part = step as f64 / steps as f64;
            let at = (from.0 + part * (to.0 - from.0), from.1 + part * (to.1 - from.1));
            if along % (on + off) < on {
                dash.push(pixel(at));
            } else if !dash.is_empty() {
                all.push(std::mem::take(&mut dash));
            }
            along += length / steps as f64;
        }
    }
    if !dash.is_empty() {
        all.push(dash);
    }
    all
}

/// Draws lines and as many labels as do not meet.
pub(crate) fn draw_lines<B: DrawingBackend>(
    area: &DrawingArea<B, Shift>,
    frame: &Frame<'_>,
    lines: &[MapLine],
) -> Result<(), PlotError> {
    let pixels: Vec<Vec<(f64, f64)>> =
        lines.iter().map(|line| line.points.iter().map(|point| frame.pixel(*point)).collect()).collect();
    for (number, (_, points)) in lines.iter().zip(&pixels).filter(|(line, _)| line.faint).enumerate() {
        for dash in dashes(points, number) {
            area.draw(&PathElement::new(dash, RGBColor(120, 120, 120).stroke_width(1))).map_err(PlotError::from)?;
        }
    }
    let strong = || lines.iter().zip(&pixels).filter(|(line, _)| !line.faint);
    for (number, (_, points)) in strong().enumerate() {
        for dash in dashes(points, number) {
            // A dash may run from dark to light cells.
            for part in dash.chunk_by(|a, b| frame.is_dark(*a) == frame.is_dark(*b)) {
                let dark = part.first().is_some_and(|pixel| frame.is_dark(*pixel));
                let colour = if dark { WHITE } else { BLACK };
                area.draw(&PathElement::new(part.to_vec(), colour.stroke_width(1))).map_err(PlotError::from)?;
            }
        }
    }
    let mut taken: Vec<Box> = Vec::new();
    for (line, points) in strong().filter(|(_, points)| length(points) > LABELLED) {
        let (width, height) = (label_width(&line.label), SIZE + 3);
        // From the top of the line down: that is where lines are farthest apart.
        let place =
            points.iter().rev().map(|(x, y)| (x.round() as i32, y.round() as i32 + height)).find_map(|(x, y)| {
                let own = (x - width / 2, y - height / 2, x + width / 2, y + height / 2);
                let free = taken.iter().all(|other| apart(own, *other));
                (frame.holds(own) && free && lone(own, points, &pixels)).then_some(own)
            });
        let Some(own) = place else { continue };
        taken.push(own);
        let (left, top, right, bottom) = own;
        area.draw(&Rectangle::new([(left, top), (right, bottom)], WHITE.filled())).map_err(PlotError::from)?;
        let centre = ((left + right) / 2, (top + bottom) / 2);
        let font = ("sans-serif", SIZE).into_font().color(&BLACK).pos(Pos::new(HPos::Center, VPos::Center));
        area.draw(&Text::new(line.label.clone(), centre, font)).map_err(PlotError::from)?;
    }
    Ok(())
}

/// Length of a line in pixels.
fn length(points: &[(f64, f64)]) -> f64 {
    points.windows(2).map(|pair| (pair[1].0 - pair[0].0).hypot(pair[1].1 - pair[0].1)).sum()
}

fn label_width(label: &str) -> i32 {
    label.chars().map(|c| if c == ',' { 5 } else { 9 }).sum::<i32>() + 4
}

fn apart(a: Box, b: Box) -> bool {
    const AIR: i32 = 3;
    a.2 + AIR < b.0 || b.2 + AIR < a.0 || a.3 + AIR < b.1 || b.3 + AIR < a.1
}

/// No other line passes under the label: it would be unclear whose it is.
fn lone(own: Box, points: &[(f64, f64)], all: &[Vec<(f64, f64)>]) -> bool {
    let inside = |(x, y): &(f64, f64)| {
        *x > f64::from(own.0) && *x < f64::from(own.2) && *y > f64::from(own.1) && *y < f64::from(own.3)
    };
    all.iter().filter(|other| !std::ptr::eq(other.as_slice(), points)).all(|other| !other.iter().any(inside))
}

/// The entries of the legend.
pub(crate) fn draw_key<B: DrawingBackend>(
    area: &DrawingArea<B, Shift>,
    lines: &[MapLine],
    (x, y): (i32, i32),
) -> Result<(), PlotError> {
    let small = |size: i32, grey: u8| {
        ("sans-serif", size).into_font().color(&RGBColor(grey, grey, grey)).pos(Pos::new(HPos::Left, VPos::Center))
    };
    let mut y = y;
    area.draw(&Text::new("two modes meet", (x, y), small(16, 60))).map_err(PlotError::from)?;
    y += 28;
    for (faint, text) in [(false, "k,l,j: Ωₖ + Ωₗ = jω"), (true, "Ωₖ − Ωₗ = jω")] {
        if !lines.iter().any(|line| line.faint == faint) {
            continue;
        }
        let sample = [(f64::from(x), f64::from(y)), (f64::from(x) + 34.0, f64::from(y))];
        for dash in dashes(&sample, 0) {
            let colour = if faint { RGBColor(120, 120, 120) } else { RGBColor(0, 0, 0) };
            area.draw(&PathElement::new(dash, colour.stroke_width(1))).map_err(PlotError::from)?;
        }
        area.draw(&Text::new(text, (x + 44, y), small(17, 0))).map_err(PlotError::from)?;
        y += 30;
    }
    let own = lines.iter().find_map(|line| line.own).map(|mode| format!("{mode}: the breather's own"));
    for text in [Some("Ω of the modes as the"), Some("breather shifts them"), own.as_deref()].into_iter().flatten() {
        area.draw(&Text::new(text, (x, y), small(15, 60))).map_err(PlotError::from)?;
        y += 22;
    }
    Ok(())
}
