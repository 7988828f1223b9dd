//! Words of several sites under a force or with losses: multipliers counted along circles, against the whole monodromy matrix.
#![allow(clippy::unwrap_used, reason = "a test stops at the first surprise")]

use vibrochain_breather::{Finder, Found, Letter, Orbit, Wanted, Word};
use vibrochain_floquet::{Analyser, FloquetError, Method, Tolerance, Verdict};
use vibrochain_lattice::{Barrier, Chain, Model};
use vibrochain_testkit::{Random, Ranges, Values};

/// A word of two to five sites, next to each other or nearly, hit once a period or on both barriers.
fn word_of_sites(random: &mut Random, chain: &Chain) -> Option<Word> {
    let (length, layers) = (chain.length(), chain.layers());
    let count = 2 + random.below(4);
    let mut places: Vec<(usize, usize)> = Vec::new();
    let first = random.below(length);
    for _ in 0..count {
        let place = ((first + random.below(2 * count)) % length, random.below(layers));
        if !places.contains(&place) {
            places.push(place);
        }
    }
    if places.len() < 2 {
        return None;
    }
    let both = random.chance(0.5);
    let mut instants: [Vec<Letter>; 2] = Default::default();
    for (site, layer) in places {
        let up = random.chance(if both { 0.5 } else { 0.2 });
        let [one, other] = if up { [Barrier::Upper, Barrier::Lower] } else { [Barrier::Lower, Barrier::Upper] };
        instants[0].push(Letter { site, layer, barrier: one });
        if both {
            instants[1].push(Letter { site, layer, barrier: other });
        }
    }
    Word::new(instants.into_iter().filter(|letters| !letters.is_empty()).collect()).ok()
}

#[derive(Debug, Default)]
struct Tally {
    compared: usize,
    stable: usize,
    unstable: usize,
    by_many: usize,
    elastic: usize,
    layered: usize,
    walls: usize,
    weak: usize,
    doubts: usize,
}

/// The count's verdict, held against the matrix's.
fn compare(orbit: &Orbit, finder: &mut Finder, tolerance: Tolerance, tally: &mut Tally) {
    let answer = Analyser::counting().stability(orbit, finder, tolerance);
    let reference = Analyser::dense().stability(orbit, finder, tolerance);
    let (answer, reference) = match (answer, reference) {
        (Err(FloquetError::Grazing { .. }), Err(_)) => return,
        (answer, reference) => (answer.unwrap(), reference.unwrap()),
    };
    let (verdict, dense): (Verdict, Verdict) = (answer.verdict, reference.verdict);
    // Where the count has a doubt a matrix answers, or the impacts' equations with all multipliers.
    if verdict.method != Method::Secular || !answer.multipliers.is_empty() {
        assert!(verdict.method == Method::Secular || verdict.method.doubt().is_some());
        tally.doubts += 1;
        return;
    }
    let told = format!("{} {} {verdict:?} {dense:?}", Word::of(orbit), orbit.model());
    if !verdict.marginal && !dense.marginal {
        assert_eq!(verdict.stable, dense.stable, "{told}");
        if verdict.mechanism.is_some() {
            assert_eq!(verdict.mechanism, dense.mechanism, "{told}");
        }
        tally.stable += usize::from(verdict.stable);
        tally.unstable += usize::from(!verdict.stable);
    }
    let off = (verdict.growth() - dense.growth()).abs();
    assert!(off <= verdict.resolution + dense.resolution + 1e-13, "{off} {told}");
    let outside = reference.multipliers.iter().filter(|value| value.norm() > 1.0 + 1e-9).count();
    tally.by_many += usize::from(outside > 2);
    tally.elastic += usize::from(orbit.model().loss() == 0.0);
    let chain = orbit.model().chain();
    tally.layered += usize::from(chain.layers() > 1);
    tally.walls += usize::from(chain.has_walls());
    tally.weak += usize::from(!verdict.stable && verdict.growth() < 1e-3);
    tally.compared += 1;
}

