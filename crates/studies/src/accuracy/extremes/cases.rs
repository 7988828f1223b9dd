//! The corners, one function each: parameter points and what is looked at there.

use vibrochain_breather::{Family, Finder, NoBreather, OrbitList};
use vibrochain_lattice::{Chain, Model, ParameterError, Point, Spectrum};
use vibrochain_truth::DEFAULT_BITS;

use super::checks::{
    Depth, Row, Spectra, check_kernels, check_orbits, check_profile, check_simulation, check_uncoupled,
};
use vibrochain_cli::common::error::CliError;
use vibrochain_maps::numbers::Number;

/// Everything, in 57 digits, of a few orbits where there are hundreds.
const DEPTH: Depth = Depth { orbits: 6, spectra: Spectra::Compared, bits: DEFAULT_BITS };

/// Binary digits of the truth for large rings, where each takes its time.
const FEW: usize = 64;

/// Masses of the paper's default ring.
const SITES: usize = 21;

/// γ₁, γ₂, ω and a.
#[derive(Clone, Copy)]
struct At {
    g1: f64,
    g2: f64,
    omega: f64,
    a: f64,
}

/// The paper's.
const DEFAULTS: At = At { g1: 0.2, g2: 0.1, omega: 1.5, a: 0.4 };

/// How much of the slow corners is done.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Effort {
    /// Masses of the largest ring.
    pub sites: usize,
    /// Periods of the longest simulation.
    pub periods: u64,
}

impl Effort {
    /// All of it: 10⁵ masses, 10⁶ periods.
    pub const FULL: Self = Self { sites: 100_000, periods: 1_000_000 };
    /// For tests without optimisation.
    pub const QUICK: Self = Self { sites: 1000, periods: 10_000 };
}

