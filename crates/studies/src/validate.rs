//! `studies validate`: the closed forms and their stability against the event-driven simulation, as a table.
//!
//! The simulation shares no formula with them: it knows the ring, its barriers and the law of impact.

use std::fmt::Write as _;

use vibrochain_breather::{Family, Finder, LatticeOrbit, Orbit, OrbitList};
use vibrochain_eventsim::{Limits, Outcome, Simulation, Time};
use vibrochain_floquet::{Complex, DMatrix, Stability, Tolerance, eigenvalues, stability};
use vibrochain_lattice::{Chain, Stop};

use crate::args::ValidateArgs;
use vibrochain_cli::common::console::Console;
use vibrochain_cli::common::error::CliError;
use vibrochain_cli::simulate::start::{Start, leading_mode_at};
use vibrochain_maps::files::Output;

/// One parameter point.
#[derive(Clone, Copy)]
struct Point {
    family: Family,
    sites: usize,
    g1: f64,
    g2: f64,
    omega: f64,
    a: f64,
    amplitude: f64,
    e: f64,
}

/// The paper's defaults, without force.
const PAPER: Point =
    Point { family: Family::DoubleSided, sites: 21, g1: 0.2, g2: 0.1, omega: 1.5, a: 0.4, amplitude: 0.0, e: 1.0 };

const SINGLE: Point = Point { family: Family::SingleSided, ..PAPER };

const FORCED: Point = Point { amplitude: 0.1, e: 0.9, ..PAPER };

/// The paper's defaults, each mechanism of `errata`, small rings and a large one.
const POINTS: [Point; 16] = [
    PAPER,
    Point { sites: 1, g2: 0.0, ..PAPER },
    Point { sites: 2, ..PAPER },
    Point { sites: 101, omega: 2.0, a: 0.6, ..PAPER },
    Point { omega: 0.85, ..SINGLE },
    Point { omega: 0.8, ..SINGLE },
    Point { omega: 0.93, ..SINGLE },
    Point { sites: 5, ..FORCED },
    FORCED,
    Point { a: 0.0, amplitude: 0.9, ..FORCED },
    Point { g1: 0.1, g2: 0.05, omega: 1.33, a: 0.0, amplitude: 1.5, e: 0.6, ..PAPER },
    Point { family: Family::SingleSided, omega: 0.92, ..FORCED },
    Point { g2: 0.08, omega: 0.92, a: 0.7, amplitude: 0.05, e: 0.9, ..SINGLE },
    Point { g2: 0.12, omega: 0.92, a: 0.7, amplitude: 0.05, e: 0.9, ..SINGLE },
    Point { omega: 1.07, a: 0.8, amplitude: 0.1582, e: 0.25, ..SINGLE },
    Point { family: Family::PeriodDoubled, omega: 1.07, a: 0.8, amplitude: 0.1582, e: 0.25, ..PAPER },
];

/// Periods over which drift and growth are measured.
const LONG: u64 = 1000;

/// Runs the subcommand.
///
/// # Errors
/// [`CliError`].
pub fn run(args: &ValidateArgs, console: &mut Console<'_>) -> Result<(), CliError> {
    let file = args.out.as_deref().map(|path| Output::document("--out", path)).transpose()?;
    let mut table = String::from(HEADING);
    for point in POINTS {
        for line in rows(point)? {
            table.push_str(&line);
        }
    }
    match file {
        Some(file) => Ok(file.finish_with(table.as_bytes())?),
        None => console.print(&table),
    }
}

const HEADING: &str = "# Closed forms against simulation

Printed by `studies validate`. Each row is a physical orbit in closed form (`vibrochain-breather`), its multipliers
(`vibrochain-floquet`) and an event-driven simulation (`vibrochain-eventsim`) that knows neither. Distances are rounding, which differs
between machines: they are given to one digit, and rates to the digits that do not differ.

- *closure*: largest distance of displacements and velocities from the start after one period of the orbit;
- *drift*: the same after 1000 periods, unless an instability has made rounding visible
  (|μ|^1000 above 1000);
- *multipliers*: largest distance of a multiplier μ from the nearest one of the simulated return map, over max(1, |μ|);
  the map's Jacobian is taken by central differences; multipliers within 1e-3 of 1 are left out, because differences split the defective pair of a
  conservative orbit;
