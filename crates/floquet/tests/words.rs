//! Words of several sites without force: their block against the whole monodromy matrix.
#![allow(clippy::unwrap_used, reason = "a test stops at the first surprise")]

use vibrochain_breather::{Finder, Letter, Orbit, OrbitList, Scope, Word};
use vibrochain_floquet::{
    Analyser, Complex, Course, End, Event, FloquetError, Mechanism, Method, Search, Tolerance, Verdict, diagram,
    full_monodromy, leading_modes, locate, phases, stability,
};
use vibrochain_lattice::{Barrier, Chain, Ends, Model, Parameter, Point};
use vibrochain_testkit::{Random, Ranges, Values};

/// Σ μᵏ is the trace of Mᵏ.
#[test]
fn power_sums_are_traces_of_the_whole_matrix() {
    let mut random = Random(31);
    let (mut checked, mut unstable, mut one_instant, mut rings, mut walls, mut layered) = (0, 0, 0, 0, 0, 0);
    let (gamma1, gamma2) = (Values::Even(0.05, 0.6), Values::Even(0.01, 0.3));
    let ranges = Ranges { sites: [2, 10], gamma1, gamma2, ..Ranges::CONSERVATIVE };
    for round in 0..1000 {
        let chain = if round < 400 { random.chain(&ranges) } else { random.lattice(&ranges) };
        let sites = chain.sites();
        let model = Model::conservative(chain, random.between(0.6, 2.5), random.between(0.0, 0.8)).unwrap();
        let word = random.word(&chain).filter(|word| word.places().len() > 1 || !chain.is_ring());
        let Some(word) = word else { continue };
        let (mut finder, mut found) = (Finder::new(sites), OrbitList::default());
        if finder.find_word(&model, &word, Scope::Symmetric, &mut found).is_err() {
            continue;
        }
        for orbit in &found.orbits {
            assert!(orbit.is_reversible());
            let answer = match stability(orbit, Tolerance::Rounding) {
                Err(FloquetError::Grazing { .. }) => continue,
                answer => answer.unwrap(),
            };
            assert_eq!(answer.multipliers.len(), 2 * sites, "{word} {model} {:?}", answer.verdict);
            let matrix = full_monodromy(orbit).unwrap();
            let mut power = matrix.clone();
            for k in 1..=4 {
                let sum: Complex<f64> = answer.multipliers.iter().map(|value| value.powi(k)).sum();
                let scale = matrix.norm().powi(k).max(1.0);
                assert!((sum.re - power.trace()).abs() < 1e-11 * scale, "{word} {model} {k}: {sum} {}", power.trace());
                assert!(sum.im.abs() < 1e-11 * scale);
                power = &power * &matrix;
            }
            let verdict = answer.verdict;
            let radius = answer.multipliers.iter().map(|value| value.norm()).fold(1.0, f64::max);
            assert!(verdict.undecided || (verdict.spectral_radius - radius).abs() < 1e-6 * radius, "{word} {model}");
            unstable += usize::from(!verdict.stable && !verdict.undecided);
            one_instant += usize::from(word.instants().len() == 1);
            rings += usize::from(chain.is_ring());
            walls += usize::from(chain.has_walls());
            layered += usize::from(chain.layers() > 1);
            checked += 1;
        }
    }
    assert!(checked > 300 && unstable > 100 && one_instant > 3, "{checked} {unstable} {one_instant}");
    assert!(rings > 100 && walls > 50 && layered > 70, "{rings} {walls} {layered}");
}

/// Two breathers so far apart that nothing is left between them but the phase: it is free, and out of it comes the smallest excess.
#[test]
fn far_breathers_hardly_feel_each_other() {
    let model = Model::conservative(Chain::new(21, 0.2, 0.05).unwrap(), 1.5, 0.2).unwrap();
    let (mut finder, mut found) = (Finder::new(21), OrbitList::default());
    let mut last = f64::INFINITY;
    for distance in 1..=5 {
        // Out of phase at odd distances, in phase at even ones: against the sign of the tail.
        let sign = if distance % 2 == 1 { ['-', '+'] } else { ['+', '-'] };
        let word: Word = format!("0+{distance}{},0-{distance}{}", sign[0], sign[1]).parse().unwrap();
        finder.find_word(&model, &word, Scope::All, &mut found).unwrap();
        let verdict = stability(&found.orbits[0], Tolerance::Rounding).unwrap().verdict;
        assert_eq!(verdict.mechanism, Some(Mechanism::PlusOne), "{word}");
        let excess = verdict.excess();
        // The phase feels the tail by the root of it, which falls by a factor from site to site.
        assert!(excess < 0.5 * last, "{word}: {excess}");
        last = excess;
    }
    assert!(last > 1e-4 && last < 1e-2, "{last}");
}

