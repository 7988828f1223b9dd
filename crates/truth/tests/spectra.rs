//! Multipliers in many digits against dense ones, closed forms by hand and exact sums and products.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test stops at the first surprise")]

use vibrochain_breather::{Family, Hit, Orbit, breathers};
use vibrochain_floquet::{eigenvalues, even_monodromy};
use vibrochain_lattice::{Chain, Model, Point};
use vibrochain_testkit::{Random, reference};
use vibrochain_truth::{Complex, DEFAULT_BITS, Real, TrueOrbit, TrueSpectrum, TruthError};

fn model(sites: usize, gamma: (f64, f64), omega: f64, asymmetry: f64, force: (f64, f64)) -> Model {
    let ring = Point::ring(sites).gamma1(gamma.0).gamma2(gamma.1);
    ring.omega(omega).asymmetry(asymmetry).amplitude(force.0).restitution(force.1).model().unwrap()
}

fn orbits(model: &Model, family: Family) -> Vec<Orbit> {
    breathers(model, family).unwrap().orbits
}

fn dense_multipliers(orbit: &Orbit) -> Vec<vibrochain_floquet::Complex<f64>> {
    let mut values = Vec::new();
    eigenvalues(&even_monodromy(orbit).unwrap(), &mut values).unwrap();
    values
}

fn spectrum(orbit: &Orbit) -> TrueSpectrum {
    TrueSpectrum::new(&TrueOrbit::refine(orbit, DEFAULT_BITS).unwrap()).unwrap()
}

/// Refines every dense multiplier. If they are all the roots, each once, their sum is the trace and their product the
/// determinant to all digits: nothing else is.
fn assert_complete(orbit: &Orbit, tolerance: f64) -> Vec<Complex> {
    let spectrum = spectrum(orbit);
    let dense = dense_multipliers(orbit);
    assert_eq!(dense.len(), spectrum.dimension());
    let (mut sum, mut product) = (Complex::new(0.0, 0.0, 256), Complex::new(1.0, 0.0, 256));
    let mut size = Real::one(64);
    let mut roots = Vec::new();
    for mu in dense {
        let (root, moved) = spectrum.refine((mu.re, mu.im)).unwrap();
        assert!(moved < tolerance * mu.norm().max(1.0), "{mu} {moved}");
        sum = &sum + &root;
        product = &product * &root;
        size += root.abs();
        roots.push(root);
    }
    let trace = Complex::real(spectrum.trace());
    let determinant = Complex::real(spectrum.determinant());
    assert!((&sum - &trace).log2_abs() < size.log2_abs() - 170.0, "{sum:?} {trace:?}");
    assert!((&product - &determinant).log2_abs() < -170.0, "{product:?} {determinant:?}");
    roots
}

#[test]
fn every_multiplier_of_the_reference_table() {
    for case in reference() {
        let (name, model, family) = (&case.name, case.model, case.family);
        let number = |key: &str| case.number(key);
        let p = number("p").or(number("p1")).unwrap();
        let has = |orbit: &&Orbit| orbit.impacts().iter().any(|impact| (0.5 * impact.impulse.abs() - p).abs() < 1e-10);
        // Mirror images share their impulses, and their multipliers.
        let found = orbits(&model, family);
        let orbit = found.iter().find(has).unwrap_or_else(|| panic!("{name}"));
        let roots = assert_complete(orbit, 1e-6);
        let radius = roots.iter().map(|root| root.abs().to_f64()).fold(0.0, f64::max);
        let expected = number("spectral_radius").unwrap();
        assert!((radius / expected - 1.0).abs() < if expected > 1000.0 { 1e-6 } else { 1e-8 }, "{name}: {radius}");
        if model.is_conservative() {
            // The trivial pair is exact, and so is the circle.
            let ones = roots.iter().filter(|root| (*root - Complex::new(1.0, 0.0, 64)).log2_abs() < -192.0).count();
            assert_eq!(ones, 2, "{name}");
            let on_circle = |root: &&Complex| (root.abs() - 1.0).log2_abs() < -190.0;
            let off = roots.len() - roots.iter().filter(on_circle).count();
            assert_eq!(off, if expected > 1.001 { 2 } else { 0 }, "{name}");
        }
    }
}

