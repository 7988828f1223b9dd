//! Orbits of any impact word: polished, conditioned, checked, followed and judged, against many digits and a simulated return map.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test stops at the first surprise")]

mod support;

use vibrochain_breather::{
    Branch, BranchPoint, BreatherError, End, Ended, Family, Finder, Hit, Impact, NoBreather, Orbit, OrbitList, Scope,
    Word, breathers,
};
use vibrochain_floquet::{Method, Tolerance, full_monodromy, stability};
use vibrochain_lattice::{Barrier, Chain, Model, Parameter, Point};
use vibrochain_testkit::{Random, ReturnMap, words};
use vibrochain_truth::{DEFAULT_BITS, TrueImpact, TrueOrbit, TrueSpectrum};

use support::assert_claims_hold;

/// The errors that an orbit's condition claims, against many digits. Returns the largest true error of an impulse.
fn assert_own_claims_hold(orbit: &Orbit, finder: &mut Finder) -> f64 {
    let condition = finder.condition(orbit).unwrap();
    let truth = TrueOrbit::refine(orbit, DEFAULT_BITS).unwrap();
    assert_claims_hold(orbit, &condition, &truth);
    let error = |(impact, truth): (&Impact, &TrueImpact)| (&truth.impulse - impact.impulse).to_f64().abs();
    orbit.impacts().iter().zip(truth.impacts()).map(error).fold(0.0, f64::max)
}

/// All multipliers' power sums and the monodromy matrix itself, against differences of a simulated return map.
fn assert_monodromy(orbit: &Orbit) {
    let map = ReturnMap::new(orbit);
    let point = map.fixed_point();
    assert!((map.apply(&point) - &point).amax() < 1e-10);
    let lead = map.ring.flow(-map.start);
    let matrix = full_monodromy(orbit).unwrap();
    let difference = (&matrix * &lead - &lead * map.jacobian()).amax();
    assert!(difference < 1e-6 * matrix.amax().max(1.0), "{difference:e} {orbit:?}");
}

/// Single-sided orbits of one mass alone, put side by side: each hits when the common force has the phase it needs.
fn side_by_side(model: &Model, sites: &[usize], solutions: &[usize]) -> Orbit {
    let alone = model.with(Parameter::Gamma2, 0.0).unwrap();
    let found = breathers(&alone, Family::SingleSided).unwrap().orbits;
    let phases: Vec<f64> = solutions.iter().map(|&i| found[i].psi().unwrap()).collect();
    let mut hits: Vec<Hit> = (sites.iter().zip(solutions).zip(&phases))
        .map(|((&site, &i), psi)| {
            let impact = found[i].impacts()[0];
            Hit::new(site, impact.barrier, (psi - phases[0]).rem_euclid(model.period()), impact.impulse)
        })
        .collect();
    hits.sort_by(|a, b| a.time.total_cmp(&b.time));
    Orbit::from_impulses(model, 1, phases[0], &hits).unwrap()
}

#[test]
fn three_impacts_at_three_sites_from_a_guess_to_a_verdict() {
    let chain = Chain::new(8, 0.2, 0.002).unwrap();
    let model = chain.point().omega(1.07).asymmetry(0.7).amplitude(0.3).restitution(0.6).model().unwrap();
    let mut finder = Finder::new(8);
    let mut checked = 0;
    for solutions in [[0, 0, 0], [0, 1, 0], [1, 1, 0], [1, 0, 1]] {
        let guess = side_by_side(&model, &[0, 1, 4], &solutions);
        assert!(guess.residual() > 1e-4, "coupling is felt: {:e}", guess.residual());
        let orbit = finder.polish(&guess).unwrap();
        assert!(orbit.residual() < 1e-14 && orbit.impacts().len() == 3);
        assert!(assert_own_claims_hold(&orbit, &mut finder) < 1e-13);
        // Followed in the coupling, to the value and back.
        let mut branch = Branch::of_orbit(&orbit, Parameter::Gamma2, 0.05).unwrap();
        let of_lattice = |point: &BranchPoint| point.orbit().to_orbit(orbit.family()).unwrap();
        let mut point = branch.start().unwrap();
        while point.value() < 0.006 {
            point = branch.step(&point, 0.01).unwrap();
            assert!(assert_own_claims_hold(&of_lattice(&point), &mut finder) < 1e-12);
        }
        let there = of_lattice(&point);
        assert_monodromy(&there);
        let verdict = stability(&there, Tolerance::Rounding).unwrap().verdict;
        let map = ReturnMap::new(&there).jacobian();
        let radius = map.complex_eigenvalues().iter().map(|value| value.norm()).fold(0.0, f64::max);
        assert!((verdict.spectral_radius - radius).abs() < 1e-5 * radius, "{} {radius}", verdict.spectral_radius);
        // Physical or not: against a fine look at all masses.
        let admissibility = finder.admissibility(&there).unwrap();
        let (a, motion) = (model.asymmetry(), finder.motion(&there).unwrap());
        let period = model.period();
        let mut highest = f64::NEG_INFINITY;
        for i in 0..4000 {
            let values = motion.displacements(period * (f64::from(i) + 0.5) / 4000.0);
            highest = values.iter().map(|v| (v - a).abs()).fold(highest, f64::max);
        }
        let right = there.impacts().iter().all(Impact::is_right_signed);
        assert_eq!(admissibility.is_physical(), right && highest < 1.0 + 1e-9, "{highest} {admissibility:?}");
        let mut back = point.reversed();
        while back.value() > model.chain().gamma2() {
            back = branch.step(&back, 0.01).unwrap();
        }
        let home = branch.at(&back, model.chain().gamma2()).unwrap();
        for (hit, first) in home.orbit().hits().iter().zip(orbit.impacts()) {
            assert!((hit.impulse - first.impulse).abs() < 1e-12 && hit.site == first.site);
        }
        checked += 1;
    }
    assert_eq!(checked, 4);
}