/// Phases of weakly coupled breathers are pendulums in a row: of three in phase at an even distance the outer ones run from the middle
/// one twice as hard, by half as much.
#[test]
fn the_phases_that_drift_apart_are_those_of_pendulums() {
    let mut checked = 0;
    for (gamma2, exact) in [(1e-3, 1e-2), (0.05, 0.05)] {
        let patterns: [(&str, &[(usize, f64)]); 4] = [
            ("0+2+,0-2-", &[(0, 1.0), (2, -1.0)]),
            ("0+1-,0-1+", &[(0, 1.0), (1, -1.0)]),
            ("0+2+4+,0-2-4-", &[(0, -0.5), (2, 1.0), (4, -0.5)]),
            ("0+1-2+,0-1+2-", &[(0, -0.5), (1, 1.0), (2, -0.5)]),
        ];
        for (word, pattern) in patterns {
            let model = Model::conservative(Chain::new(13, 0.2, gamma2).unwrap(), 1.5, 0.2).unwrap();
            let (mut finder, mut found) = (Finder::new(13), OrbitList::default());
            finder.find_word(&model, &word.parse().unwrap(), Scope::All, &mut found).unwrap();
            let orbit = &found.orbits[0];
            let shifts = phases(orbit, &leading_modes(orbit, 1).unwrap()[0], &mut finder).unwrap();
            let sign = shifts[0].1.signum() * pattern[0].1.signum();
            assert_eq!(shifts.len(), pattern.len());
            for ((site, ahead), (expected, share)) in shifts.iter().zip(pattern) {
                assert!(site == expected && (sign * ahead - share).abs() < exact, "{word} {gamma2}: {shifts:?}");
            }
            checked += 1;
        }
    }
    assert_eq!(checked, 8);
}

/// The verdict by all zeros of the determinant, if there is one, held against a matrix; `doubts` where there is none.
fn by_zeros_as_by_matrix(orbit: &Orbit, finder: &mut Finder, doubts: &mut usize) -> Option<Verdict> {
    let (model, sites) = (orbit.model().unwrap(), orbit.model().unwrap().chain().sites());
    let answer = Analyser::default().stability(orbit, finder, Tolerance::Rounding);
    let reference = Analyser::dense().stability(orbit, finder, Tolerance::Rounding);
    let (answer, reference) = match (answer, reference) {
        (Err(FloquetError::Grazing { .. }), Err(_)) => return None,
        (answer, reference) => (answer.unwrap(), reference.unwrap()),
    };
    if answer.verdict.method != Method::Secular {
        *doubts += 1;
        return None;
    }
    let told = format!("{} {model} {:?} {:?}", Word::of(orbit), answer.verdict, reference.verdict);
    assert_eq!(answer.multipliers.len(), 2 * sites, "{told}");
    let (verdict, dense) = (answer.verdict, reference.verdict);
    let radius = verdict.spectral_radius;
    let room = [&verdict, &dense].map(|one| if one.undecided { one.resolution } else { 0.0 });
    assert!((radius - dense.spectral_radius).abs() <= 1e-6 * radius + room[0] + room[1], "{told}");
    if !verdict.undecided && !dense.undecided {
        assert_eq!((verdict.stable, verdict.mechanism), (dense.stable, dense.mechanism), "{told}");
    }
    // All multipliers, where they are not next to each other.
    let powers = |multipliers: &[Complex<f64>]| {
        let sum = |k: i32| multipliers.iter().map(|mu| mu.powi(k)).sum::<Complex<f64>>();
        [1, 2, 3, 4, 5].map(sum)
    };
    let scale = radius.powi(6) * sites as f64;
    for (one, other) in powers(&answer.multipliers).into_iter().zip(powers(&reference.multipliers)) {
        assert!((one - other).norm() < 1e-8 * scale, "{one} {other} {told}");
    }
    Some(verdict)
}

