//! All masses in space and time, as colours.

use crate::axes::axis::{Axis, tick};
use crate::axes::frame::{Frame, TICK, below, left_of, ticks_of};
use crate::backend::canvas::render;
use crate::backend::drawing::{BLACK, Drawing, Line, Place, Rgb, WHITE};
use crate::backend::format::PlotError;
use crate::backend::page::Page;
use crate::map::key::colour_bar;
use crate::panels::field::{Field, FieldValue};
use crate::text::headings::{HEADING, Title};

/// Width and height on a screen.
pub(crate) const WIDTH: f64 = 1200.0;
const HEIGHT: f64 = 520.0;

/// Room for the colours' bar, in em, with its words.
pub(crate) const BAR: f64 = 9.6;

/// What no mass has been simulated for.
const NOTHING: Rgb = [225, 225, 225];

/// The colour of a displacement, −1 to 1: blue below rest, white at it, vermilion above; in grey the sign is lost, the size is not.
pub fn diverging(x: f64) -> Rgb {
    let (x, end) = (x.clamp(-1.0, 1.0), if x < 0.0 { [16.0, 50.0, 98.0] } else { [176.0, 58.0, 0.0] });
    end.map(|c| (255.0 + (c - 255.0) * x.abs()) as u8)
}

/// All masses of an orbit over one period.
#[derive(Debug, Clone, PartialEq)]
pub struct Spacetime {
    /// Line above the panel.
    pub title: String,
    /// Positions of the two barriers.
    pub barriers: (f64, f64),
    /// Displacements; its time is counted in periods of the orbit.
    pub field: Field,
    /// The impacts: time in periods, site through all layers.
    pub impacts: Vec<(f64, usize)>,
}

/// The bytes of the picture.
///
/// # Errors
/// [`PlotError`].
pub fn spacetime_picture(picture: &Spacetime, page: impl Into<Page>) -> Result<Vec<u8>, PlotError> {
    let page = page.into();
    let (em, wide) = (page.font, page.width.unwrap_or(page.px(WIDTH)));
    let title = Title::new(&picture.title, HEADING, wide, em);
    let top = title.foot();
    let bottom = top + (wide * HEIGHT / WIDTH).max(16.0 * em);
    let mut drawing = Drawing::new([wide, bottom + 0.5 * em], &picture.title);
    title.draw(&mut drawing);
    let Spacetime { barriers, field, impacts, .. } = picture;
    let panel = Panel { field, barriers: *barriers, periods: 1.0, x: "time in periods (rings: impacts)", impacts };
    let left = panel.left(bottom - top, &page);
    panel.draw(&mut drawing, [[left, top], [wide, bottom]], &page);
    render(&drawing, &page)
}

/// A field with its axes and its colours.
pub(crate) struct Panel<'a> {
    pub(crate) field: &'a Field,
    pub(crate) barriers: (f64, f64),
    pub(crate) periods: f64,
    pub(crate) x: &'static str,
    pub(crate) impacts: &'a [(f64, usize)],
}

