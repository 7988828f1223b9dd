//! The picture of orbits: for each, the profile along the ring at its impacts, and the impacting mass over a period.

use plotters::coord::Shift;
use plotters::prelude::{BLACK, DrawingArea, DrawingBackend, WHITE};

use crate::canvas::{Drawing, Format, PlotError, render};
use crate::curves::{Mark, Pane, Scale, Series, Stroke, draw_row};
use crate::words::Heading;

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
    /// The impacting masses over one period, each with its site: (t/T, v).
    pub traces: Vec<(usize, Vec<(f64, f64)>)>,
    /// Positions of the two barriers.
    pub barriers: (f64, f64),
}

const WIDTH: u32 = 1200;
/// Height of the panels of an orbit, and of the air about its caption.
const PANELS: u32 = 400;
const AIR: u32 = 16;

/// The bytes of a picture with one row of panels for each orbit.
///
/// # Errors
/// [`PlotError`].
pub fn orbit_picture(orbits: &[OrbitPanels], format: Format) -> Result<Vec<u8>, PlotError> {
    let captions: Vec<_> = orbits.iter().map(|orbit| Heading::new(&orbit.caption, WIDTH - 40, 17)).collect();
    // Rows are of one height.
    let caption = AIR + captions.iter().map(Heading::height).max().unwrap_or(0);
    let size = (WIDTH, (caption + PANELS) * orbits.len().max(1) as u32);
    render(&Rows { orbits, captions, caption }, format, size)
}

struct Rows<'a> {
    orbits: &'a [OrbitPanels],
    captions: Vec<Heading>,
    caption: u32,
}

impl Drawing for Rows<'_> {
    fn draw<B: DrawingBackend>(&self, area: &DrawingArea<B, Shift>) -> Result<(), PlotError> {
        area.fill(&WHITE).map_err(PlotError::from)?;
        let rows = area.split_evenly((self.orbits.len().max(1), 1));
        for ((orbit, caption), row) in self.orbits.iter().zip(&self.captions).zip(rows) {
            caption.draw(&row, (20, 8), BLACK)?;
            let (_, panels) = row.split_vertically(self.caption);
            draw_row(&panels.split_evenly((1, 2)), &[profile(orbit), trace(orbit)])?;
        }
        Ok(())
    }
}

fn pane(orbit: &OrbitPanels, x: &str, y: &str, series: Vec<Series>) -> Pane {
    Pane {
        caption: String::new(),
        x: x.to_owned(),
        y: y.to_owned(),
        x_range: None,
        x_log: false,
        scale: Scale::Linear,
        levels: vec![orbit.barriers.0, orbit.barriers.1],
        round: false,
        series,
    }
}

fn profile(orbit: &OrbitPanels) -> Pane {
    let series = orbit.profiles.iter().enumerate().map(|(colour, profile)| {
        let Profile { name, instant, points } = profile.clone();
        let (stroke, mark) =
            if instant == 0 { (Stroke::Solid(2), Mark::Filled(0)) } else { (Stroke::Dashed(2), Mark::Hollow(3)) };
        Series { name, colour, stroke, mark, points }
    });
    pane(orbit, orbit.x, "displacement vₙ", series.collect())
}

fn trace(orbit: &OrbitPanels) -> Pane {
    let alone = orbit.traces.len() == 1;
    let series = orbit.traces.iter().enumerate().map(|(i, (site, trace))| {
        // Masses that move alike lie on each other: the later ones are dashed.
        let stroke = if i == 0 { Stroke::Solid(2) } else { Stroke::Dashed(2) };
        let name = if alone { String::new() } else { format!("site {site}") };
        Series { name, colour: i, stroke, mark: Mark::None, points: trace.clone() }
    });
    let y = if alone { "impacting mass v₀" } else { "impacting masses vₙ" };
    let pane = pane(orbit, "time, in periods of the orbit", y, series.collect());
    Pane { x_range: Some(0.0..1.0), ..pane }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Places and words of all texts in a picture.
    fn texts(svg: &str) -> Vec<(f64, String)> {
        let of = |tag: &str| {
            let y = tag.split(" y=\"").nth(1)?.split('"').next()?.parse().ok()?;
            let words = tag.split('>').nth(1)?.split('<').next()?.trim().to_owned();
            Some((y, words))
        };
        svg.split("<text ").skip(1).filter_map(of).collect()
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
        let ticks = texts.iter().filter(|(_, words)| words.parse::<f64>().is_ok()).map(|(y, _)| *y);
        let ticks: Vec<f64> = ticks.collect();
        assert!(ticks.len() > 20 && ticks.iter().all(|y| y > first), "{first} {ticks:?}");
    }
}
