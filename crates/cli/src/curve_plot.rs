//! The picture of curves of events in the plane of two parameters.

use std::collections::BTreeMap;

use vibrochain_floquet::{EventCurve, Window};
use vibrochain_maps::files::Output;
use vibrochain_plot::{Curves as Picture, Mark, Page, Pane, Scale, Series, Stroke, curves_picture};

use crate::args::CurveArgs;
use crate::caption::in_common;
use crate::error::CliError;
use crate::locate_command::Start;

/// Colours of curves, by turns; what is not physical is grey.
const COLOURS: usize = 5;
const GREY: usize = 5;

/// A picture under way.
pub(crate) struct Plot {
    file: Option<(Page, Output)>,
}

impl Plot {
    pub(crate) fn open(args: &CurveArgs) -> Result<Self, CliError> {
        Ok(Self { file: args.page.open("--plot", args.plot.as_deref())? })
    }

    pub(crate) fn finish(self, start: &Start, window: &Window, curves: &[EventCurve]) -> Result<(), CliError> {
        let Some((page, file)) = self.file else { return Ok(()) };
        let [x, y] = window.parameters;
        let event = curves.first().map_or(String::new(), |curve| format!("{} of breathers, ", curve.event));
        let common = common(start, curves);
        let pane = Pane {
            caption: String::new(),
            x: format!("{} {}", x.meaning(), x.symbol()),
            y: format!("{} {}", y.meaning(), y.symbol()),
            x_range: Some(window.from[0]..window.to[0]),
            x_log: false,
            scale: Scale::Between(window.from[1]..window.to[1]),
            levels: Vec::new(),
            round: false,
            series: series(curves),
        };
        let picture = Picture {
            title: format!("{event}{common}"),
            columns: 1,
            panes: vec![pane],
            pane: (1000, 720),
            ..Picture::default()
        };
        let bytes = curves_picture(&picture, page).map_err(|error| CliError::Computation(error.to_string()))?;
        Ok(file.finish_with(&bytes)?)
    }
}

/// What all points of all curves have in common.
fn common(start: &Start, curves: &[EventCurve]) -> String {
    let ends = curves.iter().flat_map(|curve| [curve.points.first(), curve.points.last()]).flatten();
    let mut models: Vec<_> = ends.map(|point| point.orbit.model()).collect();
    models.push(start.orbit.model());
    in_common(&models)
}

/// The lines of each curve, physical parts and others, then marks for what is special.
fn series(curves: &[EventCurve]) -> Vec<Series> {
    let mut all = Vec::new();
    let mut marks: BTreeMap<String, Vec<(f64, f64)>> = BTreeMap::new();
    for (i, curve) in curves.iter().enumerate() {
        let line = |physical: bool| part(curve, physical);
        let name = format!("curve {}", i + 1);
        let (colour, stroke) = (i % COLOURS, Stroke::Solid(2));
        all.push(Series { name, colour, stroke, mark: Mark::None, points: line(true) });
        let (colour, stroke) = (GREY, Stroke::Dashed(1));
        all.push(Series { name: String::new(), colour, stroke, mark: Mark::None, points: line(false) });
        for one in &curve.special {
            let [x, y] = curve.points[one.point].values;
            marks.entry(one.special.to_string()).or_default().push((x, y));
        }
    }
    for (shape, (name, points)) in marks.into_iter().enumerate() {
        all.push(Series { name, colour: 4, stroke: Stroke::None, mark: Mark::Filled(shape), points });
    }
    all
}

/// The points whose orbits are physical, or those whose are not, with breaks between.
fn part(curve: &EventCurve, physical: bool) -> Vec<(f64, f64)> {
    let of = |pair: &[vibrochain_floquet::CurvePoint]| {
        let is = pair.iter().all(|point| point.physical == Some(true)) == physical;
        let [from, to] = [&pair[0], &pair[1]].map(|point| (point.values[0], point.values[1]));
        if is { vec![from, to] } else { vec![(f64::NAN, f64::NAN)] }
    };
    curve.points.windows(2).flat_map(of).collect()
}
