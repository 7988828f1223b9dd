//! Panels side by side and below each other: one drawing for all figures that are not maps.

pub(crate) mod curves;
pub mod field;
pub(crate) mod orbit;
pub(crate) mod pane;
pub(crate) mod run;
pub(crate) mod spacetime;

use crate::axes::axis::Axis;
use crate::axes::frame::{Frame, below, name_of, ticks_of};
use crate::axes::legend::Legend;
use crate::backend::canvas::render;
use crate::backend::drawing::{BLACK, Drawing, Place};
use crate::backend::format::PlotError;
use crate::backend::page::Page;
use crate::panels::curves::{Curves, Pane, Series};
use crate::panels::pane::axes;
use crate::text::headings::{CAPTION, EDGE, HEADING, Heading, TITLE, Title, capital};

/// Air at the right of a panel, for half a tick's words, in em.
const RIGHT: f64 = 1.5;

/// The least width and height of a panel, in em: three or four ticks with their words.
const NARROW: f64 = 22.0;
const LOW: f64 = 16.0;

/// What is left for the curves at least, in em: below that a panel is all legend.
const LEAST_BODY: f64 = 10.0;

/// Air above a row's own words, in em, or they seem to belong to the legend or the row above.
const APART: f64 = 0.7;

/// The bytes of the picture.
///
/// # Errors
/// [`PlotError`].
pub fn curves_picture(picture: &Curves, page: impl Into<Page>) -> Result<Vec<u8>, PlotError> {
    let page = page.into();
    render(&draw(picture, &page), &page)
}

/// Width and height that such a picture has, in units.
pub(crate) fn curves_size(picture: &Curves, page: &Page) -> [f64; 2] {
    draw(picture, page).size
}

fn draw(picture: &Curves, page: &Page) -> Drawing {
    let em = page.font;
    let mut columns = picture.columns.clamp(1, picture.panes.len().max(1));
    let all = page.width.unwrap_or(page.px(f64::from(picture.pane.0) * columns as f64));
    // A heading is of as many panels as stand in a row where there is room.
    let headed = columns;
    columns = columns.min((all / (NARROW * em)) as usize).max(1);
    let wide = all / columns as f64;
    let title = Title::new(&picture.title, TITLE, all, em);
    let top = title.foot();
    let shared = picture.shared.then(|| Shared::of(&picture.panes));
    let one_legend = picture.one_legend || picture.shared;
    let named = if one_legend { named(&picture.panes) } else { Vec::new() };
    let key = Legend::of(&named, all - 2.0 * EDGE * em, em);
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
                .then(|| picture.headings.get(i).filter(|heading| !heading.is_empty()))
                .flatten()
                .map(|text| Heading::new(&capital(text), all - 2.0 * EDGE * em, HEADING * em)),
            width: wide,
            low,
            shared: shared.as_ref(),
            one_legend,
        })
        .collect();
    let mut gaps = Vec::new();
    for row in &rows {
        let is_below = !gaps.is_empty() || key.height() > 0.0;
        let has_words = row.heading(page) + row.captions(page) > 0.0;
        gaps.push(if is_below && has_words { APART * em } else { 0.0 });
    }
    let height = top + key.height() + rows.iter().zip(&gaps).map(|(row, gap)| gap + row.height(page)).sum::<f64>();
    let mut drawing = Drawing::new([all, height], &picture.title);
    title.draw(&mut drawing);
    key.draw(&mut drawing, [EDGE * em, top], page);
    // Panels below each other stand on one line.
    let [ticks, names] =
        rows.iter().map(|row| row.left(page)).fold([0.0; 2], |most, one| [0, 1].map(|i| f64::max(most[i], one[i])));
    let left = [ticks + names + 0.6 * em, ticks];
    let mut y = top + key.height();
    for (row, gap) in rows.iter().zip(gaps) {
        y += gap;
        row.draw(&mut drawing, y, left, page);
        y += row.height(page);
    }
    drawing
}

/// What panels that can be compared have in common.
struct Shared {
    x: Axis,
    y: Axis,
}

impl Shared {
    fn of(panes: &[Pane]) -> Self {
        let axes: Vec<(Axis, Axis)> = panes.iter().map(axes).collect();
        let union = |axes: &mut dyn Iterator<Item = &Axis>| {
            let all = axes.cloned().reduce(|one, other| Axis {
                range: one.range.start.min(other.range.start)..one.range.end.max(other.range.end),
                scale: one.scale,
            });
            all.unwrap_or_else(|| Axis::numbers(0.0..1.0))
        };
        let (x, y) = (union(&mut axes.iter().map(|axes| &axes.0)), union(&mut axes.iter().map(|axes| &axes.1)));
        Self { x, y }
    }
}

