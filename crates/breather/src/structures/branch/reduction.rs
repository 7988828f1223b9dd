//! Orbits with a symmetry, which needs fewer unknowns, followed among themselves.
//!
//! Impacts that a symmetry exchanges have one impulse, and times of which one tells the other: without loads and losses the times of masses that hardly
//! feel each other are all but free. Where time runs backwards Newton's law holds by itself for impacts that are their own images; where that leaves no
//! time unknown, as with all impacts at 0 and half a period later, a branch passes the points at which others leave it.

use smallvec::{SmallVec, smallvec};

use crate::equations::linear::{Matrix, USUAL, Vector, zeros};
use crate::orbit::symmetries::Symmetry;
use crate::orbit::{Impact, time_between};
use crate::structures::equations::{Equations, System};
use crate::structures::orbit::ContactOrbit;

/// Times and impulses that agree to this part are images of each other.
pub(super) const IMAGE: f64 = 1e-8;

/// Rows of the equations that differ by no more than this part of their terms are images of each other: some roundings.
const ALIKE: f64 = 1e-13;

/// The same of their slopes, as parts of the largest of a row.
const SLOPES: f64 = 1e-12;

/// Unknowns that one coordinate moves, each with its factor.
type Moves = SmallVec<[(usize, f64); 2]>;

/// Below this a row of small whole numbers is one of zeros.
const ROUNDING: f64 = 1e-9;

/// Times that a symmetry ties to others, but for the motions it leaves, are at such a part of the period.
const PARTS: f64 = 120.0;

/// Which unknowns are free and which rows are asked for.
#[derive(Debug, Clone)]
pub(super) struct Reduction {
    group: SmallVec<[Symmetry; 4]>,
    /// Number of all unknowns.
    unknowns: usize,
    columns: SmallVec<[Moves; USUAL]>,
    /// What unknown times have beside their moves, in periods of the orbit.
    turns: SmallVec<[(usize, f64); 2]>,
    rows: SmallVec<[usize; USUAL]>,
    /// Rows that hold by themselves.
    held: SmallVec<[usize; 2]>,
}

impl Reduction {
    /// Those of an orbit, as far as its impacts show, the fewest unknowns first: none where no mirror, of space or time, spares one.
    pub(super) fn of(orbit: &ContactOrbit, equations: &Equations<'_>) -> Vec<Self> {
        let n = orbit.impacts().len();
        let halves = equations.are_halves(orbit.impacts().iter().map(|impact| impact.time));
        let reversal = halves.map(|_| Symmetry { images: (0..n).collect(), reversed: true });
        // Half a period later loads are others.
        let lapses = if equations.forced { &[false][..] } else { &[false, true] };
        let exchange = lapses.iter().find_map(|later| images(orbit, *later));
        let exchange = exchange.map(|images| Symmetry { images, reversed: false });
        let both = exchange.clone().filter(|_| reversal.is_some()).map(|one| Symmetry { reversed: true, ..one });
        let all = [[&exchange, &reversal, &both].map(Option::as_ref), [None, reversal.as_ref(), None]];
        let all = all.into_iter().chain([[exchange.as_ref(), None, None]]);
        all.filter_map(|group| Self::among(orbit, equations, group.into_iter().flatten().cloned())).collect()
    }

    /// Orbits with these symmetries of an orbit, which hold with each other; `None` where they spare no unknown.
    pub(super) fn among(
        orbit: &ContactOrbit,
        equations: &Equations<'_>,
        symmetries: impl Iterator<Item = Symmetry>,
    ) -> Option<Self> {
        let n = orbit.impacts().len();
        let identity = Symmetry { images: (0..n).collect(), reversed: false };
        let others = symmetries.filter(|one| *one != identity);
        let group: SmallVec<[Symmetry; 4]> = std::iter::once(identity.clone()).chain(others).collect();
        if group.len() == 1 || equations.self_excited || !equations.rigid.is_empty() {
            return None;
        }
        let first_of = |i: usize| group.iter().map(|symmetry| symmetry.images[i]).min().unwrap_or(i);
        let firsts: SmallVec<[usize; USUAL]> = (0..n).filter(|&i| first_of(i) == i).collect();
        let alike = |first: &usize| (0..n).filter(|&i| first_of(i) == *first).map(|i| (i, 1.0)).collect();
        let mut reduction = Self {
            unknowns: equations.unknowns(n),
            columns: firsts.iter().map(alike).collect(),
            turns: SmallVec::new(),
            rows: firsts.clone(),
            held: (0..n).filter(|&i| is_held_in(&group, i)).filter_map(|i| equations.row_of_law(n, i)).collect(),
            group,
        };
        reduction.tie_times(orbit, equations);
        reduction.columns.extend(equations.psi(n).map(|place| -> Moves { smallvec![(place, 1.0)] }));
        let reversible = reduction.group.iter().any(|symmetry| symmetry.reversed);
        for &first in firsts.iter().filter(|&&first| !is_held_in(&reduction.group, first)) {
            let rows: SmallVec<[Option<usize>; USUAL]> =
                reduction.group.iter().map(|symmetry| equations.row_of_law(n, symmetry.images[first])).collect();
            // Where one law follows from all others, that is so of the laws that are alike.
            if reversible || rows.iter().all(Option::is_some) {
                reduction.rows.extend(rows.into_iter().flatten().next());
            }
        }
        (reduction.columns.len() == reduction.rows.len()).then_some(reduction)
    }

