//! Closed forms against the search for orbits and the check of each.

use std::sync::Arc;

use vibrochain_lattice::{Chain, Contact, DampedChain, Ends, LinearMode, ModalStructure, ModeShape, Model, RowEnds};
use vibrochain_testkit::Random;

use super::*;
use crate::admissible::answer::Admissibility;
use crate::structures::orbit::ContactOrbit;

/// Some modes of a structure of up to three contacts, with and without a static load, or a ring with a contact at each mass, or a row.
fn structure(random: &mut Random) -> ModalStructure {
    let stops = |random: &mut Random| {
        let (lower, upper) = (-random.log(0.05, 2.0), random.log(0.05, 2.0));
        let sides = [(Some(lower), Some(upper)), (Some(lower), None), (None, Some(upper))];
        let (lower, upper) = sides[[0, 0, 0, 1, 2][random.below(5)]];
        Contact { lower, upper, restitution: 1.0 }
    };
    if random.below(3) == 0 {
        // A ring or a row of which all springs are known.
        let count = 1 + random.below(12);
        let a = random.between(0.0, 0.9);
        let stop = Contact { lower: Some(a - 1.0), upper: Some(a + 1.0), restitution: 1.0 };
        let contacts = (0..count).map(|n| (vec![(n, 1.0)], stop)).collect();
        let ends = [RowEnds::Alike(Ends::Closed), RowEnds::FixedFree][random.below(2)];
        let (gamma1, gamma2) = (0.2, random.between(0.0, 0.3));
        return DampedChain { gamma1, gamma2, contacts, ..DampedChain::new(count, ends) }.modal().unwrap();
    }
    if random.below(3) == 0 {
        let sites = [1, 2, 3, 5, 8, 11, 21][random.below(7)];
        let chain = Chain::new(sites, 0.2, random.between(0.0, 0.3)).unwrap();
        let model = Model::conservative(chain, 1.0, random.between(0.0, 0.9)).unwrap();
        let sites: Vec<Vec<usize>> = (0..sites).map(|site| vec![site]).collect();
        return model.felt_structure(&sites).unwrap();
    }
    let contacts: Vec<Contact> = (0..1 + random.below(3)).map(|_| stops(random)).collect();
    let still = if random.below(2) == 0 { 0.0 } else { 0.05 };
    let mut mode = || {
        let shape = ModeShape {
            contacts: contacts.iter().map(|_| random.between(-1.0, 1.0)).collect(),
            coordinates: Vec::new(),
            still: still * random.between(-1.0, 1.0),
        };
        LinearMode::oscillator(0.0, random.log(0.1, 20.0), &shape, &[])
    };
    let modes = (0..7).map(|_| mode()).collect();
    ModalStructure::new(contacts, Vec::new(), modes).unwrap()
}

