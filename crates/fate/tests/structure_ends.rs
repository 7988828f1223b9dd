//! Runs of structures: exponents by tangent vectors against multipliers, what is settled on against the table of orbits.
#![allow(clippy::unwrap_used, reason = "a test stops at the first surprise")]

use std::f64::consts::TAU;
use std::sync::Arc;

use vibrochain_breather::{Hit, LoadedStructure, Orbit, admissibility};
use vibrochain_fate::{End, Ensemble, Home, measure};
use vibrochain_floquet::{Tolerance, stability};
use vibrochain_lattice::{Barrier, Complex, Contact, Stop};
use vibrochain_testkit::structures;

/// Physical orbits of the table.
fn orbits() -> Vec<(String, Orbit)> {
    let mut all = Vec::new();
    for case in structures().into_iter().filter(|case| case.physical) {
        let structure = case.linear();
        let model = LoadedStructure::new(Arc::new(structure.modal().unwrap()), case.omega).unwrap();
        let impact = |impact: &vibrochain_testkit::StructureImpact| {
            let (lower, ..) = case.limits[impact.contact];
            let barrier = if lower == Some(impact.stop) { Barrier::Lower } else { Barrier::Upper };
            Hit::new(impact.contact, barrier, impact.time, impact.impulse)
        };
        let impacts: Vec<_> = case.impacts.iter().map(impact).collect();
        let periods = (case.period * case.omega / TAU).round() as u32;
        // Orbits without force are families, which Newton's method does not take.
        let Ok(orbit) = model.orbit_near(periods, case.psi, &impacts) else { continue };
        if admissibility(&orbit).unwrap().is_physical() {
            all.push((case.name.clone(), orbit));
        }
    }
    all
}

/// ln of the largest multiplier, those included that feel no impact.
fn predicted(orbit: &Orbit) -> (f64, bool) {
    let stability = stability(orbit, Tolerance::Rounding).unwrap();
    let largest = stability.multipliers.iter().map(|z| z.norm()).fold(0.0, f64::max);
    (largest.ln() / orbit.period(), stability.verdict.stable)
}

#[test]
fn exponents_by_tangents_are_those_of_the_multipliers() {
    let (mut compared, mut worst) = (0, 0.0_f64);
    for (name, orbit) in orbits() {
        let Ok(measured) = measure(&orbit, 1000, &Stop::default()) else { continue };
        let (predicted, _) = predicted(&orbit);
        let off = (measured.value - predicted).abs();
        // Along the double multiplier 1 of an orbit that may begin at any time perturbations grow like time itself.
        let room = if orbit.is_conservative() { 1e-7 } else { 1e-8 };
        assert!(off < room + measured.error, "{name}: {measured:?} {predicted}");
        worst = worst.max(off);
        compared += 1;
    }
    println!("{compared} orbits, {worst:e}");
    assert!(compared >= 6, "{compared}");
}

#[test]
fn runs_stay_on_what_is_stable_and_leave_what_is_not() {
    let ensemble = Ensemble { starts: 1, size: 1e-6, periods: 400, ..Ensemble::default() };
    let (mut stayed, mut left) = (0, 0);
    for (name, orbit) in orbits() {
        let home = Home::of(&orbit).unwrap();
        let (exponent, stable) = predicted(&orbit);
        let fate = home.run(&ensemble, 7, &Stop::default()).unwrap();
        // What is not decided in the time of a run tells nothing.
        let grown = exponent * 400.0 * orbit.force_period();
        if stable && grown < -5.0 {
            assert_eq!((&fate.end, fate.left), (&End::Breather, None), "{name}");
            stayed += 1;
        } else if !stable && grown > 40.0 {
            assert!(fate.left.is_some(), "{name}");
            left += 1;
        }
    }
    assert!(stayed >= 3 && left >= 1, "{stayed} {left}");
}

/// The oscillator of Shaw and Holmes settles on its stable orbit of one impact a period, from rest, and pressed against its stop, too.
#[test]
fn from_rest_it_settles_on_the_stable_orbit() {
    for stop in [0.1, -0.2] {
        let shape = vibrochain_lattice::ModeShape { contacts: vec![1.0], coordinates: vec![1.0], still: 0.0 };
        let mode = vibrochain_lattice::LinearMode::oscillator(0.05, 1.0 - 0.0025, &shape, &[Complex::new(1.0, 0.0)]);
        let contact = Contact { lower: None, upper: Some(stop), restitution: 0.8 };
        let structure = vibrochain_lattice::ModalStructure::new(vec![contact], vec![1], vec![mode]).unwrap();
        let model = LoadedStructure::new(Arc::new(structure), 2.2).unwrap();
        let ensemble = Ensemble { periods: 400, ..Ensemble::default() };
        for seed in 1..=4 {
            let fate = Home::at_rest(&model).run(&ensemble, seed, &Stop::default()).unwrap();
            assert_eq!(fate.end, End::Periodic("0+".parse().unwrap()), "{stop} {seed}");
            assert!(fate.left.is_none());
        }
    }
}

/// A mass that a negative dashpot excites settles on its cycle from rest, stays on it, and neighbours keep their distance along it: the largest
/// exponent is 0.
#[test]
fn self_excited_runs_settle_on_their_cycle() {
    let shape = vibrochain_lattice::ModeShape { contacts: vec![1.0], coordinates: Vec::new(), still: 0.0 };
    let contact = Contact { lower: Some(-1.0), upper: None, restitution: 0.5 };
    let mut checked = 0;
    for decay in [-0.1, -0.05, -0.02] {
        let mode = vibrochain_lattice::LinearMode::oscillator(decay, 1.0 - decay * decay, &shape, &[]);
        let structure = vibrochain_lattice::ModalStructure::new(vec![contact], Vec::new(), vec![mode]).unwrap();
        let model = LoadedStructure::new(Arc::new(structure), 1.0).unwrap();
        let word = "0-".parse().unwrap();
        let found = model.orbits(&word, 1).unwrap().orbits;
        let physical = found.iter().find(|orbit| admissibility(orbit).unwrap().is_physical()).unwrap();
        let measured = measure(physical, 1000, &Stop::default()).unwrap();
        assert!(measured.value.abs() < 1e-7 + measured.error, "{measured:?}");
        let ensemble = Ensemble { periods: 800, size: 1e-3, ..Ensemble::default() };
        let home = Home::of(physical).unwrap();
        for seed in 1..=4 {
            let fate = home.run(&ensemble, seed, &Stop::default()).unwrap();
            assert_eq!((&fate.end, fate.left), (&End::Breather, None), "{decay} {seed}");
            let fate = Home::at_rest(&model).run(&ensemble, seed, &Stop::default()).unwrap();
            assert_eq!(fate.end, End::Periodic(word.clone()), "{decay} {seed}");
            checked += 1;
        }
    }
    assert_eq!(checked, 12);
}
