//! The picture of a simulated run: the impacting mass over the analytic orbit, and all masses in space and time.

use plotters::chart::LabelAreaPosition;
use plotters::coord::Shift;
use plotters::element::{PathElement, Text};
use plotters::prelude::{
    BLACK, ChartBuilder, Color, DrawingArea, DrawingBackend, IntoFont, LineSeries, RGBColor, WHITE,
};

use crate::axes::{axes, barriers, legend};
use crate::canvas::{Drawing, Format, PlotError, render};
use crate::field::Field;
use crate::spacetime::{LEFT, Panel, RIGHT};

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

const WIDTH: u32 = 1200;
const TRACE: u32 = 380;
const FIELD: u32 = 420;

/// The bytes of the picture.
///
/// # Errors
/// [`PlotError`].
pub fn run_picture(picture: &RunPicture, format: Format) -> Result<Vec<u8>, PlotError> {
    render(&Sheet { picture }, format, (WIDTH, 40 + TRACE + FIELD + 90))
}

struct Sheet<'a> {
    picture: &'a RunPicture,
}

impl Drawing for Sheet<'_> {
    fn draw<B: DrawingBackend>(&self, area: &DrawingArea<B, Shift>) -> Result<(), PlotError> {
        area.fill(&WHITE).map_err(PlotError::from)?;
        let heading = ("sans-serif", 18).into_font().color(&BLACK);
        area.draw(&Text::new(self.picture.title.clone(), (LEFT as i32, 12), heading)).map_err(PlotError::from)?;
        let (_, below) = area.split_vertically(40);
        let (trace, field) = below.split_vertically(TRACE);
        self.trace(&trace)?;
        let RunPicture { field: all, barriers, periods, .. } = self.picture;
        let x = "time, in periods since the start (whole run)";
        Panel { field: all, barriers: *barriers, periods: *periods, x, impacts: &[] }.draw(&field)
    }
}

impl Sheet<'_> {
    fn trace<B: DrawingBackend>(&self, area: &DrawingArea<B, Shift>) -> Result<(), PlotError> {
        let (lower, upper) = self.picture.barriers;
        let first = self.picture.simulated.first().map_or(0.0, |point| point.0);
        let last = self.picture.simulated.last().map_or(1.0, |point| point.0).max(first + 1e-9);
        let mut chart = ChartBuilder::on(area)
            .margin_right(RIGHT)
            .margin_top(6)
            .margin_left(12)
            .set_label_area_size(LabelAreaPosition::Left, LEFT - 12)
            .set_label_area_size(LabelAreaPosition::Bottom, 60)
            // Above the upper barrier there is room for the legend.
            .build_cartesian_2d(first..last, lower - 0.15..upper + 0.6)
            .map_err(PlotError::from)?;
        axes(&mut chart, "time, in periods since the start (end of the run)", "impacting mass u₀", true)?;
        barriers(&mut chart, (lower, upper), (first, last))?;
        let series = [
            ("analytic orbit", &self.picture.analytic, RGBColor(240, 170, 90), 5),
            ("simulation", &self.picture.simulated, RGBColor(16, 50, 98), 2),
        ];
        for (name, points, colour, width) in series.into_iter().filter(|(_, points, _, _)| !points.is_empty()) {
            chart
                .draw_series(LineSeries::new(points.iter().copied(), colour.stroke_width(width)))
                .map_err(PlotError::from)?
                .label(name)
                .legend(move |(x, y)| PathElement::new([(x, y), (x + 24, y)], colour.stroke_width(width)));
        }
        legend(&mut chart)
    }
}
