//! Words of several sites: what is counted, against dense matrices; on a large ring, against a smaller one.

use vibrochain_breather::{Finder, Found, Letter, Wanted, Word};
use vibrochain_lattice::{Barrier, Chain, Model};
use vibrochain_testkit::Random;

use crate::secular::{Inertia, SecularError, Standing};
use crate::{Analyser, Tolerance};

/// A word of one or two instants at two to five sites.
fn word(random: &mut Random, sites: usize) -> Option<Word> {
    let mut instants = vec![Vec::new(), Vec::new()];
    let alike = random.chance(0.5);
    for _ in 0..2 + random.below(4) {
        let site = random.below(sites.min(8));
        let first = usize::from(!alike && random.chance(0.5));
        let double = alike || random.chance(0.7);
        for (i, barrier) in [Barrier::Upper, Barrier::Lower].into_iter().enumerate() {
            if double || i == first {
                instants[(i + first) % 2].push(Letter::new(site, barrier));
            }
        }
    }
    instants.retain(|letters| !letters.is_empty());
    Word::new(instants).ok().filter(|word| word.places().len() > 1)
}

#[test]
fn counts_are_those_of_dense_matrices() {
    let mut random = Random(15);
    let (mut stable, mut unstable, mut complex, mut open, mut one_instant) = (0, 0, 0, 0, 0);
    let (mut finder, mut found) = (Finder::new(1), Found::default());
    let (mut inertia, mut dense) = (Inertia::default(), Analyser::dense());
    for _ in 0..1500 {
        let sites = 3 + random.below(30);
        let chain = Chain::new(sites, random.between(0.05, 0.6), random.log(1e-3, 0.3)).unwrap();
        let model = Model::conservative(chain, random.between(0.6, 2.5), random.between(0.0, 0.8)).unwrap();
        let Some(word) = word(&mut random, sites) else { continue };
        if finder.find_word(&model, &word, Wanted::All, &mut found).is_err() {
            continue;
        }
        for orbit in &found.orbits {
            let Ok(reference) = dense.stability(orbit, &mut finder, Tolerance::Rounding) else { continue };
            let reference = reference.verdict;
            let condition = finder.condition(orbit).unwrap();
            inertia.set(finder.prepared(orbit).unwrap(), &condition);
            let told = format!("{word} {model:?} {reference:?}");
            match inertia.verdict() {
                Ok(verdict) => {
                    assert!(verdict.outcome != Standing::Marginal, "{verdict:?} {told}");
                    if reference.marginal {
                        continue;
                    }
                    assert_eq!(verdict.outcome == Standing::Stable, reference.stable, "{verdict:?} {told}");
                    let off = (verdict.growth - reference.growth()).abs();
                    let room = verdict.growth_error + 4.0 * reference.resolution + 1e-9 * verdict.growth;
                    assert!(off <= room, "{off:e} {verdict:?} {told}");
                    stable += usize::from(reference.stable);
                    unstable += usize::from(!reference.stable);
                    one_instant += usize::from(word.instants().len() == 1);
                }
                Err(SecularError::Incomplete { found, wanted }) => {
                    assert!(found < wanted, "{found} {wanted} {told}");
                    complex += usize::from(!reference.stable);
                    open += usize::from(reference.stable);
                }
                Err(_) => open += 1,
            }
        }
    }
    println!("{stable} {unstable} {complex} {open} {one_instant}");
    assert!(stable > 100 && unstable > 100 && one_instant > 5 && 5 * open < stable + unstable);
}

#[test]
fn five_breathers_on_ten_thousand_masses_are_judged() {
    let word: Word = "0+2+5+9+14+,0-2-5-9-14-".parse().unwrap();
    let verdict = |sites: usize, mut analyser: Analyser| {
        let model = Model::conservative(Chain::new(sites, 0.2, 0.05).unwrap(), 1.5, 0.2).unwrap();
        let (mut finder, mut found) = (Finder::new(sites), Found::default());
        finder.find_word(&model, &word, Wanted::All, &mut found).unwrap();
        analyser.verdict(&found.orbits[0], &mut finder, Tolerance::Rounding).unwrap()
    };
    let (large, small) = (verdict(10_001, Analyser::default()), verdict(101, Analyser::dense()));
    println!("{large:?} {small:?}");
    assert_eq!((large.stable, large.mechanism), (small.stable, small.mechanism));
    // Nothing of them reaches the end of the smaller ring.
    assert!((large.spectral_radius - small.spectral_radius).abs() < 1e-9);
}
