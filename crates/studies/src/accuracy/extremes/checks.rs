//! One quantity at one point: promised error, delivered error, or the reason why there is no answer.

use std::f64::consts::PI;

use vibrochain_breather::{BreatherError, Family, Finder, Motion, Orbit, OrbitList};
use vibrochain_eventsim::{Limits, Outcome, Simulation, Time};
use vibrochain_floquet::{Analyser, FloquetError, Stability, Tolerance};
use vibrochain_lattice::{Chain, ImpulseResponse, KernelJet, Model, Spectrum, far_field};
use vibrochain_truth::{Kernel, Real, TrueOrbit, TrueSpectrum, TruthError};

/// Units in the last place, times the condition number, within which kernels are promised.
const KERNEL_UNITS: f64 = 4.0;

/// One line of the table.
#[derive(Debug, Clone, PartialEq)]
pub struct Row {
    /// The corner, in words.
    pub case: String,
    /// What is looked at.
    pub quantity: String,
    /// Error promised by the program's own estimate, relative unless the quantity says otherwise.
    pub promised: Option<f64>,
    /// Error found against the truth.
    pub delivered: Option<f64>,
    /// The answer in words: a verdict, an error given, why nothing could be compared.
    pub outcome: String,
    /// What is delivered may exceed what is promised by this factor.
    pub slack: f64,
    /// Errors below this are none: the last digits of the truth itself.
    pub floor: f64,
    /// The answer contradicts the truth in kind, not in digits.
    pub wrong: bool,
}

impl Row {
    pub(crate) fn new(case: &str, quantity: impl Into<String>) -> Self {
        Self {
            case: case.to_owned(),
            quantity: quantity.into(),
            promised: None,
            delivered: None,
            outcome: String::new(),
            slack: 10.0,
            floor: 0.0,
            wrong: false,
        }
    }

    /// A quantity that nothing could be set against.
    pub(super) fn without_truth(case: &str, error: &TruthError) -> Self {
        Self::new(case, "kernels").told(format!("no truth to compare with: {error}"))
    }

    pub(crate) fn told(mut self, outcome: impl Into<String>) -> Self {
        self.outcome = outcome.into();
        self
    }

    pub(crate) fn measured(mut self, promised: f64, delivered: f64) -> Self {
        (self.promised, self.delivered) = (Some(promised), Some(delivered));
        self
    }

    /// The promise holds: the error is within the estimate, no number is missing or NaN, no verdict is wrong.
    pub fn holds(&self) -> bool {
        let within = match (self.promised, self.delivered) {
            (Some(promised), Some(delivered)) => delivered <= (self.slack * promised).max(self.floor),
            (None, None) => true,
            _ => false,
        };
        within && !self.wrong
    }
}

/// The kernels K₀, K₀′, K₀″, K₀‴ at several times and K_n at the far site, for impulses of frequency `omega`; the truth to
/// `bits` binary digits.
///
/// # Errors
/// [`TruthError`] where the truth itself cannot be had though the program answers.
pub fn check_kernels(case: &str, chain: &Chain, omega: f64, bits: usize) -> Result<Row, TruthError> {
    let row = Row { slack: 1.0, ..Row::new(case, "kernels") };
    let response = match ImpulseResponse::new(&Spectrum::new(*chain), omega) {
        Ok(response) => response,
        Err(error) => return Ok(row.told(error.to_string())),
    };
    let truth = Kernel::new(chain, omega, 1, bits)?;
    let bits = truth.work_bits();
    let (mut promised, mut delivered, mut worst) = (f64::EPSILON, 0.0, -1.0);
    let mut compare = |found: f64, exact: &Real, sensitivity: f64| {
        let size = exact.abs().to_f64().max(f64::MIN_POSITIVE);
        let error = (exact - found).abs().to_f64() / size;
        let bound = KERNEL_UNITS * f64::EPSILON * (sensitivity / size).max(1.0);
        // A NaN is worse than anything.
        let ratio = if error.is_nan() { f64::INFINITY } else { error / bound };
        if ratio > worst {
            (promised, delivered, worst) = (bound, error, ratio);
        }
    };
    for fraction in [0.0, 0.5, 0.07, 0.31, 0.93] {
        let period = response.period();
        let t = fraction * period;
        let exact_time = if fraction == 0.5 { truth.period() / 2.0 } else { Real::new(t, bits) };
        let bound = response.sensitivity(t);
        let jet = truth.jet(0, 0, &exact_time);
        let found = if fraction == 0.0 {
            let ends = response.jet_from_half(-0.5 * period);
            // At the impulse itself the odd derivatives are the mean of both sides, 0.
            KernelJet { value: response.dynamic_at_impulse(), slope: 0.0, third: 0.0, ..ends }
        } else {
            response.jet_from_half(t - 0.5 * period)
        };
        compare(found.value, &truth.dynamic(0, 0, &exact_time), bound.value);
        compare(found.curvature, &jet.curvature, bound.curvature);
        if fraction != 0.0 && fraction != 0.5 {
            compare(found.slope, &jet.slope, bound.slope);
            compare(found.third, &jet.third, bound.third);
        }
        for site in [0, chain.sites() / 2] {
            let bound = response.value_sensitivity(site, t);
            compare(response.value(site, t), &truth.value(site, 0, &exact_time), bound);
        }
    }
    Ok(row.measured(promised, delivered).told(format!("condition {:.0e}", promised / KERNEL_UNITS / f64::EPSILON)))
}

