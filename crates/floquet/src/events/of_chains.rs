//! Looks at a chain's orbits.

use vibrochain_breather::{Admissibility, Finder, Orbit};
use vibrochain_lattice::{BlochKernel, SparedModes, Stop};

use super::half_sums::{drop_nearest, half_sums};
use super::orbit::EventOrbit;
use super::watcher::{Spectrum, Watcher};
use crate::analyser::Analyser;
use crate::error::FloquetError;
use crate::locate::LocateError;
use crate::reference::dense::{is_reduced, uncoupled};
use crate::verdict::{Question, Tolerance, Verdict};

/// Impulses of a chain are about to vanish against those of a tenth of the force's own speed.
const OWN_SPEED: f64 = 0.1;

/// Looks at a chain's orbits.
pub(crate) struct OfChains {
    pub(crate) finder: Finder,
    pub(crate) analyser: Analyser,
    spectra: usize,
}

impl OfChains {
    /// Of so many masses, until `stop` is raised.
    pub(crate) fn new(sites: usize, stop: &Stop) -> Self {
        Self { finder: Finder::new(sites).until(stop), analyser: Analyser::default(), spectra: 0 }
    }
}

impl Watcher for OfChains {
    type Orbit = Orbit;
    const FAINT: f64 = 1e-6;

    fn admissibility(&mut self, orbit: &Orbit) -> Result<Admissibility, LocateError> {
        Ok(self.finder.admissibility(orbit)?)
    }

    /// Without losses from a matrix, which tells two that meet from one better than a determinant.
    fn spectrum(&mut self, orbit: &Orbit, tolerance: Tolerance) -> Result<Spectrum, LocateError> {
        self.finder.stop().heard()?;
        self.spectra += 1;
        if !orbit.is_lossless() {
            let question = Question { orbit, tolerance, thorough: true };
            let (verdict, values) = self.analyser.decide(question, &mut self.finder)?;
            return Ok((values, Some(verdict)));
        }
        self.analyser.dense.solve(orbit, &mut self.finder)?;
        let mut sums = half_sums(&self.analyser.dense.values, orbit.is_reversible());
        // The whole lattice's matrix has modes, too, that no impact reaches.
        if !is_reduced(orbit) && !uncoupled(orbit) {
            let prepared = self.finder.prepared(orbit).map_err(FloquetError::from)?;
            let (_, spared) = BlochKernel::of_lattice(prepared.response(), &orbit.hit_sites());
            for SparedModes { frequency, count, .. } in spared {
                (0..count).for_each(|_| drop_nearest(&mut sums, (frequency * orbit.period()).cos()));
            }
        }
        Ok((sums, None))
    }

    fn verdict(&mut self, orbit: &Orbit, tolerance: Tolerance) -> Result<Verdict, LocateError> {
        Ok(self.analyser.verdict(orbit, &mut self.finder, tolerance)?)
    }

    fn strength(&self, orbit: &Orbit) -> f64 {
        orbit.strength().max(OWN_SPEED * orbit.model().omega())
    }

    fn spectra(&self) -> usize {
        self.spectra
    }
}