#[test]
fn checked_words_are_found_again_from_a_guess() {
    let mut random = Random(8);
    for case in words() {
        let mut rough = case.hits.clone();
        rough.iter_mut().for_each(|hit| hit.impulse *= 1.0 + 0.02 * (random.unit() - 0.5));
        let sites = case.model.chain().sites();
        let mut finder = Finder::new(sites);
        let guess = Orbit::from_impulses(&case.model, 1, case.psi, &rough).unwrap();
        let orbit = finder.polish(&guess).unwrap_or_else(|error| panic!("{}: {error}", case.word));
        assert!(orbit.residual() < 1e-14, "{}: {:e}", case.word, orbit.residual());
        for hit in &case.hits {
            let same = |impact: &&Impact| impact.site == hit.site && impact.barrier == hit.barrier;
            let impact = orbit.impacts().iter().find(same).unwrap();
            assert!((impact.impulse - hit.impulse).abs() < 1e-12 * hit.impulse.abs().max(1.0), "{}", case.word);
        }
        if let Some(physical) = case.physical {
            assert_eq!(finder.admissibility(&orbit).unwrap().is_physical(), physical, "{}", case.word);
        }
        assert_own_claims_hold(&orbit, &mut finder);
        let verdict = stability(&orbit, Tolerance::Rounding).unwrap().verdict;
        // The table's radius is that of dense eigenvalues: the trivial pair is split.
        let difference = (verdict.spectral_radius - case.spectral_radius).abs();
        assert!(difference < 1e-6 * case.spectral_radius, "{}: {}", case.word, verdict.spectral_radius);
    }
}

/// The impulses of the table, whatever the order of impacts of one instant.
fn assert_same_impulses(orbit: &Orbit, hits: &[Hit], word: &str) {
    assert_eq!(orbit.impacts().len(), hits.len());
    for hit in hits {
        let same = |impact: &&Impact| impact.site == hit.site && impact.barrier == hit.barrier;
        let impact = orbit.impacts().iter().find(same).unwrap();
        assert!((impact.impulse - hit.impulse).abs() < 1e-12 * hit.impulse.abs().max(1.0), "{word}");
    }
}

#[test]
fn checked_words_are_found_without_a_guess() {
    let (mut finder, mut found) = (Finder::new(21), OrbitList::default());
    let (mut reversible, mut forced) = (0, 0);
    for case in words() {
        let word: Word = case.word.parse().unwrap();
        assert_eq!(word.to_string(), case.word);
        finder.find_word(&case.model, &word, Scope::All, &mut found).unwrap();
        if case.model.is_conservative() {
            let orbit =
                found.orbits.iter().find(|orbit| orbit.phi().is_none_or(|phi| phi == 0.5 * orbit.period())).unwrap();
            assert!(orbit.residual() < 1e-14, "{word}: {:e}", orbit.residual());
            assert_same_impulses(orbit, &case.hits, &case.word);
            assert_eq!(finder.admissibility(orbit).unwrap().is_physical(), case.physical.unwrap(), "{word}");
            reversible += 1;
            continue;
        }
        assert!(found.completeness.is_established(), "{word}: {:?}", found.completeness);
        let psi = |orbit: &&Orbit| (orbit.psi().unwrap() - case.psi).abs() < 1e-10;
        let orbit = found.orbits.iter().find(psi).unwrap();
        assert_same_impulses(orbit, &case.hits, &case.word);
        assert_eq!(Word::of(orbit), word);
        forced += 1;
    }
    assert!(reversible >= 30 && forced >= 1, "{reversible} {forced}");
}