/// What is done about multipliers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Spectra {
    /// Nothing.
    Left,
    /// They are computed, and must be numbers or an error in words.
    Computed,
    /// The leading one is compared with the truth.
    Compared,
}

/// How much `check_orbits` does.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Depth {
    /// Orbits looked at, at most.
    pub orbits: usize,
    /// Multipliers too.
    pub spectra: Spectra,
    /// Binary digits of the truth.
    pub bits: usize,
}

/// Impulses, times and multipliers of the orbits of a family at a point, one row for each quantity with its worst orbit.
pub fn check_orbits(case: &str, model: &Model, family: Family, depth: Depth) -> Vec<Row> {
    let name = family.name();
    let mut finder = Finder::new(model.chain().sites());
    let mut found = OrbitList::default();
    let whole = Row::new(case, format!("{name} orbits"));
    if let Err(error) = finder.find(model, family, &mut found) {
        return vec![whole.told(error.to_string())];
    }
    if let Some(reason) = found.completeness.reason() {
        return vec![whole.told(reason.to_string())];
    }
    let orbits = std::mem::take(&mut found.orbits);
    if orbits.is_empty() {
        let (unresolved, exhausted) = found.completeness.open();
        return vec![whole.told(format!("{unresolved} places unresolved, {exhausted} not searched"))];
    }
    let mut analyser = Analyser::default();
    let mut rows: Vec<Row> = Vec::new();
    // The worst row of each quantity.
    let mut keep = |row: Row| match rows.iter_mut().find(|old| old.quantity == row.quantity) {
        Some(old) if worse(&row, old) => *old = row,
        Some(_) => {}
        None => rows.push(row),
    };
    for orbit in orbits.iter().take(depth.orbits) {
        match TrueOrbit::refine(orbit, depth.bits) {
            Ok(truth) => check_orbit(case, name, orbit, &truth, (&mut finder, &mut analyser), depth.spectra, &mut keep),
            Err(error) => keep(whole.clone().told(format!("no truth to compare with: {error}"))),
        }
    }
    let more = orbits.len();
    if more > 1
        && let Some(first) = rows.first_mut()
    {
        first.outcome = format!("{more} orbits; {}", first.outcome);
    }
    rows
}

/// Whether a row says more than another one of its quantity: broken before kept, then the larger share of the promise.
pub(crate) fn worse(row: &Row, old: &Row) -> bool {
    let ratio = |row: &Row| match (row.promised, row.delivered) {
        _ if row.wrong => f64::INFINITY,
        (Some(promised), Some(delivered)) if delivered > row.floor => delivered / promised,
        _ => -1.0,
    };
    !row.holds() && old.holds() || ratio(row) > ratio(old)
}

