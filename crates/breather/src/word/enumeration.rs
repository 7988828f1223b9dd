//! Words of two instants on a few neighbouring sites, each of which hits as a family does, up to symmetry.

use vibrochain_lattice::{Barrier, Ends, Layout, Model};

use crate::orbit::Family;
use crate::word::{Letter, Word, WordError};

impl Word {
    /// All words of `sites_used` masses, in whatever layer, the farthest `reach` sites apart at most, each of which hits as one of
    /// `families` does, at two instants in all: in their canonical forms, in order. A double-sided site may be on its upper barrier at either instant, a
    /// single-sided one hits at either.
    ///
    /// # Errors
    /// [`WordError::TooMany`] for words that would be too long.
    ///
    /// ```
    /// use vibrochain_breather::{Family, Word};
    /// use vibrochain_lattice::{Chain, Model};
    /// let model = Model::conservative(Chain::new(21, 0.2, 0.05)?, 1.5, 0.2)?;
    /// let pairs = Word::enumerate(&model, 2, 2, &[Family::DoubleSided])?;
    /// let written: Vec<String> = pairs.iter().map(Word::to_string).collect();
    /// assert_eq!(written, ["0+1+,0-1-", "0+1-,0-1+", "0+2+,0-2-", "0+2-,0-2+"]);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn enumerate(
        model: &Model,
        sites_used: usize,
        reach: usize,
        families: &[Family],
    ) -> Result<Vec<Self>, WordError> {
        let (mut words, layout) = (Vec::new(), model.chain().layout());
        let (ways, reach) = (ways(families), reach.min(layout.length.saturating_sub(1)));
        // In a closed row a word may begin anywhere: at site 0.
        let starts = if layout.ends == Ends::Closed { 0..1 } else { 0..layout.length };
        let chosen = choices(sites_used, reach, layout.layers);
        let sets = starts.flat_map(|start| chosen.iter().map(move |places| (start, places)));
        for (start, places) in
            sets.filter(|(start, places)| places.last().is_some_and(|(site, _)| start + site < layout.length))
        {
            for chosen in combinations(vec![ways.len(); places.len()]) {
                let mut instants = [Vec::new(), Vec::new()];
                for (&(site, layer), &way) in places.iter().zip(&chosen) {
                    let site = start + site;
                    for (instant, barrier) in instants.iter_mut().zip(ways.get(way).copied().unwrap_or_default()) {
                        instant.extend(barrier.map(|barrier| Letter { site, layer, barrier }));
                    }
                }
                let instants: Vec<_> = instants.into_iter().filter(|letters| !letters.is_empty()).collect();
                if !instants.is_empty() {
                    words.push(Self::new(instants)?.canonical(model));
                }
            }
        }
        words.sort();
        words.dedup();
        Ok(words)
    }

    /// How many words [`Word::enumerate`] looks at before symmetry makes them fewer.
    pub fn combinations(layout: &Layout, sites_used: usize, reach: usize, families: &[Family]) -> f64 {
        let of = |places: usize, count: usize| {
            if count > places { 0.0 } else { (0..count).map(|i| (places - i) as f64 / (i + 1) as f64).product::<f64>() }
        };
        // So many at the first site, the others beyond it.
        let (first, others) = (layout.layers, reach.saturating_mul(layout.layers));
        let sets: f64 = (1..=sites_used.min(first)).map(|at| of(first, at) * of(others, sites_used - at)).sum();
        let starts = if layout.ends == Ends::Closed { 1.0 } else { layout.length as f64 };
        starts * sets * (ways(families).len() as f64).powi(i32::try_from(sites_used).unwrap_or(i32::MAX))
    }
}

/// One of each: all choices of a number below each of `sizes`, the first number changing fastest.
pub(crate) fn combinations(sizes: Vec<usize>) -> impl Iterator<Item = Vec<usize>> {
    let first = sizes.iter().all(|&size| size > 0).then(|| vec![0; sizes.len()]);
    std::iter::successors(first, move |choice| {
        let mut next = choice.clone();
        for (number, &size) in next.iter_mut().zip(&sizes) {
            *number += 1;
            if *number < size {
                return Some(next);
            }
            *number = 0;
        }
        None
    })
}