/// Orbits of random words under a force are fixed points of a simulated return map; branches end where they say.
#[test]
fn followed_words_are_orbits_and_their_ends_are_ends() {
    let mut random = Random(17);
    let (mut finder, mut found) = (Finder::new(9), OrbitList::default());
    let (mut orbits, mut ends, mut folds, mut grazings) = (0, 0, 0, 0);
    for round in 0..240 {
        let gamma2 = random.between(0.05, 0.4);
        let chain = Chain::new(9, random.between(0.05, 0.6), gamma2).unwrap();
        let (omega, asymmetry) = (random.between(0.5, 2.0), random.between(0.0, 0.8));
        let (amplitude, restitution) = (random.between(0.02, 0.6), random.between(0.2, 0.99));
        let point = chain.point().omega(omega).asymmetry(asymmetry);
        let model = point.amplitude(amplitude).restitution(restitution).model().unwrap();
        // Lists of up to three impacts one after the other are proved: no branch is followed to those.
        let words = ["0+3+,0-3-", "0-,2-", "0-2-", "0+,4-,0-", "0+1-,0-1+", "0+", "0-3-", "0-2-4-"];
        let word: Word = words[round % 8].parse().unwrap();
        if finder.find_word(&model, &word, Scope::All, &mut found).is_err() {
            continue;
        }
        for orbit in &found.orbits {
            assert!(orbit.residual() < 1e-13, "{word} {:e}", orbit.residual());
            if finder.admissibility(orbit).unwrap().is_physical() {
                let map = ReturnMap::new(orbit);
                let point = map.fixed_point();
                assert!((map.apply(&point) - &point).amax() < 1e-9, "{word}");
                orbits += 1;
            }
        }
        let told = |ended: &&Ended| matches!(ended.by, End::Fold | End::Grazing { .. });
        for ended in found.ended.iter().filter(told) {
            ends += 1;
            assert!(ended.value > 0.0 && ended.value < gamma2, "{ended} {word}");
            let at = |part: f64| {
                let model = model.with(Parameter::Gamma2, part * ended.value).unwrap();
                let (mut finder, mut found) = (Finder::new(9), OrbitList::default());
                finder.find_word(&model, &word, Scope::All, &mut found).unwrap();
                found
            };
            // Just before its end a branch is there, just behind it is not.
            let (before, behind) = (at(1.0 - 1e-4), at(1.0 + 1e-4));
            assert!(before.orbits.len() > behind.orbits.len(), "{ended} {word} {model:?}");
            match ended.by {
                End::Fold => {
                    let tell = |orbit: &Orbit| finder_condition(orbit);
                    assert!(before.orbits.iter().map(tell).fold(1.0, f64::min) < 0.1, "{ended} {word}");
                    folds += 1;
                }
                End::Grazing { site } => {
                    let slow = |impact: &Impact| impact.site == site && impact.velocity_before.abs() < 0.1;
                    assert!(before.orbits.iter().any(|orbit| orbit.impacts().iter().any(slow)), "{ended} {word}");
                    grazings += 1;
                }
                End::Resonance(_) | End::Unbounded | End::Lost | End::Unfinished => {}
            }
        }
    }
    assert!(orbits >= 10 && ends >= 10 && folds >= 3 && grazings >= 3, "{orbits} {ends} {folds} {grazings}");
}

fn finder_condition(orbit: &Orbit) -> f64 {
    Finder::new(9).condition(orbit).unwrap().fold
}

