//! All impact words of a few neighbouring sites, up to symmetry.

use vibrochain_lattice::{Barrier, Model};

use crate::orbit::Family;
use crate::word::{Letter, Word, WordError};

impl Word {
    /// All words of `sites_used` sites, the farthest `reach` apart at most, each of which hits as one of `families` does, at two
    /// instants in all: in their canonical forms, in order. A double-sided site may be on its upper barrier at either instant, a
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
        let mut words = Vec::new();
        for sites in choices(sites_used, reach.min(model.chain().sites().saturating_sub(1))) {
            let ways = ways(families);
            for chosen in combinations(vec![ways.len(); sites.len()]) {
                let mut instants = [Vec::new(), Vec::new()];
                for (&site, &way) in sites.iter().zip(&chosen) {
                    for (instant, barrier) in instants.iter_mut().zip(ways.get(way).copied().unwrap_or_default()) {
                        instant.extend(barrier.map(|barrier| Letter::new(site, barrier)));
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
    pub fn combinations(sites_used: usize, reach: usize, families: &[Family]) -> f64 {
        if sites_used == 0 || sites_used - 1 > reach {
            return 0.0;
        }
        let sets: f64 = (1..sites_used).map(|i| (reach - (i - 1)) as f64 / i as f64).product();
        sets * (ways(families).len() as f64).powi(i32::try_from(sites_used).unwrap_or(i32::MAX))
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

/// Site 0 and `count` − 1 others up to `reach`, rising.
fn choices(count: usize, reach: usize) -> Vec<Vec<usize>> {
    if count == 0 || count > reach + 1 {
        return Vec::new();
    }
    let mut all = Vec::new();
    let mut sites: Vec<usize> = (0..count).collect();
    loop {
        all.push(sites.clone());
        // The last site that can move on, and all behind it as close as they can be.
        let Some(i) = (1..count).rev().find(|&i| sites[i] < reach + 1 + i - count) else { return all };
        sites[i] += 1;
        (i + 1..count).for_each(|j| sites[j] = sites[j - 1] + 1);
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use vibrochain_lattice::Chain;

    use super::*;

    /// Against all words of a small ring, made by hand of every barrier at every site and instant.
    #[test]
    fn every_word_is_listed_once() {
        let model = Model::conservative(Chain::new(7, 0.2, 0.05).unwrap(), 1.5, 0.2).unwrap();
        let both = [Family::DoubleSided, Family::SingleSided];
        let listed = Word::enumerate(&model, 3, 6, &both).unwrap();
        let mut all = BTreeSet::new();
        for code in 0..5_usize.pow(7) {
            let way = |site: u32| code / 5_usize.pow(site) % 5;
            if (0..7).filter(|&site| way(site) > 0).count() != 3 {
                continue;
            }
            let mut instants = vec![Vec::new(), Vec::new()];
            for site in 0..7 {
                let at = |instant: &mut Vec<Letter>, barrier| instant.push(Letter::new(site as usize, barrier));
                match way(site) {
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
        assert!(all.len() > 50);
        assert_eq!(listed, all.into_iter().collect::<Vec<_>>());
        assert_eq!(Word::combinations(3, 6, &both), 15.0 * 64.0);
        assert_eq!(choices(3, 6).len(), 15);
        let listed: Vec<_> = combinations(vec![2, 1, 2]).collect();
        assert_eq!(listed, [[0, 0, 0], [1, 0, 0], [0, 0, 1], [1, 0, 1]]);
        assert_eq!((combinations(vec![3, 0]).count(), combinations(Vec::new()).count()), (0, 1));
        assert!(choices(4, 2).is_empty() && choices(1, 3) == [[0]]);
        // What has no room, or no end.
        assert_eq!(Word::combinations(4, 2, &both) + Word::combinations(0, 2, &both), 0.0);
        assert!(Word::combinations(3, usize::MAX, &both) > 1e30);
    }
}
