//! Orbits with a symmetry that needs fewer unknowns, followed among themselves.
//!
//! Where a mirror of the structure exchanges impacts, at once or half a period later, these have one impulse and one time for each pair: without loads
//! and losses the times of masses that hardly feel each other are all but free. Orbits that are their own mirror images in time, with all impacts at 0
//! and half a period later, have no unknown times, and Newton's laws hold by themselves: so their branch passes where others leave it.

use smallvec::{SmallVec, smallvec};

use crate::equations::linear::{Matrix, Vector};
use crate::orbit::time_between;
use crate::structures::equations::{Equations, System};
use crate::structures::orbit::{StructureImpact, StructureOrbit};

/// Times and impulses that agree to this part are images of each other.
pub(super) const IMAGE: f64 = 1e-8;

/// Rows of the equations that differ by no more than this part of their terms are images of each other: some roundings.
const ALIKE: f64 = 1e-13;

/// The same of their slopes, as parts of the largest of a row.
const SLOPES: f64 = 1e-12;

/// Which unknowns a coordinate moves, and which rows are asked for.
#[derive(Debug, Clone)]
pub(super) struct Twins {
    /// The image of each impact, another one or itself.
    images: Vec<usize>,
    /// Images come half a period later.
    are_later: bool,
    /// Whether each impact is half a period after the first one, where all are there or at 0.
    halves: Option<Vec<bool>>,
    columns: Vec<SmallVec<[usize; 2]>>,
    rows: Vec<usize>,
    /// Rows that hold by themselves.
    held: Vec<usize>,
}

impl Twins {
    /// Those of an orbit, as far as its impacts show, the fewest unknowns first: none where no mirror, of space or time, spares one.
    pub(super) fn of(orbit: &StructureOrbit, equations: &Equations<'_>) -> Vec<Self> {
        let n = orbit.impacts().len();
        if equations.has_time() || !equations.rigid.is_empty() || n < 2 {
            return Vec::new();
        }
        let halves = || equations.are_halves(orbit.impacts().iter().map(|impact| impact.time));
        let exchanged = || [false, true].into_iter().find_map(|later| Some((later, images(orbit, later)?)));
        let all = [(exchanged(), halves()), (None, halves()), (exchanged(), None)];
        let some = all.into_iter().filter(|(exchanged, halves)| exchanged.is_some() || halves.is_some());
        some.map(|(exchanged, halves)| {
            let (are_later, images) = exchanged.unwrap_or_else(|| (false, (0..n).collect()));
            Self::with(equations, (are_later, images), halves)
        })
        .collect()
    }

    fn with(equations: &Equations<'_>, (are_later, images): (bool, Vec<usize>), halves: Option<Vec<bool>>) -> Self {
        let n = images.len();
        let firsts: Vec<usize> = (0..n).filter(|&i| images[i] >= i).collect();
        let both =
            |i: usize| -> SmallVec<[usize; 2]> { if images[i] == i { smallvec![i] } else { smallvec![i, images[i]] } };
        let mut columns: Vec<_> = firsts.iter().map(|&i| both(i)).collect();
        let (mut rows, mut held) = (firsts.clone(), Vec::new());
        if halves.is_some() {
            held.extend((0..n).filter_map(|i| equations.row_of_law(n, i)));
        } else {
            let times = firsts.iter().filter(|&&i| i > 0);
            columns.extend(times.map(|&i| both(i).into_iter().map(|j| n + j - 1).collect()));
            let laws = firsts.iter().filter(|&&i| !both(i).contains(&equations.left_out));
            rows.extend(laws.filter_map(|&i| equations.row_of_law(n, i)));
        }
        Self { images, are_later, halves, columns, rows, held }
    }

    /// Whether the images of places, and of their slopes by impulses, are what they are images of, and laws hold by themselves, at a point that is
    /// its own image.
    pub(super) fn are_kept_by(&self, system: &System) -> bool {
        let n = self.images.len();
        let image = |i: usize| self.images[i];
        self.held.iter().all(|&i| system.rows[i].abs() <= ALIKE * system.sizes[i])
            && (0..n).all(|i| {
                let (row, other) = (system.jacobian.row(i), system.jacobian.row(image(i)));
                let length = row[..n].iter().map(|entry| entry.abs()).fold(0.0, f64::max);
                (system.rows[i] - system.rows[image(i)]).abs() <= ALIKE * system.sizes[i]
                    && (0..n).all(|j| (row[j] - other[image(j)]).abs() <= SLOPES * length)
            })
    }

    /// Number of coordinates.
    pub(super) fn size(&self) -> usize {
        self.columns.len()
    }