#[test]
fn words_without_an_answer_say_why() {
    let (mut finder, mut found) = (Finder::new(7), OrbitList::default());
    let mut none = |amplitude: f64, restitution: f64, gamma1: f64, word: &str| {
        let chain = Chain::new(7, gamma1, 0.05).unwrap();
        let model =
            chain.point().omega(1.5).asymmetry(0.2).amplitude(amplitude).restitution(restitution).model().unwrap();
        finder.find_word(&model, &word.parse().unwrap(), Scope::All, &mut found).map(|()| found.completeness.reason())
    };
    assert_eq!(none(0.0, 0.9, 0.2, "0+3+,0-3-"), Ok(Some(NoBreather::LossWithoutForce)));
    assert_eq!(none(0.0, 1.0, 0.0, "0+3+"), Ok(Some(NoBreather::NetImpulse)));
    assert_eq!(none(0.0, 1.0, 0.2, "0+,3+,4-"), Ok(Some(NoBreather::NothingPushes)));
    assert_eq!(none(0.0, 1.0, 0.2, "0+,3+,4-,4+,4+"), Ok(Some(NoBreather::NoStart)));
    assert_eq!(none(0.0, 1.0, 0.2, "0+3+,0-3-,0+3+,0-3-"), Ok(Some(NoBreather::RepeatsSooner)));
    assert_eq!(none(0.0, 1.0, 0.2, "0+,0-,0+,0-"), Ok(Some(NoBreather::RepeatsSooner)));
    assert!(matches!(none(0.1, 0.9, 0.2, "0-,0-,0-,3-"), Ok(Some(NoBreather::NotSearched(_)))));
    assert!(matches!(none(0.0, 1.0, 0.2, "0+7+"), Err(BreatherError::Word(_))));
}

/// Losses that no force makes good: there is no orbit, and no phase to look for.
#[test]
fn a_guess_that_leads_nowhere_is_an_error() {
    let model = Point::ring(5).gamma1(0.2).gamma2(0.1).omega(1.5).asymmetry(0.4).restitution(0.7).model().unwrap();
    let hits = [(0, 0.0), (2, 1.3), (3, 1.7)].map(|(site, time)| Hit::new(site, Barrier::Upper, time, -1.0));
    let guess = Orbit::from_impulses(&model, 1, 0.0, &hits).unwrap();
    match Finder::new(5).polish(&guess) {
        Err(BreatherError::NotConverged { violation }) => assert!(violation > 1e-6, "{violation}"),
        other => panic!("{other:?}"),
    }
}

/// Verdicts on pairs in phase and out of phase, from strong coupling to next to none, where the pair of their phases is all but on the
/// circle: what is certain is right, and excess is known as well as it says.
#[test]
fn certain_verdicts_on_pairs_are_right_however_weak_the_coupling() {
    let mut random = Random(5);
    let (mut unstable, mut stable, mut open, mut tiny) = (0, 0, 0, 0);
    for _ in 0..150 {
        let sites = 3 + random.below(5);
        let chain = Chain::new(sites, random.between(0.1, 1.0), random.log(1e-7, 0.3)).unwrap();
        let out = random.chance(0.4);
        let asymmetry = if out { 0.0 } else { random.between(0.0, 0.6) };
        let model = Model::conservative(chain, random.between(1.0, 2.5), asymmetry).unwrap();
        let distance = 1 + random.below(sites / 2);
        let signs = if out { ['-', '+'] } else { ['+', '-'] };
        let word: Word = format!("0+{distance}{},0-{distance}{}", signs[0], signs[1]).parse().unwrap();
        let (mut finder, mut found) = (Finder::new(sites), OrbitList::default());
        if finder.find_word(&model, &word, Scope::All, &mut found).is_err() {
            continue;
        }
        for orbit in &found.orbits {
            let Ok(answer) = stability(orbit, Tolerance::Rounding) else { continue };
            let Ok(truth) = TrueOrbit::refine(orbit, DEFAULT_BITS) else { continue };
            let verdict = answer.verdict;
            if verdict.method != Method::Secular || verdict.undecided {
                open += 1;
                continue;
            }
            let told = format!("{word} {model} {verdict:?}");
            let blocks = [1.0, -1.0].map(|sign| TrueSpectrum::of_partners(&truth, sign).unwrap());
            let refined = |start: vibrochain_floquet::Complex<f64>| {
                let roots = blocks.iter().filter_map(|block| block.refine((start.re, start.im)).ok());
                roots.min_by(|a, b| a.1.total_cmp(&b.1)).map(|(root, _)| (root.abs() - 1.0).to_f64())
            };
            let start = verdict.leading;
            if verdict.stable {
                let upper = answer.multipliers.iter().filter(|multiplier| multiplier.im >= 0.0);
                for excess in upper.filter_map(|&multiplier| refined(multiplier)) {
                    assert!(excess.abs() < 1e-20, "{excess:e} {told}");
                }
                stable += 1;
            } else if let Some(excess) = refined(start) {
                let off = (excess - verdict.excess()).abs();
                assert!(excess > 0.0 && off <= verdict.resolution + 1e-15 * excess, "{excess:e} {off:e} {told}");
                tiny += usize::from(excess < 1e-4);
                unstable += 1;
            }
        }
    }
    println!("{unstable} {stable} {open} {tiny}");
    assert!(unstable > 40 && stable > 40 && tiny > 4 && 3 * open < unstable + stable);
}
