//! What a cell of a damped ring's map costs, counted and not timed: what is alike is worked out once. And what a cell says where nothing is physical.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test stops at the first surprise")]

use std::path::Path;

use vibrochain_breather::{ContactMotion, Proof};
use vibrochain_lattice::Stop;
use vibrochain_maps::absence::{AT_ONCE, Absence};
use vibrochain_maps::grid::Grid;
use vibrochain_maps::structure::{StructureClass, StructureScene};

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
            let found = model.orbits(&"0+,0-".parse().unwrap(), 1).unwrap();
            let Some(Proof::Enclosures { intervals: own }) = found.completeness.proof() else {
                panic!("{:?}", found.completeness);
            };
            intervals += own;
            cells += 1;
        }
    }
    assert!(cells == 12 && intervals < 60 * cells, "{intervals} of {cells}");
}

/// A heavy mass with a light tip, which rings after each impact: a cell without a physical orbit says which contact is in the way and how soon after
/// an impact, and the motion is beyond the barrier there.
#[test]
fn cells_say_why_nothing_is_physical() {
    let text = "omega = 1\n[structure]\nmasses = [1, 0.02]\nstiffness = [[9, -8], [-8, 8]]\ndamping = [[0.05, 0], [0, 0.001]]\n\
                [[contact]]\nat = 1\nupper = 0.3\nrestitution = 0.7\n[[contact]]\nat = 0\nlower = -0.6\n[force]\nload = [0.2, 0]\n\
                [sweep]\nx = { parameter = \"omega\", from = 0.3, to = 3, points = 40 }\n\
                y = { parameter = \"load\", from = 0.2, to = 4, points = 6 }\n[compute]\nfamilies = [\"0+\"]\n";
    let scene = StructureScene::of_text(text, Path::new(".")).unwrap();
    let stop = Stop::default();
    let (mut worker, mut cells) = (scene.worker(&stop), Vec::new());
    scene.compute(&mut worker, 0..240, &stop, &mut cells).unwrap();
    let mut counts = [0; Absence::ALL.len()];
    for (number, cell) in (0..).zip(&cells) {
        assert_eq!(cell.found.absence.is_some(), cell.class == StructureClass::None, "{cell:?}");
        let Some(absence) = cell.found.absence else { continue };
        counts[absence as usize] += 1;
        let model = scene.worker(&stop).model(&scene, number).unwrap();
        let found = model.orbits(&"0+".parse().unwrap(), 1).unwrap();
        let pushing = |orbit: &&vibrochain_breather::Orbit| orbit.impacts()[0].impulse < 0.0;
        let candidates: Vec<_> = found.orbits.iter().filter(pushing).collect();
        let Some(first) = cell.found.obstruction else {
            assert!(absence == Absence::NoOrbit && candidates.is_empty(), "{cell:?}");
            continue;
        };
        let within = |orbit: &&&vibrochain_breather::Orbit| {
            let motion = ContactMotion::new(orbit.contacts().unwrap()).unwrap();
            let stops = model.structure().contacts()[first.contact as usize];
            let room = |part: f64| {
                stops.room(motion.contact(first.contact as usize, first.impact as usize, part * orbit.period())[0])
            };
            match absence {
                Absence::NoOrbit | Absence::NotFound | Absence::Sticks => false,
                Absence::WrongSign => orbit.impacts()[0].velocity_before <= 0.0,
                // It is farthest out there, or touches.
                _ => room(first.after) <= 1e-9,
            }
        };
        assert!(candidates.iter().any(|orbit| within(&orbit)), "{cell:?}");
        assert_eq!(absence == Absence::CrossesAtOnce, first.after > 0.0 && first.after <= AT_ONCE);
    }
    let told = counts.iter().filter(|count| **count > 0).count();
    assert!(told >= 2 && counts[Absence::CrossesAtOnce as usize] > 10, "{counts:?}");
}
