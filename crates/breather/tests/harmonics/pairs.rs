//! Orbits that come in pairs: shifted by a period of the force, or about to merge in a fold.

use vibrochain_breather::{Family, Orbit, breathers};
use vibrochain_lattice::{Chain, ImpulseResponse, Point, Spectrum};
use vibrochain_testkit::Random;

use super::completeness::{TwoImpacts, force, plain, random_model, with};

/// Impacts in the time of the force, over the orbit's period.
fn in_force_time(orbit: &Orbit) -> Vec<(f64, f64)> {
    orbit
        .impacts()
        .iter()
        .map(|impact| ((impact.time + orbit.psi().unwrap()) / orbit.period(), impact.impulse))
        .collect()
}

/// Two orbits are the same but for a shift by `shift` of the period.
fn same_after_shift(first: &[(f64, f64)], second: &[(f64, f64)], shift: f64) -> bool {
    let scale = first.iter().map(|(_, impulse)| impulse.abs()).fold(1.0, f64::max);
    first.iter().all(|(time, impulse)| {
        second.iter().any(|(other, other_impulse)| {
            let turn = time + shift - other;
            (turn - turn.round()).abs() < 1e-8 && (impulse - other_impulse).abs() < 1e-6 * scale
        })
    })
}

#[test]
fn a_doubled_orbit_and_its_shift_by_a_period_of_the_force_are_listed_once() {
    let mut random = Random(7);
    let (mut doubled, mut single) = (0, 0);
    for set in 0..60 {
        let elastic = if set % 3 == 0 { 1.0 } else { 0.6 + 0.4 * random.between(0.0, 1.0) };
        let mut model = if set % 2 == 0 { plain(&mut random, set / 2, elastic) } else { random_model(&mut random) };
        if set % 10 == 9 {
            // The force itself repeats within its period.
            model = with(&model, &force(&[(3, 1.5, 0.4), (9, 0.3, 1.0)]));
        }
        let Ok(singles) = breathers(&model, Family::SingleSided) else { continue };
        let found = breathers(&model, Family::PeriodDoubled).unwrap();
        let repetitions = 2 * model.force().repetitions();
        let orbits: Vec<_> = found.orbits.iter().map(in_force_time).collect();
        for (i, orbit) in orbits.iter().enumerate() {
            for step in 0..repetitions {
                let shift = f64::from(step) / f64::from(repetitions);
                for (j, other) in orbits.iter().enumerate() {
                    // By a whole number of its own periods an orbit is itself, and no other way.
                    let same = same_after_shift(orbit, other, shift);
                    assert_eq!(same, i == j && step == 0, "set {set}: {i} {j} {shift} {model:?}");
                }
            }
        }
        // The single-sided orbit is a doubled one with two equal impacts; it is not listed.
        for orbit in &singles.orbits {
            let twice: Vec<_> = [0.0, 0.5]
                .map(|later| ((orbit.psi().unwrap() / orbit.period()) / 2.0 + later, orbit.impacts()[0].impulse))
                .to_vec();
            assert!(!orbits.iter().any(|other| same_after_shift(other, &twice, 0.0)), "set {set} {model:?}");
            single += 1;
        }
        doubled += orbits.len();
    }
    assert!(doubled > 60 && single > 30, "{doubled} {single}");
}

