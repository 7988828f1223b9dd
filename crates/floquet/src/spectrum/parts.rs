//! Symmetries of an orbit, read off J(z). Under each an eigenvector is even or odd, and multipliers of eigenvectors that differ in this pass each
//! other.
//!
//! A symmetry takes impact i to impact j at another contact, or half a period later: what happens to i in a period happens to j in that period
//! or in the next one. So U takes y_i to place j, times 1/z if it is the next one, and J(z)U = UJ(z). U² is 1, or 1/z where U goes on by half a
//! period; √z·U is a reflection then, and ±√z are multipliers of half a period.

use nalgebra::{Complex, DMatrix};
use vibrochain_breather::BlochEquations;

type C = Complex<f64>;

/// Times, as a part of the period, and entries of J, as a part of the largest, are alike up to this: an orbit that lacks the symmetry comes as
/// near only within the square of it from where it branches off.
const ALIKE: f64 = 1e-9;

/// The most contacts that are exchanged in all ways, 76 reflections; symmetries of more are not found.
const MOST_CONTACTS: usize = 6;

/// Where J is held against its image: on the circle, at no particular angle.
const ANGLE: f64 = 1.234;

/// Where a symmetry takes each impact, and whether that is in the next period.
#[derive(Debug, Clone)]
struct Image(Vec<(usize, bool)>);

impl Image {
    /// That of contacts that change places, half a period later or at once.
    fn of(equations: &BlochEquations, contacts: &[usize], is_later: bool) -> Option<Self> {
        let (impacts, since) = (equations.impacts(), equations.since_cut());
        let period = equations.kernel().period();
        let later = if is_later { 0.5 * period } else { 0.0 };
        let image = |i: usize| {
            let away = |j: usize| {
                let turns = (since[i] + later - since[j]) / period;
                (turns - turns.round()).abs()
            };
            let to = (0..impacts.len()).filter(|&j| impacts[j].contact == contacts[impacts[i].contact]);
            let to = to.min_by(|&a, &b| away(a).total_cmp(&away(b))).filter(|&j| away(j) <= ALIKE)?;
            Some((to, is_later && since[to] < since[i]))
        };
        (0..impacts.len()).map(image).collect::<Option<_>>().map(Self)
    }

    /// J(z)U = UJ(z), given J by rows.
    fn keeps(&self, matrix: &[C], z: C) -> bool {
        let size = 2 * self.0.len();
        let place = |r: usize| 2 * self.0[r / 2].0 + r % 2;
        let factor = |r: usize| if self.0[r / 2].1 { z.inv() } else { C::new(1.0, 0.0) };
        let largest = matrix.iter().map(|entry| entry.norm()).fold(0.0, f64::max);
        let off = |r: usize, c: usize| {
            (matrix[place(r) * size + place(c)] * factor(c) - matrix[r * size + c] * factor(r)).norm()
        };
        (0..size).all(|r| (0..size).all(|c| off(r, c) <= ALIKE * largest))
    }

    fn after(&self, other: &[usize]) -> Vec<usize> {
        other.iter().map(|&i| self.0[i].0).collect()
    }

    fn places(&self) -> Vec<usize> {
        self.0.iter().map(|(to, _)| *to).collect()
    }
}

/// Reflections that commute, none a product of others.
#[derive(Debug, Clone, Default)]
pub(super) struct Parts {
    mirrors: Vec<Image>,
    /// One that goes on by half a period.
    shift: Option<Image>,
}

impl Parts {
    pub(super) fn of(equations: &BlochEquations) -> Self {
        let mut parts = Self::default();
        let contacts = equations.kernel().contacts();
        if contacts > MOST_CONTACTS {
            return parts;
        }
        let (z, mut matrix) = (C::from_polar(1.0, ANGLE), None);
        for is_later in [false, true] {
            for swaps in involutions(contacts) {
                let Some(image) = Image::of(equations, &swaps, is_later) else { continue };
                let places = image.places();
                let commutes = |known: &Image| known.after(&places) == image.after(&known.places());
                let is_new = parts.shift.is_none() && parts.mirrors.iter().all(commutes) && !parts.have(&places);
                if is_new && image.keeps(matrix.get_or_insert_with(|| equations.matrix(z)), z) {
                    if is_later { parts.shift = Some(image) } else { parts.mirrors.push(image) }
                }
            }
        }
        parts
    }

    /// Whether some mirrors one after the other lead to the same places.
    fn have(&self, places: &[usize]) -> bool {
        let all: Vec<usize> = (0..places.len()).collect();
        (0..1_u32 << self.mirrors.len()).any(|product| {
            let mirrors = self.mirrors.iter().enumerate().filter(|(k, _)| product >> k & 1 == 1);
            mirrors.fold(all.clone(), |places, (_, mirror)| mirror.after(&places)) == places
        })
    }

    /// How many reflections there are, the one by half a period the last.
    pub(super) fn count(&self) -> usize {
        self.mirrors.len() + usize::from(self.shift.is_some())
    }

    pub(super) fn have_shift(&self) -> bool {
        self.shift.is_some()
    }

    /// What each reflection makes of columns, two rows for each impact.
    pub(super) fn reflected<'a>(&'a self, columns: &'a DMatrix<C>, z: C) -> impl Iterator<Item = DMatrix<C>> + 'a {
        let mirrors = self.mirrors.iter().map(|image| (image, C::new(1.0, 0.0)));
        mirrors.chain(self.shift.iter().map(move |image| (image, z.sqrt()))).map(move |(image, by)| {
            let mut reflected = DMatrix::zeros(columns.nrows(), columns.ncols());
            for r in 0..2 * image.0.len() {
                let (to, is_next) = image.0[r / 2];
                let factor = if is_next { by / z } else { by };
                for column in 0..columns.ncols() {
                    reflected[(2 * to + r % 2, column)] = columns[(r, column)] * factor;
                }
            }
            reflected
        })
    }
}

/// All ways in which some of `count` change places in pairs, none of them first.
fn involutions(count: usize) -> Vec<Vec<usize>> {
    let mut all = vec![(0..count).collect::<Vec<usize>>()];
    for i in 0..count {
        let known = all.len();
        for of in 0..known {
            for j in i + 1..count {
                if (all[of][i], all[of][j]) == (i, j) {
                    let mut more = all[of].clone();
                    more.swap(i, j);
                    all.push(more);
                }
            }
        }
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pairs_change_places_in_all_ways() {
        for (count, ways) in [1, 1, 2, 4, 10, 26, 76].into_iter().enumerate() {
            let mut all = involutions(count);
            assert!(all.iter().all(|one| (0..count).all(|i| one[one[i]] == i)));
            all.sort();
            all.dedup();
            assert_eq!(all.len(), ways);
        }
    }
}
