//! Multipliers as eigenvalues of the smallest dense matrix that an orbit's structure leaves: the reference, and what answers
//! where the secular form does not.
//!
//! | orbit | matrix | dimension |
//! |---|---|---|
//! | conservative, mirror image of itself in time | `half_sum` | M − 1 |
//! | the same, of one site on a ring | its part even about the site | ⌊M/2⌋ |
//! | impacts at one site | the modes that feel them | on a ring 2(⌊M/2⌋+1), less the trivial pair |
//! | impacts at several sites | whole lattice | 2M, less the trivial pair |
//!
//! The trivial pair μ = 1 of a conservative orbit (the perturbation along the orbit and its canonical partner) is left out: the known left
//! eigenvector of one is reflected to an axis before eigenvalues are computed, and what is then next to 1 is the other. (In ν there is
//! none.) Rounding would split the two by 1e-7 and more, and weakly coupled breathers have others next to them.

use nalgebra::{Complex, DMatrix};
use vibrochain_breather::{Finder, Orbit};
use vibrochain_lattice::Spectrum;

use crate::error::FloquetError;
use crate::map_paths::Modes;
use crate::reference::eigen::eigenvalues_until;
use crate::reference::half_sum::HalfSum;
use crate::reference::mirrors::Mirrors;
use crate::reference::monodromy::{EvenCoordinates, check_dimension, full_monodromy_until};
use crate::reference::reflector::deflated;
use crate::zeros::Nu;

/// Reusable work space for dense matrices.
#[derive(Debug, Clone, Default)]
pub(crate) struct Dense {
    /// Of the last orbit's chain.
    spectrum: Option<Spectrum>,
    modes: Modes,
    coordinates: EvenCoordinates,
    /// Of which `values` are the eigenvalues.
    pub(crate) matrix: DMatrix<f64>,
    pub(crate) values: Vec<Complex<f64>>,
}

impl Dense {
    /// The multipliers of the space that feels impacts as the last verdict or [`Dense::solve`] found them, without the trivial
    /// pair.
    pub(crate) fn multipliers(&self, orbit: &Orbit) -> Vec<Complex<f64>> {
        if orbit.is_reversible() {
            self.values.iter().flat_map(|&nu| Nu::of(nu).multipliers()).collect()
        } else {
            self.values.clone()
        }
    }

    /// Fills `values` with the non-trivial multipliers of the space that feels impacts (for a reversible orbit with
    /// their ν) and returns the norm of the matrix.
    pub(crate) fn solve(&mut self, orbit: &Orbit, finder: &mut Finder) -> Result<f64, FloquetError> {
        self.values.clear();
        let chain = orbit.model().chain();
        let alone = uncoupled(orbit);
        if alone && orbit.model().is_conservative() {
            // One mass, whose only pair is the trivial one.
            return Ok(0.0);
        }
        if orbit.is_reversible() {
            let centred = orbit.centre().is_some();
            check_dimension(if centred { chain.even_modes() } else { chain.sites() })?;
            // Modes odd about the one site of a ring feel nothing, and coincide nearly with even ones.
            let mirrors = if centred { Mirrors::of(orbit) } else { Mirrors::default() };
            let half_sum = HalfSum::new(orbit, &mut self.spectrum)?;
            let basis = mirrors.basis(chain.sites(), 0);
            let flow = HalfSum::flow(orbit, &basis, finder)?;
            self.matrix = deflated(half_sum.on(&basis).matrix, &flow);
        } else if is_reduced(orbit) || alone {
            check_dimension(2 * chain.even_modes())?;
            self.modes.set_felt(finder.prepared(orbit)?);
            let felt = || self.modes.list().iter().map(|mode| (mode.frequency, mode.weight));
            match felt().next() {
                Some((frequency, _)) if alone => {
                    self.coordinates.set([(frequency, 1.0)].into_iter(), orbit.frequency())
                }
                _ => self.coordinates.set(felt(), orbit.frequency()),
            }
            self.matrix = self.coordinates.monodromy(orbit)?;
        } else {
            self.matrix = full_monodromy_until(orbit, finder.stop())?;
        }
        let norm = self.matrix.norm();
        if !norm.is_finite() {
            return Err(FloquetError::NotConverged { dimension: self.matrix.nrows() });
        }
        let mut trivial = if orbit.model().is_conservative() && !orbit.is_reversible() { 2 } else { 0 };
        if trivial > 0 && orbit.impact_site().is_none() {
            let left = canonical_flow(orbit, finder)?;
            self.matrix = deflated(std::mem::take(&mut self.matrix), &left);
            trivial = 1;
        }
        eigenvalues_until(&self.matrix, &mut self.values, finder.stop())?;
        for _ in 0..trivial {
            let from_one = |i: &usize| (self.values[*i] - 1.0).norm_sqr();
            let nearest = (0..self.values.len()).min_by(|i, j| from_one(i).total_cmp(&from_one(j)));
            nearest.map(|i| self.values.remove(i));
        }
        Ok(norm)
    }
}

/// ωᵀ(f, ·) of the flow f just before the first impact, a left eigenvector of M, which keeps the canonical form ω.
fn canonical_flow(orbit: &Orbit, finder: &mut Finder) -> Result<Vec<f64>, FloquetError> {
    let motion = finder.motion(orbit)?;
    motion.seek(0, 0.0);
    let sites = orbit.model().chain().sites();
    let accelerations = (0..sites).map(|n| -motion.site(n).acceleration);
    let mut left: Vec<f64> = accelerations.chain((0..sites).map(|n| motion.site(n).velocity)).collect();
    // Several impacts may share the first instant; before it each site is slower by its impulse.
    let first = orbit.impacts().first().map_or(0.0, |impact| impact.time);
    for impact in orbit.impacts().iter().filter(|impact| impact.time == first) {
        left[sites + impact.site] -= impact.impulse;
    }
    Ok(left)
}

/// Matrices are those of the modes that feel the impacts.
pub(crate) fn is_reduced(orbit: &Orbit) -> bool {
    orbit.centre().is_some() || orbit.impact_site().is_some() && !orbit.model().is_conservative()
}

/// The masses that are not hit swing alone.
pub(crate) fn uncoupled(orbit: &Orbit) -> bool {
    orbit.impact_site().is_some() && orbit.model().chain().is_uncoupled()
}
