//! Orbits in many digits against checked numbers, closed forms by hand and the equations of motion.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test stops at the first surprise")]

use vibrochain_breather::{Family, Hit, Orbit, breathers};
use vibrochain_lattice::{Barrier, Chain, Force, Harmonic, Model, Point};
use vibrochain_testkit::reference;
use vibrochain_truth::{DEFAULT_BITS, Real, TrueOrbit, TruthError};

fn model(sites: usize, gamma: (f64, f64), omega: f64, asymmetry: f64, force: (f64, f64)) -> Model {
    let ring = Point::ring(sites).gamma1(gamma.0).gamma2(gamma.1);
    ring.omega(omega).asymmetry(asymmetry).amplitude(force.0).restitution(force.1).model().unwrap()
}

fn orbits(model: &Model, family: Family) -> Vec<Orbit> {
    breathers(model, family).unwrap().orbits
}

fn refine(orbit: &Orbit) -> TrueOrbit {
    TrueOrbit::refine(orbit, DEFAULT_BITS).unwrap_or_else(|error| panic!("{error}: {orbit:?}"))
}

/// The defining problem, from displacements alone: on the barrier at impacts, velocities by Newton's law, and the equation
/// of motion by the neighbours' forces.
fn assert_solves_its_equations(orbit: &TrueOrbit) {
    let model = *orbit.model();
    let (chain, e) = (model.chain(), model.restitution());
    let sites = chain.sites();
    let force = |t: &Real| match orbit.psi() {
        Some(psi) => model.force().harmonics().iter().fold(Real::zero(64), |sum, harmonic| {
            // In digits: j times an f64 need not be one.
            let phase = (t + psi) * model.omega() * f64::from(harmonic.number) + harmonic.phase;
            sum + phase.sin_cos().1 * harmonic.amplitude
        }),
        None => Real::zero(64),
    };
    let by_forces = |site: usize, t: &Real| {
        let v = |n: usize| orbit.displacement(n % sites, t);
        let own = v(site);
        let stretch = &own * 2.0 - v(site + 1) - v(site + sites - 1);
        force(t) - own * chain.gamma1() - stretch * chain.gamma2()
    };
    assert!(orbit.residual().log10_abs() < -50.0, "{}", orbit.residual());
    for impact in orbit.impacts() {
        let barrier = Real::new(model.asymmetry(), 256) + impact.barrier.sign();
        assert!((orbit.displacement(impact.site, &impact.time) - barrier).log10_abs() < -50.0);
        assert!((&impact.velocity_after + &impact.velocity_before * e).log10_abs() < -50.0);
        let h = Real::new(1e-80, 512);
        let before = orbit.velocity(impact.site, &(&impact.time - &h));
        let after = orbit.velocity(impact.site, &(&impact.time + &h));
        assert!((before - &impact.velocity_before).log10_abs() < -50.0);
        assert!((after - &impact.velocity_after).log10_abs() < -50.0);
        let acceleration = by_forces(impact.site, &impact.time);
        assert!((&acceleration - &impact.acceleration).log10_abs() < -50.0 + acceleration.log10_abs().max(0.0));
    }
    // Between impacts, elsewhere.
    let (t, site) = (orbit.period() * 0.3217, sites / 3);
    let h = Real::new(1e-30, 512);
    let slope = (orbit.velocity(site, &(&t + &h)) - orbit.velocity(site, &(&t - &h))) / (&h * 2.0);
    assert!((slope - by_forces(site, &t)).log10_abs() < -48.0);
    let slope = (orbit.displacement(site, &(&t + &h)) - orbit.displacement(site, &(&t - &h))) / (&h * 2.0);
    assert!((slope - orbit.velocity(site, &t)).log10_abs() < -48.0);
}

