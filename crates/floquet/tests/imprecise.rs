//! Next to coincident poles the residues know the leading multiplier of a conservative breather to few digits. The secular function as a
//! product of sums settles it then, of two impacts a period, as a dense matrix would.
#![allow(clippy::unwrap_used, reason = "a test stops at the first surprise")]

use vibrochain_breather::{Family, Finder, OrbitList};
use vibrochain_floquet::{Analyser, Method, Secular, Standing, Tolerance};
use vibrochain_lattice::{Chain, Model};
use vibrochain_testkit::Random;

#[test]
fn what_poles_hide_the_equations_settle() {
    let mut random = Random(41);
    let (mut finder, mut found, mut secular) = (Finder::new(1), OrbitList::default(), Secular::default());
    let (mut analyser, mut dense) = (Analyser::default(), Analyser::dense());
    // Leading multipliers that were imprecise, and those of few modes.
    let (mut settled, mut few) = (0, 0);
    for _ in 0..20_000 {
        let chain = Chain::new(random.of(&[9, 20, 36, 41, 60]), 0.2, random.between(0.0, 0.3)).unwrap();
        let model = Model::conservative(chain, random.between(0.4, 2.0), 0.4).unwrap();
        if finder.find_symmetric(&model, Family::DoubleSided, &mut found).is_err() {
            continue;
        }
        for orbit in found.orbits.iter().filter(|orbit| orbit.impacts().iter().all(|hit| hit.is_right_signed())) {
            let imprecise = secular.replace(finder.prepared(orbit).unwrap()).is_ok_and(|()| {
                secular.verdict().is_ok_and(|verdict| {
                    verdict.outcome == Standing::Unstable && verdict.excess_error > 1e-9 * (2.0 + verdict.excess)
                })
            });
            if !imprecise {
                continue;
            }
            let told = analyser.verdict(orbit, &mut finder, Tolerance::Rounding).unwrap();
            if told.method == Method::Dense {
                continue;
            }
            let expected = dense.verdict(orbit, &mut finder, Tolerance::Rounding).unwrap();
            let radius = expected.spectral_radius;
            let most = 4.0 * (told.resolution + expected.resolution) + 1e-13 * radius;
            assert!((told.spectral_radius - radius).abs() < most, "{model}: {told:?} {expected:?}");
            assert_eq!(told.mechanism.is_some(), expected.mechanism.is_some(), "{model}");
            settled += 1;
            few += usize::from(chain.even_modes() < 12);
        }
    }
    assert!(settled > 100 && few > 20, "{settled} {few}");
}
