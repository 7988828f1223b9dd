//! Limits that are known by hand.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test stops at the first surprise")]

use vibrochain::breather::{Family, NoBreather, Orbit, admissibility, breathers};
use vibrochain::floquet::{Tolerance, stability};
use vibrochain::lattice::{Chain, Model, Point};

fn conservative(sites: usize, gamma1: f64, gamma2: f64, omega: f64, a: f64) -> Model {
    Model::conservative(Chain::new(sites, gamma1, gamma2).unwrap(), omega, a).unwrap()
}

fn the_only(model: &Model, family: Family) -> Orbit {
    let found = breathers(model, family).unwrap();
    assert!(found.orbits.len() == 1 && found.completeness.is_established(), "{:?}", found.completeness);
    found.orbits[0].clone()
}

fn impulses(orbit: &Orbit) -> Vec<f64> {
    orbit.impacts().iter().map(|impact| impact.impulse).collect()
}

#[test]
fn without_coupling_a_mass_is_a_single_oscillator() {
    // Between the barriers v = C cos(Ωτ) + D sin(Ωτ) about mid-flight τ = 0: v = a + 1 at τ = −T/4, a − 1 at T/4.
    let (g1, omega, a) = (0.2_f64, 1.5, 0.4);
    let (w, quarter) = (g1.sqrt(), 0.5 * std::f64::consts::PI / omega);
    let (c, d) = (a / (w * quarter).cos(), -1.0 / (w * quarter).sin());
    let speed = |tau: f64| w * (d * (w * tau).cos() - c * (w * tau).sin());
    for (sites, gamma2) in [(1, 0.0), (1, 0.7), (2, 0.0), (7, 0.0), (7, 1e-300), (21, 1e-17)] {
        let orbit = the_only(&conservative(sites, g1, gamma2, omega, a), Family::DoubleSided);
        for (impulse, expected) in impulses(&orbit).iter().zip([2.0 * speed(-quarter), -2.0 * speed(quarter)]) {
            assert!((impulse - expected).abs() < 2e-15, "{sites} {gamma2}: {impulse} {expected}");
        }
        assert!(admissibility(&orbit).unwrap().is_physical());
        // A lone oscillator between barriers is integrable: nothing grows but the phase.
        assert!(stability(&orbit, Tolerance::Rounding).unwrap().verdict.stable);
    }
}

#[test]
fn a_fast_breather_flies_straight() {
    // T → 0: distance 2 in half a period, speed 4/T, impulse twice that.
    for omega in [1e3, 1e6, 1e9] {
        let model = conservative(21, 0.2, 0.1, omega, 0.4);
        let orbit = the_only(&model, Family::DoubleSided);
        assert!(orbit.residual() < 1e-14);
        for impulse in impulses(&orbit) {
            assert!((impulse.abs() * model.period() / 8.0 - 1.0).abs() < 0.2 / omega, "{omega}: {impulse}");
        }
    }
}

#[test]
fn a_ring_that_nothing_holds_has_double_sided_breathers_only() {
    for sites in [1, 2, 5, 21] {
        let free = conservative(sites, 0.0, 0.1, 1.5, 0.4);
        let orbit = the_only(&free, Family::DoubleSided);
        // No net impulse; the limit of ever softer springs.
        assert!(impulses(&orbit).iter().sum::<f64>().abs() < 1e-15 && orbit.residual() < 1e-15);
        let soft = the_only(&conservative(sites, 1e-14, 0.1, 1.5, 0.4), Family::DoubleSided);
        for (a, b) in impulses(&orbit).iter().zip(impulses(&soft)) {
            assert!((a - b).abs() < 1e-12, "{sites}");
        }
        assert!(soft.residual() < 1e-15);
        assert!(stability(&orbit, Tolerance::Rounding).is_ok());
        let single = breathers(&free, Family::SingleSided).unwrap();
        assert_eq!((single.orbits.len(), single.completeness.reason()), (0, Some(NoBreather::NetImpulse)));
    }
}

