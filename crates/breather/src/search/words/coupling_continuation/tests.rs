//! Branches of masses that hit together, from a weak coupling on: where they end, and that it takes few steps.

use std::f64::consts::TAU;

use vibrochain_lattice::{Chain, Point};

use super::*;
use crate::search::finder::{Finder, Scope};
use crate::search::orbit_list::OrbitList;

/// Where the branches of a word's orbits end that begin at a coupling of 1e-3, and the work that each took.
fn ends(model: &Model, word: &str) -> Vec<(Ended, u64)> {
    let weak = model.with(Parameter::Gamma2, 1e-3).unwrap();
    let (mut finder, mut found) = (Finder::new(model.chain().sites()), OrbitList::default());
    finder.find_word(&weak, &word.parse().unwrap(), Scope::All, &mut found).unwrap();
    let mut ends = Vec::new();
    for start in &found.orbits {
        let mut effort = Effort::until(&Stop::default());
        if let Err(ended) = follow(start, model, &mut effort).unwrap() {
            ends.push((ended, MOST_WORK - effort.left));
        }
    }
    ends
}

const OMEGA: f64 = 0.91;
const GAMMA1: f64 = 0.14;

/// Where K₀(0) + K₂(0) = 0 of two masses opposite each other on a ring of four, from the sum over all modes: by hand, with no code of the program's.
fn pole() -> f64 {
    let kernels = |gamma2: f64| -> f64 {
        let mode = |k: f64| {
            let frequency = (GAMMA1 + 4.0 * gamma2 * (TAU * k / 8.0).sin().powi(2)).sqrt();
            (1.0 + (TAU * 2.0 * k / 4.0).cos()) / (8.0 * frequency * (0.5 * TAU * frequency / OMEGA).tan())
        };
        (0..4).map(|k| mode(f64::from(k))).sum()
    };
    let (mut low, mut high) = (0.04, 0.06);
    assert!(kernels(low) > 0.0 && kernels(high) < 0.0);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if kernels(middle) > 0.0 { low = middle } else { high = middle }
    }
    0.5 * (low + high)
}

#[test]
fn where_impulses_grow_without_bound_a_branch_ends_and_says_so() {
    let ring = Point::ring(4).gamma1(GAMMA1).gamma2(0.08).omega(OMEGA);
    let model = ring.asymmetry(0.24).amplitude(0.75).restitution(1.0).model().unwrap();
    let ends = ends(&model, "0-2-");
    let unbounded: Vec<_> = ends.iter().filter(|(ended, _)| ended.by == End::Unbounded).collect();
    assert!(!unbounded.is_empty(), "{ends:?}");
    for (ended, work) in unbounded {
        assert_eq!(ended.coupling, Parameter::Gamma2);
        assert!((ended.value - pole()).abs() < 1e-9, "{ended} {}", pole());
        assert!(ended.to_string().starts_with("impulses that grow without bound at gamma2 = 0.04770926"), "{ended}");
        assert!(*work < MOST_WORK / 1000, "{work}");
    }
}

#[test]
fn other_words_at_elastic_impacts_end_as_well() {
    let mut unbounded = 0;
    for (word, sites) in [("1-3-", 5), ("0-2-", 5), ("0-1-", 4), ("0-2-4-", 6)] {
        for step in 0..12 {
            let part = f64::from(step) / 12.0;
            let chain = Chain::new(sites, 0.1 + 0.2 * part, 0.03 + 0.1 * (7.0 * part).fract()).unwrap();
            let point = chain.point().omega(0.8 + 0.5 * (5.0 * part).fract()).asymmetry(0.24).amplitude(0.75);
            for (ended, work) in ends(&point.model().unwrap(), word) {
                assert!(ended.by.is_known() && work < MOST_WORK / 100, "{word} {part}: {ended} {work}");
                unbounded += usize::from(ended.by == End::Unbounded);
            }
        }
    }
    assert!(unbounded > 3, "{unbounded}");
}

/// Steps crept towards it until the work for one search was spent, half a minute.
#[test]
fn a_branch_that_creeps_towards_a_resonance_ends_there() {
    let (gamma1, omega) = (0.3540207113381798, 0.5801805980077499);
    let point = Chain::new(9, gamma1, 0.32401137357515286).unwrap().point().omega(omega).asymmetry(0.30062071059642603);
    let model = point.amplitude(0.2377423835905643).restitution(0.9877188993670045).model().unwrap();
    let ends = ends(&model, "0+3+,0-3-");
    let told = ends.iter().find(|(ended, _)| matches!(ended.by, End::Resonance(_)));
    let (told, _) = told.unwrap_or_else(|| panic!("{ends:?}"));
    // At the coupling that is told, a harmonic of the force meets a mode: the frequencies of all modes in closed form.
    let at = |k: f64| (gamma1 + 4.0 * told.value * (0.5 * TAU * k / 9.0).sin().powi(2)).sqrt() / omega;
    assert!((0..=4).any(|k| (at(f64::from(k)) - at(f64::from(k)).round()).abs() < 1e-4), "{told}");
}
