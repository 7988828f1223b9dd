//! Lines with labels over the raster of a map: white on dark cells and black on light ones, and broken, so that the cells
//! under them show.

use crate::backend::drawing::{Across, BLACK, Drawing, Line, Place, Rgb, Upright, WHITE};
use crate::map::key::Entry;
use crate::map::raster::Raster;
use crate::map::sheet::Placed;
use crate::text::font::width;

/// A line over a map.
#[derive(Debug, Clone, PartialEq)]
pub struct MapLine {
    /// Its points, in units of the axes.
    pub points: Vec<(f64, f64)>,
    /// What is written on it, where there is room.
    pub label: String,
    /// Drawn thin, without a label.
    pub faint: bool,
    /// The number of the internal mode, if it is one of the two.
    pub internal: Option<usize>,
}

/// Left, top, right, bottom.
type Bounds = [f64; 4];

/// Dash and gap, and the steps in which the cells below are looked at, on a screen.
const DASH: [f64; 2] = [7.0, 9.0];
const STEP: f64 = 1.0;

/// Shorter lines have no label.
const LABELLED: f64 = 60.0;

/// Size of the labels against the letters of legends, and the air about them in em.
const SIZE: f64 = 0.87;
const AIR: f64 = 0.2;

/// Of lines that are not the main matter.
const FAINT: Rgb = [120, 120, 120];

/// The dashes of line number `number`, so many times as large as on a screen. Lines begin their dashes at different places, or those
/// side by side would make a pattern of their own.
fn dashes(points: &[Place], number: usize, times: f64) -> Vec<Vec<Place>> {
    let [on, off] = DASH.map(|part| part * times);
    let (mut all, mut dash) = (Vec::new(), Vec::new());
    let golden = 0.5 * (5f64.sqrt() - 1.0);
    let mut along = (number as f64 * golden).fract() * (on + off);
    for pair in points.windows(2) {
        let ([x0, y0], [x1, y1]) = (pair[0], pair[1]);
        let length = (x1 - x0).hypot(y1 - y0);
        // Small steps: enough for the eye, and no case is special.
        let steps = (length / (STEP * times)).ceil().clamp(1.0, 1e5) as usize;
        for step in 0..=steps {
            let part = step as f64 / steps as f64;
            if along % (on + off) < on {
                dash.push([x0 + part * (x1 - x0), y0 + part * (y1 - y0)]);
            } else if !dash.is_empty() {
                all.push(std::mem::take(&mut dash));
            }
            if step < steps {
                along += length / steps as f64;
            }
        }
    }
    if !dash.is_empty() {
        all.push(dash);
    }
    all
}

/// Draws lines and as many labels as do not meet.
pub(crate) fn draw_lines(
    drawing: &mut Drawing,
    placed: &Placed,
    raster: &Raster,
    lines: &[MapLine],
    part: &dyn Fn([f64; 2]) -> [f64; 2],
) {
    let page = &placed.page;
    let (times, corners) = (page.px(1.0), placed.corners());
    let points: Vec<Vec<Place>> =
        lines.iter().map(|line| line.points.iter().map(|&(x, y)| placed.within(part([x, y]))).collect()).collect();
    let of = |faint: bool| lines.iter().zip(&points).filter(move |(line, _)| line.faint == faint);
    drawing.clipped(corners, |drawing| {
        for (number, (_, points)) in of(true).enumerate() {
            for dash in dashes(points, number, times) {
                drawing.line(dash, Line::new(FAINT, times));
            }
        }
        let is_dark = |[x, y]: &Place| {
            let [[left, top], [right, bottom]] = corners;
            raster.is_dark([(x - left) / (right - left), (y - top) / (bottom - top)])
        };
        for (number, (_, points)) in of(false).enumerate() {
            for dash in dashes(points, number, times) {
                // A dash may run from dark to light cells.
                for part in dash.chunk_by(|a, b| is_dark(a) == is_dark(b)) {
                    let dark = part.first().is_some_and(is_dark);
                    drawing.line(part.to_vec(), Line::new(if dark { WHITE } else { BLACK }, 1.2 * times));
                }
            }
        }
    });
    let em = SIZE * page.font;
    let mut taken: Vec<Bounds> = Vec::new();
    for (line, own) in of(false).filter(|(_, points)| length(points) > LABELLED * times) {
        let (half, high) = (0.5 * em * width(&line.label) + AIR * em, 0.62 * em);
        // From the top of the line down: that is where lines are farthest apart.
        let place = own.iter().rev().find_map(|&[x, y]| {
            let y = y + 2.0 * high;
            let bounds = [x - half, y - high, x + half, y + high];
            let free = taken.iter().all(|other| apart(bounds, *other, 3.0 * times));
            (holds(corners, bounds, 3.0 * times) && free && lone(bounds, own, &points)).then_some(bounds)
        });
        let Some(bounds) = place else { continue };
        taken.push(bounds);
        let [left, top, right, bottom] = bounds;
        drawing.area(vec![[left, top], [right, top], [right, bottom], [left, bottom]], WHITE);
        let centre = [0.5 * (left + right), 0.5 * (top + bottom)];
        drawing.anchored(&line.label, centre, em, BLACK, (Across::Centre, Upright::Middle));
    }
}

/// Within the map, and off its frame.
fn holds([[left, top], [right, bottom]]: [Place; 2], bounds: Bounds, air: f64) -> bool {
    bounds[0] > left + air && bounds[1] > top + air && bounds[2] < right - air && bounds[3] < bottom - air
}

fn length(points: &[Place]) -> f64 {
    points.windows(2).map(|pair| (pair[1][0] - pair[0][0]).hypot(pair[1][1] - pair[0][1])).sum()
}

fn apart(a: Bounds, b: Bounds, air: f64) -> bool {
    a[2] + air < b[0] || b[2] + air < a[0] || a[3] + air < b[1] || b[3] + air < a[1]
}

/// No other line passes under the label: it would be unclear whose it is.
fn lone(own: Bounds, points: &[Place], all: &[Vec<Place>]) -> bool {
    let inside = |[x, y]: &Place| *x > own[0] && *x < own[2] && *y > own[1] && *y < own[3];
    all.iter().filter(|other| !std::ptr::eq(other.as_slice(), points)).all(|other| !other.iter().any(inside))
}

/// The entries of the legend.
pub(crate) fn key(lines: &[MapLine]) -> Vec<Entry<'static>> {
    if lines.is_empty() {
        return Vec::new();
    }
    let mut all = vec![Entry::Heading("two modes meet".to_owned())];
    for (faint, colour, text) in [(false, BLACK, "k,l,j: Ωₖ + Ωₗ = jω"), (true, FAINT, "Ωₖ − Ωₗ = jω")]
    {
        if lines.iter().any(|line| line.faint == faint) {
            all.push(Entry::Stroke(colour, Some(DASH), text.to_owned()));
        }
    }
    let internal = lines.iter().find_map(|line| line.internal).map(|mode| format!("{mode}: the internal mode"));
    let notes = [Some("Ω of the modes as the".to_owned()), Some("breather shifts them".to_owned()), internal];
    all.extend(notes.into_iter().flatten().map(Entry::Note));
    all
}
