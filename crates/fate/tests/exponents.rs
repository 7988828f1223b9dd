//! Tangent vectors of the simulation, and exponents measured by them, against multipliers, which share no code with them.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test stops at the first surprise")]

use vibrochain_breather::{Family, Motion, Orbit, admissibility, breathers};
use vibrochain_eventsim::{Limits, Outcome, Simulation, Time};
use vibrochain_fate::{Start, measure};
use vibrochain_floquet::{Tolerance, full_monodromy, stability};
use vibrochain_lattice::{Model, Point, Propagator, Spectrum, Stop};

fn forced(sites: usize, [gamma1, gamma2, omega, asymmetry, amplitude, restitution]: [f64; 6]) -> Model {
    let ring = Point::ring(sites).gamma1(gamma1).gamma2(gamma2);
    ring.omega(omega).asymmetry(asymmetry).amplitude(amplitude).restitution(restitution).model().unwrap()
}

/// Physical breathers of the paper's default with a force, its neighbours, and some without force.
fn orbits() -> Vec<Orbit> {
    let default = [0.2, 0.1, 1.5, 0.4, 0.1, 0.9];
    let mut models = vec![forced(21, default), forced(5, default)];
    for (place, values) in [(2, [1.2, 1.35, 1.7]), (3, [0.1, 0.3, 0.6]), (1, [0.02, 0.06, 0.15]), (5, [0.7, 0.8, 0.95])]
    {
        models.extend(values.map(|value| {
            let mut point = default;
            point[place] = value;
            forced(21, point)
        }));
    }
    for omega in [0.8, 0.93, 1.1, 1.5] {
        models.push(forced(21, [0.2, 0.1, omega, 0.4, 0.0, 1.0]));
    }
    let families = [Family::DoubleSided, Family::SingleSided, Family::PeriodDoubled];
    let found = |model: &Model| families.map(|family| breathers(model, family).unwrap().orbits).concat();
    let physical = |orbit: &Orbit| admissibility(orbit).unwrap().is_physical();
    models.iter().flat_map(found).filter(physical).collect()
}

/// What one period does to every perturbation, from the flight before the first impact, by tangent vectors.
fn by_tangents(orbit: &Orbit) -> Vec<Vec<f64>> {
    let start = orbit.time_in_last_flight();
    let (u, v) = Motion::of(orbit).unwrap().state(start);
    let mut simulation = Simulation::new(orbit.model().unwrap(), orbit.psi().unwrap_or(0.0) + start, &u, &v).unwrap();
    let sites = u.len();
    let unit = |i: usize| (0..sites).map(|n| f64::from(u8::from(n == i))).collect::<Vec<_>>();
    let units: Vec<_> = (0..2 * sites).map(|i| [unit(i), unit(i.wrapping_sub(sites))]).collect();
    let mut tangents = simulation.tangents_along(&units).unwrap();
    let end = Time::new(orbit.model().unwrap(), orbit.force_periods().into(), 0.0);
    let report = simulation.run_with(&mut tangents, &Limits::until(end), |_| {}).unwrap();
    assert_eq!((report.outcome, report.work.impacts), (Outcome::TimeReached, orbit.impacts().len() as u64));
    (0..2 * sites).map(|i| tangents.vector(i).unwrap().concat()).collect()
}