impl Panel<'_> {
    fn y(&self) -> Axis {
        let low = self.field.lowest as f64 - 0.5;
        Axis::numbers(low..low + self.field.sites as f64)
    }

    fn name(&self) -> &'static str {
        match (self.field.lowest < 0, self.field.length < self.field.sites) {
            (true, _) => "site, from site 0",
            (false, false) => "site",
            (false, true) => "site, layer upon layer",
        }
    }

    /// The width of its vertical ticks.
    pub(crate) fn ticks(&self, height: f64, page: &Page) -> f64 {
        ticks_of(&self.y(), height, page)
    }

    /// Where its box begins.
    pub(crate) fn left(&self, height: f64, page: &Page) -> f64 {
        left_of(&self.y(), self.name(), height, page) + 0.3 * page.font
    }

    /// Draws it from the left edge of its box to the right end of the picture, ticks and names below included.
    pub(crate) fn draw(&self, drawing: &mut Drawing, [[left, top], [right, bottom]]: [Place; 2], page: &Page) {
        let Field { sites, lowest, length, .. } = self.field;
        let (em, periods) = (page.font, self.periods.max(1e-9));
        let corners =
            [[page.snap(left), page.snap(top)], [page.snap(right - BAR * em), page.snap(bottom - below(true, page))]];
        let frame = Frame { corners, x: Axis::numbers(0.0..periods), y: self.y(), ticks: 0.0 };
        let pixels = page.pixels(frame.size());
        drawing.image(corners, pixels, self.raster(pixels));
        for border in (*length..*sites).step_by(*length) {
            let y = frame.place((0.0, (*lowest + border as i64) as f64 - 0.5))[1];
            drawing.line(vec![[corners[0][0], y], [corners[1][0], y]], Line::new(BLACK, page.px(2.0)).crisp());
        }
        for &(time, site) in self.impacts {
            // Around a circle: the picture begins with the site at its lower edge.
            let row = (site as i64 - lowest).rem_euclid(*sites as i64) + lowest;
            let at = frame.place((time, row as f64));
            drawing.circle(at, page.px(6.0), Some(WHITE), Some(Line::new(BLACK, page.px(2.0))));
            drawing.circle(at, page.px(2.0), Some(BLACK), None);
        }
        frame.axes(drawing, [self.x, self.name()], page);
        self.bar(drawing, [corners[1][0] + 1.2 * em, corners[0][1]], frame.size()[1], page);
    }

    fn raster(&self, [w, h]: [u32; 2]) -> Vec<u8> {
        let Field { shown, columns: values, spacing, covered, .. } = self.field;
        // Rest is white, and what is as far from it as the farther barrier has full colour.
        let full = if *shown == FieldValue::Displacement { self.farther() } else { 1.0 };
        let mut pixels = Vec::with_capacity(3 * (w * h) as usize);
        for py in 0..h {
            for px in 0..w {
                let time = (f64::from(px) + 0.5) / f64::from(w) * self.periods;
                // What is left after the last column has none of its own.
                let index = ((time / spacing) as usize).min(values.len().saturating_sub(1));
                let column = values.get(index).filter(|_| time <= *covered);
                // The largest offset is on top.
                let value =
                    column.and_then(|column| column.get(column.len() - 1 - py as usize * column.len() / h as usize));
                pixels.extend(value.map_or(NOTHING, |u| diverging(u / full)));
            }
        }
        pixels
    }

    /// The distance of the farther barrier from rest.
    fn farther(&self) -> f64 {
        self.barriers.0.abs().max(self.barriers.1.abs())
    }

    /// What the colours mean, from a place down.
    fn bar(&self, drawing: &mut Drawing, [x, top]: Place, room: f64, page: &Page) {
        let (em, (lower, upper)) = (page.font, self.barriers);
        let names = self.names();
        let height = (13.0 * em).min(room - 1.4 * em * names.len() as f64).max(4.0 * em);
        let right = x + 1.2 * em;
        // From barrier to barrier, with rest between.
        let (ends, middle, full) = match self.field.shown {
            FieldValue::Displacement => ([lower, upper], 0.0, self.farther()),
            FieldValue::Amplitude => ([0.0, 1.0], 0.5, 1.0),
        };
        let length = ends[1] - ends[0];
        let colour = |part: f64| diverging((ends[0] + part * length) / full);
        colour_bar(drawing, [[x, top], [right, top + height]], colour, page);
        // Words at the ends stand within the bar; that of rest gives way where a barrier is next to it.
        let place = |value: f64| (ends[1] - value) / length;
        let room = 1.2 * TICK * em / height;
        let between = Some((middle, place(middle))).filter(|(_, part)| (room..=1.0 - room).contains(part));
        for (label, part) in [(ends[1], 0.04), (ends[0], 0.96)].into_iter().chain(between) {
            drawing.words(&tick(label), [right + 0.5 * em, top + part * height], TICK * em, BLACK);
        }
        for (i, line) in names.iter().enumerate() {
            drawing.words(line, [x, top + height + (1.0 + 1.3 * i as f64) * em], 0.88 * em, BLACK);
        }
    }

    /// What the colours of the field mean.
    fn names(&self) -> Vec<String> {
        let Field { shown, sites, columns, spacing, .. } = self.field;
        let mut lines = match shown {
            FieldValue::Displacement => vec!["displacement u".to_owned()],
            FieldValue::Amplitude if *spacing == 1.0 => {
                vec!["(max u − min u)/2".to_owned(), "in each period".to_owned()]
            }
            FieldValue::Amplitude => vec!["(max u − min u)/2".to_owned(), format!("in {spacing} periods")],
        };
        let rows = columns.first().map_or(0, Vec::len);
        if rows < *sites {
            let masses = sites.div_ceil(rows.max(1));
            lines.extend([format!("largest of {masses}"), "masses".to_owned()]);
        }
        lines
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// With barriers at −0.6 and 1.4 a mass at rest is white, not one in the middle of the gap; equal distances from rest have equal
    /// strength.
    #[test]
    fn rest_is_white_and_the_farther_barrier_has_full_colour() {
        let columns = vec![vec![0.0, 1.4, 0.4, -0.4]];
        let shown = FieldValue::Displacement;
        let field = Field { shown, sites: 4, lowest: 0, length: 4, columns, spacing: 1.0, covered: 1.0 };
        let panel = Panel { field: &field, barriers: (-0.6, 1.4), periods: 1.0, x: "", impacts: &[] };
        let pixels = panel.raster([1, 4]);
        let [low, some, full, rest] = [0, 1, 2, 3].map(|row| [0, 1, 2].map(|k| pixels[3 * row + k]));
        assert_eq!((rest, full), ([255; 3], diverging(1.0)));
        let depth = |colour: Rgb, end: Rgb| f64::from(255 - colour[0]) / f64::from(255 - end[0]);
        assert!((depth(low, diverging(-1.0)) - 0.4 / 1.4).abs() < 0.01, "{low:?}");
        assert!((depth(some, diverging(1.0)) - 0.4 / 1.4).abs() < 0.02, "{some:?}");
    }
}
