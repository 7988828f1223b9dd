//! What a map looks at against the full lists: no physical orbit may be missing, and few others be left.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test stops at the first surprise")]

use vibrochain_breather::{Family, Finder, Orbit, OrbitList, Proof, Scope};
use vibrochain_lattice::{Model, Parameter};
use vibrochain_testkit::Values::{Either, Even, Is};
use vibrochain_testkit::{Random, Ranges};

/// A ring without force, slow enough for harmonics to meet the band.
fn random_model(random: &mut Random) -> Model {
    let sites = random.of(&[[13, 79], [1, 12], [1, 12], [1, 12]]);
    let model = random.model(&Ranges {
        sites,
        gamma1: Either(0.08, &Is(0.0), &Even(0.0, 0.6)),
        gamma2: Even(0.001, 0.3),
        asymmetry: Either(0.4, &Is(0.0), &Even(0.0, 0.9)),
        ..Ranges::CONSERVATIVE
    });
    let top = (model.chain().gamma1() + 4.0 * model.chain().gamma2()).sqrt();
    model.with(Parameter::Omega, random.between(0.2, 1.2) * top).unwrap()
}

/// The impacts' times and impulses.
fn impacts(orbit: &Orbit) -> Vec<(f64, f64)> {
    orbit.impacts().iter().map(|impact| (impact.time, impact.impulse)).collect()
}

#[test]
fn no_physical_conservative_orbit_is_missed() {
    let mut random = Random(13);
    let (mut finder, mut found) = (Finder::new(6), OrbitList::default());
    let (mut listed, mut looked_at, mut physical, mut asymmetric) = (0, 0, 0, 0);
    for _ in 0..6000 {
        let model = random_model(&mut random);
        for family in [Family::DoubleSided, Family::SingleSided] {
            let mut orbits = |wanted: Scope, count: &mut usize| {
                if finder.search(&model, family, wanted, &mut found).is_err() {
                    return Vec::new();
                }
                *count += found.orbits.len();
                let mut orbits = found.orbits.clone();
                orbits.retain(|orbit| finder.admissibility(orbit).unwrap().is_physical());
                orbits.sort_by(|a, b| a.phi().unwrap_or(0.0).total_cmp(&b.phi().unwrap_or(0.0)));
                orbits
            };
            let all = orbits(Scope::All, &mut listed);
            let candidates = orbits(Scope::Candidates, &mut looked_at);
            assert_eq!(all.len(), candidates.len(), "{model:?} {family:?}");
            for (one, other) in all.iter().zip(&candidates) {
                for ((time, impulse), (its_time, its_impulse)) in impacts(one).into_iter().zip(impacts(other)) {
                    assert!((time - its_time).abs() < 1e-9 * model.period(), "{model:?}");
                    assert!((impulse - its_impulse).abs() < 1e-7 * impulse.abs(), "{model:?}");
                }
            }
            physical += all.len();
            asymmetric += all.iter().filter(|orbit| orbit.phi().is_some_and(|phi| phi != 0.5 * model.period())).count();
        }
    }
    assert!(physical > 1000 && asymmetric > 100, "{physical} {asymmetric}");
    // The bounds are worth their while: most of what is listed is not looked at.
    assert!(looked_at - physical < (listed - physical) / 8, "{listed} {looked_at} {physical}");
}

/// A ring under a force, with or without losses and asymmetry, soft, stiff, slow and fast.
fn random_forced_model(random: &mut Random) -> Model {
    let sites = random.of(&[[13, 79], [1, 12], [1, 12], [1, 30]]);
    random.model(&Ranges {
        sites,
        gamma1: Either(0.08, &Is(0.0), &Even(0.0, 0.6)),
        gamma2: Either(0.05, &Even(1e-9, 1e-6), &Even(0.001, 0.3)),
        omega: Even(0.25, 3.0),
        asymmetry: Either(0.2, &Is(0.0), &Even(0.0, 0.9)),
        amplitude: Either(0.3, &Even(0.3, 1.5), &Even(0.002, 0.3)),
        restitution: Either(0.2, &Is(1.0), &Even(0.2, 0.999)),
    })
}

#[test]
fn no_physical_forced_orbit_is_missed() {
    let mut random = Random(19);
    let (mut finder, mut found) = (Finder::new(6), OrbitList::default());
    let (mut right_signed, mut physical, mut fewer) = (0, 0, 0);
    for _ in 0..3000 {
        let model = random_forced_model(&mut random);
        let mut orbits = |wanted: Scope| {
            if finder.search(&model, Family::DoubleSided, wanted, &mut found).is_err() {
                return None;
            }
            let mut orbits = found.orbits.clone();
            orbits.retain(|orbit| orbit.impacts().iter().all(vibrochain_breather::Impact::is_right_signed));
            physical += orbits.iter().filter(|orbit| finder.admissibility(orbit).unwrap().is_physical()).count();
            let intervals = match found.completeness.proof() {
                Some(Proof::Enclosures { intervals }) => intervals,
                _ => 0,
            };
            Some((orbits, found.completeness.open() == (0, 0), intervals))
        };
        let (Some((all, all_told, full)), Some((candidates, told, part))) =
            (orbits(Scope::All), orbits(Scope::Candidates))
        else {
            continue;
        };
        // What is left open may be listed or not.
        if !(all_told && told) {
            continue;
        }
        assert_eq!(all.len(), candidates.len(), "{model:?}");
        for (one, other) in all.iter().zip(&candidates) {
            for ((time, impulse), (its_time, its_impulse)) in impacts(one).into_iter().zip(impacts(other)) {
                assert!((time - its_time).abs() < 1e-9 * model.period(), "{model:?}");
                assert!((impulse - its_impulse).abs() < 1e-7 * impulse.abs(), "{model:?}");
            }
        }
        right_signed += all.len();
        fewer += usize::from(full > 3 * part);
    }
    // Both lists are looked at, and the grid is worth its while.
    assert!(right_signed > 500 && physical > 400 && fewer > 800, "{right_signed} {physical} {fewer}");
}
