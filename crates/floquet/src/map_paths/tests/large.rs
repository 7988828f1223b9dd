//! Large rings.

use vibrochain_breather::{Family, Finder, OrbitList};

use super::*;
use crate::Analyser;
use crate::map_paths::fast_sums::large_reversible as large;
use crate::map_paths::reversible::{double_sided, single_sided};
use crate::map_paths::{Secular, Standing, modes};
use crate::spectrum::{SpectralFunction, origins};
use crate::verdict::{Method, Tolerance};
use crate::zeros::{Nu, excess as outside_circle};

#[test]
fn residues_of_large_rings_are_those_of_the_pair_formulas() {
    let mut finder = Finder::new(1201);
    let mut found = OrbitList::default();
    let mut checked = 0;
    for (omega, g2) in [(0.8, 0.1), (1.5, 0.1), (0.31, 0.2), (0.9, 0.01), (0.173, 0.3)] {
        let model = model(1201, 0.2, g2, omega, 0.4).unwrap();
        for family in BOTH {
            finder.find_symmetric(&model, family, &mut found).unwrap();
            let orbit = &found.orbits[0];
            let (mut whole, mut modes) = (modes::Modes::default(), modes::Modes::default());
            whole.set(finder.prepared(orbit).unwrap().response());
            // Four at a time, too, for the pairs.
            modes.gather(&whole, &(0..whole.count()).collect::<Vec<_>>());
            let (mut pairs, mut sums) = (Vec::new(), Vec::new());
            if family == Family::SingleSided {
                single_sided::residues(&modes, &mut pairs);
                large::single_sided(&modes, &mut sums);
            } else {
                let ratio = orbit.impacts()[1].impulse / orbit.impacts()[0].impulse;
                let saltations = double_sided::Saltations::new(&modes, ratio, 0.0);
                double_sided::residues(&modes, &saltations, &mut Vec::new(), &mut pairs);
                large::double_sided(&modes, &saltations, &mut sums);
            }
            sums.sort_by_key(|pole| pole.mode);
            assert_eq!(pairs.len(), sums.len());
            for (a, b) in pairs.iter().zip(&sums) {
                let allowed = 20.0 * (a.error + b.error) + 1e-12 * a.residue.abs();
                assert!((a.residue - b.residue).abs() <= allowed, "{family:?} {omega} {g2}: {a:?} {b:?}");
                checked += 1;
            }
        }
    }
    assert_eq!(checked, 5 * 2 * 601);
}

#[test]
fn large_rings_have_all_their_roots() {
    let mut finder = Finder::new(21);
    let mut found = OrbitList::default();
    let mut secular = Secular::default();
    for (sites, omega, g2) in [(601, 0.8, 0.1), (701, 1.5, 0.1), (800, 0.6, 0.2), (1001, 0.6, 0.1), (1001, 0.55, 0.3)] {
        let model = model(sites, 0.2, g2, omega, 0.4).unwrap();
        for family in BOTH {
            finder.find_symmetric(&model, family, &mut found).unwrap();
            let orbit = &found.orbits[0];
            secular.replace(finder.prepared(orbit).unwrap()).unwrap();
            let (values, norm) = dense(orbit, &mut finder);
            let leading = values.iter().map(|nu| excess(*nu)).fold(0.0, f64::max);
            let verdict = secular.verdict().unwrap();
            let name = format!("{family:?} {sites} {omega}: {verdict:?}, dense {leading:e}");
            assert!((verdict.excess - leading).abs() < 1e-8 * norm, "{name}");
            let (roots, errors) = secular.roots().unwrap();
            assert_eq!(roots.len(), values.len(), "{name}");
            let allowed = 1e-11 + errors.iter().copied().fold(0.0, f64::max);
            let distance = farthest(roots, &values).max(farthest(&values, roots));
            assert!(distance < allowed, "{name}: {distance:e} {allowed:e}");
        }
    }
}

