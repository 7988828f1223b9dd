//! Curves and points in panels: one drawing for all figures that are not maps. Lines differ in colour, lightness and
//! dashes, points in shape; the legend stands above its panel, where it hides nothing.

use std::ops::Range;

use crate::axis::{Axis, Scale as Along};
use crate::canvas::render;
use crate::drawing::{BLACK, Drawing, Fill, Line, Place, Rgb, Shape};
use crate::font::width;
use crate::format::PlotError;
use crate::frame::{Frame, below, left_of};
use crate::markers;
use crate::page::Page;
use crate::palette::LINES;
use crate::strokes::thinned;
use crate::words::Heading;

/// A picture of panels side by side.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Curves {
    /// Line above the panels.
    pub title: String,
    /// The panels, row by row.
    pub panes: Vec<Pane>,
    /// Panels in a row; fewer on a page that has no room for them.
    pub columns: usize,
    /// Width and height of a panel on a screen, its legend included.
    pub pane: (u32, u32),
    /// Lines above the rows, if there are any.
    pub headings: Vec<String>,
    /// Panels share their axes, so that they can be compared, and the legend of the first one.
    pub shared: bool,
}

/// One panel.
#[derive(Debug, Clone, PartialEq, Default)]
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
#[derive(Debug, Clone, PartialEq, Default)]
pub enum Scale {
    /// Linear, from the data.
    #[default]
    Linear,
    /// Linear with these ends; what lies beyond is not seen.
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

/// Sizes of the title and of captions against that of legends.
const TITLE: f64 = 1.2;
pub(crate) const CAPTION: f64 = 1.07;

/// In em: the air about all, the height of a row of a legend, the length of its samples and the air beside them.
pub(crate) const EDGE: f64 = 0.8;
const LEGEND_ROW: f64 = 1.6;
const SAMPLE: f64 = 2.3;
const BESIDE: f64 = 0.5;
const BETWEEN: f64 = 1.5;
/// Air at the right of a panel, for half a tick's words.
const RIGHT: f64 = 1.5;

/// The least width and height of a panel, in em.
const NARROW: f64 = 22.0;
const LOW: f64 = 16.0;

/// A panel's width to its height at least, in em, of what is left for the curves.
const LEAST_BODY: f64 = 7.0;

/// Dashes and gaps of lines, on a screen.
const DASH: [f64; 2] = [8.0, 5.0];

/// The bytes of the picture.
///
/// # Errors
/// [`PlotError`].
pub fn curves_picture(picture: &Curves, page: impl Into<Page>) -> Result<Vec<u8>, PlotError> {
    let page = page.into();
    render(&draw(picture, &page), &page)
}

fn draw(picture: &Curves, page: &Page) -> Drawing {
    let em = page.font;
    let mut columns = picture.columns.clamp(1, picture.panes.len().max(1));
    let all = page.width.unwrap_or(page.px(f64::from(picture.pane.0) * columns as f64));
    // A heading is of as many panels as stand in a row where there is room.
    let headed = columns;
    columns = columns.min((all / (NARROW * em)) as usize).max(1);
    let wide = all / columns as f64;
    let title = Heading::new(&picture.title, all - 2.0 * EDGE * em, TITLE * em);
    let top = if picture.title.is_empty() { 0.5 * EDGE * em } else { 1.5 * EDGE * em + title.height() };

    let shared = picture.shared.then(|| Shared::of(&picture.panes));
    let key = shared.as_ref().map_or(0.0, |shared| Legend::of(&shared.named, all - 2.0 * EDGE * em, em).height());
    let low = wide * f64::from(picture.pane.1) / f64::from(picture.pane.0.max(1));
    let rows: Vec<Row<'_>> = picture
        .panes
        .chunks(headed)
        .enumerate()
        .flat_map(|(i, group)| group.chunks(columns).enumerate().map(move |(j, panes)| (i, j, panes)))
        .map(|(i, j, panes)| Row {
            panes,
            first: i * headed + j * columns,
            heading: (j == 0)
                .then(|| picture.headings.get(i))
                .flatten()
                .map(|text| Heading::new(text, all - 2.0 * EDGE * em, 1.13 * em)),
            width: wide,
            low,
            shared: shared.as_ref(),
        })
        .collect();
    let height = top + key + rows.iter().map(|row| row.height(page)).sum::<f64>();
    let mut drawing = Drawing::new([all, height], &picture.title);
    title.draw(&mut drawing, [EDGE * em, EDGE * em], BLACK);
    if let Some(shared) = &shared {
        Legend::of(&shared.named, all - 2.0 * EDGE * em, em).draw(&mut drawing, [EDGE * em, top], page);
    }
    // Panels below each other stand on one line.
    let left = rows.iter().map(|row| row.left(page)).fold(0.0, f64::max);
    let mut y = top + key;
    for row in rows {
        row.draw(&mut drawing, y, left, page);
        y += row.height(page);
    }
    drawing
}

fn colour(index: usize) -> Rgb {
    LINES[index % LINES.len()]
}

/// What panels that can be compared have in common.
struct Shared<'a> {
    x: Axis,
    y: Axis,
    named: Vec<&'a Series>,
}