#[test]
fn random_parameters_of_every_family() {
    let mut generator = Random(12_345);
    let mut random = || generator.unit();
    let mut checked = [0; 3];
    for case in 0..40 {
        let sites = 1 + (random() * 9.0) as usize;
        let gamma = (if case % 5 == 0 { 0.0 } else { 0.05 + random() }, 0.01 + 0.3 * random());
        let (omega, asymmetry) = (0.5 + 2.0 * random(), if case % 4 == 0 { 0.0 } else { 0.9 * random() });
        let force = match case % 3 {
            0 => (0.0, 1.0),
            1 => (2.0 * random(), 0.2 + 0.8 * random()),
            _ => (random(), 1.0),
        };
        let model = model(sites, gamma, omega, asymmetry, force);
        let families = [Family::DoubleSided, Family::SingleSided, Family::PeriodDoubled];
        for (family, checked) in families.into_iter().zip(&mut checked) {
            let Ok(found) = breathers(&model, family) else { continue };
            for orbit in found.orbits.iter().take(2) {
                let truth = TrueOrbit::refine(orbit, DEFAULT_BITS).unwrap_or_else(|error| panic!("{error}: {orbit:?}"));
                assert!(truth.residual().log10_abs() < -55.0, "{orbit:?}");
                let error = truth.error_of(orbit).unwrap();
                assert!(error.impulse < 1e-9 && error.time < 1e-9 && error.psi < 1e-9, "{error:?} {orbit:?}");
                // Next to grazing the multipliers of an f64 orbit are those of another one.
                let slow = orbit.impacts().iter().map(|impact| impact.velocity_before.abs()).fold(1.0, f64::min);
                if slow > 1e-3 {
                    assert_complete(orbit, 1e-4);
                    *checked += 1;
                }
            }
        }
    }
    assert!(checked.iter().all(|&checked| checked >= 5), "{checked:?}");
}

#[test]
fn a_start_on_the_real_axis_between_a_complex_pair_finds_one_of_them() {
    let orbit = &orbits(&model(1, (0.2, 0.0), 1.5, 0.4, (0.1, 0.9)), Family::DoubleSided)[0];
    let spectrum = spectrum(orbit);
    let pair = dense_multipliers(orbit);
    assert!(pair[0].im.abs() > 0.1 && pair.len() == 2);
    let (root, moved) = spectrum.refine((pair[0].re, 0.0)).unwrap();
    assert!((root.abs() * root.abs() - spectrum.determinant()).log10_abs() < -57.0);
    assert!((moved / pair[0].im.abs() - 1.0).abs() < 1e-12);
}

#[test]
fn one_mass_by_hand() {
    // M = R(T)S: trace −2e cos ΩT + κ sin(ΩT)/Ω, determinant e², κ = (1+e)v̈/v⁻.
    let (g1, omega, a, force, e) = (0.25, 1.3, 0.5, 0.75, 0.8);
    for orbit in &orbits(&model(1, (g1, 0.0), omega, a, (force, e)), Family::SingleSided) {
        let truth = TrueOrbit::refine(orbit, DEFAULT_BITS).unwrap();
        let spectrum = TrueSpectrum::new(&truth).unwrap();
        let e = Real::new(e, 512);
        let impact = &truth.impacts()[0];
        let (sin, cos) = (Real::pi(512) / omega).sin_cos();
        let kappa = (&e + 1.0) * &impact.acceleration / &impact.velocity_before;
        let trace = kappa * sin * 2.0 - &e * cos * 2.0;
        assert!((spectrum.trace() - &trace).log10_abs() < -57.0);
        assert!((spectrum.determinant() - &e * &e).log10_abs() < -57.0);
        let root = Complex::real(&trace * &trace / 4.0 - &e * &e).sqrt();
        for mu in [Complex::real(&trace / 2.0) + &root, Complex::real(&trace / 2.0) - &root] {
            let (found, moved) = spectrum.refine(mu.to_f64()).unwrap();
            assert!((&found - &mu).log2_abs() < mu.log2_abs() - 190.0, "{found:?} {mu:?}");
            assert!(moved < 1e-15 * mu.abs().to_f64().max(1.0), "{moved} {mu:?}");
        }
    }
}

#[test]
fn words_rings_that_nothing_holds_and_elastic_forced_orbits() {
    for (sites, gamma1, force) in [(9, 0.0, (0.5, 0.9)), (8, 0.2, (0.3, 1.0)), (2, 0.2, (0.3, 0.7))] {
        for orbit in &orbits(&model(sites, (gamma1, 0.1), 1.7, 0.3, force), Family::DoubleSided) {
            assert_complete(orbit, 1e-6);
        }
    }
    // A rigid mode has its pole where a conservative orbit has its trivial pair.
    let free = &orbits(&model(9, (0.0, 0.1), 1.7, 0.3, (0.0, 1.0)), Family::DoubleSided)[0];
    for start in [(1.0, 0.0), (1.0, 1e-8), (1.0 + 1e-7, 0.0)] {
        let (root, moved) = spectrum(free).refine(start).unwrap();
        assert!((root.re - 1.0).log10_abs() < -57.0 && root.im.log10_abs() < -57.0 && moved < 2e-7);
    }
    // Two periods as one word of four impacts: the multipliers are squares.
    let forced = &orbits(&model(5, (0.2, 0.1), 1.5, 0.4, (0.1, 0.9)), Family::DoubleSided)[0];
    let twice: Vec<_> = (0..2)
        .flat_map(|n| {
            forced.impacts().iter().map(move |i| Hit { time: i.time + f64::from(n) * forced.period(), ..Hit::from(i) })
        })
        .collect();
    let word = Orbit::from_impulses(forced.model().unwrap(), 2, forced.psi().unwrap(), &twice).unwrap();
    let (once, twice) = (spectrum(forced), spectrum(&word));
    assert!((twice.determinant() - once.determinant().powi(2)).log10_abs() < -57.0);
    for mu in dense_multipliers(forced) {
        let (root, _) = once.refine((mu.re, mu.im)).unwrap();
        let square = &root * &root;
        let (found, moved) = twice.refine(square.to_f64()).unwrap();
        assert!((found - square).log2_abs() < -190.0 && moved < 1e-15);
    }
}

