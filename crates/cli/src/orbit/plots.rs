//! `mapgen orbit --all-plots`: seven pictures of each solution, six of one with impacts at several sites or not on a ring.
//!
//! | file | shows |
//! |---|---|
//! | `solution-K-profile` | displacements of all masses at the impacts |
//! | `solution-K-spacetime` | displacements of all masses over a period, and its impacts |
//! | `solution-K-trace` | the impacting mass and its neighbour over a period |
//! | `solution-K-phase` | phase portrait of the impacting mass, impacts as jumps |
//! | `solution-K-multipliers` | Floquet multipliers and the unit circle |
//! | `solution-K-eigenvector` | the perturbation that belongs to the leading multiplier |
//! | `solution-K-decay` | of one impact site on a ring: distance from the uniform motion, site by site, on a logarithmic axis |

use std::ffi::OsStr;
use std::path::Path;

use vibrochain_breather::{BreatherError, Finder, Impact, Motion, Orbit};
use vibrochain_floquet::{Complex, FloquetMode, Multipliers, leading_modes};
use vibrochain_lattice::{Decay, Ends, Spectrum, decay};

use crate::common::caption::{beside, describe};
use crate::common::error::CliError;
use vibrochain_maps::files::Output;
use vibrochain_plot::field::FieldWriter;
pub(crate) use vibrochain_plot::loss;
use vibrochain_plot::{
    Curves, Mark, Page, Pane, Profile, Scale, Series, Spacetime, Stroke, curves_picture, spacetime_picture,
};

/// Samples of one flight between impacts.
const FLIGHT: usize = 160;

/// Harmonics among which the slowest decay is looked for: later ones decay faster.
const HARMONICS: u64 = 1000;

/// Corners of the unit circle.
const CIRCLE: u32 = 180;

fn computation(error: impl std::fmt::Display) -> CliError {
    CliError::Computation(error.to_string())
}

/// Begins the names of all files here.
const NAME: &str = "solution-";

/// Whether a name may be that of a file here.
pub(crate) fn is_own(name: &OsStr) -> bool {
    name.to_string_lossy().starts_with(NAME)
}

/// Writes the pictures of solution number `number`. Without stability those of multipliers and eigenvector are left out.
///
/// # Errors
/// [`CliError`].
pub(crate) fn write(
    folder: &Path,
    page: Page,
    number: usize,
    orbit: &Orbit,
    all: Option<&Multipliers>,
) -> Result<(), CliError> {
    let title = format!("{} breather {number}: {}", orbit.name(), describe(orbit.model()));
    let ending = page.format.ending();
    let save = |name: &str, pane: (u32, u32), panes: Vec<Pane>| {
        let columns = panes.len();
        let picture = Curves { title: title.clone(), panes, columns, pane, ..Curves::default() };
        let bytes = curves_picture(&picture, page).map_err(computation)?;
        let file = Output::create(&folder.join(format!("{NAME}{number}-{name}.{ending}")))?;
        Ok::<_, CliError>(file.finish_with(&bytes)?)
    };
    save("profile", (960, 480), vec![profile(orbit)?])?;
    let (trace, phase) = flights(orbit)?;
    save("trace", (960, 480), vec![trace])?;
    save("phase", (960, 560), vec![phase])?;
    let picture = spacetime_picture(&spacetime(orbit, title.clone())?, page).map_err(computation)?;
    let file = Output::create(&folder.join(format!("{NAME}{number}-spacetime.{ending}")))?;
    file.finish_with(&picture)?;
    if orbit.centre().is_some() {
        save("decay", (960, 520), vec![decay_pane(orbit)?])?;
    }
    if let Some(all) = all {
        save("multipliers", (960, 760), vec![multipliers(all)])?;
        save("eigenvector", (660, 480), eigenvector(orbit, all.verdict.leading)?)?;
    }
    Ok(())
}

/// What stands below profiles.
pub(crate) fn along(orbit: &Orbit) -> &'static str {
    if orbit.model().chain().ends() == Ends::Closed { "site n, from the impacting mass" } else { "site n" }
}

/// The masses of each layer by their place below profiles: in a closed row by offset from the first impact, −⌊(M−1)/2⌋ … ⌊M/2⌋.
pub(crate) fn rows(orbit: &Orbit) -> Vec<Vec<(f64, usize)>> {
    let chain = orbit.model().chain();
    let length = chain.length() as i64;
    let home = orbit.impacts().first().map_or(0, |impact| impact.site as i64 % length);
    let (from, home) = if chain.ends() == Ends::Closed { (-(length - 1) / 2, home) } else { (0, 0) };
    let row = |layer: i64| {
        let place = |n: i64| (n as f64, (layer * length + (home + n).rem_euclid(length)) as usize);
        (from..from + length).map(place).collect()
    };
    (0..chain.layers() as i64).map(row).collect()
}

