//! All masses in space and time, as colours.

use plotters::chart::LabelAreaPosition;
use plotters::coord::Shift;
use plotters::element::{BitMapElement, Circle, PathElement, Rectangle, Text};
use plotters::prelude::{BLACK, ChartBuilder, Color, DrawingArea, DrawingBackend, IntoFont, WHITE};

use crate::axes::axes;
use crate::canvas::{Drawing, Format, PlotError, render};
use crate::field::{Field, Shown};
use crate::ticks::tick;
use crate::words::Heading;

const WIDTH: u32 = 1200;
pub(crate) const LEFT: u32 = 90;
pub(crate) const RIGHT: u32 = 140;
const HEIGHT: u32 = 520;

/// What no mass has been simulated for.
const NOTHING: [u8; 3] = [225, 225, 225];

/// Blue below the middle of the gap, white at it, vermilion above; in grey the sign is lost, the size is not.
fn diverging(x: f64) -> [u8; 3] {
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
pub fn spacetime_picture(picture: &Spacetime, format: Format) -> Result<Vec<u8>, PlotError> {
    let heading = Heading::new(&picture.title, WIDTH - 40, 17);
    let top = 16 + heading.height();
    render(&Sheet { picture, heading, top }, format, (WIDTH, top + HEIGHT))
}

struct Sheet<'a> {
    picture: &'a Spacetime,
    heading: Heading,
    top: u32,
}

impl Drawing for Sheet<'_> {
    fn draw<B: DrawingBackend>(&self, area: &DrawingArea<B, Shift>) -> Result<(), PlotError> {
        area.fill(&WHITE).map_err(PlotError::from)?;
        self.heading.draw(area, (20, 8), BLACK)?;
        let (_, below) = area.split_vertically(self.top);
        let Spacetime { barriers, field, impacts, .. } = self.picture;
        Panel { field, barriers: *barriers, periods: 1.0, x: "time, in periods of the orbit", impacts }.draw(&below)
    }
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
    pub(crate) fn draw<B: DrawingBackend>(&self, area: &DrawingArea<B, Shift>) -> Result<(), PlotError> {
        let Field { shown, sites, lowest, length, columns: values, spacing, covered } = self.field;
        let (sites, periods) = (*sites, self.periods);
        let width = WIDTH - LEFT - RIGHT;
        let (low, high) = (*lowest as f64 - 0.5, (*lowest + sites as i64) as f64 - 0.5);
        let (lower, upper) = self.barriers;
        // What is white, and what has full colour.
        let middle = if *shown == Shown::Displacement { 0.5 * (lower + upper) } else { 0.0 };
        let mut chart = ChartBuilder::on(area)
            .margin_right(RIGHT)
            .margin_top(10)
            .margin_bottom(20)
            .margin_left(12)
            .set_label_area_size(LabelAreaPosition::Left, LEFT - 12)
            .set_label_area_size(LabelAreaPosition::Bottom, 60)
            .build_cartesian_2d(0.0..periods.max(1e-9), low..high)
            .map_err(PlotError::from)?;
        let y = match (*lowest < 0, *length < sites) {
            (true, _) => "site, from site 0",
            (false, false) => "site",
            (false, true) => "site, layer upon layer",
        };
        axes(&mut chart, self.x, y, false)?;
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
        for border in (*length..sites).step_by(*length) {
            let y = (*lowest + border as i64) as f64 - 0.5;
            let line = PathElement::new([(0.0, y), (periods, y)], BLACK.stroke_width(2));
            chart.plotting_area().draw(&line).map_err(PlotError::from)?;
        }
        for &(time, site) in self.impacts {
            // Around a circle: the picture begins with the site at its lower edge.
            let row = (site as i64 - lowest).rem_euclid(sites as i64) + lowest;
            let place = (time, row as f64);
            for (radius, style) in [(6, WHITE.filled()), (6, BLACK.stroke_width(2)), (2, BLACK.filled())] {
                chart.plotting_area().draw(&Circle::new(place, radius, style)).map_err(PlotError::from)?;
            }
        }

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
        let Field { shown, sites, columns, spacing, .. } = self.field;
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