#[test]
fn tangents_of_a_period_are_the_monodromy_matrix() {
    let orbits = orbits();
    let mut worst = 0.0_f64;
    for orbit in &orbits {
        let tangents = by_tangents(orbit);
        let monodromy = full_monodromy(orbit).unwrap();
        let sites = monodromy.nrows() / 2;
        // That begins just before the first impact: M = F(s) T F(−s) by the flight F to it.
        let spectrum = Spectrum::new(*orbit.model().unwrap().chain());
        let [to, back] = [-1.0, 1.0].map(|sign| Propagator::new(&spectrum, sign * orbit.time_in_last_flight()));
        let apply = |flow: &Propagator, x: &[f64]| {
            let (mut u, mut v) = (vec![0.0; sites], vec![0.0; sites]);
            flow.apply(&x[..sites], &x[sites..], &mut u, &mut v);
            [u, v].concat()
        };
        let size = monodromy.amax().max(1.0);
        for j in 0..2 * sites {
            let unit: Vec<f64> = (0..2 * sites).map(|i| f64::from(u8::from(i == j))).collect();
            let before = apply(&back, &unit);
            let mut after = vec![0.0; 2 * sites];
            for (weight, column) in before.iter().zip(&tangents) {
                after.iter_mut().zip(column).for_each(|(sum, x)| *sum += weight * x);
            }
            let after = apply(&to, &after);
            for (i, x) in after.iter().enumerate() {
                let error = (x - monodromy[(i, j)]).abs() / size;
                worst = worst.max(error);
            }
        }
    }
    println!("{} orbits, {worst:e}", orbits.len());
    // Of the largest entry; impacts come at their instants to rounding, and the saltation feels that.
    assert!(orbits.len() >= 20 && worst < 1e-10, "{} {worst:e}", orbits.len());
}

/// ln|μ|/T of the largest multiplier.
fn predicted(orbit: &Orbit) -> f64 {
    let multipliers = stability(orbit, Tolerance::Rounding).unwrap().multipliers;
    multipliers.iter().fold(0.0_f64, |most, multiplier| most.max(multiplier.norm())).ln() / orbit.period()
}

/// One run from an unstable breather, and no other: its direction settles as μ⁻ⁿ while rounding grows as μⁿ, and where the two meet a
/// period tells the exponent.
#[test]
fn a_run_that_starts_on_a_breather_has_its_exponent_before_it_leaves() {
    let (mut compared, mut forced, mut worst) = (0, 0, 0.0_f64);
    for orbit in orbits() {
        let expected = predicted(&orbit);
        let growth = expected * orbit.period();
        if growth < 0.4 {
            continue;
        }
        let start = Start::on(&orbit).unwrap();
        let mut simulation = start.simulation(orbit.model().unwrap()).unwrap();
        let mut tangents = simulation.tangents(1, 3).unwrap();
        let periods = (16.5 / growth).ceil() as u64;
        let mut logs = vec![0.0];
        for period in 1..=periods {
            let until = Time::new(orbit.model().unwrap(), period * u64::from(orbit.force_periods()), 0.0);
            simulation.run_with(&mut tangents, &Limits::until(until), |_| {}).unwrap();
            logs.push(tangents.orthonormalise()[0]);
        }
        let [.., before, last] = logs[..] else { panic!("too short") };
        let measured = (last - before) / orbit.period();
        worst = worst.max((measured - expected).abs());
        compared += 1;
        forced += usize::from(orbit.model().unwrap().amplitude() > 0.0);
    }
    println!("{compared} breathers, {forced} forced, {worst:e}");
    assert!(compared >= 13 && forced >= 12 && worst < 1e-6, "{compared} {forced} {worst:e}");
}

#[test]
fn exponents_measured_along_breathers_are_those_of_their_multipliers() {
    let orbits = orbits();
    let (mut settled, mut worst) = (0, 0.0_f64);
    for orbit in &orbits {
        let measured = measure(orbit, 2000, &Stop::default()).unwrap();
        let difference = (measured.value - predicted(orbit)).abs();
        // More than a few periods: by one direction that settled.
        settled += usize::from(measured.periods > 2 && measured.periods < 2000);
        worst = worst.max(difference);
        assert!(difference < 1e-6, "{orbit:?} {measured:?} {}", predicted(orbit));
        assert!(measured.error < 1e-6, "{measured:?}");
    }
    println!("{} breathers, {settled} by one direction, {worst:e}", orbits.len());
    assert!(orbits.len() >= 26 && settled >= 12, "{} {settled}", orbits.len());
}
