//! The impulses of a word of one or two instants without force, from the conditions of position alone: a linear system.
//!
//! Impulses P and static displacement s of impacts at 0 and φ = T/2 + δ follow from Σ_j P_j K̂_ij + s = a ± 1 and Σ P = g s.

use smallvec::SmallVec;
use vibrochain_lattice::{ImpulseResponse, Model};

use crate::equations::System;
use crate::equations::linear::{Matrix, USUAL, Vector, dot};
use crate::error::NoBreather;
use crate::orbit::{Draft, Family, Hit};
use crate::word::Word;

/// Beyond this reciprocal condition rounding of the kernels leaves no digit of the impulses.
const SINGULAR: f64 = 16.0 * f64::EPSILON;

/// The conditions of position of a word.
pub(crate) struct Positions<'a> {
    model: &'a Model,
    response: &'a ImpulseResponse,
    /// The impacts, and whether they hit at the second instant.
    pub(crate) hits: SmallVec<[(Hit, bool); USUAL]>,
    /// The masses that are hit, rising, and the place of each impact's among them.
    sites: SmallVec<[usize; USUAL]>,
    places: SmallVec<[usize; USUAL]>,
    /// K̂ of each pair of masses at one instant, and half a period apart.
    pub(crate) still: Vec<[f64; 2]>,
    /// a ± 1 of each impact, and the 0 of the net impulse.
    pub(crate) stops: Vector,
}

impl<'a> Positions<'a> {
    /// Those of a word in one row.
    ///
    /// # Errors
    /// [`NoBreather::NetImpulse`], which needs no search.
    pub(crate) fn new(model: &'a Model, response: &'a ImpulseResponse, word: &Word) -> Result<Self, NoBreather> {
        let hits: SmallVec<[(Hit, bool); USUAL]> = (word.instants().iter().zip([false, true]))
            .flat_map(|(letters, late)| letters.iter().map(move |letter| (letter, late)))
            .map(|(letter, late)| (Hit::new(letter.site, letter.barrier, 0.0, 0.0), late))
            .collect();
        if response.static_stiffness() == 0.0 && word.is_one_sided() {
            return Err(NoBreather::NetImpulse);
        }
        let mut sites: SmallVec<[usize; USUAL]> = hits.iter().map(|(hit, _)| hit.site).collect();
        sites.sort_unstable();
        sites.dedup();
        let places = hits.iter().map(|(hit, _)| sites.partition_point(|&site| site < hit.site)).collect();
        let mut stops: Vector = hits.iter().map(|(hit, _)| model.barrier(hit.barrier)).collect();
        stops.push(0.0);
        let mut positions = Self { model, response, hits, sites, places, still: Vec::new(), stops };
        positions.still = positions.each_pair(|one, other| response.dynamics_between(one, other));
        Ok(positions)
    }

    pub(crate) fn response(&self) -> &'a ImpulseResponse {
        self.response
    }

    /// Something of each pair of masses, kernels being symmetric, in the order of [`Positions::pair`].
    pub(crate) fn each_pair<T>(&self, mut of: impl FnMut(usize, usize) -> T) -> Vec<T> {
        let sites = &self.sites;
        (0..sites.len())
            .flat_map(|high| (0..=high).map(move |low| (high, low)))
            .map(|(high, low)| of(sites[high], sites[low]))
            .collect()
    }

    /// Where the pair of masses of two impacts stands.
    pub(crate) fn pair(&self, i: usize, j: usize) -> usize {
        let (low, high) = (self.places[i].min(self.places[j]), self.places[i].max(self.places[j]));
        high * (high + 1) / 2 + low
    }

    /// The impacts hit at different instants.
    pub(crate) fn is_across(&self, i: usize, j: usize) -> bool {
        self.hits[i].1 != self.hits[j].1
    }

    /// Both instants hit the same masses.
    pub(crate) fn same_masses(&self) -> bool {
        let count = |late: bool| self.hits.iter().filter(|hit| hit.1 == late).count();
        count(false) == self.sites.len() && count(true) == self.sites.len()
    }

    /// Some mass is hit at both.
    pub(crate) fn share_masses(&self) -> bool {
        self.hits.len() > self.sites.len()
    }

    /// The linear system; `across` holds K̂ of each pair of masses at φ.
    fn system(&self, across: impl Fn(usize) -> f64) -> Option<System> {
        let (n, g) = (self.hits.len(), self.response.static_stiffness());
        let matrix = Matrix::from_fn(n + 1, |i, j| match (i < n, j < n) {
            (true, true) if self.is_across(i, j) => across(self.pair(i, j)),
            (true, true) => self.still[self.pair(i, j)][0],
            (true, false) | (false, true) => 1.0,
            (false, false) => -g,
        });
        // Impulses are like those of a mass that crosses the gap in half a period.
        let mut units: Vector = (0..n).map(|_| self.model.omega()).collect();
        units.push(1.0);
        let system = System::new(matrix, &units);
        (system.reciprocal_condition > SINGULAR).then_some(system)
    }

    /// Impulses and static displacement.
    fn solve(&self, system: &System) -> Vector {
        let mut solution = system.solve(&self.stops);
        // An inverse leaves its condition times the rounding of the terms; once more, and it is the rounding alone.
        let mut rows = self.stops.clone();
        for (i, row) in rows.iter_mut().enumerate() {
            *row -= dot(system.matrix.row(i), &solution);
        }
        solution.iter_mut().zip(system.solve(&rows)).for_each(|(x, change)| *x += change);
        solution
    }

    /// The orbit with these times, if Newton's law holds.
    ///
    /// # Errors
    /// [`NoBreather::Singular`].
    pub(crate) fn draft(&self, delta: f64) -> Result<Draft, NoBreather> {
        let system = if delta == 0.0 {
            self.system(|pair| self.still[pair][1])
        } else {
            let values = self.each_pair(|one, other| self.response.jet_between(one, other, delta).value);
            self.system(|pair| values[pair])
        };
        let solution = self.solve(&system.ok_or(NoBreather::Singular)?);
        if !solution.iter().all(|x| x.is_finite()) {
            return Err(NoBreather::Singular);
        }
        let second = 0.5 * self.response.period() + delta;
        let hit = |((hit, late), &impulse): (&(Hit, bool), &f64)| Hit {
            impulse,
            time: if *late { second } else { 0.0 },
            ..*hit
        };
        let impacts = self.hits.iter().zip(&solution).map(hit).collect();
        Ok(Draft::new(self.response, (Family::Word, 1), 0.0, impacts, solution[self.hits.len()]))
    }
}
