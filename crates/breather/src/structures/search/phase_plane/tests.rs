//! Lists under loads of several harmonics against starts spread over times and phase, which know of no enclosure.

use std::sync::Arc;

use vibrochain_lattice::{Barrier, Contact, LinearMode, ModalStructure, ModeShape};
use vibrochain_testkit::Random;

use super::*;
use crate::structures::equations::Equations;
use crate::structures::model::LoadedStructure;
use crate::structures::orbit::ContactOrbit;
use crate::structures::tests::{next_to_a_resonance, strays};

/// Two contacts of a few modes under two or three harmonics, even ones among them; at times nothing holds it, and a static load pushes it.
fn model(random: &mut Random, harmonics: &[u32]) -> LoadedStructure {
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
    LoadedStructure::new(structure, random.between(0.5, 3.0)).unwrap()
}

#[test]
fn lists_under_several_harmonics_and_next_to_resonances_are_complete() {
    let mut random = Random(137);
    let (mut lists, mut complete, mut orbits, mut rigid, mut sought, mut resonant) = (0, 0, 0, 0, 0, 0);
    for round in 0..90 {
        let model = if round % 3 == 2 {
            // One load of a structure next to a resonance.
            let off = random.log(1e-8, 1e-3);
            next_to_a_resonance(&mut random, off)
        } else {
            model(&mut random, if round % 2 == 0 { &[1, 2] } else { &[1, 3, 4] })
        };
        for (word, periods) in [("0-", 1), ("0-,0+", 1), ("0-,0-", 2), ("0+,1-", 1), ("0+,1+", 1)] {
            let word: crate::word::Word = word.parse().unwrap();
            let Ok(found) = model.orbits(&word, periods) else { continue };
            (lists, orbits) = (lists + 1, orbits + found.orbits.len());
            if !found.completeness.is_established() {
                continue;
            }
            complete += 1;
            resonant += usize::from(round % 3 == 2);
            let letters: SmallVec<[(usize, Barrier); 4]> =
                word.letters().map(|letter| (letter.site, letter.barrier)).collect();
            let equations = Equations::new(&model, periods, letters.iter().map(|letter| letter.0)).unwrap();
            let impacts = Impacts { equations: &equations, letters };
            for start in impacts.starts().unwrap().0.into_iter().step_by(10) {
                let orbit = equations.solve(start.point);
                let Ok(orbit) = orbit.and_then(|point| ContactOrbit::new(&equations, periods, point)) else {
                    continue;
                };
                let apart = orbit.phi().map_or(orbit.period(), |phi| phi.min(orbit.period() - phi));
                if !orbit.has_its_instants()
                    || !orbit.has_impulses()
                    || orbit.repeats_sooner()
                    || apart < 1e-4 * orbit.period()
                {
                    continue;
                }
                let is_listed = found.contacts().any(|listed| listed.begun_at(&orbit).is_some());
                assert!(is_listed, "{round} {word} {:?}: {orbit:?}", found.completeness);
                (sought, rigid) = (sought + 1, rigid + usize::from(!equations.rigid.is_empty()));
            }
        }
    }
    let told = format!("{lists} {complete} {orbits} {rigid} {sought} {resonant}");
    assert!(resonant > 55, "{told}");
    assert!(lists > 280 && complete > 270 && orbits > 900 && rigid > 300 && sought > 2500, "{told}");
}

/// Upper and lower barriers of two contacts, one of which is hit twice every other time.
fn letters(round: usize) -> [(usize, Barrier); 2] {
    [(0, Barrier::Upper), [(1, Barrier::Lower), (0, Barrier::Upper)][round % 2]]
}

/// Numbers of W at points are within what is told of a rectangle about them, and so are their slopes, with the states of modes next to a resonance.
#[test]
fn numbers_of_open_modes_are_within_their_enclosures() {
    let mut random = Random(139);
    let (mut checked, mut useful) = (0, 0);
    for round in 0..40 {
        let off = random.log(1e-11, 1e-3);
        let model = next_to_a_resonance(&mut random, off);
        let letters = letters(round);
        let equations = Equations::new(&model, 1, letters.iter().map(|letter| letter.0)).unwrap();
        let opened = equations.opened_within(0.05, 2).unwrap();
        let impacts = Impacts { equations: &opened, letters: letters.into_iter().collect() };
        let Some(plane) = PhasePlane::new(&impacts, false, 1000) else { continue };
        for _ in 0..10 {
            let centre = [0.0; 2].map(|_: f64| plane.period * random.between(0.05, 0.9));
            let radius = centre.map(|at| at.min(plane.period - at) * random.log(1e-4, 0.9));
            let off = radius.map(|r| r * random.of(&[-1.0, 1.0, random.clone().between(-1.0, 1.0)]));
            let at = [centre[0] + off[0], centre[1] + off[1]];
            let whole = plane.filled(&plane.strip(centre[0], radius[0]), centre, radius);
            let point = plane.filled(&plane.strip(at[0], 0.0), at, [0.0; 2]);
            for (own, at) in whole.iter().flatten().zip(point.iter().flatten()) {
                let used = strays(own, at, off);
                if own.rest() > 1e-9 * own.bound() {
                    (checked, useful) = (checked + 1, useful + usize::from(used > 0.05));
                }
            }
        }
    }
    assert!(checked > 3000 && useful > checked / 4, "{checked} {useful}");
}

/// Not so near that the kernel is large, the zeros with the states of modes among the unknowns are those of the kernel.
#[test]
fn zeros_with_open_modes_are_those_of_the_kernel() {
    let mut random = Random(149);
    let (mut lists, mut zeros) = (0, 0);
    for round in 0..40 {
        let off = random.of(&[-1.0, 1.0]) * random.log(5e-4, 2e-3);
        let model = next_to_a_resonance(&mut random, off);
        let letters = letters(round);
        let equations = Equations::new(&model, 1, letters.iter().map(|letter| letter.0)).unwrap();
        let opened = equations.opened_within(0.05, 2).unwrap();
        let [closed, opened] = [&equations, &opened].map(|equations| {
            let impacts = Impacts { equations, letters: letters.into_iter().collect() };
            PhasePlane::new(&impacts, false, 100_000).map(|plane| plane.zeros())
        });
        let (Some(mut closed), Some(mut opened)) = (closed, opened) else { continue };
        if [&closed, &opened].iter().any(|zeros| zeros.exhausted + zeros.unresolved.len() > 0) {
            continue;
        }
        for zeros in [&mut closed, &mut opened] {
            zeros.simple.sort_by(|one, other| one[0].total_cmp(&other[0]).then(one[1].total_cmp(&other[1])));
        }
        assert_eq!(closed.simple.len(), opened.simple.len(), "{round} {closed:?} {opened:?}");
        for (one, other) in closed.simple.iter().zip(&opened.simple) {
            let apart = (one[0] - other[0]).abs().max((one[1] - other[1]).abs());
            assert!(apart < 1e-6 * model.period(), "{round} {one:?} {other:?}");
            zeros += 1;
        }
        lists += 1;
    }
    assert!(lists > 30 && zeros > 60, "{lists} {zeros}");
}
