//! Words of many instants without force, and words of several periods of the force, found from masses alone: against many digits, a
//! simulated return map and the limit itself.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test stops at the first surprise")]

mod support;

use vibrochain_breather::{End, Finder, NoBreather, Orbit, OrbitList, Scope, Unsearched, Word};
use vibrochain_floquet::full_monodromy;
use vibrochain_lattice::{Chain, Ends, Model, Point};
use vibrochain_testkit::{Random, ReturnMap};
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
    let (point, jacobian) = (map.fixed_point(), map.jacobian());
    let radius = jacobian.complex_eigenvalues().iter().map(|value| value.norm()).fold(1.0, f64::max);
    let mut state = point.clone();
    // Ten periods, or as many as the growth of rounding allows.
    let periods = (1e4_f64.ln() / radius.ln()).clamp(1.0, 10.0) as usize;
    for _ in 0..periods {
        state = map.apply(&state);
    }
    assert!((&state - &point).amax() < 1e-10, "{} {:e}", Word::of(orbit), (&state - &point).amax());
    let lead = map.ring.flow(-map.start);
    let matrix = full_monodromy(orbit).unwrap();
    let difference = (&matrix * &lead - &lead * jacobian).amax();
    // Next to a grazing the map bends within the square of the impact's velocity, and differences see less of its slope.
    let seen = matrix.amax().max(1.0) / map.slowest_impact().powi(2);
    assert!(difference < 1e-6 * seen, "{difference:e} {} {orbit:?}", Word::of(orbit));
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
        let (mut finder, mut found) = (Finder::new(chain.sites()), OrbitList::default());
        let word: Word = word.parse().unwrap();
        finder.find_word(&model, &word, Scope::All, &mut found).unwrap();
        for orbit in &found.orbits {
            physical += usize::from(check(orbit, &mut finder));
            all += 1;
        }
    }
    assert!(all >= 9 && physical >= 6, "{all} {physical}");
}

#[test]
fn one_mass_may_have_doubled_its_period_beside_one_that_has_not() {
    let (mut all, mut physical) = (0, 0);
    for (asymmetry, amplitude, restitution) in [(0.8, 0.16, 0.25), (0.7, 0.3, 0.6), (0.6, 0.3, 0.9)] {
        let ring = Point::ring(9).gamma1(0.2).gamma2(0.01);
        let model =
            ring.omega(1.07).asymmetry(asymmetry).amplitude(amplitude).restitution(restitution).model().unwrap();
        for word in ["0-,3-,0-,3-", "0-3-,0-,3-", "0-,3-", "0-3-,0-3-", "0-,3+,0-,3-,3+,3-"] {
            let (mut finder, mut found) = (Finder::new(9), OrbitList::default());
            let word: Word = word.parse().unwrap();
            finder.find_word_over(&model, &word, 2, &mut found).unwrap();
            for orbit in &found.orbits {
                assert_eq!(orbit.force_periods(), 2);
                physical += usize::from(check(orbit, &mut finder));
                all += 1;
            }
        }
    }
    assert!(all >= 31 && physical >= 21, "{all} {physical}");
}

/// What nothing determines is not searched for, and the answer says so.
#[test]
fn phases_that_nothing_holds_are_named() {
    let reason = |chain: Chain, asymmetry: f64, word: &str| {
        let model = Model::conservative(chain, 1.5, asymmetry).unwrap();
        let (mut finder, mut found) = (Finder::new(chain.sites()), OrbitList::default());
        finder.find_word(&model, &word.parse().unwrap(), Scope::All, &mut found).unwrap();
        assert!(found.orbits.is_empty());
        found.completeness.reason()
    };
    let ring = |sites: usize, gamma2: f64| Chain::new(sites, 0.2, gamma2).unwrap();
    let word = "0+3+,3-,0-3+,3-";
    // In a centred gap one mass has odd harmonics of its frequency only, and the other, twice as fast, even ones.
    let unsearched = |why| Some(NoBreather::NotSearched(why));
    assert_eq!(reason(ring(9, 0.05), 0.0, word), unsearched(Unsearched::FreePhases));
    assert_eq!(reason(ring(101, 0.001), 0.2, &word.replace('3', "50")), unsearched(Unsearched::FreePhases));
    assert_eq!(reason(ring(9, 0.0), 0.2, word), unsearched(Unsearched::Uncoupled));
    // Phases that are none of those at rest, and a mass that has no such orbit alone.
    assert_eq!(reason(ring(9, 0.05), 0.2, "0+,3+,3-,0-,3+,3-"), Some(NoBreather::NoStart));
    assert_eq!(reason(ring(9, 0.05), 0.2, "0+,0-,0-,3+"), Some(NoBreather::NoStart));
}

