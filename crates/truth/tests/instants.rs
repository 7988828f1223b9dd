//! Words of many instants without force, and words of several periods of the force, found from masses alone: against many digits, a
//! simulated return map and the limit itself.
#![allow(clippy::unwrap_used, reason = "a test stops at the first surprise")]

mod support;

use vibrochain_breather::{
    BreatherError, Completeness, Finder, Found, NoBreather, Orbit, Unsearched, Wanted, Word,
};
use vibrochain_floquet::full_monodromy;
use vibrochain_lattice::{Chain, Ends, Model, Parameter};
use vibrochain_testkit::{ReturnMap, dense};
use vibrochain_truth::{DEFAULT_BITS, TrueOrbit};

use support::assert_claims_hold;

/// An orbit's claims in many digits; of a physical one closure and monodromy by a simulation. Returns whether it is physical.
fn check(orbit: &Orbit, finder: &mut Finder) -> bool {
    assert!(orbit.residual() < 1e-13, "{:e} {orbit:?}", orbit.residual());
    let truth = TrueOrbit::refine(orbit, DEFAULT_BITS).unwrap();
    assert_claims_hold(orbit, &finder.condition(orbit).unwrap(), &truth);
    if !finder.admissibility(orbit).unwrap().is_physical() {
        return false;
    }
    let map = ReturnMap::new(orbit);
    let point = map.fixed_point();
    let mut state = point.clone();
    for _ in 0..10 {
        state = map.apply(&state);
        // Where it is unstable rounding grows.
        if (&state - &point).amax() > 1e-10 {
            break;
        }
    }
    assert!((map.apply(&point) - &point).amax() < 1e-11, "{}", Word::of(orbit));
    let lead = map.ring.flow(-map.start);
    let matrix = dense(&full_monodromy(orbit).unwrap());
    let difference = (&matrix * &lead - &lead * map.jacobian()).amax();
    assert!(difference < 1e-6 * matrix.amax().max(1.0), "{difference:e} {} {orbit:?}", Word::of(orbit));
    true
}

#[test]
fn masses_of_other_frequencies_and_waves_that_go_round_are_found() {
    let ring = |sites: usize, gamma2: f64| Chain::new(sites, 0.2, gamma2).unwrap();
    let square = ring(4, 0.05).with_ends(Ends::Free).with_layers(2, 0.05, Ends::Free).unwrap();
    let (mut all, mut physical) = (0, 0);
    for (chain, omega, word) in [
        // Twice, three times as fast as the other, either way.
        (ring(9, 0.05), 1.5, "0+3+,3-,0-3+,3-"),
        (ring(9, 0.05), 1.5, "0+3-,3+,0-3-,3+"),
        (ring(9, 0.05), 1.5, "0+2+,2-,2+,0-2-,2+,2-"),
        (ring(9, 0.05).with_ends(Ends::Free), 1.5, "1+2+,2-,1-2+,2-"),
        (ring(9, 0.02), 0.8, "0-3+,3-,3+,3-"),
        (ring(8, 0.02), 0.8, "0-3-,3+"),
        // Three masses a third of a period apart, and around a square of two layers a quarter.
        (ring(3, 0.02), 0.8, "0-,1-,2-"),
        (ring(9, 0.05), 1.5, "0+,6-,3+,0-,6+,3-"),
        (square, 1.5, "1:0+2:1-,2:0+1:1-,1:0-2:1+,2:0-1:1+"),
        (square, 1.5, "1:0+,1:1+,1:0-,1:1-"),
    ] {
        let model = Model::conservative(chain, omega, 0.2).unwrap();
        let (mut finder, mut found) = (Finder::new(chain.sites()), Found::default());
        let word: Word = word.parse().unwrap();
        finder.find_word(&model, &word, Wanted::All, &mut found).unwrap();
        println!("{word}: {} {:?} {:?}", found.orbits.len(), found.completeness, found.ended);
        for orbit in &found.orbits {
            let yes = check(orbit, &mut finder);
            println!("   {} {yes}", Word::of(orbit));
            physical += usize::from(yes);
            all += 1;
        }
    }
    println!("{all} {physical}");
}

#[test]
fn one_mass_may_have_doubled_its_period_beside_one_that_has_not() {
    let (mut all, mut physical) = (0, 0);
    for (asymmetry, amplitude, restitution) in [(0.8, 0.16, 0.25), (0.7, 0.3, 0.6), (0.6, 0.3, 0.9)] {
        let model = Model::forced(Chain::new(9, 0.2, 0.01).unwrap(), 1.07, asymmetry, amplitude, restitution).unwrap();
        for word in ["0-,3-,0-,3-", "0-3-,0-,3-", "0-,3-", "0-3-,0-3-", "0-,3+,0-,3-,3+,3-"] {
            let (mut finder, mut found) = (Finder::new(9), Found::default());
            let word: Word = word.parse().unwrap();
            finder.find_word_over(&model, &word, 2, &mut found).unwrap();
            println!("{word}: {} {:?} {:?}", found.orbits.len(), found.completeness, found.ended);
            for orbit in &found.orbits {
                assert_eq!(orbit.force_periods(), 2);
                let yes = check(orbit, &mut finder);
                println!("   {} {yes}", Word::of(orbit));
                physical += usize::from(yes);
                all += 1;
            }
        }
    }
    println!("{all} {physical}");
}
