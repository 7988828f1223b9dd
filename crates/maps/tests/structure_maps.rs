//! What a cell of a damped ring's map costs, counted and not timed: what is alike is worked out once.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test stops at the first surprise")]

use std::path::Path;

use vibrochain_breather::{StructureSearch, structure_orbits};
use vibrochain_maps::structure::StructureScene;

const SITES: usize = 21;

fn ring(gamma2: f64, omega: f64) -> StructureScene {
    let contact = |at: usize| format!("[[contact]]\nat = {at}\nlower = -0.6\nupper = 1.4\nrestitution = 0.9\n");
    let contacts: String = (0..SITES).map(contact).collect();
    let load = vec![0.1; SITES];
    let chain = format!("chain = {{ sites = {SITES}, gamma1 = 0.2, gamma2 = {gamma2}, damping = 0.01 }}");
    let text = format!("omega = {omega}\n[structure]\n{chain}\n{contacts}[force]\nload = {load:?}\n");
    StructureScene::of_text(&text, Path::new(".")).unwrap()
}

/// All modes die at one rate, to the last digit: their exponential is taken once. Masses that a mirror through the one that is hit exchanges do the
/// same.
#[test]
fn what_is_alike_is_one() {
    let model = ring(0.1, 1.5).model().unwrap();
    let structure = model.structure();
    assert_eq!(structure.modes().len(), SITES);
    for mode in structure.modes() {
        assert_eq!(mode.decay.to_bits(), structure.modes()[0].decay.to_bits());
        assert!((mode.decay - 0.005).abs() < 1e-15);
    }
    let felt = structure.participating_modes(&[0]);
    assert_eq!(felt.modes.len(), SITES / 2 + 1);
    for (mass, twin) in felt.twins.iter().enumerate() {
        assert_eq!(*twin, mass.min(SITES - mass) % SITES);
    }
    // No mirror leaves two masses where they are.
    let pair = structure.participating_modes(&[0, 5]).twins;
    assert!(pair.iter().enumerate().all(|(mass, twin)| mass == *twin), "{pair:?}");
}

/// Proving a list of two-impact orbits complete takes 40 intervals a cell, averaged over twelve cells: the number grows with the zeros
/// of F(φ) and with its oscillations.
#[test]
fn proofs_take_few_intervals() {
    let (mut intervals, mut cells) = (0, 0);
    for gamma2 in [0.02, 0.1, 0.25] {
        for omega in [1.0, 1.5, 2.0, 2.8] {
            let model = ring(gamma2, omega).model().unwrap();
            let found = structure_orbits(&model, &"0+,0-".parse().unwrap(), 1).unwrap();
            let StructureSearch::Enclosures { intervals: own, unresolved: 0 } = found.search else {
                panic!("{:?}", found.search);
            };
            intervals += own;
            cells += 1;
        }
    }
    assert!(cells == 12 && intervals < 60 * cells, "{intervals} of {cells}");
}