/// One site, and two that a reflection exchanges, at once or in turns, of lattices that are no rings.
#[test]
fn zeros_of_lattices_are_those_of_the_matrix() {
    let mut random = Random(78);
    let (gamma1, gamma2) = (Values::Log(0.01, 0.6), Values::Log(1e-3, 0.4));
    let ranges = Ranges { sites: [1, 9], gamma1, gamma2, ..Ranges::CONSERVATIVE };
    let (mut alone, mut pairs, mut layered, mut walls, mut unstable, mut stable) = (0, 0, 0, 0, 0, 0);
    let (mut in_turns, mut doubts) = (0, 0);
    for _ in 0..3000 {
        let chain = random.lattice(&ranges);
        let model = Model::conservative(chain, random.between(0.5, 3.0), random.between(0.0, 0.8)).unwrap();
        let (site, layer) = chain.layout().place(random.below(chain.sites()));
        let image = |n: usize, count: usize, random: &mut Random| random.of(&[n, count - 1 - n]);
        let partner = (image(site, chain.length(), &mut random), image(layer, chain.layers(), &mut random));
        if chain.is_ring() || chain.is_uncoupled() {
            continue;
        }
        let mut places = vec![(site, layer), partner];
        places.dedup();
        let at = |barrier| places.iter().map(|&(site, layer)| Letter { site, layer, barrier }).collect::<Vec<_>>();
        let mut instants = vec![at(Barrier::Lower)];
        let out = places.len() == 2 && random.chance(0.3);
        if out {
            // One after the other.
            let other = instants[0].pop().unwrap();
            instants.push(vec![other]);
        }
        if random.chance(0.6) {
            let up = |letter: &Letter| Letter { barrier: Barrier::Upper, ..*letter };
            let upper: Vec<Vec<Letter>> = instants.iter().map(|letters| letters.iter().map(up).collect()).collect();
            match (instants.as_mut_slice(), upper.as_slice()) {
                ([first, second], [up_first, up_second]) => {
                    first.extend(up_second);
                    second.extend(up_first);
                }
                _ => instants.splice(0..0, upper).for_each(drop),
            }
        }
        let word = Word::new(instants).unwrap();
        let (mut finder, mut found) = (Finder::new(chain.sites()), OrbitList::default());
        if finder.find_word(&model, &word, Scope::All, &mut found).is_err() {
            continue;
        }
        for orbit in &found.orbits {
            let Some(verdict) = by_zeros_as_by_matrix(orbit, &mut finder, &mut doubts) else { continue };
            in_turns += usize::from(out);
            *(if places.len() == 1 { &mut alone } else { &mut pairs }) += 1;
            layered += usize::from(chain.layers() > 1);
            walls += usize::from(chain.has_walls());
            unstable += usize::from(verdict.mechanism.is_some());
            stable += usize::from(verdict.stable);
        }
    }
    let counts = [alone, pairs, layered, walls, unstable, stable, in_turns];
    assert!(10 * doubts < alone + pairs, "{doubts} {counts:?}");
    assert!(alone > 300 && pairs > 500 && counts.iter().all(|&count| count > 200), "{counts:?}");
}

/// Two chains side by side that swing alike stretch no spring between them: whatever γ₃ is, the orbit is the same, though modes in which
/// the chains swing against each other pass many a harmonic on the way. Against each other they do move those, and end there.
#[test]
fn a_resonance_ends_only_orbits_that_push_its_mode() {
    let chain = Chain::new(11, 0.3, 0.05).unwrap().with_layers(2, 0.2, Ends::Free).unwrap();
    let model = Model::conservative(chain, 1.1, 0.3).unwrap();
    let find = |word: &str| {
        let (mut finder, mut found) = (Finder::new(22), OrbitList::default());
        finder.find_word(&model, &word.parse().unwrap(), Scope::All, &mut found).unwrap();
        found.orbits.swap_remove(0)
    };
    let course = |orbit: &Orbit| Course { from: 0.05, to: 3.0, ..Course::new(orbit, Parameter::Gamma3) };
    let alike = find("5:0+5:1+,5:0-5:1-");
    let whole = diagram(&alike, &Course { events: vec![Event::Grazing], ..course(&alike) }).unwrap();
    let branch = &whole.branches[0];
    assert!(branch.ends.iter().all(|(_, end)| *end == End::Range), "{:?}", branch.ends);
    let mut checked = 0;
    for point in branch.points() {
        for (here, there) in point.orbit.impacts().iter().zip(alike.impacts()) {
            assert!((here.impulse - there.impulse).abs() < 1e-9 * there.impulse.abs(), "{}", point.value);
            checked += 1;
        }
    }
    assert!(checked > 200, "{checked}");
    let against = find("5:0+5:1-,5:0-5:1+");
    let answer =
        locate(&against, &Search { event: Event::Fold, free: Parameter::Gamma3, from: 0.05, to: 3.0 }).unwrap();
    assert!(answer.ends.iter().any(|(_, end)| matches!(end, End::Resonance(_))), "{:?}", answer.ends);
}

