//! The picture of orbits: for each, the profile along the ring at its impacts, and the impacting mass over a period.

use crate::backend::format::PlotError;
use crate::backend::page::Page;
use crate::panels::curves::{Curves, Mark, Pane, Series, Stroke};
use crate::panels::curves_picture;

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

/// One orbit's data.
#[derive(Debug, Clone, PartialEq)]
pub struct OrbitPanels {
    /// Line above the panels.
    pub caption: String,
    /// What stands below the profiles.
    pub x: &'static str,
    /// Displacements by site at each instant of impacts.
    pub profiles: Vec<Profile>,
    /// The impacting masses over one period, each with its site: (t/T, u).
    pub traces: Vec<(usize, Vec<(f64, f64)>)>,
    /// Positions of the two barriers.
    pub barriers: (f64, f64),
}

/// Width and height of a panel.
const PANEL: (u32, u32) = (600, 400);

/// The bytes of a picture with one row of panels for each orbit.
///
/// # Errors
/// [`PlotError`].
pub fn orbit_picture(orbits: &[OrbitPanels], page: impl Into<Page>) -> Result<Vec<u8>, PlotError> {
    let panes = orbits.iter().flat_map(|orbit| [profile(orbit), trace(orbit)]).collect();
    let headings = orbits.iter().map(|orbit| orbit.caption.clone()).collect();
    curves_picture(&Curves { panes, columns: 2, pane: PANEL, headings, ..Curves::default() }, page)
}

fn pane(orbit: &OrbitPanels, x: &str, y: &str, series: Vec<Series>) -> Pane {
    let levels = vec![orbit.barriers.0, orbit.barriers.1];
    Pane { x: x.to_owned(), y: y.to_owned(), levels, series, ..Pane::default() }
}

fn profile(orbit: &OrbitPanels) -> Pane {
    let series = orbit.profiles.iter().enumerate().map(|(colour, profile)| {
        let Profile { name, instant, points } = profile.clone();
        let (stroke, mark) =
            if instant == 0 { (Stroke::Solid(2), Mark::Filled(0)) } else { (Stroke::Dashed(2), Mark::Hollow(3)) };
        Series { name, colour, stroke, mark, points }
    });
    pane(orbit, orbit.x, "displacement uₙ", series.collect())
}

fn trace(orbit: &OrbitPanels) -> Pane {
    let alone = orbit.traces.len() == 1;
    let series = orbit.traces.iter().enumerate().map(|(i, (site, trace))| {
        // Masses that move alike lie on each other: the later ones are dashed.
        let stroke = if i == 0 { Stroke::Solid(2) } else { Stroke::Dashed(2) };
        let name = if alone { String::new() } else { format!("site {site}") };
        Series { name, colour: i, stroke, mark: Mark::None, points: trace.clone() }
    });
    let y = if alone { "impacting mass u₀" } else { "impacting masses uₙ" };
    let pane = pane(orbit, "time, in periods of the orbit", y, series.collect());
    Pane { x_range: Some(0.0..1.0), ..pane }
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
        let caption = "double-sided breather 1: N = 20, γ₁ = 0.2790465016543734, γ₂ = 0.13606569615937517, \
                       ω = 0.3456359754617771, a = 0.4, force 1:0.1:0,3:-0.03:0.5,5:0.01:0, e = 0.9; stable";
        let points = vec![(-1.0, 0.1), (0.0, 1.4), (1.0, 0.1)];
        let profile = |time: f64| Profile { name: format!("at t = {time:.4}"), instant: 0, points: points.clone() };
        let orbit = OrbitPanels {
            caption: caption.to_owned(),
            x: "site",
            profiles: vec![profile(0.0), profile(2.0)],
            traces: vec![(0, vec![(0.0, 1.4), (0.5, -0.6), (1.0, 1.4)])],
            barriers: (-0.6, 1.4),
        };
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
}