    /// Columns of the times that symmetry leaves free: those of t_σ(i) = t_σ(0) ± t_i for all symmetries σ, by elimination.
    fn tie_times(&mut self, orbit: &ContactOrbit, equations: &Equations<'_>) {
        let n = orbit.impacts().len();
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
        for symmetry in &self.group {
            let home = symmetry.images[0];
            for (i, &image) in symmetry.images.iter().enumerate() {
                let mut row = vec![0.0; n];
                row[image] += 1.0;
                row[home] -= 1.0;
                row[i] -= if symmetry.reversed { -1.0 } else { 1.0 };
                tie(row);
            }
            if equations.forced {
                // Later by whole periods of the force.
                let mut row = vec![0.0; n];
                row[home] = 1.0;
                tie(row);
            }
        }
        let turn = |i: usize| orbit.impacts()[i].time / orbit.period();
        let free = |i: &usize| ties.iter().all(|(pivot, _)| pivot != i);
        for column in (1..n).filter(free) {
            let mut moves: Moves = equations.time(n, column).map(|place| (place, 1.0)).into_iter().collect();
            for (pivot, row) in ties.iter().filter(|(_, row)| row[column].abs() > ROUNDING) {
                moves.extend(equations.time(n, *pivot).map(|place| (place, -row[column])));
            }
            self.columns.push(moves);
        }
        for (pivot, row) in &ties {
            let tied: f64 = (1..n).filter(free).map(|i| row[i] * turn(i)).sum();
            let rest = turn(*pivot) + tied;
            let part = (rest * PARTS).round() / PARTS;
            let rest = if (rest - part).abs() <= IMAGE { part } else { rest };
            self.turns.extend(equations.time(n, *pivot).map(|place| (place, rest)));
        }
    }

    /// Whether the images of places, and of their slopes by impulses, are what they are images of, and laws hold by themselves, at a point that is
    /// its own image.
    pub(super) fn are_kept_by(&self, system: &System) -> bool {
        let n = system.arrivals.len();
        let same = |symmetry: &Symmetry, i: usize| {
            let image = |i: usize| symmetry.images[i];
            let (row, other) = (system.jacobian.row(i), system.jacobian.row(image(i)));
            let length = row[..n].iter().map(|entry| entry.abs()).fold(0.0, f64::max);
            (system.rows[i] - system.rows[image(i)]).abs() <= ALIKE * system.sizes[i]
                && (0..n).all(|j| (row[j] - other[image(j)]).abs() <= SLOPES * length)
        };
        self.held.iter().all(|&i| system.rows[i].abs() <= ALIKE * system.sizes[i])
            && self.group.iter().all(|symmetry| (0..n).all(|i| same(symmetry, i)))
    }

    /// Number of coordinates.
    pub(super) fn size(&self) -> usize {
        self.columns.len()
    }

    /// The first unknown that each coordinate moves.
    pub(super) fn leading(&self) -> impl Iterator<Item = usize> + '_ {
        self.columns.iter().filter_map(|column| column.first()).map(|entry| entry.0)
    }

    /// All unknowns from coordinates.
    pub(super) fn expand(&self, z: &[f64], period: f64) -> Vector {
        let mut full = zeros(self.unknowns);
        self.turns.iter().for_each(|&(i, turn)| full[i] = turn * period);
        for (column, value) in self.columns.iter().zip(z) {
            column.iter().for_each(|&(i, factor)| full[i] += factor * value);
        }
        full
    }

    pub(super) fn rows(&self, full: &[f64]) -> Vector {
        self.rows.iter().map(|&i| full[i]).collect()
    }

    pub(super) fn matrix(&self, full: &Matrix) -> Matrix {
        Matrix::from_fn(self.size(), |i, j| {
            self.columns[j].iter().map(|&(k, factor)| factor * full[(self.rows[i], k)]).sum()
        })
    }
}

/// Whether time runs backwards about an impact.
fn is_held_in(group: &[Symmetry], i: usize) -> bool {
    group.iter().any(|symmetry| symmetry.reversed && symmetry.images[i] == i)
}