fn forced(omega: f64, a: f64, amplitude: f64, e: f64) -> Model {
    let ring = Point::ring(21).gamma1(0.2).gamma2(0.1);
    ring.omega(omega).asymmetry(a).amplitude(amplitude).restitution(e).model().unwrap()
}

#[test]
fn the_elastic_limit_is_regular() {
    for family in [Family::DoubleSided, Family::SingleSided] {
        let at = |e: f64| {
            let (omega, a, amplitude) = if family == Family::DoubleSided { (1.5, 0.4, 0.9) } else { (0.92, 0.4, 0.1) };
            let mut all: Vec<_> =
                breathers(&forced(omega, a, amplitude, e), family).unwrap().orbits.iter().map(impulses).collect();
            all.sort_by(|a, b| a[0].total_cmp(&b[0]));
            all
        };
        let elastic = at(1.0);
        assert_eq!(elastic.len(), 2);
        for loss in [1e-15, 1e-12, 1e-9, 1e-6] {
            let near = at(1.0 - loss);
            assert_eq!(near.len(), 2, "{family:?} {loss}");
            for (a, b) in elastic.iter().flatten().zip(near.iter().flatten()) {
                assert!((a - b).abs() < 10.0 * loss + 1e-14, "{family:?} {loss}: {a} {b}");
            }
        }
    }
    // Single-sided, e = 1: p = (1 − a ± Ã)/χ₂ with χ₂ of the conservative breather, p = (1 − a)/χ₂.
    let p = 0.5 * impulses(&the_only(&conservative(21, 0.2, 0.1, 0.92, 0.4), Family::SingleSided))[0];
    let response: f64 = 0.1 / (0.2 - 0.92 * 0.92);
    for orbit in breathers(&forced(0.92, 0.4, 0.1, 1.0), Family::SingleSided).unwrap().orbits {
        let ratio = 0.5 * impulses(&orbit)[0] / p;
        assert!(((ratio - 1.0).abs() * 0.6 - response.abs()).abs() < 1e-14, "{ratio}");
    }
}

#[test]
fn a_force_has_a_threshold() {
    // a = 0: A ≥ |γ₁−ω²| q/√(q² + ω²D²), D = χ₂−χ₁ of the checked table.
    let (q, d): (f64, f64) = (0.1 / 1.9, -0.5788951801307799 + 1.8179685869648226);
    let threshold = 2.05 * q / q.hypot(1.5 * d);
    assert_eq!(
        breathers(&forced(1.5, 0.0, threshold * (1.0 + 1e-9), 0.9), Family::DoubleSided).unwrap().orbits.len(),
        2
    );
    let below = breathers(&forced(1.5, 0.0, threshold * (1.0 - 1e-9), 0.9), Family::DoubleSided).unwrap();
    let Some(NoBreather::ForceTooWeak { threshold: told }) = below.completeness.reason() else { panic!("{below:?}") };
    assert!(below.orbits.is_empty() && (told / threshold - 1.0).abs() < 1e-12);
}

#[test]
fn symmetry_breaks_at_the_pitchfork_of_figure_9_and_no_orbit_is_lost_next_to_it() {
    let pitchfork = 0.524585314448;
    let count = |e: f64| {
        let model = Point::ring(21).gamma1(0.1).gamma2(0.05).omega(1.33).amplitude(1.5).restitution(e).model().unwrap();
        let found = breathers(&model, Family::DoubleSided).unwrap();
        assert_eq!(found.completeness.open().0, 0, "{e}");
        found.orbits.len()
    };
    assert_eq!((count(0.6), count(0.5)), (4, 2));
    for distance in [1e-3, 1e-5, 1e-7, 1e-9] {
        assert_eq!((count(pitchfork + distance), count(pitchfork - distance)), (4, 2), "{distance}");
    }
}