impl<'a> Shared<'a> {
    fn of(panes: &'a [Pane]) -> Self {
        let axes: Vec<(Axis, Axis)> = panes.iter().map(axes).collect();
        let union = |axes: &mut dyn Iterator<Item = &Axis>| {
            let all = axes.cloned().reduce(|one, other| Axis {
                range: one.range.start.min(other.range.start)..one.range.end.max(other.range.end),
                scale: one.scale,
            });
            all.unwrap_or_else(|| Axis::numbers(0.0..1.0))
        };
        let (x, y) = (union(&mut axes.iter().map(|axes| &axes.0)), union(&mut axes.iter().map(|axes| &axes.1)));
        let first = panes.first().map_or(&[] as &[Series], |pane| &pane.series);
        Self { x, y, named: first.iter().filter(|series| !series.name.is_empty()).collect() }
    }
}

/// The entries of a legend, in as many rows as they need.
struct Legend<'a> {
    /// Row, place from the left, and what it tells of.
    entries: Vec<(usize, f64, &'a Series)>,
    rows: usize,
    em: f64,
}

impl<'a> Legend<'a> {
    fn of(series: &[&'a Series], room: f64, em: f64) -> Self {
        let (mut x, mut row, mut entries) = (0.0, 0, Vec::new());
        for entry in series {
            let wide = (SAMPLE + BESIDE + width(&entry.name)) * em;
            if x > 0.0 && x + wide > room {
                (x, row) = (0.0, row + 1);
            }
            entries.push((row, x, *entry));
            x += wide + BETWEEN * em;
        }
        let rows = if entries.is_empty() { 0 } else { row + 1 };
        Self { entries, rows, em }
    }

    fn height(&self) -> f64 {
        LEGEND_ROW * self.em * self.rows as f64
    }

    fn draw(&self, drawing: &mut Drawing, [left, top]: Place, page: &Page) {
        let em = self.em;
        for (row, x, series) in &self.entries {
            let (x, y) = (left + x, top + (*row as f64 + 0.5) * LEGEND_ROW * em);
            if let Some(line) = stroke(series, page) {
                drawing.line(vec![[x, y], [x + SAMPLE * em, y]], line);
            }
            mark(drawing, series, [x + 0.5 * SAMPLE * em, y], page);
            drawing.words(&series.name, [x + (SAMPLE + BESIDE) * em, y], em, BLACK);
        }
    }
}

/// Panels side by side. They share the height of captions and legends, so that their axes stand level.
struct Row<'a> {
    panes: &'a [Pane],
    /// Number of the first panel.
    first: usize,
    heading: Option<Heading>,
    /// Of a panel: its width, and its height where its legend is short.
    width: f64,
    low: f64,
    shared: Option<&'a Shared<'a>>,
}