/// Without coupling two masses that are hit alike have each multiplier twice, and rounding parts such pairs by its root; the multipliers of a
/// mass that is not hit do not count. A verdict alone, as maps ask for it, says the same of both as one with all multipliers.
#[test]
fn a_verdict_alone_on_masses_without_coupling_is_that_of_all_multipliers() {
    let (mut analyser, mut found, mut undecided, mut stable) = (Analyser::default(), OrbitList::default(), 0, 0);
    let cases = [(3, "0+1+,0-1-", 1.0), (5, "0+1+,0-1-", 1.0), (21, "0+1+,0-1-", 1.0), (3, "0-1-", 0.47)];
    for (sites, word, e) in cases {
        let (word, mut finder): (Word, _) = (word.parse().unwrap(), Finder::new(sites));
        for omega in (0..60).map(|i| 1.0 + 0.03 * f64::from(i)) {
            let force = if e < 1.0 { 0.24 } else { 0.0 };
            let point = Point::ring(sites).gamma1(0.8).omega(omega).asymmetry(0.45).amplitude(force).restitution(e);
            if finder.find_word(&point.model().unwrap(), &word, Scope::All, &mut found).is_err() {
                continue;
            }
            for orbit in &found.orbits {
                let alone = analyser.verdict(orbit, &mut finder, Tolerance::Rounding).unwrap();
                let all = analyser.stability(orbit, &mut finder, Tolerance::Rounding).unwrap().verdict;
                assert_eq!(
                    (alone.stable, alone.undecided),
                    (all.stable, all.undecided),
                    "{sites} {omega}: {alone} {all}"
                );
                undecided += usize::from(alone.undecided);
                stable += usize::from(alone.stable);
                assert!(e == 1.0 || !alone.stable || alone.spectral_radius < 1.0, "{omega}: {alone}");
            }
        }
    }
    assert!(undecided > 100 && stable > 10, "{undecided} {stable}");
}

/// An orbit that is its own mirror image after half a period has the squares of that half's multipliers: ±i become a double −1 on the circle.
/// Rounding parts it, and a map must not call that unstable.
#[test]
fn a_map_does_not_call_a_double_minus_one_unstable() {
    let row = Point::ring(4).ends(Ends::Free).gamma1(0.2).gamma2(0.430_426_285_095_017_4);
    let ring = Point::ring(7).gamma1(0.2).omega(1.627_203_395_289_933_9);
    let (mut analyser, mut met) = (Analyser::default(), 0);
    let word: Word = "0+,0-".parse().unwrap();
    for i in -80..=80 {
        let off = 4e-10 * f64::from(i);
        for point in [row.omega(2.543_945_478_434_061_6 + off), ring.gamma2(0.138_740_117_989_817_97 + off)] {
            let (mut finder, mut found) = (Finder::new(point.sites()), OrbitList::default());
            finder.find_word(&point.model().unwrap(), &word, Scope::Symmetric, &mut found).unwrap();
            for orbit in &found.orbits {
                let verdict = analyser.verdict(orbit, &mut finder, Tolerance::Rounding).unwrap();
                assert!(verdict.stable || verdict.undecided, "{off:e} {verdict}");
                let all = analyser.stability(orbit, &mut finder, Tolerance::Rounding).unwrap();
                met += usize::from(all.multipliers.iter().filter(|mu| (*mu + 1.0).norm() < 1e-6).count() == 2);
            }
        }
    }
    assert!(met > 300, "{met}");
}