/// The rows of one orbit.
fn check_orbit(
    case: &str,
    family: &str,
    orbit: &Orbit,
    truth: &TrueOrbit,
    (finder, analyser): (&mut Finder, &mut Analyser),
    spectra: Spectra,
    keep: &mut impl FnMut(Row),
) {
    let refused = |error: BreatherError| Row::new(case, format!("{family} orbits")).told(error.to_string());
    let (condition, error) = match (finder.condition(orbit), truth.error_of(orbit)) {
        (Ok(condition), Ok(error)) => (condition, error),
        (Err(error), _) => return keep(refused(error)),
        (_, Err(error)) => return keep(Row::new(case, format!("{family} orbits")).told(error.to_string())),
    };
    let fold = condition.fold;
    let distances = format!(
        "residual {:.0e}, resonance {:.0e}, grazing {:.0e}, fold {fold:.0e}",
        orbit.residual(),
        condition.resonance,
        condition.grazing
    );
    let impulses = Row::new(case, format!("{family} impulses"));
    keep(impulses.measured(condition.impulse_error(), error.impulse).told(distances));
    if orbit.phi().is_some() || orbit.psi().is_some() {
        let times = Row::new(case, format!("{family} times"));
        keep(times.measured(condition.time_error(), error.time.max(error.psi)));
    }
    if spectra != Spectra::Left {
        let row = Row::new(case, format!("{family} spectral radius"));
        keep(match analyser.stability(orbit, finder, Tolerance::Rounding) {
            Ok(stability) if stability.multipliers.iter().any(|mu| !(mu.re.is_finite() && mu.im.is_finite())) => {
                Row { wrong: true, ..row.told("a multiplier is not a number") }
            }
            Ok(_) if spectra == Spectra::Computed => return,
            Ok(stability) => check_radius(row, &stability, truth),
            Err(FloquetError::Breather(error)) => refused(error),
            Err(error) => row.told(error.to_string()),
        });
    }
}

/// The spectral radius of an orbit.
fn check_radius(row: Row, stability: &Stability, truth: &TrueOrbit) -> Row {
    let verdict = stability.verdict;
    let said = match verdict.mechanism {
        _ if verdict.undecided => "undecided",
        Some(mechanism) => mechanism.name(),
        None => "stable",
    };
    if !(verdict.spectral_radius.is_finite() && verdict.spectral_radius >= 0.0) {
        return Row { wrong: true, ..row.told("not a number") };
    }
    let spectrum = match TrueSpectrum::new(truth) {
        Ok(spectrum) => spectrum,
        Err(error) => return row.told(format!("{said}; no truth to compare with: {error}")),
    };
    match spectrum.refine((verdict.leading.re, verdict.leading.im)) {
        Ok((root, moved)) => {
            let excess = root.abs() - 1.0;
            // On the circle to all digits, up to those of the root itself.
            let digits = 2f64.powi(10 - i32::try_from(truth.bits()).unwrap_or(0));
            let on_circle = excess.abs() < digits;
            let wrong = verdict.stable && !on_circle && excess.to_f64() > 0.0
                || verdict.mechanism.is_some() && excess.to_f64() <= 0.0;
            // A root far away is another one: the program's is none.
            let far = (1e-3 * (1.0 + verdict.spectral_radius)).max(10.0 * verdict.resolution);
            let wrong = wrong || !verdict.undecided && moved > far;
            let error = (root.abs() - verdict.spectral_radius).abs().to_f64();
            // A radius of exactly 1 carries no error, but the root's own digits end somewhere.
            let promised = if on_circle { verdict.resolution } else { verdict.resolution.max(f64::EPSILON) };
            let told = format!("{said}, |μ| = {:.7}", verdict.spectral_radius);
            Row { wrong, floor: digits, ..row.measured(promised, error).told(told) }
        }
        Err(error @ TruthError::OnPole { .. }) => row.told(format!("{said}: {error}")),
        Err(error) => row.told(format!("{said}; no truth to compare with: {error}")),
    }
}

