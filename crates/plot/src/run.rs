//! The picture of a simulated run: the impacting mass over the analytic orbit, and all masses in space and time.

use plotters::chart::LabelAreaPosition;
use plotters::coord::Shift;
use plotters::element::{BitMapElement, PathElement, Rectangle, Text};
use plotters::prelude::{
    BLACK, ChartBuilder, Color, DrawingArea, DrawingBackend, IntoFont, LineSeries, RGBColor, WHITE,
};

use crate::axes::{axes, barriers, legend};
use crate::canvas::{Drawing, Format, PlotError, render};
use crate::field::{Field, Shown};
use crate::map::tick;

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

/// What no mass has been simulated for.
const NOTHING: [u8; 3] = [225, 225, 225];

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

    fn field<B: DrawingBackend>(&self, area: &DrawingArea<B, Shift>) -> Result<(), PlotError> {
        let Field { shown, sites, columns: values, spacing, covered } = &self.picture.field;
        let (sites, periods) = (*sites, self.picture.periods);
        let width = WIDTH - LEFT - RIGHT;
        let (half, other) = ((sites as i64 - 1) / 2, sites as i64 / 2);
        let (lower, upper) = self.picture.barriers;
        // What is white, and what has full colour.
        let middle = if *shown == Shown::Displacement { 0.5 * (lower + upper) } else { 0.0 };
        let mut chart = ChartBuilder::on(area)
            .margin_right(RIGHT)
            .margin_top(10)
            .margin_bottom(20)
            .margin_left(12)
            .set_label_area_size(LabelAreaPosition::Left, LEFT - 12)
            .set_label_area_size(LabelAreaPosition::Bottom, 60)
            .build_cartesian_2d(0.0..periods.max(1e-9), -(half as f64) - 0.5..other as f64 + 0.5)
            .map_err(PlotError::from)?;
        axes(&mut chart, "time, in periods since the start (whole run)", "site, from site 0", false)?;
        let (columns, rows) = chart.plotting_area().get_pixel_range();
        let (w, h) = ((columns.end - columns.start).max(1) as u32, (rows.end - rows.start).max(1) as u32);
        let mut pixels = Vec::with_capacity(3 * (w * h) as usize);
        for py in 0..h {
            for px in 0..w {
                let time = (f64::from(px) + 0.5) / f64::from(w) * periods;
                // What is left after the last column has none of its own.
                let index = ((time / spacing) as usize).min(values.len().saturating_sub(1));
                let column = values.get(index).filter(|_| time <= *covered);
                // The largest offset is on top.
                let value =
                    column.and_then(|column| column.get(column.len() - 1 - py as usize * column.len() / h as usize));
                pixels.extend(value.map_or(NOTHING, |u| diverging(u - middle)));
            }
        }
        let raster = BitMapElement::with_owned_buffer((0, 0), (w, h), pixels)
            .ok_or_else(|| PlotError("the raster does not fit its frame".to_owned()))?;
        chart.plotting_area().strip_coord_spec().draw(&raster).map_err(PlotError::from)?;

        // Colour bar.
        let (x, top, bar) = ((LEFT + width) as i32 + 24, 10, 200);
        let depth = if *shown == Shown::Displacement { 2.0 } else { 1.0 };
        let pixels = (0..bar)
            .flat_map(|py| (0..18).flat_map(move |_| diverging(1.0 - depth * f64::from(py) / f64::from(bar - 1))));
        if let Some(patch) = BitMapElement::with_owned_buffer((x, top), (18, bar), pixels.collect()) {
            area.draw(&patch).map_err(PlotError::from)?;
        }
        area.draw(&Rectangle::new([(x, top), (x + 18, top + bar as i32)], BLACK)).map_err(PlotError::from)?;
        let text = ("sans-serif", 14).into_font().color(&BLACK);
        let bottom = top + bar as i32;
        let ends = if *shown == Shown::Displacement { [upper, middle, lower] } else { [1.0, 0.5, 0.0] };
        for (label, y) in ends.into_iter().zip([top, top + bar as i32 / 2 - 7, bottom - 14]) {
            area.draw(&Text::new(tick(label), (x + 26, y), text.clone())).map_err(PlotError::from)?;
        }
        for (i, line) in self.names().into_iter().enumerate() {
            area.draw(&Text::new(line, (x - 12, bottom + 8 + 18 * i as i32), text.clone())).map_err(PlotError::from)?;
        }
        Ok(())
    }

    /// What the colours of the field mean.
    fn names(&self) -> Vec<String> {
        let Field { shown, sites, columns, spacing, .. } = &self.picture.field;
        let mut lines = match shown {
            Shown::Displacement => vec!["displacement u".to_owned()],
            Shown::Amplitude if *spacing == 1.0 => vec!["(max u − min u)/2".to_owned(), "in each period".to_owned()],
            Shown::Amplitude => vec!["(max u − min u)/2".to_owned(), format!("in {spacing} periods")],
        };
        let rows = columns.first().map_or(0, Vec::len);
        if rows < *sites {
            let masses = sites.div_ceil(rows.max(1));
            lines.extend([format!("largest of {masses}"), "masses".to_owned()]);
        }
        lines
    }
}
