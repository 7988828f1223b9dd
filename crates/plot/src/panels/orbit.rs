//! The picture of orbits: for each, the profile along a chain at its impacts, what is hit over a period, and its phase portrait.

use crate::backend::format::PlotError;
use crate::backend::page::Page;
use crate::panels::curves::{Curves, Mark, Pane, Series, Stroke};
use crate::panels::{curves_picture, curves_size};

/// Displacements of a row of masses at one instant.
#[derive(Debug, Clone, PartialEq)]
pub struct Profile {
    /// Its name in the legend.
    pub name: String,
    /// Number of the instant; those after the first are dashed.
    pub instant: usize,
    /// Site and displacement.
    pub points: Vec<(f64, f64)>,
}

/// A mass, or a contact of a structure, over one period.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Trace {
    /// Its name in the legend.
    pub name: String,
    /// Of each flight between impacts of the orbit, in the order of time: t/T, place and velocity.
    pub flights: Vec<Vec<[f64; 3]>>,
    /// Its own impacts that are marked: t/T and place.
    pub impacts: Vec<(f64, f64)>,
}

/// A row of panels, or several, for one orbit.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct OrbitPanels {
    /// Line above the panels.
    pub caption: String,
    /// The panels, two in a row.
    pub panes: Vec<Pane>,
}

/// Width and height of a panel.
const PANEL: (u32, u32) = (600, 400);

/// A velocity that changes by less than this part of the largest does not jump.
const JUMP: f64 = 1e-9;

/// The bytes of a picture of orbits below each other.
///
/// # Errors
/// [`PlotError`].
pub fn orbit_picture(orbits: &[OrbitPanels], page: impl Into<Page>) -> Result<Vec<u8>, PlotError> {
    curves_picture(&below_each_other(orbits), page)
}

/// How many of the first orbits a picture may have without being higher than its page: one in any case.
pub fn orbits_on_page(orbits: &[OrbitPanels], page: impl Into<Page>) -> usize {
    let page = page.into();
    let fits = |count: &usize| {
        page.height.is_none_or(|height| curves_size(&below_each_other(&orbits[..*count]), &page)[1] <= height)
    };
    (1..=orbits.len()).rev().find(fits).unwrap_or_else(|| orbits.len().min(1))
}

fn below_each_other(orbits: &[OrbitPanels]) -> Curves {
    let (mut panes, mut headings) = (Vec::new(), Vec::new());
    for orbit in orbits {
        panes.extend(orbit.panes.iter().cloned());
        headings.push(orbit.caption.clone());
        headings.resize(panes.len().div_ceil(2), String::new());
    }
    Curves { panes, columns: 2, pane: PANEL, headings, ..Curves::default() }
}

/// Displacements along a chain at the instants of impacts, over what `x` names.
pub fn profile_pane(x: &str, profiles: Vec<Profile>) -> Pane {
    let series = profiles.into_iter().enumerate().map(|(colour, Profile { name, instant, points })| {
        let (stroke, mark) =
            if instant == 0 { (Stroke::Solid(2), Mark::Filled(0)) } else { (Stroke::Dashed(2), Mark::Hollow(3)) };
        Series { name, colour, stroke, mark, points }
    });
    Pane::titled("", x, "displacement uₙ", series.collect())
}

/// Places over a period. One trace alone needs no name.
pub fn trace_pane(y: &str, traces: &[Trace]) -> Pane {
    let mut series = Vec::new();
    for (colour, trace) in traces.iter().enumerate() {
        // Masses that move alike lie on each other: the later ones are dashed.
        let stroke = if colour == 0 { Stroke::Solid(2) } else { Stroke::Dashed(2) };
        let name = if traces.len() == 1 { "" } else { &trace.name };
        let points = trace.flights.iter().flatten().map(|[time, place, _]| (*time, *place));
        series.push(Series::line(name, colour, stroke, points));
        if !trace.impacts.is_empty() {
            series.push(Series::marks("", colour, Mark::Filled(colour), trace.impacts.iter().copied()));
        }
    }
    Pane { x_range: Some(0.0..1.0), ..Pane::titled("", "time, in periods of the orbit", y, series) }
}

