//! One panel: its axes from its data, its curves and its marks.

use std::ops::Range;

use crate::axes::axis::{Axis, Scale as Along};
use crate::axes::frame::Frame;
use crate::backend::drawing::{Drawing, Fill, Line, Place, Rgb, Shape};
use crate::backend::markers;
use crate::backend::page::Page;
use crate::backend::strokes::thinned;
use crate::map::palette::{BORDERS, LINES};
use crate::panels::curves::{Mark, Pane, Scale, Series, Stroke};

/// Dashes and gaps of lines, on a screen.
const DASH: [f64; 2] = [8.0, 5.0];

fn colour(index: usize) -> Rgb {
    let index = index % (LINES.len() + BORDERS.len());
    LINES.get(index).copied().unwrap_or_else(|| BORDERS[index - LINES.len()])
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

/// The axes of a panel, from its data as far as they are not given.
pub(crate) fn axes(pane: &Pane) -> (Axis, Axis) {
    let points = || pane.series.iter().flat_map(|series| series.points.iter().copied());
    let along = || points().map(|point| point.0).chain(pane.uprights.iter().copied());
    let x = pane.x_range.clone().unwrap_or_else(|| padded(along()));
    let visible = points().filter(|point| x.contains(&point.0)).map(|point| point.1);
    let y = match &pane.scale {
        Scale::Logarithmic => Axis::decades(visible.filter(|y| *y > 0.0 && y.is_finite()).map(f64::log10)),
        Scale::Between(range) => Axis::numbers(range.clone()),
        Scale::Moduli => Axis::moduli(visible),
        Scale::Linear => Axis::numbers(padded(visible.chain(pane.levels.iter().copied()))),
    };
    let scale = if pane.x_log { Along::Powers } else { Along::Numbers };
    (Axis { range: x, scale }, y)
}

pub(crate) fn stroke(series: &Series, page: &Page) -> Option<Line> {
    let line = |wide: u32| Line::new(colour(series.colour), page.px(f64::from(wide)));
    match series.stroke {
        Stroke::None => None,
        Stroke::Solid(wide) => Some(line(wide)),
        Stroke::Dashed(wide) => Some(line(wide).dashed(page.px(DASH[0]), page.px(DASH[1]))),
    }
}

pub(crate) fn mark(drawing: &mut Drawing, series: &Series, at: Place, page: &Page) {
    let (shade, size) = (colour(series.colour), page.px(1.0));
    match series.mark {
        Mark::None => {}
        Mark::Dot => drawing.circle(at, 1.1 * size, Some(shade), None),
        Mark::Filled(shape) => markers::draw(drawing, shape, at, size, Some(shade), None),
        Mark::Small(shape) => markers::draw(drawing, shape, at, 0.6 * size, Some(shade), None),
        Mark::Hollow(shape) => markers::draw(drawing, shape, at, 1.5 * size, None, Some(Line::new(shade, 2.0 * size))),
    }
}

impl Pane {
    pub(crate) fn draw(&self, drawing: &mut Drawing, mut frame: Frame, page: &Page) {
        if self.round {
            let [[left, top], [right, bottom]] = frame.corners;
            let (x, y) = (&frame.x.range, &frame.y.range);
            let ratio = (right - left) / (bottom - top) * (y.end - y.start) / (x.end - x.start);
            if ratio > 1.0 {
                frame.x.range = stretched(&frame.x.range, ratio);
            } else {
                frame.y.range = stretched(&frame.y.range, 1.0 / ratio);
            }
        }
        frame.grid(drawing, page);
        for level in self.levels.iter().map(|level| frame.y.scale.place(*level)) {
            if (0.0..=1.0).contains(&frame.y.part(level)) {
                frame.level(drawing, level, page);
            }
        }
        for upright in self.uprights.iter().filter(|upright| frame.x.range.contains(upright)) {
            frame.upright(drawing, *upright, page);
        }
        let place = |&(x, y): &(f64, f64)| {
            let y = frame.y.scale.place(y);
            (x.is_finite() && y.is_finite()).then(|| frame.place((x, y)))
        };
        // Half a mark beyond the edge is seen, its points are not beyond.
        let [[left, top], [right, bottom]] = frame.corners;
        let inside = |[x, y]: &Place| {
            let near = 1e-6 * (right - left);
            (left - near..=right + near).contains(x) && (top - near..=bottom + near).contains(y)
        };
        drawing.clipped(frame.corners, |drawing| {
            for series in &self.series {
                let Some(line) = stroke(series, page) else { continue };
                let placed: Vec<Option<Place>> =
                    series.points.iter().map(|point| Some(held(place(point)?, &frame))).collect();
                let pieces = placed.split(Option::is_none).filter(|piece| piece.len() > 1);
                let outlines: Vec<Vec<Place>> =
                    pieces.map(|piece| thinned(&piece.iter().flatten().copied().collect::<Vec<_>>())).collect();
                if !outlines.is_empty() {
                    drawing.shape(Shape { outlines, line: Some(line), ..Shape::default() });
                }
            }
        });
        frame.axes(drawing, [&self.x, &self.y], page);
        for series in &self.series {
            let seen = series.points.iter().filter_map(place).filter(inside);
            if series.mark == Mark::Dot {
                // As one shape: there are thousands.
                let half = page.px(0.9);
                let square = |[x, y]: Place| {
                    vec![[x - half, y - half], [x + half, y - half], [x + half, y + half], [x - half, y + half]]
                };
                let fill = Some(Fill::Colour(colour(series.colour)));
                let outlines: Vec<Vec<Place>> = seen.map(square).collect();
                drawing.shape(Shape { outlines, closed: true, fill, ..Shape::default() });
                continue;
            }
            seen.for_each(|at| mark(drawing, series, at, page));
        }
    }
}

/// A place as far off as any picture knows: numbers without bound leave it in their direction.
fn held([x, y]: Place, frame: &Frame) -> Place {
    let [[left, top], [right, bottom]] = frame.corners;
    let (w, h) = (20.0 * (right - left), 20.0 * (bottom - top));
    [x.clamp(left - w, right + w), y.clamp(top - h, bottom + h)]
}