- *growth*: rate per period at which a perturbation of 1e-8 along the leading eigenvector grows in the simulation, measured
  until it is 1e-5 or for 1000 periods, beside the leading |μ|; for orbits with |μ| above 1.0001.

| family | M | γ₁ | γ₂ | ω | a | A | e | closure | drift | multipliers | leading \\|μ\\| | growth |
|---|---|---|---|---|---|---|---|---|---|---|---|---|
";

fn computation(error: impl std::fmt::Display) -> CliError {
    CliError::Computation(error.to_string())
}

/// One row for each physical orbit at a point.
fn rows(point: Point) -> Result<Vec<String>, CliError> {
    let Point { family, sites, g1, g2, omega, a, amplitude, e } = point;
    let ring = Chain::new(sites, g1, g2)?.point();
    let model = ring.omega(omega).asymmetry(a).amplitude(amplitude).restitution(e).model()?;
    let mut finder = Finder::new(sites);
    let mut found = OrbitList::default();
    finder.find(&model, family, &mut found).map_err(computation)?;
    let mut lines = Vec::new();
    for orbit in std::mem::take(&mut found.orbits) {
        if !finder.admissibility(&orbit).map_err(computation)?.is_physical() {
            continue;
        }
        let map = ReturnMap::new(&orbit)?;
        let answer = stability(&orbit, Tolerance::Rounding).map_err(computation)?;
        let radius = answer.verdict.spectral_radius;
        let closure = distance(&map.after(&map.state(), 1)?, &map.state());
        let mut line = format!(
            "| {} | {sites} | {g1} | {g2} | {omega} | {a} | {amplitude} | {e} | {closure:.0e} |",
            family.name()
        );
        // Writing to a String cannot fail.
        let _ = if radius.powf(LONG as f64) < 1000.0 {
            write!(line, " {:.0e} |", distance(&map.after(&map.state(), LONG)?, &map.state()))
        } else {
            write!(line, " |")
        };
        let _ = write!(line, " {:.0e} | {radius:.7} |", map.multiplier_error(&answer)?);
        let _ = if radius > 1.0001 { writeln!(line, " {} |", rate(map.growth(radius)?)) } else { writeln!(line, " |") };
        lines.push(line);
    }
    if lines.is_empty() {
        let reason = found.completeness.reason().map_or("none is physical".to_owned(), |reason| reason.to_string());
        return Err(CliError::Computation(format!(
            "no {} orbit to validate at omega = {omega}: {reason}",
            family.name()
        )));
    }
    Ok(lines)
}

/// A measured growth to the digits on which two runs agree: the faster it is, the fewer periods it is measured over.
fn rate(growth: f64) -> String {
    let decimals = if growth < 2.0 { 5 } else { (3 - growth.log10() as i32).max(0) as usize };
    format!("{growth:.decimals$}")
}

fn distance(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

/// The simulated return map of an orbit, from the middle of its last flight.
pub(crate) struct ReturnMap<'a> {
    orbit: LatticeOrbit<'a>,
    start: Start,
}

impl<'a> ReturnMap<'a> {
    pub(crate) fn new(orbit: &'a Orbit) -> Result<Self, CliError> {
        Ok(Self { orbit: orbit.lattice()?, start: Start::on(orbit)? })
    }

    /// Displacements, then velocities.
    fn state(&self) -> Vec<f64> {
        self.start.displacement.iter().chain(&self.start.velocity).copied().collect()
    }

    fn simulation(&self, state: &[f64]) -> Result<Simulation, CliError> {
        let (u, v) = state.split_at(state.len() / 2);
        Simulation::new(self.orbit.model(), self.start.psi, u, v).map_err(computation)
    }

    /// The state once `periods` periods of the orbit have passed since the simulation began.
    fn reach(&self, simulation: &mut Simulation, periods: u64) -> Result<Vec<f64>, CliError> {
        let time = Time::new(self.orbit.model(), periods * u64::from(self.orbit.force_periods()), 0.0);
        let report = simulation.run(&Limits::until(time), |_| {});
        if report.outcome != Outcome::TimeReached {
            return Err(CliError::Computation(format!("a validation run ended early: {:?}", report.outcome)));
        }
        let state = simulation.state();
        Ok(state.displacement.into_iter().chain(state.velocity).collect())
    }

