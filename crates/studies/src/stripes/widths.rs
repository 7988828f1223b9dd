//! How wide stripes of instability are and how strong, and what law they follow, as tables and a picture.
//!
//! Stripes are found by `StripeFinder`, one by one; the laws are [`growth_at_meeting`], which knows the infinite ring and 1/M, and
//! [`weak_growth`], for masses that are hardly coupled.

use std::f64::consts::PI;
use std::fmt::Write as _;

use vibrochain_breather::{Family, Finder, OrbitList};
use vibrochain_floquet::{DressedModes, Stripe, StripeEnd, StripeFinder, StripeLine};
use vibrochain_lattice::{Chain, Model, Parameter};
use vibrochain_plot::{Curves, Format, Mark, Pane, Scale, Series, Stroke, curves_picture};

use crate::args::StripesArgs;
use crate::stripes::law::{growth_at_meeting, weak_growth};
use vibrochain_cli::common::console::Console;
use vibrochain_cli::common::error::CliError;
use vibrochain_maps::files::{Output, distinct};

/// γ₁ everywhere.
const GAMMA1: f64 = 0.2;

/// ω from which rows are looked at, below all first harmonics, and points of a row.
const FROM: f64 = 0.6;
const POINTS: usize = 2000;

/// Steps of ω = 2Ω̃(ω) to where a mode meets itself: Ω̃ hardly moves.
const APPROACH: usize = 6;

/// A breather of a ring of N + 1 masses.
#[derive(Debug, Clone, Copy)]
struct Place {
    family: Family,
    n: usize,
    gamma2: f64,
    asymmetry: f64,
}

const fn place(family: Family, n: usize, gamma2: f64, asymmetry: f64) -> Place {
    Place { family, n, gamma2, asymmetry }
}

/// The tables: what varies, and the rows.
const TABLES: [(&str, &[Place]); 4] = [
    (
        "Longer and longer rings",
        &[
            place(Family::DoubleSided, 5, 0.1, 0.4),
            place(Family::DoubleSided, 10, 0.1, 0.4),
            place(Family::DoubleSided, 20, 0.1, 0.4),
            place(Family::DoubleSided, 40, 0.1, 0.4),
            place(Family::DoubleSided, 80, 0.1, 0.4),
        ],
    ),
    (
        "More and more coupling",
        &[
            place(Family::DoubleSided, 20, 0.0001, 0.4),
            place(Family::DoubleSided, 20, 0.001, 0.4),
            place(Family::DoubleSided, 20, 0.01, 0.4),
            place(Family::DoubleSided, 20, 0.03, 0.4),
            place(Family::DoubleSided, 20, 0.3, 0.4),
            place(Family::DoubleSided, 20, 1.0, 0.4),
        ],
    ),
    (
        "More and more asymmetry",
        &[
            place(Family::DoubleSided, 20, 0.01, 0.001),
            place(Family::DoubleSided, 20, 0.01, 0.1),
            place(Family::DoubleSided, 20, 0.01, 0.2),
            place(Family::DoubleSided, 20, 0.01, 0.6),
            place(Family::DoubleSided, 20, 0.01, 0.8),
        ],
    ),
    (
        "Single-sided breathers",
        &[
            place(Family::SingleSided, 20, 0.03, 0.8),
            place(Family::SingleSided, 40, 0.03, 0.8),
            place(Family::SingleSided, 80, 0.03, 0.8),
            place(Family::SingleSided, 40, 0.1, 0.4),
        ],
    ),
];

/// A stripe of the first harmonic, and its growth by both laws.
#[derive(Debug, Clone, Copy)]
struct Told {
    stripe: Stripe,
    modes: (usize, usize),
    /// No other stripe meets it.
    apart: bool,
    law: Option<f64>,
    weak: Option<f64>,
}

/// Runs the subcommand.
///
/// # Errors
/// [`CliError`].
pub fn run(args: &StripesArgs, console: &mut Console<'_>) -> Result<(), CliError> {
    let taken = distinct(&[], &[("--out", args.out.as_deref()), ("--plot", args.plot.as_deref())])?;
    let format = args.plot.as_deref().map(|path| Format::asked("--plot", path)).transpose()?;
    let picture = args.plot.as_deref().map(Output::create).transpose()?;
    let file = args.out.as_deref().map(|path| Output::document("--out", path)).transpose()?;
    let mut text = String::new();
    for (title, places) in TABLES {
        let _ = write!(text, "{title}:\n\n{HEADING}");
        for place in places {
            let _ = writeln!(text, "{}", row(place, &stripes(place)?));
        }
        text.push('\n');
    }
    if let (Some(picture), Some(format)) = (picture, format) {
        let bytes = curves_picture(&drawn()?, format).map_err(failed)?;
        picture.finish_with(&bytes)?;
    }
    match file {
        Some(file) => Ok(file.finish_with(text.trim_end().as_bytes())?),
        None => console.answer(text.trim_end(), false, taken),
    }
}

fn failed(error: impl std::fmt::Display) -> CliError {
    CliError::Computation(error.to_string())
}

