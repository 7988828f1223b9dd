//! Error against run time: one panel a case, one line and marker a method, both axes logarithmic.

use plotters::chart::{ChartBuilder, LabelAreaPosition};
use plotters::coord::Shift;
use plotters::element::{EmptyElement, PathElement, Polygon, Text};
use plotters::prelude::{BLACK, Color, DrawingArea, DrawingBackend, IntoFont, LineSeries, RGBColor, WHITE};

use vibrochain_plot::axes::labelled_axes;
use vibrochain_plot::canvas::{Drawing, Format, PlotError, render};
use vibrochain_plot::decades::{Decades, power_of_ten};
use vibrochain_plot::markers::marker;
use vibrochain_plot::palette::LINES;

/// What is drawn.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct WorkPrecision {
    /// Line above the panels.
    pub title: String,
    /// What the errors are.
    pub error: String,
    /// Names of the methods.
    pub methods: Vec<String>,
    /// One panel a case.
    pub panels: Vec<WorkPrecisionPanel>,
}

/// One case.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct WorkPrecisionPanel {
    /// Its name.
    pub caption: String,
    /// For each method, seconds and error of its settings. An error of 0 is drawn on the lower edge.
    pub series: Vec<Vec<(f64, f64)>>,
}

const PANEL: (u32, u32) = (430, 380);
/// Panels side by side.
const COLUMNS: usize = 3;
/// Title, what the errors are.
const HEADING: u32 = 70;
const LEGEND_ROW: u32 = 26;
const LEGEND_COLUMN: u32 = 330;
const EDGE: u32 = 24;

/// The bytes of the picture.
///
/// # Errors
/// [`PlotError`].
pub(super) fn work_precision_picture(picture: &WorkPrecision, format: Format) -> Result<Vec<u8>, PlotError> {
    let layout = Layout::of(picture);
    render(&Sheet { picture, layout }, format, layout.size)
}

#[derive(Debug, Clone, Copy)]
struct Layout {
    size: (u32, u32),
    heading: u32,
    grid: (usize, usize),
    legend_columns: usize,
}

impl Layout {
    fn of(picture: &WorkPrecision) -> Self {
        let panels = picture.panels.len().max(1);
        let columns = panels.min(COLUMNS);
        let grid = (panels.div_ceil(columns), columns);
        // A picture of one panel is as wide as two: its heading needs the room.
        let width = PANEL.0 * columns.max(2) as u32;
        let legend_columns = ((width - EDGE) / LEGEND_COLUMN).max(1) as usize;
        let heading = HEADING + LEGEND_ROW * picture.methods.len().div_ceil(legend_columns) as u32;
        Self { size: (width, heading + PANEL.1 * grid.0 as u32), heading, grid, legend_columns }
    }
}

struct Sheet<'a> {
    picture: &'a WorkPrecision,
    layout: Layout,
}

fn colour(method: usize) -> RGBColor {
    let [r, g, b] = LINES[method % LINES.len()];
    RGBColor(r, g, b)
}

impl Drawing for Sheet<'_> {
    fn draw<B: DrawingBackend>(&self, area: &DrawingArea<B, Shift>) -> Result<(), PlotError> {
        area.fill(&WHITE).map_err(PlotError::from)?;
        let (heading, panels) = area.split_vertically(self.layout.heading);
        self.heading(&heading)?;
        // Panels of a picture share their axes: they can be compared.
        let points = || self.picture.panels.iter().flat_map(|panel| panel.series.iter().flatten());
        let x = Decades::holding(points().map(|point| point.0.log10()));
        let positive = points().map(|point| point.1).filter(|error| *error > 0.0).map(f64::log10);
        let mut y = Decades::holding(positive);
        if points().any(|point| point.1 == 0.0) {
            y = y.with_one_below();
        }
        for (i, (panel, place)) in self.picture.panels.iter().zip(panels.split_evenly(self.layout.grid)).enumerate() {
            // With one panel the right half of the sheet stays with it.
            draw_panel(&place, panel, x, y, i % self.layout.grid.1 == 0)?;
        }
        Ok(())
    }
}

