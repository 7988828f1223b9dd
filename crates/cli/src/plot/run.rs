//! The picture of a simulated run: the impacting mass over the analytic orbit, and all masses in space and time.

use plotters::chart::LabelAreaPosition;
use plotters::coord::Shift;
use plotters::element::{BitMapElement, PathElement, Rectangle, Text};
use plotters::prelude::{
    BLACK, ChartBuilder, Color, DrawingArea, DrawingBackend, IntoFont, LineSeries, RGBColor, WHITE,
};

use crate::plot::axes::{axes, barriers, legend};
use crate::plot::canvas::{Drawing, Format, PlotError, render};
use crate::plot::map::tick;

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
    /// Displacements of all masses at equally spaced times.
    pub columns: Vec<Vec<f64>>,
    /// Length of the run in periods of the force.
    pub periods: f64,
}

const WIDTH: u32 = 1200;
const TRACE: u32 = 380;
const LEFT: u32 = 90;
const RIGHT: u32 = 140;
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

/// Blue below the middle of the gap, white at it, vermilion above; in grey the sign is lost, the size is not.
fn diverging(x: f64) -> [u8; 3] {
    let (x, end) = (x.clamp(-1.0, 1.0), if x < 0.0 { [16.0, 50.0, 98.0] } else { [176.0, 58.0, 0.0] });
    end.map(|c| (255.0 + (c - 255.0) * x.abs()) as u8)
}

impl Drawing for Sheet<'_> {
    fn draw<B: DrawingBackend>(&self, area: &DrawingArea<B, Shift>) -> Result<(), PlotError> {
        area.fill(&WHITE).map_err(PlotError::from)?;
        let heading = ("sans-serif", 18).into_font().color(&BLACK);
        area.draw(&Text::new(self.picture.title.clone(), (LEFT as i32, 12), heading)).map_err(PlotError::from)?;
        let (_, below) = area.split_vertically(40);
        let (trace, field) = below.split_vertically(TRACE);
        self.trace(&trace)?;
        self.field(&field)
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
            .build_cartesian_2d(first..last, lower - 0.15..upper + 0.15)
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

    fn field<B: DrawingBackend>(&self, area: &DrawingArea<B, Shift>) -> Result<(), PlotError> {
        let sites = self.picture.columns.first().map_or(1, Vec::len).max(1);
        let width = WIDTH - LEFT - RIGHT;
        let (half, other) = ((sites as i64 - 1) / 2, sites as i64 / 2);
        let middle = 0.5 * (self.picture.barriers.0 + self.picture.barriers.1);
        let mut chart = ChartBuilder::on(area)
            .margin_right(RIGHT)
            .margin_top(10)
            .margin_bottom(20)
            .margin_left(12)
            .set_label_area_size(LabelAreaPosition::Left, LEFT - 12)
            .set_label_area_size(LabelAreaPosition::Bottom, 60)
            .build_cartesian_2d(0.0..self.picture.periods, -(half as f64) - 0.5..other as f64 + 0.5)
            .map_err(PlotError::from)?;
        axes(&mut chart, "time, in periods since the start (whole run)", "site, from site 0", false)?;
        let (columns, rows) = chart.plotting_area().get_pixel_range();
        let (w, h) = ((columns.end - columns.start).max(1) as u32, (rows.end - rows.start).max(1) as u32);
        let mut pixels = Vec::with_capacity(3 * (w * h) as usize);
        for py in 0..h {
            let offset = other - (i64::from(py) * sites as i64 / i64::from(h));
            let site = offset.rem_euclid(sites as i64) as usize;
            for px in 0..w {
                let index = px as usize * self.picture.columns.len() / w as usize;
                let value = self.picture.columns.get(index).and_then(|column| column.get(site));
                pixels.extend(diverging(value.map_or(0.0, |u| u - middle)));
            }
        }
        let raster = BitMapElement::with_owned_buffer((0, 0), (w, h), pixels)
            .ok_or_else(|| PlotError("the raster does not fit its frame".to_owned()))?;
        chart.plotting_area().strip_coord_spec().draw(&raster).map_err(PlotError::from)?;

        // Colour bar.
        let (x, top, bar) = ((LEFT + width) as i32 + 24, 10, 200);
        let pixels = (0..bar)
            .flat_map(|py| (0..18).flat_map(move |_| diverging(1.0 - 2.0 * f64::from(py) / f64::from(bar - 1))));
        if let Some(patch) = BitMapElement::with_owned_buffer((x, top), (18, bar), pixels.collect()) {
            area.draw(&patch).map_err(PlotError::from)?;
        }
        area.draw(&Rectangle::new([(x, top), (x + 18, top + bar as i32)], BLACK)).map_err(PlotError::from)?;
        let text = ("sans-serif", 14).into_font().color(&BLACK);
        let (lower, upper) = self.picture.barriers;
        for (label, y) in [(upper, top), (middle, top + bar as i32 / 2 - 7), (lower, top + bar as i32 - 14)] {
            area.draw(&Text::new(tick(label), (x + 26, y), text.clone())).map_err(PlotError::from)?;
        }
        let name = Text::new("u", (x + 5, top + bar as i32 + 8), ("sans-serif", 16).into_font().color(&BLACK));
        area.draw(&name).map_err(PlotError::from)
    }
}
