//! What the panels of all pictures have in common: grid, axes with names, barriers, legend.

use plotters::chart::{ChartContext, SeriesLabelPosition};
use plotters::coord::cartesian::Cartesian2d;
use plotters::coord::ranged1d::{Ranged, ValueFormatter};
use plotters::coord::types::RangedCoordf64;
use plotters::element::DashedPathElement;
use plotters::prelude::{Color, DrawingBackend, RGBColor, WHITE};

use crate::canvas::PlotError;
use crate::ticks::tick;

/// A panel with two real axes.
pub type Panel<'a, B> = ChartContext<'a, B, Cartesian2d<RangedCoordf64, RangedCoordf64>>;

/// Draws the axes, over a light grid if the panel is not filled by a raster.
pub fn axes<B: DrawingBackend>(panel: &mut Panel<'_, B>, x: &str, y: &str, grid: bool) -> Result<(), PlotError> {
    labelled_axes(panel, x, y, grid, [&|value| tick(*value); 2])
}

/// The same for axes of any kind, with labels for the ticks of x and y.
pub fn labelled_axes<B: DrawingBackend, X, Y>(
    panel: &mut ChartContext<'_, B, Cartesian2d<X, Y>>,
    x: &str,
    y: &str,
    grid: bool,
    labels: [&dyn Fn(&f64) -> String; 2],
) -> Result<(), PlotError>
where
    X: Ranged<ValueType = f64> + ValueFormatter<f64>,
    Y: Ranged<ValueType = f64> + ValueFormatter<f64>,
{
    let mut mesh = panel.configure_mesh();
    if grid {
        mesh.light_line_style(WHITE).bold_line_style(RGBColor(230, 230, 230));
    } else {
        mesh.disable_mesh();
    }
    mesh.x_desc(x)
        .y_desc(y)
        .axis_desc_style(("sans-serif", 17))
        .label_style(("sans-serif", 14))
        .x_label_formatter(&labels[0])
        .y_label_formatter(&labels[1])
        .draw()
        .map_err(PlotError::from)
}

/// Draws the two barriers as dashed lines across the panel.
pub fn barriers<B: DrawingBackend>(
    panel: &mut Panel<'_, B>,
    (lower, upper): (f64, f64),
    (from, to): (f64, f64),
) -> Result<(), PlotError> {
    let style = RGBColor(110, 110, 110).stroke_width(1);
    let lines = [lower, upper].map(|at| DashedPathElement::new(vec![(from, at), (to, at)], 6, 4, style));
    panel.draw_series(lines).map(|_| ()).map_err(PlotError::from)
}

/// Draws the legend of the series that have labels.
pub fn legend<'a, B: DrawingBackend + 'a>(panel: &mut Panel<'a, B>) -> Result<(), PlotError> {
    panel
        .configure_series_labels()
        .position(SeriesLabelPosition::UpperRight)
        .background_style(WHITE.mix(0.85))
        .border_style(RGBColor(200, 200, 200))
        .label_font(("sans-serif", 15))
        .draw()
        .map_err(PlotError::from)
}