impl Row<'_> {
    fn axes(&self, pane: &Pane) -> (Axis, Axis) {
        match self.shared {
            Some(shared) => (shared.x.clone(), shared.y.clone()),
            None => axes(pane),
        }
    }

    fn left(&self, page: &Page) -> f64 {
        let of = |pane: &Pane| left_of(&self.axes(pane).1, !pane.y.is_empty(), 0.7 * self.low, page);
        self.panes.iter().map(of).fold(0.0, f64::max) + 0.3 * page.font
    }

    fn caption(&self, i: usize, page: &Page) -> Heading {
        let caption = &self.panes[i].caption;
        let text = match (page.letters, u8::try_from(self.first + i)) {
            (true, Ok(number @ 0..26)) => format!("({}) {caption}", char::from(b'a' + number)),
            _ => caption.clone(),
        };
        Heading::new(&text, self.width - (EDGE + RIGHT) * page.font, CAPTION * page.font)
    }

    fn captions(&self, page: &Page) -> f64 {
        let highest = (0..self.panes.len()).map(|i| self.caption(i, page).height()).fold(0.0, f64::max);
        if highest > 0.0 { highest + 0.3 * page.font } else { 0.0 }
    }

    fn legend<'p>(&self, pane: &'p Pane, page: &Page) -> Legend<'p> {
        let shared = self.shared.is_some();
        let named: Vec<&Series> = pane.series.iter().filter(|series| !shared && !series.name.is_empty()).collect();
        Legend::of(&named, self.width - (EDGE + RIGHT) * page.font, page.font)
    }

    fn legends(&self, page: &Page) -> f64 {
        self.panes.iter().map(|pane| self.legend(pane, page).height()).fold(0.0, f64::max)
    }

    fn heading(&self, page: &Page) -> f64 {
        self.heading.as_ref().map_or(0.0, |heading| heading.height() + 0.7 * page.font)
    }

    fn height(&self, page: &Page) -> f64 {
        let em = page.font;
        let about = self.captions(page) + self.legends(page) + below(true, page);
        self.heading(page) + self.low.max(LOW * em).max(about + LEAST_BODY * em) + 0.3 * em
    }

    fn draw(&self, drawing: &mut Drawing, y: f64, left: f64, page: &Page) {
        let em = page.font;
        if let Some(heading) = &self.heading {
            heading.draw(drawing, [EDGE * em, y + 0.4 * em], BLACK);
        }
        let bottom = y + self.height(page) - 0.3 * em;
        let head = y + self.heading(page);
        for (i, pane) in self.panes.iter().enumerate() {
            let from = i as f64 * self.width;
            // Words may begin left of the panel: there is nothing else above it.
            let words = from + left.min(EDGE * em);
            self.caption(i, page).draw(drawing, [words, head], BLACK);
            let top = head + self.captions(page);
            self.legend(pane, page).draw(drawing, [words, top], page);
            let corners = [
                [page.snap(from + left), page.snap(top + self.legends(page) + 0.5 * em)],
                [page.snap(from + self.width - RIGHT * em), page.snap(bottom - below(!pane.x.is_empty(), page))],
            ];
            let (x, y) = self.axes(pane);
            pane.draw(drawing, Frame { corners, x, y }, page);
        }
    }
}