#[test]
fn weak_coupling_is_told_apart_from_none() {
    // Multipliers within 1e-13 of poles that are as close to each other.
    let coupled = &orbits(&model(7, (0.2, 1e-12), 1.5, 0.4, (0.1, 0.9)), Family::DoubleSided)[0];
    let near = spectrum(coupled);
    let single = &orbits(&model(1, (0.2, 0.0), 1.5, 0.4, (0.1, 0.9)), Family::DoubleSided)[0];
    let alone = spectrum(single);
    for mu in dense_multipliers(single) {
        let (isolated, _) = alone.refine((mu.re, mu.im)).unwrap();
        let (root, moved) = near.refine(isolated.to_f64()).unwrap();
        assert!(moved < 1e-10 && (root - isolated).log2_abs() > -60.0);
    }
    // Those of the other masses, on the circle to 1e-12.
    let angle = 0.2_f64.sqrt() * coupled.period();
    let (root, moved) = near.refine((angle.cos(), angle.sin())).unwrap();
    assert!(moved < 1e-10 && (root.abs() - 1.0).log10_abs() < -20.0, "{root:?}");

    // Without coupling they are the poles themselves.
    let uncoupled = &orbits(&model(7, (0.2, 0.0), 1.5, 0.4, (0.1, 0.9)), Family::DoubleSided)[0];
    let error = spectrum(uncoupled).refine((angle.cos(), -angle.sin())).unwrap_err();
    assert_eq!(error, TruthError::OnPole { mode: 0, multiplicity: 4 });
    let (mu, _) = alone.refine((0.8, 0.1)).unwrap();
    let (same, _) = spectrum(uncoupled).refine(mu.to_f64()).unwrap();
    assert!((mu - same).log2_abs() < -190.0);
}

#[test]
fn a_crossing_of_the_circle_is_where_it_is_known_to_be() {
    // Neimark–Sacker at γ₂ = 0.088347387971: |μ| − 1 changes sign within the digits given.
    let excess = |gamma2: f64| {
        let found = orbits(&model(21, (0.2, gamma2), 0.92, 0.7, (0.05, 0.9)), Family::SingleSided);
        let orbit = found.iter().max_by(|a, b| a.impacts()[0].impulse.total_cmp(&b.impacts()[0].impulse)).unwrap();
        let spectrum = spectrum(orbit);
        let dense = dense_multipliers(orbit);
        dense
            .iter()
            .map(|mu| spectrum.refine((mu.re, mu.im)).unwrap().0.abs() - 1.0)
            .reduce(|a, b| if b > a { b } else { a })
            .unwrap()
    };
    let (before, after) = (excess(0.088347387971 - 1e-12), excess(0.088347387971 + 1e-12));
    assert!(before.is_negative() && !after.is_negative(), "{before} {after}");
    assert!(after.log10_abs() < -10.0);
}

#[test]
fn what_cannot_be_answered_is_an_error() {
    let model = model(5, (0.2, 0.1), 1.5, 0.4, (0.0, 1.0));
    let orbit = &orbits(&model, Family::DoubleSided)[0];
    let spectrum = spectrum(orbit);
    for start in [(0.0, 0.0), (f64::NAN, 0.0), (f64::INFINITY, 1.0)] {
        assert!(matches!(spectrum.refine(start), Err(TruthError::Parameter { .. })));
    }
    // Two masses that move as one: an orbit, but with impacts at two sites.
    let one = Model::conservative(Chain::new(1, 0.2, 0.0).unwrap(), 1.5, 0.4).unwrap();
    let two = Model::conservative(Chain::new(2, 0.2, 0.1).unwrap(), 1.5, 0.4).unwrap();
    let single = &orbits(&one, Family::DoubleSided)[0];
    let both = |i: usize| {
        let impact = single.impacts()[i];
        [0, 1].map(|site| Hit { site, ..Hit::from(&impact) })
    };
    let word = Orbit::from_impulses(&two, 1, 0.0, &[both(0), both(1)].concat()).unwrap();
    let truth = TrueOrbit::refine(&word, DEFAULT_BITS).unwrap();
    let alone = TrueOrbit::refine(single, DEFAULT_BITS).unwrap();
    assert!((&truth.impacts()[3].impulse - &alone.impacts()[1].impulse).log10_abs() < -57.0);
    assert_eq!(TrueSpectrum::new(&truth).unwrap_err(), TruthError::SeveralSites);
}