/// The most lines of a profile; of more layers the first instant is shown alone.
const MOST_LINES: usize = 8;

/// Displacements below each other: a line for every instant of impacts and layer, named by `name` and the layer, with the number of
/// the instant.
pub(crate) fn profiles(orbit: &Orbit, motion: &mut Motion, name: impl Fn(&[Impact]) -> String) -> Vec<Profile> {
    let (rows, mut lines) = (rows(orbit), Vec::new());
    let instants = if rows.len() == 1 { usize::MAX } else { (MOST_LINES / rows.len()).max(1) };
    for (i, impacts) in orbit.instants().take(instants).enumerate() {
        let Some(first) = impacts.first() else { continue };
        let v = motion.displacements(first.time);
        for (layer, row) in rows.iter().enumerate() {
            let of_layer = if rows.len() == 1 { String::new() } else { format!(", layer {layer}") };
            let points = row.iter().map(|&(n, site)| (n, v[site])).collect();
            lines.push(Profile { name: format!("{}{of_layer}", name(impacts)), instant: i, points });
        }
    }
    lines
}

fn pane(caption: &str, x: &str, y: &str, series: Vec<Series>) -> Pane {
    Pane {
        caption: caption.to_owned(),
        x: x.to_owned(),
        y: y.to_owned(),
        x_range: None,
        x_log: false,
        scale: Scale::Linear,
        levels: Vec::new(),
        round: false,
        series,
    }
}

fn barriers(orbit: &Orbit) -> Vec<f64> {
    let a = orbit.model().asymmetry();
    vec![a - 1.0, a + 1.0]
}

fn impact_name(orbit: &Orbit, impact: &Impact) -> String {
    format!("{} barrier, t/T = {:.4}", impact.barrier.name(), impact.time / orbit.period())
}

fn profile(orbit: &Orbit) -> Result<Pane, BreatherError> {
    let name = |impacts: &[Impact]| match impacts {
        [impact] => format!("impact on the {}", impact_name(orbit, impact)),
        _ => format!("impacts at t/T = {:.4}", impacts.first().map_or(0.0, |impact| impact.time / orbit.period())),
    };
    let lines = profiles(orbit, &mut Motion::of(orbit)?, name);
    let series = lines.into_iter().enumerate().map(|(colour, Profile { name, instant, points })| {
        let (stroke, mark) =
            if instant == 0 { (Stroke::Solid(2), Mark::Filled(0)) } else { (Stroke::Dashed(2), Mark::Hollow(3)) };
        Series { name, colour, stroke, mark, points }
    });
    let pane = pane("", along(orbit), "displacement uₙ", series.collect());
    Ok(Pane { levels: barriers(orbit), ..pane })
}

/// Samples of a period in space and time: a column for every other pixel.
const COLUMNS: u64 = 450;

fn spacetime(orbit: &Orbit, title: String) -> Result<Spacetime, BreatherError> {
    let mut motion = Motion::of(orbit)?;
    let mut field = FieldWriter::new(orbit.model().chain(), 1.0, COLUMNS);
    for k in 0..=COLUMNS {
        let part = k as f64 / COLUMNS as f64;
        field.see(&motion.displacements(part * orbit.period()), part);
    }
    let a = orbit.model().asymmetry();
    let impacts = orbit.impacts().iter().map(|impact| (impact.time / orbit.period(), impact.site)).collect();
    Ok(Spacetime { title, barriers: (a - 1.0, a + 1.0), field: field.finish(), impacts })
}