/// A panel in a box of its own, its legend above its axes: with what stands about it.
pub(crate) fn draw_pane(
    drawing: &mut Drawing,
    pane: &Pane,
    [[left, top], [right, bottom]]: [Place; 2],
    inner: f64,
    page: &Page,
) {
    let row = Row {
        panes: std::slice::from_ref(pane),
        first: 0,
        heading: None,
        width: right - left,
        low: bottom - top,
        shared: None,
    };
    let legend = row.legend(pane, page);
    legend.draw(drawing, [inner, top], page);
    let corners = [
        [page.snap(inner), page.snap(top + legend.height() + 0.5 * page.font)],
        [page.snap(right), page.snap(bottom - below(!pane.x.is_empty(), page))],
    ];
    let (x, y) = axes(pane);
    pane.draw(drawing, Frame { corners, x, y }, page);
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
fn axes(pane: &Pane) -> (Axis, Axis) {
    let points = || pane.series.iter().flat_map(|series| series.points.iter().copied());
    let x = pane.x_range.clone().unwrap_or_else(|| padded(points().map(|point| point.0)));
    let visible = points().filter(|point| x.contains(&point.0)).map(|point| point.1);
    let y = match &pane.scale {
        Scale::Logarithmic => Axis::decades(visible.filter(|y| *y > 0.0 && y.is_finite()).map(f64::log10)),
        Scale::Between(range) => Axis::numbers(range.clone()),
        Scale::Linear => Axis::numbers(padded(visible.chain(pane.levels.iter().copied()))),
    };
    let scale = if pane.x_log { Along::Powers } else { Along::Numbers };
    (Axis { range: x, scale }, y)
}

fn stroke(series: &Series, page: &Page) -> Option<Line> {
    let line = |wide: u32| Line::new(colour(series.colour), page.px(f64::from(wide)));
    match series.stroke {
        Stroke::None => None,
        Stroke::Solid(wide) => Some(line(wide)),
        Stroke::Dashed(wide) => Some(line(wide).dashed(page.px(DASH[0]), page.px(DASH[1]))),
    }
}

fn mark(drawing: &mut Drawing, series: &Series, at: Place, page: &Page) {
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
    fn draw(&self, drawing: &mut Drawing, mut frame: Frame, page: &Page) {
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
        let logarithmic = frame.y.scale == Along::Decades;
        for &level in self.levels.iter().filter(|level| !logarithmic || **level > 0.0) {
            let level = if logarithmic { level.log10() } else { level };
            if (0.0..=1.0).contains(&frame.y.part(level)) {
                frame.level(drawing, level, page);
            }
        }
        let place = |&(x, y): &(f64, f64)| {
            let y = if logarithmic { y.log10() } else { y };
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::format::Format;

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
            let picture =
                Curves { title: "γ₂".to_owned(), panes, columns: 2, pane: (500, 360), ..Curves::default() };
            let svg = String::from_utf8(curves_picture(&picture, Format::Svg).unwrap()).unwrap();
            assert!(svg.contains("γ₂") && svg.contains("growth") && !svg.contains("NaN") && !svg.contains("inf"));
            assert!(curves_picture(&picture, Format::Png).unwrap().starts_with(b"\x89PNG"));
            assert!(curves_picture(&picture, Format::Pdf).unwrap().starts_with(b"%PDF"));
        }
    }

    #[test]
    fn a_legend_breaks_into_rows_where_the_panel_ends() {
        let entries: Vec<_> = (0..5).map(|i| series(&format!("a name of some length {i}"), Vec::new())).collect();
        let entries: Vec<&Series> = entries.iter().collect();
        let legend = Legend::of(&entries, 500.0, 15.0);
        assert_eq!((legend.entries.len(), legend.rows), (5, 3));
        assert!(legend.entries.iter().all(|(_, x, _)| *x < 500.0) && Legend::of(&[], 600.0, 15.0).rows == 0);
    }

    /// A column of a journal has no room for three panels side by side, and its letters stay readable.
    #[test]
    fn a_narrow_page_has_fewer_panels_in_a_row() {
        let panes = vec![pane(Scale::Linear, vec![series("one", vec![(0.0, 1.0), (1.0, 2.0)])]); 3];
        let picture = Curves { panes, columns: 3, pane: (480, 440), ..Curves::default() };
        let on = |page: Page| draw(&picture, &page).size;
        let [wide, low] = on(Page::from(Format::Svg));
        assert!((wide - 1440.0).abs() < 1e-9 && low < 600.0);
        let [wide, high] = on(crate::page::Purpose::Column.page(Format::Pdf));
        assert!((wide - 86.0 * crate::page::MILLIMETRE).abs() < 1e-9 && high > 1.5 * wide, "{wide} {high}");
    }

    #[test]
    fn letters_name_the_panels_and_shared_axes_are_one() {
        let panes = vec![
            pane(Scale::Logarithmic, vec![series("one", vec![(0.0, 1.0), (1.0, 2.0)])]),
            pane(Scale::Logarithmic, vec![series("one", vec![(5.0, 1e-6), (9.0, 1e3)])]),
        ];
        let picture = Curves { panes, columns: 2, pane: (480, 440), shared: true, ..Curves::default() };
        let page = Page { letters: true, ..Page::from(Format::Svg) };
        let svg = String::from_utf8(curves_picture(&picture, page).unwrap()).unwrap();
        assert!(svg.contains("aria-label=\"(a) caption\"") && svg.contains("aria-label=\"(b) caption\""));
        assert_eq!(svg.matches("aria-label=\"one\"").count(), 1);
        assert_eq!(svg.matches("aria-label=\"10⁻⁶\"").count(), 2);
    }
}