/// What a site may do at the two instants.
fn ways(families: &[Family]) -> Vec<[Option<Barrier>; 2]> {
    let (lower, upper) = (Some(Barrier::Lower), Some(Barrier::Upper));
    let of = |family: &Family| match family {
        Family::DoubleSided => vec![[upper, lower], [lower, upper]],
        Family::SingleSided => vec![[lower, None], [None, lower]],
        Family::PeriodDoubled | Family::Word => Vec::new(),
    };
    families.iter().flat_map(of).collect()
}

/// All sets of `count` masses, as site and layer, at sites 0 to `reach`, at least one of them at site 0; rising.
fn choices(count: usize, reach: usize, layers: usize) -> Vec<Vec<(usize, usize)>> {
    let places = (reach + 1) * layers;
    if count == 0 || count > places {
        return Vec::new();
    }
    let mut all = Vec::new();
    let mut chosen: Vec<usize> = (0..count).collect();
    while chosen[0] < layers {
        all.push(chosen.iter().map(|place| (place / layers, place % layers)).collect());
        // The last one that can move on, and all behind it as close as they can be.
        let Some(i) = (0..count).rev().find(|&i| chosen[i] < places + i - count) else { break };
        chosen[i] += 1;
        (i + 1..count).for_each(|j| chosen[j] = chosen[j - 1] + 1);
    }
    all
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use vibrochain_lattice::Chain;

    use super::*;

    /// Against all words of a small lattice, made by hand of every barrier at every site and instant.
    #[test]
    fn every_word_is_listed_once() {
        let both = [Family::DoubleSided, Family::SingleSided];
        let ring = Chain::new(7, 0.2, 0.05).unwrap();
        let square = Chain::new(3, 0.2, 0.05).unwrap().with_layers(2, 0.1, Ends::Free).unwrap();
        for (chain, least) in
            [(ring, 50), (ring.with_ends(Ends::Free), 300), (square, 50), (square.with_ends(Ends::Fixed), 100)]
        {
            let (model, sites) = (Model::conservative(chain, 1.5, 0.2).unwrap(), chain.sites());
            let listed = Word::enumerate(&model, 3, chain.length() - 1, &both).unwrap();
            let mut all = BTreeSet::new();
            for code in 0..5_usize.pow(sites as u32) {
                let way = |n: usize| code / 5_usize.pow(n as u32) % 5;
                if (0..sites).filter(|&n| way(n) > 0).count() != 3 {
                    continue;
                }
                let mut instants = vec![Vec::new(), Vec::new()];
                for n in 0..sites {
                    let (site, layer) = chain.layout().place(n);
                    let at = |instant: &mut Vec<Letter>, barrier| instant.push(Letter { site, layer, barrier });
                    match way(n) {
                        1 => at(&mut instants[0], Barrier::Lower),
                        2 => at(&mut instants[1], Barrier::Lower),
                        3 => {
                            at(&mut instants[0], Barrier::Upper);
                            at(&mut instants[1], Barrier::Lower);
                        }
                        4 => {
                            at(&mut instants[0], Barrier::Lower);
                            at(&mut instants[1], Barrier::Upper);
                        }
                        _ => {}
                    }
                }
                instants.retain(|letters| !letters.is_empty());
                all.insert(Word::new(instants).unwrap().canonical(&model));
            }
            assert!(all.len() > least, "{chain}: {}", all.len());
            assert_eq!(listed, all.into_iter().collect::<Vec<_>>(), "{chain}");
        }
        let layout = Layout::ring(7);
        assert_eq!(Word::combinations(&layout, 3, 6, &both), 15.0 * 64.0);
        assert_eq!(choices(3, 6, 1).len(), 15);
        assert_eq!(Word::combinations(&square.layout(), 3, 2, &both), choices(3, 2, 2).len() as f64 * 64.0);
        let listed: Vec<_> = combinations(vec![2, 1, 2]).collect();
        assert_eq!(listed, [[0, 0, 0], [1, 0, 0], [0, 0, 1], [1, 0, 1]]);
        assert_eq!((combinations(vec![3, 0]).count(), combinations(Vec::new()).count()), (0, 1));
        assert!(choices(4, 2, 1).is_empty() && choices(1, 3, 1) == [[(0, 0)]]);
        // What has no room, or no end.
        assert_eq!(Word::combinations(&layout, 4, 2, &both) + Word::combinations(&layout, 0, 2, &both), 0.0);
        assert!(Word::combinations(&layout, 3, usize::MAX, &both) > 1e30);
    }
}
