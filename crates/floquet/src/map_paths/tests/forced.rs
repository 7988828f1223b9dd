//! Orbits with forces and losses, and shapes.

use nalgebra::Complex;
use vibrochain_breather::{Family, Finder, Orbit, OrbitList};
use vibrochain_lattice::{Chain, Point};

use super::*;
use crate::Analyser;
use crate::map_paths::Secular;
use crate::reference::eigen::eigenvalues;
use crate::spectrum::{ImpactSpectrum, ModalShape};
use crate::verdict::{Method, Tolerance};

/// A random forced orbit's dense multipliers on the even subspace.
pub(crate) fn forced_cases(
    seed: u64,
    cases: usize,
    family: Family,
    mut check: impl FnMut(&Orbit, &mut Finder, &[Complex<f64>], f64),
) {
    let mut random = Random(seed);
    let (mut finder, mut found) = (Finder::new(21), OrbitList::default());
    for _ in 0..cases {
        let sites = 1 + (random.unit() * 40.0) as usize;
        let chain = Chain::new(sites, random.log(0.02, 1.0), random.log(1e-3, 0.5)).unwrap();
        let (omega, a) = (random.between(0.5, 3.0), random.between(0.0, 0.9));
        let point = chain.point().omega(omega).asymmetry(a);
        let model = point.amplitude(random.log(0.05, 2.0)).restitution(random.between(0.2, 0.99)).model().unwrap();
        if finder.find_symmetric(&model, family, &mut found).is_err() {
            continue;
        }
        for orbit in &found.orbits {
            let Ok(matrix) = crate::even_monodromy(orbit) else { continue };
            let mut dense = Vec::new();
            eigenvalues(&matrix, &mut dense).unwrap();
            finder.motion(orbit).unwrap();
            check(orbit, &mut finder, &dense, matrix.norm());
        }
    }
}

/// The multipliers of the impacts' equations.
fn spectrum(orbit: &Orbit, finder: &mut Finder) -> ImpactSpectrum {
    ImpactSpectrum::new(&finder.at_contacts(orbit).unwrap().bloch_equations().0)
}

#[test]
fn all_multipliers_of_forced_orbits_are_those_of_the_dense_matrix() {
    for (i, family) in [Family::SingleSided, Family::DoubleSided, Family::PeriodDoubled].into_iter().enumerate() {
        let (mut checked, mut doubts) = (0, 0);
        forced_cases(7 + i as u64, 500, family, |orbit, finder, dense, norm| {
            checked += 1;
            let name = || format!("{family:?} {:?}", orbit.model());
            let ImpactSpectrum { multipliers: roots, errors, is_certified } = spectrum(orbit, finder);
            if !is_certified {
                doubts += 1;
                return;
            }
            assert_eq!(roots.len(), dense.len());
            let distance = farthest(&roots, dense).max(farthest(dense, &roots));
            let allowed = 1e-12 * norm + 4.0 * errors.iter().copied().fold(0.0, f64::max);
            assert!(distance <= allowed, "{}: {distance:e}, granted {allowed:e}", name());
            // Nobody is found twice: power sums.
            let (sum, square) =
                (dense.iter().map(|z| z.re).sum::<f64>(), dense.iter().map(|z| (z * z).re).sum::<f64>());
            let scale = allowed * norm * dense.len() as f64;
            assert!((roots.iter().map(|z| z.re).sum::<f64>() - sum).abs() < scale, "{}", name());
            assert!((roots.iter().map(|z| (z * z).re).sum::<f64>() - square).abs() < scale * norm, "{}", name());
        });
        assert!(checked > 450 && doubts < checked / 50, "{family:?}: {doubts} of {checked}");
    }
}

#[test]
fn verdicts_on_forced_orbits() {
    for (i, family) in [Family::SingleSided, Family::DoubleSided, Family::PeriodDoubled].into_iter().enumerate() {
        let (mut analyser, mut checked, mut open) = (Analyser::default(), 0, 0);
        forced_cases(10 + i as u64, 400, family, |orbit, finder, dense, norm| {
            checked += 1;
            let verdict = match analyser.verdict(orbit, finder, Tolerance::Rounding) {
                Ok(verdict) if verdict.method == Method::Secular && !verdict.undecided => verdict,
                _ => {
                    open += 1;
                    return;
                }
            };
            let excess = dense.iter().map(|mu| mu.norm()).fold(0.0, f64::max) - 1.0;
            let blur = 1e-12 * norm + verdict.resolution;
            let name = format!("{family:?} {:?}: {verdict:?}, dense {excess:e}", orbit.model());
            assert!((excess - verdict.excess()).abs() < blur, "{name}");
            assert_eq!(verdict.stable, verdict.excess() < 0.0, "{name}");
        });
        assert!(checked > 350 && open < checked / 50, "{family:?}: {open} of {checked}");
    }
}