/// What a map takes from closed forms is what it would take from orbits: the same one is physical, with the same impulses, ratio and margin, and
/// where none is the list is complete and has none.
#[test]
fn closed_forms_say_what_orbits_say() {
    let mut random = Random(41);
    let mut finder = Finder::default();
    let (mut seen, mut crossing, mut alike, mut aside) = ([[0; 3]; 2], 0, 0, 0);
    for _ in 0..1500 {
        let model = LoadedStructure::new(Arc::new(structure(&mut random)), random.log(0.2, 4.0)).unwrap();
        for (two, word) in ["0-", "0+,0-"].into_iter().enumerate() {
            let word = word.parse().unwrap();
            let searched = finder.map_orbit(&model, &word, 1);
            if matches!(searched, MapSearch::Open) {
                seen[two][2] += 1;
                continue;
            }
            let list = model.candidates(&word, 1).unwrap();
            assert!(list.completeness.is_established(), "{:?}", list.completeness);
            let margin = |orbit: &ContactOrbit| orbit.first_obstruction().unwrap();
            let physical: Vec<_> = list.contacts().filter(|orbit| margin(orbit).is_physical()).collect();
            let MapSearch::One(found) = searched else {
                assert!(physical.is_empty(), "{word} {physical:?}");
                seen[two][0] += 1;
                continue;
            };
            if let Some(obstruction) = found.obstruction() {
                assert!(physical.is_empty(), "{word} {physical:?}");
                let Admissibility { obstruction: told, .. } = margin(list.contacts().next().unwrap());
                let Some(Obstruction::Crossing { site, barrier, time, excess }) = told else { panic!("{told:?}") };
                let phi = found.times().last().unwrap_or_default() / found.period();
                // The search refines the time of an impact that is not half a period later.
                let is_aside = phi > 0.0 && phi < 0.499;
                let close = if is_aside { 1e-9 } else { 1e-12 };
                aside += usize::from(is_aside);
                assert!((phi - list.orbits[0].impacts().last().unwrap().time / found.period()).abs() < close, "{phi}");
                let Obstruction::Crossing { site: own, barrier: own_barrier, time: own_time, excess: own_excess } =
                    obstruction
                else {
                    panic!("{obstruction:?}")
                };
                assert!((excess - own_excess).abs() < close * (1.0 + excess.abs()), "{word} {obstruction:?} {told:?}");
                // Of places that only rounding tells apart, as symmetry has them, either may be told.
                let same = (site, barrier) == (own, own_barrier);
                let together = crate::orbit::time_between(time, own_time, found.period()) < 1e-6 * found.period();
                alike += usize::from(same && together);
                crossing += 1;
                continue;
            }
            seen[two][1] += 1;
            let [orbit] = physical[..] else { panic!("{word} {}", physical.len()) };
            let [own, told] = [found.reversible(), orbit.reversible()].map(Option::unwrap);
            let strongest = orbit.impulses().into_iter().fold(0.0, |most: f64, impulse| most.max(impulse.abs()));
            for (one, other) in found.impulses().iter().zip(orbit.impulses()) {
                assert!((one - other).abs() < 1e-12 * strongest, "{one} {other}");
            }
            assert_eq!((own.modes, own.period, own.ratio.is_some()), (told.modes, told.period, told.ratio.is_some()));
            if let (Some((one, error)), Some((other, by_orbit))) = (own.ratio, told.ratio) {
                assert!(
                    (one - other).abs() <= error * one.abs() && error < 1e3 * by_orbit,
                    "{one} {other} {error:e} {by_orbit:e}"
                );
            }
            let size =
                model.structure().contacts().iter().flat_map(|c| [c.lower, c.upper]).flatten().fold(1.0, f64::max);
            match (found.margin(), margin(orbit).margin) {
                (Some(one), Some(other)) => assert!((one - other).abs() < 1e-12 * size, "{word} {one} {other}"),
                (one, other) => assert_eq!(one, other, "{word}"),
            }
        }
    }
    assert!(seen.as_flattened().iter().all(|&count| count > 30), "{seen:?}");
    assert!(crossing > 300 && alike > crossing * 49 / 50, "{alike} {crossing}");
    assert!(aside > 30, "{aside}");
}

/// Losses, loads, several contacts, several instants and doubled words are left to the search.
#[test]
fn what_is_no_closed_form_is_left_open() {
    let shape = ModeShape { contacts: vec![1.0, 0.5], coordinates: Vec::new(), still: 0.0 };
    let stop = Contact { lower: Some(-1.0), upper: Some(0.7), restitution: 1.0 };
    let model = |decay: f64, square: f64, restitution: f64| {
        let mode = LinearMode::oscillator(decay, square, &shape, &[]);
        let contacts = vec![Contact { restitution, ..stop }, stop];
        let structure = ModalStructure::new(contacts, Vec::new(), vec![mode]).unwrap();
        LoadedStructure::new(Arc::new(structure), 1.5).unwrap()
    };
    let found = |model: &LoadedStructure, word: &str, periods: u32| {
        Finder::default().map_orbit(model, &word.parse().unwrap(), periods)
    };
    let plain = model(0.0, 1.0, 1.0);
    assert!(matches!(found(&plain, "0+,0-", 1), MapSearch::One(_)));
    for word in ["0+,1-", "0+,0+", "0+,0-,0+", "0+1+", "5+"] {
        assert!(matches!(found(&plain, word, 1), MapSearch::Open), "{word}");
    }
    assert!(matches!(found(&plain, "0+,0-", 2), MapSearch::Open));
    // Damped, held by nothing, and inelastic.
    for (decay, square, restitution) in [(0.1, 1.0, 1.0), (0.0, 0.0, 1.0), (0.0, 1.0, 0.9)] {
        assert!(matches!(found(&model(decay, square, restitution), "0+,0-", 1), MapSearch::Open));
    }
}
