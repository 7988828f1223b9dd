//! Monodromy matrices against finite differences of a simulated return map, every family and several ring sizes.

use nalgebra::DMatrix;
use vibrochain::breather::{Family, Hit, Orbit, breathers};
use vibrochain::floquet::{Complex, Tolerance, even_monodromy, full_monodromy, stability};
use vibrochain::lattice::{Barrier, Chain, ImpulseResponse, Model, Spectrum};
use vibrochain_testkit::ReturnMap;

const SIZES: [usize; 6] = [1, 2, 3, 5, 20, 21];

fn check(orbit: &Orbit, name: &str) {
    check_within(orbit, name, 1e-7);
}

fn check_within(orbit: &Orbit, name: &str, tolerance: f64) {
    let map = ReturnMap::new(orbit);
    if map.slowest_impact() < 0.02 {
        // Next to grazing differences of the map lose their digits before they see its slope.
        return;
    }
    let point = map.fixed_point();
    let closure = (map.apply(&point) - &point).amax();
    assert!(closure < 1e-11, "{name}: closes to {closure:e}");
    // The matrix starts just before the first impact, the map earlier by `lead`: M·L(lead) = L(lead)·M_map.
    let lead = map.ring.flow(-map.start);
    let matrix = full_monodromy(orbit).unwrap();
    let difference = (&matrix * &lead - &lead * map.jacobian()).amax();
    assert!(difference < tolerance * matrix.amax().max(1.0), "{name}: {difference:e}");
}

/// Power sums Σμ and Σμ² of all multipliers against the traces of M and M².
fn check_traces(orbit: &Orbit, name: &str) {
    let matrix = full_monodromy(orbit).unwrap();
    let multipliers = stability(orbit, Tolerance::Rounding).unwrap().multipliers;
    assert_eq!(multipliers.len(), matrix.nrows(), "{name}");
    let scale = matrix.norm().powi(2);
    let square: DMatrix<f64> = &matrix * &matrix;
    for (trace, sum) in [
        (matrix.trace(), multipliers.iter().sum::<Complex<f64>>()),
        (square.trace(), multipliers.iter().map(|m| m * m).sum()),
    ] {
        assert!((trace - sum.re).abs() < 1e-12 * scale && sum.im.abs() < 1e-12 * scale, "{name}: {trace} {sum}");
    }
}

#[test]
fn conservative_families() {
    for sites in SIZES {
        let chain = Chain::new(sites, 0.2, 0.1).unwrap();
        for (family, omega) in [
            (Family::DoubleSided, 1.5),
            (Family::DoubleSided, 0.42),
            (Family::SingleSided, 0.8),
            (Family::SingleSided, 0.93),
        ] {
            let model = Model::conservative(chain, omega, 0.4).unwrap();
            let found = breathers(&model, family).unwrap();
            assert!(!found.orbits.is_empty());
            for (i, orbit) in found.orbits.iter().enumerate() {
                let name = format!("{sites} {family:?} {omega} {i}");
                check(orbit, &name);
                check_traces(orbit, &name);
            }
        }
    }
}

#[test]
fn forced_families() {
    for sites in SIZES {
        let chain = Chain::new(sites, 0.2, 0.1).unwrap();
        let mut families = [0; 3];
        for (i, (family, omega, a, amplitude, e)) in [
            (Family::DoubleSided, 1.5, 0.4, 0.1, 0.9),
            (Family::DoubleSided, 1.33, 0.0, 1.5, 0.6),
            (Family::DoubleSided, 1.5, 0.4, 0.9, 1.0),
            (Family::SingleSided, 0.92, 0.4, 0.1, 0.9),
            (Family::SingleSided, 0.92, 0.4, 0.1, 1.0),
            (Family::PeriodDoubled, 1.07, 0.8, 0.1582, 0.25),
        ]
        .into_iter()
        .enumerate()
        {
            let model = chain.point().omega(omega).asymmetry(a).amplitude(amplitude).restitution(e).model().unwrap();
            for orbit in &breathers(&model, family).unwrap().orbits {
                families[family as usize] += 1;
                let name = format!("{sites} case {i} φ {:?}", orbit.phi());
                check(orbit, &name);
                check_traces(orbit, &name);
            }
        }
        assert!(families[0] > 0 && families[1] > 0, "{sites}: {families:?}");
        assert!(families[2] > 0 || sites < 20, "{sites}: {families:?}");
    }
}

/// Two masses of one ring that hit in step: the impulses solve two linear conditions for each instant.
fn two_site_orbit(sites: usize, second: usize) -> Orbit {
    let model = Model::conservative(Chain::new(sites, 0.2, 0.1).unwrap(), 1.5, 0.3).unwrap();
    let response = ImpulseResponse::new(&Spectrum::new(*model.chain()), model.omega()).unwrap();
    let half = 0.5 * model.period();
    let hits = [
        (0, Barrier::Upper, 0.0),
        (second, Barrier::Lower, 0.0),
        (0, Barrier::Lower, half),
        (second, Barrier::Upper, half),
    ];
    let matrix = DMatrix::from_fn(4, 4, |i, j| {
        let elapsed: f64 = hits[i].2 - hits[j].2;
        response.value(model.chain().distance(hits[i].0, hits[j].0), elapsed.abs())
    });
    let wanted = nalgebra::DVector::from_iterator(4, hits.iter().map(|hit| model.barrier(hit.1)));
    let impulses = matrix.lu().solve(&wanted).unwrap();
    let word: Vec<_> = hits.iter().zip(&impulses).map(|(hit, p)| Hit::new(hit.0, hit.1, hit.2, *p)).collect();
    Orbit::from_impulses(&model, 1, 0.0, &word).unwrap()
}

#[test]
fn impacts_at_two_sites_go_through_the_full_space() {
    for (sites, second) in [(5, 2), (8, 3), (21, 1)] {
        let orbit = two_site_orbit(sites, second);
        assert!(orbit.residual() < 1e-13 && orbit.lattice().unwrap().centre().is_none());
        check_within(&orbit, &format!("{sites} {second}"), 1e-6);
        check_traces(&orbit, &format!("{sites} {second}"));
        assert!(even_monodromy(&orbit).is_err());
    }
}

/// Largest distance of any value of `some` from the nearest of `all`.
fn farthest(some: &[Complex<f64>], all: &[Complex<f64>]) -> f64 {
    let nearest = |z: &Complex<f64>| all.iter().map(|w| (z - w).norm()).fold(f64::INFINITY, f64::min);
    some.iter().map(nearest).fold(0.0, f64::max)
}

#[test]
fn the_even_subspace_and_the_odd_modes_make_up_the_full_spectrum() {
    for sites in SIZES {
        let chain = Chain::new(sites, 0.2, 0.1).unwrap();
        let model = chain.point().omega(1.5).asymmetry(0.4).amplitude(0.1).restitution(0.9).model().unwrap();
        for orbit in &breathers(&model, Family::DoubleSided).unwrap().orbits {
            let found = stability(orbit, Tolerance::Rounding).unwrap().multipliers;
            let full: Vec<_> = full_monodromy(orbit).unwrap().complex_eigenvalues().iter().copied().collect();
            assert!(farthest(&found, &full) < 1e-9 && farthest(&full, &found) < 1e-9, "{sites}");
        }
    }
}