/// The impact of another contact that is the image of each one, or at once the impact itself; `None` where one has none, or each is its own.
fn images(orbit: &ContactOrbit, later: bool) -> Option<Vec<usize>> {
    let (impacts, period) = (orbit.impacts(), orbit.period());
    let lapse = if later { 0.5 * period } else { 0.0 };
    let alike = |one: &Impact, other: &Impact| {
        one.site != other.site
            && one.barrier == other.barrier
            && time_between(one.time + lapse, other.time, period) <= IMAGE * period
            && (one.impulse - other.impulse).abs() <= IMAGE * one.impulse.abs()
    };
    let image = |i: usize| (0..impacts.len()).find(|&j| alike(&impacts[i], &impacts[j])).or((!later).then_some(i));
    let all: Vec<usize> = (0..impacts.len()).map(image).collect::<Option<_>>()?;
    // In pairs, and contacts as they do.
    let contact = |i: usize| impacts[i].site;
    let pairs = (0..all.len()).all(|i| {
        all[all[i]] == i && (0..all.len()).all(|j| contact(i) != contact(j) || contact(all[i]) == contact(all[j]))
    });
    let exchanges = all.iter().enumerate().any(|(i, image)| *image != i);
    (exchanges && pairs).then_some(all)
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use vibrochain_lattice::{Barrier, Chain, Model, Parameter, Stop};

    use super::*;
    use crate::orbit::symmetries::symmetries;
    use crate::orbit::{Hit, Orbit};
    use crate::search::finder::{Finder, Scope};
    use crate::search::orbit_list::OrbitList;
    use crate::structures::branch::continuation::{Branch, Continuation};
    use crate::structures::branch::family::ModelFamily;
    use crate::structures::model::LoadedStructure;
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
                    Ok(LoadedStructure::new(Arc::new(structure.with_contacts(stops).unwrap()), 1.5).unwrap())
                });
                let at = family(&[0.0]).unwrap();
                let strikes = hits.iter().map(|hit| at.strike(hit).unwrap()).collect();
                let start = ContactOrbit::given(&at, (1, 0.0), strikes).unwrap();
                let stop = Stop::default();
                Continuation::through(&start, family, &[0.0], &[1.0], &stop).unwrap().size()
            };
            // Each orbit is its own mirror image in time: no time is unknown.
            assert_eq!([size(0.0), size(1e-3)], [left, hits.len()], "{word}");
        }
    }
    /// What symmetry leaves free is counted by hand: each coordinate moves all impacts that it exchanges, and an orbit's own are where it is.
    #[test]
    fn of_impacts_with_a_symmetry_what_it_leaves_free_is_followed() {
        let chain = Chain::new(9, 0.2, 0.05).unwrap();
        let (quiet, forced) = (
            Model::conservative(chain, 1.5, 0.2).unwrap(),
            chain.point().omega(1.5).asymmetry(0.2).amplitude(0.1).restitution(0.9).model().unwrap(),
        );
        for (model, hits, left) in [
            // A pair: one impulse, and under a force its phase.
            (quiet, &[(0, 0.0), (2, 0.0)][..], 1),
            (forced, &[(0, 0.0), (2, 0.0)], 2),
            // A wave, forwards and, reflected, back.
            (quiet, &[(0, 0.0), (3, 1.0 / 3.0), (6, 2.0 / 3.0)], 1),
            // The one between hits twice, midway or at a time that is left free.
            (quiet, &[(0, 0.0), (1, 0.25), (2, 0.5), (1, 0.75)], 2),
            (quiet, &[(0, 0.0), (1, 0.2), (2, 0.5), (1, 0.7)], 3),
            // The same there and back in time.
            (quiet, &[(0, 0.0), (1, 0.2), (2, 0.5), (1, 0.8)], 4),
        ] {
            let hit = |&(site, turn): &(usize, f64)| Hit::new(site, Barrier::Lower, turn * model.period(), 1.0);
            let hits: Vec<Hit> = hits.iter().map(hit).collect();
            let orbit = Orbit::from_impulses(&model, 1, 0.3, &hits).unwrap();
            let (stop, lattice) = (Stop::default(), orbit.lattice().unwrap());
            let family = lattice.models(&[Parameter::Gamma2], &stop);
            let start = ContactOrbit::of_orbit(&orbit, &stop).unwrap();
            let mut branch =
                Branch::among_symmetric(&start, &symmetries(lattice), family, (0.05, 0.05), &stop).unwrap();
            let origin = branch.system().origin().unwrap();
            let there = branch.system().evaluate(&origin).unwrap();
            assert_eq!((branch.system().size(), there.matrix.size()), (left, left), "{hits:?}");
            for (own, hit) in there.orbit.impacts().iter().zip(&hits) {
                let apart = (own.time - hit.time).abs() + (own.impulse - hit.impulse).abs();
                assert!(apart < 1e-14 && there.orbit.model().site(own.site) == hit.site, "{hits:?} {own:?}");
            }
        }
    }
}
