//! Looks at a chain's orbits.

use vibrochain_breather::{Admissibility, Finder, Orbit};
use vibrochain_lattice::Stop;

use super::half_sums::half_sums;
use super::orbit::EventOrbit;
use super::watcher::{Spectrum, Watcher};
use crate::analyser::Analyser;
use crate::locate::LocateError;
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
        Ok((half_sums(&self.analyser.dense.values, orbit.is_reversible()), None))
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
