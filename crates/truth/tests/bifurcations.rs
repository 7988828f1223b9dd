//! Bifurcation points against conditions in 50 digits: what must vanish changes its sign within the error that comes with
//! the answer.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test stops at the first surprise")]

use vibrochain_breather::{Family, Orbit, breathers};
use vibrochain_floquet::{Event, Evidence, Located, Search, locate};
use vibrochain_lattice::{Model, Parameter, Point};
use vibrochain_truth::{Complex, DEFAULT_BITS, Kernel, Real, TrueOrbit, TrueSpectrum};

fn model(gamma: (f64, f64), omega: f64, asymmetry: f64, force: (f64, f64)) -> Model {
    let ring = Point::ring(21).gamma1(gamma.0).gamma2(gamma.1);
    ring.omega(omega).asymmetry(asymmetry).amplitude(force.0).restitution(force.1).model().unwrap()
}

fn find(model: &Model, family: Family, which: usize, search: (Event, Parameter, f64, f64)) -> Vec<Located> {
    let orbit = &breathers(model, family).unwrap().orbits[which];
    let (event, free, from, to) = search;
    let answer = locate(orbit, &Search { event, free, from, to }).unwrap();
    assert!(!answer.located.is_empty(), "{answer:?}");
    answer.located
}

/// The orbit of 50 digits next to `orbit`, at a parameter of f64.
fn refined(orbit: &Orbit, free: Parameter, value: f64) -> TrueOrbit {
    let model = orbit.model().unwrap().with(free, value).unwrap();
    let found = breathers(&model, orbit.family()).unwrap().orbits;
    let unlike = |other: &Orbit| {
        let pairs = other.impacts().iter().zip(orbit.impacts());
        pairs.map(|(a, b)| (a.impulse - b.impulse).abs() + (a.time - b.time).abs()).fold(0.0, f64::max)
    };
    let nearest = found.iter().min_by(|a, b| unlike(a).total_cmp(&unlike(b))).unwrap();
    assert!(unlike(nearest) < 1e-4, "{}", unlike(nearest));
    TrueOrbit::refine(nearest, DEFAULT_BITS).unwrap()
}

/// The condition has different signs on both sides of the answer, an error away (but at least `least`, as the test at hand
/// can start from an f64 orbit there).
fn assert_within_error(found: &Located, free: Parameter, condition: impl Fn(&TrueOrbit) -> Real) {
    assert!(found.error < 1e-12, "{:e}", found.error);
    let side = |sign: f64| condition(&refined(&found.orbit, free, found.value + sign * found.error));
    let (low, high) = (side(-1.0), side(1.0));
    assert!(low.is_negative() != high.is_negative(), "{} ± {:e}: {low} {high}", found.value, found.error);
}

fn characteristic(orbit: &TrueOrbit, z: f64) -> Real {
    let spectrum = TrueSpectrum::new(orbit).unwrap();
    spectrum.characteristic(&Complex::new(z, 0.0, 256)).unwrap().re
}

/// |μ|² − 1 of the multiplier next to `start`.
fn excess(orbit: &TrueOrbit, start: (f64, f64)) -> Real {
    let (multiplier, moved) = TrueSpectrum::new(orbit).unwrap().refine(start).unwrap();
    assert!(moved < 1e-9, "{moved}");
    multiplier.norm_sqr() - 1.0
}

#[test]
fn period_doublings() {
    let start = model((0.2, 0.1), 1.07, 0.8, (0.165, 0.25));
    for (free, from, to) in [
        (Parameter::Amplitude, 0.15, 0.2),
        (Parameter::Restitution, 0.05, 1.0),
        (Parameter::Gamma1, 0.1, 0.4),
        (Parameter::Gamma2, 0.05, 0.2),
        (Parameter::Omega, 1.0, 1.3),
        (Parameter::Asymmetry, 0.7, 0.9),
    ] {
        for found in find(&start, Family::SingleSided, 0, (Event::PeriodDoubling, free, from, to)) {
            println!("{} = {} ± {:e}", free.name(), found.value, found.error);
            assert_within_error(&found, free, |orbit| characteristic(orbit, -1.0));
        }
    }
}