    /// The first unknown that each coordinate moves.
    pub(super) fn leading(&self) -> impl Iterator<Item = usize> + '_ {
        self.columns.iter().map(|column| column[0])
    }

    /// All unknowns from coordinates.
    pub(super) fn expand(&self, z: &[f64], period: f64) -> Vector {
        let n = self.images.len();
        let mut full: Vector = std::iter::repeat_n(0.0, 2 * n - 1).collect();
        for (column, value) in self.columns.iter().zip(z) {
            column.iter().for_each(|&i| full[i] = *value);
        }
        if let Some(halves) = &self.halves {
            let times = halves.iter().skip(1).map(|&half| if half { 0.5 * period } else { 0.0 });
            full[n..].iter_mut().zip(times).for_each(|(time, own)| *time = own);
            return full;
        }
        for (i, &image) in self.images.iter().enumerate().filter(|(i, image)| *image > i) {
            let own = if i == 0 { 0.0 } else { full[n + i - 1] };
            full[n + image - 1] = if self.are_later { (own + 0.5 * period).rem_euclid(period) } else { own };
        }
        full
    }

    pub(super) fn rows(&self, full: &[f64]) -> Vector {
        self.rows.iter().map(|&i| full[i]).collect()
    }

    pub(super) fn matrix(&self, full: &Matrix) -> Matrix {
        Matrix::from_fn(self.size(), |i, j| self.columns[j].iter().map(|&k| full[(self.rows[i], k)]).sum())
    }
}

/// The impact of another contact that is the image of each one; `None` where one has none.
fn images(orbit: &StructureOrbit, later: bool) -> Option<Vec<usize>> {
    let (impacts, period) = (orbit.impacts(), orbit.period());
    let lapse = if later { 0.5 * period } else { 0.0 };
    let alike = |one: &StructureImpact, other: &StructureImpact| {
        one.contact != other.contact
            && one.barrier == other.barrier
            && time_between(one.time + lapse, other.time, period) <= IMAGE * period
            && (one.impulse - other.impulse).abs() <= IMAGE * one.impulse.abs()
    };
    let all: Option<Vec<usize>> =
        impacts.iter().map(|one| (0..impacts.len()).find(|&j| alike(one, &impacts[j]))).collect();
    let all = all?;
    // In pairs, and contacts as they do.
    let contact = |i: usize| impacts[i].contact;
    let pairs = (0..all.len()).all(|i| {
        all[all[i]] == i && (0..all.len()).all(|j| contact(i) != contact(j) || contact(all[i]) == contact(all[j]))
    });
    pairs.then_some(all)
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use vibrochain_lattice::{Chain, Model, Stop};

    use super::*;
    use crate::orbit::Hit;
    use crate::search::finder::{Finder, OrbitList, Scope};
    use crate::structures::branch::continuation::{Continuation, ModelFamily};
    use crate::structures::model::StructureModel;
    use crate::tracer::system::System;

    /// Two masses that hit together, and later: half of the unknowns are left, unless what varies tells the two from each other, by however little.
    #[test]
    fn mirror_images_are_followed_together_as_long_as_nothing_tells_them_apart() {
        let model = Model::conservative(Chain::new(5, 0.2, 0.05).unwrap(), 1.5, 0.2).unwrap();
        let (mut finder, mut found) = (Finder::new(5), OrbitList::default());
        for (word, left) in [("0+1+,0-1-", 2), ("0+2-,0-2+", 2), ("0+,0-", 2)] {
            finder.find_word(&model, &word.parse().unwrap(), Scope::All, &mut found).unwrap();
            let hits: Vec<Hit> = found.orbits[0].impacts().iter().map(Hit::from).collect();
            let masses: Vec<Vec<usize>> = (0..5).map(|mass| vec![mass]).collect();
            let size = |wider: f64| {
                let masses = masses.clone();
                let family: ModelFamily = Arc::new(move |values: &[f64]| {
                    let structure = model.structure(&masses).unwrap();
                    let mut stops = structure.contacts().to_vec();
                    stops[0].upper = stops[0].upper.map(|upper| upper + wider * values[0]);
                    Ok(StructureModel::new(Arc::new(structure.with_contacts(stops).unwrap()), 1.5).unwrap())
                });
                let at = family(&[0.0]).unwrap();
                let strikes = hits.iter().map(|hit| at.strike(hit).unwrap()).collect();
                let start = StructureOrbit::given(&at, (1, 0.0), strikes).unwrap();
                let stop = Stop::default();
                Continuation::through(&start, family, &[0.0], &[1.0], &stop).unwrap().size()
            };
            // Each orbit is its own mirror image in time: no time is unknown.
            assert_eq!([size(0.0), size(1e-3)], [left, hits.len()], "{word}");
        }
    }
}
