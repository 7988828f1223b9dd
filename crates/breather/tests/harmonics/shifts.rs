//! Forces of several harmonics: a shift of time and harmonics of nothing change no orbit.

use vibrochain_breather::{BreatherError, Orbit, OrbitList, breathers, condition};
use vibrochain_lattice::{Model, Point};

use super::completeness::{FAMILIES, force, with};

/// The points of the tables and figures, and some where solutions crowd.
fn points() -> Vec<Model> {
    [
        (21, 0.2, 0.1, 1.5, 0.4, 0.1, 0.9),
        (21, 0.1, 0.05, 1.33, 0.0, 1.5, 0.6),
        (21, 0.1, 0.05, 1.33, 0.0, 1.5, 0.5),
        (21, 0.1, 0.05, 1.33, 0.0, 1.5, 0.524_586),
        (21, 0.2, 0.1, 0.92, 0.4, 0.1, 0.9),
        (21, 0.2, 0.1, 1.07, 0.8, 0.1582, 0.25),
        (5, 0.2, 0.1, 1.5, 0.4, 0.9, 1.0),
        (21, 0.2, 0.1, 0.05, 0.3, 0.5, 0.9),
        (4, 0.2, 0.1, 0.42, 0.2, 0.5, 0.7),
        (7, 0.0, 0.1, 1.3, 0.0, 1.5, 0.8),
        (1, 0.3, 0.0, 0.9, 0.1, 0.4, 0.95),
    ]
    .map(|(sites, g1, g2, omega, a, amplitude, e)| {
        let ring = Point::ring(sites).gamma1(g1).gamma2(g2);
        ring.omega(omega).asymmetry(a).amplitude(amplitude).restitution(e).model().unwrap()
    })
    .to_vec()
}

/// The orbits of `a` are among those of `b`, whose force is ahead by the time `shift`; all of them are, unless `a` left
/// places open.
fn assert_same(a: &OrbitList, b: &OrbitList, shift: f64, name: &str) {
    assert_eq!(b.completeness.open(), (0, 0), "{name}");
    let unresolved = a.completeness.open().0 > 0;
    assert!(a.orbits.len() == b.orbits.len() || (unresolved && a.orbits.len() < b.orbits.len()), "{name}");
    for orbit in &b.orbits {
        // One of these periods is 6e-4 from a resonance, which takes three digits from the kernel.
        assert!(orbit.residual() < 5e-12, "{name}: {}", orbit.residual());
    }
    for expected in &a.orbits {
        let period = expected.force_period();
        let distance = |orbit: &Orbit| {
            let turn = (orbit.psi().unwrap() + shift - expected.psi().unwrap()) / period;
            let psi = (turn - turn.round()).abs();
            let pairs = expected.impacts().iter().zip(orbit.impacts());
            pairs.map(|(p, q)| (p.impulse - q.impulse).abs() + (p.time - q.time).abs() / period).sum::<f64>() + psi
        };
        let nearest = b.orbits.iter().map(distance).fold(f64::INFINITY, f64::min);
        // Next to a fold, at 4e-8 here, rounding moves them by as much more.
        let fold = condition(expected).unwrap().fold;
        assert!(nearest < (f64::EPSILON / fold).max(1e-9), "{name}: {nearest:e} {fold:e}");
    }
}

#[test]
fn a_shifted_cosine_has_the_orbits_of_the_plain_one() {
    let mut compared = 0;
    for (i, plain) in points().iter().enumerate() {
        for phase in [0.7, -2.0] {
            let shifted = with(plain, &force(&[(1, plain.amplitude(), phase)]));
            for family in FAMILIES {
                let (a, b) = (breathers(plain, family).unwrap(), breathers(&shifted, family).unwrap());
                assert_same(&a, &b, phase / plain.omega(), &format!("point {i} {family:?}"));
                compared += b.orbits.len();
            }
        }
    }
    assert!(compared > 80, "{compared}");
}

#[test]
fn a_vanishing_harmonic_changes_nothing() {
    for (i, plain) in points().iter().enumerate() {
        let more = with(plain, &force(&[(1, plain.amplitude(), 0.0), (3, 1e-100, 1.0), (7, -1e-100, 0.0)]));
        for family in FAMILIES {
            let (a, b) = (breathers(plain, family).unwrap(), breathers(&more, family).unwrap());
            assert_same(&a, &b, 0.0, &format!("point {i} {family:?}"));
        }
    }
}

#[test]
fn one_plain_harmonic_in_a_list_is_the_plain_cosine() {
    for plain in points() {
        let listed = with(&plain, &force(&[(1, plain.amplitude(), 0.0)]));
        assert_eq!(listed, plain);
        for family in FAMILIES {
            assert_eq!(breathers(&listed, family).unwrap(), breathers(&plain, family).unwrap());
        }
    }
}

#[test]
fn a_resonance_of_the_third_harmonic_is_an_error() {
    // 3ω on the uniform mode, √γ₁.
    let ring = Point::ring(5).gamma1(2.25).gamma2(0.1);
    let plain = ring.omega(0.5).asymmetry(0.2).amplitude(0.1).restitution(0.9).model().unwrap();
    let model = with(&plain, &force(&[(1, 0.1, 0.0), (3, 0.01, 0.5)]));
    for family in FAMILIES {
        let error = breathers(&model, family).unwrap_err();
        assert!(matches!(error, BreatherError::Resonance(r) if r.harmonic == 3 && r.mode == 0), "{error}");
    }
}