fn stripe_line(&Place { family, n, gamma2, asymmetry }: &Place) -> Result<StripeLine, CliError> {
    let chain = Chain::new(n + 1, GAMMA1, gamma2).map_err(failed)?;
    let model = Model::conservative(chain, 1.0, asymmetry).map_err(failed)?;
    Ok(StripeLine { model, family, free: Parameter::Omega })
}

/// The modes of the breather at ω, if there is one, and its model.
fn modes(line: &StripeLine, omega: f64) -> Result<Option<(Model, DressedModes)>, CliError> {
    let model = line.model.with(Parameter::Omega, omega).map_err(failed)?;
    let (mut finder, mut found, mut modes) =
        (Finder::new(model.chain().sites()), OrbitList::default(), DressedModes::default());
    finder.find_symmetric(&model, line.family, &mut found).map_err(failed)?;
    let Some(orbit) = found.orbits.first() else { return Ok(None) };
    modes.replace(finder.prepared(orbit).map_err(failed)?).map_err(failed)?;
    Ok(Some((model, modes)))
}

/// The stripes of the first harmonic, whole ones, along ω.
fn stripes(place: &Place) -> Result<Vec<Told>, CliError> {
    let line = stripe_line(place)?;
    let top = 2.0 * (GAMMA1 + 4.0 * place.gamma2).sqrt();
    let row = StripeFinder::default().along(&line, (FROM, 1.01 * top), POINTS).map_err(failed)?;
    let mut told = Vec::new();
    for stripe in &row.stripes {
        let Some((pair, 1)) = stripe.pair else { continue };
        if stripe.ends != [StripeEnd::Edge; 2] {
            continue;
        }
        let met = |other: &&Stripe| (other.centre - stripe.centre).abs() < other.half_width + stripe.half_width;
        let Some((model, modes)) = modes(&line, stripe.centre)? else { continue };
        told.push(Told {
            stripe: *stripe,
            modes: pair,
            apart: row.stripes.iter().filter(met).count() == 1,
            law: growth_at_meeting(&modes, &model, pair),
            weak: weak_growth(&line, pair, 1),
        });
    }
    Ok(told)
}

const HEADING: &str = "\
| N | γ₂ | a | stripes | widths | strongest | × M | apart | growth : law | widths : law | growth : weak law |
|---:|---:|---:|---:|---:|---:|---:|---:|---:|---:|---:|
";

fn row(&Place { n, gamma2, asymmetry, .. }: &Place, all: &[Told]) -> String {
    let widths = spread(all.iter().map(|told| 2.0 * told.stripe.half_width));
    let strongest = all.iter().map(|told| told.stripe.growth).fold(0.0, f64::max);
    let apart: Vec<&Told> = all.iter().filter(|told| told.apart).collect();
    let ratios = |ratio: &dyn Fn(&Told) -> Option<f64>| match spread(apart.iter().filter_map(|told| ratio(told))) {
        Some([least, middle, most]) => format!("{least:.3} … {middle:.3} … {most:.3}"),
        None => "–".to_owned(),
    };
    let width = |told: &Told| PI * told.stripe.half_width / told.stripe.centre;
    format!(
        "| {n} | {gamma2} | {asymmetry} | {} | {} | {strongest:.2e} | {:.2e} | {} | {} | {} | {} |",
        all.len(),
        widths.map_or("–".to_owned(), |[least, _, most]| format!("{least:.1e} … {most:.1e}")),
        strongest * (n + 1) as f64,
        apart.len(),
        ratios(&|told| Some(told.stripe.growth / told.law?)),
        ratios(&|told| Some(width(told) / told.law?)),
        ratios(&|told| Some(told.stripe.growth / told.weak?)),
    )
}

/// The least, the one in the middle, the largest.
fn spread(values: impl Iterator<Item = f64>) -> Option<[f64; 3]> {
    let mut values: Vec<f64> = values.filter(|value| value.is_finite()).collect();
    values.sort_by(f64::total_cmp);
    Some([*values.first()?, *values.get(values.len() / 2)?, *values.last()?])
}

/// Growth of modes against themselves over ω, and width of one in the middle of the band over the coupling, both times M, in rings of all
/// lengths.
fn drawn() -> Result<Curves, CliError> {
    let pane = |caption: String, x: &str, y: &str, series: Vec<Series>| Pane {
        caption,
        x: x.to_owned(),
        y: y.to_owned(),
        x_range: None,
        x_log: false,
        scale: Scale::Logarithmic,
        levels: Vec::new(),
        uprights: Vec::new(),
        round: false,
        series,
    };
    Ok(Curves {
        title: format!("Stripes of double-sided breathers, a mode against itself, γ₁ = {GAMMA1}"),
        panes: vec![
            pane("γ₂ = 0.1, a = 0.4".to_owned(), "frequency ω", "M ln|μ|, M masses", over_omega(0.1, 0.4)?),
            pane(
                "q = π/2, a = 0.4 (above) and 0.04".to_owned(),
                "log₁₀ γ₂/γ₁",
                "M × width in ω",
                over_coupling([0.4, 0.04])?,
            ),
        ],
        columns: 2,
        pane: (560, 460),
        ..Curves::default()
    })
}

