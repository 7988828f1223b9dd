//! Panels of a chain's orbit: displacements along it, what is hit over a period, its phase portrait, its multipliers.

use vibrochain_breather::{BreatherError, Impact, LatticeOrbit, Motion, Orbit};
use vibrochain_floquet::{Complex, Verdict};
use vibrochain_lattice::Ends;

use crate::map::classes::loss;
use crate::panels::curves::{Mark, Pane, Series, Stroke};
use crate::panels::orbit::{Profile, Trace, portrait_pane, profile_pane, trace_pane};

/// Samples of one flight between impacts.
const FLIGHT: usize = 160;

/// Corners of the unit circle.
const CIRCLE: u32 = 180;

/// Points of a trace: a few pixels each, smooth to the eye.
const SAMPLES: usize = 160;

/// Its panels: the profile at its impacts, and what is hit over a period.
///
/// # Errors
/// [`BreatherError`] at a resonance.
pub fn orbit_panes(orbit: &Orbit) -> Result<[Pane; 2], BreatherError> {
    let (lattice, mut motion) = (orbit.lattice()?, Motion::of(orbit)?);
    let at = |impacts: &[Impact]| format!("at t/T = {:.4}", part(orbit, impacts));
    let profiles = profiles(lattice, &mut motion, at);
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
    let panes = [profile_pane(along(lattice), profiles), trace_pane(y, &traces)];
    Ok(panes.map(|pane| Pane { levels: barriers(lattice), ..pane }))
}

/// Physical or not, stable or how not, for captions.
#[must_use]
pub fn state(is_physical: bool, verdict: Option<&Verdict>) -> String {
    match verdict {
        _ if !is_physical => "not physical".to_owned(),
        None => "physical".to_owned(),
        Some(verdict) => match verdict.mechanism {
            None if verdict.undecided => "undecided".to_owned(),
            None => "stable".to_owned(),
            Some(mechanism) => format!("unstable, {}, |μ| = {:.6}", loss(mechanism), verdict.spectral_radius),
        },
    }
}

/// What stands below profiles.
#[must_use]
pub fn along(orbit: LatticeOrbit<'_>) -> &'static str {
    if orbit.model().chain().ends() == Ends::Closed { "site n, from the impacting mass" } else { "site n" }
}

/// The masses of each layer by their place below profiles: in a closed row by offset from the first impact, −⌊(M−1)/2⌋ … ⌊M/2⌋.
#[must_use]
pub fn rows(orbit: LatticeOrbit<'_>) -> Vec<Vec<(f64, usize)>> {
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
fn profiles(orbit: LatticeOrbit<'_>, motion: &mut Motion, name: impl Fn(&[Impact]) -> String) -> Vec<Profile> {
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

fn barriers(orbit: LatticeOrbit<'_>) -> Vec<f64> {
    let a = orbit.model().asymmetry();
    vec![a - 1.0, a + 1.0]
}

/// When impacts of one instant are, as a part of the period.
fn part(orbit: &Orbit, impacts: &[Impact]) -> f64 {
    impacts.first().map_or(0.0, |impact| impact.time / orbit.period())
}

/// Where and when an impact is, in parts of the period.
#[must_use]
pub fn impact_name(orbit: &Orbit, impact: &Impact) -> String {
    format!("{} barrier, t/T = {:.4}", impact.barrier.name(), impact.time / orbit.period())
}

/// The profile at its impacts, each named by its barrier.
///
/// # Errors
/// [`BreatherError`] at a resonance.
pub fn orbit_profile(orbit: &Orbit) -> Result<Pane, BreatherError> {
    let name = |impacts: &[Impact]| match impacts {
        [impact] => format!("impact on the {}", impact_name(orbit, impact)),
        _ => format!("impacts at t/T = {:.4}", part(orbit, impacts)),
    };
    let lattice = orbit.lattice()?;
    let lines = profiles(lattice, &mut Motion::of(orbit)?, name);
    Ok(Pane { levels: barriers(lattice), ..profile_pane(along(lattice), lines) })
}

/// The traces over a period of the impacting mass and its neighbour, and the phase portrait.
///
/// # Errors
/// [`BreatherError`] at a resonance.
pub fn orbit_flights(orbit: &Orbit) -> Result<(Pane, Pane), BreatherError> {
    let mut motion = Motion::of(orbit)?;
    let home = orbit.impacts().first().map_or(0, |impact| impact.site);
    let lattice = orbit.lattice()?;
    let [left, right, ..] = lattice.model().chain().neighbours(home);
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
    let phase = Pane { uprights: barriers(lattice), ..phase };
    if next != home {
        traces.push(trace(next, "its neighbour u₁"));
    }
    let trace = trace_pane("displacement", &traces);
    Ok((Pane { x: "time t/T".to_owned(), levels: barriers(lattice), ..trace }, phase))
}

/// Multipliers, by falling modulus, in the plane.
#[must_use]
pub fn multiplier_pane(all: &[Complex<f64>], verdict: &Verdict) -> Pane {
    let circle = (0..=CIRCLE).map(|k| std::f64::consts::TAU * f64::from(k) / f64::from(CIRCLE));
    let place = |z: &Complex<f64>| (z.re, z.im);
    let leading = all.iter().filter(|z| verdict.mechanism.is_some() && same(z, &verdict.leading));
    let leading: Vec<_> = leading.map(place).collect();
    let state = verdict.mechanism.map_or(if verdict.stable { "stable" } else { "undecided" }.to_owned(), |mechanism| {
        format!("unstable, {}", loss(mechanism))
    });
    let caption =
        format!("{state}; |μ| = {:.9}, leading μ = {}", verdict.spectral_radius, in_six_digits(verdict.leading));
    let mut all = vec![
        Series::line("unit circle", 5, Stroke::Solid(1), circle.map(|t| (t.cos(), t.sin()))),
        Series::marks("multipliers", 0, Mark::Filled(0), all.iter().map(place)),
    ];
    if !leading.is_empty() {
        all.push(Series::marks("leading", 1, Mark::Hollow(3), leading));
    }
    Pane { round: true, ..Pane::titled(&caption, "Re μ", "Im μ", all) }
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