#[test]
fn shapes_are_eigenvectors_of_the_monodromy_matrix() {
    let mut checked = 0;
    let mut check = |orbit: &Orbit, finder: &mut Finder, multiplier: Complex<f64>| {
        finder.motion(orbit).unwrap();
        let Ok(shape) = ModalShape::new(&finder.at_contacts(orbit).unwrap(), multiplier) else { return };
        let matrix = crate::full_monodromy(orbit).unwrap();
        let sites = orbit.model().unwrap().chain().sites();
        let (mut state, velocity) = shape.at_sites(sites, orbit.lattice().unwrap().centre().unwrap());
        state.extend(velocity);
        let size = state.iter().map(|z| z.norm()).fold(0.0, f64::max);
        for row in 0..2 * sites {
            let image: Complex<f64> = matrix.row(row).iter().zip(&state).map(|(m, z)| z * *m).sum();
            let defect = (image - multiplier * state[row]).norm();
            assert!(defect < 1e-9 * size * matrix.norm().powi(2), "{:?} {multiplier}: {defect:e}", orbit.model());
        }
        checked += 1;
    };
    for (i, family) in [Family::SingleSided, Family::DoubleSided, Family::PeriodDoubled].into_iter().enumerate() {
        forced_cases(20 + i as u64, 20, family, |orbit, finder, dense, _| {
            for multiplier in dense {
                check(orbit, finder, *multiplier);
            }
        });
    }
    let mut secular = Secular::default();
    for omega in [0.8, 0.92, 0.93, 1.1] {
        for family in BOTH {
            let (mut finder, mut found) = (Finder::new(21), OrbitList::default());
            finder.find_symmetric(&model(21, 0.2, 0.1, omega, 0.4).unwrap(), family, &mut found).unwrap();
            secular.replace(finder.prepared(&found.orbits[0]).unwrap()).unwrap();
            for nu in secular.roots().unwrap().0 {
                for mu in crate::zeros::Nu::of(*nu).multipliers() {
                    check(&found.orbits[0], &mut finder, mu);
                }
            }
        }
    }
    assert!(checked > 1000, "{checked}");
}

/// One and two impacts, weak and strong losses.
#[test]
fn multipliers_of_large_rings_are_those_of_the_dense_matrix() {
    let (mut finder, mut found) = (Finder::new(401), OrbitList::default());
    let mut compared = 0;
    for (family, omega, amplitude, e) in [
        (Family::SingleSided, 0.92, 0.1, 0.9),
        (Family::SingleSided, 0.45, 0.3, 0.3),
        (Family::DoubleSided, 1.5, 0.1, 0.9),
        (Family::PeriodDoubled, 1.5, 0.3, 0.99),
    ] {
        let ring = Point::ring(401).gamma1(0.2).gamma2(0.1);
        let model = ring.omega(omega).asymmetry(0.4).amplitude(amplitude).restitution(e).model().unwrap();
        finder.find(&model, family, &mut found).unwrap();
        let orbit = &found.orbits[0];
        let matrix = crate::even_monodromy(orbit).unwrap();
        let mut dense = Vec::new();
        eigenvalues(&matrix, &mut dense).unwrap();
        finder.motion(orbit).unwrap();
        let ImpactSpectrum { multipliers: values, is_certified, .. } = spectrum(orbit, &mut finder);
        assert!(values.len() == 402 && is_certified);
        let distance = farthest(&values, &dense).max(farthest(&dense, &values));
        assert!(distance < 1e-9, "{family:?} {omega}: {distance:e}");
        compared += 1;
    }
    assert_eq!(compared, 4);
}

/// Elastic impacts under a force: multipliers on the circle are told by structure, those off it by the dense matrix.
#[test]
fn large_elastic_rings_are_judged_without_a_matrix() {
    let mut unstable = 0;
    for (sites, omega, amplitude) in [(401, 0.92, 0.1), (401, 0.45, 0.3), (601, 1.5, 0.3), (501, 2.2, 0.2)] {
        let ring = Point::ring(sites).gamma1(0.2).gamma2(0.1);
        let model = ring.omega(omega).asymmetry(0.4).amplitude(amplitude).model().unwrap();
        let (mut finder, mut found) = (Finder::new(sites), OrbitList::default());
        for family in [Family::SingleSided, Family::DoubleSided] {
            finder.find(&model, family, &mut found).unwrap();
            for orbit in found.orbits.iter().take(2) {
                let verdict = Analyser::default().verdict(orbit, &mut finder, Tolerance::Rounding).unwrap();
                assert_eq!(verdict.method, Method::Secular, "{family:?} {sites} {omega}: {verdict:?}");
                let dense = Analyser::dense().verdict(orbit, &mut finder, Tolerance::Rounding).unwrap();
                let name = format!("{family:?} {sites} {omega}: {verdict:?}, dense {dense:?}");
                assert!(verdict.excess() < dense.excess() + dense.resolution.max(1e-7), "{name}");
                if dense.excess() > 1e-6 {
                    let allowed = 1e-9 * (1.0 + dense.excess()) + dense.resolution + verdict.resolution;
                    assert!((verdict.excess() - dense.excess()).abs() < allowed, "{name}");
                    unstable += 1;
                }
            }
        }
    }
    assert!(unstable > 3, "{unstable}");
}
