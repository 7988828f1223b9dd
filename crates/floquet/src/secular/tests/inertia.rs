//! Words of several sites: what is counted, against dense matrices; on a large ring, against a smaller one.

use vibrochain_breather::{Finder, Found, Letter, Wanted, Word};
use vibrochain_lattice::{Barrier, Chain, Ends, Model};
use vibrochain_testkit::{Random, Ranges, Values};

use crate::analyser::Failure;
use crate::secular::SecularError;
use crate::verdict::Question;
use crate::{Analyser, Mechanism, Tolerance};

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
    let (mut stable, mut unstable, mut complex, mut open, mut one_instant) = (0, 0, 0, [0; 2], 0);
    let (mut finder, mut found) = (Finder::new(1), Found::default());
    let (mut analyser, mut dense) = (Analyser::default(), Analyser::dense());
    let (gamma1, gamma2) = (Values::Even(0.05, 0.6), Values::Log(1e-3, 0.3));
    let ranges = Ranges { sites: [2, 12], gamma1, gamma2, ..Ranges::CONSERVATIVE };
    let mut lattices = [0; 2];
    for round in 0..3500 {
        let sites = 3 + random.below(30);
        let ring = Chain::new(sites, random.between(0.05, 0.6), random.log(1e-3, 0.3)).unwrap();
        let chain = if round < 1500 { ring } else { random.lattice(&ranges) };
        let model = Model::conservative(chain, random.between(0.6, 2.5), random.between(0.0, 0.8)).unwrap();
        let word = if round < 1500 { word(&mut random, sites) } else { random.word(&chain) };
        let Some(word) = word.filter(|word| word.places().len() > 1) else { continue };
        if finder.find_word(&model, &word, Wanted::Symmetric, &mut found).is_err() {
            continue;
        }
        for orbit in &found.orbits {
            let Ok(reference) = dense.stability(orbit, &mut finder, Tolerance::Rounding) else { continue };
            let reference = reference.verdict;
            let question = Question { orbit, tolerance: Tolerance::Rounding, thorough: false };
            let told = format!("{word} {model:?} {reference:?}");
            match analyser.by_inertia(question, &mut finder) {
                Ok((verdict, _)) => {
                    if reference.marginal {
                        continue;
                    }
                    assert_eq!((verdict.stable, verdict.mechanism), (reference.stable, reference.mechanism), "{told}");
                    let off = (verdict.growth() - reference.growth()).abs();
                    let room = verdict.resolution + 4.0 * reference.resolution + 1e-9 * verdict.growth();
                    assert!(off <= room, "{off:e} {verdict:?} {told}");
                    stable += usize::from(reference.stable);
                    unstable += usize::from(!reference.stable);
                    lattices[usize::from(!reference.stable)] += usize::from(!chain.is_ring());
                    one_instant += usize::from(word.instants().len() == 1);
                }
                Err(Failure::SecularError(SecularError::Incomplete { found, wanted })) => {
                    assert!(found < wanted, "{found} {wanted} {told}");
                    complex += usize::from(!reference.stable);
                    open[usize::from(!chain.is_ring())] += usize::from(reference.stable);
                }
                Err(_) => open[usize::from(!chain.is_ring())] += 1,
            }
        }
    }
    println!("{stable} {unstable} {complex} {open:?} {one_instant} {lattices:?}");
    assert!(lattices.iter().all(|&count| count > 100), "{lattices:?}");
    assert!(stable > 100 && unstable > 100 && one_instant > 5 && 5 * open[0] < stable + unstable);
    // Of two directions modes nearly coincide far more often.
    assert!(open[1] < lattices[0] + lattices[1], "{open:?}");
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

/// Complex multipliers, which a count leaves open, are found from a shorter ring or row; if not all are, that is said.
#[test]
fn complex_multipliers_of_long_rings_and_rows_are_settled() {
    let mut random = Random(8);
    // Of rings and of rows.
    let (mut settled, mut open) = ([0; 2], [0; 2]);
    let (mut finder, mut found) = (Finder::new(1), Found::default());
    let (mut analyser, mut dense) = (Analyser::default(), Analyser::dense());
    for round in 0..180 {
        let chain = Chain::new(160, random.between(0.4, 0.6), random.between(0.03, 0.1)).unwrap();
        let chain = chain.with_ends([Ends::Closed, Ends::Free, Ends::Fixed][round % 3]);
        let model = Model::conservative(chain, random.between(0.6, 1.4), random.between(0.0, 0.1)).unwrap();
        let word = random.of(&["0+1+2+,0-1-2-", "0+1-,0-1+", "0+1+3+,0-1-3-", "0+2-3+,0-2+3-"]).parse().unwrap();
        if finder.find_word(&model, &word, Wanted::Symmetric, &mut found).is_err() {
            continue;
        }
        for orbit in &found.orbits {
            let Ok(reference) = dense.verdict(orbit, &mut finder, Tolerance::Rounding) else { continue };
            if reference.mechanism != Some(Mechanism::NeimarkSacker) {
                continue;
            }
            let question = Question { orbit, tolerance: Tolerance::Rounding, thorough: false };
            match analyser.by_inertia(question, &mut finder) {
                Ok((verdict, _)) => {
                    let off = (verdict.growth() - reference.growth()).abs();
                    assert_eq!(verdict.mechanism, reference.mechanism, "{word} {model:?}");
                    assert!(off <= verdict.resolution + 1e-10, "{off:e} {verdict:?} {reference:?} {word} {model:?}");
                    settled[usize::from(!chain.is_ring())] += 1;
                }
                Err(_) => open[usize::from(!chain.is_ring())] += 1,
            }
        }
    }
    // A breather at an end of a row meets waves at frequencies that the row's own length has, which a shorter row does not tell.
    assert!(settled[0] > 8 && settled[1] > 3 && open[0] < settled[0], "{settled:?} {open:?}");
}