#[test]
fn neimark_sacker() {
    let start = model((0.2, 0.09), 0.92, 0.7, (0.05, 0.9));
    for found in find(&start, Family::SingleSided, 0, (Event::NeimarkSacker, Parameter::Gamma2, 0.08, 0.11)) {
        let Evidence::Multiplier(multiplier) = found.evidence else { panic!("{:?}", found.evidence) };
        println!("{} ± {:e}", found.value, found.error);
        assert_within_error(&found, Parameter::Gamma2, |orbit| excess(orbit, (multiplier.re, multiplier.im)));
    }
}

#[test]
fn grazing_at_a_peak_and_by_an_impact() {
    let single = model((0.2, 0.1), 0.92, 0.4, (0.1, 0.9));
    for found in find(&single, Family::SingleSided, 0, (Event::Grazing, Parameter::Omega, 0.78, 0.95)) {
        let Evidence::Touch(touch) = found.evidence else { panic!("{:?}", found.evidence) };
        println!("{} ± {:e} {touch:?}", found.value, found.error);
        // The peak: Newton's method for zero velocity, from the time of the answer.
        assert_within_error(&found, Parameter::Omega, |orbit| {
            let mut t = Real::new(touch.time, 256);
            for _ in 0..8 {
                t = &t - orbit.velocity(touch.site, &t) / orbit.acceleration(touch.site, &t);
            }
            assert!(orbit.velocity(touch.site, &t).log10_abs() < -40.0);
            let outward = (orbit.displacement(touch.site, &t) - orbit.model().asymmetry()) * touch.barrier.sign();
            outward - 1.0
        });
    }
    let double = model((0.2, 0.1), 0.95, 0.4, (0.1, 0.9));
    for found in find(&double, Family::DoubleSided, 0, (Event::Grazing, Parameter::Omega, 0.9, 1.0)) {
        let Evidence::Impact(impact) = found.evidence else { panic!("{:?}", found.evidence) };
        println!("{} ± {:e}", found.value, found.error);
        assert_within_error(&found, Parameter::Omega, |orbit| orbit.impacts()[impact].velocity_before.clone());
    }
}

#[test]
fn pitchfork_of_figure_nine() {
    let start = model((0.1, 0.05), 1.33, 0.0, (1.5, 0.5));
    let found = find(&start, Family::DoubleSided, 0, (Event::Pitchfork, Parameter::Restitution, 0.4, 0.7));
    println!("{} ± {:e}", found[0].value, found[0].error);
    assert_within_error(&found[0], Parameter::Restitution, |orbit| characteristic(orbit, 1.0));
}

/// The single-sided orbits exist from A = |γ₁−ω²|(1−a) q/√(q²+ω²χ₂²) on.
#[test]
fn fold_of_the_single_sided_family() {
    let start = model((0.2, 0.1), 1.07, 0.8, (0.165, 0.25));
    let found = &find(&start, Family::SingleSided, 0, (Event::Fold, Parameter::Amplitude, 0.15, 0.2))[0];
    let kernel = Kernel::new(start.chain(), 1.07, 1, DEFAULT_BITS).unwrap();
    let q = Real::new(0.75, 256) / 1.25;
    let omega = Real::new(1.07, 256);
    let swing = &omega * kernel.chi2();
    let norm = (&q * &q + &swing * &swing).sqrt();
    let least = (&omega * &omega - 0.2) * (-Real::new(0.8, 256) + 1.0) * &q / norm;
    let error = (least - found.value).abs().to_f64();
    println!("{} ± {:e}: {error:e}", found.value, found.error);
    assert!(error <= found.error && found.error < 1e-13, "{error:e} {:e}", found.error);
}