/// A corner: its name, and its rows.
type Corner = (&'static str, fn(&str, Effort) -> Result<Vec<Row>, CliError>);

/// All corners, in the order of the table.
pub const CORNERS: [Corner; 12] = [
    ("no and weak coupling", weak_coupling),
    ("stiff and soft coupling", stiffness_ratio),
    ("no and soft on-site springs", soft),
    ("next to the band", band_edge),
    ("next to a resonance", resonance),
    ("slow and fast breathers", frequencies),
    ("asymmetry at its ends", asymmetry),
    ("elastic and dead impacts under a force", restitution),
    ("force at its threshold and far above", force),
    ("grazing", grazing),
    ("smallest and largest rings", rings),
    ("far field and long times", far),
];

/// Runs a corner.
///
/// # Errors
/// [`CliError`] where the truth cannot be had.
pub fn rows((name, run): &Corner, effort: Effort) -> Result<Vec<Row>, CliError> {
    run(name, effort)
}

fn truth(error: impl std::fmt::Display) -> CliError {
    CliError::Computation(error.to_string())
}

fn conservative(sites: usize, at: At) -> Result<Model, ParameterError> {
    Model::conservative(Chain::new(sites, at.g1, at.g2)?, at.omega, at.a)
}

/// Kernels, both conservative families and their multipliers.
fn all(case: &str, sites: usize, point: At) -> Result<Vec<Row>, CliError> {
    let model = conservative(sites, point)?;
    let mut rows = vec![check_kernels(case, model.chain(), point.omega, DEFAULT_BITS).map_err(truth)?];
    for family in [Family::DoubleSided, Family::SingleSided] {
        rows.extend(check_orbits(case, &model, family, DEPTH));
    }
    Ok(rows)
}

fn forced(case: &str, At { g1, g2, omega, a }: At, (amplitude, e): (f64, f64)) -> Result<Vec<Row>, CliError> {
    let ring = Point::ring(SITES).gamma1(g1).gamma2(g2);
    let model = ring.omega(omega).asymmetry(a).amplitude(amplitude).restitution(e).model()?;
    let families = [Family::DoubleSided, Family::SingleSided, Family::PeriodDoubled];
    Ok(families.into_iter().flat_map(|family| check_orbits(case, &model, family, DEPTH)).collect())
}

fn weak_coupling(_: &str, _: Effort) -> Result<Vec<Row>, CliError> {
    let mut rows = Vec::new();
    for g2 in [0.0, 1e-300, 1e-12] {
        let case = format!("γ₂ = {}", Number(g2));
        rows.push(check_uncoupled(&case, &conservative(SITES, At { g2, ..DEFAULTS })?).map_err(truth)?);
        rows.extend(all(&case, SITES, At { g2, ..DEFAULTS })?);
        rows.extend(forced(&case, At { g2, ..DEFAULTS }, (0.1, 0.9))?);
    }
    Ok(rows)
}

fn stiffness_ratio(_: &str, _: Effort) -> Result<Vec<Row>, CliError> {
    let mut rows = all("γ₂/γ₁ = 1e8", SITES, At { g1: 1e-8, g2: 1.0, omega: 2.5, ..DEFAULTS })?;
    rows.extend(all("γ₂/γ₁ = 1e8, ω in the band", SITES, At { g1: 1e-8, g2: 1.0, omega: 1.1, ..DEFAULTS })?);
    rows.extend(all("γ₂/γ₁ = 1e-8", SITES, At { g1: 1.0, g2: 1e-8, omega: 1.5, ..DEFAULTS })?);
    rows.extend(forced("γ₂/γ₁ = 1e8", At { g1: 1e-8, g2: 1.0, omega: 2.5, ..DEFAULTS }, (1.0, 0.9))?);
    rows.extend(forced("γ₂/γ₁ = 1e-8", At { g1: 1.0, g2: 1e-8, omega: 1.5, ..DEFAULTS }, (0.3, 0.9))?);
    Ok(rows)
}

fn soft(_: &str, _: Effort) -> Result<Vec<Row>, CliError> {
    let mut rows = Vec::new();
    for g1 in [0.0, 1e-14] {
        let case = format!("γ₁ = {}", Number(g1));
        rows.extend(all(&case, SITES, At { g1, ..DEFAULTS })?);
        rows.extend(forced(&case, At { g1, ..DEFAULTS }, (0.5, 0.9))?);
    }
    Ok(rows)
}

fn band_edge(_: &str, _: Effort) -> Result<Vec<Row>, CliError> {
    let At { g1, g2, .. } = DEFAULTS;
    let (bottom, top) = Spectrum::new(Chain::new(SITES, g1, g2)?).band();
    let mut rows = Vec::new();
    for distance in [1e-4, 1e-8, 1e-11, 1e-14] {
        let case = format!("ω above the band by {distance:e}");
        rows.extend(all(&case, SITES, At { omega: top * (1.0 + distance), ..DEFAULTS })?);
        let case = format!("ω below the band by {distance:e}");
        rows.extend(all(&case, SITES, At { omega: bottom * (1.0 - distance), ..DEFAULTS })?);
    }
    Ok(rows)
}

fn resonance(_: &str, _: Effort) -> Result<Vec<Row>, CliError> {
    let At { g1, g2, .. } = DEFAULTS;
    let spectrum = Spectrum::new(Chain::new(SITES, g1, g2)?);
    // The second harmonic on a mode in the middle of the band.
    let mode = spectrum.frequencies().get(5).copied().unwrap_or_default();
    let mut rows = Vec::new();
    for distance in [1e-2, 1e-5, 1e-8, 1e-11, 1e-13, 1e-15] {
        rows.extend(all(
            &format!("2ω at {distance:e} from mode 5"),
            SITES,
            At { omega: 0.5 * mode * (1.0 + distance), ..DEFAULTS },
        )?);
    }
    // The force on the uniform mode.
    for distance in [1e-8, 1e-13, 1e-15] {
        let case = format!("force at {distance:e} from mode 0");
        rows.extend(forced(&case, At { omega: g1.sqrt() * (1.0 + distance), ..DEFAULTS }, (0.1, 0.9))?);
    }
    Ok(rows)
}

fn frequencies(_: &str, _: Effort) -> Result<Vec<Row>, CliError> {
    let mut rows = Vec::new();
    for omega in [1e-3, 1e6] {
        let case = format!("ω = {omega:e}");
        rows.extend(all(&case, SITES, At { omega, ..DEFAULTS })?);
        let amplitude = if omega > 1.0 { 0.5 * omega * omega } else { 0.2 };
        rows.extend(forced(&case, At { omega, ..DEFAULTS }, (amplitude, 0.9))?);
    }
    Ok(rows)
}

fn asymmetry(_: &str, _: Effort) -> Result<Vec<Row>, CliError> {
    let mut rows = Vec::new();
    for (name, a) in [("a = 0", 0.0), ("a = 1 − 1e-12", 1.0 - 1e-12)] {
        rows.extend(all(name, SITES, At { a, ..DEFAULTS })?);
        rows.extend(forced(name, At { a, ..DEFAULTS }, (0.9, 0.9))?);
    }
    Ok(rows)
}

fn restitution(_: &str, _: Effort) -> Result<Vec<Row>, CliError> {
    let mut rows = Vec::new();
    for (name, e, amplitude) in [("e = 1", 1.0, 0.1), ("e = 1 − 1e-15", 1.0 - 1e-15, 0.1), ("e = 1e-6", 1e-6, 3.0)] {
        rows.extend(forced(name, DEFAULTS, (amplitude, e))?);
    }
    Ok(rows)
}

fn force(_: &str, _: Effort) -> Result<Vec<Row>, CliError> {
    // Without asymmetry the least force is known in closed form.
    let point = At { a: 0.0, ..DEFAULTS };
    let ring = Point::ring(SITES).gamma1(point.g1).gamma2(point.g2);
    let model = |amplitude| ring.omega(point.omega).asymmetry(point.a).amplitude(amplitude).restitution(0.9).model();
    let mut found = OrbitList::default();
    Finder::new(SITES).find(&model(1e-6)?, Family::DoubleSided, &mut found).map_err(truth)?;
    let Some(NoBreather::ForceTooWeak { threshold }) = found.completeness.reason() else {
        return Err(truth("no threshold of the force"));
    };
    let mut rows = Vec::new();
    let steps =
        [("just below", 1.0 - 1e-14), ("just above", 1.0 + 1e-14), ("1e-8 above", 1.0 + 1e-8), ("1e6 times", 1e6)];
    for (name, factor) in steps {
        rows.extend(forced(&format!("force {name} its threshold"), point, (threshold * factor, 0.9))?);
    }
    Ok(rows)
}

fn grazing(_: &str, _: Effort) -> Result<Vec<Row>, CliError> {
    let point = At { omega: 0.92, ..DEFAULTS };
    let At { g1, omega, a, .. } = point;
    let mut rows = Vec::new();
    // The force alone reaches the barrier at (1−a)|γ₁−ω²|: beyond it by δ one impact has an impulse of that order.
    for distance in [1e-2, 1e-4, 1e-8, 1e-12] {
        for e in [1.0, 0.9] {
            let amplitude = (1.0 - a) * (omega * omega - g1) * (1.0 + distance);
            rows.extend(forced(&format!("grazing, p ~ {distance:e}, e = {e}"), point, (amplitude, e))?);
        }
    }
    Ok(rows)
}

fn masses(sites: usize) -> String {
    format!("{sites} mass{}", if sites == 1 { "" } else { "es" })
}

fn rings(_: &str, effort: Effort) -> Result<Vec<Row>, CliError> {
    let At { g1, g2, omega, a } = DEFAULTS;
    let mut rows = Vec::new();
    for sites in [1, 2, 3, 4] {
        rows.extend(all(&masses(sites), sites, DEFAULTS)?);
        let ring = Point::ring(sites).gamma1(g1).gamma2(g2);
        let model = ring.omega(omega).asymmetry(a).amplitude(0.1).restitution(0.9).model()?;
        let case = format!("{}, forced", masses(sites));
        rows.extend(check_orbits(&case, &model, Family::DoubleSided, DEPTH));
    }
    let case = masses(effort.sites);
    let model = conservative(effort.sites, DEFAULTS)?;
    rows.push(check_kernels(&case, model.chain(), omega, FEW).map_err(truth)?);
    let depth = Depth { orbits: 1, spectra: Spectra::Left, bits: FEW };
    rows.extend(check_orbits(&case, &model, Family::DoubleSided, depth));
    Ok(rows)
}

fn far(_: &str, effort: Effort) -> Result<Vec<Row>, CliError> {
    let chain = Chain::new(601, 0.2, 0.02)?;
    let profile = check_profile("601 masses, γ₂ = 0.02, ω = 2", &chain, 2.0, &[1, 10, 100, 280]).map_err(truth)?;
    // Stable, so that rounding is not blown up.
    let model = conservative(SITES, At { g2: 0.05, omega: 1.7, a: 0.2, ..DEFAULTS })?;
    let long = check_simulation("long simulation", &model, effort.periods).map_err(truth)?;
    Ok(vec![profile, long])
}