/// Impulses of the weakly coupled conservative double-sided breather against the single oscillator's, by hand:
/// χ₁ = −1/(Ω sin ΩT/2), χ₂ = −cot(ΩT/2)/Ω, half impulses 1/(χ₂−χ₁) ∓ a/(χ₁+χ₂). The coupling moves them by O(γ₂).
///
/// # Errors
/// [`BreatherError`].
pub fn check_uncoupled(case: &str, model: &Model) -> Result<Row, BreatherError> {
    let row = Row::new(case, "impulses, single oscillator by hand");
    let mut finder = Finder::new(model.chain().sites());
    let mut found = OrbitList::default();
    finder.find_symmetric(model, Family::DoubleSided, &mut found)?;
    let Some([upper, lower]) = found.orbits.first().map(Orbit::impacts) else {
        return Ok(Row { wrong: true, ..row.told("no orbit") });
    };
    let (g1, omega, a) = (model.chain().gamma1().sqrt(), model.omega(), model.asymmetry());
    let y = PI * g1 / omega;
    let (chi1, chi2) = (-1.0 / (g1 * y.sin()), -y.cos() / (g1 * y.sin()));
    let (p1, p2) = (1.0 / (chi2 - chi1) - a / (chi1 + chi2), 1.0 / (chi2 - chi1) + a / (chi1 + chi2));
    let error = (lower.impulse / (2.0 * p1) - 1.0).abs().max((upper.impulse / (-2.0 * p2) - 1.0).abs());
    Ok(row.measured(4.0 * f64::EPSILON + 10.0 * model.chain().gamma2(), error))
}

/// K_n far from the impacted site, relative to itself: the sum over harmonics against the modal sum in as many digits as
/// it takes.
///
/// # Errors
/// [`TruthError`].
pub fn check_profile(case: &str, chain: &Chain, omega: f64, sites: &[usize]) -> Result<Row, TruthError> {
    let spectrum = Spectrum::new(*chain);
    let t = 0.13 * 2.0 * PI / omega;
    // 1e-300 lies 1000 binary digits below the terms of the sum.
    let truth = Kernel::new(chain, omega, 1, 1200)?;
    let (mut worst, mut smallest) = (0.0_f64, 0.0);
    for &site in sites {
        let exact = truth.value(site, 0, &Real::new(t, truth.work_bits()));
        let (found, _) = far_field(&spectrum, omega, site, t, 100_000);
        worst = worst.max(((Real::new(found, 64) - &exact) / &exact).abs().to_f64());
        smallest = exact.log10_abs();
    }
    let furthest = sites.iter().copied().max().unwrap_or_default() as f64;
    // λ^n: n roundings of λ, and those of the sum.
    let promised = f64::EPSILON * (furthest + 16.0);
    Ok(Row::new(case, "profile").measured(promised, worst).told(format!("down to 1e{smallest:.0}")))
}

/// A stable breather flown for many periods by the simulation; displacements and velocities/ω against the orbit's own.
///
/// # Errors
/// [`BreatherError`], also if there is no orbit.
pub fn check_simulation(case: &str, model: &Model, periods: u64) -> Result<Row, BreatherError> {
    let row = Row::new(case, "simulated state, absolute");
    let mut finder = Finder::new(model.chain().sites());
    let mut found = OrbitList::default();
    finder.find_symmetric(model, Family::DoubleSided, &mut found)?;
    let Some(orbit) = found.orbits.first() else {
        return Ok(Row { wrong: true, ..row.told("no orbit") });
    };
    // Start and compare midway between two impacts.
    let mut motion = Motion::of(orbit)?;
    let start = -0.25 * orbit.period();
    motion.at(0, start);
    let (x, v): (Vec<f64>, Vec<f64>) = (0..motion.sites())
        .map(|n| {
            let at = motion.site(n);
            (at.displacement, at.velocity)
        })
        .unzip();
    let mut simulation = match Simulation::new(model, 0.0, &x, &v) {
        Ok(simulation) => simulation,
        Err(error) => return Ok(Row { wrong: true, ..row.told(error.to_string()) }),
    };
    let report = simulation.run(&Limits::until(Time::new(model, periods, 0.0)), |_| {});
    let state = simulation.state();
    let pairs = state.displacement.iter().zip(&x).map(|(a, b)| (a - b).abs());
    let rates = state.velocity.iter().zip(&v).map(|(a, b)| (a - b).abs() / model.omega());
    let error = pairs.chain(rates).fold(0.0, f64::max);
    // A rounding a period is a random walk of the energy, whose drift of the phase adds up: N^{3/2}.
    let promised = 8.0 * f64::EPSILON * (periods as f64).powf(1.5);
    let wrong = report.outcome != Outcome::TimeReached;
    Ok(Row { wrong, ..row.measured(promised, error).told(format!("{:?} after {periods} periods", report.outcome)) })
}
