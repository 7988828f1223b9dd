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
    /// Of moduli of multipliers: by the logarithm of their distance from 1, of which this much is a decade's step away from 1, and
    /// linear next to 1.
    AboutOne(f64),
}

impl Scale {
    /// The scale of multipliers: linear about 1, where stability changes, if most of what is unstable is not far from there and of
    /// two orders at most; otherwise by the logarithm of the distance from 1. Next to a grazing impact they grow without bound; such ends leave the
    /// picture.
    pub fn about_one(series: &[Series]) -> Self {
        let points = series.iter().flat_map(|series| &series.points);
        let mut drawn: Vec<f64> = points.map(|point| point.1).filter(|value| value.is_finite()).collect();
        drawn.sort_by(f64::total_cmp);
        let unstable = &drawn[drawn.partition_point(|value| *value <= 1.0 + LEAST / 100.0)..];
        let Some(least) = drawn.first() else { return Self::Linear };
        let share = |hundredths: usize| unstable.get(unstable.len() * hundredths / 100).copied().unwrap_or(1.0);
        let (most, weak) = (share(MOST_OF_IT), share(WEAK) - 1.0);
        if most > FAR || most - 1.0 > ORDERS * weak {
            return Self::AboutOne(10f64.powf(weak.log10().floor()).min(COARSEST));
        }
        let (low, highest) = (least.min(1.0), drawn.last().copied().unwrap_or(most));
        let top = highest.min(1.0 + ROOM * (most - 1.0)).max(1.0 + LEAST);
        // A peak that is nearly all seen is seen whole; what leaves the picture does so at its edge.
        let (top, air) = if highest <= 1.0 + WHOLE * (top - 1.0) { (highest.max(top), AIR) } else { (top, 0.0) };
        Self::Between(low - AIR * (top - low)..top + air * (top - low))
    }
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

/// Multipliers are drawn linearly where of those beyond 1 this many in a hundred are below `FAR`, up to so many times as far from
/// 1 as these are, and at least so far; otherwise by logarithms.
const MOST_OF_IT: usize = 80;
const FAR: f64 = 5.0;
/// And where the weakest excesses, this many in a hundred, are less than so many times weaker: on a linear axis a hundredth of its height is
/// a line on that of 1. A stripe that a branch crosses is a few points of hundreds.
const WEAK: usize = 3;
const ORDERS: f64 = 100.0;
/// The largest step next to 1 of an axis by logarithms: an excess of a tenth a period is never next to none.
const COARSEST: f64 = 0.1;
const ROOM: f64 = 2.0;
const LEAST: f64 = 0.01;

/// What rises at most so much further than that does not leave the picture; about it is air, a part of its height.
const WHOLE: f64 = 1.5;
const AIR: f64 = 0.07;

#[cfg(test)]
mod tests {
    use super::*;

    /// Ends of the scale of multipliers: ten that are 1.01 and one of another height.
    fn ends(height: f64) -> Range<f64> {
        let points = std::iter::repeat_n(1.01, 10).chain([1.0, height]).enumerate().map(|(i, y)| (i as f64, y));
        match Scale::about_one(&[Series::line("", 0, Stroke::Solid(1), points)]) {
            Scale::Between(ends) => ends,
            other => panic!("{other:?}"),
        }
    }

    /// Stripes that grow by a thousandth beside a branch that ends in a grazing impact: neither flattens the other.
    #[test]
    fn excesses_of_several_orders_are_drawn_by_logarithms() {
        let scale = |heights: &[f64]| {
            let points = heights.iter().enumerate().map(|(i, y)| (i as f64, *y));
            Scale::about_one(&[Series::line("", 0, Stroke::Solid(1), points)])
        };
        assert_eq!(scale(&[1.0, 1.0, 1.003, 1.004, 1.8, 2.5, 3.0, 2.0]), Scale::AboutOne(1e-3));
        assert_eq!(scale(&[0.9, 20.0, 300.0, 1e4]), Scale::AboutOne(COARSEST));
        assert!(matches!(scale(&[1.0, 1.002, 1.01, 1.03]), Scale::Between(_)));
        assert!(matches!(scale(&[0.5, 0.9, 1.0]), Scale::Between(_)));
    }

    #[test]
    fn a_peak_is_seen_whole_and_what_grows_without_bound_leaves_the_picture() {
        for height in [1.011, 1.019, 1.025, 1.029] {
            let seen = ends(height);
            assert!(
                seen.end > height && seen.end < height + 0.1 * (height - 1.0) && seen.start < 1.0,
                "{height} {seen:?}"
            );
        }
        for height in [1.04, 7.0, 1e9] {
            assert!((ends(height).end - 1.02).abs() < 1e-12, "{height} {:?}", ends(height));
        }
    }
}