    fn after(&self, state: &[f64], periods: u64) -> Result<Vec<f64>, CliError> {
        self.reach(&mut self.simulation(state)?, periods)
    }

    /// Time from the map's section to the first impact.
    pub(crate) fn lead(&self) -> f64 {
        -self.start.time
    }

    /// The map's Jacobian by central differences, row by row.
    pub(crate) fn jacobian(&self) -> Result<Vec<f64>, CliError> {
        let point = self.state();
        let n = point.len();
        // Small against the slowest impact: near grazing the map bends on the scale of its velocity squared.
        let slowest = self.orbit.impacts().iter().map(|impact| impact.velocity_before.abs()).fold(1.0, f64::min);
        let h = 1e-4 * slowest * slowest;
        let mut entries = vec![0.0; n * n];
        for j in 0..n {
            let slope = |h: f64| -> Result<Vec<f64>, CliError> {
                let shifted = |h: f64| {
                    let mut state = point.clone();
                    state[j] += h;
                    self.after(&state, 1)
                };
                let (plus, minus) = (shifted(h)?, shifted(-h)?);
                Ok(plus.iter().zip(&minus).map(|(plus, minus)| (plus - minus) / (2.0 * h)).collect())
            };
            for (i, (fine, coarse)) in slope(0.5 * h)?.iter().zip(slope(h)?).enumerate() {
                entries[i * n + j] = (4.0 * fine - coarse) / 3.0;
            }
        }
        Ok(entries)
    }

    /// Largest distance of a multiplier from the spectrum of the differenced return map.
    fn multiplier_error(&self, answer: &Stability) -> Result<f64, CliError> {
        let (n, entries) = (self.state().len(), self.jacobian()?);
        let mut found = Vec::new();
        eigenvalues(&DMatrix::from_row_slice(n, n, &entries), &mut found).map_err(computation)?;
        let one = Complex::new(1.0, 0.0);
        let compared = answer.multipliers.iter().filter(|mu| (*mu - one).norm() > 1e-3);
        let nearest = |mu: &Complex<f64>| found.iter().map(|other| (mu - other).norm()).fold(f64::INFINITY, f64::min);
        Ok(compared.map(|mu| nearest(mu) / mu.norm().max(1.0)).fold(0.0, f64::max))
    }

    /// Growth per period of a small perturbation along the leading eigenvector.
    fn growth(&self, radius: f64) -> Result<f64, CliError> {
        let mode = leading_mode_at(&self.orbit, self.start.time, &Stop::default()).map_err(computation)?;
        let size = 1e-8;
        // From 1e-8 to 1e-5, in as many periods as that takes.
        let periods = ((1e3_f64.ln() / radius.ln()) as u64).clamp(1, LONG);
        let mut start = self.start.clone();
        start.perturb_along(self.orbit.model(), size, &mode);
        let perturbed: Vec<f64> = start.displacement.iter().chain(&start.velocity).copied().collect();
        let w: Vec<Complex<f64>> = mode.iter().map(|(u, _)| *u).chain(mode.iter().map(|(_, v)| *v)).collect();
        let point = self.state();
        let amplitude = |state: &[f64]| -> f64 {
            let d: Vec<f64> = state.iter().zip(&point).map(|(x, y)| x - y).collect();
            mode_amplitude(&d, &w)
        };
        let end = self.after(&perturbed, periods)?;
        Ok((amplitude(&end) / amplitude(&perturbed)).powf(1.0 / periods as f64))
    }
}

/// |c| of d = Re(c w) by least squares; for a real w, d = c w.
fn mode_amplitude(d: &[f64], w: &[Complex<f64>]) -> f64 {
    let sum = |f: &dyn Fn(f64, &Complex<f64>) -> f64| -> f64 { d.iter().zip(w).map(|(d, w)| f(*d, w)).sum() };
    let (a, b, c) = (sum(&|_, w| w.re * w.re), sum(&|_, w| w.re * w.im), sum(&|_, w| w.im * w.im));
    let (r, s) = (sum(&|d, w| d * w.re), sum(&|d, w| d * w.im));
    let determinant = a * c - b * b;
    if c <= 1e-20 * a || determinant <= 1e-14 * a * c {
        return (r / a).abs();
    }
    ((c * r - b * s) / determinant).hypot((a * s - b * r) / determinant)
}