/// The traces over a period, and the phase portrait.
fn flights(orbit: &Orbit) -> Result<(Pane, Pane), BreatherError> {
    let mut motion = Motion::of(orbit)?;
    let home = orbit.impacts().first().map_or(0, |impact| impact.site);
    let [left, right, ..] = orbit.model().chain().neighbours(home);
    let next = right.filter(|&n| n != home).or(left).unwrap_or(home);
    let (mut own, mut neighbour) = (Vec::new(), Vec::new());
    let (mut flight, mut jumps, mut before, mut after) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
    let mut ends: Vec<((f64, f64), (f64, f64))> = Vec::new();
    for i in 0..motion.intervals() {
        let (start, length) = motion.interval(i);
        let mut ends_of = ((0.0, 0.0), (0.0, 0.0));
        for k in 0..=FLIGHT {
            let elapsed = length * k as f64 / FLIGHT as f64;
            motion.seek(i, elapsed);
            let now = motion.site(home);
            let time = (start + elapsed) / orbit.period();
            own.push((time, now.displacement));
            neighbour.push((time, motion.site(next).displacement));
            let here = (now.displacement, now.velocity);
            flight.push(here);
            if k == 0 {
                ends_of.0 = here;
            }
            ends_of.1 = here;
        }
        flight.push((f64::NAN, f64::NAN));
        ends.push(ends_of);
    }
    for (i, &(start, _)) in ends.iter().enumerate() {
        let from = ends[(i + ends.len() - 1) % ends.len()].1;
        before.push(from);
        after.push(start);
        jumps.extend([from, start, (f64::NAN, f64::NAN)]);
    }
    let line = |name: &str, colour, stroke, points| {
        let name = name.to_owned();
        Series { name, colour, stroke, mark: Mark::None, points }
    };
    let dots = |name: &str, colour, mark, points| {
        let name = name.to_owned();
        Series { name, colour, stroke: Stroke::None, mark, points }
    };
    let mut traces = vec![line("impacting mass u₀", 0, Stroke::Solid(3), own)];
    if next != home {
        traces.push(line("its neighbour u₁", 1, Stroke::Dashed(2), neighbour));
    }
    let trace = pane("", "time t/T", "displacement", traces);
    let portrait = vec![
        line("flight", 0, Stroke::Solid(2), flight),
        line("impact", 5, Stroke::Dashed(2), jumps),
        dots("before", 1, Mark::Filled(3), before),
        dots("after", 1, Mark::Hollow(0), after),
    ];
    let phase = pane("", "displacement u₀", "velocity of the impacting mass", portrait);
    Ok((Pane { x_range: Some(0.0..1.0), levels: barriers(orbit), ..trace }, phase))
}

fn multipliers(all: &Multipliers) -> Pane {
    let circle = (0..=CIRCLE).map(|k| std::f64::consts::TAU * f64::from(k) / f64::from(CIRCLE));
    let circle = circle.map(|t| (t.cos(), t.sin())).collect();
    let place = |z: Complex<f64>| (z.re, z.im);
    let verdict = all.verdict;
    let leading = all.sorted().filter(|z| verdict.mechanism.is_some() && same(z, &verdict.leading));
    let leading: Vec<_> = leading.map(place).collect();
    let all = all.sorted().map(place).collect();
    let series =
        |name: &str, colour, stroke, mark, points| Series { name: name.to_owned(), colour, stroke, mark, points };
    let state = verdict.mechanism.map_or(if verdict.stable { "stable" } else { "marginal" }.to_owned(), |mechanism| {
        format!("unstable, {}", loss(mechanism))
    });
    let caption =
        format!("{state}; |μ| = {:.9}, leading μ = {}", verdict.spectral_radius, in_six_digits(verdict.leading));
    let mut all = vec![
        series("unit circle", 5, Stroke::Solid(1), Mark::None, circle),
        series("multipliers", 0, Stroke::None, Mark::Filled(0), all),
    ];
    if !leading.is_empty() {
        all.push(series("leading", 1, Stroke::None, Mark::Hollow(3), leading));
    }
    Pane { round: true, ..pane(&caption, "Re μ", "Im μ", all) }
}

/// "0.600000 + 0.800000i"; a real number has no imaginary part to show.
fn in_six_digits(z: Complex<f64>) -> String {
    let sign = if z.im < 0.0 { '−' } else { '+' };
    let imaginary = if z.im == 0.0 { String::new() } else { format!(" {sign} {:.6}i", z.im.abs()) };
    format!("{:.6}{imaginary}", z.re).replace('-', "−")
}

/// The leading multiplier or its conjugate.
fn same(a: &Complex<f64>, b: &Complex<f64>) -> bool {
    let close = 1e-9 * (1.0 + b.norm());
    (a - b).norm() < close || (a.conj() - b).norm() < close
}

