//! Words of several sites without force: their block against the whole monodromy matrix.
#![allow(clippy::unwrap_used, reason = "a test stops at the first surprise")]

use vibrochain_breather::{Finder, Found, Letter, Wanted, Word};
use vibrochain_floquet::{Complex, FloquetError, Mechanism, Tolerance, full_monodromy, stability};
use vibrochain_lattice::{Barrier, Chain, Model};
use vibrochain_testkit::{Random, Ranges, Values, dense};

/// A word of one or two instants at up to four sites.
fn word(random: &mut Random, chain: &Chain) -> Option<Word> {
    let mut instants = vec![Vec::new(), Vec::new()];
    for _ in 0..1 + random.below(4) {
        let (site, layer) = chain.layout().place(random.below(chain.sites()));
        let barriers =
            if random.chance(0.5) { [Barrier::Upper, Barrier::Lower] } else { [Barrier::Lower, Barrier::Upper] };
        let double = random.chance(0.6);
        let first = random.below(2);
        for (i, barrier) in barriers.into_iter().enumerate() {
            if double || i == first {
                instants[i].push(Letter { site, layer, barrier });
            }
        }
    }
    instants.retain(|letters| !letters.is_empty());
    Word::new(instants).ok().filter(|word| word.places().len() > 1 || !chain.is_ring())
}

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
        let Some(word) = word(&mut random, &chain) else { continue };
        let (mut finder, mut found) = (Finder::new(sites), Found::default());
        if finder.find_word(&model, &word, Wanted::All, &mut found).is_err() {
            continue;
        }
        for orbit in &found.orbits {
            assert!(orbit.is_reversible());
            let answer = match stability(orbit, Tolerance::Rounding) {
                Err(FloquetError::Grazing { .. }) => continue,
                answer => answer.unwrap(),
            };
            assert_eq!(answer.multipliers.len(), 2 * sites, "{word} {model} {:?}", answer.verdict);
            let matrix = dense(&full_monodromy(orbit).unwrap());
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
            assert!(verdict.marginal || (verdict.spectral_radius - radius).abs() < 1e-6 * radius, "{word} {model}");
            unstable += usize::from(!verdict.stable && !verdict.marginal);
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

/// Two breathers so far apart that nothing is left between them but the phase: it is free, and out of it comes the smallest growth.
#[test]
fn far_breathers_hardly_feel_each_other() {
    let model = Model::conservative(Chain::new(21, 0.2, 0.05).unwrap(), 1.5, 0.2).unwrap();
    let (mut finder, mut found) = (Finder::new(21), Found::default());
    let mut last = f64::INFINITY;
    for distance in 1..=5 {
        // Out of phase at odd distances, in phase at even ones: against the sign of the tail.
        let sign = if distance % 2 == 1 { ['-', '+'] } else { ['+', '-'] };
        let word: Word = format!("0+{distance}{},0-{distance}{}", sign[0], sign[1]).parse().unwrap();
        finder.find_word(&model, &word, Wanted::All, &mut found).unwrap();
        let verdict = stability(&found.orbits[0], Tolerance::Rounding).unwrap().verdict;
        assert_eq!(verdict.mechanism, Some(Mechanism::PlusOne), "{word}");
        let growth = verdict.growth();
        // The phase feels the tail by the root of it, which falls by a factor from site to site.
        assert!(growth < 0.5 * last, "{word}: {growth}");
        last = growth;
    }
    assert!(last > 1e-4 && last < 1e-2, "{last}");
}
