//! Orbits with a symmetry, followed among themselves.

use smallvec::{SmallVec, smallvec};

use crate::equations::linear::{Matrix, USUAL, Vector};
use crate::equations::unknowns::Unknowns;
use crate::orbit::Orbit;
use crate::orbit::symmetries::symmetries;

/// Closer to half the period than this a double-sided orbit is the symmetric one.
pub(crate) const SYMMETRIC: f64 = 1e-10;

/// Unknowns that one coordinate moves, each with its factor.
type Moves = SmallVec<[(usize, f64); 2]>;

/// Below this a row of small whole numbers is one of zeros, and beyond it parts of a period differ.
const ROUNDING: f64 = 1e-9;

/// Times of impacts that symmetry ties to others, but for the motions it leaves, are at such a part of the period.
const PARTS: f64 = 120.0;

/// Which unknowns are free and which equations are asked for. Those of an orbit of two impacts under a force stand as
/// P₀, P₁, s, t₁, ψ and as position 0, position 1, net impulse, Newton 0, Newton 1.
///
/// - Without symmetry: all of them.
/// - Words, as masses side by side have it: whatever symmetry of the lattice, perhaps later or in reversed time, the impacts have.
#[derive(Debug, Clone)]
pub(crate) struct Reduction {
    columns: SmallVec<[Moves; USUAL]>,
    rows: SmallVec<[usize; USUAL]>,
    /// What unknown times have beside their moves, in periods of the orbit.
    turns: SmallVec<[(usize, f64); 2]>,
    /// ψ in periods of the force, where symmetry holds it.
    pub(crate) psi: Option<f64>,
}

impl Reduction {
    /// All unknowns free.
    pub(crate) fn none(unknowns: &Unknowns) -> Self {
        let all = 0..unknowns.size();
        let columns = all.clone().map(|i| -> Moves { smallvec![(i, 1.0)] }).collect();
        Self { columns, rows: all.collect(), turns: SmallVec::new(), psi: None }
    }

    /// Orbits with all the symmetry that the impacts of `orbit` have.
    pub(crate) fn of_word(orbit: &Orbit, unknowns: &Unknowns) -> Self {
        let (n, group) = (unknowns.impacts, symmetries(orbit));
        let one = |i: usize| -> Moves { smallvec![(i, 1.0)] };
        let first_of = |i: usize| group.iter().map(|symmetry| symmetry.images[i]).min().unwrap_or(i);
        let firsts: SmallVec<[usize; USUAL]> = (0..n).filter(|&i| first_of(i) == i).collect();
        let mut reduction = Self::none(unknowns);
        reduction.columns = (firsts.iter())
            .map(|&first| (0..n).filter(|&i| first_of(i) == first).map(|i| (i, 1.0)).collect())
            .collect();
        reduction.columns.push(one(n));
        reduction.rows = firsts.iter().copied().collect();
        reduction.rows.push(n);
        if unknowns.times().next().is_some() {
            reduction.tie_times(orbit, unknowns);
        }
        reduction.columns.extend(unknowns.psi().map(one));
        let reversible = group.iter().any(|symmetry| symmetry.reversed);
        for &first in &firsts {
            // Newton's law changes its sign with time, and so holds by itself for an impact that is its own mirror image.
            if group.iter().any(|symmetry| symmetry.reversed && symmetry.images[first] == first) {
                continue;
            }
            let rows: SmallVec<[Option<usize>; USUAL]> =
                group.iter().map(|symmetry| unknowns.newton(symmetry.images[first])).collect();
            // Where one law follows from all others, that is so of the laws that are alike.
            if reversible || rows.iter().all(Option::is_some) {
                reduction.rows.extend(rows.into_iter().flatten().next());
            }
        }
        if reduction.columns.len() == reduction.rows.len() { reduction } else { Self::none(unknowns) }
    }

    /// Columns of the times that symmetry leaves free: those of t_σ(i) = t_σ(0) ± t_i for all symmetries σ, by elimination.
    fn tie_times(&mut self, orbit: &Orbit, unknowns: &Unknowns) {
        let (n, conservative) = (unknowns.impacts, orbit.model().is_conservative());
        // Rows in which one time, the pivot, is 1 and no other row's pivot is there; the first impact's time is 0.
        let mut ties: Vec<(usize, Vec<f64>)> = Vec::new();
        let mut tie = |mut row: Vec<f64>| {
            row[0] = 0.0;
            for (pivot, other) in &ties {
                let factor = row[*pivot];
                row.iter_mut().zip(other).for_each(|(entry, other)| *entry -= factor * other);
            }
            let Some(pivot) = (1..n).rev().find(|&i| row[i].abs() > ROUNDING) else { return };
            let head = row[pivot];
            row.iter_mut().for_each(|entry| *entry /= head);
            for (_, other) in &mut ties {
                let factor = other[pivot];
                other.iter_mut().zip(&row).for_each(|(entry, row)| *entry -= factor * row);
            }
            ties.push((pivot, row));
        };
        for symmetry in symmetries(orbit) {
            let home = symmetry.images[0];
            for (i, &image) in symmetry.images.iter().enumerate() {
                let mut row = vec![0.0; n];
                row[image] += 1.0;
                row[home] -= 1.0;
                row[i] -= if symmetry.reversed { -1.0 } else { 1.0 };
                tie(row);
            }
            if !conservative {
                // Later by whole periods of the force.
                let mut row = vec![0.0; n];
                row[home] = 1.0;
                tie(row);
            }
        }
        let turn = |i: usize| orbit.impacts()[i].time / orbit.period();
        let free = |i: &usize| ties.iter().all(|(pivot, _)| pivot != i);
        for column in (1..n).filter(free) {
            let mut moves: Moves = unknowns.time(column).map(|place| (place, 1.0)).into_iter().collect();
            for (pivot, row) in ties.iter().filter(|(_, row)| row[column].abs() > ROUNDING) {
                moves.extend(unknowns.time(*pivot).map(|place| (place, -row[column])));
            }
            self.columns.push(moves);
        }
        for (pivot, row) in &ties {
            let tied: f64 = (1..n).filter(free).map(|i| row[i] * turn(i)).sum();
            let rest = turn(*pivot) + tied;
            let part = (rest * PARTS).round() / PARTS;
            let rest = if (rest - part).abs() <= ROUNDING { part } else { rest };
            self.turns.extend(unknowns.time(*pivot).map(|place| (place, rest)));
        }
    }

    /// Number of coordinates.
    pub(crate) fn size(&self) -> usize {
        self.columns.len()
    }

    /// The first unknown that a coordinate moves.
    pub(crate) fn leading(&self, coordinate: usize) -> usize {
        self.columns.get(coordinate).and_then(|column| column.first()).map_or(0, |entry| entry.0)
    }

    /// All unknowns from the free coordinates, with those that are fixed as in `full`.
    pub(crate) fn expand(&self, z: &[f64], period: f64, full: &mut Vector) {
        self.columns.iter().flatten().for_each(|&(i, _)| full[i] = 0.0);
        self.turns.iter().for_each(|&(i, turn)| full[i] = turn * period);
        for (column, z) in self.columns.iter().zip(z) {
            for &(i, factor) in column {
                full[i] += factor * z;
            }
        }
    }

    pub(crate) fn rows(&self, full: &[f64]) -> Vector {
        self.rows.iter().map(|&i| full[i]).collect()
    }

    pub(crate) fn matrix(&self, full: &Matrix) -> Matrix {
        Matrix::from_fn(self.size(), |i, j| {
            self.columns[j].iter().map(|&(k, factor)| factor * full[(self.rows[i], k)]).sum()
        })
    }
}
