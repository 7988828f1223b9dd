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
//! The trivial pair μ = 1 of a conservative orbit (the perturbation along the orbit and its canonical partner) is
//! taken out before the eigenvalues are computed, by reflecting the known right and left eigenvectors to the axes.

use nalgebra::{Complex, DMatrix};
use vibrochain_breather::{Finder, LatticeOrbit, Orbit};
use vibrochain_lattice::Spectrum;

use crate::error::FloquetError;
use crate::map_paths::Modes;
use crate::reference::eigen::eigenvalues_until;
use crate::reference::half_sum::{Basis, HalfSum};
use crate::reference::monodromy::{EvenCoordinates, check_dimension, flow_before_first_impact, full_monodromy_until};
use crate::reference::reflector::Reflector;
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
    flow: Vec<f64>,
    left: Vec<f64>,
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
    pub(crate) fn solve(&mut self, orbit: LatticeOrbit<'_>, finder: &mut Finder) -> Result<f64, FloquetError> {
        self.values.clear();
        let chain = orbit.model().chain();
        let alone = uncoupled(orbit);
        if alone && orbit.model().is_conservative() {
            // One mass, whose only pair is the trivial one.
            return Ok(0.0);
        }
        if orbit.is_reversible() {
            let centre = orbit.centre();
            check_dimension(if centre.is_some() { chain.even_modes() } else { chain.sites() })?;
            let half_sum = HalfSum::new(orbit, &mut self.spectrum)?;
            // Modes odd about the one site of a ring feel nothing, and coincide nearly with even ones.
            let even = |site: usize| Basis::even_about(site, chain.sites());
            let basis = centre.map_or_else(|| Basis::of_masses(chain.sites()), even);
            HalfSum::set_flow(&orbit, &basis, finder, &mut self.left)?;
            self.matrix = Reflector::of(&self.left).deflated(half_sum.on(&basis));
            eigenvalues_until(&self.matrix, &mut self.values, finder.stop())?;
            return Ok(self.matrix.norm());
        }
        if is_reduced(orbit) || alone {
            check_dimension(2 * chain.even_modes())?;
            self.modes.set_felt(finder.prepared(orbit.orbit())?);
            let felt = || self.modes.list().iter().map(|mode| (mode.frequency, mode.weight));
            match felt().next() {
                Some((frequency, _)) if alone => {
                    self.coordinates.set([(frequency, 1.0)].into_iter(), orbit.frequency())
                }
                _ => self.coordinates.set(felt(), orbit.frequency()),
            }
            self.matrix = self.coordinates.monodromy(&orbit)?;
        } else {
            self.matrix = full_monodromy_until(&orbit, finder.stop())?;
        }
        let norm = self.matrix.norm();
        if !norm.is_finite() {
            return Err(FloquetError::NotConverged { dimension: self.matrix.nrows() });
        }
        if orbit.model().is_conservative() {
            self.deflate(orbit, finder)?;
        }
        eigenvalues_until(&self.matrix, &mut self.values, finder.stop())?;
        Ok(norm)
    }

    /// Removes the trivial pair: M f = f with the flow f, and ωᵀ(f, ·)M = ωᵀ(f, ·) because M keeps the canonical form ω.
    fn deflate(&mut self, orbit: LatticeOrbit<'_>, finder: &mut Finder) -> Result<(), FloquetError> {
        let half = self.matrix.nrows() / 2;
        self.left.clear();
        if orbit.centre().is_some() {
            flow_before_first_impact(&orbit, finder, &self.coordinates, &mut self.flow)?;
            // ω(f, z) = Σ (f_X z_Y − f_Y z_X)/Ω̃
            let scales = &self.coordinates.scales;
            self.left.extend((0..half).map(|k| -self.flow[k + half] / scales[k]));
            self.left.extend((0..half).map(|k| self.flow[k] / scales[k]));
        } else {
            let motion = finder.motion(&orbit)?;
            motion.seek(0, 0.0);
            self.flow.clear();
            self.flow.extend((0..half).map(|n| motion.site(n).velocity));
            self.flow.extend((0..half).map(|n| motion.site(n).acceleration));
            // Several impacts may share the first instant; before it each site is slower by its impulse.
            let first = orbit.impacts().first().map_or(0.0, |impact| impact.time);
            for impact in orbit.impacts().iter().filter(|impact| impact.time == first) {
                self.flow[impact.site] -= impact.impulse;
            }
            self.left.extend((0..half).map(|n| -self.flow[n + half]));
            self.left.extend_from_slice(&self.flow[..half]);
        }
        let first = Reflector::of(&self.flow);
        first.apply(&mut self.left);
        let rest = first.deflated(std::mem::take(&mut self.matrix));
        self.matrix = Reflector::of(self.left.get(1..).unwrap_or_default()).deflated(rest);
        Ok(())
    }
}

/// Matrices are those of the modes that feel the impacts.
pub(crate) fn is_reduced(orbit: LatticeOrbit<'_>) -> bool {
    orbit.centre().is_some() || orbit.impact_site().is_some() && !orbit.model().is_conservative()
}

/// The masses that are not hit swing alone.
pub(crate) fn uncoupled(orbit: LatticeOrbit<'_>) -> bool {
    orbit.impact_site().is_some() && orbit.model().chain().is_uncoupled()
}
