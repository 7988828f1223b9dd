use std::sync::Arc;

use nalgebra::{DMatrix, DVector};
use vibrochain_breather::{Family, Finder, LoadedStructure, Orbit, breathers};
use vibrochain_lattice::{Chain, Contact, LinearMode, ModalStructure, ModeShape, Model, Structure};
use vibrochain_testkit::{Random, stiffness};

use super::*;
use crate::verdict::Method;

/// Stops on both sides of one contact.
fn stops(random: &mut Random) -> Contact {
    Contact { lower: Some(-random.log(0.3, 3.0)), upper: Some(random.log(0.3, 3.0)), restitution: 1.0 }
}

/// Positive matrices of any shape, and a contact that sees all coordinates.
fn dense(random: &mut Random) -> ModalStructure {
    let n = 1 + random.below(7);
    let mut positive = |least: f64| {
        let root = DMatrix::from_fn(n, n, |_, _| random.between(-1.0, 1.0));
        &root * root.transpose() + DMatrix::identity(n, n) * least
    };
    let (mass, stiffness) = (positive(0.5), positive(0.05));
    let weights = DVector::from_fn(n, |_, _| random.between(-1.0, 1.0));
    let contacts = vec![(weights, stops(random))];
    Structure { mass, stiffness, contacts, ..Structure::default() }.modal().unwrap()
}

/// Frequencies and shapes, some of them nearly equal, hardly seen, or of a motion that nothing holds.
fn given(random: &mut Random) -> ModalStructure {
    let count = 1 + random.below(12);
    let mut frequency = 0.0;
    let mut mode = |k: usize| {
        let close = k > 0 && random.chance(0.1);
        frequency = if close { frequency * (1.0 + random.log(1e-9, 1e-4)) } else { random.log(0.2, 4.0) };
        let square = if random.chance(0.03) { 0.0 } else { frequency * frequency };
        let shape = random.of(&[1.0, 1.0, 1.0, 1e-4]) * random.between(-1.0, 1.0);
        let shape = ModeShape { contacts: vec![shape], coordinates: Vec::new(), still: 0.0 };
        LinearMode::oscillator(0.0, square, &shape, &[])
    };
    let modes = (0..count).map(&mut mode).collect();
    ModalStructure::new(vec![stops(random)], Vec::new(), modes).unwrap()
}

/// Unequal masses in a row, held nowhere or at both ends.
fn row(random: &mut Random) -> ModalStructure {
    let (n, held) = (2 + random.below(12), random.chance(0.5));
    let mut stiffness = DMatrix::zeros(n, n);
    let ends = [(0, 0), (n - 1, n - 1)].into_iter().filter(|_| held);
    for (i, j) in (1..n).map(|i| (i - 1, i)).chain(ends) {
        let spring = random.log(0.1, 2.0);
        stiffness[(i, i)] += spring;
        if i != j {
            stiffness[(j, j)] += spring;
            stiffness[(i, j)] -= spring;
            stiffness[(j, i)] -= spring;
        }
    }
    let mass = DMatrix::from_diagonal(&DVector::from_fn(n, |_, _| random.log(0.3, 3.0)));
    let site = random.below(n);
    let weights = DVector::from_fn(n, |i, _| f64::from(u8::from(i == site)));
    let contacts = vec![(weights, stops(random))];
    Structure { mass, stiffness, contacts, ..Structure::default() }.modal().unwrap()
}

/// What the modes that one contact feels say is what J(z) says, with fewer errors allowed than both tell.
#[test]
fn modes_of_one_contact_say_what_the_equations_say() {
    let (mut random, mut analyser) = (Random(41), Analyser::default());
    // Of one instant and of two: answered, stable, unstable; left open.
    let (mut answers, mut stable, mut unstable, mut open) = ([0; 2], [0; 2], [0; 2], 0);
    let (mut rigid, mut leading, mut all, mut asked) = (0, [0; 3], 0, 0);
    for round in 0..1500 {
        let structure = Arc::new([dense, given, row][round % 3](&mut random));
        let model = LoadedStructure::new(structure, random.log(0.3, 3.0)).unwrap();
        for (instants, word) in ["0+", "0+,0-"].into_iter().enumerate() {
            let Ok(found) = model.orbits(&word.parse().unwrap(), 1) else { continue };
            for orbit in found.orbits.iter().filter_map(Orbit::contacts) {
                let Some(reversible) = orbit.reversible() else { continue };
                let Some(told) = analyser.structure_reversible(&reversible, Tolerance::Rounding) else {
                    open += 1;
                    continue;
                };
                assert_eq!(told.method, Method::Secular);
                answers[instants] += 1;
                if let Some((verdict, list)) = analyser.structure_multipliers(&reversible, Tolerance::Rounding)
                    && let Ok((_, mut right)) = BlochProblem::of(orbit).all_worked_out(Tolerance::Rounding)
                {
                    assert_eq!((verdict.stable, list.len()), (told.stable, right.len()), "{round} {word}");
                    for z in list {
                        let off = |w: &Complex<f64>| (w - z).norm();
                        let nearest =
                            (0..right.len()).min_by(|&i, &j| off(&right[i]).total_cmp(&off(&right[j]))).unwrap();
                        // Next to another pair both know less.
                        let apart = off(&right.swap_remove(nearest));
                        assert!(apart < 1e-8 * (1.0 + z.norm()), "{round} {word}: {z} {apart:e}");
                        all += usize::from(apart < 1e-11 * (1.0 + z.norm()));
                        asked += 1;
                    }
                }
                rigid += usize::from(reversible.modes.iter().any(|mode| mode.frequency == 0.0));
                let Ok(right) = BlochProblem::of(orbit).worked_out(Tolerance::Rounding, false) else {
                    continue;
                };
                let error = told.resolution + right.resolution + 1e-10 * (1.0 + told.spectral_radius);
                let apart = (told.spectral_radius - right.spectral_radius).abs();
                assert!(right.undecided || apart <= error, "{round} {word}: {told:?} {right:?}");
                if right.undecided {
                    continue;
                }
                assert_eq!((told.stable, told.mechanism), (right.stable, right.mechanism), "{round} {word} {right:?}");
                stable[instants] += usize::from(told.stable);
                unstable[instants] += usize::from(!told.stable);
                if !told.stable {
                    let way = if told.leading.im != 0.0 { 2 } else { usize::from(told.leading.re < 0.0) };
                    leading[way] += 1;
                    let off = [told.leading, told.leading.conj()].map(|z| (z - right.leading).norm());
                    assert!(off[0].min(off[1]) <= 1e-6 * (1.0 + right.spectral_radius), "{told:?} {right:?}");
                }
            }
        }
    }
    assert!(answers.iter().all(|count| *count > 700) && open * 20 < answers[0] + answers[1], "{answers:?} {open}");
    assert!(stable.iter().chain(&unstable).all(|count| *count > 100), "{stable:?} {unstable:?}");
    assert!(asked > 5_000 && 100 * (asked - all) < asked, "{all} of {asked}");
    assert!(rigid > 50 && leading.iter().all(|count| *count > 20), "{rigid} {leading:?}");
}

