//! Impulses that grow nearly without bound: up to elastic impacts lists hold the same orbits, for the work of few steps. Work is counted, by looks
//! at the request to stop: one an orbit at least.
#![allow(clippy::unwrap_used, reason = "a test stops at the first surprise")]

use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

use vibrochain_breather::{Finder, OrbitList, Scope};
use vibrochain_lattice::{Model, Point, Stop};

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