/// What panels have names for, each once.
fn named(panes: &[Pane]) -> Vec<&Series> {
    let mut named: Vec<&Series> = Vec::new();
    for series in panes.iter().flat_map(|pane| &pane.series).filter(|series| !series.name.is_empty()) {
        if named.iter().all(|other| other.name != series.name) {
            named.push(series);
        }
    }
    named
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
    shared: Option<&'a Shared>,
    /// The legend stands above all rows.
    one_legend: bool,
}

impl Row<'_> {
    fn axes(&self, pane: &Pane) -> (Axis, Axis) {
        match self.shared {
            Some(shared) => (shared.x.clone(), shared.y.clone()),
            None => axes(pane),
        }
    }

    /// Widths of the ticks and names of vertical axes.
    fn left(&self, page: &Page) -> [f64; 2] {
        let high = self.height(page) - self.heading(page) - self.captions(page) - self.legends(page) - 0.8 * page.font;
        let of = |pane: &Pane| {
            let length = high - below(!pane.x.is_empty(), page);
            [ticks_of(&self.axes(pane).1, length, page), name_of(&pane.y, length, page)]
        };
        self.panes.iter().map(of).fold([0.0; 2], |most, one| [most[0].max(one[0]), most[1].max(one[1])])
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
        let is_own = |series: &&Series| !self.one_legend && !series.name.is_empty();
        let own: Vec<&Series> = pane.series.iter().filter(is_own).collect();
        Legend::of(&own, self.width - (EDGE + RIGHT) * page.font, page.font)
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

    fn draw(&self, drawing: &mut Drawing, y: f64, [left, ticks]: [f64; 2], page: &Page) {
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
            pane.draw(drawing, Frame { corners, x, y, ticks }, page);
        }
    }
}

/// A panel in a box of its own, its legend above its axes: with what stands about it.
pub(crate) fn draw_pane(
    drawing: &mut Drawing,
    pane: &Pane,
    [[left, top], [right, bottom]]: [Place; 2],
    [inner, ticks]: [f64; 2],
    page: &Page,
) {
    let row = Row {
        panes: std::slice::from_ref(pane),
        first: 0,
        heading: None,
        width: right - left,
        low: bottom - top,
        shared: None,
        one_legend: false,
    };
    let legend = row.legend(pane, page);
    legend.draw(drawing, [inner, top], page);
    let corners = [
        [page.snap(inner), page.snap(top + legend.height() + 0.5 * page.font)],
        [page.snap(right), page.snap(bottom - below(!pane.x.is_empty(), page))],
    ];
    let (x, y) = axes(pane);
    pane.draw(drawing, Frame { corners, x, y, ticks }, page);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::backend::format::Format;
    use crate::panels::curves::{Mark, Scale, Stroke};

    fn series(name: &str, points: Vec<(f64, f64)>) -> Series {
        Series { name: name.to_owned(), colour: 1, stroke: Stroke::Dashed(2), mark: Mark::Hollow(3), points }
    }

    fn pane(scale: Scale, series: Vec<Series>) -> Pane {
        let (caption, x, y) = ("caption".to_owned(), "ω".to_owned(), "u₀".to_owned());
        Pane { caption, x, y, scale, levels: vec![0.5], uprights: vec![1.0], series, ..Pane::default() }
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

    /// A column of a journal has no room for three panels side by side, and its letters stay readable.
    #[test]
    fn a_narrow_page_has_fewer_panels_in_a_row() {
        let panes = vec![pane(Scale::Linear, vec![series("one", vec![(0.0, 1.0), (1.0, 2.0)])]); 3];
        let picture = Curves { panes, columns: 3, pane: (480, 440), ..Curves::default() };
        let on = |page: Page| draw(&picture, &page).size;
        let [wide, low] = on(Page::from(Format::Svg));
        assert!((wide - 1440.0).abs() < 1e-9 && low < 600.0);
        let [wide, high] = on(crate::backend::page::Purpose::Column.page(Format::Pdf));
        assert!((wide - 86.0 * crate::backend::page::MILLIMETRE).abs() < 1e-9 && high > 1.5 * wide, "{wide} {high}");
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