#[test]
fn every_case_of_the_reference_table() {
    for case in reference() {
        let (name, model, family) = (&case.name, case.model, case.family);
        let number = |key: &str| case.number(key);
        let doubled = family == Family::PeriodDoubled;
        let expected: Vec<f64> = ["p", "p1", "p2"].iter().filter_map(|key| number(key)).collect();
        let refined: Vec<_> = orbits(&model, family).iter().map(refine).collect();
        let close = |a: f64, b: f64| (a - b).abs() < 1e-12;
        let matches = |orbit: &&TrueOrbit| {
            let mut p: Vec<f64> = orbit.impacts().iter().rev().map(|i| 0.5 * i.impulse.abs().to_f64()).collect();
            let same = |p: &[f64]| p.iter().zip(&expected).all(|(&p, &q)| close(p, q));
            let forwards = same(&p);
            p.reverse();
            forwards || (doubled && same(&p))
        };
        let orbit = refined.iter().find(matches).unwrap_or_else(|| panic!("{name}: {expected:?}"));
        assert!(close(orbit.period().to_f64(), number("period").unwrap()));
        if let (Some(phi), Some(found)) = (number("phi"), orbit.phi()) {
            let phi = if doubled && phi < 0.5 * orbit.period().to_f64() { orbit.period().to_f64() - phi } else { phi };
            // Printed to 1e-13 at best: where two orbits are close the table has fewer digits.
            assert!((found.to_f64() - phi).abs() < 1e-11, "{name}: {found} {phi}");
        }
        if let (Some(psi), Some(found), false) = (number("psi"), orbit.psi(), doubled) {
            assert!((found.to_f64() - psi).abs() < 1e-11, "{name}: {found} {psi}");
        }
        if let Some(chi2) = number("chi2") {
            assert!(close(orbit.kernel().chi2().to_f64(), chi2), "{name}");
        }
        if let (Some([Some(chi1), Some(chi2), Some(chi3)]), Some(phi), false) = (
            case.values["chi"].as_array().map(|chi| [chi[0].as_f64(), chi[1].as_f64(), chi[2].as_f64()]),
            orbit.phi(),
            doubled,
        ) {
            assert!(close(orbit.kernel().chi1(phi).to_f64(), chi1), "{name}");
            assert!(close(orbit.kernel().chi2().to_f64(), chi2), "{name}");
            assert!((orbit.kernel().chi3(phi).to_f64() - chi3).abs() < 1e-11, "{name}");
        }
        assert_solves_its_equations(orbit);
    }
}

#[test]
fn conservative_orbits_of_one_mass_by_hand() {
    // A mass on a spring Ω² = 1/4 between barriers at a ± 1: on the way from the upper to the lower one in T/2 it moves
    // as α cos Ω(t−T/4) + β sin Ω(t−T/4), with α cos y = a, −β sin y = 1, y = ΩT/4.
    let (omega, a) = (1.7, 0.25);
    let orbit = &orbits(&model(1, (0.25, 0.0), omega, a, (0.0, 1.0)), Family::DoubleSided)[0];
    let truth = refine(orbit);
    let y = Real::pi(512) / omega / 4.0;
    let (sin, cos) = y.sin_cos();
    let (alpha, beta) = (Real::new(a, 512) / &cos, Real::new(-1.0, 512) / &sin);
    // Velocity just after the impact at t = 0, where the phase is −y: Ω(α sin y + β cos y).
    let after = (&alpha * &sin + &beta * &cos) / 2.0;
    assert!((&truth.impacts()[0].velocity_after - &after).log10_abs() < -57.0);
    assert!((&truth.impacts()[0].impulse - &after * 2.0).log10_abs() < -57.0);
    assert!((truth.impacts()[1].velocity_before.clone() - (&beta * &cos - &alpha * &sin) / 2.0).log10_abs() < -57.0);
    assert!((truth.phi().unwrap() - truth.period() / 2.0).log10_abs() < -57.0);
    let middle = truth.period() / 4.0;
    assert!((truth.displacement(0, &middle) - &alpha).log10_abs() < -57.0);

    // One barrier at a − 1: from it and back to it in T, u = α cos Ω(t−T/2) with α cos(ΩT/2) = a − 1.
    let orbit = &orbits(&model(1, (0.25, 0.0), omega, a, (0.0, 1.0)), Family::SingleSided)[0];
    let truth = refine(orbit);
    let (sin, cos) = (Real::pi(512) / omega / 2.0).sin_cos();
    let impulse = Real::new(a - 1.0, 512) / cos * sin;
    assert!((&truth.impacts()[0].impulse - impulse).log10_abs() < -57.0);
    assert_solves_its_equations(&truth);
}

#[test]
fn forced_single_sided_orbits_solve_their_quadratic() {
    // (χ₂² + q²/ω²) p² − 2(1−a)χ₂ p + (1−a)² − Ã² = 0, χ₂ = −cot(ΩT/2)/Ω for one mass.
    let (g1, omega, a, force, e) = (0.25, 1.3, 0.5, 0.75, 0.8);
    let found = orbits(&model(1, (g1, 0.0), omega, a, (force, e)), Family::SingleSided);
    assert_eq!(found.len(), 2);
    let (sin, cos) = (Real::pi(512) / omega * 0.5).sin_cos();
    let chi = -(cos / sin / 0.5);
    let q = (-Real::new(e, 512) + 1.0) / (Real::new(e, 512) + 1.0);
    let response = Real::new(force, 512) / (-(Real::new(omega, 512) * omega) + g1);
    let square = &chi * &chi + &q * &q / omega / omega;
    let mut sum = Real::zero(512);
    for orbit in &found {
        let truth = refine(orbit);
        let p = &truth.impacts()[0].impulse / 2.0;
        let rest = &square * &p * &p - &chi * &p * 2.0 * (1.0 - a) + (1.0 - a) * (1.0 - a) - &response * &response;
        assert!(rest.log10_abs() < -57.0, "{rest}");
        assert_solves_its_equations(&truth);
        sum += p;
    }
    // Both roots, not one twice.
    assert!((sum * &square - &chi * 2.0 * (1.0 - a)).log10_abs() < -57.0);
}

