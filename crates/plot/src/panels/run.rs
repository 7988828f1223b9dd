//! The picture of a simulated run: the impacting mass over the analytic orbit, and all masses in space and time.

use crate::axes::frame::name_of;
use crate::backend::canvas::render;
use crate::backend::drawing::Drawing;
use crate::backend::format::PlotError;
use crate::backend::page::Page;
use crate::panels::curves::{Pane, Scale, Series, Stroke};
use crate::panels::draw_pane;
use crate::panels::field::Field;
use crate::panels::spacetime::{BAR, Panel, WIDTH};
use crate::text::headings::{HEADING, Title};

/// What is drawn.
#[derive(Debug, Clone, PartialEq)]
pub struct RunPicture {
    /// Line above the panels.
    pub title: String,
    /// Positions of the two barriers.
    pub barriers: (f64, f64),
    /// The impacting mass as simulated: (time in periods since the start, displacement).
    pub simulated: Vec<(f64, f64)>,
    /// The same on the analytic orbit; empty if there is none.
    pub analytic: Vec<(f64, f64)>,
    /// All masses.
    pub field: Field,
    /// Length of the run in periods of the force.
    pub periods: f64,
}

/// Heights of the two panels for the width of a screen.
const TRACE: f64 = 380.0;
const FIELD: f64 = 480.0;

/// What stands above and below the upper panel on a narrow page, in em: a legend of two rows, ticks and a name.
const ABOUT: f64 = 8.0;

/// The bytes of the picture.
///
/// # Errors
/// [`PlotError`].
pub fn run_picture(picture: &RunPicture, page: impl Into<Page>) -> Result<Vec<u8>, PlotError> {
    let page = page.into();
    let (em, wide) = (page.font, page.width.unwrap_or(page.px(WIDTH)));
    let title = Title::new(&picture.title, HEADING, wide, em);
    let top = title.foot();
    let middle = top + (wide * TRACE / WIDTH).max(15.0 * em);
    let bottom = middle + (wide * FIELD / WIDTH).max(15.0 * em);
    let mut drawing = Drawing::new([wide, bottom + 0.5 * em], &picture.title);
    title.draw(&mut drawing);
    let RunPicture { field, barriers, periods, .. } = picture;
    let x = "time in periods (whole run)";
    let panel = Panel { field, barriers: *barriers, periods: *periods, x, impacts: &[] };
    // Both panels begin where ticks of the one and the name of the other have room; less its legend and ticks, the upper one is so high.
    let (pane, high) = (picture.trace(), middle - top - ABOUT * em);
    let named = panel.ticks(bottom - middle, &page) + name_of(&pane.y, high, &page) + 0.6 * em;
    let left = panel.left(bottom - middle, &page).max(named);
    let trace = [[left, top], [wide - BAR * em, middle - 0.8 * em]];
    draw_pane(&mut drawing, &pane, trace, [left, panel.ticks(bottom - middle, &page)], &page);
    panel.draw(&mut drawing, [[left, middle], [wide, bottom]], &page);
    render(&drawing, &page)
}

impl RunPicture {
    fn trace(&self) -> Pane {
        let (lower, upper) = self.barriers;
        let pane = run_trace("impacting mass u₀", &self.simulated, &self.analytic, vec![lower, upper]);
        Pane { scale: Scale::Between(lower - 0.15..upper + 0.15), ..pane }
    }
}

/// What is hit at the end of a run, over the orbit that the run began on if there is one: places over periods since the start.
pub fn run_trace(y: &str, simulated: &[(f64, f64)], analytic: &[(f64, f64)], levels: Vec<f64>) -> Pane {
    let first = simulated.first().map_or(0.0, |point| point.0);
    let last = simulated.last().map_or(1.0, |point| point.0).max(first + 1e-9);
    let series = [("analytic orbit", analytic, 1, 6), ("simulation", simulated, 0, 2)];
    let drawn = series.into_iter().filter(|(_, points, ..)| !points.is_empty());
    let lines = drawn.map(|(name, points, colour, wide): (&str, &[(f64, f64)], _, _)| {
        Series::line(name, colour, Stroke::Solid(wide), points.iter().copied())
    });
    let pane = Pane::titled("", "time in periods (end of the run)", y, lines.collect());
    Pane { x_range: Some(first..last), levels, ..pane }
}
