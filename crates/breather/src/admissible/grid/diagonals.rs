//! What pulls at the contacts of a structure, by diagonals: neighbours are next to each other in most lists.

use vibrochain_lattice::simd::lanes::{LANES, Lane, ZERO, four};
use wide::f64x4;

/// Diagonals at most: with more, modes tell accelerations as soon.
const MOST: usize = 8;

/// A matrix by its diagonals: column less row, and an entry a row, in groups.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Diagonals {
    list: Vec<(isize, Vec<Lane>)>,
}

impl Diagonals {
    /// Of so many groups of rows, by rows, columns and entries, which add up; `None` where there are many diagonals.
    pub(crate) fn new(groups: usize, entries: impl Iterator<Item = (usize, usize, f64)>) -> Option<Self> {
        let mut list: Vec<(isize, Vec<Lane>)> = Vec::new();
        for (row, column, entry) in entries {
            let off = column as isize - row as isize;
            let place = list.iter().position(|(known, _)| *known == off).unwrap_or(list.len());
            if place == MOST {
                return None;
            }
            if place == list.len() {
                list.push((off, vec![[0.0; LANES]; groups]));
            }
            list[place].1[row / LANES][row % LANES] += entry;
        }
        Some(Self { list })
    }

    /// The matrix times a column, each sum as `finish` has it; `between` is work space.
    pub(crate) fn act(
        &self,
        column: &[Lane],
        between: &mut Vec<f64>,
        finish: impl Fn(f64x4) -> f64x4,
        out: &mut [Lane],
    ) {
        self.sums(column, between, |entry| entry, finish, out);
    }

    /// A bound of that by bounds of the column's moduli.
    pub(crate) fn bound(&self, column: &[Lane], between: &mut Vec<f64>, out: &mut [Lane]) {
        self.sums(column, between, f64x4::abs, |sum| sum, out);
    }

    #[inline]
    fn sums(
        &self,
        column: &[Lane],
        between: &mut Vec<f64>,
        of: impl Fn(f64x4) -> f64x4,
        finish: impl Fn(f64x4) -> f64x4,
        out: &mut [Lane],
    ) {
        let count = column.len() * LANES;
        if between.len() != 3 * count {
            between.clear();
            between.resize(3 * count, 0.0);
        }
        let middle = between[count..2 * count].as_chunks_mut::<LANES>().0;
        middle.iter_mut().zip(column).for_each(|(slot, lane)| *slot = *lane);
        for (g, out) in out.iter_mut().enumerate() {
            let mut sum = ZERO;
            for (off, entries) in &self.list {
                let from = (count + g * LANES).wrapping_add_signed(*off);
                if let Some(values) = between.get(from..).and_then(|rest| rest.first_chunk::<LANES>()) {
                    sum += of(four(entries[g])) * four(*values);
                }
            }
            *out = finish(sum).to_array();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// As a sum over all entries has it; entries of one place add up.
    #[test]
    fn diagonals_are_the_matrix() {
        let mut random = fastrand::Rng::with_seed(5);
        for groups in 1..4 {
            let size = groups * LANES - 1;
            let mut dense = vec![vec![0.0; size]; size];
            let mut entries = Vec::new();
            for (row, dense) in dense.iter_mut().enumerate() {
                for off in [0_isize, 1, -1, 2, 0] {
                    if let Some(column) = row.checked_add_signed(off).filter(|column| *column < size) {
                        let entry = random.f64() - 0.5;
                        dense[column] += entry;
                        entries.push((row, column, entry));
                    }
                }
            }
            let diagonals = Diagonals::new(groups, entries.into_iter()).unwrap();
            let mut column = vec![[0.0; LANES]; groups];
            column.as_flattened_mut()[..size].iter_mut().for_each(|slot| *slot = random.f64() - 0.5);
            let (mut between, mut out, mut most) = (Vec::new(), column.clone(), column.clone());
            diagonals.act(&column, &mut between, |sum| -sum, &mut out);
            let moduli: Vec<Lane> = column.iter().map(|lane| lane.map(f64::abs)).collect();
            diagonals.bound(&moduli, &mut between, &mut most);
            for (row, dense) in dense.iter().enumerate() {
                let sum: f64 = dense.iter().zip(column.as_flattened()).map(|(entry, x)| entry * x).sum();
                assert!((out.as_flattened()[row] + sum).abs() < 1e-15);
                assert!(most.as_flattened()[row] >= sum.abs());
            }
        }
    }

    #[test]
    fn a_full_matrix_has_no_diagonals() {
        assert!(Diagonals::new(2, (0..64).map(|n| (n / 8, n % 8, 1.0))).is_none());
    }
}