/// A chain's matrices have the verdicts of the chain, rigid ones, too.
#[test]
fn matrices_of_a_chain_have_its_verdicts() {
    let (mut random, mut analyser) = (Random(43), Analyser::default());
    let (mut stable, mut unstable, mut rigid) = (0, 0, 0);
    for _ in 0..250 {
        let sites = random.of(&[2, 3, 5, 8, 13]);
        let gamma1 = random.of(&[0.0, 0.2, 0.2]);
        let chain = Chain::new(sites, gamma1, random.log(1e-2, 1.0)).unwrap();
        let model = Model::conservative(chain, random.between(0.5, 3.0), random.between(0.0, 0.8)).unwrap();
        let a = model.asymmetry();
        let contact = Contact { lower: Some(a - 1.0), upper: Some(a + 1.0), restitution: 1.0 };
        let site = random.below(sites);
        let weights = DVector::from_fn(sites, |i, _| f64::from(u8::from(i == site)));
        let matrices = Structure {
            mass: DMatrix::identity(sites, sites),
            stiffness: stiffness(&chain),
            contacts: vec![(weights, contact)],
            ..Structure::default()
        };
        let structure = LoadedStructure::new(Arc::new(matrices.modal().unwrap()), model.omega()).unwrap();
        for (family, word) in [(Family::DoubleSided, "0+,0-"), (Family::SingleSided, "0-")] {
            let (Ok(own), Ok(found)) = (breathers(&model, family), structure.orbits(&word.parse().unwrap(), 1)) else {
                continue;
            };
            let mut finder = Finder::new(sites);
            for orbit in own.orbits.iter().filter(|orbit| orbit.is_reversible()) {
                let Some(other) = found.orbits.iter().find_map(|orbit| orbit.contacts()?.reversible()) else {
                    continue;
                };
                let right = analyser.verdict(orbit, &mut finder, Tolerance::Rounding).unwrap();
                let Some(told) = analyser.structure_reversible(&other, Tolerance::Rounding) else { continue };
                if right.undecided {
                    continue;
                }
                let error = 1e-9 * right.spectral_radius;
                assert!((told.spectral_radius - right.spectral_radius).abs() <= error, "{model:?} {told:?} {right:?}");
                assert_eq!(told.stable, right.stable, "{model:?}");
                *(if told.stable { &mut stable } else { &mut unstable }) += 1;
                rigid += usize::from(gamma1 == 0.0);
            }
        }
    }
    assert!(stable > 60 && unstable > 60 && rigid > 40, "{stable} {unstable} {rigid}");
}

/// The matrix of a period has the multipliers that J(z) has, but those of the shift in time, which it splits by the root of rounding.
#[test]
fn the_matrix_of_a_period_has_the_multipliers_of_the_equations() {
    let (mut random, mut checked, mut off) = (Random(43), 0, 0);
    for round in 0..300 {
        let structure = Arc::new([dense, row][round % 2](&mut random));
        let model = LoadedStructure::new(structure, random.log(0.3, 3.0)).unwrap();
        for word in ["0+", "0+,0-"] {
            let Ok(found) = model.orbits(&word.parse().unwrap(), 1) else { continue };
            for orbit in found.orbits.iter().filter_map(Orbit::contacts) {
                let Ok((_, expected)) = BlochProblem::of(orbit).all(Tolerance::Rounding) else { continue };
                let found = crate::events::by_matrix::multipliers(&orbit.bloch_equations().0, true).unwrap();
                assert_eq!(found.len(), expected.len());
                for mu in &expected {
                    let nearest = found.iter().map(|other| (other - mu).norm()).fold(f64::INFINITY, f64::min);
                    // Next to 1 it may be one of the two that are left out.
                    assert!(nearest <= 1e-6 * (1.0 + mu.norm()) || (mu - 1.0).norm() < 1e-3, "{mu} {nearest:e}");
                    off += usize::from((mu.norm() - 1.0).abs() > 1e-3);
                    checked += 1;
                }
            }
        }
    }
    assert!(checked > 1000 && off > 20, "{checked} {off}");
}