const LAW: usize = 4;

fn line(name: &str, stroke: Stroke, points: Vec<(f64, f64)>) -> Series {
    Series { name: name.to_owned(), colour: LAW, stroke, mark: Mark::None, points }
}

fn points(n: usize, number: usize, points: Vec<(f64, f64)>) -> Series {
    let (colour, mark) = (number, Mark::Small(number));
    Series { name: format!("N = {n}"), colour, stroke: Stroke::None, mark, points }
}

/// The law as the longest ring has it, and what is found. Rings of about one length look alike in both pictures.
fn over_omega(gamma2: f64, asymmetry: f64) -> Result<Vec<Series>, CliError> {
    let mut all = Vec::new();
    for (number, n) in [80, 20, 10, 5].into_iter().enumerate() {
        let told = stripes(&place(Family::DoubleSided, n, gamma2, asymmetry))?;
        let alike = told.iter().filter(|told| told.modes.0 == told.modes.1);
        let of = |growth: &dyn Fn(&Told) -> Option<f64>| -> Vec<_> {
            let place = |told: &Told| Some((told.stripe.centre, (n + 1) as f64 * growth(told)?));
            alike.clone().filter_map(place).collect()
        };
        if number == 0 {
            all.push(line("law", Stroke::Solid(1), of(&|told| told.law)));
        }
        all.push(points(n, number, of(&|told| Some(told.stripe.growth))));
    }
    Ok(all)
}

/// Decades of γ₂/γ₁ and steps in each.
const DECADES: [i32; 2] = [-4, 1];
const STEPS: i32 = 4;

/// Modes that have q = π/2 in rings of every second even length.
fn over_coupling(asymmetries: [f64; 2]) -> Result<Vec<Series>, CliError> {
    let gap = (f64::NAN, f64::NAN);
    let (mut all, mut law, mut weak) = (Vec::new(), Vec::new(), Vec::new());
    for (number, n) in [(0, 81), (1, 21), (3, 5)] {
        let (k, sites) = ((n - 1) / 4, (n + 1) as f64);
        let mut found = Vec::new();
        for asymmetry in asymmetries {
            for step in STEPS * DECADES[0]..=STEPS * DECADES[1] {
                let power = f64::from(step) / f64::from(STEPS);
                let line = stripe_line(&place(Family::DoubleSided, n, GAMMA1 * 10f64.powf(power), asymmetry))?;
                let (mut finder, mut omega) =
                    (StripeFinder::default(), 2.0 * (GAMMA1 * (1.0 + 2.0 * 10f64.powf(power))).sqrt());
                for _ in 0..APPROACH {
                    omega = modes(&line, omega)?.and_then(|(_, modes)| modes.frequency(k)).map_or(omega, |w| 2.0 * w);
                }
                let Ok(stripe) = finder.near(&line, (k, k), 1, omega) else { continue };
                let width = |growth: f64| 2.0 * sites * growth * stripe.centre / PI;
                found.push((power, 2.0 * sites * stripe.half_width));
                if number == 0 {
                    let told = modes(&line, stripe.centre)?;
                    let told = told.and_then(|(model, modes)| growth_at_meeting(&modes, &model, (k, k)));
                    law.extend(told.map(|growth| (power, width(growth))));
                    weak.extend(
                        weak_growth(&line, (k, k), 1).map(|growth| (power, width(growth))).filter(|_| power <= 0.0),
                    );
                }
            }
            law.push(gap);
            weak.push(gap);
        }
        all.push(points(n, number, found));
    }
    all.insert(0, line("law", Stroke::Solid(1), law));
    all.insert(1, line("law of weak coupling", Stroke::Dashed(1), weak));
    Ok(all)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test stops at the first surprise")]

    use super::*;

    #[test]
    fn the_document_has_the_rows_that_are_printed() {
        let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/stripes.md");
        let document = std::fs::read_to_string(path).unwrap();
        let mut checked = 0;
        for (title, places) in TABLES {
            assert!(document.contains(&format!("{title}:\n\n{HEADING}")), "{title}");
            // Longer rings take seconds each.
            for place in places.iter().filter(|place| place.n <= 20) {
                let row = row(place, &stripes(place).unwrap());
                assert!(document.contains(&row), "{row}");
                checked += 1;
            }
        }
        assert!(checked >= 14, "{checked}");
    }

    #[test]
    fn the_picture_has_a_point_for_each_ring_and_the_law_between() {
        let all = over_coupling([0.4, 0.04]).unwrap();
        let steps = (STEPS * (DECADES[1] - DECADES[0]) + 1) as usize;
        assert_eq!(all.len(), 5);
        for series in &all {
            let finite = series.points.iter().filter(|(_, y)| y.is_finite() && *y > 0.0).count();
            let least = if series.name.contains("weak") { 2 * (steps - STEPS as usize) } else { 2 * (steps - 2) };
            assert!(finite >= least && finite <= 2 * steps, "{} {finite}", series.name);
        }
    }
}
