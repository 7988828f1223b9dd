//! Enclosures of three impacts: at points of their rectangles, and around orbits.

use smallvec::smallvec;
use vibrochain_lattice::Barrier;
use vibrochain_testkit::Random;

use super::*;
use crate::structures::equations::Equations;
use crate::structures::tests::{model, next_to_a_resonance, strays};

/// The three letters of a word, above one contact, above the same or the other, below the other.
fn letters(round: usize) -> [(usize, Barrier); 3] {
    [(0, Barrier::Upper), (round % 2, Barrier::Upper), (1, Barrier::Lower)]
}

/// Numbers of W at points are within what is told of a rectangle about them, and so are their slopes; on small rectangles nothing much is left.
#[test]
fn numbers_of_the_equations_are_within_their_enclosures() {
    let mut random = Random(71);
    let (mut checked, mut useful, mut open) = (0, 0, 0);
    for round in 0..60 {
        let off = random.log(1e-11, 1e-4);
        let model = if round % 3 == 0 { next_to_a_resonance(&mut random, off) } else { model(&mut random) };
        let letters = letters(round);
        let equations = Equations::new(&model, 1, letters.iter().map(|letter| letter.0)).unwrap();
        let opened = equations.opened_within(1e-2, 1);
        open += usize::from(opened.is_some());
        let equations = opened.unwrap_or(equations);
        let impacts = Impacts { equations: &equations, letters: smallvec![letters[0], letters[1], letters[2]] };
        let Some(functions) = ThreeImpacts::new(&impacts, 1000) else { continue };
        let period = equations.period();
        let table = |at: [f64; 2], radius: [f64; 2]| functions.filled(&functions.strip(at[0], radius[0]), at, radius);
        for _ in 0..10 {
            let centre = [0.0; 2].map(|_: f64| period * random.between(0.05, 0.45));
            let radius = centre.map(|at| at * random.log(1e-4, 0.9));
            let whole = table(centre, radius);
            let off = radius.map(|r| r * random.of(&[-1.0, 1.0, random.clone().between(-1.0, 1.0)]));
            let point = table([centre[0] + off[0], centre[1] + off[1]], [0.0; 2]);
            for (own, at) in whole.iter().flatten().zip(point.iter().flatten()) {
                let used = strays(own, at, off);
                if own.rest() > 1e-9 * own.bound() {
                    checked += 1;
                    useful += usize::from(used > 0.05);
                }
            }
        }
    }
    assert!(checked > 4000 && useful > checked / 4 && open >= 20, "{checked} {useful} {open}");
}

/// No rectangle about the times of an orbit is said to hold none, however wide; and most narrow ones say that it is the only one.
#[test]
fn no_orbit_is_excluded() {
    let mut random = Random(73);
    let (mut orbits, mut enclosed, mut alone, mut elsewhere) = (0, 0, 0, 0);
    for round in 0..100 {
        let model = model(&mut random);
        let letters = letters(round);
        let word = if round % 2 == 0 { "0+,0+,1-" } else { "0+,1+,1-" };
        let Ok(found) = model.orbits(&word.parse().unwrap(), 1) else { continue };
        let equations = Equations::new(&model, 1, letters.iter().map(|letter| letter.0)).unwrap();
        let impacts = Impacts { equations: &equations, letters: smallvec![letters[0], letters[1], letters[2]] };
        let Some(functions) = ThreeImpacts::new(&impacts, 1000) else { continue };
        for orbit in &found.orbits {
            let (impacts, period) = (orbit.impacts(), orbit.period());
            let of = |i: usize| (impacts[i % 3].site, impacts[i % 3].barrier);
            let pushes = impacts.iter().all(|impact| impact.barrier.sign() * impact.impulse < 0.0);
            let first = (0..3).find(|first| (0..3).all(|i| of(first + i) == letters[i]));
            let Some(first) = first.filter(|_| pushes) else { continue };
            let time = |i: usize| impacts[(first + i) % 3].time - impacts[first].time;
            let [x, both] = [1, 2].map(|i| time(i).rem_euclid(period));
            let at = [x, both - x];
            orbits += 1;
            for _ in 0..40 {
                let radius = at.map(|at| at * random.log(1e-6, 1.0));
                let centre: [f64; 2] = std::array::from_fn(|i| at[i] + radius[i] * random.between(-0.95, 0.95));
                let enclose = |centre: [f64; 2]| {
                    functions.enclose(&functions.strip(centre[0], radius[0]), centre, radius, 0).unwrap()
                };
                let (patches, sound) = enclose(centre);
                enclosed += 1;
                alone += usize::from(sound);
                assert!(!patches.iter().any(Patch::excludes_zero), "{at:?} {centre:?} {radius:?} {patches:?}");
                let other: [f64; 2] = std::array::from_fn(|i| random.between(radius[i], 0.4 * period));
                elsewhere += usize::from(enclose(other).0.iter().any(Patch::excludes_zero));
            }
        }
    }
    assert!(orbits > 12 && alone > enclosed / 4 && elsewhere > enclosed / 4, "{orbits} {enclosed} {alone} {elsewhere}");
}

/// Not so near that the kernel is large, the zeros of impacts that push are with the state of a mode among the unknowns those of the kernel.
#[test]
fn zeros_with_an_open_mode_are_those_of_the_kernel() {
    let mut random = Random(79);
    let (mut lists, mut orbits) = (0, 0);
    for round in 0..40 {
        let off = random.of(&[-1.0, 1.0]) * random.log(3e-4, 2e-3);
        let model = next_to_a_resonance(&mut random, off);
        let letters = letters(round);
        let equations = Equations::new(&model, 1, letters.iter().map(|letter| letter.0)).unwrap();
        let opened = equations.opened_within(0.05, 1).unwrap();
        let found = [&equations, &opened].map(|equations| {
            let impacts = Impacts { equations, letters: letters.into_iter().collect() };
            let functions = ThreeImpacts::new(&impacts, 60_000)?;
            let zeros = functions.zeros();
            let pushes = |at: &[f64; 2]| {
                let numbers = functions.numbers(*at).unwrap();
                numbers.iter().zip(&functions.push).all(|(number, push)| number * push > 1e-9)
            };
            let pushing: Vec<[f64; 2]> = zeros.simple.iter().filter(|at| pushes(at)).copied().collect();
            (zeros.exhausted + zeros.unresolved.len() == 0).then_some(pushing)
        });
        let [Some(closed), Some(opened)] = found else { continue };
        assert_eq!(closed.len(), opened.len(), "{round} {closed:?} {opened:?}");
        for at in &closed {
            let near = |other: &&[f64; 2]| (0..2).all(|i| (at[i] - other[i]).abs() < 1e-7 * model.period());
            assert_eq!(opened.iter().filter(near).count(), 1, "{round} {at:?} {opened:?}");
            orbits += 1;
        }
        lists += 1;
    }
    assert!(lists > 10 && orbits > 3, "{lists} {orbits}");
}
