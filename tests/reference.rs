//! Every case of the table of checked numbers (tests/data/reference.json), which were established by two independent
//! event-driven simulations and a finite-difference monodromy matrix.
#![allow(clippy::unwrap_used, reason = "a test stops at the first surprise")]

use approx::relative_eq;
use vibrochain::breather::{Family, Orbit, admissibility, breathers};
use vibrochain::floquet::{Tolerance, stability};
use vibrochain_testkit::reference;

/// Paper's half impulses in the table's order: p1 at φ, p2 at 0; p for one impact.
fn half_impulses(orbit: &Orbit) -> Vec<f64> {
    orbit.impacts().iter().rev().map(|impact| 0.5 * impact.impulse.abs()).collect()
}

#[test]
fn impulses_phases_and_spectra_of_every_case() {
    for case in reference() {
        let (name, model, family) = (&case.name, case.model, case.family);
        let number = |key: &str| case.number(key);
        let doubled = family == Family::PeriodDoubled;
        let expected: Vec<f64> = ["p", "p1", "p2"].iter().filter_map(|key| number(key)).collect();
        let found = breathers(&model, family).unwrap();
        assert!(found.completeness.is_established(), "{name}");
        // The doubled orbit is listed with its later second impact; the table may hold its shift.
        let matches = |orbit: &&Orbit| {
            let p = half_impulses(orbit);
            let swapped: Vec<f64> = p.iter().rev().copied().collect();
            let same = |p: &[f64]| p.iter().zip(&expected).all(|(p, q)| relative_eq!(p, q, epsilon = 1e-10));
            same(&p) || (doubled && same(&swapped))
        };
        let orbit = found.orbits.iter().find(matches);
        let orbit = orbit.unwrap_or_else(|| panic!("{name}: {expected:?} not among {:?}", found.orbits));
        assert!(orbit.residual() < 1e-13, "{name}");
        if let (Some(phi), Some(found)) = (number("phi"), orbit.phi()) {
            let phi = if doubled && phi < 0.5 * orbit.period() { orbit.period() - phi } else { phi };
            assert!((found - phi).abs() < 1e-10, "{name}: φ {found} {phi}");
        }
        if let (Some(psi), Some(found)) = (number("psi"), orbit.psi()) {
            // A doubled orbit's shift by a time φ moves the phase of the force as much.
            let shift = if doubled { number("phi").unwrap() } else { 0.0 };
            let distance = |x: f64| (x.rem_euclid(model.period())).min((-x).rem_euclid(model.period()));
            assert!(distance(found - psi).min(distance(found - psi - shift)) < 1e-10, "{name}: ψ {found} {psi}");
        }
        let physical = admissibility(orbit).unwrap().is_physical();
        assert_eq!(physical, case.values["physical"].as_bool().unwrap(), "{name}");
        let radius = number("spectral_radius").unwrap();
        let verdict = stability(orbit, Tolerance::Rounding).unwrap().verdict;
        let tolerance = if radius > 1000.0 { 1e-6 } else { 1e-8 };
        let error = (verdict.spectral_radius / radius - 1.0).abs();
        assert!(error < tolerance, "{name}: |μ| {} {radius}", verdict.spectral_radius);
        assert_eq!(verdict.stable, radius < 1.0 + 1e-9, "{name}");
    }
}
