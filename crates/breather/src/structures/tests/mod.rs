//! Promises of structures' orbits and of the bounds that prove them: on random structures, against samples, differences and closed forms.

mod bounds;
mod enclosures;
mod jacobian;
mod lists;

use std::sync::Arc;

use vibrochain_lattice::{Complex, Contact, LinearMode, ModalStructure, ModeShape};
use vibrochain_testkit::Random;

use super::model::LoadedStructure;
use super::orbit::ContactOrbit;
use crate::roots::patch::Patch;

/// A mode of real shape below, at or above critical damping, as two contacts see it.
fn mode(random: &mut Random, frequency: f64, ratio: f64) -> LinearMode {
    let contacts = vec![random.between(-1.0, 1.0), random.between(-1.0, 1.0)];
    let shape = ModeShape { contacts, coordinates: Vec::new(), still: random.between(-0.1, 0.1) };
    let load = Complex::new(random.between(-1.0, 1.0), random.between(-1.0, 1.0));
    LinearMode::oscillator(ratio * frequency, frequency * frequency * (1.0 - ratio * ratio), &shape, &[load])
}

/// Two poles λ, μ of one complex shape, φ and iφ: so much of each that an impulse moves no contact at once, 2 Re(φφᵀ + (iφ)(iφ)ᵀ) = 0, and gives it a
/// velocity, 2 Re (λ−μ)φφᵀ > 0.
fn poles(random: &mut Random) -> [LinearMode; 2] {
    let mut pole = || Complex::new(-random.log(1e-3, 0.5), random.log(0.4, 5.0));
    let rates = [pole(), pole()];
    let turn = Complex::from_polar(1.0, -0.5 * (rates[0] - rates[1]).arg());
    let number = |random: &mut Random| turn * random.between(-0.5, 0.5);
    let contacts = [number(random), number(random)];
    let load = [random.between(-0.5, 0.5), random.between(-0.5, 0.5)];
    [(0, Complex::new(1.0, 0.0)), (1, Complex::new(0.0, 1.0))].map(|(k, by)| {
        let contacts = contacts.map(|shape| shape * by).to_vec();
        let shape = ModeShape { contacts, coordinates: Vec::new(), still: turn * by * 0.1 };
        let loads = [[Complex::new((turn * by).re, 0.0) * load[0], Complex::new((turn * by).im, 0.0) * load[1]]];
        LinearMode::pole(rates[k], &shape, &loads)
    })
}

/// A few modes of all kinds under a load of one harmonic, with a stop above one contact and two about the other; at a frequency.
pub(in crate::structures) fn model(random: &mut Random) -> LoadedStructure {
    let count = 1 + random.below(5);
    let ratios = [random.log(1e-3, 0.9), random.log(1e-3, 0.9), 1.0, 1.5];
    let mut modes: Vec<LinearMode> = (0..count)
        .map(|_| {
            let (frequency, ratio) = (random.log(0.3, 5.0), ratios[random.below(4)]);
            mode(random, frequency, ratio)
        })
        .collect();
    if random.chance(0.4) {
        modes.extend(poles(random));
    }
    let contacts = vec![
        Contact { lower: None, upper: Some(random.between(0.0, 0.5)), restitution: random.between(0.3, 1.0) },
        Contact { lower: Some(-random.log(0.1, 1.0)), upper: Some(random.log(0.1, 1.0)), restitution: 0.8 },
    ];
    let structure = ModalStructure::new(contacts, vec![1], modes).unwrap();
    LoadedStructure::new(Arc::new(structure), random.between(0.5, 3.0)).unwrap()
}

/// The same with one more mode next to a resonance, its frequency off by so much, with hardly a dashpot.
pub(in crate::structures) fn next_to_a_resonance(random: &mut Random, off: f64) -> LoadedStructure {
    let model = model(random);
    let (structure, harmonic) = (model.structure(), random.below(3) + 1);
    let mut modes = structure.modes().to_vec();
    let ratio = random.log(1e-3, 1e-1) * off.abs();
    modes.push(mode(random, model.omega() * harmonic as f64 * (1.0 + off), ratio));
    let structure = ModalStructure::new(structure.contacts().to_vec(), vec![1], modes).unwrap();
    LoadedStructure::new(Arc::new(structure), model.omega()).unwrap()
}

/// Whether a number of a table of enclosures, and its slopes, are at a point so far off what is told of the rectangle; how much of that it takes.
pub(in crate::structures) fn strays(own: &Patch, at: &Patch, off: [f64; 2]) -> f64 {
    let linear = own.value() + own.slope()[0] * off[0] + own.slope()[1] * off[1];
    let away = (at.value() - linear).abs();
    assert!(away <= own.rest() + at.rounding, "{away:e} {own:?} {at:?}");
    for axis in 0..2 {
        let turned = (at.slope()[axis] - own.slope()[axis]).abs();
        let rounding = 1e-12 * (own.slope()[axis].abs() + own.swing()[axis]);
        assert!(turned <= own.swing()[axis] + rounding, "{axis} {turned:e} {own:?} {at:?}");
    }
    away / own.rest()
}

/// Orbits of one impact and of two of random structures, so many structures long.
fn orbits(random: &mut Random, structures: usize, mut visit: impl FnMut(&ContactOrbit, &mut Random)) {
    for _ in 0..structures {
        let model = model(random);
        let word = random.of(&["0+", "0+,0+", "1-,1+", "0+,1-"]).parse().unwrap();
        let Ok(found) = model.orbits(&word, 1) else { continue };
        found.contacts().for_each(|orbit| visit(orbit, random));
    }
}