/// Velocity over place of one mass or contact, impacts as jumps.
pub fn portrait_pane(x: &str, y: &str, trace: &Trace) -> Pane {
    let there = |[_, place, velocity]: &[f64; 3]| (*place, *velocity);
    let (mut flight, mut jumps, mut before, mut after) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
    let fastest = trace.flights.iter().flatten().fold(0.0, |most: f64, point| most.max(point[2].abs()));
    let mut last = trace.flights.last().and_then(|points| points.last());
    for points in &trace.flights {
        flight.extend(points.iter().map(there));
        flight.push((f64::NAN, f64::NAN));
        if let (Some(from), Some(to)) = (last, points.first())
            && (from[2] - to[2]).abs() > JUMP * fastest
        {
            before.push(there(from));
            after.push(there(to));
            jumps.extend([there(from), there(to), (f64::NAN, f64::NAN)]);
        }
        last = points.last();
    }
    let all = vec![
        Series::line("flight", 0, Stroke::Solid(2), flight),
        // In the colour of its marks: barriers, on which it lies, are grey and dashed.
        Series::line("impact", 1, Stroke::Dashed(2), jumps),
        Series::marks("before", 1, Mark::Filled(3), before),
        Series::marks("after", 1, Mark::Hollow(0), after),
    ];
    Pane::titled("", x, y, all)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::backend::format::Format;

    /// Heights and words of all texts in a picture.
    fn texts(svg: &str) -> Vec<(f64, String)> {
        let of = |tag: &str| {
            let y = tag.split("translate(").nth(1)?.split(')').next()?.split(' ').nth(1)?.parse().ok()?;
            Some((y, tag.split('"').next()?.to_owned()))
        };
        svg.split("<g aria-label=\"").skip(1).filter_map(of).collect()
    }

    #[test]
    fn legends_hide_nothing_and_long_captions_lose_nothing() {
        let caption = "Double-sided breather 1: N = 20, γ₁ = 0.2790465016543734, γ₂ = 0.13606569615937517, \
                       ω = 0.3456359754617771, a = 0.4, force 1:0.1:0,3:-0.03:0.5,5:0.01:0, e = 0.9; stable";
        let points = vec![(-1.0, 0.1), (0.0, 1.4), (1.0, 0.1)];
        let profile = |time: f64| Profile { name: format!("at t = {time:.4}"), instant: 0, points: points.clone() };
        let flights = vec![vec![[0.0, 1.4, 0.0], [0.5, -0.6, 0.0], [1.0, 1.4, 0.0]]];
        let trace = Trace { flights, ..Trace::default() };
        let panes = [profile_pane("site", vec![profile(0.0), profile(2.0)]), trace_pane("u₀", &[trace])];
        let panes = panes.map(|pane| Pane { levels: vec![-0.6, 1.4], ..pane }).to_vec();
        let orbit = OrbitPanels { caption: caption.to_owned(), panes };
        let svg = String::from_utf8(orbit_picture(&[orbit.clone(), orbit], Format::Svg).unwrap()).unwrap();
        let texts = texts(&svg);
        let words: Vec<_> = texts.iter().map(|(_, words)| words.as_str()).collect();
        // In two lines.
        assert!(words.iter().all(|words| *words != caption));
        for part in caption.split(", ") {
            assert_eq!(words.iter().filter(|words| words.contains(part)).count(), 2, "{part}");
        }
        // Ticks stand beside the panel, the legend above all of them.
        let (first, _) = texts.iter().find(|(_, words)| words == "at t = 2.0000").unwrap();
        let ticks = texts.iter().filter(|(_, words)| words.replace('−', "-").parse::<f64>().is_ok()).map(|(y, _)| *y);
        let ticks: Vec<f64> = ticks.collect();
        assert!(ticks.len() > 20 && ticks.iter().all(|y| y > first), "{first} {ticks:?}");
    }

    /// What hits another mass changes no velocity here; a flight that ends on a barrier with another velocity than the next begins with does.
    #[test]
    fn only_what_changes_the_velocity_is_a_jump() {
        let flights = vec![vec![[0.0, 1.0, -0.5], [0.4, 0.2, 0.3]], vec![[0.4, 0.2, 0.3], [1.0, 1.0, 0.6]]];
        let drawn = portrait_pane("u", "v", &Trace { flights, ..Trace::default() });
        let points = |name: &str| drawn.series.iter().find(|series| series.name == name).unwrap().points.clone();
        assert_eq!((points("before"), points("after")), (vec![(1.0, 0.6)], vec![(1.0, -0.5)]));
        assert_eq!(points("flight").len(), 6);
    }
}