fn eigenvector(orbit: &Orbit, leading: Complex<f64>) -> Result<Vec<Pane>, CliError> {
    let mut finder = Finder::new(orbit.model().chain().sites());
    let mode = match FloquetMode::of(orbit, &mut finder, leading) {
        Ok(mode) => Some(mode),
        // The secular form does not know it: by a dense matrix.
        Err(_) => leading_modes(orbit, 1)?.pop(),
    };
    let Some(mode) = mode else { return Ok(Vec::new()) };
    let turning = mode.multiplier.im != 0.0;
    // Layer upon layer the x axis goes on.
    let row: Vec<(f64, usize)> = match rows(orbit) {
        mut rows if rows.len() == 1 => rows.remove(0),
        _ => (0..orbit.model().chain().sites()).map(|n| (n as f64, n)).collect(),
    };
    let x = if orbit.model().chain().layers() == 1 { along(orbit) } else { "site, layer after layer" };
    let part = |name: &str, colour, stroke, mark, of: &dyn Fn(usize) -> f64| Series {
        name: name.to_owned(),
        colour,
        stroke,
        mark,
        points: row.iter().map(|&(n, site)| (n, of(site))).collect(),
    };
    let panel = |caption: &str, letter: &str, values: &[Complex<f64>]| {
        let mut series = vec![part("real part", 0, Stroke::Solid(2), Mark::Filled(0), &|n| values[n].re)];
        if turning {
            series.push(part("imaginary part", 1, Stroke::Dashed(2), Mark::Hollow(3), &|n| values[n].im));
        }
        pane(caption, x, letter, series)
    };
    let caption = format!("leading perturbation just before the first impact, |μ| = {:.6}", mode.multiplier.norm());
    Ok(vec![
        panel(&caption, "displacement δuₙ", &mode.displacement),
        panel("its velocities", "velocity δu\u{307}ₙ", &mode.velocity),
    ])
}

/// |v_n − G| at the impacts, each site in full relative accuracy: by harmonics, of which every one falls from site to site
/// by its own factor. The modal sum, which keeps absolute accuracy, stands beside it.
fn decay_pane(orbit: &Orbit) -> Result<Pane, BreatherError> {
    let model = orbit.model();
    let chain = model.chain();
    let spectrum = Spectrum::new(*chain);
    let mut motion = Motion::of(orbit)?;
    let home = orbit.impact_site().unwrap_or(0);
    let mut all = Vec::new();
    for (i, impact) in orbit.impacts().iter().enumerate() {
        let uniform = orbit.steady().at(impact.site).value(impact.time + orbit.psi().unwrap_or(0.0));
        let v = motion.displacements(impact.time);
        let field = |n: usize| if n == 0 { v[home] - uniform } else { beside(orbit, &spectrum, n, impact.time) };
        let points = (0..chain.even_modes()).map(|n| (n as f64, field(n).abs())).collect();
        let (stroke, mark) =
            if i == 0 { (Stroke::Solid(2), Mark::Filled(0)) } else { (Stroke::Solid(2), Mark::Filled(3)) };
        all.push(Series {
            name: format!("impact on the {}", impact_name(orbit, impact)),
            colour: i,
            stroke,
            mark,
            points,
        });
        if i == 0 {
            let modal = (0..chain.even_modes()).map(|n| (n as f64, (v[(home + n) % chain.sites()] - uniform).abs()));
            let (name, stroke, mark) = ("the same by the sum over modes".to_owned(), Stroke::None, Mark::Hollow(1));
            all.push(Series { name, colour: 4, stroke, mark, points: modal.collect() });
        }
    }
    let caption = match slowest(orbit) {
        None => "a harmonic of the breather lies in the band of the ring: no decay".to_owned(),
        Some((0, factor)) => format!("slowest decay: the mean over a period, factor {factor:.6} from site to site"),
        Some((j, factor)) => format!("slowest decay: harmonic {j}, factor {factor:.6} from site to site"),
    };
    let pane = pane(&caption, "distance from the impacting mass, in sites", "|uₙ − uniform motion|", all);
    Ok(Pane { scale: Scale::Logarithmic, ..pane })
}

/// The harmonic present that decays the slowest, and its factor per site; `None` if one propagates.
fn slowest(orbit: &Orbit) -> Option<(u64, f64)> {
    let chain = orbit.model().chain();
    let mut slowest = (0, 0.0_f64);
    // Equal and opposite impulses half a period apart make odd harmonics alone.
    let present = |j: u64| {
        let phase = |t: f64| std::f64::consts::TAU * j as f64 * t / orbit.period();
        let (re, im) = orbit.impacts().iter().fold((0.0, 0.0), |(re, im), impact| {
            let (sin, cos) = phase(impact.time).sin_cos();
            (re + impact.impulse * cos, im + impact.impulse * sin)
        });
        let most = orbit.impacts().iter().map(|impact| impact.impulse.abs()).fold(0.0, f64::max);
        f64::hypot(re, im) > 1e-12 * most
    };
    for j in (0..HARMONICS).filter(|&j| (j > 0 || chain.gamma1() > 0.0) && present(j)) {
        match decay(chain, j as f64 * orbit.frequency()) {
            Decay::Propagating(_) => return None,
            Decay::Evanescent(factor) if factor.abs() > slowest.1.abs() => slowest = (j, factor),
            Decay::Evanescent(_) => {}
        }
    }
    Some(slowest)
}
