//! Impacts that take all velocity: one multiplier is 0, and all others are told beside it.
#![allow(clippy::unwrap_used, reason = "a test stops at the first surprise")]

use std::sync::Arc;

use nalgebra::{Complex as C, DMatrix, DVector};
use vibrochain_breather::LoadedStructure;
use vibrochain_floquet::{Tolerance, stability};
use vibrochain_lattice::{Contact, Structure};
use vibrochain_testkit::Random;

const WORDS: [&str; 8] = ["0+", "1-", "0+,0-", "0+,1+", "1+,1-", "0-,0-", "0+,0-,1+", "0+,0+,1-"];

fn draw(random: &mut Random) -> (Structure, f64, &'static str) {
    let n = 2 + random.below(7);
    let root = DMatrix::from_fn(n, n, |_, _| random.between(-1.0, 1.0));
    let stiffness = &root * root.transpose() + DMatrix::identity(n, n) * random.between(0.3, 1.5);
    let losses = match random.below(10) {
        0 | 1 => 0.0,
        2 => random.between(0.1, 2.0),
        _ => random.log(1e-3, 1e-1),
    };
    let damping = &stiffness * losses;
    let mass = DMatrix::from_diagonal(&DVector::from_fn(n, |_, _| random.between(0.6, 1.4)));
    let mut load = DVector::from_fn(n, |_, _| C::from_polar(random.between(0.0, 1.0), random.between(-3.0, 3.0)));
    load[0] += C::new(0.5, 0.0);
    let mut contact = |at: usize| {
        let weights = DVector::from_fn(n, |i, _| if i == at { 1.0 } else { 0.0 });
        let [lower, upper] = [-1.0, 1.0].map(|side| Some(side * random.between(0.1, 0.8)));
        (weights, Contact { lower, upper, restitution: 0.0 })
    };
    let contacts = vec![contact(0), contact(n - 1)];
    let structure = Structure { mass, damping, stiffness, contacts, loads: vec![(1, load)], ..Structure::default() };
    (structure, random.between(0.4, 3.0), WORDS[random.below(WORDS.len())])
}

#[test]
fn one_multiplier_is_zero_and_none_is_in_doubt() {
    let mut random = Random(91);
    let (mut orbits, mut several) = (0, 0);
    for number in 0..1200 {
        let (structure, omega, word) = draw(&mut random);
        let model = LoadedStructure::new(Arc::new(structure.modal().unwrap()), omega).unwrap();
        let Ok(found) = model.orbits(&word.parse().unwrap(), 1) else { continue };
        for orbit in found.orbits.iter().take(3) {
            let told = stability(orbit, Tolerance::Rounding);
            let told = told.unwrap_or_else(|error| panic!("{number} {word}: {error}"));
            let mut sizes: Vec<f64> = told.multipliers.iter().map(|multiplier| multiplier.norm()).collect();
            sizes.sort_by(f64::total_cmp);
            assert!(sizes[0] < 1e-12 && sizes.len() == 2 * structure.mass.nrows(), "{number} {word}: {sizes:?}");
            several += usize::from(sizes[1] < 1e-6);
            orbits += 1;
        }
    }
    assert!(orbits > 800 && several < orbits / 20, "{orbits} {several}");
}