#[test]
fn orbits_under_several_harmonics() {
    let harmonic = |(number, amplitude, phase)| Harmonic { number, amplitude, phase };
    let square = Force::new(&[(1, 0.3, 0.0), (3, -0.1, 0.0), (5, 0.06, 0.0)].map(harmonic)).unwrap();
    let skew =
        Force::new(&[(1, 0.1582, 0.5), (3, 0.002, 1.5 - std::f64::consts::PI), (5, 0.001, 2.5)].map(harmonic)).unwrap();
    let mut families = [0; 3];
    for (family, force, gamma1, omega, a, e) in [
        (Family::DoubleSided, square, 0.2, 1.5, 0.4, 0.9),
        (Family::DoubleSided, square, 0.2, 1.5, 0.0, 0.8),
        (Family::DoubleSided, skew, 0.0, 1.7, 0.3, 0.9),
        (Family::SingleSided, square, 0.2, 0.92, 0.4, 0.9),
        (Family::PeriodDoubled, skew, 0.2, 1.07, 0.8, 0.25),
    ] {
        let chain = Chain::new(21, gamma1, 0.1).unwrap();
        let model = chain.point().omega(omega).asymmetry(a).under(&force).restitution(e).model().unwrap();
        for orbit in &orbits(&model, family) {
            let truth = refine(orbit);
            assert_solves_its_equations(&truth);
            let error = truth.error_of(orbit).unwrap();
            assert!(error.impulse < 1e-11 && error.time < 1e-11 && error.psi < 1e-11, "{family:?} {error:?}");
            families[family as usize] += 1;
        }
    }
    assert!(families.iter().all(|&count| count > 0), "{families:?}");
}

#[test]
fn rings_that_nothing_holds() {
    for (asymmetry, force) in [(0.3, (0.0, 1.0)), (0.3, (0.5, 0.9)), (0.0, (0.5, 0.7)), (0.2, (0.4, 1.0))] {
        let model = model(9, (0.0, 0.1), 1.7, asymmetry, force);
        let found = orbits(&model, Family::DoubleSided);
        assert!(!found.is_empty());
        for orbit in &found {
            let truth = refine(orbit);
            let net = truth.impacts().iter().fold(Real::zero(64), |sum, impact| sum + &impact.impulse);
            assert!(net.log10_abs() < -57.0);
            assert_solves_its_equations(&truth);
            let error = truth.error_of(orbit).unwrap();
            assert!(error.impulse < 1e-12 && error.time < 1e-12 && error.psi < 1e-12, "{error:?}");
        }
    }
    // Held by next to nothing, the orbit is next to that of a free ring.
    let [free, held] = [0.0, 1e-100]
        .map(|gamma1| refine(&orbits(&model(9, (gamma1, 0.1), 1.7, 0.3, (0.5, 0.9)), Family::DoubleSided)[0]));
    assert!((&free.impacts()[1].impulse - &held.impacts()[1].impulse).log10_abs() < -57.0);
}

#[test]
fn asymmetric_conservative_orbits() {
    let found = orbits(&model(21, (0.2, 0.1), 0.42, 0.4, (0.0, 1.0)), Family::DoubleSided);
    let truths: Vec<_> = found.iter().map(refine).collect();
    let fractions: Vec<f64> = truths.iter().map(|orbit| (orbit.phi().unwrap() / orbit.period()).to_f64()).collect();
    assert!(fractions.iter().any(|x| (x - 0.141418).abs() < 1e-6), "{fractions:?}");
    assert!(fractions.contains(&0.5) && fractions.len() >= 3);
    for truth in &truths {
        assert!(truth.kernel().chi3(truth.phi().unwrap()).log10_abs() < -57.0);
        assert_solves_its_equations(truth);
    }
}