impl Sheet<'_> {
    fn heading<B: DrawingBackend>(&self, area: &DrawingArea<B, Shift>) -> Result<(), PlotError> {
        let text = |words: &str, place: (i32, i32), size: u32| {
            let style = ("sans-serif", size).into_font().color(&BLACK);
            area.draw(&Text::new(words.to_owned(), place, style)).map_err(PlotError::from)
        };
        text(&self.picture.title, (EDGE as i32, 12), 20)?;
        text(&format!("error: {}", self.picture.error), (EDGE as i32, 40), 15)?;
        for (i, method) in self.picture.methods.iter().enumerate() {
            let (row, column) = (i / self.layout.legend_columns, i % self.layout.legend_columns);
            let (x, y) =
                (EDGE as i32 + (column as u32 * LEGEND_COLUMN) as i32, (HEADING + 12 + row as u32 * LEGEND_ROW) as i32);
            let line = PathElement::new([(x, y), (x + 32, y)], colour(i).stroke_width(2));
            area.draw(&line).map_err(PlotError::from)?;
            let corners: Vec<_> = marker(i).into_iter().map(|(dx, dy)| (x + 16 + dx, y + dy)).collect();
            area.draw(&Polygon::new(corners, colour(i))).map_err(PlotError::from)?;
            text(method, (x + 42, y - 8), 16)?;
        }
        Ok(())
    }
}

fn draw_panel<B: DrawingBackend>(
    area: &DrawingArea<B, Shift>,
    panel: &WorkPrecisionPanel,
    x: Decades,
    y: Decades,
    first_column: bool,
) -> Result<(), PlotError> {
    let mut chart = ChartBuilder::on(area)
        .caption(&panel.caption, ("sans-serif", 16))
        .margin_right(16)
        .margin_left(8)
        .margin_top(4)
        .margin_bottom(6)
        .set_label_area_size(LabelAreaPosition::Left, 72)
        .set_label_area_size(LabelAreaPosition::Bottom, 48)
        .build_cartesian_2d(x, y)
        .map_err(PlotError::from)?;
    let error = if first_column { "error" } else { "" };
    labelled_axes(&mut chart, "time of one evaluation, seconds", error, true, [&|value| power_of_ten(*value); 2])?;
    let floor = y.low();
    for (method, series) in panel.series.iter().enumerate() {
        let place = |&(seconds, error): &(f64, f64)| (seconds.log10(), if error > 0.0 { error.log10() } else { floor });
        let line = LineSeries::new(series.iter().map(place), colour(method).mix(0.8).stroke_width(2));
        chart.draw_series(line).map_err(PlotError::from)?;
        let markers =
            series.iter().map(|point| EmptyElement::at(place(point)) + Polygon::new(marker(method), colour(method)));
        chart.draw_series(markers).map_err(PlotError::from)?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pictures_of_any_number_of_panels_are_drawn() {
        for panels in [1, 2, 7] {
            let panel = WorkPrecisionPanel {
                caption: "χ₂".to_owned(),
                series: vec![vec![(1e-6, 1e-3), (1e-3, 0.0)], vec![(1e-5, 1e-9)], Vec::new()],
            };
            let methods = vec!["a".to_owned(), "b".to_owned(), "c".to_owned()];
            let picture = WorkPrecision {
                title: "title".to_owned(),
                error: "of something".to_owned(),
                methods,
                panels: vec![panel; panels],
            };
            let svg = String::from_utf8(work_precision_picture(&picture, Format::Svg).unwrap()).unwrap();
            assert!(svg.contains("χ₂") && svg.contains("10⁻⁶") && svg.contains("error: of something"), "{panels}");
            assert!(work_precision_picture(&picture, Format::Png).unwrap().starts_with(b"\x89PNG"));
        }
    }
}
