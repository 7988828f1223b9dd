//! Branches from masses without coupling along which impulses grow without bound, or nearly so: they end where the pair's χ₂ vanishes,
//! or go through, and either takes the work of few steps. Work is counted, by looks at the request to stop: one an orbit at least.
#![allow(clippy::unwrap_used, reason = "a test stops at the first surprise")]

use std::f64::consts::TAU;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

use vibrochain_breather::{Completeness, End, Finder, NoBreather, OrbitList, Scope};
use vibrochain_lattice::{Chain, Model, Parameter, Point, Stop};

/// Two masses opposite each other on a ring of four, under a force.
const OMEGA: f64 = 0.91;
const GAMMA1: f64 = 0.14;

fn opposite(restitution: f64) -> Model {
    let ring = Point::ring(4).gamma1(GAMMA1).gamma2(0.08);
    ring.omega(OMEGA).asymmetry(0.24).amplitude(0.75).restitution(restitution).model().unwrap()
}

/// The orbits of a word, and the looks that it took to find them.
fn found(model: &Model, word: &str) -> (OrbitList, usize) {
    let looks = Arc::new(AtomicUsize::new(0));
    let counter = Arc::clone(&looks);
    let stop = Stop::when(move || counter.fetch_add(1, Ordering::Relaxed) == usize::MAX);
    let mut found = OrbitList::default();
    let mut finder = Finder::new(model.chain().sites()).until(&stop);
    finder.find_word(model, &word.parse().unwrap(), Scope::All, &mut found).unwrap();
    (found, looks.load(Ordering::Relaxed))
}

/// Where K₀(0) + K₂(0) = 0, −χ₂/2 of the pair, from the sum over all modes: by hand, with no code of the program's.
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
    let (list, looks) = found(&opposite(1.0), "0-2-");
    println!("{looks} looks, {:?} {:?}", list.completeness, list.ended);
    let unbounded: Vec<_> = list.ended.iter().filter(|ended| ended.by == End::Unbounded).collect();
    assert!(!unbounded.is_empty(), "{:?}", list.ended);
    for ended in unbounded {
        assert_eq!(ended.coupling, Parameter::Gamma2);
        assert!((ended.value - pole()).abs() < 1e-9, "{ended} {}", pole());
        assert!(ended.to_string().starts_with("impulses that grow without bound at gamma2 = 0.04770926"), "{ended}");
    }
    assert!(!list.completeness.is_established());
    assert!(looks < 30_000, "{looks}");
}

#[test]
fn up_to_elastic_impacts_the_same_orbits_are_found_for_little_more_work() {
    let (lossy, least) = found(&opposite(0.9), "0-2-");
    let mut last: Option<OrbitList> = None;
    for digits in 3..=6 {
        let loss = 10f64.powi(-digits);
        let (list, looks) = found(&opposite(1.0 - loss), "0-2-");
        println!("1 - {loss:e}: {} orbits, {looks} looks, {:?}", list.orbits.len(), list.ended);
        assert_eq!(list.orbits.len(), lossy.orbits.len(), "{loss} {:?}", list.ended);
        assert!(!list.orbits.is_empty() && list.orbits.iter().all(|orbit| orbit.residual() < 1e-9));
        // Steps grow as the logarithm of impulses does.
        assert!(looks < 8 * least, "{looks} {least}");
        // Orbits depend on the loss smoothly.
        if let Some(last) = &last {
            for (orbit, before) in list.orbits.iter().zip(&last.orbits) {
                let (a, b) = (orbit.impacts()[0].impulse, before.impacts()[0].impulse);
                assert!((a / b - 1.0).abs() < 100.0 * loss, "{loss}: {a} {b}");
            }
        }
        last = Some(list);
    }
}

#[test]
fn other_words_at_elastic_impacts_end_as_well() {
    let mut kinds = [0; 2];
    for (word, sites) in [("1-3-", 5), ("0-2-", 5), ("0-1-", 4), ("0-2-4-", 6)] {
        for step in 0..12 {
            let part = f64::from(step) / 12.0;
            let chain = Chain::new(sites, 0.1 + 0.2 * part, 0.03 + 0.1 * (7.0 * part).fract()).unwrap();
            let model =
                chain.point().omega(0.8 + 0.5 * (5.0 * part).fract()).asymmetry(0.24).amplitude(0.75).model().unwrap();
            let (list, looks) = found(&model, word);
            assert!(looks < 400_000, "{word} {model} {looks}");
            kinds[0] += list.ended.iter().filter(|ended| ended.by == End::Unbounded).count();
            // What was lost on the way is no proof that there is none.
            let open = list.ended.iter().filter(|ended| matches!(ended.by, End::Lost | End::Unfinished)).count();
            if open > 0 {
                kinds[1] += 1;
                assert!(list.completeness.open() != (0, 0), "{word} {model} {:?}", list.completeness);
                let none = Completeness::None { reason: NoBreather::BranchesEnded, by: None };
                assert!(list.completeness != none);
            }
        }
    }
    println!("{kinds:?}");
    assert!(kinds[0] > 3, "{kinds:?}");
}