#[test]
fn next_to_a_fold_it_converges_or_says_so() {
    // Forced single-sided orbits appear in pairs at this amplitude; the two closest f64 neighbours of the fold that
    // still have orbits.
    let at = |amplitude: f64| model(21, (0.2, 0.1), 1.07, 0.8, (amplitude, 0.25));
    let (mut none, mut some) = (0.157927_f64, 0.157928_f64);
    while f64::from_bits(none.to_bits() + 1) < some {
        let middle = 0.5 * (none + some);
        if orbits(&at(middle), Family::SingleSided).is_empty() { none = middle } else { some = middle }
    }
    assert!((some - 0.157927457267).abs() < 1e-12);
    let mut converged = 0;
    for steps in [0, 1, 4, 16, 1 << 10, 1 << 20] {
        let model = at(f64::from_bits(some.to_bits() + steps));
        for orbit in &orbits(&model, Family::SingleSided) {
            match TrueOrbit::refine(orbit, DEFAULT_BITS) {
                Ok(truth) => {
                    assert_solves_its_equations(&truth);
                    converged += 1;
                    // The f64 orbit is wrong by about the square root of rounding here, and that is seen.
                    let error = truth.error_of(orbit).unwrap();
                    assert!(error.impulse < 1e-6, "{error:?}");
                }
                Err(error) => assert!(matches!(error, TruthError::NotConverged { .. }), "{error}"),
            }
        }
    }
    assert!(converged >= 8, "{converged}");
    // Where there is no orbit a start from next door must not find one.
    let amplitude = f64::from_bits(some.to_bits() + (1 << 20));
    let hits: Vec<_> = orbits(&at(amplitude), Family::SingleSided)[0].impacts().iter().map(Hit::from).collect();
    let psi = orbits(&at(amplitude), Family::SingleSided)[0].psi().unwrap();
    let stranger = Orbit::from_impulses(&at(none - 1e-9), 1, psi, &hits).unwrap();
    let error = TrueOrbit::refine(&stranger, DEFAULT_BITS).unwrap_err();
    assert!(matches!(error, TruthError::NotConverged { .. }), "{error}");
}

#[test]
fn errors_of_an_orbit_are_what_was_put_in() {
    let model = model(21, (0.2, 0.1), 1.5, 0.4, (0.1, 0.9));
    let orbit = &orbits(&model, Family::DoubleSided)[0];
    let truth = refine(orbit);
    let error = truth.error_of(orbit).unwrap();
    assert!(error.impulse < 1e-13 && error.time < 1e-13 && error.psi < 1e-13 && error.acceleration < 1e-13);
    let mut hits: Vec<_> = orbit.impacts().iter().map(Hit::from).collect();
    let largest = hits[0].impulse.abs().max(hits[1].impulse.abs());
    hits[1].time += 3e-6 * orbit.period();
    hits[0].impulse += 2e-6 * largest;
    let psi = orbit.psi().unwrap() - 1e-6 * model.period();
    let word = Orbit::from_impulses(&model, 1, psi, &hits).unwrap();
    let error = truth.error_of(&word).unwrap();
    assert!((error.impulse / 2e-6 - 1.0).abs() < 1e-6, "{error:?}");
    assert!((error.time / 3e-6 - 1.0).abs() < 1e-6 && (error.psi / 1e-6 - 1.0).abs() < 1e-6, "{error:?}");
    // And the word, a bad start, leads to the same orbit.
    let again = refine(&word);
    assert!((&again.impacts()[1].impulse - &truth.impacts()[1].impulse).log10_abs() < -57.0);
    assert!((again.psi().unwrap() - truth.psi().unwrap()).log10_abs() < -57.0);

    let single = &orbits(&model, Family::SingleSided)[0];
    assert!(matches!(truth.error_of(single), Err(TruthError::Mismatch { .. })));
    hits[0].impulse *= 2.0;
    let far = Orbit::from_impulses(&model, 1, psi, &hits).unwrap();
    assert!(TrueOrbit::refine(&far, DEFAULT_BITS).is_err());
    let lossy = model.chain().point().omega(1.5).asymmetry(0.4).restitution(0.9).model().unwrap();
    let dead = Orbit::from_impulses(&lossy, 1, 0.0, &[Hit::new(0, Barrier::Lower, 0.0, 1.0)]).unwrap();
    assert_eq!(TrueOrbit::refine(&dead, DEFAULT_BITS).unwrap_err(), TruthError::Dissipative);
}

#[test]
fn more_digits_extend_fewer() {
    let orbit = &orbits(&model(5, (0.2, 0.1), 1.5, 0.4, (0.1, 0.9)), Family::DoubleSided)[1];
    let (few, many) = (TrueOrbit::refine(orbit, 128).unwrap(), TrueOrbit::refine(orbit, 640).unwrap());
    assert!(many.residual().log10_abs() < -300.0);
    for (a, b) in few.impacts().iter().zip(many.impacts()) {
        assert!((&a.impulse - &b.impulse).log10_abs() < -60.0 && (&a.time - &b.time).log10_abs() < -60.0);
    }
}
