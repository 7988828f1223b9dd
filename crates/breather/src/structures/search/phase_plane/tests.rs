//! Lists under loads of several harmonics against starts spread over times and phase, which know of no enclosure.

use std::sync::Arc;

use vibrochain_lattice::{Barrier, Contact, LinearMode, ModalStructure, ModeShape};
use vibrochain_testkit::Random;

use super::*;
use crate::structures::equations::Equations;
use crate::structures::model::StructureModel;
use crate::structures::orbit::StructureOrbit;

/// Two contacts of a few modes under two or three harmonics, even ones among them; at times nothing holds it, and a static load pushes it.
fn model(random: &mut Random, harmonics: &[u32]) -> StructureModel {
    let rigid = random.chance(0.3);
    let modes = (0..1 + usize::from(rigid) + random.below(3)).map(|number| {
        let contacts = vec![random.between(0.2, 1.0), random.between(-1.0, 1.0)];
        let loads: Vec<C> =
            harmonics.iter().map(|_| C::new(random.between(-1.0, 1.0), random.between(-1.0, 1.0))).collect();
        let loose = rigid && number == 0;
        let still = if loose && random.chance(0.5) { random.between(0.1, 0.5) } else { 0.0 };
        let shape = ModeShape { contacts, coordinates: Vec::new(), still };
        let decay = if loose || random.chance(0.3) { 0.0 } else { random.log(1e-3, 0.5) };
        LinearMode::oscillator(decay, if loose { 0.0 } else { random.log(0.1, 9.0) }, &shape, &loads)
    });
    let modes = modes.collect();
    let stops = Contact {
        lower: Some(-random.log(0.1, 1.0)),
        upper: Some(random.log(0.1, 1.0)),
        restitution: random.between(0.4, 1.0),
    };
    let structure = Arc::new(ModalStructure::new(vec![stops; 2], harmonics.to_vec(), modes).unwrap());
    StructureModel::new(structure, random.between(0.5, 3.0)).unwrap()
}

#[test]
fn lists_under_several_harmonics_are_complete() {
    let mut random = Random(137);
    let (mut lists, mut complete, mut orbits, mut rigid, mut sought) = (0, 0, 0, 0, 0);
    for round in 0..60 {
        let model = model(&mut random, if round % 2 == 0 { &[1, 2] } else { &[1, 3, 4] });
        for (word, periods) in [("0-", 1), ("0-,0+", 1), ("0-,0-", 2), ("0+,1-", 1), ("0+,1+", 1)] {
            let word: crate::word::Word = word.parse().unwrap();
            let Ok(found) = model.orbits(&word, periods) else { continue };
            (lists, orbits) = (lists + 1, orbits + found.orbits.len());
            if !found.search.is_complete() {
                continue;
            }
            complete += 1;
            let letters: SmallVec<[(usize, Barrier); 4]> =
                word.letters().map(|letter| (letter.site, letter.barrier)).collect();
            let equations = Equations::new(&model, periods, letters.iter().map(|letter| letter.0)).unwrap();
            let impacts = Impacts { equations: &equations, letters };
            for start in impacts.starts().unwrap().0.into_iter().step_by(10) {
                let orbit = equations.solve(start.point);
                let Ok(orbit) = orbit.and_then(|point| StructureOrbit::new(&equations, periods, point)) else {
                    continue;
                };
                let apart = orbit.phi().map_or(orbit.period(), |phi| phi.min(orbit.period() - phi));
                if !orbit.has_its_instants() || !orbit.hits() || orbit.repeats_sooner() || apart < 1e-4 * orbit.period()
                {
                    continue;
                }
                let is_listed = found.orbits.iter().any(|listed| listed.begun_at(&orbit).is_some());
                assert!(is_listed, "{round} {word} {:?}: {orbit:?}", found.search);
                (sought, rigid) = (sought + 1, rigid + usize::from(!equations.rigid.is_empty()));
            }
        }
    }
    let told = format!("{lists} {complete} {orbits} {rigid} {sought}");
    assert!(lists > 280 && complete > 270 && orbits > 900 && rigid > 300 && sought > 2500, "{told}");
}