/// As the coupling vanishes an orbit becomes that of masses alone, whatever their frequencies.
#[test]
fn words_begin_at_masses_alone() {
    let impulses = |gamma2: f64| {
        let model = Model::conservative(Chain::new(9, 0.2, gamma2).unwrap(), 1.5, 0.2).unwrap();
        let (mut finder, mut found) = (Finder::new(9), OrbitList::default());
        finder.find_word(&model, &"0+1+,1-,0-1+,1-".parse().unwrap(), Scope::All, &mut found).unwrap();
        found.orbits[0].impacts().iter().map(|impact| (impact.site, impact.impulse)).collect::<Vec<_>>()
    };
    // One mass between two barriers, by the closed form of the family.
    let alone = |omega: f64| {
        let model = Model::conservative(Chain::new(1, 0.2, 0.0).unwrap(), omega, 0.2).unwrap();
        let found = vibrochain_breather::breathers(&model, vibrochain_breather::Family::DoubleSided).unwrap();
        found.orbits[0].impacts().iter().map(|impact| impact.impulse).collect::<Vec<_>>()
    };
    for (gamma2, near) in [(1e-3, 0.02), (1e-4, 0.002)] {
        let mut compared = 0;
        for (site, impulse) in impulses(gamma2) {
            let expected = alone(if site == 0 { 1.5 } else { 3.0 });
            let off = expected.iter().map(|one| (one - impulse).abs()).fold(f64::INFINITY, f64::min);
            assert!(off < near, "{gamma2} {site} {off}");
            compared += 1;
        }
        assert_eq!(compared, 6);
    }
}

/// What ends branches of random words under a force: every end has a name.
fn assert_ends_are_named(rounds: usize) {
    let mut random = Random(17);
    let (mut finder, mut found) = (Finder::new(9), OrbitList::default());
    let (mut ends, mut came) = ([0; 3], 0);
    for round in 0..rounds {
        let gamma2 = random.between(0.05, 0.4);
        let chain = Chain::new(9, random.between(0.05, 0.6), gamma2).unwrap();
        let (omega, asymmetry) = (random.between(0.5, 2.0), random.between(0.0, 0.8));
        let (amplitude, restitution) = (random.between(0.02, 0.6), random.between(0.2, 0.99));
        let point = chain.point().omega(omega).asymmetry(asymmetry);
        let model = point.amplitude(amplitude).restitution(restitution).model().unwrap();
        // Lists of up to three instants of which a symmetry makes the impacts alike are proved: no branch is followed to those.
        let words = [
            "0+1+4+,0-1-4-",
            "0-1-3-",
            "0-1-4-",
            "0+4-,0-4+",
            "0+1-,0-1+",
            "0+3-,0-3+",
            "0+1+3+,0-1-3-",
            "0-2-3-",
            "0-1-3-7-",
        ];
        if finder.find_word(&model, &words[round % 9].parse().unwrap(), Scope::All, &mut found).is_err() {
            continue;
        }
        came += found.orbits.len();
        for ended in &found.ended {
            match ended.by {
                End::Fold => ends[0] += 1,
                End::Grazing { .. } => ends[1] += 1,
                End::Resonance(_) => ends[2] += 1,
                End::Unbounded | End::Lost | End::Unfinished => panic!("{ended} {} {model}", words[round % 9]),
            }
        }
    }
    println!("{came} came, ended by {ends:?}");
    assert!(ends.iter().all(|&count| 90 * count > rounds) && 20 * came > rounds, "{ends:?} {came}");
}

#[test]
fn every_branch_ends_for_a_reason_that_is_told() {
    assert_ends_are_named(500);
}

#[test]
#[ignore = "a minute; ten thousand branches"]
fn slow_every_branch_ends_for_a_reason_that_is_told() {
    assert_ends_are_named(15_000);
}
