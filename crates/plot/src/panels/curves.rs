//! Curves and points in panels, as values: what all figures that are not maps consist of.

use std::ops::Range;

use crate::axes::axis::is_logarithmic;
use crate::map::mapped::MapAxis;

/// A picture of panels side by side.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Curves {
    /// Line above the panels.
    pub title: String,
    /// The panels, row by row.
    pub panes: Vec<Pane>,
    /// Panels in a row; fewer on a page that has no room for them.
    pub columns: usize,
    /// Width and height of a panel on a screen, its legend included.
    pub pane: (u32, u32),
    /// Lines above the rows, if there are any.
    pub headings: Vec<String>,
    /// One legend for all panels, above them: what has one name means one thing.
    pub one_legend: bool,
    /// Panels share their axes, so that they can be compared, and their legend.
    pub shared: bool,
}

/// One panel.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Pane {
    /// Line above the legend; may be empty.
    pub caption: String,
    /// What the horizontal axis is.
    pub x: String,
    /// What the vertical axis is.
    pub y: String,
    /// Ends of the horizontal axis; from the data if absent.
    pub x_range: Option<Range<f64>>,
    /// Places along the horizontal axis are decimal logarithms; its ticks tell the numbers.
    pub x_log: bool,
    /// Scale of the vertical axis.
    pub scale: Scale,
    /// Heights of thin dashed lines across the panel, such as the barriers.
    pub levels: Vec<f64>,
    /// Places of the same, upright.
    pub uprights: Vec<f64>,
    /// Both axes in the same units, so that a circle is round.
    pub round: bool,
    /// The curves.
    pub series: Vec<Series>,
}

impl Pane {
    /// One with its words and curves.
    #[must_use]
    pub fn titled(caption: &str, x: &str, y: &str, series: Vec<Series>) -> Self {
        Self { caption: caption.to_owned(), x: x.to_owned(), y: y.to_owned(), series, ..Self::default() }
    }

    /// An empty one over an axis of a sweep, along which values have the places that [`place`](crate::place) gives them.
    pub fn over(axis: &MapAxis) -> Self {
        Self { x: axis.label.clone(), x_log: is_logarithmic(&axis.values), ..Self::default() }
    }
}

/// A vertical axis.
#[derive(Debug, Clone, PartialEq, Default)]
pub enum Scale {
    /// Linear, from the data.
    #[default]
    Linear,
    /// Linear with these ends; what lies beyond is not seen.
    Between(Range<f64>),
    /// Logarithmic; values that are not positive are left out.
    Logarithmic,
    /// Logarithmic, of moduli of multipliers, 1 always among them: from 0.01 to 100 at most.
    Moduli,
}

/// How the points of a series are joined.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Stroke {
    /// Not at all.
    None,
    /// By a line so many pixels wide.
    Solid(u32),
    /// By dashes so many pixels wide.
    Dashed(u32),
}

/// How the points of a series are marked.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Mark {
    /// Not at all.
    None,
    /// By a filled shape.
    Filled(usize),
    /// By a filled shape of about half the size, where many points are close.
    Small(usize),
    /// By a dot of two pixels, where there are thousands.
    Dot,
    /// By the outline of a shape, larger, so that a filled one shows inside.
    Hollow(usize),
}

/// A curve.
#[derive(Debug, Clone, PartialEq)]
pub struct Series {
    /// Its name in the legend; without one it has no entry.
    pub name: String,
    /// Which of the colours of lines, [`LINES`](crate::palette::LINES); beyond them [`BORDERS`](crate::palette::BORDERS).
    pub colour: usize,
    /// The line.
    pub stroke: Stroke,
    /// The points.
    pub mark: Mark,
    /// Its points. One that is not finite breaks the line.
    pub points: Vec<(f64, f64)>,
}

impl Series {
    /// A line.
    pub fn line(
        name: impl Into<String>,
        colour: usize,
        stroke: Stroke,
        points: impl IntoIterator<Item = (f64, f64)>,
    ) -> Self {
        Self { name: name.into(), colour, stroke, mark: Mark::None, points: points.into_iter().collect() }
    }

    /// Points without a line.
    pub fn marks(
        name: impl Into<String>,
        colour: usize,
        mark: Mark,
        points: impl IntoIterator<Item = (f64, f64)>,
    ) -> Self {
        Self { mark, ..Self::line(name, colour, Stroke::None, points) }
    }
}