/// Where errors of residues leave a large ring open, the multiplier that leads is the one that does when each that may is refined in full.
#[test]
fn one_step_passes_over_multipliers_that_do_not_lead() {
    for sites in [40_001, 100_000] {
        let (mut finder, mut found, mut analyser) = (Finder::new(sites), OrbitList::default(), Analyser::default());
        finder.find_symmetric(&model(sites, 0.2, 0.1, 1.5, 0.4).unwrap(), Family::DoubleSided, &mut found).unwrap();
        let (orbit, tolerance) = (&found.orbits[0], Tolerance::Rounding);
        analyser.secular.replace(finder.prepared(orbit).unwrap()).unwrap();
        assert_eq!(analyser.secular.verdict().unwrap().outcome, Standing::Undecided);
        let told = analyser.stability(orbit, &mut finder, tolerance).unwrap().verdict;
        let known = finder.at_contacts(orbit).unwrap();
        let (equations, _) = known.bloch_equations();
        let data = origins(&equations, known.error_origins());
        let function = SpectralFunction::taking(equations, true);
        let may_lead = |(nu, error): &(Nu, f64)| nu.excess() + nu.excess_error(nu.excess(), *error) > told.excess();
        let open: Vec<Nu> = analyser.secular.all_nu().unwrap().filter(may_lead).map(|(nu, _)| nu).collect();
        let refined = open.iter().filter_map(|nu| function.refine(nu.multipliers()[0], &data));
        let excesses: Vec<f64> = refined.map(|refined| outside_circle(refined.z)).collect();
        let leading = excesses.iter().copied().fold(0.0, f64::max);
        assert!((leading - told.excess()).abs() < 1e-14 && told.resolution < 0.03 * leading, "{leading:e} {told:?}");
        assert!(excesses.iter().filter(|excess| **excess < 0.999 * leading).count() >= 40, "{}", excesses.len());
    }
}

/// The isolated multiplier of a single-sided breather converges exponentially with the length of the ring, to
/// ν = 1.57752638953639 for ω = 0.8; and a ring of 20001 masses has 10000 roots.
#[test]
fn a_long_ring_has_the_isolated_multiplier_of_the_infinite_one() {
    let (mut finder, mut found, mut secular) = (Finder::new(20001), OrbitList::default(), Secular::default());
    finder.find_symmetric(&model(20001, 0.2, 0.1, 0.8, 0.4).unwrap(), Family::SingleSided, &mut found).unwrap();
    secular.replace(finder.prepared(&found.orbits[0]).unwrap()).unwrap();
    let verdict = secular.verdict().unwrap();
    let leading = verdict.leading.unwrap();
    assert!(verdict.outcome == Standing::Unstable && leading.im == 0.0);
    assert!((0.5 * (leading.re + 1.0 / leading.re) - 1.57752638953639).abs() < 2e-12, "{verdict:?}");
    let (roots, _) = secular.roots().unwrap();
    assert_eq!(roots.len(), 10000);
    assert!(roots.iter().any(|nu| (nu.re - 1.57752638953639).abs() < 2e-12));
}

/// Overlapping bands: errors of residues next to coincident poles say little, the impacts' equations settle what leads.
#[test]
fn long_rings_with_overlapping_bands_are_not_undecided() {
    let (mut finder, mut found, mut analyser) = (Finder::new(21), OrbitList::default(), Analyser::default());
    let mut plain = Secular::default();
    let mut undecided = 0;
    for (sites, family, omega) in
        [(20_001, Family::SingleSided, 0.6), (100_001, Family::SingleSided, 0.31), (100_001, Family::DoubleSided, 0.45)]
    {
        finder.find_symmetric(&model(sites, 0.2, 0.1, omega, 0.4).unwrap(), family, &mut found).unwrap();
        let orbit = &found.orbits[0];
        let verdict = analyser.verdict(orbit, &mut finder, Tolerance::Rounding).unwrap();
        assert_eq!(verdict.method, Method::Secular);
        assert!(
            !verdict.undecided && verdict.resolution < 1e-2 * verdict.excess(),
            "{family:?} {sites} {omega}: {verdict:?}"
        );
        plain.replace(finder.prepared(orbit).unwrap()).unwrap();
        let bound = plain.verdict().unwrap();
        assert!(
            (bound.excess - verdict.excess()).abs() <= bound.excess_error,
            "{family:?} {omega}: {bound:?} {verdict:?}"
        );
        undecided += usize::from(bound.outcome == Standing::Undecided);
    }
    // By residues alone nothing could be said of the longest.
    assert_eq!(undecided, 2);
}
