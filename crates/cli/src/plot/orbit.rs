//! The picture of orbits: for each, the profile along the ring at its impacts, and the impacting mass over a period.

use plotters::chart::LabelAreaPosition;
use plotters::coord::Shift;
use plotters::element::{Circle, PathElement, Text};
use plotters::prelude::{
    BLACK, ChartBuilder, Color, DrawingArea, DrawingBackend, IntoFont, LineSeries, RGBColor, WHITE,
};

use crate::plot::axes::{axes, barriers, legend};
use crate::plot::canvas::{Drawing, Format, PlotError, render};

/// One orbit's data.
#[derive(Debug, Clone, PartialEq)]
pub struct OrbitPanels {
    /// Line above the panels.
    pub caption: String,
    /// Displacements by site, the impacted site in the middle, at each impact: (time of the impact, (offset, v)).
    pub profiles: Vec<(f64, Vec<(i64, f64)>)>,
    /// The impacting mass over one period: (t/T, v).
    pub trace: Vec<(f64, f64)>,
    /// Positions of the two barriers.
    pub barriers: (f64, f64),
}

const WIDTH: u32 = 1200;
const HEIGHT: u32 = 420;

/// Blue and vermilion, told apart by lightness and by colour-blind eyes.
const SERIES: [RGBColor; 3] = [RGBColor(16, 50, 98), RGBColor(213, 94, 0), RGBColor(46, 134, 171)];

/// The bytes of a picture with one row of panels for each orbit.
///
/// # Errors
/// [`PlotError`].
pub fn orbit_picture(orbits: &[OrbitPanels], format: Format) -> Result<Vec<u8>, PlotError> {
    render(&Rows { orbits }, format, (WIDTH, HEIGHT * orbits.len().max(1) as u32))
}

struct Rows<'a> {
    orbits: &'a [OrbitPanels],
}

/// A range with some air about it.
fn padded(values: impl Iterator<Item = f64>) -> std::ops::Range<f64> {
    let (low, high) = values.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(v), h.max(v)));
    let air = (0.08 * (high - low)).max(1e-6);
    low - air..high + air
}

impl Drawing for Rows<'_> {
    fn draw<B: DrawingBackend>(&self, area: &DrawingArea<B, Shift>) -> Result<(), PlotError> {
        area.fill(&WHITE).map_err(PlotError::from)?;
        for (orbit, row) in self.orbits.iter().zip(area.split_evenly((self.orbits.len().max(1), 1))) {
            let caption = ("sans-serif", 17).into_font().color(&BLACK);
            row.draw(&Text::new(orbit.caption.clone(), (20, 8), caption)).map_err(PlotError::from)?;
            let (_, panels) = row.split_vertically(32);
            let (left, right) = panels.split_horizontally(WIDTH / 2);
            profile_panel(&left, orbit)?;
            trace_panel(&right, orbit)?;
        }
        Ok(())
    }
}

fn profile_panel<B: DrawingBackend>(area: &DrawingArea<B, Shift>, orbit: &OrbitPanels) -> Result<(), PlotError> {
    let (lower, upper) = orbit.barriers;
    let points = || orbit.profiles.iter().flat_map(|(_, profile)| profile);
    let reach = points().map(|(n, _)| n.abs()).max().unwrap_or(1).max(1) as f64 + 0.5;
    let values = padded(points().map(|(_, v)| *v).chain([lower, upper]));
    let mut chart = ChartBuilder::on(area)
        .margin(10)
        .margin_right(20)
        .set_label_area_size(LabelAreaPosition::Left, 64)
        .set_label_area_size(LabelAreaPosition::Bottom, 50)
        .build_cartesian_2d(-reach..reach, values)
        .map_err(PlotError::from)?;
    axes(&mut chart, "site, from the impacting mass", "displacement vₙ", true)?;
    barriers(&mut chart, (lower, upper), (-reach, reach))?;
    for (i, (time, profile)) in orbit.profiles.iter().enumerate() {
        let colour = SERIES[i % SERIES.len()];
        let line = profile.iter().map(|&(n, v)| (n as f64, v));
        chart
            .draw_series(LineSeries::new(line.clone(), colour.stroke_width(2)))
            .map_err(PlotError::from)?
            .label(format!("at t = {time:.4}"))
            .legend(move |(x, y)| PathElement::new([(x, y), (x + 24, y)], colour.stroke_width(2)));
        let dots = line.map(|point| {
            if i == 0 { Circle::new(point, 3, colour.filled()) } else { Circle::new(point, 4, colour.stroke_width(1)) }
        });
        chart.draw_series(dots).map_err(PlotError::from)?;
    }
    legend(&mut chart)
}

fn trace_panel<B: DrawingBackend>(area: &DrawingArea<B, Shift>, orbit: &OrbitPanels) -> Result<(), PlotError> {
    let (lower, upper) = orbit.barriers;
    let values = padded(orbit.trace.iter().map(|(_, v)| *v).chain([lower, upper]));
    let mut chart = ChartBuilder::on(area)
        .margin(10)
        .margin_right(20)
        .set_label_area_size(LabelAreaPosition::Left, 64)
        .set_label_area_size(LabelAreaPosition::Bottom, 50)
        .build_cartesian_2d(0.0..1.0, values)
        .map_err(PlotError::from)?;
    axes(&mut chart, "time, in periods of the orbit", "impacting mass v₀", true)?;
    barriers(&mut chart, (lower, upper), (0.0, 1.0))?;
    let line = LineSeries::new(orbit.trace.iter().copied(), SERIES[0].stroke_width(2));
    chart.draw_series(line).map_err(PlotError::from)?;
    Ok(())
}