fn random_words(seed: u64, rounds: usize, sites: [usize; 2], tally: &mut Tally) {
    let mut random = Random(seed);
    let (gamma1, gamma2) = (Values::Even(0.05, 0.6), Values::Log(0.003, 0.2));
    let restitution = Values::Either(
        0.15,
        &Values::Is(1.0),
        &Values::Either(0.2, &Values::Even(0.9, 0.999), &Values::Even(0.3, 0.95)),
    );
    let ranges = Ranges { sites, gamma1, gamma2, restitution, amplitude: Values::Log(0.05, 0.6), ..Ranges::FORCED };
    for round in 0..rounds {
        let chain = if round % 2 == 0 { random.chain(&ranges) } else { random.lattice(&ranges) };
        let (omega, asymmetry) = (random.between(0.7, 2.2), random.between(0.0, 0.7));
        let (amplitude, restitution) = (random.value(ranges.amplitude), random.value(ranges.restitution));
        let model = Model::forced(chain, omega, asymmetry, amplitude, restitution).unwrap();
        let Some(word) = word_of_sites(&mut random, &chain) else { continue };
        let tolerance = if random.chance(0.3) { Tolerance::Growth(random.log(1e-4, 0.3)) } else { Tolerance::Rounding };
        let (mut finder, mut found) = (Finder::new(chain.sites()), Found::default());
        if finder.find_word(&model, &word, Wanted::All, &mut found).is_err() {
            continue;
        }
        for orbit in found.orbits.iter().filter(|orbit| orbit.impact_site().is_none()).take(4) {
            compare(orbit, &mut finder, tolerance, tally);
        }
    }
}

fn counts_hold(seed: u64, rounds: usize, sites: [usize; 2]) -> Tally {
    let mut tally = Tally::default();
    random_words(seed, rounds, sites, &mut tally);
    println!("{tally:?}");
    assert!(10 * tally.compared > rounds && 10 * tally.doubts < tally.compared, "{tally:?}");
    tally
}

#[test]
fn counts_are_those_of_the_matrix() {
    let tally = counts_hold(5, 600, [3, 12]);
    let Tally { stable, unstable, by_many, elastic, layered, walls, weak, .. } = tally;
    assert!(unstable > 60 && [stable, by_many, elastic, layered].iter().all(|&count| count > 15), "{tally:?}");
    assert!(walls > 9 && weak > 5, "{tally:?}");
}

#[test]
#[ignore = "minutes: cargo test --workspace --test turns -- --ignored slow"]
fn slow_counts_on_middle_lattices_are_those_of_the_matrix() {
    counts_hold(6, 2000, [3, 12]);
    counts_hold(7, 600, [12, 60]);
}

/// A row of masses next to each other: what is outside the circle is the breather's own, and the length of the ring does not matter to it.
fn on_a_ring(sites: usize, word: &str) -> Vec<Verdict> {
    let model = Model::forced(Chain::new(sites, 0.2, 0.02).unwrap(), 1.5, 0.4, 0.1, 0.9).unwrap();
    let (mut finder, mut found) = (Finder::new(sites), Found::default());
    finder.find_word(&model, &word.parse().unwrap(), Wanted::All, &mut found).unwrap();
    let mut analyser = Analyser::default();
    found.orbits.iter().map(|orbit| analyser.verdict(orbit, &mut finder, Tolerance::Growth(0.01)).unwrap()).collect()
}

fn long_rings_are_like_short_ones(sites: usize, word: &str) {
    let (short, long) = (on_a_ring(51, word), on_a_ring(sites, word));
    assert!(short.len() == long.len() && short.iter().any(|verdict| !verdict.stable));
    for (short, long) in short.iter().zip(&long) {
        assert!(short.method == Method::Dense(None) && long.method == Method::Secular, "{short:?} {long:?}");
        assert_eq!((short.stable, short.mechanism), (long.stable, long.mechanism), "{short:?} {long:?}");
        let room = if long.stable { long.resolution } else { 1e-9 };
        assert!((short.growth() - long.growth()).abs() <= room + 1e-9, "{short:?} {long:?}");
    }
}

#[test]
fn rings_beyond_the_matrix_are_like_short_ones() {
    long_rings_are_like_short_ones(1101, "0+1+2+,0-1-2-");
}

#[test]
#[ignore = "a minute: cargo test --workspace --test turns -- --ignored slow"]
fn slow_rings_of_ten_thousand_masses_are_like_short_ones() {
    long_rings_are_like_short_ones(10_001, "0+1+2+3+4+,0-1-2-3-4-");
}
