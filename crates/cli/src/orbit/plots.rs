//! Pictures of a chain's orbits. `mapgen orbit --all-plots`: seven of each solution, six of one with impacts at several sites or not on a ring.
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

use std::path::Path;

use vibrochain_breather::{BreatherError, Finder, Impact, Motion, Orbit};
use vibrochain_floquet::{Complex, FloquetMode, Verdict, leading_modes};
use vibrochain_lattice::{Decay, Ends, Spectrum, decay};

use crate::common::caption::{beside, describe};
use crate::common::error::CliError;
use crate::common::solution::Solution;
use crate::orbit::pictures::{Folder, Pictured};
use vibrochain_plot::field::FieldWriter;
pub(crate) use vibrochain_plot::loss;
use vibrochain_plot::{
    Mark, OrbitPanels, Page, Pane, Profile, Scale, Series, Spacetime, Stroke, Trace, portrait_pane, profile_pane,
    spacetime_picture, trace_pane,
};

/// Samples of one flight between impacts.
const FLIGHT: usize = 160;

/// Harmonics among which the slowest decay is looked for: later ones decay faster.
const HARMONICS: u64 = 1000;

/// Corners of the unit circle.
const CIRCLE: u32 = 180;

/// Points of a trace: a few pixels each, smooth to the eye.
const SAMPLES: usize = 160;

impl Pictured for Solution {
    fn panels(&self, number: usize) -> Result<OrbitPanels, CliError> {
        let orbit = &self.orbit;
        let mut motion = Motion::of(orbit)?;
        let at = |impacts: &[Impact]| format!("at t = {:.4}", impacts.first().map_or(0.0, |impact| impact.time));
        let profiles = profiles(orbit, &mut motion, at);
        // Between samples the tips of a trace, which are its impacts, would be cut off.
        let impacts = orbit.impacts().iter().map(|impact| (impact.time / orbit.period()).rem_euclid(1.0));
        let mut parts: Vec<f64> = (0..=SAMPLES).map(|k| k as f64 / SAMPLES as f64).chain(impacts).collect();
        parts.sort_by(f64::total_cmp);
        let trace = |site| {
            let at = |part: &f64| [*part, motion.at(site, part * orbit.period()).displacement, f64::NAN];
            Trace { name: format!("site {site}"), flights: vec![parts.iter().map(at).collect()], ..Trace::default() }
        };
        let traces: Vec<Trace> = orbit.hit_sites().into_iter().map(trace).collect();
        let y = if traces.len() == 1 { "impacting mass u₀" } else { "impacting masses uₙ" };
        let verdict = self.multipliers.as_ref().ok().map(|all| &all.verdict);
        let state = state(self.admissibility.is_physical(), verdict);
        let caption = format!("{} breather {number}: {}; {state}", orbit.name(), describe(orbit.model()));
        let panes = [profile_pane(along(orbit), profiles), trace_pane(y, &traces)];
        let panes = panes.map(|pane| Pane { levels: barriers(orbit), ..pane }).to_vec();
        Ok(OrbitPanels { caption, panes })
    }

    /// Without stability those of multipliers and eigenvector are left out.
    fn write(&self, folder: &Path, page: Page, number: usize) -> Result<(), CliError> {
        let orbit = &self.orbit;
        let title = format!("{} breather {number}: {}", orbit.name(), describe(orbit.model()));
        let folder = Folder { path: folder, page, number, title };
        folder.save("profile", (960, 480), vec![profile(orbit)?])?;
        let (trace, phase) = flights(orbit)?;
        folder.save("trace", (960, 480), vec![trace])?;
        folder.save("phase", (960, 560), vec![phase])?;
        let picture = spacetime_picture(&spacetime(orbit, folder.title.clone())?, page);
        folder.write("spacetime", &picture.map_err(|error| CliError::Computation(error.to_string()))?)?;
        if orbit.centre().is_some() {
            folder.save("decay", (960, 520), vec![decay_pane(orbit)?])?;
        }
        if let Ok(all) = &self.multipliers {
            folder.save(
                "multipliers",
                (960, 760),
                vec![multiplier_pane(&all.sorted().collect::<Vec<_>>(), &all.verdict)],
            )?;
            folder.save("eigenvector", (660, 480), eigenvector(orbit, all.verdict.leading)?)?;
        }
        Ok(())
    }
}

/// Physical or not, stable or how not, for captions.
pub(crate) fn state(is_physical: bool, verdict: Option<&Verdict>) -> String {
    match verdict {
        _ if !is_physical => "not physical".to_owned(),
        None => "physical".to_owned(),
        Some(verdict) => match verdict.mechanism {
            None if verdict.marginal => "marginal".to_owned(),
            None => "stable".to_owned(),
            Some(mechanism) => format!("unstable, {}, |μ| = {:.6}", loss(mechanism), verdict.spectral_radius),
        },
    }
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
    Pane { caption: caption.to_owned(), x: x.to_owned(), y: y.to_owned(), series, ..Pane::default() }
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
    Ok(Pane { levels: barriers(orbit), ..profile_pane(along(orbit), lines) })
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
    let intervals = motion.intervals();
    let mut trace = |site: usize, name: &str| {
        let flight = |i: usize| {
            let (start, length) = motion.interval(i);
            let point = |k: usize| {
                let elapsed = length * k as f64 / FLIGHT as f64;
                motion.seek(i, elapsed);
                let now = motion.site(site);
                [(start + elapsed) / orbit.period(), now.displacement, now.velocity]
            };
            (0..=FLIGHT).map(point).collect()
        };
        Trace { name: name.to_owned(), flights: (0..intervals).map(flight).collect(), ..Trace::default() }
    };
    let mut traces = vec![trace(home, "impacting mass u₀")];
    let phase = portrait_pane("displacement u₀", "velocity of the impacting mass", &traces[0]);
    let phase = Pane { uprights: barriers(orbit), ..phase };
    if next != home {
        traces.push(trace(next, "its neighbour u₁"));
    }
    let trace = trace_pane("displacement", &traces);
    Ok((Pane { x: "time t/T".to_owned(), levels: barriers(orbit), ..trace }, phase))
}

/// Multipliers, by falling modulus, in the plane.
pub(crate) fn multiplier_pane(all: &[Complex<f64>], verdict: &Verdict) -> Pane {
    let circle = (0..=CIRCLE).map(|k| std::f64::consts::TAU * f64::from(k) / f64::from(CIRCLE));
    let circle = circle.map(|t| (t.cos(), t.sin())).collect();
    let place = |z: &Complex<f64>| (z.re, z.im);
    let leading = all.iter().filter(|z| verdict.mechanism.is_some() && same(z, &verdict.leading));
    let leading: Vec<_> = leading.map(place).collect();
    let all = all.iter().map(place).collect();
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