#[test]
fn next_to_a_fold_the_pair_is_found_or_reported() {
    let square = |amplitude: f64| force(&[(1, amplitude, 0.3), (3, -amplitude / 3.0, 0.0), (5, amplitude / 5.0, 1.0)]);
    for (family, omega, a, e, mut low, mut high) in [
        (Family::DoubleSided, 1.5, 0.4, 0.9, 0.01, 0.3),
        (Family::DoubleSided, 1.33, 0.0, 0.6, 0.05, 1.5),
        (Family::SingleSided, 0.92, 0.4, 0.9, 0.001, 0.3),
        (Family::PeriodDoubled, 1.07, 0.8, 0.25, 0.1, 0.1343),
    ] {
        let chain = Chain::new(21, 0.2, 0.1).unwrap();
        let at = |amplitude: f64| {
            let found = breathers(
                &chain.point().omega(omega).asymmetry(a).under(&square(amplitude)).restitution(e).model().unwrap(),
                family,
            )
            .unwrap();
            let (unresolved, exhausted) = found.completeness.open();
            assert!(exhausted == 0 && found.orbits.iter().all(|orbit| orbit.residual() < 1e-13));
            (found.orbits.len(), unresolved)
        };
        assert_eq!((at(low), at(high)), ((0, 0), (2, 0)), "{family:?}");
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            if at(middle).0 < 2 { low = middle } else { high = middle }
        }
        for beyond in [1e-10, 1e-8, 1e-6, 1e-5] {
            assert_eq!((at(high - beyond), at(high + beyond)), ((0, 0), (2, 0)), "{family:?} {high} {beyond:e}");
        }
        for beyond in [-1e-14, -1e-15, 0.0, 1e-15, 1e-14, 1e-13] {
            let (orbits, unresolved) = at(high + beyond);
            assert!(orbits % 2 == 0 || unresolved > 0, "{family:?} {high} {beyond:e}: {orbits}");
        }
    }
}

/// Where rounding blurs the orbits of a pair, each may be blurred alone, up to a millionth of the period from the other.
#[test]
fn a_pair_next_to_its_fold_is_one_place() {
    let mut random = fastrand::Rng::with_seed(7);
    let (mut folds, mut blurred) = (0, 0);
    while folds < 60 {
        let gamma2 = (0.6 * random.f64() - 0.3).max(0.0);
        let chain = Chain::new(random.usize(1..8), 0.1 + 0.5 * random.f64(), gamma2).unwrap();
        let (omega, a, e) = (0.5 + 1.5 * random.f64(), 0.8 * random.f64(), 0.3 + 0.69 * random.f64());
        let family = if random.bool() { Family::DoubleSided } else { Family::PeriodDoubled };
        let at = |amplitude: f64| {
            let found = breathers(
                &chain.point().omega(omega).asymmetry(a).amplitude(amplitude).restitution(e).model().unwrap(),
                family,
            )
            .unwrap();
            let (unresolved, exhausted) = found.completeness.open();
            (found.orbits.len(), unresolved, exhausted)
        };
        let (mut low, mut high) = (0.05 * random.f64(), 0.05 + 1.5 * random.f64());
        let (few, many) = (at(low), at(high));
        if few.0 == many.0 || few.0 > many.0 + 2 || many.0 > few.0 + 2 || few.1 + many.1 + few.2 + many.2 > 0 {
            continue;
        }
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            if at(middle).0 != many.0 { low = middle } else { high = middle }
        }
        folds += 1;
        for beyond in (-40..60_i32).map(|i| f64::from(i.signum()) * 1e-16 * 1.3_f64.powi(i.abs())) {
            let (orbits, unresolved, _) = at(high + beyond);
            assert!(unresolved <= 1, "{family:?} {chain:?} {omega} {a} {e} {high} {beyond:e}: {orbits}, {unresolved}");
            blurred += unresolved;
        }
    }
    assert!(blurred > 100, "{blurred}");
}

#[test]
fn under_a_force_that_repeats_within_the_period_an_orbit_is_listed_once() {
    // The third harmonic alone: a shift of psi by T/3 changes nothing.
    let ring = Point::ring(5).gamma1(0.2).gamma2(0.1);
    let model = ring.omega(0.5).asymmetry(0.2).under(&force(&[(3, 1.5, 0.4)])).restitution(0.95).model().unwrap();
    let response = ImpulseResponse::new(&Spectrum::new(*model.chain()), model.omega()).unwrap();
    let found = breathers(&model, Family::DoubleSided).unwrap();
    let third = model.period() / 3.0;
    assert!(!found.orbits.is_empty() && found.orbits.iter().all(|orbit| orbit.psi().unwrap() < third));
    let seen = TwoImpacts { model: &model, response: &response, barriers: [1.2, -0.8] }.scan(400);
    assert_eq!(seen.len(), 3 * found.orbits.len());
    let singles = breathers(&model, Family::SingleSided).unwrap().orbits;
    assert!(!singles.is_empty() && singles.iter().all(|orbit| orbit.psi().unwrap() < third));
}
